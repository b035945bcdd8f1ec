// What probes say where something stands between.
#include "quality/measures.h"

#include "quality/baked.h"

#include "halflight/render/probes.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

namespace halflight::quality {
namespace {

// Small things on a sunny floor: their light must not come from probes in the shadow behind the building or under the
// floor's rim, whatever tetrahedra join. Above the forecourt of the hall nothing stands between any point and the sun.
Figure measureFloor(const std::filesystem::path& assets)
{
    const std::string scene = "tests/probe_hall.glb";
    BakeSettings settings = settingsFor(MixedLightingMode::Shadowmask, 4.0f, 16, 1);
    settings.probeSpacingMeters = 0.6f;
    auto baked = bakeFile(assets / scene, settings);
    if (!baked) return failed("probes", scene, baked.error())[0];
    const ProbeInterpolator probes(baked->result.baked);
    double worst = 0.0;
    for (const float y : {0.02f, 0.05f, 0.1f, 0.2f, 0.4f}) {
        for (float z = 1.2f; z < 5.81f; z += 0.2f) {
            for (float x = -4.8f; x < 4.81f; x += 0.2f)
                worst = std::max(worst, 1.0 - double(probes.sample({x, y, z}).occlusion[0]));
        }
    }
    return {"probes", scene, "most shadow 2 cm to 40 cm above a sunny floor", 100.0 * worst, 1.0, "%"};
}

// Light of the bright room in the dark one, over that of the bright room: at single points, and in a proxy volume.
class ProbeRooms {
public:
    explicit ProbeRooms(const BakedScene& baked) : probes_(baked)
    {
        std::vector<double> bright;
        forPlaces(0.25f, [&](vec3 p) { bright.push_back(at({-p.x, p.y, p.z})); });
        level_ = percentile(bright, 0.5);
    }

    /// In percent of the bright room's median.
    [[nodiscard]] std::vector<double> dark(float metersFromWall) const
    {
        std::vector<double> dark;
        forPlaces(metersFromWall, [&](vec3 p) { dark.push_back(100.0 * at(p) / level_); });
        return dark;
    }
    /// Of a box in the dark room, a texel every 10 cm, that ends 25 cm from the wall.
    [[nodiscard]] std::vector<double> darkVolume() const
    {
        const ProxyVolume volume =
            makeProxyVolume(probes_, Bounds{{0.27f, 0.3f, -1.0f}, {1.27f, 1.3f, 1.0f}}, {ivec3(11, 11, 21)});
        std::vector<double> dark;
        forPlaces(0.25f, [&](vec3 p) {
            dark.push_back(100.0 * luminanceOf(sampleProxyVolume(volume, p).radiance[0]) / level_);
        });
        return dark;
    }
    /// Least light 2 cm from the bright side of the wall, of that 25 cm from it, in percent.
    [[nodiscard]] double brightAtWall() const
    {
        double least = 100.0;
        for (float y = 0.3f; y < 2.2f; y += 0.3f) {
            for (float z = -1.8f; z < 1.81f; z += 0.3f)
                least = std::min(least, 100.0 * at({-0.04f, y, z}) / at({-0.27f, y, z}));
        }
        return least;
    }

private:
    [[nodiscard]] double at(vec3 p) const { return luminanceOf(probes_.sample(p).radiance[0]); }
    template<typename Visit> static void forPlaces(float metersFromWall, Visit visit)
    {
        for (float y = 0.3f; y < 2.2f; y += 0.3f) {
            for (float z = -1.8f; z < 1.81f; z += 0.3f) {
                for (float x = 0.02f + metersFromWall; x < 3.9f; x += 0.3f) visit(vec3(x, y, z));
            }
        }
    }

    ProbeInterpolator probes_;
    double level_ = 0.0;
};

int probesOutside(const ProbeSet& set)
{
    int outside = 0;
    for (const Probe& probe : set.probes) {
        const vec3 p = probe.position;
        const bool inRoom =
            p.y > 0.0f && p.y < 2.5f && std::abs(p.z) < 2.0f && std::abs(p.x) > 0.02f && std::abs(p.x) < 4.0f;
        outside += !inRoom && probe.valid ? 1 : 0;
    }
    return outside;
}

double most(const std::vector<double>& values)
{
    return *std::max_element(values.begin(), values.end());
}

/// Brightest places in the dark room, of bakes with several seeds. Noise decides where probes are added, and with it
/// how well the ones beside the wall see it: 1 to 10 % by seed. `first`: the bake of the settings' own seed.
std::vector<double> brightestBySeed(const ProbeRooms& first, const std::filesystem::path& file, BakeSettings settings)
{
    constexpr float kFromWall = 0.02f; // metres
    constexpr int kMore = 4;
    std::vector<double> brightest = {most(first.dark(kFromWall))};
    for (int i = 0; i < kMore; ++i) {
        ++settings.seed;
        if (const auto baked = bakeFile(file, settings))
            brightest.push_back(most(ProbeRooms(baked->result.baked).dark(kFromWall)));
    }
    return brightest;
}

} // namespace

Figures measureProbes(const std::filesystem::path& assets)
{
    const std::string scene = "quality/probe_rooms.glb";
    BakeSettings settings = settingsFor(MixedLightingMode::Shadowmask, 4.0f, 16, 2);
    settings.probeSpacingMeters = 0.0f;
    auto baked = bakeFile(assets / scene, settings);
    if (!baked) return failed("probes", scene, baked.error());
    const ProbeRooms rooms(baked->result.baked);
    std::vector<double> brightest = brightestBySeed(rooms, assets / scene, settings);
    std::vector<double> dark = rooms.dark(0.25f);
    return {
        {"probes", scene, "brightest place in the dark room, 25 cm or more from the wall, of the bright room",
         most(dark), 1.0, "%"},
        {"probes", scene, "… 2 cm or more from the wall, median of five seeds", percentile(brightest, 0.5), 10.0, "%"},
        {"probes", scene, "… in a proxy volume 25 cm from the wall", most(rooms.darkVolume()), 1.0, "%"},
        {"probes", scene, "median of the dark room, of the bright room", percentile(dark, 0.5), 1.0, "%"},
        {"probes", scene, "light lost 2 cm from the wall in the bright room, of that at 25 cm",
         100.0 - rooms.brightAtWall(), 20.0, "%"},
        {"probes", scene, "valid probes outside both rooms", double(probesOutside(baked->result.baked.probes)), 0.0,
         ""},
        measureFloor(assets)};
}

} // namespace halflight::quality
