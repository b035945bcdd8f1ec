#include "render/render_test.h"

#include "halflight/shading/brdf.h"
#include "halflight/shading/light.h"

#include <cmath>

namespace halflight::test {

void RenderTest::SetUpTestSuite()
{
    auto created = Renderer::create({.validation = true});
    ASSERT_TRUE(created) << created.error().text();
    renderer = std::move(*created);
}

void RenderTest::SetUp()
{
    ASSERT_TRUE(renderer);
    earlierMessages_ = renderer->validationMessages().size();
}

void RenderTest::startAnew()
{
    TearDownTestSuite();
    SetUpTestSuite();
    RenderTest::SetUp();
}

void RenderTest::TearDown()
{
    if (!renderer) return;
    const std::vector<std::string> messages = renderer->validationMessages();
    for (std::size_t i = earlierMessages_; i < messages.size(); ++i) ADD_FAILURE() << messages[i];
}

RenderedFrame RenderTest::render(const BakedScene& baked, const Camera& camera, const RenderSettings& settings)
{
    if (Status status = renderer->load(baked); !status) {
        ADD_FAILURE() << status.error().text();
        return {ImageRgba32f(settings.size.x, settings.size.y), {}, {}};
    }
    return render(camera, settings);
}

RenderedFrame RenderTest::render(const Camera& camera, const RenderSettings& settings)
{
    auto frame = renderer->render(camera, settings);
    if (!frame) {
        ADD_FAILURE() << frame.error().text();
        return {ImageRgba32f(settings.size.x, settings.size.y), {}, {}};
    }
    return std::move(*frame);
}

Camera lookAt(vec3 eye, vec3 target, float verticalFovRadians)
{
    const vec3 back = glm::normalize(eye - target);
    const vec3 up = std::abs(back.y) < 0.99f ? vec3(0, 1, 0) : vec3(0, 0, -1);
    const vec3 right = glm::normalize(glm::cross(up, back));
    Camera camera;
    camera.worldFromCamera = mat4(vec4(right, 0), vec4(glm::cross(back, right), 0), vec4(back, 0), vec4(eye, 1));
    camera.verticalFovRadians = verticalFovRadians;
    return camera;
}

ivec2 pixelOf(const Camera& camera, ivec2 size, vec3 point)
{
    const vec3 p(glm::inverse(camera.worldFromCamera) * vec4(point, 1.0f));
    const float tanHalf = std::tan(0.5f * camera.verticalFovRadians);
    const float aspect = float(size.x) / float(size.y);
    const vec2 ndc(p.x / -p.z / (tanHalf * aspect), p.y / -p.z / tanHalf);
    return {int(std::floor((ndc.x * 0.5f + 0.5f) * float(size.x))),
            int(std::floor((0.5f - ndc.y * 0.5f) * float(size.y)))};
}

Ray pixelRay(const Camera& camera, ivec2 size, ivec2 pixel)
{
    const float tanHalf = std::tan(0.5f * camera.verticalFovRadians);
    const float aspect = float(size.x) / float(size.y);
    const vec2 ndc = (vec2(pixel) + 0.5f) / vec2(size) * 2.0f - 1.0f;
    const vec3 direction(ndc.x * tanHalf * aspect, -ndc.y * tanHalf, -1.0f);
    return {vec3(camera.worldFromCamera[3]), glm::normalize(mat3(camera.worldFromCamera) * direction)};
}

vec3 onPlane(const Ray& ray, float height)
{
    return ray.origin + ray.direction * ((height - ray.origin.y) / ray.direction.y);
}

Mesh makeRectangle(float width, float depth, int material)
{
    MeshPart part;
    const vec2 half(0.5f * width, 0.5f * depth);
    for (const vec2 corner : {vec2(-1, -1), vec2(1, -1), vec2(-1, 1), vec2(1, 1)}) {
        part.positions.push_back({corner.x * half.x, 0.0f, corner.y * half.y});
        part.normals.push_back({0, 1, 0});
        part.tangents.push_back({1, 0, 0, 1});
        part.uv[0].push_back(corner * 0.5f + 0.5f);
        part.lightmapUv.push_back(corner * 0.5f + 0.5f);
    }
    part.indices = {0, 2, 1, 1, 2, 3};
    part.material = material;
    Mesh mesh;
    mesh.parts.push_back(std::move(part));
    return mesh;
}

int addObject(Scene& scene, Mesh mesh, const mat4& worldFromObject, bool isStatic)
{
    Object object;
    object.mesh = int(scene.meshes.size());
    object.worldFromObject = worldFromObject;
    object.isStatic = isStatic;
    scene.meshes.push_back(std::move(mesh));
    scene.objects.push_back(object);
    return int(scene.objects.size()) - 1;
}

int addMaterial(Scene& scene, vec4 baseColor)
{
    Material material;
    material.baseColor = baseColor;
    material.metallic = 0.0f;
    material.roughness = 1.0f;
    scene.materials.push_back(material);
    return int(scene.materials.size()) - 1;
}

Light directionalLight(vec3 toLight, float lux)
{
    Light light;
    light.type = LightType::Directional;
    light.intensity = lux;
    light.worldFromLight = lightPose(vec3(0.0f), -toLight);
    light.mode = LightMode::Realtime;
    return light;
}

void bakeAsMixed(Light& light, MixedLightingMode mode, int channel)
{
    light.mode = LightMode::Mixed;
    light.baking.isBaked = true;
    light.baking.bakeType = LightMode::Mixed;
    light.baking.mixedMode = mode;
    light.baking.occlusionMaskChannel = channel;
    light.baking.worldFromLight = light.worldFromLight;
}

vec3 directRadiance(const ShadedPoint& point, const Light& light, float attenuation)
{
    const shading::LightSample incoming = shading::sampleLight(
        int(light.type), light.color * light.intensity, light.position(), light.direction(), light.rangeMeters,
        shading::spotConstants(light.innerConeRadians, light.outerConeRadians), point.position);
    return shading::reflectLight(point.baseColor, point.metallic, point.roughness, 1.0f, point.normal, point.view,
                                 incoming.direction, incoming.illuminance * attenuation);
}

vec3 indirectRadiance(const ShadedPoint& point, vec3 irradiance)
{
    const float nDotV = std::max(std::abs(glm::dot(point.normal, point.view)), 1.0e-4f);
    const vec3 f0 = shading::specularF0Of(point.baseColor, point.metallic, 1.0f);
    const vec3 albedo =
        shading::diffuseAlbedoOf(point.baseColor, point.metallic) * shading::diffuseShare(f0, 1.0f, nDotV);
    return shading::diffuseRadiance(albedo, irradiance) +
           shading::environmentSpecular(f0, 1.0f, point.roughness, nDotV) * irradiance * (1.0f / kPi);
}

PictureDifference compare(const ImageRgba32f& a, const ImageRgba32f& b)
{
    constexpr float kRelative = 0.005f;
    double sum = 0.0;
    for (const vec4& texel : a.texels()) sum += double(luminance(vec3(texel)));
    const float absolute = float(sum / double(a.texelCount())) / 2000.0f;
    PictureDifference result;
    for (int y = 0; y < a.height(); ++y) {
        for (int x = 0; x < a.width(); ++x) {
            float worst = 0.0f;
            for (int c = 0; c < 3; ++c) {
                const float allowed = kRelative * std::max(a(x, y)[c], b(x, y)[c]) + absolute;
                worst = std::max(worst, std::abs(a(x, y)[c] - b(x, y)[c]) / allowed);
            }
            result.differing += worst <= 1.0f ? 0 : 1; // and where it is not a number
            result.lit += vec3(a(x, y)) != vec3(0.0f);
            if (worst * kRelative > result.worstRelative) {
                result.worstRelative = worst * kRelative;
                result.worst = {x, y};
            }
        }
    }
    return result;
}

testing::AssertionResult near(vec3 actual, vec3 expected, float relative, float absolute)
{
    for (int c = 0; c < 3; ++c)
        if (!(std::abs(actual[c] - expected[c]) <= relative * std::abs(expected[c]) + absolute))
            return testing::AssertionFailure()
                   << "got (" << actual.x << ", " << actual.y << ", " << actual.z << "), expected (" << expected.x
                   << ", " << expected.y << ", " << expected.z << ")";
    return testing::AssertionSuccess();
}

} // namespace halflight::test
