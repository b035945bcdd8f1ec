#include "unwrap/cuts/cut_scene.h"

namespace halflight::charts {
namespace {

constexpr double kToleranceTexels = 0.02; ///< vertices so near to a plane count as on it

bool isInstance(const Object& object)
{
    return object.sourceInstance >= 0;
}

} // namespace

SceneCuts cutScene(Scene& scene, const std::vector<GroupLayout>& groups, const std::vector<Surface>& surfaces,
                   double texelMeters, const CrossingTest& test, std::vector<std::string>& warnings)
{
    const std::vector<uint8_t> copyable = copyableMeshes(scene);
    std::vector<std::vector<uint32_t>> pieces(groups.size());
    std::vector<CutCandidate> candidates;
    double texels = 0.0;
    for (std::size_t g = 0; g < groups.size(); ++g) {
        double area = 0.0;
        for (const double a : surfaces[g].areas) area += a;
        texels += area * double(groups[g].group.objects.size()) / (texelMeters * texelMeters);
        if (groups[g].authored || copyable[std::size_t(groups[g].group.mesh)] == 0) continue;
        pieces[g] = smoothPieces(surfaces[g]);
        for (const int o : groups[g].group.objects) {
            const Object& object = scene.objects[std::size_t(o)];
            if (!isInstance(object))
                candidates.push_back({o, &surfaces[g], pieces[g], texelMeters / double(object.lightmapScale), {}});
        }
    }
    findCuts(scene, candidates, texels, test, warnings);
    SceneCuts cuts;
    for (const CutCandidate& candidate : candidates) {
        if (candidate.cuts.empty()) continue;
        Object& object = scene.objects[std::size_t(candidate.object)];
        Mesh cut(scene.meshes[std::size_t(object.mesh)]);
        std::vector<uint32_t> portions =
            cutMesh(cut, *candidate.surface, candidate.pieces, glm::dmat4(object.worldFromObject), candidate.cuts,
                    kToleranceTexels * candidate.texelMeters, cuts.count);
        if (portions.empty()) continue;
        const auto users = std::count_if(scene.objects.begin(), scene.objects.end(),
                                         [&](const Object& other) { return other.mesh == object.mesh; });
        if (users > 1) {
            object.mesh = int(scene.meshes.size());
            scene.meshes.emplace_back();
        }
        scene.meshes[std::size_t(object.mesh)] = std::move(cut);
        cuts.portions.resize(scene.meshes.size());
        cuts.portions[std::size_t(object.mesh)] = std::move(portions);
    }
    return cuts;
}

} // namespace halflight::charts
