// What surfaces reflect of the reflection probes, pixel by pixel, against the formulas on the CPU.
#include "halflight/base/rgb9e5.h"
#include "halflight/shading/brdf.h"
#include "halflight/shading/directional.h"
#include "halflight/shading/indirect.h"
#include "halflight/shading/reflection.h"
#include "halflight/shading/sh.h"
#include "render/render_test.h"

#include <glm/gtc/matrix_transform.hpp>

#include <cmath>
#include <optional>

namespace halflight::test::reflections_test {
namespace {

constexpr ivec2 kSize{160, 90};
constexpr int kTile = 128;
constexpr float kUnit = 4.0f;

/// A tile whose light is linear in the direction at every level, brighter by level: filtering adds no error but that
/// of RGB9E5.
ImageRgb32f tileOf(vec3 base)
{
    ImageRgb32f tile(kTile, kTile + kTile / 2);
    for (int level = 0; level < shading::kReflectionLevels; ++level) {
        const ivec2 offset(shading::reflectionLevelOffset(kTile, level));
        const int size = shading::reflectionLevelSize(kTile, level);
        for (int y = 0; y < size; ++y)
            for (int x = 0; x < size; ++x) {
                const vec2 uv = (vec2(x, y) - 0.5f) / float(size - 2);
                const vec3 d = shading::directionFromOctahedron(glm::clamp(uv, vec2(0.0f), vec2(1.0f)));
                tile(offset.x + x, offset.y + y) = (base + 0.5f * d) * (1.0f + 0.25f * float(level)) / kUnit;
            }
    }
    return tile;
}
vec3 tileLight(vec3 base, vec3 direction, float level)
{
    return (base + 0.5f * direction) * (1.0f + 0.25f * level);
}

struct MirrorFloor {
    BakedScene baked;
    Camera camera = lookAt(vec3(0.5f, 1.2f, 1.8f), vec3(0.3f, 0, 0));
    vec3 baseColor{0.9f, 0.7f, 0.5f};
    vec3 irradiance{2.0f, 3.0f, 4.0f};

    explicit MirrorFloor(bool lightmapped = true)
    {
        const int material = addMaterial(baked.scene, vec4(baseColor, 1.0f));
        const int object = addObject(baked.scene, makeRectangle(6, 6, material), mat4(1.0f), lightmapped);
        baked.isBaked = true;
        baked.mode = MixedLightingMode::BakedIndirect;
        if (lightmapped) {
            baked.scene.objects[std::size_t(object)].lightmap.page = 0;
            baked.lightmaps = {Image<uint32_t>(4, 4, packRgb9e5(irradiance))};
        } else {
            Probe probe;
            probe.radiance[0] = irradiance / (kPi * shading::shBasis(0, vec3(0, 1, 0)));
            baked.probes.probes = {probe};
        }
        baked.reflections.size = kTile;
        baked.reflections.unitNits = kUnit;
    }
    void material(float metallic, float roughness)
    {
        baked.scene.materials[0].metallic = metallic;
        baked.scene.materials[0].roughness = roughness;
    }
    void addProbe(vec3 position, const mat4& worldFromBox, float fade, vec3 base)
    {
        ReflectionSet& set = baked.reflections;
        set.probes.push_back({position, worldFromBox, fade});
        Image<uint32_t> picture(kTile, int(set.probes.size()) * (kTile + kTile / 2));
        std::copy(set.picture.texels().begin(), set.picture.texels().end(), picture.texels().begin());
        const Image<uint32_t> tile = encodeRgb9e5(tileOf(base));
        std::copy(tile.texels().begin(), tile.texels().end(),
                  picture.texels().begin() + std::ptrdiff_t(set.picture.texelCount()));
        set.picture = std::move(picture);
        bases.push_back(base);
    }
    /// A directional lightmap whose texels trust the probes so far.
    void setTrust(uint8_t value)
    {
        trust = value;
        baked.lightmapDirections = {ImageRgba8(4, 4, stored())};
    }
    [[nodiscard]] u8vec4 stored() const
    {
        const vec3 even = shading::encodeMeanDirection(vec3(0, 2.0f / 3.0f, 0));
        return u8vec4(vec4(even, float(trust.value_or(255)) / 255.0f) * 255.0f + 0.5f);
    }
    std::vector<vec3> bases;
    std::optional<uint8_t> trust;

    /// Radiance of a point of the floor, from the formulas.
    [[nodiscard]] vec3 expected(vec3 position, vec3 view) const
    {
        using namespace shading;
        const Material& m = baked.scene.materials[0];
        const vec3 normal(0, 1, 0);
        vec3 local = irradiance / kShadingPi;
        vec3 own = local;
        if (trust) {
            // An even hemisphere of light, as setTrust() stores it.
            const vec3 mean = decodeMeanDirection(vec3(stored()) / 255.0f);
            const vec3 lobe = specularLookup(view, normal, m.roughness);
            own *= directionalSpecularScale(mean, normal, normal, view, lobe, m.roughness);
        }
        vec3 radiance(0.0f);
        vec3 rough(0.0f);
        float left = 1.0f;
        float weights = 0.0f;
        for (std::size_t i = 0; i < bases.size(); ++i) {
            const ReflectionProbe& probe = baked.reflections.probes[i];
            const mat4 box = glm::inverse(probe.worldFromBox);
            const vec3 inBox(box * vec4(position, 1.0f));
            const vec3 half(glm::length(vec3(probe.worldFromBox[0])), glm::length(vec3(probe.worldFromBox[1])),
                            glm::length(vec3(probe.worldFromBox[2])));
            const float weight = left * reflectionCoverage(inBox, half, probe.fadeMeters);
            left -= weight;
            if (weight <= 0.0f) continue;
            const auto light = [&](vec3 direction, float roughness) {
                const vec4 at =
                    lookUpReflection(position, direction, inBox, mat3(box) * direction, probe.position, roughness);
                return tileLight(bases[i], vec3(at), reflectionLevel(at.w));
            };
            radiance += weight * light(glm::reflect(-view, normal), m.roughness);
            rough += weight * light(normal, 1.0f);
            weights += weight;
        }
        if (weights <= 0.0f)
            return reflectIndirect(baseColor, m.metallic, m.roughness, m.specular, view.y, irradiance, own);
        const float share = trust ? float(*trust) / 255.0f : 1.0f;
        const vec3 surroundings =
            reflectedSurroundings(radiance / weights, rough / weights, weights, share, own, local, m.roughness);
        return reflectIndirect(baseColor, m.metallic, m.roughness, m.specular, view.y, irradiance, surroundings);
    }
    void check(const RenderedFrame& frame, float relative) const
    {
        for (const ivec2 p : {ivec2(80, 45), ivec2(30, 60), ivec2(130, 70), ivec2(60, 30)}) {
            const Ray ray = pixelRay(camera, kSize, p);
            const vec3 expectedLight = expected(onPlane(ray, 0.0f), -ray.direction);
            EXPECT_TRUE(near(vec3(frame.radiance(p.x, p.y)), expectedLight, relative)) << p.x << " " << p.y;
        }
    }
};

class ReflectionPixels : public BothPaths {
protected:
    RenderSettings settings()
    {
        RenderSettings result;
        result.path = GetParam();
        result.mode = RunMode::BakedIndirect;
        result.size = kSize;
        return result;
    }
};
INSTANTIATE_TEST_SUITE_P(, ReflectionPixels, kBothPaths, pathNameOf);

const mat4 kRoom = glm::translate(mat4(1.0f), vec3(0, 1.5f, 0)) * glm::rotate(mat4(1.0f), 0.4f, vec3(0, 1, 0)) *
                   glm::scale(mat4(1.0f), vec3(3.0f, 1.6f, 4.0f));

TEST_P(ReflectionPixels, MirrorsGlossAndDullDielectrics)
{
    for (const bool lightmapped : {true, false}) {
        for (const vec2 material : {vec2(1, 0), vec2(1, 0.35f), vec2(0, 0.2f), vec2(0, 0.6f), vec2(1, 1)}) {
            MirrorFloor floor(lightmapped);
            floor.addProbe(vec3(0.2f, 1.4f, -0.3f), kRoom, 0.1f, vec3(3, 2, 1));
            floor.material(material.x, material.y);
            floor.check(render(floor.baked, floor.camera, settings()), 8e-3f);
        }
    }
}

// Where boxes overlap the first one counts; where both end, their light fades out as the formula says.
TEST_P(ReflectionPixels, ProbesBlendInTheirOrder)
{
    MirrorFloor floor;
    floor.material(1.0f, 0.1f);
    const auto boxAt = [](float x) { return glm::scale(glm::translate(mat4(1.0f), vec3(x, 0.5f, 0)), vec3(1, 2, 4)); };
    floor.addProbe(vec3(-1, 1, 0), boxAt(-1.2f), 0.4f, vec3(6, 1, 1));
    floor.addProbe(vec3(1.2f, 1, 0), boxAt(1.2f), 0.3f, vec3(1, 6, 1));
    floor.check(render(floor.baked, floor.camera, settings()), 1e-2f);
}

// Texels of a directional lightmap say how far they trust the probes: all, half and nothing.
TEST_P(ReflectionPixels, TexelsTrustProbesAsFarAsTheySay)
{
    for (const int trust : {255, 128, 0}) {
        MirrorFloor floor;
        floor.setTrust(uint8_t(trust));
        floor.addProbe(vec3(0.2f, 1.4f, -0.3f), kRoom, 0.1f, vec3(6, 1, 3));
        floor.material(1.0f, 0.35f);
        floor.check(render(floor.baked, floor.camera, settings()), 8e-3f);
    }
}

// Where the only box ends, in the middle of the floor, its light fades out over the fade's two lengths and reaches the
// lightmap's own: no pixel differs from the next one by more than that ramp has it.
TEST_P(ReflectionPixels, ABoxEndsWithoutAnEdge)
{
    MirrorFloor floor;
    floor.material(1.0f, 0.3f);
    constexpr float kFade = 0.5f;
    floor.addProbe(vec3(-1, 1, 0), glm::scale(glm::translate(mat4(1.0f), vec3(-3, 0.5f, 0)), vec3(3, 2, 4)), kFade,
                   vec3(9, 9, 9));
    floor.camera = lookAt(vec3(0.6f, 3.0f, 0.01f), vec3(0.6f, 0, 0));
    const RenderedFrame frame = render(floor.baked, floor.camera, settings());
    const auto light = [&](int x) { return luminance(vec3(frame.radiance(x, kSize.y / 2))); };
    const auto metres = [&](int x) { return onPlane(pixelRay(floor.camera, kSize, {x, kSize.y / 2}), 0.0f).x; };
    float within = 0.0f;
    float beyond = 0.0f;
    float steepest = 0.0f;                                  // nits per metre
    for (int x = 1; x < kSize.x && metres(x) < 2.0f; ++x) { // the floor itself ends beyond
        const float step = std::abs(light(x) - light(x - 1));
        steepest = std::max(steepest, step / std::abs(metres(x) - metres(x - 1)));
        if (metres(x) < 0.0f) within = light(x);
        if (metres(x) > 2.0f * kFade && beyond == 0.0f) beyond = light(x);
    }
    ASSERT_GT(within, 1.5f * beyond) << "the probe is brighter than the lightmap";
    // The blend is at most as steep as a ramp over two thirds of a fade, and the probe's light varies a little besides.
    EXPECT_LT(steepest, 2.0f * (within - beyond) / kFade);
    EXPECT_NEAR(beyond, luminance(floor.expected(vec3(2.0f * kFade + 0.05f, 0, 0), vec3(0, 1, 0))), 0.05f * beyond);
}

TEST_P(ReflectionPixels, OffAndRealtimeHaveNone)
{
    MirrorFloor floor;
    floor.material(1.0f, 0.0f);
    floor.addProbe(vec3(0, 1, 0), kRoom, 0.1f, vec3(9, 9, 9));
    floor.baked.scene.sky = {vec3(1.0f), vec3(1.0f), vec3(1.0f)};
    const Ray ray = pixelRay(floor.camera, kSize, kSize / 2);
    RenderSettings off = settings();
    off.reflectionProbes = false;
    const vec3 share = shading::environmentSpecular(floor.baseColor, 1.0f, 0.0f, -ray.direction.y);
    EXPECT_TRUE(near(vec3(render(floor.baked, floor.camera, off).radiance(80, 45)), share * floor.irradiance / kPi));
    RenderSettings realtime = settings();
    realtime.mode = RunMode::Realtime;
    EXPECT_TRUE(near(vec3(render(floor.baked, floor.camera, realtime).radiance(80, 45)), share));
}

} // namespace
} // namespace halflight::test::reflections_test
