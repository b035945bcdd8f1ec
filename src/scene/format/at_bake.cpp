#include "scene/format/at_bake.h"

#include "halflight/base/finite.h"
#include "halflight/base/mathematics.h"
#include "halflight/base/parallel.h"
#include "scene/document/patcher.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace halflight {

namespace {

constexpr int kSmallTexels = 256; // side of the copies that textures are sampled from
constexpr int kSamplesOfPart = 2048;
constexpr int kFewestSamples = 4; // of a triangle, three points each
constexpr int kMostSamples = 128;

// Tolerances. Tools store positions with 14 bits of a mesh's or the scene's extent and simplify within 1e-4 of it.
constexpr float kPositionMeters = 1.0e-3f;
constexpr float kPositionShare = 5.0e-4f; // of the surface's extent
constexpr float kAreaShare = 0.02f;
constexpr float kColor = 0.03f;
constexpr float kEmissionShare = 0.03f;
constexpr float kSwitch = 0.02f;

// Absent members of a record: casts and receives shadows, is one-sided and lit.
constexpr std::array<float, 4> kUsualSwitches = {1.0f, 1.0f, 0.0f, 0.0f};

// JSON holds no more digits than the tolerances need.
double rounded(float value, int digits)
{
    std::array<char, 32> text{};
    std::snprintf(text.data(), text.size(), "%.*g", digits, double(value));
    return std::strtod(text.data(), nullptr);
}

Json rounded(vec3 v, int digits)
{
    return Json::array({rounded(v.x, digits), rounded(v.y, digits), rounded(v.z, digits)});
}

template<typename Values> bool readNumbers(const Json& json, Values& out, std::size_t count)
{
    if (!json.is_array() || json.size() != count) return false;
    for (std::size_t i = 0; i < count; ++i) {
        if (!json[i].is_number() || !std::isfinite(json[i].get<float>())) return false;
        out[typename Values::size_type(i)] = json[i].get<float>();
    }
    return true;
}

bool readTriple(const Json& json, vec3& out)
{
    std::array<float, 3> values{};
    if (!readNumbers(json, values, 3)) return false;
    out = {values[0], values[1], values[2]};
    return true;
}

bool readFloat(const Json& json, float& out)
{
    if (!json.is_number() || !std::isfinite(json.get<float>())) return false;
    out = json.get<float>();
    return true;
}

// Linear values as textures hold them, for means: tools resize pictures without decoding them. Display gamma stands for
// sRGB.
vec3 encoded(vec3 linear)
{
    return math::pow(glm::max(linear, vec3(0.0f)), vec3(1.0f / 2.2f));
}

// A texture's means over blocks of texels. Colours count by their alpha: codecs change what nobody sees.
Image<vec4> smallCopy(const ImageRgba8& pixels)
{
    const ivec2 step = (pixels.size() + kSmallTexels - 1) / kSmallTexels;
    const ivec2 size = (pixels.size() + step - 1) / step;
    Image<vec4> small(size.x, size.y, vec4(0.0f));
    for (int y = 0; y < pixels.height(); ++y) {
        for (int x = 0; x < pixels.width(); ++x) {
            const vec4 texel = vec4(pixels(x, y)) / 255.0f;
            small(x / step.x, y / step.y) += vec4(vec3(texel) * texel.w, texel.w);
        }
    }
    for (int y = 0; y < size.y; ++y) {
        for (int x = 0; x < size.x; ++x) {
            const ivec2 texels = glm::min(step, pixels.size() - ivec2(x, y) * step);
            vec4& mean = small(x, y);
            if (mean.w > 0.0f) mean = vec4(vec3(mean) / mean.w, mean.w);
            mean.w /= float(texels.x * texels.y);
        }
    }
    return small;
}

int wrapped(float coordinate, int size, Texture::Wrap wrap)
{
    if (!std::isfinite(coordinate)) return 0;
    float place = coordinate;
    if (wrap == Texture::Wrap::Repeat) place -= std::floor(place);
    if (wrap == Texture::Wrap::MirroredRepeat) place = 1.0f - std::abs(place - 2.0f * std::floor(place / 2.0f) - 1.0f);
    return int(glm::clamp(place * float(size), 0.0f, float(size - 1)));
}

// The i-th point of an even sequence in a triangle: barycentric coordinates. The steps are those of the plastic number
// (Roberts 2018, "The Unreasonable Effectiveness of Quasirandom Sequences").
vec3 pointInTriangle(int i)
{
    const double n = double(i) + 0.5;
    vec2 p(float(n * 0.7548776662466927 - std::floor(n * 0.7548776662466927)),
           float(n * 0.5698402909980532 - std::floor(n * 0.5698402909980532)));
    if (p.x + p.y > 1.0f) p = 1.0f - p;
    return {1.0f - p.x - p.y, p.x, p.y};
}

bool differ(float a, float b, float tolerance)
{
    return !(std::abs(a - b) <= tolerance);
}

bool differ(vec3 a, vec3 b, float tolerance)
{
    return differ(a.x, b.x, tolerance) || differ(a.y, b.y, tolerance) || differ(a.z, b.z, tolerance);
}

} // namespace

Json SurfaceAtBake::json() const
{
    Json json = {{"min", rounded(low, 6)},
                 {"max", rounded(high, 6)},
                 {"centroid", rounded(centroid, 6)},
                 {"spread", rounded(spread, 5)},
                 {"area", rounded(area, 5)}};
    if (switches != kUsualSwitches) {
        for (const float share : switches) json["switches"].push_back(rounded(share, 4));
    }
    if (!hasColors) return json;
    json["color"] = rounded(color, 4);
    if (emission != vec3(0.0f)) json["emission"] = rounded(emission, 4);
    if (opacity != 1.0f) json["opacity"] = rounded(opacity, 4);
    if (metallic != 0.0f) json["metallic"] = rounded(metallic, 4);
    return json;
}

std::optional<SurfaceAtBake> SurfaceAtBake::from(const Json& json, const glm::dvec3& shift)
{
    SurfaceAtBake s;
    const bool good = readTriple(member(json, "min"), s.low) && readTriple(member(json, "max"), s.high) &&
                      readTriple(member(json, "centroid"), s.centroid) &&
                      readTriple(member(json, "spread"), s.spread) && readFloat(member(json, "area"), s.area);
    if (!good) return std::nullopt;
    for (vec3* position : {&s.low, &s.high, &s.centroid}) *position = vec3(glm::dvec3(*position) + shift);
    s.switches = kUsualSwitches;
    readNumbers(member(json, "switches"), s.switches, 4);
    s.hasColors = readTriple(member(json, "color"), s.color);
    readTriple(member(json, "emission"), s.emission);
    readFloat(member(json, "opacity"), s.opacity);
    readFloat(member(json, "metallic"), s.metallic);
    return s;
}

bool SurfaceAtBake::differsFrom(const SurfaceAtBake& other) const
{
    const float tolerance =
        kPositionMeters + kPositionShare * std::max(glm::distance(low, high), glm::distance(other.low, other.high));
    if (differ(low, other.low, tolerance) || differ(high, other.high, tolerance) ||
        differ(centroid, other.centroid, tolerance) || differ(spread, other.spread, tolerance) ||
        differ(area, other.area, kAreaShare * std::max(area, other.area)))
        return true;
    for (std::size_t i = 0; i < switches.size(); ++i) {
        if (differ(switches[i], other.switches[i], kSwitch)) return true;
    }
    if (!hasColors || !other.hasColors) return false;
    const vec3 brighter = glm::max(emission, other.emission);
    return differ(color, other.color, kColor) || differ(opacity, other.opacity, kColor) ||
           differ(metallic, other.metallic, kColor) ||
           differ(emission, other.emission, kEmissionShare * std::max({brighter.x, brighter.y, brighter.z}));
}

struct AtBake::Sums {
    double area = 0.0;
    glm::dvec3 first{0.0}; ///< integrals of position and of its squares over the area
    glm::dvec3 second{0.0};
    Bounds bounds;
    glm::dvec4 switches{0.0};
    glm::dvec3 color{0.0};
    glm::dvec3 emission{0.0};
    double opacity = 0.0;
    double metallic = 0.0;
};

AtBake::AtBake(const Scene& scene) : scene_(scene)
{
    for (const Material& material : scene.materials) {
        for (const TextureRef& ref : {material.baseColorTexture, material.emissiveTexture,
                                      material.metallicRoughnessTexture, material.transmissionTexture}) {
            if (ref) small_[ref.texture] = {};
        }
    }
    std::vector<decltype(small_)::value_type*> list;
    for (auto& item : small_) list.push_back(&item);
    parallelFor(list.size(), 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const ImageRgba8& pixels = scene.textures[std::size_t(list[i]->first)].pixels;
            if (!pixels.empty()) list[i]->second = smallCopy(pixels);
        }
    });
    hasColors_ = std::none_of(list.begin(), list.end(), [](const auto* item) { return item->second.empty(); });
}

/// A texture's small copy as a part's material reads it.
struct AtBake::Reader {
    const Image<vec4>* small = nullptr; ///< none: white
    Texture::Wrap wrapU{};
    Texture::Wrap wrapV{};
    const std::vector<vec2>* uvs = nullptr;
    TextureRef ref;
    vec2 turn{1.0f, 0.0f}; ///< cosine and sine of the rotation

    [[nodiscard]] vec4 at(const uint32_t* corners, vec3 weights) const
    {
        if (small == nullptr) return vec4(1.0f);
        vec2 uv(0.0f);
        for (int k = 0; k < 3 && !uvs->empty(); ++k) uv += weights[k] * (*uvs)[corners[k]];
        const vec2 scaled = ref.scale * uv;
        uv = ref.offset + vec2(turn.x * scaled.x + turn.y * scaled.y, turn.x * scaled.y - turn.y * scaled.x);
        return (*small)(wrapped(uv.x, small->width(), wrapU), wrapped(uv.y, small->height(), wrapV));
    }
};

/// What all points of a part have in common.
struct AtBake::Look {
    const Material& material;
    vec4 color{1.0f};
    vec3 emission{0.0f};
    Reader baseColor;
    Reader emissive;
    Reader metallicRoughness;
    Reader transmission;
};

AtBake::Reader AtBake::readerOf(const TextureRef& ref, const MeshPart& part) const
{
    if (!ref) return {};
    const Texture& texture = scene_.textures[std::size_t(ref.texture)];
    const vec2 turn(math::cos(ref.rotationRadians), math::sin(ref.rotationRadians));
    return {&small_.at(ref.texture), texture.wrapU, texture.wrapV, &part.uv[std::size_t(ref.texCoord)], ref, turn};
}

AtBake::Look AtBake::lookOf(const MeshPart& part) const
{
    const Material& m = materialOf(scene_, part);
    return {m,
            vec4(encoded(vec3(m.baseColor)), m.baseColor.w),
            encoded(m.emissiveNits),
            readerOf(m.baseColorTexture, part),
            readerOf(m.emissiveTexture, part),
            readerOf(m.metallicRoughnessTexture, part),
            readerOf(m.transmissionTexture, part)};
}

void AtBake::addTriangle(const MeshPart& part, const Look& look, std::size_t triangle, const Object& object,
                         int samples, Sums& sums) const
{
    const uint32_t* corners = &part.indices[3 * triangle];
    std::array<glm::dvec3, 3> p;
    for (std::size_t k = 0; k < 3; ++k) {
        const vec3 world(object.worldFromObject * vec4(part.positions[corners[k]], 1.0f));
        sums.bounds.extend(world);
        p[k] = glm::dvec3(world);
    }
    const double area = 0.5 * glm::length(glm::cross(p[1] - p[0], p[2] - p[0]));
    const glm::dvec3 sum = p[0] + p[1] + p[2];
    sums.area += area;
    sums.first += area / 3.0 * sum;
    sums.second += area / 12.0 * (p[0] * p[0] + p[1] * p[1] + p[2] * p[2] + sum * sum);
    if (!hasColors_) return;
    // Each point from all three corners: tools may begin a triangle at any of them.
    for (int i = 0; i < 3 * samples; ++i) {
        const vec3 point = pointInTriangle(i / 3);
        const vec3 weights(point[i % 3], point[(i + 1) % 3], point[(i + 2) % 3]);
        vec4 color = look.color * look.baseColor.at(corners, weights);
        vec4 ofVertices(0.0f);
        for (int k = 0; k < 3 && !part.colors.empty(); ++k) ofVertices += weights[k] * part.colors[corners[k]];
        if (!part.colors.empty()) color *= vec4(encoded(vec3(ofVertices)), ofVertices.w);
        const double share = area / (3.0 * samples);
        if (look.emission != vec3(0.0f))
            sums.emission += share * glm::dvec3(look.emission * vec3(look.emissive.at(corners, weights)));
        float metallic = look.material.metallic;
        if (metallic != 0.0f) metallic *= look.metallicRoughness.at(corners, weights).z;
        const float opacity = look.material.coverage(color.w, metallic, look.transmission.at(corners, weights).x);
        sums.color += share * double(opacity) * glm::dvec3(color);
        sums.opacity += share * double(opacity);
        sums.metallic += share * double(metallic);
    }
}

void AtBake::add(const Object& object, const MeshPart& part, Sums& sums) const
{
    const Look look = lookOf(part);
    const Material& material = look.material;
    const std::size_t triangles = part.triangleCount();
    const int samples = int(
        std::clamp<std::size_t>(kSamplesOfPart / std::max<std::size_t>(triangles, 1), kFewestSamples, kMostSamples));
    const double before = sums.area;
    for (std::size_t t = 0; t < triangles; ++t) addTriangle(part, look, t, object, samples, sums);
    sums.switches += (sums.area - before) * glm::dvec4(object.castShadows && material.castShadows,
                                                       object.receiveShadows && material.receiveShadows,
                                                       material.doubleSided, material.unlit);
}

std::optional<SurfaceAtBake> AtBake::ofObjects(std::span<const Object* const> objects) const
{
    Sums sums;
    for (const Object* object : objects) {
        if (!object->isStatic || object->mesh < 0) continue;
        for (const MeshPart& part : scene_.meshes[std::size_t(object->mesh)].parts)
            if (part.side != SurfaceSide::Back) add(*object, part, sums);
    }
    if (sums.bounds.empty()) return std::nullopt;
    SurfaceAtBake surface;
    surface.low = sums.bounds.min;
    surface.high = sums.bounds.max;
    surface.area = float(sums.area);
    surface.hasColors = hasColors_;
    if (!(sums.area > 0.0)) {
        surface.centroid = sums.bounds.center();
        return surface;
    }
    const glm::dvec3 centroid = sums.first / sums.area;
    surface.centroid = vec3(centroid);
    surface.spread = vec3(glm::sqrt(glm::max(sums.second / sums.area - centroid * centroid, glm::dvec3(0.0))));
    for (int i = 0; i < 4; ++i) surface.switches[std::size_t(i)] = float(sums.switches[i] / sums.area);
    if (sums.opacity > 0.0) surface.color = vec3(sums.color / sums.opacity);
    surface.emission = vec3(sums.emission / sums.area);
    surface.opacity = float(sums.opacity / sums.area);
    surface.metallic = float(sums.metallic / sums.area);
    return surface;
}

Json AtBake::sceneJson(std::size_t lightmapped) const
{
    std::map<int, bool> isStatic; // by node
    for (const Object& object : scene_.objects) isStatic[object.sourceNode] |= object.isStatic && object.mesh >= 0;
    const auto staticNodes = std::count_if(isStatic.begin(), isStatic.end(), [](const auto& n) { return n.second; });
    const auto lights = std::count_if(scene_.lights.begin(), scene_.lights.end(), [](const Light& light) {
        return light.baking.isBaked && light.baking.bakeType != LightMode::Realtime;
    });
    return {{"staticNodes", staticNodes}, {"lightmappedNodes", lightmapped}, {"bakedLights", lights}};
}

Json membersOfBake(const Json& root)
{
    Json members = Json::array();
    for (const char* name : {"lightmapUnitLux", "lightmaps", "lightmapDirections", "shadowmasks", "shadowmaskChannels",
                             "probes", "probes/sight", "reflectionProbes", "groups"}) {
        if (root.contains(Json::json_pointer("/" + std::string(name)))) members.push_back(name);
    }
    return members;
}

std::vector<std::string> lostMembers(const Json& root)
{
    std::set<std::string> names;
    for (const Json& name : member(member(root, "atBake"), "members")) names.insert(name.get<std::string>());
    for (const Json& name : membersOfBake(root)) names.erase(name.get<std::string>());
    return {names.begin(), names.end()};
}

bool shapeChangedSinceBake(const Light& light)
{
    const LightAtBake& was = light.baking.atBake;
    if (!was.known) return false;
    const auto changed = [](float now, float before) {
        return before >= 0.0f && std::abs(now - before) > 1.0e-3f * std::max(std::abs(now), std::abs(before)) + 1.0e-6f;
    };
    if (light.castShadows != was.castShadows) return true;
    if (light.type == LightType::Directional) return changed(light.angularRadiusRadians, was.angularRadiusRadians);
    const vec2 size = lightAtBake(light).sizeMeters;
    if (changed(size.x, was.sizeMeters.x) || changed(size.y, was.sizeMeters.y)) return true;
    if (changed(light.rangeMeters, was.rangeMeters) || changed(light.radiusMeters, was.radiusMeters)) return true;
    return light.type == LightType::Spot && (changed(light.outerConeRadians, light.baking.outerConeRadians) ||
                                             changed(light.innerConeRadians, was.innerConeRadians));
}

} // namespace halflight
