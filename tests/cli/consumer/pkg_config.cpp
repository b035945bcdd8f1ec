// Built with the flags that pkg-config gives for an installed Halflight: links the baker and a reader.

#include "halflight/bake/bake.h"
#include "halflight/bake_cpu/embree_integrator.h"
#include "halflight/scene/gltf.h"

int main()
{
    const auto baked =
        halflight::bake(halflight::Scene(), halflight::BakeSettings(), halflight::embreeIntegrators(), {});
    const auto read = halflight::readBakedScene("no such file.glb");
    const bool said = baked || !baked.error().text().empty(); // an empty scene: either will do
    return said && !read ? 0 : 1;
}
