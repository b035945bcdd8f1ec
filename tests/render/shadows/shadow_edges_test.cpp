// S2. Cascaded shadows to the texel: filters, blends between cascades, rest while the camera moves, and biases that
// show neither acne nor a gap at a caster's foot.
#include "render/render_test.h"

#include <glm/gtc/matrix_transform.hpp>

#include <cmath>

namespace halflight::test::shadow_edges_test {
namespace {

constexpr ivec2 kSize{320, 180};
const vec3 kAlbedo(0.5f);

const char* filterName(ShadowFilter filter)
{
    const char* names[] = {"Hard", "Pcf", "Soft"};
    return names[int(filter)];
}
const char* blendName(CascadeBlend blend)
{
    const char* names[] = {"Hard", "Dithered", "Soft"};
    return names[int(blend)];
}

/// Where the slab's edge is: on no cascade's grid of texels, which all have a line at x = 0.
constexpr float kEdge = 0.1131f;

/// A long floor under a sun straight above, and a slab 2 m up whose edge runs along the view: left of it lit, right of
/// it in shadow. Shadow map columns run along the edge too, so R across it is the filter itself.
struct EdgeScene {
    BakedScene baked;
    Camera camera = lookAt(vec3(-1.0f, 3.0f, 0), vec3(-0.2f, 0, -9), 1.2f);

    EdgeScene()
    {
        Scene& scene = baked.scene;
        const int material = addMaterial(scene, vec4(kAlbedo, 1.0f));
        addObject(scene, makeRectangle(60, 120, material), glm::translate(mat4(1.0f), vec3(0, 0, -50)), true);
        addObject(scene, makeRectangle(8, 120, material), glm::translate(mat4(1.0f), vec3(kEdge + 4, 2, -50)), true);
        scene.lights.push_back(directionalLight(vec3(0, 1, 0), 3.0f));
    }
};

/// Texels across the edge: the shadow map's column coordinate of a place, and which way it runs.
float columnOf(const ShadowTile& tile, vec3 world)
{
    return ((tile.clipFromWorld * vec4(world, 1.0f)).x * 0.5f + 0.5f) * float(tile.size);
}
float rowOf(const ShadowTile& tile, vec3 world)
{
    return ((tile.clipFromWorld * vec4(world, 1.0f)).y * 0.5f + 0.5f) * float(tile.size);
}

/// R at a floor point by that tile: texels are shadowed whose centres lie under the slab, and a tent of the filter's
/// half width in texels weighs them (Hard: the texel the point falls in).
float realtimeByHand(const ShadowTile& tile, ShadowFilter filter, vec3 point)
{
    const bool alongColumns = std::abs(tile.clipFromWorld[0].x) > std::abs(tile.clipFromWorld[0].y);
    const auto coordinate = [&](vec3 p) { return alongColumns ? columnOf(tile, p) : rowOf(tile, p); };
    const float edge = coordinate(vec3(kEdge, 0, 0));
    const float shadowSide = coordinate(vec3(kEdge + 1, 0, 0)) > edge ? 1.0f : -1.0f;
    const float at = coordinate(point);
    const auto lit = [&](float center) { return (center - edge) * shadowSide > 0.0f ? 0.0f : 1.0f; };
    if (filter == ShadowFilter::Hard) return lit(std::floor(at) + 0.5f);
    const float halfWidth = filter == ShadowFilter::Pcf ? 2.0f : 4.0f;
    float sum = 0.0f;
    for (float center = std::floor(at) - 8.5f; center < at + 9.0f; center += 1.0f)
        sum += std::max(0.0f, 1.0f - std::abs(center - at) / halfWidth) / halfWidth * lit(center);
    return sum;
}

/// What a pixel shows of R: its radiance by the lit one's.
struct EdgePixel {
    vec3 point;
    float distance;
    float realtime;
};
std::vector<EdgePixel> edgePixels(const EdgeScene& edge, const RenderedFrame& frame, float reach)
{
    std::vector<EdgePixel> result;
    for (int y = 0; y < kSize.y; ++y)
        for (int x = 0; x < kSize.x; ++x) {
            const Ray ray = pixelRay(edge.camera, kSize, {x, y});
            if (ray.direction.y > -0.08f) continue;
            const ShadedPoint point{onPlane(ray, 0.0f), vec3(0, 1, 0), -ray.direction, kAlbedo};
            if (std::abs(point.position.x) > reach || point.position.z < -100.0f) continue;
            // The slab hides what lies behind it.
            const vec3 onSlab = onPlane(ray, 2.0f);
            if (onSlab.x > kEdge - 0.01f && onSlab.x < kEdge + 8.0f) continue;
            const float full = directRadiance(point, edge.baked.scene.lights[0], 1.0f).x;
            result.push_back(
                {point.position, glm::distance(ray.origin, point.position), frame.radiance(x, y).x / full});
        }
    return result;
}

/// Weight of the next cascade: 0 before the last tenth of this one, 1 at its end.
float blendWeight(const FramePlan& plan, const ShadowSettings& settings, int cascade, float distance)
{
    if (cascade + 1 >= settings.cascades) return 0.0f;
    const float end = plan.cascadeFar[std::size_t(cascade)];
    const float begin = end * (1.0f - settings.cascadeBlendFraction);
    return glm::clamp((distance - begin) / (end - begin), 0.0f, 1.0f);
}

int cascadeAt(const FramePlan& plan, const ShadowSettings& settings, float distance)
{
    int cascade = 0;
    while (cascade + 1 < settings.cascades && distance > plan.cascadeFar[std::size_t(cascade)]) ++cascade;
    return cascade;
}

class ShadowEdgesS2 : public RenderTest,
                      public testing::WithParamInterface<std::tuple<ShadowFilter, CascadeBlend, RenderPath>> {};
INSTANTIATE_TEST_SUITE_P(
    , ShadowEdgesS2,
    testing::Combine(testing::Values(ShadowFilter::Hard, ShadowFilter::Pcf, ShadowFilter::Soft),
                     testing::Values(CascadeBlend::Hard, CascadeBlend::Dithered, CascadeBlend::Soft), kBothPaths),
    [](const auto& info) {
        return std::string(filterName(std::get<0>(info.param))) + blendName(std::get<1>(info.param)) + "Blend" +
               pathName(std::get<2>(info.param));
    });

// Every pixel of the edge, through 1 to 4 cascades: the tent of the cascade that the distance chooses, and where two
// meet the next one's by weight (soft), by chance (dithered) or not at all (hard). The sum of all weights is tested
// with it.
TEST_P(ShadowEdgesS2, FilterAndBlendAreExact)
{
    const auto [filter, blend, path] = GetParam();
    EdgeScene edge;
    for (int cascades = 1; cascades <= 4; ++cascades) {
        RenderSettings settings;
        settings.path = path;
        settings.size = kSize;
        settings.shadows.cascades = cascades;
        settings.shadows.filter = filter;
        settings.shadows.cascadeBlend = blend;
        settings.shadows.cascadeBlendFraction = 0.3f;
        settings.shadows.distanceMeters = 40.0f;
        settings.shadows.directionalMapSize = 256;
        const RenderedFrame frame = render(edge.baked, edge.camera, settings);
        ASSERT_TRUE(frame.plan.lights[0].hasRealtimeShadow);
        ASSERT_EQ(frame.plan.lights[0].tileCount, cascades);

        int checked = 0;
        int partial = 0; // neither lit nor dark
        int wrong = 0;
        int blended = 0;
        int ditheredToNext = 0;
        double ditherWeight = 0.0;
        for (const EdgePixel& pixel : edgePixels(edge, frame, 2.0f)) {
            if (pixel.distance > 38.0f) continue; // the fade begins at 39 m
            const int cascade = cascadeAt(frame.plan, settings.shadows, pixel.distance);
            const float weight = blendWeight(frame.plan, settings.shadows, cascade, pixel.distance);
            const ShadowTile& tile = frame.plan.tiles[std::size_t(cascade)];
            // Interpolated positions differ from the ray's by fractions of a millimetre; a step may be on either side.
            const vec3 nudge(2.0e-3f, 0, 0);
            const auto range = [&](const ShadowTile& t) {
                const float a = realtimeByHand(t, filter, pixel.point - nudge);
                const float b = realtimeByHand(t, filter, pixel.point + nudge);
                return vec2(std::min(a, b), std::max(a, b));
            };
            vec2 expected = range(tile);
            constexpr float kTolerance = 0.01f; // texture filtering has 8 bits
            const auto isIn = [&](vec2 r) {
                return pixel.realtime >= r.x - kTolerance && pixel.realtime <= r.y + kTolerance;
            };
            bool right = isIn(expected);
            if (weight > 0.0f && blend != CascadeBlend::Hard) {
                const vec2 next = range(frame.plan.tiles[std::size_t(cascade) + 1]);
                if (blend == CascadeBlend::Soft) {
                    right = isIn(glm::mix(expected, next, weight));
                } else {
                    const bool canTell = next.x > expected.y + 0.05f || next.y < expected.x - 0.05f;
                    if (canTell) {
                        ++blended;
                        ditherWeight += double(weight);
                        ditheredToNext += isIn(next) ? 1 : 0;
                    }
                    right = right || isIn(next);
                }
            }
            ++checked;
            partial += expected.x > 0.02f && expected.y < 0.98f ? 1 : 0;
            if (!right && wrong++ < 3)
                ADD_FAILURE() << cascades << " cascades, " << cascade << " at x " << pixel.point.x << " distance "
                              << pixel.distance << ": " << pixel.realtime << ", expected " << expected.x << "…"
                              << expected.y << ", weight of the next " << weight;
        }
        EXPECT_EQ(wrong, 0) << "of " << checked;
        EXPECT_GT(checked, 2000);
        if (filter != ShadowFilter::Hard) EXPECT_GT(partial, 100);
        if (blend == CascadeBlend::Dithered && cascades > 1 && blended > 60) {
            EXPECT_NEAR(double(ditheredToNext) / blended, ditherWeight / blended, 0.15) << blended << " pixels";
        }
    }
}

class ShadowFiltersS2 : public RenderTest, public testing::WithParamInterface<std::tuple<ShadowFilter, RenderPath>> {};
INSTANTIATE_TEST_SUITE_P(, ShadowFiltersS2,
                         testing::Combine(testing::Values(ShadowFilter::Hard, ShadowFilter::Pcf, ShadowFilter::Soft),
                                          kBothPaths),
                         [](const auto& info) {
                             return std::string(filterName(std::get<0>(info.param))) +
                                    pathName(std::get<1>(info.param));
                         });

// The camera creeps by parts of a texel: the edge stays where it was in the world, to the value.
TEST_P(ShadowFiltersS2, EdgesRestWhileTheCameraCreeps)
{
    const auto [filter, path] = GetParam();
    EdgeScene edge;
    RenderSettings settings;
    settings.path = path;
    settings.size = kSize;
    settings.shadows.filter = filter;
    settings.shadows.cascadeBlend = CascadeBlend::Hard;
    settings.shadows.cascades = 2;
    settings.shadows.distanceMeters = 40.0f;
    settings.shadows.directionalMapSize = 256;
    FramePlan first;
    const mat4 start = edge.camera.worldFromCamera;
    for (int step = 0; step < 7; ++step) {
        edge.camera.worldFromCamera = glm::translate(mat4(1.0f), 0.017f * float(step) * vec3(1, 0.1f, 0.4f)) * start;
        const RenderedFrame frame = render(edge.baked, edge.camera, settings);
        if (step == 0) first = frame.plan;
        int wrong = 0;
        int checked = 0;
        for (const EdgePixel& pixel : edgePixels(edge, frame, 1.0f)) {
            if (pixel.distance > 38.0f) continue;
            // By the first frame's tile: another frame's may be off by whole texels only.
            const ShadowTile& tile = first.tiles[std::size_t(cascadeAt(frame.plan, settings.shadows, pixel.distance))];
            const float a = realtimeByHand(tile, filter, pixel.point - vec3(3.0e-3f, 0, 0));
            const float b = realtimeByHand(tile, filter, pixel.point + vec3(3.0e-3f, 0, 0));
            wrong += pixel.realtime < std::min(a, b) - 0.012f || pixel.realtime > std::max(a, b) + 0.012f ? 1 : 0;
            ++checked;
        }
        EXPECT_EQ(wrong, 0) << "step " << step << " of " << checked;
        EXPECT_GT(checked, 1000);
    }
}

// Planes cast into their own shadow maps and are lit all the same, whatever the sun's height and azimuth and their own
// tilt: no pixel has acne with the default biases. Each path has half of the azimuths.
TEST_P(ShadowFiltersS2, NoAcneOnPlanesAtAnySunAngle)
{
    const auto [filter, path] = GetParam();
    const float tilts[] = {0.0f, 0.5f, 1.2f};
    const bool forward = path == RenderPath::Forward;
    for (const float elevation : {3.0f, 8.0f, 20.0f, 45.0f, 70.0f, 90.0f}) {
        for (const float azimuth : {forward ? 0.0f : 90.0f, forward ? 201.0f : 37.0f}) {
            BakedScene baked;
            Scene& scene = baked.scene;
            const int material = addMaterial(scene, vec4(kAlbedo, 1.0f));
            for (int i = 0; i < 3; ++i) { // side by side, far apart: none shades another
                const mat4 pose = glm::translate(mat4(1.0f), vec3(40.0f * float(i), 0, 0)) *
                                  glm::rotate(mat4(1.0f), tilts[i], glm::normalize(vec3(1, 0, 0.3f)));
                addObject(scene, makeRectangle(12, 12, material), pose, true);
                scene.objects.back().castShadows = true;
            }
            const float e = glm::radians(elevation);
            const float a = glm::radians(azimuth);
            const vec3 toSun(std::cos(e) * std::cos(a), std::sin(e), std::cos(e) * std::sin(a));
            scene.lights.push_back(directionalLight(toSun, 3.0f));
            for (int i = 0; i < 3; ++i) {
                const vec3 normal(mat3(scene.objects[std::size_t(i)].worldFromObject) * vec3(0, 1, 0));
                if (glm::dot(normal, toSun) < 0.03f) continue; // in its own shade, or along the light
                for (std::size_t other = 0; other < 3; ++other) scene.objects[other].castShadows = int(other) == i;
                const vec3 middle(40.0f * float(i), 0, 0);
                const Camera camera = lookAt(middle + normal * 6.0f + vec3(0, 2.0f, 7.0f), middle);
                RenderSettings settings;
                settings.path = path;
                settings.size = {160, 90};
                settings.shadows.filter = filter;
                const RenderedFrame frame = render(baked, camera, settings);
                ASSERT_TRUE(frame.plan.lights[0].hasRealtimeShadow);
                int dark = 0;
                int checked = 0;
                float worst = 1.0f;
                for (int y = 0; y < 90; y += 1)
                    for (int x = 0; x < 160; x += 1) {
                        const Ray ray = pixelRay(camera, {160, 90}, {x, y});
                        const float reach = glm::dot(middle - ray.origin, normal) / glm::dot(ray.direction, normal);
                        const vec3 p = ray.origin + ray.direction * reach;
                        const vec3 local(glm::inverse(scene.objects[std::size_t(i)].worldFromObject) * vec4(p, 1.0f));
                        if (!(reach > 0.0f) || std::max(std::abs(local.x), std::abs(local.z)) > 5.9f) continue;
                        const ShadedPoint point{p, normal, -ray.direction, kAlbedo};
                        const float full = directRadiance(point, scene.lights[0], 1.0f).x;
                        const float seen = frame.radiance(x, y).x / full;
                        dark += seen < 0.995f ? 1 : 0;
                        worst = std::min(worst, seen);
                        ++checked;
                    }
                EXPECT_EQ(dark, 0) << "of " << checked << " at elevation " << elevation << " azimuth " << azimuth
                                   << " tilt " << tilts[i] << ", worst " << worst;
                EXPECT_GT(checked, 500);
            }
        }
    }
}

// A wall on the floor: from its foot on the floor is dark, but for what a filter's kernel and the biases may let
// through, which is measured in texels and, near the camera, in centimetres.
TEST_P(ShadowFiltersS2, ShadowBeginsAtTheWallsFoot)
{
    const auto [filter, path] = GetParam();
    BakedScene baked;
    Scene& scene = baked.scene;
    const int material = addMaterial(scene, vec4(kAlbedo, 1.0f));
    scene.materials[std::size_t(material)].doubleSided = true;
    addObject(scene, makeRectangle(20, 20, material), mat4(1.0f), true);
    // In the plane x = 0, from the floor to 2 m: thinner than any texel.
    const mat4 upright = glm::translate(mat4(1.0f), vec3(0, 1, 0)) * glm::rotate(mat4(1.0f), kPi / 2.0f, vec3(0, 0, 1));
    addObject(scene, makeRectangle(2, 8, material), upright, true);
    for (const float elevation : {20.0f, 45.0f, 70.0f}) {
        const float e = glm::radians(elevation);
        scene.lights = {directionalLight(vec3(-std::cos(e), std::sin(e), 0.0f), 3.0f)}; // shadow towards +x
        const Camera camera = lookAt(vec3(2.0f, 2.5f, 3.0f), vec3(0.2f, 0, 0), 0.7f);
        RenderSettings settings;
        settings.path = path;
        settings.size = kSize;
        settings.shadows.filter = filter;
        const RenderedFrame frame = render(baked, camera, settings);
        const float texel = frame.plan.tiles[0].texelMeters;
        float gap = 0.0f; // the farthest point from the foot that is lit by more than a tenth
        int dark = 0;
        for (int y = 0; y < kSize.y; ++y)
            for (int x = 0; x < kSize.x; ++x) {
                const Ray ray = pixelRay(camera, kSize, {x, y});
                const ShadedPoint point{onPlane(ray, 0.0f), vec3(0, 1, 0), -ray.direction, kAlbedo};
                // Within the shadow, clear of its other end and of the wall's ends.
                const float end = 2.0f / std::tan(e) - 8.0f * texel;
                if (point.position.x < 2.0e-3f || point.position.x > std::min(end, 0.6f)) continue;
                if (std::abs(point.position.z) > 1.0f) continue;
                // Within the first cascade, whose texel counts below.
                if (glm::distance(ray.origin, point.position) > 0.85f * frame.plan.cascadeFar[0]) continue;
                const float seen = frame.radiance(x, y).x / directRadiance(point, scene.lights[0], 1.0f).x;
                if (seen > 0.1f) gap = std::max(gap, point.position.x);
                dark += seen <= 0.1f ? 1 : 0;
            }
        EXPECT_GT(dark, 300);
        // Across the light's direction a texel spans texel / sin(e) of the floor at most.
        // The normal bias counts most under a low sun, where 0.6 texels more than the filter's are let through.
        const float reach = float(filterReachTexels(filter)) / 2.0f + (elevation < 30.0f ? 0.6f : 2.5f);
        EXPECT_LE(gap, reach * texel / std::sin(e)) << "elevation " << elevation << ", texel " << texel;
        EXPECT_LE(gap, 0.05f) << "elevation " << elevation << ", texel " << texel;
    }
}

} // namespace
} // namespace halflight::test::shadow_edges_test
