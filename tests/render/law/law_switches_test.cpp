// The law where a light, an object or a material switches shadows off (spec S20, S30).
#include "render/law/law_modes.h"

#include <utility>

namespace halflight::test::law_switches_test {
namespace {

using namespace law;

/// A light whose shadows are off has no shadow of any kind (spec section 4): static and dynamic receivers.
class LightWithoutShadowsS20 : public RenderTest, public testing::WithParamInterface<ModePath> {};
INSTANTIATE_TEST_SUITE_P(, LightWithoutShadowsS20, testing::Combine(kAllModes, kBothPaths), modePathName);

TEST_P(LightWithoutShadowsS20, NeitherBakedNorRealtime)
{
    const auto [mode, path] = GetParam();
    for (const bool byStrength : {false, true}) {
        for (const bool isDynamic : {false, true}) {
            LawScene law = makeScene(bakeModeFor(mode));
            if (isDynamic) makeFloorDynamic(law);
            Light& sun = law.baked.scene.lights[0];
            if (byStrength)
                sun.shadowStrength = 0.0f;
            else
                sun.castShadows = false;
            const RenderedFrame frame = render(law.baked, makeCamera(), settingsFor(mode, path));
            EXPECT_FALSE(frame.plan.usesMask);
            EXPECT_FALSE(frame.forwardReadsMask);
            expectSites(frame, [&, mode = mode](const Site& site) {
                const vec3 irradiance = isDynamic ? kProbeRadiance * kPi : lightmapOf(site.column);
                const vec3 direct = directRadiance(site.point, sun, 1.0f);
                if (mode == RunMode::Realtime) return direct;
                // Subtractive's lightmap holds the direct light, shadows and all.
                const bool inLightmap = mode == RunMode::Subtractive && !isDynamic;
                return indirectRadiance(site.point, irradiance) + (inLightmap ? vec3(0.0f) : direct);
            });
        }
    }
}

/// A mesh and a material for this object alone.
Material& ownMaterialOf(Scene& scene, int object)
{
    Object& owner = scene.objects[std::size_t(object)];
    Mesh mesh = scene.meshes[std::size_t(owner.mesh)];
    scene.materials.push_back(materialOf(scene, mesh.parts.at(0)));
    for (MeshPart& part : mesh.parts) part.material = int(scene.materials.size()) - 1;
    owner.mesh = int(scene.meshes.size());
    scene.meshes.push_back(std::move(mesh));
    return scene.materials.back();
}

/// What a site of the floor reflects when the slab over a column casts no realtime shadow.
vec3 withoutCaster(int column, RunMode mode, const Scene& scene, const Site& site)
{
    const vec3 lightmap = lightmapOf(site.column);
    const float realtime = site.column == column ? 1.0f : realtimeOf(mode, site.column);
    if (mode == RunMode::Subtractive)
        return indirectRadiance(
            site.point, subtractiveByHand(lightmap, vec3(kSunLux * kToSun.y), realtime, site.fade, vec3(0.0f), 1.0f));
    return indirectRadiance(site.point, lightmap) +
           directRadiance(site.point, scene.lights[0],
                          attenuationByHand(mode, true, maskOf(site.column), true, realtime, site.fade, 1.0f));
}

/// The object's switches, and its material's in place of them.
class ReceiveShadowsS30 : public RenderTest, public testing::WithParamInterface<ModePath> {};
INSTANTIATE_TEST_SUITE_P(, ReceiveShadowsS30,
                         testing::Combine(testing::Values(RunMode::Shadowmask, RunMode::DistanceShadowmask,
                                                          RunMode::Subtractive),
                                          kBothPaths),
                         modePathName);

TEST_P(ReceiveShadowsS30, OffMeansNeitherRealtimeNorBaked)
{
    const auto [mode, path] = GetParam();
    for (const bool byMaterial : {false, true}) {
        LawScene law = makeScene(bakeModeFor(mode));
        if (byMaterial)
            ownMaterialOf(law.baked.scene, law.floor).receiveShadows = false;
        else
            law.baked.scene.objects[std::size_t(law.floor)].receiveShadows = false;
        const RenderedFrame frame = render(law.baked, makeCamera(), settingsFor(mode, path));
        expectSites(frame, [&, mode = mode](const Site& site) {
            const vec3 indirect = indirectRadiance(site.point, lightmapOf(site.column));
            if (mode == RunMode::Subtractive) return indirect;
            return indirect + directRadiance(site.point, law.baked.scene.lights[0], 1.0f);
        });
    }
}

// One slab that casts no shadow is missing from the shadow map, and only that one.
TEST_P(ReceiveShadowsS30, CastOffLeavesOneCasterOut)
{
    const auto [mode, path] = GetParam();
    for (const bool byMaterial : {false, true}) {
        LawScene law = makeScene(bakeModeFor(mode));
        Scene& scene = law.baked.scene;
        int silenced = 0; // the dynamic slab of the third column
        for (const int blocker : law.blockers) {
            Object& object = scene.objects[std::size_t(blocker)];
            if (object.isStatic || object.worldFromObject[3].x > kColumns[3]) continue;
            if (byMaterial) {
                ownMaterialOf(scene, blocker).castShadows = false;
                // And a speck of another material at one corner, which keeps the object among the casters.
                std::vector<MeshPart>& parts = scene.meshes[std::size_t(object.mesh)].parts;
                MeshPart speck = parts[0];
                for (vec3& p : speck.positions) p = 0.9f * parts[0].positions[0] + 0.01f * p;
                speck.material = 0;
                parts.push_back(speck);
            } else {
                object.castShadows = false;
            }
            ++silenced;
        }
        ASSERT_EQ(silenced, 1);
        const RenderedFrame frame = render(law.baked, makeCamera(), settingsFor(mode, path));
        expectSites(frame, [&, mode = mode](const Site& site) { return withoutCaster(2, mode, scene, site); });
    }
}

// Switches of static objects that are turned after the bake: baked shadows stay as they are, and a warning says so.
TEST_P(ReceiveShadowsS30, TurnedSinceTheBakeIsSaid)
{
    const auto [mode, path] = GetParam();
    LawScene law = makeScene(bakeModeFor(mode));
    Scene& scene = law.baked.scene;
    int caster = -1; // the static slab of the second column
    for (const int blocker : law.blockers) {
        Object& object = scene.objects[std::size_t(blocker)];
        object.name = "slab " + std::to_string(blocker);
        if (object.isStatic && object.worldFromObject[3].x < kColumns[2]) caster = blocker;
    }
    ASSERT_GE(caster, 0);
    scene.objects[std::size_t(law.floor)].name = "floor";
    ASSERT_TRUE(renderer->load(law.baked));
    const auto draw = [&, path = path](RunMode drawn) {
        auto frame = renderer->render(makeCamera(), settingsFor(drawn, path));
        EXPECT_TRUE(frame);
        return std::move(*frame);
    };
    const auto said = [&](const FramePlan& plan, const std::string& words) {
        return std::any_of(plan.warnings.begin(), plan.warnings.end(),
                           [&](const std::string& warning) { return warning.find(words) != std::string::npos; });
    };
    EXPECT_TRUE(draw(mode).plan.warnings.empty());

    ASSERT_TRUE(renderer->setObjectShadows(caster, false, true));
    const RenderedFrame frame = draw(mode);
    EXPECT_TRUE(said(frame.plan, "\"slab " + std::to_string(caster) + "\": castShadows was switched off"));
    expectSites(frame, [&, mode = mode](const Site& site) { return withoutCaster(1, mode, scene, site); });
    EXPECT_TRUE(draw(RunMode::Realtime).plan.warnings.empty());
    ASSERT_TRUE(renderer->setObjectShadows(caster, true, true));
    EXPECT_TRUE(draw(mode).plan.warnings.empty());

    ASSERT_TRUE(renderer->setObjectShadows(law.floor, true, false));
    EXPECT_EQ(said(draw(mode).plan, "\"floor\": receiveShadows was switched off"), mode == RunMode::Subtractive);
}

} // namespace
} // namespace halflight::test::law_switches_test
