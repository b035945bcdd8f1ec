#include "bake/denoise_stages.h"

#include "bake/denoise/denoise.h"
#include "bake/seams/surface_grid.h"

namespace halflight {
namespace {

/// `body` returns what the denoisers of denoise.h return.
template<typename Body> Status runDenoiser(const BakeRun& run, BakeReport& report, const Body& body)
{
    if (run.settings.denoiser == Denoiser::Off) return {};
    StageTimer timer(report, "denoise");
    if (Status s = body(); !s) {
        if (s.error().code == ErrorCode::DeviceFailed) return s;
        report.warnings.push_back("the processor denoises in the GPU's place: " + s.error().message);
    }
    timer.finish();
    if (run.progress.cancelled()) return cancelledError();
    return {};
}

} // namespace

Status denoiseStage(const BakeRun& run, const CachedIntegrator& cached, std::span<const SeamSample> seams,
                    const DeviceDenoiser& device, std::vector<IrradianceEstimate>& estimates)
{
    return runDenoiser(run, run.report(), [&] {
        run.progress("denoise", 0.0);
        const bool directional = run.report().quality.directional;
        return denoise(cached.geometry, cached.map, seams, estimates, directional, device);
    });
}

Status denoiseStage(const BakeRun& run, const CachedIntegrator& cached, std::span<const SeamSample> seams,
                    const DeviceDenoiser& device, std::span<const uint8_t> valid, std::span<const uint8_t> samples,
                    ComponentSignals& components, BakeReport& report)
{
    return runDenoiser(run, report, [&] {
        const SurfaceGrid grid(cached.map, seams);
        return denoiseComponents({cached.geometry, cached.map, grid, valid, samples}, components.components(), device);
    });
}

} // namespace halflight
