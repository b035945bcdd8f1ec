// halflight compose: one state of a bake with light groups, as a baked file without groups.

#include "console.h"
#include "group_option.h"
#include "interrupt.h"
#include "terminal.h"

#include "halflight/base/files_in_use.h"
#include "halflight/scene/gltf.h"

#include <spdlog/fmt/fmt.h>

#include <memory>

namespace halflight::cli {
namespace {

struct ComposeOptions {
    std::filesystem::path input;
    std::filesystem::path output;
    std::vector<GroupWeight> groups;
    bool quiet = false;
};

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
    const Result<std::vector<vec3>> weights = groupWeights(*baked, options.groups);
    if (!weights) return fail(options.input, weights.error());
    std::string state;
    for (std::size_t g = 0; g < weights->size(); ++g) {
        const vec3 w = (*weights)[g];
        const bool grey = w.x == w.y && w.x == w.z;
        state += fmt::format("{}{}={}", g > 0 ? ", " : "", printable(baked->groups[g].name),
                             grey ? fmt::format("{:g}", w.x) : fmt::format("{:g},{:g},{:g}", w.x, w.y, w.z));
    }
    const std::vector<std::string> kept = oldReflections(*baked, *weights);
    composeGroups(*baked, *weights);
    WriteOptions write;
    write.mayReplace = commitOutput;
    if (Status status = writeBakedScene(options.output, *baked, write); !status)
        return fail(options.output, status.error());
    if (options.quiet) return kOk;
    for (const std::string& warning : baked->scene.warnings) warn(options.input, warning);
    for (const std::string& warning : kept) warn(options.input, printable(warning));
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
    app.add_flag("-q,--quiet", options->quiet, "print errors only");
    app.footer("Example: halflight compose baked.glb -o evening.glb --group lamps=1 --group sun=0");
    return {&app, [options] { return runCompose(*options); }};
}

} // namespace halflight::cli
