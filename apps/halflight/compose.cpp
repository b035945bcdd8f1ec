// halflight compose: one state of a bake with light groups, as a baked file without groups.

#include "console.h"
#include "group_option.h"
#include "interrupt.h"
#include "light_override.h"
#include "terminal.h"

#include "halflight/base/files_in_use.h"
#include "halflight/scene/gltf.h"
#include "halflight/scene/turning_lights.h"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <memory>

namespace halflight::cli {
namespace {

struct ComposeOptions {
    std::filesystem::path input;
    std::filesystem::path output;
    std::vector<GroupWeight> groups;
    std::vector<LightOverride> lights;
    bool quiet = false;
};

/// Lights that turn have another direction, colour or intensity; the others follow their groups.
Status changeLights(BakedScene& baked, const std::vector<LightOverride>& changes)
{
    for (const LightOverride& change : changes)
        if (change.position || change.rangeMeters || change.innerConeRadians || change.outerConeRadians ||
            change.shadowStrength || change.shadowBias.depthTexels || change.shadowBias.slope ||
            change.shadowBias.normalTexels)
            return Error{ErrorCode::InvalidArgument,
                         "--light changes direction, color and intensity here, and nothing else of light \"" +
                             change.name + "\"",
                         ""};
    const auto changed = changedLights(baked.scene, changes);
    if (!changed) return changed.error();
    for (const auto& [index, light] : *changed) {
        if (!turns(light))
            return Error{
                ErrorCode::InvalidArgument,
                fmt::format("light \"{}\" does not turn: give it halflight_directions and bake it again, or set "
                            "its light group",
                            light.name),
                ""};
        Light& own = baked.scene.lights[std::size_t(index)];
        own.worldFromLight = light.worldFromLight;
        own.color = light.color;
        own.intensity = light.intensity;
    }
    return {};
}

int runCompose(const ComposeOptions& options)
{
    const std::string extension = lowerExtension(options.output);
    if (extension != ".glb" && extension != ".gltf") {
        return wrongUsage("compose",
                          fmt::format("--output must end in .glb or .gltf, not '{}'", options.output.string()));
    }
    FilesInUse files;
    std::filesystem::path culprit;
    addReadFiles(files, options.input, {});
    addBakedFiles(files, "--output", options.output);
    if (Status status = files.check(culprit); !status) return fail(culprit, status.error());
    if (Status status = checkOutput(options.output); !status) return fail(options.output, status.error());
    Result<BakedScene> baked = readBakedScene(options.input);
    if (!baked) return fail(options.input, baked.error());
    addExternalFiles(files, externalFiles(baked->scene));
    if (Status status = files.check(culprit); !status) return fail(culprit, status.error());
    if (baked->groups.empty())
        return fail(options.input, {ErrorCode::InvalidArgument, "has no light groups: bake a scene that has some", ""});
    if (Status status = changeLights(*baked, options.lights); !status) return fail(options.input, status.error());
    const Result<std::vector<vec3>> weights = groupWeights(*baked, options.groups);
    if (!weights) return fail(options.input, weights.error());
    std::string state;
    for (const auto& [name, w] : settableWeights(*baked, *weights)) {
        const bool grey = w.x == w.y && w.x == w.z;
        state += fmt::format("{}{}={}", state.empty() ? "" : ", ", printable(name),
                             grey ? fmt::format("{:g}", w.x) : fmt::format("{:g},{:g},{:g}", w.x, w.y, w.z));
    }
    std::vector<std::string> notes = oldReflections(*baked, *weights);
    for (const Light& light : baked->scene.lights)
        if (turns(light) && std::ranges::find(options.lights, light.name, &LightOverride::name) != options.lights.end())
            for (std::string& note : changesSinceBake(light, "light \"" + light.name + "\"", false))
                notes.push_back(std::move(note));
    composeGroups(*baked, *weights);
    WriteOptions write;
    write.mayReplace = commitOutput;
    if (Status status = writeBakedScene(options.output, *baked, write); !status)
        return fail(options.output, status.error());
    if (options.quiet) return kOk;
    for (const std::string& warning : baked->scene.warnings) warn(options.input, warning);
    for (const std::string& note : notes) warn(options.input, printable(note));
    print("{}: {}\n", options.output.string(), state);
    return kOk;
}

} // namespace

Command addComposeCommand(CLI::App& parent)
{
    auto options = std::make_shared<ComposeOptions>();
    CLI::App& app =
        *parent.add_subcommand("compose", "Write a state of a bake with light groups as a bake without groups");
    app.add_option("FILE", options->input, "a baked file with light groups, .glb or .gltf")->required()->type_name(" ");
    app.add_option("-o,--output", options->output, "the file to write: .glb, or .gltf with its files beside it")
        ->required()
        ->type_name("OUT.glb");
    addGroups(app, options->groups,
              "weight of a light group, one number or three for red, green and blue (default: as the file has it); may "
              "be repeated");
    addSky(app, options->groups);
    addLights(app, options->lights, "direction, color and intensity of a light that turns; may be repeated");
    app.add_flag("-q,--quiet", options->quiet, "print errors only");
    app.footer("Example: halflight compose baked.glb -o evening.glb --group lamps=1 --group sun=0");
    return {&app, [options] { return runCompose(*options); }};
}

} // namespace halflight::cli
