// Part "groups" of bench_bake: what light groups cost, and how good each is alone (spec S33).

#include "group_cost.h"

#include "bake/geometry/indices.h"
#include "bake/group_stages.h"

#include "halflight/bake_cpu/embree_integrator.h"

#include <cstdio>
#include <cstdlib>

namespace halflight::bench {
namespace {

struct GroupRun {
    Run all;
    std::vector<std::vector<IrradianceEstimate>> components;
};

/// `components`: of no group as well, which is the first.
GroupRun integrateGroups(const Prepared& p, IntegrationSettings settings, const LightComponents& components)
{
    settings.components = components;
    GroupRun run;
    auto made = makeEmbreeIntegrator(p.scene, p.geometry, settings);
    if (!made) std::exit(1);
    const auto count = std::size_t(components.count);
    run.all.estimates.resize(p.map.texels.size());
    std::vector<IrradianceEstimate> found(p.map.texels.size() * count);
    TexelMap valid = p.map;
    const double start = cpuSeconds();
    const bool done = (*made)->findValidPoints(valid, nullptr, {}) &&
                      (*made)
                          ->prepare(valid, nullptr)
                          ->irradianceByComponent({allIndices(p.map.texels.size())}, run.all.estimates, found, {});
    if (!done) std::exit(1);
    run.all.cpu = cpuSeconds() - start;
    run.all.rays = (*made)->raysTraced();
    run.components.resize(count);
    for (std::size_t i = 0; i < found.size(); ++i) run.components[i % count].push_back(found[i]);
    return run;
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
        const GroupRun with = integrateGroups(p, settings, components);
        std::printf("%s: %d groups, %.2f times the rays, %.2f times the CPU seconds\n", name.c_str(),
                    components.count - 1, double(with.all.rays) / double(without.rays), with.all.cpu / without.cpu);
        std::printf("%16s %8s %10s %10s %8s\n", "group", "share", "own bake", "in groups", "ratio");
        const double all = meanOf(with.all.estimates);
        for (int c = 0; c < components.count; ++c) {
            const auto& own = with.components[std::size_t(c)];
            const Prepared alone{onlyOf(p.scene, components, c), p.geometry, p.map};
            IntegrationSettings fine = settings;
            fine.samples *= kTruthTimes;
            fine.seed = 77;
            const std::vector<IrradianceEstimate> truth = integrate(alone, alone.map, fine).estimates;
            const double best = compare(integrate(alone, alone.map, settings).estimates, nullptr, truth).rmse;
            const double error = compare(own, nullptr, truth).rmse;
            std::printf("%16s %7.1f%% %9.2f%% %9.2f%% %8.2f\n",
                        c == 0 ? "(rest)" : grouping->groups[std::size_t(c - 1)].name.c_str(),
                        100.0 * meanOf(own) / all, 100.0 * best, 100.0 * error, error / best);
            std::fflush(stdout);
        }
    }
}

} // namespace halflight::bench
