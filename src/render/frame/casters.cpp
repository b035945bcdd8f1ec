// Who casts into a shadow map.
#include "render/frame/frame_internal.h"

namespace halflight {

std::vector<uint32_t> castersOfTile(const Scene& scene, std::span<const Bounds> bounds, const LightVolume& volume,
                                    bool staticCasters, const mat4& clipFromWorld)
{
    const Planes planes = planesOf(clipFromWorld);
    std::vector<uint32_t> casters;
    for (std::size_t i = 0; i < scene.objects.size(); ++i) {
        const Object& object = scene.objects[i];
        if (!object.castShadows || (object.isStatic && !staticCasters)) continue;
        if (meets(volume, bounds[i]) && meets(planes, bounds[i])) casters.push_back(uint32_t(i));
    }
    return casters;
}

} // namespace halflight
