// Part "groups" of bench_bake: what light groups cost, and how good each is alone (spec S33).

#include "group_cost.h"

#include "bake/group_stages.h"

#include <cmath>
#include <cstdio>
#include <cstdlib>

namespace halflight::bench {
namespace {

/// Estimates of one component.
std::vector<IrradianceEstimate> estimatesOf(const Run& run, int component)
{
    const std::size_t count = run.components.size() / run.estimates.size();
    std::vector<IrradianceEstimate> own;
    for (std::size_t i = 0; i < run.estimates.size(); ++i)
        own.push_back(run.components[i * count + std::size_t(component)]);
    return own;
}

/// The scene with the light of one component alone.
Scene onlyOf(Scene scene, const LightComponents& components, int component)
{
    for (std::size_t i = 0; i < scene.lights.size(); ++i)
        if (components.ofLight[i] != component) scene.lights[i].intensity = 0.0f;
    for (std::size_t i = 0; i < scene.materials.size(); ++i)
        if (components.ofMaterial[i] != component) scene.materials[i].emissiveNits = vec3(0.0f);
    if (components.ofSky[0] != component) scene.sky = {};
    return scene;
}

double meanOf(const std::vector<IrradianceEstimate>& estimates)
{
    double sum = 0.0;
    for (const IrradianceEstimate& e : estimates)
        sum += double(luminance(e.irradiance)) * (e.valid ? 1.0 : 0.0) / double(estimates.size());
    return sum;
}

std::vector<IntegrationSettings> withSeeds(const IntegrationSettings& settings, int count)
{
    std::vector<IntegrationSettings> all(std::size_t(count), settings);
    for (int i = 0; i < count; ++i) all[std::size_t(i)].seed = uint32_t(1 + i);
    return all;
}

double squared(double x)
{
    return x * x;
}

} // namespace

void partGroups(const Options& options)
{
    constexpr int kTruthTimes = 16; // a quarter of the noise
    for (const std::string& name : options.scenes) {
        Scene scene = load(name, false, options.settings);
        Result<LightGrouping> grouping = groupLights(scene, GroupChoice::Authored);
        if (!grouping || grouping->groups.empty()) {
            std::fprintf(stderr, "%s: no groups\n", name.c_str());
            std::exit(1);
        }
        grouping->exchange(scene);
        const LightComponents components = componentsOf(*grouping);
        Prepared p = prepareScene(std::move(scene), options.size, false);
        IntegrationSettings settings = options.integration();
        settings.samples = options.samples > 0 ? options.samples : 64;
        const Run without = integrate(p, p.map, settings);
        IntegrationSettings grouped = settings;
        grouped.components = components;
        std::vector<Run> with;
        for (const IntegrationSettings& seeded : withSeeds(grouped, options.seeds))
            with.push_back(integrate(p, p.map, seeded));
        std::printf("%s: %d groups, %.2f times the rays, %.2f times the CPU seconds\n", name.c_str(),
                    components.count - 1, double(with[0].rays) / double(without.rays), with[0].cpu / without.cpu);
        std::printf("%16s %8s %10s %10s %8s\n", "group", "share", "own bake", "in groups", "ratio");
        const double all = meanOf(with[0].estimates);
        for (int c = 0; c < components.count; ++c) {
            const Prepared alone{onlyOf(p.scene, components, c), p.geometry, p.map};
            IntegrationSettings fine = settings;
            fine.samples *= kTruthTimes;
            fine.seed = 77;
            const std::vector<IrradianceEstimate> truth = integrate(alone, alone.map, fine).estimates;
            double best = 0.0; // squares
            double error = 0.0;
            for (const IntegrationSettings& seeded : withSeeds(settings, options.seeds))
                best += squared(compare(integrate(alone, alone.map, seeded).estimates, nullptr, truth).rmse);
            for (const Run& run : with) error += squared(compare(estimatesOf(run, c), nullptr, truth).rmse);
            std::printf("%16s %7.1f%% %9.2f%% %9.2f%% %8.2f\n",
                        c == 0 ? "(rest)" : grouping->groups[std::size_t(c - 1)].name.c_str(),
                        100.0 * meanOf(truth) / all, 100.0 * std::sqrt(best / options.seeds),
                        100.0 * std::sqrt(error / options.seeds), std::sqrt(error / best));
            std::fflush(stdout);
        }
    }
}

} // namespace halflight::bench
