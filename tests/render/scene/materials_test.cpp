// Normals, masks, blending and other properties of glTF materials.
#include "render/render_test.h"

#include "halflight/shading/brdf.h"
#include "halflight/shading/directional.h"
#include "shading/srgb_table.h"

#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/packing.hpp>

#include <array>
#include <cmath>

namespace halflight::test::materials_test {
namespace {

constexpr ivec2 kSize{160, 90};
const vec3 kAlbedo(0.5f, 0.6f, 0.7f);

RenderSettings settingsFor(RenderPath path)
{
    RenderSettings settings;
    settings.path = path;
    settings.size = kSize;
    settings.shadows.directionalMapSize = 1024;
    return settings;
}

ivec2 center()
{
    return kSize / 2;
}

/// A wall in the plane z = 0 that faces +Z, seen from z = `eyeZ`, with a sun.
struct Wall {
    BakedScene baked;
    Light sun;

    explicit Wall(vec3 toSun)
    {
        Scene& scene = baked.scene;
        addObject(scene, makeRectangle(4, 4, addMaterial(scene, vec4(kAlbedo, 1.0f))),
                  glm::rotate(mat4(1.0f), kPi / 2.0f, vec3(1, 0, 0)), true);
        sun = directionalLight(toSun, 2.0f);
        scene.lights.push_back(sun);
    }
    Material& material() { return baked.scene.materials[0]; }
    Object& object() { return baked.scene.objects[0]; }
};

Camera from(float z)
{
    return lookAt(vec3(0.3f, 0.2f, z), vec3(0.3f, 0.2f, 0));
}

/// The picture's middle as a point of the wall with this normal.
ShadedPoint middle(const Camera& camera, vec3 normal)
{
    const Ray ray = pixelRay(camera, kSize, center());
    return {ray.origin - ray.direction * (ray.origin.z / ray.direction.z), normal, -ray.direction, kAlbedo};
}

vec3 pixel(const RenderedFrame& frame)
{
    return vec3(frame.radiance(center().x, center().y));
}

class Materials : public BothPaths {};
INSTANTIATE_TEST_SUITE_P(, Materials, kBothPaths, pathNameOf);

TEST_P(Materials, BackFacesCulledUnlessDoubleSided)
{
    for (const float side : {1.0f, -1.0f}) {
        Wall wall(vec3(0.3f, 0.4f, side));
        const Camera camera = from(2.0f * side);
        EXPECT_TRUE(near(pixel(render(wall.baked, camera, settingsFor(GetParam()))),
                         side > 0 ? directRadiance(middle(camera, vec3(0, 0, 1)), wall.sun, 1.0f) : vec3(0.0f)));
        wall.material().doubleSided = true;
        EXPECT_TRUE(near(pixel(render(wall.baked, camera, settingsFor(GetParam()))),
                         directRadiance(middle(camera, vec3(0, 0, side)), wall.sun, 1.0f)));
    }
}

// A double-sided wall lit from behind is dark in front: its normal faces the viewer.
TEST_P(Materials, DoubleSidedSurfaceLitOnOneSideOnly)
{
    Wall wall(vec3(0, 0.2f, 1));
    wall.material().doubleSided = true;
    EXPECT_TRUE(near(pixel(render(wall.baked, from(-2.0f), settingsFor(GetParam()))), vec3(0.0f)));
}

// Mirrored transforms keep front faces in front and normals outside, non-uniform scale and shear keep normals normal.
TEST_P(Materials, MirroredScaledAndShearedNormals)
{
    const mat4 upright = glm::rotate(mat4(1.0f), kPi / 2.0f, vec3(1, 0, 0));
    mat4 shear(1.0f);
    shear[1][2] = 0.5f; // z += 0.5 y: the wall leans
    for (const mat4& transform : {glm::scale(mat4(1.0f), vec3(-1, 1, 1)), glm::scale(mat4(1.0f), vec3(1, -2, 1)),
                                  glm::scale(mat4(1.0f), vec3(-1, -1, 1)), glm::scale(mat4(1.0f), vec3(3, 0.5f, 1)),
                                  shear, shear * glm::scale(mat4(1.0f), vec3(-2, 1, 1))}) {
        Wall wall(vec3(0.3f, 0.4f, 1));
        wall.object().worldFromObject = transform * upright;
        const Camera camera = from(2.0f);
        const vec3 normal =
            glm::normalize(transform == shear || transform[1][2] != 0.0f ? vec3(0, -0.5f, 1) : vec3(0, 0, 1));
        const Ray ray = pixelRay(camera, kSize, center());
        const ShadedPoint point{ray.origin -
                                    ray.direction * (glm::dot(ray.origin, normal) / glm::dot(ray.direction, normal)),
                                normal, -ray.direction, kAlbedo};
        EXPECT_TRUE(
            near(pixel(render(wall.baked, camera, settingsFor(GetParam()))), directRadiance(point, wall.sun, 1.0f)));
    }
}

// A normal map that tilts towards +u: along the tangent, whether the object is mirrored, or seen from behind.
TEST_P(Materials, NormalMapFollowsTangentFrame)
{
    for (const float mirror : {1.0f, -1.0f}) {
        for (const float side : {1.0f, -1.0f}) {
            Wall wall(vec3(0.3f, 0.4f, side));
            Texture texture;
            texture.pixels = ImageRgba8(1, 1, u8vec4(204, 153, 230, 255)); // (0.6, 0.2, 0.804)
            wall.baked.scene.textures.push_back(texture);
            wall.material().normalTexture.texture = 0;
            wall.material().doubleSided = true;
            wall.object().worldFromObject = glm::scale(mat4(1.0f), vec3(mirror, 1, 1)) * wall.object().worldFromObject;
            const Camera camera = from(2.0f * side);
            // Object space: normal +y, tangent +x, bitangent = normal x tangent = -z; upright: -z becomes +y.
            const vec3 mapped = vec3(204, 153, 230) / 255.0f * 2.0f - 1.0f;
            const vec3 normal = side * glm::normalize(vec3(mirror * mapped.x, mapped.y, mapped.z));
            ShadedPoint point = middle(camera, normal);
            EXPECT_TRUE(near(pixel(render(wall.baked, camera, settingsFor(GetParam()))),
                             directRadiance(point, wall.sun, 1.0f), 3e-3f))
                << mirror << ' ' << side;
        }
    }
}

// A renderer keeps the textures that the next scene has too. Those that changed, moved to another slot or are gone are
// the next scene's own: every picture has the values of its texels.
TEST_P(Materials, NextSceneHasItsOwnTextures)
{
    const u8vec4 grey(188, 188, 188, 255); // sRGB, 0.503
    const u8vec4 red(255, 0, 0, 255);
    const auto expected = [](u8vec4 texel) {
        return kAlbedo * vec3(shading::kLinearFromSrgb8[texel.r], shading::kLinearFromSrgb8[texel.g],
                              shading::kLinearFromSrgb8[texel.b]);
    };
    const auto expectTextures = [&](const std::vector<u8vec4>& texels, int used) {
        Wall wall(vec3(0.3f, 0.4f, 1));
        for (const u8vec4 texel : texels) {
            Texture texture;
            texture.pixels = ImageRgba8(4, 4, texel);
            wall.baked.scene.textures.push_back(texture);
        }
        wall.material().baseColorTexture.texture = used;
        if (texels.size() > 1) wall.material().emissiveTexture.texture = 1 - used; // in a slot, and black: no emission
        ShadedPoint point = middle(from(2.0f), vec3(0, 0, 1));
        point.baseColor = expected(texels[std::size_t(used)]);
        EXPECT_TRUE(near(pixel(render(wall.baked, from(2.0f), settingsFor(GetParam()))),
                         directRadiance(point, wall.sun, 1.0f), 3e-3f));
    };
    startAnew();
    expectTextures({grey}, 0);
    expectTextures({grey}, 0);      // kept
    expectTextures({red}, 0);       // of the same size
    expectTextures({grey, red}, 1); // one kept, in another slot
    expectTextures({red, grey}, 1);
    expectTextures({grey, grey}, 0); // twice the same
    expectTextures({grey}, 0);
}

// Holes of an alpha mask are seen through and let the sun through; the rest is solid.
TEST_P(Materials, AlphaMaskHolesInPictureAndShadow)
{
    BakedScene baked;
    Scene& scene = baked.scene;
    const int floor = addMaterial(scene, vec4(kAlbedo, 1.0f));
    const int leaf = addMaterial(scene, vec4(1.0f));
    Texture texture; // left half open
    texture.pixels = ImageRgba8(8, 8, u8vec4(255));
    for (int y = 0; y < 8; ++y)
        for (int x = 0; x < 4; ++x) texture.pixels.edit()(x, y).a = 50;
    texture.wrapU = texture.wrapV = Texture::Wrap::ClampToEdge;
    scene.textures.push_back(texture);
    scene.materials[std::size_t(leaf)].baseColorTexture.texture = 0;
    scene.materials[std::size_t(leaf)].alphaMode = Material::AlphaMode::Mask;
    scene.materials[std::size_t(leaf)].doubleSided = true;
    addObject(scene, makeRectangle(20, 20, floor), mat4(1.0f), true);
    addObject(scene, makeRectangle(4, 4, leaf), glm::translate(mat4(1.0f), vec3(0, 2, 0)), true);
    const Light sun = directionalLight(vec3(0, 1, 0.001f), 3.0f);
    scene.lights.push_back(sun);
    const Camera low = lookAt(vec3(0, 1, 8), vec3(0, 0, 0));
    RenderedFrame frame = render(baked, low, settingsFor(GetParam()));
    for (const float x : {-1.2f, -0.6f, 0.6f, 1.2f}) {
        const ivec2 p = pixelOf(low, kSize, vec3(x, 0, 0));
        const Ray ray = pixelRay(low, kSize, p);
        const ShadedPoint point{onPlane(ray, 0.0f), vec3(0, 1, 0), -ray.direction, kAlbedo};
        EXPECT_TRUE(near(vec3(frame.radiance(p.x, p.y)), directRadiance(point, sun, x < 0 ? 1.0f : 0.0f))) << x;
    }
    // From above, the open half shows the floor.
    const Camera high = lookAt(vec3(0, 8, 0.01f), vec3(0, 0, 0));
    frame = render(baked, high, settingsFor(GetParam()));
    for (const float x : {-0.8f, 0.8f}) {
        const ivec2 p = pixelOf(high, kSize, vec3(x, 2, 0));
        const Ray ray = pixelRay(high, kSize, p);
        ShadedPoint point{onPlane(ray, x < 0 ? 0.0f : 2.0f), vec3(0, 1, 0), -ray.direction,
                          x < 0 ? kAlbedo : vec3(1.0f)};
        EXPECT_TRUE(near(vec3(frame.radiance(p.x, p.y)), directRadiance(point, sun, 1.0f))) << x;
    }
}

// S32. A normal map on a lightmapped wall: the lightmap's value is that on the wall's own normal, its direction tells
// what the mapped normal gets. Without directions, or with them turned off, the map does nothing to baked light.
TEST_P(Materials, NormalMapsSeeTheLightmapsDirectionS32)
{
    Wall wall(vec3(0, 0.2f, 1));
    Scene& scene = wall.baked.scene;
    scene.lights.clear();
    wall.object().isStatic = true;
    wall.object().lightmap = {0, vec2(1.0f), vec2(0.0f)};
    wall.baked.isBaked = true;
    wall.baked.mode = MixedLightingMode::BakedIndirect;
    const vec3 irradiance(4.0f, 2.0f, 1.0f);
    wall.baked.lightmaps.emplace_back(4, 4, glm::packF3x9_E1x5(irradiance));
    Texture texture;
    texture.pixels = ImageRgba8(1, 1, u8vec4(128 + 51, 128, 128 + 110, 255));
    scene.textures.push_back(texture);
    wall.material().normalTexture.texture = 0;
    wall.material().roughness = 0.4f; // so that the light's highlight shows
    const vec3 encoded = vec3(texture.pixels(0, 0)) / 255.0f * 2.0f - 1.0f;
    const vec3 mapped = glm::normalize(vec3(encoded.x, encoded.y, encoded.z));
    const vec3 up(0, 0, 1); // the wall's normal
    const vec3 toLight = glm::normalize(vec3(1.0f, 0.3f, 1.0f));
    RenderSettings settings = settingsFor(GetParam());
    settings.mode = RunMode::BakedIndirect;
    for (const float share : {0.0f, 0.6f, 1.0f}) {
        const vec3 direction = glm::mix((2.0f / 3.0f) * up, toLight, share);
        const vec3 stored = glm::floor((direction * 0.5f + 0.5f) * 255.0f + 0.5f);
        wall.baked.lightmapDirections = {ImageRgba8(4, 4, u8vec4(vec4(stored, 255.0f)))};
        for (const bool on : {true, false}) {
            settings.directionalLightmaps = on;
            // By hand: the sky part that a tilted surface sees, and the cosine law.
            const auto scaleOn = [&](vec3 n) {
                const float sky = 0.5f + 0.5f * glm::dot(n, up);
                const float light = std::max(glm::dot(n, toLight), 0.0f) / toLight.z;
                return on ? glm::mix(sky, light, share) : 1.0f;
            };
            ShadedPoint point = middle(from(3.0f), mapped);
            point.roughness = 0.4f;
            const vec3 mirror = glm::reflect(-point.view, mapped);
            const vec3 lobe = glm::normalize(glm::mix(mirror, mapped, point.roughness * point.roughness));
            const float nDotV = glm::dot(mapped, point.view);
            const vec3 albedo = kAlbedo * shading::diffuseShare(vec3(0.04f), 1.0f, nDotV);
            const vec3 diffuse = shading::diffuseRadiance(albedo, irradiance * scaleOn(mapped));
            const float met = on ? shading::directionalSpecularScale(stored / 127.5f - 1.0f, up, mapped, point.view,
                                                                     lobe, point.roughness)
                                 : 1.0f;
            if (on && share == 1.0f) EXPECT_GT(met, 1.5f * scaleOn(lobe)) << "a highlight";
            const vec3 specular =
                shading::environmentSpecular(vec3(0.04f), 1.0f, point.roughness, glm::dot(mapped, point.view)) *
                irradiance * (met / kPi);
            EXPECT_TRUE(near(pixel(render(wall.baked, from(3.0f), settings)), diffuse + specular, 0.02f))
                << share << (on ? " on" : " off");
        }
    }
    EXPECT_GT(glm::dot(mapped, toLight) / toLight.z, 1.2f) << "the map must matter";
}

// Two blended panes before a wall: over each other from back to front, whatever their order in the scene; they cast no
// realtime shadow.
TEST_P(Materials, BlendedPanesBackToFront)
{
    for (const bool swapped : {false, true}) {
        Wall wall(vec3(0, 0.2f, 1));
        Scene& scene = wall.baked.scene;
        const mat4 upright = wall.object().worldFromObject;
        const vec4 colors[2] = {{0.9f, 0.1f, 0.1f, 0.5f}, {0.1f, 0.1f, 0.9f, 0.25f}};
        for (const int i : swapped ? std::array{1, 0} : std::array{0, 1}) {
            const int material = addMaterial(scene, colors[i]);
            scene.materials.back().alphaMode = Material::AlphaMode::Blend;
            addObject(scene, makeRectangle(3, 3, material),
                      glm::translate(mat4(1.0f), vec3(0, 0, i == 0 ? 0.5f : 1.0f)) * upright, false);
            scene.objects.back().castShadows = false; // what is seen through them, not what they keep back
        }
        const Camera camera = from(3.0f);
        ShadedPoint point = middle(camera, vec3(0, 0, 1));
        vec3 expected = directRadiance(point, wall.sun, 1.0f);
        for (const vec4& color : colors) {
            point.baseColor = vec3(color);
            expected = glm::mix(expected, directRadiance(point, wall.sun, 1.0f), color.a);
        }
        EXPECT_TRUE(near(pixel(render(wall.baked, camera, settingsFor(GetParam()))), expected)) << swapped;
    }
}

TEST_P(Materials, EmissiveUnlitAndVertexColors)
{
    Wall wall(vec3(0, 0.2f, 1));
    const Camera camera = from(2.0f);
    wall.material().emissiveNits = vec3(5, 0, 2);
    EXPECT_TRUE(near(pixel(render(wall.baked, camera, settingsFor(GetParam()))),
                     vec3(5, 0, 2) + directRadiance(middle(camera, vec3(0, 0, 1)), wall.sun, 1.0f)));
    wall.material().emissiveNits = vec3(0.0f);
    MeshPart& part = wall.baked.scene.meshes[0].parts[0];
    part.colors.assign(part.positions.size(), vec4(0.5f, 0.25f, 1.0f, 1.0f));
    ShadedPoint point = middle(camera, vec3(0, 0, 1));
    point.baseColor *= vec3(0.5f, 0.25f, 1.0f);
    EXPECT_TRUE(
        near(pixel(render(wall.baked, camera, settingsFor(GetParam()))), directRadiance(point, wall.sun, 1.0f)));
    wall.material().unlit = true;
    EXPECT_TRUE(near(pixel(render(wall.baked, camera, settingsFor(GetParam()))), point.baseColor));
}

// Meshes whose texture coordinates are the same all over have their texel's colour, filtered or not.
TEST_P(Materials, OneTextureCoordinateEverywhere)
{
    for (const bool nearest : {true, false}) {
        Wall wall(vec3(0, 0.2f, 1));
        Texture color;
        color.pixels = ImageRgba8(4, 4, u8vec4(188, 188, 188, 255)); // 0.5029 linear
        color.nearest = nearest;
        wall.baked.scene.textures = {color};
        wall.material().baseColor = vec4(1.0f);
        wall.material().baseColorTexture.texture = 0;
        for (vec2& uv : wall.baked.scene.meshes[0].parts[0].uv[0]) uv = vec2(0.0f, 1.0f);
        const Camera camera = from(2.0f);
        ShadedPoint point = middle(camera, vec3(0, 0, 1));
        point.baseColor = vec3(std::pow((188 / 255.0f + 0.055f) / 1.055f, 2.4f));
        EXPECT_TRUE(near(pixel(render(wall.baked, camera, settingsFor(GetParam()))),
                         directRadiance(point, wall.sun, 1.0f), 3e-3f))
            << nearest;
    }
}

// Base colour is sRGB, metallic-roughness is not, and KHR_texture_transform moves what is read.
TEST_P(Materials, TexturesSrgbTransformAndMetallicRoughness)
{
    Wall wall(vec3(0, 0.2f, 1));
    Scene& scene = wall.baked.scene;
    Texture color;
    color.pixels = ImageRgba8(4, 4, u8vec4(255, 0, 0, 255));
    for (int y = 0; y < 4; ++y) color.pixels.edit()(3, y) = u8vec4(188, 188, 188, 255); // 0.5029 linear
    color.nearest = true;
    Texture data;
    data.pixels = ImageRgba8(1, 1, u8vec4(0, 128, 64, 255));
    scene.textures = {color, data};
    wall.material().baseColor = vec4(1.0f);
    wall.material().baseColorTexture.texture = 0;
    wall.material().baseColorTexture.scale = vec2(0.0f);
    wall.material().baseColorTexture.offset = vec2(0.875f, 0.5f); // the last column, everywhere
    wall.material().metallicRoughnessTexture.texture = 1;
    wall.material().metallic = 1.0f;
    const Camera camera = from(2.0f);
    ShadedPoint point = middle(camera, vec3(0, 0, 1));
    point.baseColor = vec3(std::pow((188 / 255.0f + 0.055f) / 1.055f, 2.4f));
    point.roughness = 128 / 255.0f;
    point.metallic = 64 / 255.0f;
    EXPECT_TRUE(
        near(pixel(render(wall.baked, camera, settingsFor(GetParam()))), directRadiance(point, wall.sun, 1.0f), 3e-3f));
}

// Realtime mode: the open sky lights what no light reaches, dimmed by the material's occlusion.
TEST_P(Materials, RealtimeAmbientIsTheSkyTimesOcclusion)
{
    Wall wall(vec3(0, 0.2f, -1)); // the sun behind
    Scene& scene = wall.baked.scene;
    scene.sky = {vec3(2.0f), vec3(2.0f), vec3(2.0f)};
    const Camera camera = from(2.0f);
    const vec3 open = indirectRadiance(middle(camera, vec3(0, 0, 1)), vec3(2.0f * kPi));
    EXPECT_TRUE(near(pixel(render(wall.baked, camera, settingsFor(GetParam()))), open, 2e-3f));
    Texture occlusion;
    occlusion.pixels = ImageRgba8(1, 1, u8vec4(51, 0, 0, 255));
    scene.textures.push_back(occlusion);
    wall.material().occlusionTexture.texture = 0;
    wall.material().occlusionStrength = 0.5f;
    EXPECT_TRUE(near(pixel(render(wall.baked, camera, settingsFor(GetParam()))), open * 0.6f, 2e-3f));
}

TEST_P(Materials, SkyFillsTheBackgroundByDirection)
{
    BakedScene baked;
    baked.scene.sky = {vec3(1, 2, 3), vec3(4, 4, 4), vec3(0.5f)};
    const Camera camera = lookAt(vec3(0.0f), vec3(0.3f, 0.1f, -1));
    const RenderedFrame frame = render(baked, camera, settingsFor(GetParam()));
    for (const ivec2 p : {ivec2(0, 0), ivec2(159, 89), ivec2(80, 45), ivec2(10, 80)}) {
        const vec3 d = pixelRay(camera, kSize, p).direction;
        const vec3 expected =
            d.y >= 0 ? glm::mix(vec3(4.0f), vec3(1, 2, 3), d.y) : glm::mix(vec3(4.0f), vec3(0.5f), -d.y);
        EXPECT_TRUE(near(vec3(frame.radiance(p.x, p.y)), expected));
    }
}

} // namespace
} // namespace halflight::test::materials_test
