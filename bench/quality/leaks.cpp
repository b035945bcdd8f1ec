// Light that comes through walls and floors.

#include "quality/baked.h"
#include "quality/measures.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace halflight::quality {

namespace {

// Inside is dark: what light there is came through walls. The sky is the same from everywhere, so outside is pi times
// its radiance.
Figures measureClosedRooms(const std::filesystem::path& assets)
{
    Figures figures;
    struct Room {
        const char* file;
        std::vector<Bounds> insides;
    };
    const std::vector<Room> rooms = {
        {"quality/leaks.glb", {{vec3(-2.0f, 0.0f, -1.6f), vec3(2.0f, 2.4f, 1.6f)}}},
        {"tests/closed_room.glb",
         {{vec3(-5.0f, 0.0f, -2.0f), vec3(-1.0f, 2.5f, 2.0f)}, {vec3(1.0f, 0.0f, -2.0f), vec3(5.0f, 2.5f, 2.0f)}}}};
    for (const Room& room : rooms) {
        for (const float density : {6.0f, 20.0f}) {
            auto baked = bakeFile(assets / room.file, settingsFor(MixedLightingMode::Shadowmask, density, 32, 1));
            if (!baked) return failed("leaks", room.file, baked.error());
            double worst = 0.0;
            double sum = 0.0;
            std::size_t count = 0;
            forSurface(*baked, [&](const SurfaceSample& s) {
                const vec3 before = s.position + 2.0e-3f * s.geometricNormal;
                for (const Bounds& inside : room.insides) {
                    if (glm::any(glm::lessThan(before, inside.min)) || glm::any(glm::greaterThan(before, inside.max)))
                        continue;
                    const double leak = luminanceOf(baked->light(s.page, s.texel)) / (kPi * 50.0);
                    worst = std::max(worst, leak);
                    sum += leak;
                    ++count;
                }
            });
            const std::string at = ", " + std::to_string(int(density)) + " texels/m";
            figures.push_back(
                {"leaks", room.file, "brightest point inside, of the outside's light" + at, 100.0 * worst, 0.1, "%"});
            figures.push_back({"leaks", room.file, "mean inside, of the outside's light" + at,
                               100.0 * sum / double(count), 0.01, "%"});
            if (count == 0) figures.back().value = std::numeric_limits<double>::infinity();
        }
    }
    return figures;
}

/// Height of the floors of cellars.glb above their nodes.
float floorOf(vec3 local)
{
    return 0.1f * local.x + 0.08f * local.z;
}

/// Light and shadow of the hidden space under the floor, of all that is hidden, at the visible surfaces of cellars.glb.
struct Hidden {
    double light = 0.0;
    double dark = 0.0;
    double mask = 0.0;
};

/// Rooms and walls stand three metres apart, rooms behind the walls.
Hidden hiddenIn(const Baked& baked, int column)
{
    const float x = 3.0f * float(column);
    double leak = 0.0;
    double below = 0.0;
    std::size_t samples = 0;
    Hidden hidden;
    constexpr float kOnFloor = 2.0e-3f; // metres: a point on the floor's plane is of both sides
    const double sun = 10.0 * std::sqrt(0.5);
    forSurface(baked, [&](const SurfaceSample& s) {
        const vec3 before = s.position + 1.0e-3f * s.geometricNormal;
        const double light = luminanceOf(baked.light(s.page, s.texel));
        const vec3 room = before - vec3(x, 0.0f, -3.0f);
        const float above = room.y - floorOf(room);
        if (std::abs(room.x) < 0.7f && std::abs(room.z) < 0.5f && room.y > -0.7f && room.y < 1.7f) {
            if (above > kOnFloor) leak = std::max(leak, light);
            if (above < -0.2f && std::abs(s.geometricNormal.y) < 0.5f) {
                below += light;
                ++samples;
            }
        }
        const vec3 yard = before - vec3(x, 0.0f, 0.0f);
        if (std::abs(yard.x) > 0.7f || std::abs(yard.z) > 2.0e-3f || s.geometricNormal.z < 0.5f) return;
        if (yard.y <= floorOf(yard) + kOnFloor || yard.y > 1.7f) return;
        hidden.dark = std::max(hidden.dark, (sun - light) / sun);
        hidden.mask = std::max(hidden.mask, 1.0 - double(baked.mask(s.page, s.texel, 0)));
    });
    hidden.light =
        samples > 0 && below > 0.0 ? leak * double(samples) / below : std::numeric_limits<double>::infinity();
    return hidden;
}

/// Walls that go on below a floor have the light above it: none in the rooms, all of the sun in the open.
Figures measureCellars(const std::filesystem::path& assets)
{
    const std::string scene = "quality/cellars.glb";
    Figures figures;
    struct Case {
        const char* name;
        Quality quality;
        float density;
    };
    for (const Case c : {Case{"preview", Quality::Preview, 10.0f}, Case{"medium", Quality::Medium, 20.0f}}) {
        BakeSettings settings = settingsFor(MixedLightingMode::Shadowmask, c.density, 0, 2);
        settings.shadowSamples = 0;
        settings.quality = c.quality;
        const auto baked = bakeFile(assets / scene, settings);
        if (!baked) return failed("leaks", scene, baked.error());
        const std::string at = std::string(", ") + c.name + ", " + std::to_string(int(c.density)) + " texels/m";
        for (int column = 0; column < 2; ++column) {
            const Hidden hidden = hiddenIn(*baked, column);
            const std::string floor = column == 0 ? "floor of 2 cm: " : "floor without thickness: ";
            figures.push_back({"leaks", scene, floor + "brightest point above it, of the cellar's light" + at,
                               100.0 * hidden.light, 0.5, "%"});
            figures.push_back({"leaks", scene, floor + "darkest point of a sunlit wall above it, lack of light" + at,
                               100.0 * hidden.dark, 0.5, "%"});
            figures.push_back({"leaks", scene, floor + "the same of the mask" + at, 100.0 * hidden.mask, 2.0, "%"});
        }
    }
    return figures;
}

} // namespace

Figures measureLeaks(const std::filesystem::path& assets)
{
    Figures figures = measureClosedRooms(assets);
    const Figures cellars = measureCellars(assets);
    figures.insert(figures.end(), cellars.begin(), cellars.end());
    return figures;
}

} // namespace halflight::quality
