#include "scene/format/sky_at_bake.h"

#include "halflight/base/hash.h"
#include "scene/format/bake_members.h"

#include <algorithm>

namespace halflight {

std::string pictureHash(const ImageRgb32f& picture, float rotationRadians)
{
    return Hasher().add(picture.size()).add(picture.texels()).add(rotationRadians).hash().hex();
}

bool skyDiffersFrom(const Sky& skyOfFile, const Json& atBake)
{
    if (!atBake.is_object()) return false;
    const auto differs = [&](const char* key, vec3 now) {
        vec3 then(0.0f);
        return readVector(member(atBake, key), then) &&
               glm::distance(now, then) > 1.0e-3f * std::max(glm::length(now), glm::length(then));
    };
    const std::string hash =
        skyOfFile.picture == nullptr ? "" : pictureHash(*skyOfFile.picture, skyOfFile.rotationRadians);
    return differs("zenith", skyOfFile.zenith) || differs("horizon", skyOfFile.horizon) ||
           differs("ground", skyOfFile.ground) || hash != stringOf(atBake, "picture");
}

} // namespace halflight
