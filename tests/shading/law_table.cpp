// Prints inputs and outputs of the formulas that a runtime needs, as JSON: assets/conformance/law.json is what it
// prints (docs/conformance.md). A case is the list of a function's arguments, vectors as lists, and its result at the
// end.

#include "halflight/shading/directional.h"
#include "halflight/shading/law.h"
#include "halflight/shading/light.h"
#include "halflight/shading/mask.h"
#include "halflight/shading/random.h"
#include "halflight/shading/sh.h"
#include "halflight/shading/sight.h"
#include "halflight/shading/sky.h"

#include <algorithm>
#include <cstdio>
#include <string>
#include <vector>

namespace {

using namespace halflight;
using namespace halflight::shading;

/// Random numbers that are the same everywhere.
class Numbers {
public:
    explicit Numbers(uint32_t seed) : state_(seed) {}
    /// In steps of 1/256 of the range, so that they are exact in every language.
    float in(float low, float high)
    {
        state_ = hashCombine(state_, 1u);
        return low + (high - low) * float(state_ % 257u) / 256.0f;
    }
    /// 0 and 1 twice as often as all between.
    float share()
    {
        const float x = in(-1.0f, 2.0f);
        return std::clamp(x, 0.0f, 1.0f);
    }
    bool flag() { return in(0.0f, 1.0f) < 0.5f; }
    int mode() { return int(in(0.0f, 4.999f)); }
    vec3 color(float most)
    {
        const float r = in(0.0f, most);
        const float g = in(0.0f, most);
        return {r, g, in(0.0f, most)};
    }
    vec3 direction()
    {
        for (;;) {
            const float x = in(-1.0f, 1.0f);
            const float y = in(-1.0f, 1.0f);
            const vec3 d(x, y, in(-1.0f, 1.0f));
            if (glm::dot(d, d) > 0.01f) return glm::normalize(d);
        }
    }

private:
    uint32_t state_;
};

std::string text(float value)
{
    char buffer[32];
    std::snprintf(buffer, sizeof(buffer), "%.9g", double(value));
    return buffer;
}
std::string text(int value)
{
    return std::to_string(value);
}
std::string text(bool value)
{
    return value ? "true" : "false";
}
template<glm::length_t N> std::string text(const glm::vec<N, float>& v)
{
    std::string result = "[";
    for (glm::length_t i = 0; i < N; ++i) result += (i > 0 ? "," : "") + text(v[i]);
    return result + "]";
}

/// One function of the table.
class Function {
public:
    Function(const char* name, const char* header, std::vector<std::string> arguments, bool first = false)
    {
        std::printf("%s  {\"name\": \"%s\", \"header\": \"halflight/shading/%s\", \"arguments\": [", first ? "" : ",\n",
                    name, header);
        for (std::size_t i = 0; i < arguments.size(); ++i)
            std::printf("%s\"%s\"", i > 0 ? ", " : "", arguments[i].c_str());
        std::printf("], \"cases\": [");
    }
    ~Function() { std::printf("\n  ]}"); }
    Function(const Function&) = delete;
    Function& operator=(const Function&) = delete;

    template<typename... Values> void add(const Values&... values)
    {
        std::string line;
        ((line += (line.empty() ? "" : ",") + text(values)), ...);
        std::printf("%s\n    [%s]", any_ ? "," : "", line.c_str());
        any_ = true;
    }

private:
    bool any_ = false;
};

void lawOfMixing(int cases)
{
    Numbers n(1);
    {
        Function f("mixShadows", "law.h", {"mode", "hasBaked", "baked", "hasRealtime", "realtime", "fade", "strength"},
                   true);
        for (int i = 0; i < 4 * cases; ++i) {
            const int mode = n.mode();
            const bool hasBaked = n.flag();
            const float baked = n.share();
            const bool hasRealtime = n.flag();
            const float realtime = n.share();
            const float fade = n.share();
            const float strength = n.share();
            f.add(mode, hasBaked, baked, hasRealtime, realtime, fade, strength,
                  mixShadows(mode, hasBaked, baked, hasRealtime, realtime, fade, strength));
        }
    }
    {
        Function f("subtractiveIrradiance", "law.h",
                   {"lightmap", "mainIrradiance", "baked", "faded", "shadowColor", "strength"});
        for (int i = 0; i < cases; ++i) {
            const vec3 lightmap = n.color(8.0f);
            const vec3 main = n.color(8.0f);
            const float baked = n.share();
            const float faded = n.share();
            const vec3 shadow = n.color(2.0f);
            const float strength = n.share();
            f.add(lightmap, main, baked, faded, shadow, strength,
                  subtractiveIrradiance(lightmap, main, baked, faded, shadow, strength));
        }
    }
    {
        Function f("shadowFade", "law.h", {"cameraDistance", "fadeConstants"});
        for (int i = 0; i < cases; ++i) {
            const vec2 constants = fadeConstants(n.in(1.0f, 100.0f), n.in(0.5f, 20.0f));
            const float distance = n.in(0.0f, 120.0f);
            f.add(distance, constants, shadowFade(distance, constants));
        }
    }
    {
        Function f("bakedWithinReach", "law.h", {"baked", "distanceMeters", "reachMeters", "cosAngle", "cosCone"});
        for (int i = 0; i < cases; ++i) {
            const float baked = n.share();
            const float distance = n.in(0.0f, 20.0f);
            const float reach = n.flag() ? 0.0f : n.in(1.0f, 20.0f);
            const float angle = n.in(-1.0f, 1.0f);
            const float cone = n.flag() ? -2.0f : n.in(-1.0f, 1.0f);
            f.add(baked, distance, reach, angle, cone, bakedWithinReach(baked, distance, reach, angle, cone));
        }
    }
}

void lawByColor(int cases)
{
    Numbers m(6);
    {
        Function f("mixShadowsByColor", "law.h",
                   {"mode", "hasBaked", "baked", "hasRealtime", "realtime", "fade", "strength"});
        for (int i = 0; i < cases; ++i) {
            const int mode = m.mode();
            const bool hasBaked = m.flag();
            const vec3 baked = m.color(1.0f);
            const bool hasRealtime = m.flag();
            const float realtime = m.share();
            const float fade = m.share();
            const float strength = m.share();
            f.add(mode, hasBaked, baked, hasRealtime, realtime, fade, strength,
                  mixShadowsByColor(mode, hasBaked, baked, hasRealtime, realtime, fade, strength));
        }
    }
    {
        Function f("subtractiveIrradianceByColor", "law.h",
                   {"lightmap", "mainIrradiance", "baked", "faded", "shadowColor", "strength"});
        for (int i = 0; i < cases; ++i) {
            const vec3 lightmap = m.color(8.0f);
            const vec3 main = m.color(8.0f);
            const vec3 baked = m.color(1.0f);
            const float faded = m.share();
            const vec3 shadow = m.color(2.0f);
            const float strength = m.share();
            f.add(lightmap, main, baked, faded, shadow, strength,
                  subtractiveIrradianceByColor(lightmap, main, baked, faded, shadow, strength));
        }
    }
}

void storedLight(int cases)
{
    Numbers n(2);
    {
        Function f("decodeMask", "mask.h", {"stored", "rangeTexels", "penumbraTexels", "footprintTexels"});
        for (int i = 0; i < cases; ++i) {
            const float stored = n.share();
            const float range = n.flag() ? 0.0f : n.in(1.0f, 8.0f);
            const float penumbra = n.in(0.0f, 2.0f);
            const float footprint = n.in(0.0f, 4.0f);
            f.add(stored, range, penumbra, footprint, decodeMask(stored, range, penumbra, footprint));
        }
    }
    {
        Function f("directionalIrradianceScale", "directional.h", {"meanDirection", "bakedNormal", "normal"});
        for (int i = 0; i < cases; ++i) {
            const vec3 baked = n.direction();
            const vec3 mean = glm::normalize(baked + 0.7f * n.direction()) * n.in(0.0f, 1.0f);
            const vec3 normal = glm::normalize(baked + 0.8f * n.direction());
            f.add(mean, baked, normal, directionalIrradianceScale(mean, baked, normal));
        }
    }
    {
        Function f("directionalSpecularScale", "directional.h",
                   {"meanDirection", "bakedNormal", "normal", "view", "lobe", "roughness"});
        Numbers m(5);
        for (int i = 0; i < cases; ++i) {
            const vec3 baked = m.direction();
            const vec3 mean = glm::normalize(baked + 0.7f * m.direction()) * m.in(0.0f, 1.0f);
            const vec3 normal = glm::normalize(baked + 0.5f * m.direction());
            const vec3 view = glm::normalize(normal + 0.9f * m.direction());
            const vec3 lobe = glm::normalize(normal + 0.9f * m.direction());
            const float roughness = m.in(0.1f, 1.0f);
            f.add(mean, baked, normal, view, lobe, roughness,
                  directionalSpecularScale(mean, baked, normal, view, lobe, roughness));
        }
    }
    {
        Function f("shIrradianceWeight", "sh.h", {"i", "n"});
        for (int i = 0; i < cases; ++i) {
            const vec3 normal = n.direction();
            f.add(i % 9, normal, shIrradianceWeight(i % 9, normal));
        }
    }
    {
        Function f("skyRadiance", "sky.h", {"zenith", "horizon", "ground", "d"});
        for (int i = 0; i < cases; ++i) {
            const vec3 zenith = n.color(4.0f);
            const vec3 horizon = n.color(4.0f);
            const vec3 ground = n.color(4.0f);
            const vec3 d = n.direction();
            f.add(zenith, horizon, ground, d, skyRadiance(zenith, horizon, ground, d));
        }
    }
}

void lights(int cases)
{
    Numbers n(3);
    {
        Function f("distanceAttenuation", "light.h", {"distanceMeters", "rangeMeters"});
        for (int i = 0; i < cases; ++i) {
            const float distance = n.in(0.0f, 12.0f);
            const float range = n.flag() ? 0.0f : n.in(1.0f, 10.0f);
            f.add(distance, range, distanceAttenuation(distance, range));
        }
    }
    Function f("spotAttenuation", "light.h", {"cosAngle", "spotConstants"});
    for (int i = 0; i < cases; ++i) {
        const float outer = n.in(0.1f, 1.5f);
        const vec2 constants = spotConstants(outer * n.in(0.0f, 1.0f), outer);
        const float angle = n.in(-0.2f, 1.0f);
        f.add(angle, constants, spotAttenuation(angle, constants));
    }
}

void sight(int cases)
{
    Numbers n(4);
    {
        Function f("octahedralX", "sight.h", {"d"});
        for (int i = 0; i < cases; ++i) {
            const vec3 d = n.direction();
            f.add(d, octahedralX(d));
        }
    }
    {
        Function f("octahedralY", "sight.h", {"d"});
        for (int i = 0; i < cases; ++i) {
            const vec3 d = n.direction();
            f.add(d, octahedralY(d));
        }
    }
    {
        Function f("octahedralShare", "sight.h", {"column", "row", "u", "v", "mirrored"});
        for (int i = 0; i < cases; ++i) {
            const float u = n.share();
            const float v = n.share();
            const bool mirrored = n.flag();
            f.add(i % 2, i / 2 % 2, u, v, mirrored, octahedralShare(i % 2, i / 2 % 2, u, v, mirrored));
        }
    }
    Function f("probeSight", "sight.h", {"nearness", "variance", "pointNearness"});
    for (int i = 0; i < cases; ++i) {
        const float nearness = n.in(1.0f, 8.0f);
        const float variance = n.flag() ? 0.0f : n.in(0.0f, 1.0f);
        const float point = n.in(1.0f, 8.0f);
        f.add(nearness, variance, point, probeSight(nearness, variance, point));
    }
}

} // namespace

int main()
{
    constexpr int kCases = 64; // of each function
    std::printf("{\"version\": 1, \"relativeTolerance\": 1e-4, \"absoluteTolerance\": 1e-5, \"functions\": [\n");
    lawOfMixing(kCases);
    lawByColor(kCases);
    storedLight(kCases);
    lights(kCases);
    sight(kCases);
    std::printf("\n]}\n");
    return 0;
}
