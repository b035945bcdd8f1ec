#pragma once
// A floor in four columns: lit; in static shadow; in dynamic shadow; in both. What the law makes of it is known at
// every point, near the camera, within the fade, and beyond the shadow distance.
#include "render/render_test.h"

#include <array>
#include <functional>
#include <vector>

namespace halflight::test::law {

inline constexpr ivec2 kSize{384, 216};
inline constexpr float kShadowDistance = 30.0f;
inline constexpr float kFadeRange = 10.0f;
inline constexpr float kSunLux = 3.0f;
/// 51 / 255 exactly: a baked penumbra, so that min and lerp differ.
inline constexpr float kBakedShadow = 0.2f;
inline constexpr std::array<float, 4> kColumns{-6.0f, -2.0f, 2.0f, 6.0f};
inline constexpr std::array<const char*, 4> kColumnNames{"lit", "static shadow", "dynamic shadow", "both shadows"};
/// Rows of the floor: two near, nine within the fade, two beyond the shadow distance.
inline constexpr std::array<float, 13> kDepths{-12.0f, -15.0f, -21.0f, -22.0f, -23.0f, -24.0f, -25.0f,
                                               -26.0f, -27.0f, -28.0f, -28.6f, -34.0f, -42.0f};
inline const vec3 kToSun = glm::normalize(vec3(0.2f, 1.0f, 0.1f));
inline const vec3 kAlbedo(0.8f, 0.5f, 0.25f);
/// Rasterizers snap corners to 1/256 pixel, which moves a fragment by millimetres here, and t with it.
inline constexpr float kAbsolute = 2.0e-4f;

constexpr bool inStaticShadow(int column)
{
    return column == 1 || column == 3;
}
constexpr bool inDynamicShadow(int column)
{
    return column >= 2;
}
/// R by geometry: which slabs are in the sun's shadow map in this mode (spec section 2, last paragraph of the law).
float realtimeOf(RunMode mode, int column);
/// Lightmap of a column: values that RGB9E5 holds exactly.
vec3 lightmapOf(int column);

struct LawScene {
    BakedScene baked;
    int floor = -1;
    std::vector<int> blockers;
    ImageRgba8 mask; ///< of the floor's page
};
/// The floor's page holds it in its middle half, so that scale and offset count; the rest has other values.
LawScene makeScene(MixedLightingMode bakeMode);
/// Gives a subtractive scene the main light's own mask.
void addMainLightMask(LawScene& law);
MixedLightingMode bakeModeFor(RunMode mode);
Camera makeCamera();
RenderSettings settingsFor(RunMode mode, RenderPath path = RenderPath::Forward);

/// A point of the floor in a column, with the pixel that shows it.
struct Site {
    int column;
    ivec2 pixel;
    ShadedPoint point;
    float fade;
};
/// Every column in every row.
std::vector<Site> sites();
/// Checks all of them against what is expected of each.
void expectSites(const RenderedFrame& frame, const std::function<vec3(const Site&)>& expected);

/// The law as section 2 of the specification puts it, written out a second time on purpose: a picture is compared with
/// this, not with the code that made it.
float attenuationByHand(RunMode mode, bool hasBaked, float baked, bool hasRealtime, float realtime, float fade,
                        float strength);
vec3 subtractiveByHand(vec3 lightmap, vec3 mainIrradiance, float realtime, float fade, vec3 shadowColor, float strength,
                       float baked = 1.0f);

} // namespace halflight::test::law
