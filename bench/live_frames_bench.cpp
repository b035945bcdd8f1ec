// Frames that a window gets while it bakes. Usage:
//
//   bench_live_frames SCENE.glb [QUALITY preview|medium|high] [LIGHTMAP_SIZE] [WxH] [DEVICE]
//
// DEVICE: "cpu", the default; "gpu"; or a part of a GPU's name, which bakes then.
// Draws frames one after the other as the window does, forward with all defaults: for three seconds alone, then during
// a bake, whose light and tiles are loaded between frames. Prints median, 90th percentile and longest seconds of a
// frame, and those of loading. Wall time, with reading the picture back: use a quiet machine.
#include "session_arguments.h"

#include "halflight/bake/bake_session.h"
#include "halflight/bake_cpu/embree_integrator.h"
#include "halflight/bake_gpu/gpu_integrator.h"
#include "halflight/render/renderer.h"
#include "halflight/scene/gltf.h"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

using namespace halflight;
using namespace halflight::bench;

namespace {

template<typename T> T checked(Result<T> result)
{
    if (result) return std::move(*result);
    std::fprintf(stderr, "%s\n", result.error().text().c_str());
    std::exit(1);
}

void print(const char* what, std::vector<double> seconds)
{
    if (seconds.empty()) return;
    std::sort(seconds.begin(), seconds.end());
    std::printf("%-22s %5zu  median %.3f s, 90 %% within %.3f s, longest %.3f s\n", what, seconds.size(),
                seconds[seconds.size() / 2], seconds[seconds.size() * 9 / 10], seconds.back());
}

class LiveFrames {
public:
    LiveFrames(Scene scene, ivec2 size) : scene_(std::move(scene)), renderer_(checked(Renderer::create()))
    {
        view_.size = size;
        if (!scene_.cameras.empty()) camera_ = scene_.cameras.front();
        load(BakedScene{.scene = scene_});
        frame(); // prepares the shaders
    }
    void alone()
    {
        std::vector<double> frames;
        for (const Clock::time_point start = Clock::now(); secondsSince(start) < 3.0;) frames.push_back(frame());
        print("alone", frames);
    }
    void baking(const BakeSettings& settings, const IntegratorFactory& integrators)
    {
        std::vector<double> frames;
        std::vector<double> loads;
        const Clock::time_point start = Clock::now();
        BakeSession session(scene_, settings, integrators);
        session.setView(camera_, float(view_.size.x) / float(view_.size.y));
        while (!session.state().finished) {
            const auto ofTexels = session.takeLight();
            if (const auto light = ofTexels ? ofTexels : session.takeProbeLight()) {
                loads.push_back(load(*light));
                const double first = frame();
                std::printf("%s shown after %.2f s, in a frame of %.3f s\n",
                            ofTexels ? "light of texels" : "light of probes", secondsSince(start), first);
            }
            const std::vector<LightTile> tiles = session.takeTiles();
            std::vector<LightmapRectangle> rectangles;
            for (const LightTile& tile : tiles) rectangles.push_back({tile.page, tile.offset, &tile.texels});
            if (!rectangles.empty() && !renderer_->updateLightmaps(rectangles)) std::exit(1);
            frames.push_back(frame());
        }
        (void)checked(session.takeResult());
        std::printf("denoised light of all texels after %.2f s\n", secondsSince(start));
        print("during the bake", frames);
        print("loading light", loads);
    }

private:
    double load(const BakedScene& baked)
    {
        const Clock::time_point start = Clock::now();
        if (!renderer_->load(baked)) std::exit(1);
        view_.mode = defaultRunMode(baked);
        return secondsSince(start);
    }
    double frame()
    {
        const Clock::time_point start = Clock::now();
        (void)checked(renderer_->render(camera_, view_));
        return secondsSince(start);
    }

    Scene scene_;
    std::unique_ptr<Renderer> renderer_;
    RenderSettings view_;
    Camera camera_;
};

} // namespace

int main(int count, char** arguments)
{
    if (count < 2) {
        std::fprintf(stderr,
                     "usage: bench_live_frames SCENE.glb [preview|medium|high] [LIGHTMAP_SIZE] [WxH] [DEVICE]\n");
        return 2;
    }
    ivec2 size(320, 180);
    if (count > 4 && std::sscanf(arguments[4], "%dx%d", &size.x, &size.y) != 2) return 2;
    const std::string device = count > 5 ? arguments[5] : "cpu";
    const IntegratorFactory integrators =
        device == "cpu" ? embreeIntegrators()
                        : gpuIntegrators(checked(openBakeDevice({.name = device == "gpu" ? "" : device})));
    LiveFrames live(checked(readScene(arguments[1])), size);
    live.alone();
    live.baking(settingsOf(count, arguments), integrators);
    return 0;
}
