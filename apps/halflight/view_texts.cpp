#include "view_texts.h"

#include "halflight/scene/turning_lights.h"

#include <spdlog/fmt/fmt.h>

#include <algorithm>

namespace halflight::cli {
namespace {

/// For a shell: everything within '…', which only the quote itself ends.
std::string quoted(const std::string& text)
{
    std::string result = "'";
    for (const char c : text) result += c == '\'' ? std::string("'\\''") : std::string(1, c);
    return result + "'";
}

/// A TOML basic string.
std::string tomlString(const std::string& text)
{
    std::string result = "\"";
    for (const char c : text) {
        if (c == '"' || c == '\\') result += '\\';
        if (static_cast<unsigned char>(c) < 0x20)
            result += fmt::format("\\u{:04x}", int(c));
        else
            result += c;
    }
    return result + "\"";
}

/// The value of `halflight render --light` for what was changed; empty when nothing was.
std::string lightOverride(const Light& light, const Light& atLoad)
{
    std::string changes;
    const auto add = [&](const std::string& change) { changes += (changes.empty() ? "" : ",") + change; };
    if (light.intensity != atLoad.intensity) add(fmt::format("intensity={:.9g}", light.intensity));
    if (light.color != atLoad.color)
        add(fmt::format("color={:.9g},{:.9g},{:.9g}", light.color.r, light.color.g, light.color.b));
    if (light.shadowStrength != atLoad.shadowStrength) add(fmt::format("strength={:.9g}", light.shadowStrength));
    if (const vec3 d = light.direction(); turns(light) && d != atLoad.direction())
        add(fmt::format("direction={:.9g},{:.9g},{:.9g}", d.x, d.y, d.z));
    return changes;
}

/// Rules and options go by names: those of several lights or objects would change all of them.
template<typename T> bool isUnique(const T& named, const std::vector<T>& all)
{
    return std::count_if(all.begin(), all.end(), [&](const T& other) { return other.name == named.name; }) == 1;
}

/// The file's camera that this is; nothing once it has moved.
const Camera* fileCamera(const Camera& camera, const Scene& scene)
{
    const auto found = std::find(scene.cameras.begin(), scene.cameras.end(), camera);
    const bool isNamed = found != scene.cameras.end() && !found->name.empty() && isUnique(*found, scene.cameras);
    return isNamed ? &*found : nullptr;
}

/// Degrees that give the same float in radians: six digits where those do, as 45 has it.
std::string degreesOf(float radians)
{
    const std::string text = fmt::format("{:.6g}", glm::degrees(radians));
    return glm::radians(std::stof(text)) == radians ? text : fmt::format("{:.9g}", glm::degrees(double(radians)));
}

std::string cameraOptions(const Camera& camera, const vec3& ahead, const Scene& scene)
{
    if (const Camera* named = fileCamera(camera, scene)) return " --camera " + quoted(named->name);
    const dvec3 eye = scene.originMeters + dvec3(camera.worldFromCamera[3]);
    const dvec3 target = scene.originMeters + dvec3(ahead);
    return fmt::format(" --eye {:.12g},{:.12g},{:.12g} --target {:.12g},{:.12g},{:.12g} --fov {}", eye.x, eye.y, eye.z,
                       target.x, target.y, target.z, degreesOf(camera.verticalFovRadians));
}

/// The ends of all cascades but the last.
std::string splitsOf(const ShadowSettings& shadows)
{
    std::string text;
    for (int i = 0; i + 1 < shadows.cascades; ++i)
        text += fmt::format("{}{:.6g}", i > 0 ? "," : "", shadows.cascadeSplits[std::size_t(i)]);
    return text;
}

/// Lines of a settings file for what was changed of a light.
std::string keysOf(const Light& light, const Light& before)
{
    std::string keys;
    if (light.mode != before.mode) keys += fmt::format("mode = \"{}\"\n", nameOf(light.mode));
    if (light.color != before.color)
        keys += fmt::format("color = [{:.9g}, {:.9g}, {:.9g}]\n", light.color.r, light.color.g, light.color.b);
    if (light.intensity != before.intensity) keys += fmt::format("intensity = {:.9g}\n", light.intensity);
    if (light.shadowStrength != before.shadowStrength)
        keys += fmt::format("shadow_strength = {:.9g}\n", light.shadowStrength);
    if (light.radiusMeters != before.radiusMeters) keys += fmt::format("radius = {:.9g}\n", light.radiusMeters);
    if (light.angularRadiusRadians != before.angularRadiusRadians)
        keys += fmt::format("angular_diameter = {:.9g}\n", glm::degrees(2.0f * light.angularRadiusRadians));
    if (light.indirectMultiplier != before.indirectMultiplier)
        keys += fmt::format("indirect_multiplier = {:.9g}\n", light.indirectMultiplier);
    if (light.sizeMeters != before.sizeMeters && light.type == LightType::Disk)
        keys += fmt::format("size = {:.9g}\n", light.sizeMeters.x);
    else if (light.sizeMeters != before.sizeMeters)
        keys += fmt::format("size = [{:.9g}, {:.9g}]\n", light.sizeMeters.x, light.sizeMeters.y);
    if (light.castShadows != before.castShadows) keys += fmt::format("cast_shadows = {}\n", light.castShadows);
    return keys;
}

std::string keysOf(const Object& object, const Object& before)
{
    std::string keys;
    if (object.isStatic != before.isStatic) keys += fmt::format("static = {}\n", object.isStatic);
    if (object.castShadows != before.castShadows) keys += fmt::format("cast_shadows = {}\n", object.castShadows);
    if (object.receiveShadows != before.receiveShadows)
        keys += fmt::format("receive_shadows = {}\n", object.receiveShadows);
    return keys;
}

/// Adds to a list for people.
void add(std::string& list, const std::string& what)
{
    list += (list.empty() ? "" : ", ") + what;
}

std::string lineOf(const ViewedPicture& picture)
{
    const RenderSettings& settings = picture.render;
    const Scene& scene = picture.scene;
    const Scene& atLoad = picture.atLoad;
    std::string line = fmt::format(
        "halflight render {} -o picture.png --size {}x{}{} --mode {} --path {} --samples {} --exposure {:.9g}",
        quoted(picture.file), settings.size.x, settings.size.y, cameraOptions(picture.camera, picture.ahead, scene),
        nameOf(settings.mode), nameOf(settings.path), settings.supersampling * settings.supersampling,
        picture.exposureEv);
    const auto add = [&](const std::string& option) { line += " " + option; };
    if (!picture.settingsFile.empty()) add("--settings " + quoted(picture.settingsFile));
    if (scene.emissionScale != 1.0f) add("--emission-unit blender");
    if (settings.view != DebugView::Lit) add(fmt::format("--view {}", nameOf(settings.view)));
    if (picture.toneMapping != ToneMapping::Neutral) add(fmt::format("--tone-mapping {}", nameOf(picture.toneMapping)));
    if (picture.shadowDistanceGiven) add(fmt::format("--shadow-distance {:.6g}", settings.shadows.distanceMeters));
    const ShadowSettings defaults;
    const ShadowSettings& shadows = settings.shadows;
    if (shadows.fadeRangeMeters != defaults.fadeRangeMeters)
        add(fmt::format("--shadow-fade-range {:.6g}", shadows.fadeRangeMeters));
    if (shadows.cascades != defaults.cascades) add(fmt::format("--cascades {}", shadows.cascades));
    if (shadows.cascadeSplits != defaults.cascadeSplits) add("--cascade-splits " + splitsOf(shadows));
    if (shadows.depthBias != defaults.depthBias) add(fmt::format("--shadow-depth-bias {:.6g}", shadows.depthBias));
    if (shadows.slopeBias != defaults.slopeBias) add(fmt::format("--shadow-slope-bias {:.6g}", shadows.slopeBias));
    if (shadows.normalBiasTexels != defaults.normalBiasTexels)
        add(fmt::format("--shadow-normal-bias {:.6g}", shadows.normalBiasTexels));
    if (const auto& color = settings.subtractiveShadowColor)
        add(fmt::format("--shadow-color {:.9g},{:.9g},{:.9g}", color->r, color->g, color->b));
    if (shadows.filter != defaults.filter) add(fmt::format("--shadow-filter {}", nameOf(shadows.filter)));
    if (!shadows.penumbrae) add("--penumbrae off");
    if (!settings.proxyVolumes) add("--proxy-volumes off");
    if (!settings.directionalLightmaps) add("--directional off");
    if (!settings.reflectionProbes) add("--reflection-probes off");
    if (!settings.specular) add("--specular off");
    for (const GroupWeight& group : picture.groups)
        add("--group " +
            quoted(fmt::format("{}={:.9g},{:.9g},{:.9g}", group.name, group.weight.r, group.weight.g, group.weight.b)));
    for (std::size_t i = 0; i < scene.lights.size() && i < atLoad.lights.size(); ++i) {
        const std::string changes = lightOverride(scene.lights[i], atLoad.lights[i]);
        if (!changes.empty() && isUnique(scene.lights[i], scene.lights))
            add("--light " + quoted(scene.lights[i].name + ":" + changes));
    }
    return line;
}

std::string rulesOf(const Scene& scene, const Scene& atLoad)
{
    std::string text;
    const auto addRules = [&](const char* table, const auto& now, const auto& before) {
        for (std::size_t i = 0; i < now.size() && i < before.size(); ++i) {
            const std::string keys = keysOf(now[i], before[i]);
            if (keys.empty() || !isUnique(now[i], now)) continue;
            text += fmt::format("[[{}]]\npattern = {}\n{}\n", table, tomlString(now[i].name), keys);
        }
    };
    addRules("light", scene.lights, atLoad.lights);
    addRules("node", scene.objects, atLoad.objects);
    return text;
}

std::string leftOutOfSettings(const Scene& scene, const Scene& atLoad)
{
    std::string text;
    for (std::size_t i = 0; i < scene.objects.size() && i < atLoad.objects.size(); ++i)
        if (scene.objects[i].worldFromObject != atLoad.objects[i].worldFromObject)
            add(text, "the place of '" + scene.objects[i].name + "'");
    const auto addNamesakes = [&](const auto& now, const auto& before) {
        for (std::size_t i = 0; i < now.size() && i < before.size(); ++i)
            if (!keysOf(now[i], before[i]).empty() && !isUnique(now[i], now))
                add(text, "changes of one of several '" + now[i].name + "'");
    };
    addNamesakes(scene.lights, atLoad.lights);
    addNamesakes(scene.objects, atLoad.objects);
    return text;
}

std::string leftOutOfLine(const ViewedPicture& picture)
{
    std::string text;
    const Scene& scene = picture.scene;
    const Scene& atLoad = picture.atLoad;
    const Camera& camera = picture.camera;
    if (camera.orthographic && !fileCamera(camera, scene)) add(text, "an orthographic camera that was moved");
    const ShadowSettings defaults;
    const ShadowSettings& shadows = picture.render.shadows;
    if (shadows.cascadeBlend != defaults.cascadeBlend) add(text, "how cascades blend");
    if (shadows.directionalMapSize != defaults.directionalMapSize) add(text, "the size of cascades");
    if (shadows.atlasSize != defaults.atlasSize) add(text, "the size of the shadow atlas");
    if (shadows.pointShadows != defaults.pointShadows) add(text, "shadows of point lights off");
    for (std::size_t i = 0; i < scene.lights.size() && i < atLoad.lights.size(); ++i) {
        Light said = atLoad.lights[i];
        said.intensity = scene.lights[i].intensity;
        said.color = scene.lights[i].color;
        said.shadowStrength = scene.lights[i].shadowStrength;
        if (!keysOf(scene.lights[i], said).empty()) add(text, "more changes of the light '" + said.name + "'");
    }
    for (std::size_t i = 0; i < scene.objects.size() && i < atLoad.objects.size(); ++i)
        if (!keysOf(scene.objects[i], atLoad.objects[i]).empty())
            add(text, "switches of '" + scene.objects[i].name + "'");
    if (const std::string places = leftOutOfSettings(scene, atLoad); !places.empty()) add(text, places);
    return text;
}

} // namespace

ViewText commandLine(const ViewedPicture& picture)
{
    return {lineOf(picture), leftOutOfLine(picture)};
}

ViewText settingsFile(const Scene& scene, const Scene& atLoad)
{
    std::string leftOut = leftOutOfSettings(scene, atLoad);
    for (std::size_t i = 0; i < scene.lights.size() && i < atLoad.lights.size(); ++i)
        if (scene.lights[i].direction() != atLoad.lights[i].direction())
            add(leftOut, "the direction of the light '" + scene.lights[i].name + "'");
    for (std::size_t i = 0; i < scene.materials.size() && i < atLoad.materials.size(); ++i)
        if (scene.materials[i].emissiveNits != atLoad.materials[i].emissiveNits)
            add(leftOut, "the emission of '" + scene.materials[i].name + "'");
    const Sky& sky = scene.sky;
    const Sky& before = atLoad.sky;
    if (sky.zenith != before.zenith || sky.horizon != before.horizon || sky.ground != before.ground)
        add(leftOut, "the sky's weight");
    return {rulesOf(scene, atLoad), leftOut};
}

} // namespace halflight::cli
