// The compose pass of light groups (S33): milliseconds for a page and a group by GPU timestamps, when a weight changes
// before each frame, and what frames without a change do. Exit code 1 when such a frame composes.
//
//   bench_groups [--cpu] [--frames N] [--side TEXELS]

#include "halflight/base/rgb9e5.h"
#include "halflight/render/renderer.h"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>
#include <vector>

using namespace halflight;

namespace {

/// One page, all of whose groups have light on all texels, with directions or without.
BakedScene bakeWithGroups(int groups, int side, bool directional)
{
    BakedScene baked;
    baked.isBaked = true;
    baked.mode = MixedLightingMode::BakedIndirect;
    const Image<uint32_t> page(side, side, packRgb9e5(vec3(1.0f, 0.5f, 0.25f)));
    const ImageRgba8 directions(side, side, u8vec4(128, 200, 128, 255));
    baked.lightmaps = {page};
    if (directional) baked.lightmapDirections = {directions};
    for (int g = 0; g < groups; ++g) {
        BakedGroup& group = baked.groups.emplace_back();
        group.name = std::to_string(g);
        group.lightmaps = {page};
        if (directional) group.directions = {directions};
    }
    return baked;
}

/// Of the frame's compose pass; below 0 where there is none.
double composeMilliseconds(Renderer& renderer)
{
    RenderSettings settings;
    settings.mode = RunMode::BakedIndirect;
    settings.size = {64, 64};
    settings.timings = true;
    const Result<RenderedFrame> frame = renderer.render(Camera{}, settings);
    if (!frame || !frame->timed) {
        std::fprintf(stderr, "%s\n", frame ? "the device has no timestamps" : frame.error().text().c_str());
        std::exit(2);
    }
    for (const PassReport& pass : frame->passes)
        if (pass.name == "compose") return pass.milliseconds;
    return -1.0;
}

bool bench(Renderer& renderer, int groups, int side, bool directional, int frames)
{
    if (Status status = renderer.load(bakeWithGroups(groups, side, directional)); !status) {
        std::fprintf(stderr, "%s\n", status.error().text().c_str());
        std::exit(2);
    }
    composeMilliseconds(renderer);
    std::vector<double> times;
    for (int i = 0; i < frames; ++i) {
        if (!renderer.setLightGroup("0", vec3(0.1f * float(i % 10 + 1)))) std::exit(2);
        times.push_back(composeMilliseconds(renderer));
    }
    const bool rests = composeMilliseconds(renderer) < 0.0;
    std::sort(times.begin(), times.end());
    const double median = times[times.size() / 2];
    // Read: the rest and each group; written: one sum.
    const double bytes = double(groups + 2) * double(side) * double(side) * (directional ? 8.0 : 4.0);
    std::printf("| %d | %s | %.3f | %.4f | %.0f | %s |\n", groups, directional ? "yes" : "no", median, median / groups,
                bytes / median / 1.0e6, rests ? "none" : "COMPOSES");
    return rests;
}

} // namespace

int main(int argc, char** argv)
{
    int frames = 31;
    int side = 2048;
    RendererOptions options;
    for (int i = 1; i < argc; ++i) {
        if (std::strcmp(argv[i], "--cpu") == 0) options.preferCpu = true;
        if (std::strcmp(argv[i], "--frames") == 0 && i + 1 < argc) frames = std::max(1, std::atoi(argv[++i]));
        if (std::strcmp(argv[i], "--side") == 0 && i + 1 < argc) side = std::max(1, std::atoi(argv[++i]));
    }
    const auto renderer = Renderer::create(options);
    if (!renderer) {
        std::fprintf(stderr, "%s\n", renderer.error().text().c_str());
        return 2;
    }
    std::printf("device: %s, a page of %d x %d, medians of %d frames\n\n", (*renderer)->deviceName().c_str(), side,
                side, frames);
    std::printf("| groups | directions | ms | ms for a group | GB/s | frames at rest |\n|---|---|---|---|---|---|\n");
    bool rests = true;
    for (const bool directional : {false, true})
        for (const int groups : {1, 4, 16}) rests = bench(**renderer, groups, side, directional, frames) && rests;
    return rests ? 0 : 1;
}
