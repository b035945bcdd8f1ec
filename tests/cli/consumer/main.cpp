// An engine that fills a Scene itself, bakes it, and asks for a frame's plan: no glTF file and no Vulkan device.

#include <halflight/bake/bake.h>
#include <halflight/bake_cpu/embree_integrator.h>
#include <halflight/render/frame.h>
#include <halflight/shading/law.h>

#include <cstdio>

using namespace halflight;

namespace {

Scene floorUnderASun()
{
    MeshPart part;
    part.positions = {{-2, 0, -2}, {-2, 0, 2}, {2, 0, 2}, {2, 0, -2}};
    part.normals.assign(4, vec3(0, 1, 0));
    part.indices = {0, 1, 2, 0, 2, 3};
    Mesh mesh;
    mesh.parts = {part};
    Object object;
    object.name = "floor";
    object.mesh = 0;
    Light sun;
    sun.name = "sun";
    sun.type = LightType::Directional;
    sun.intensity = 3.0f;
    // Shines along its -Z: turned to point straight down.
    sun.worldFromLight = glm::mat4_cast(glm::angleAxis(-0.5f * kPi, vec3(1, 0, 0)));

    Scene scene;
    scene.meshes = {mesh};
    scene.objects = {object};
    scene.lights = {sun};
    return scene;
}

} // namespace

int main()
{
    BakeSettings settings;
    settings.quality = Quality::Preview;
    settings.samples = 4;
    settings.lightmapSize = 64;
    const Result<BakeResult> result = bake(floorUnderASun(), settings, embreeIntegrators());
    if (!result) {
        std::printf("%s\n", result.error().text().c_str());
        return 1;
    }
    const BakedScene& baked = result->baked;
    if (baked.lightmaps.size() != 1 || baked.scene.lights[0].baking.occlusionMaskChannel != 0) return 1;
    if (!checkRunMode(baked, RunMode::DistanceShadowmask) || checkRunMode(baked, RunMode::Subtractive)) return 1;

    // Halfway through the fade of a distance shadowmask, a realtime shadow over baked light is half as dark.
    const float attenuation = shading::mixShadows(shading::kModeDistanceShadowmask, true, 1.0f, true, 0.0f, 0.5f, 1.0f);
    std::printf("attenuation %g\n", double(attenuation));
    return attenuation == 0.5f ? 0 : 1;
}
