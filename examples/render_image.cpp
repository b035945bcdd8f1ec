// A baked file in, a changed scene out: moves an object, changes a light, picks mode and path, and draws to an image.
//
//   render_image BAKED.glb PICTURE.png [forward|deferred]

#include "halflight/render/renderer.h"
#include "halflight/scene/gltf.h"

#include <glm/gtc/matrix_transform.hpp>

#include <cstdio>
#include <cstring>

using namespace halflight;

namespace {

int fail(const Error& error)
{
    std::fprintf(stderr, "render_image: %s\n", error.text().c_str());
    return 1;
}

/// The file's first camera, else one that sees the scene from a corner.
Camera cameraOf(const Scene& scene)
{
    if (!scene.cameras.empty()) return scene.cameras.front();
    const Bounds bounds = scene.bounds();
    Camera camera;
    const vec3 eye = bounds.center() + 0.9f * glm::length(bounds.size()) * glm::normalize(vec3(1.0f, 0.7f, 1.2f));
    camera.worldFromCamera = glm::inverse(glm::lookAt(eye, bounds.center(), vec3(0, 1, 0)));
    return camera;
}

/// Lifts the first dynamic object by half a metre.
Status moveObject(Renderer& renderer)
{
    const std::vector<Object>& objects = renderer.scene().objects;
    for (std::size_t i = 0; i < objects.size(); ++i) {
        if (objects[i].isStatic) continue;
        const mat4 lifted = glm::translate(mat4(1.0f), vec3(0.0f, 0.5f, 0.0f)) * objects[i].worldFromObject;
        return renderer.setObjectTransform(int(i), lifted);
    }
    return {};
}

/// Makes the first light warmer and half as bright. Its baked shadows stay right.
Status changeLight(Renderer& renderer)
{
    if (renderer.scene().lights.empty()) return {};
    Light light = renderer.scene().lights.front();
    light.color *= vec3(1.0f, 0.8f, 0.6f);
    light.intensity *= 0.5f;
    return renderer.setLight(0, light);
}

} // namespace

int main(int argc, char** argv)
{
    if (argc < 3) {
        std::fprintf(stderr, "usage: render_image BAKED.glb PICTURE.png [forward|deferred]\n");
        return 2;
    }
    const Result<BakedScene> baked = readBakedScene(argv[1]);
    if (!baked) return fail(baked.error());

    const Result<std::unique_ptr<Renderer>> created = Renderer::create();
    if (!created) return fail(created.error());
    Renderer& renderer = **created;
    if (Status status = renderer.load(*baked); !status) return fail(status.error());
    if (Status status = moveObject(renderer); !status) return fail(status.error());
    if (Status status = changeLight(renderer); !status) return fail(status.error());

    RenderSettings settings;
    settings.size = {640, 360};
    settings.mode = defaultRunMode(*baked);
    // A shadowmask bake serves this mode too: near shadows realtime, far ones baked.
    if (settings.mode == RunMode::Shadowmask) settings.mode = RunMode::DistanceShadowmask;
    if (argc > 3 && std::strcmp(argv[3], "deferred") == 0) settings.path = RenderPath::Deferred;
    const Result<RenderedFrame> frame = renderer.render(cameraOf(baked->scene), settings);
    if (!frame) return fail(frame.error());
    for (const std::string& warning : frame->plan.warnings) std::fprintf(stderr, "warning: %s\n", warning.c_str());

    // The radiance is yours: show it, write it, or expose it as here.
    const ImageRgba8 picture = displayedPicture(frame->radiance, automaticExposure(frame->radiance));
    if (Status status = writePng(argv[2], picture); !status) return fail(status.error());
    std::printf("%s: %s, %zu lights, G-buffer targets %d\n", argv[2], renderer.deviceName().c_str(),
                frame->plan.lights.size(), frame->gBufferTargets);
    return 0;
}
