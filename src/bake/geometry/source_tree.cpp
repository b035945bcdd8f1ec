#include "bake/geometry/source_tree.h"

#include "bake/geometry/flatten.h"

namespace halflight {
namespace {

std::vector<std::size_t> trianglesOfObjects(const Scene& scene)
{
    std::vector<std::size_t> counts;
    for (const Object& object : scene.objects) counts.push_back(scene.meshes[std::size_t(object.mesh)].triangleCount());
    return counts;
}

} // namespace

SourceTree::SourceTree(const IntegratorFactory& factory, const IntegrationSettings& settings)
    : factory_(factory), settings_(settings)
{
    settings_.fewRays = true;
}

const BakeGeometry& SourceTree::geometryOf(const Scene& scene)
{
    std::vector<std::size_t> triangles = trianglesOfObjects(scene);
    if (triangles != triangles_) {
        triangles_ = std::move(triangles);
        integrator_.reset();
        geometry_ = flattenGeometry(scene, 1, GeometryFilter::Static);
    }
    return geometry_;
}

Integrator* SourceTree::integratorOf(const Scene& scene)
{
    const BakeGeometry& geometry = geometryOf(scene);
    if (integrator_) return integrator_.get();
    scene_ = {};
    scene_.textures = scene.textures;
    scene_.materials = scene.materials;
    scene_.objects = scene.objects;
    scene_.lights = scene.lights;
    scene_.sky = scene.sky;
    Result<std::unique_ptr<Integrator>> made = factory_.make(scene_, geometry, settings_);
    if (made) integrator_ = std::move(*made);
    return integrator_.get();
}

} // namespace halflight
