#pragma once
// A small scene that is baked in the background, and the light that is shown of it.

#include "bake/test_room.h"

#include "halflight/bake/bake_session.h"
#include "halflight/base/rgb9e5.h"

#include <chrono>
#include <cmath>
#include <optional>
#include <thread>
#include <vector>

namespace halflight::test {

inline BakeSettings quick()
{
    BakeSettings settings;
    settings.quality = Quality::Preview;
    settings.samples = 16;
    settings.lightmapSize = 128;
    settings.probeSpacingMeters = 1.0f;
    return settings;
}

/// Without layouts of its own, so that charts are made.
inline Scene scene()
{
    Scene scene = room(true, true, true);
    for (Object& object : scene.objects) object.lightmap = {};
    for (Mesh& mesh : scene.meshes)
        for (MeshPart& part : mesh.parts) part.lightmapUv.clear();
    return scene;
}

inline void put(const LightTile& tile, BakedScene& shown)
{
    Image<uint32_t>& page = shown.lightmaps.at(std::size_t(tile.page));
    for (int y = 0; y < tile.texels.height(); ++y)
        for (int x = 0; x < tile.texels.width(); ++x) page(tile.offset.x + x, tile.offset.y + y) = tile.texels(x, y);
}

/// Root mean square difference of the light of `shown` and the result, over the result's.
inline double errorOf(const BakedScene& shown, const BakeResult& result)
{
    double difference = 0.0;
    double all = 0.0;
    for (std::size_t p = 0; p < result.irradiance.size(); ++p) {
        const ImageRgb32f page = decodeRgb9e5(shown.lightmaps.at(p), shown.lightmapUnitLux);
        for (std::size_t i = 0; i < page.texelCount(); ++i) {
            const vec3 light = result.irradiance[p].texels()[i];
            if (page.texels()[i] == vec3(0.0f)) continue; // far from all charts
            difference += double(glm::dot(page.texels()[i] - light, page.texels()[i] - light));
            all += double(glm::dot(light, light));
        }
    }
    return std::sqrt(difference / all);
}

/// First light, and what it becomes by each call of takeTiles(), until the bake ends.
inline std::vector<BakedScene> statesOf(BakeSession& session)
{
    std::optional<BakedScene> shown;
    std::vector<BakedScene> states;
    bool last = false;
    while (!last) {
        last = session.state().finished;
        if (!shown) {
            if ((shown = session.takeLight())) states.push_back(*shown);
        } else {
            const std::vector<LightTile> tiles = session.takeTiles();
            for (const LightTile& tile : tiles) put(tile, *shown);
            if (!tiles.empty()) states.push_back(*shown);
        }
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    return states;
}

} // namespace halflight::test
