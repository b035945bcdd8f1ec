#pragma once
// The scene: plain structs, filled by the glTF reader (gltf.h) or by an engine. Right-handed, Y up, metres, seconds;
// colours are linear Rec. 709. A light shines along its local -Z, a camera looks along its local -Z (as in glTF).
//
// "World" in names of transforms and positions means the scene's own space, whose origin lies at
// Scene::originMeters of the file's or engine's world. The two are the same for scenes near the world's origin.

#include "halflight/base/image.h"
#include "halflight/base/math.h"
#include "halflight/scene/material.h"

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace halflight {

/// A vertex on the line between two vertices of one primitive, which the unwrapper added where it cut a mesh.
struct CutVertex {
    uint32_t from = 0; ///< as in MeshPart::sourceVertex
    uint32_t to = 0;
    float share = 0.0f; ///< of the way, 0…1

    /// An attribute at the vertex for its values at the ends.
    [[nodiscard]] float between(float a, float b) const
    {
        return float(double(a) + double(share) * (double(b) - double(a)));
    }
};
/// Set in numbers of vertices that are an index into MeshPart::cutVertices instead.
constexpr uint32_t kCutVertex = 0x80000000u;

/// Which side of a surface a part of a mesh is. Both: the material says which sides are seen. Front, Back: the two
/// halves of a double-sided sheet whose sides have texels of their own. The back half has the triangles of the front
/// half with reversed winding and normals. A half is seen from its front alone, though its material is double-sided.
/// Rays meet the front half only, from both sides.
enum class SurfaceSide : uint8_t { Both, Front, Back };

/// What texels of a triangle hold. Front: the light of its front, the one side that is seen. FrontOfBoth: the same,
/// though both sides are seen. Mean: the mean light of both sides (small sheets, leaves). Back: the light of its back,
/// because its front is never seen.
enum class TexelSide : uint8_t { Front, FrontOfBoth, Mean, Back };

/// Whether a static double-sided sheet has texels for each of its sides. Automatic: where both can be seen, and their
/// light differs.
enum class TwoSided : uint8_t { Automatic, On, Off };

/// One triangle list with one material: a glTF primitive after strips and fans became lists. All vertex arrays that are
/// not empty have the same length; indices are valid. Zero-area triangles may occur.
struct MeshPart {
    std::vector<vec3> positions; ///< object space, finite
    std::vector<vec3> normals;   ///< unit; always present after reading (flat normals where the file had none)
    std::vector<vec4> tangents;  ///< xyz unit, w = bitangent sign; present when the material has a normal texture
    /// TEXCOORD_n of the file at index n: 0 and 1, and those that the material reads; empty where absent.
    std::array<std::vector<vec2>, kTexCoordSets> uv;
    std::vector<vec4> colors;      ///< linear RGBA vertex colours; empty where absent
    std::vector<uint32_t> indices; ///< 3 per triangle, counter-clockwise front faces
    int material = -1;             ///< index into Scene::materials; -1 = glTF's default material

    /// Lightmap coordinates in [0,1] of the mesh's own layout; a point's place on its page is
    /// `object.lightmap.scale * lightmapUv + object.lightmap.offset`. Empty until unwrapped.
    std::vector<vec2> lightmapUv;
    /// For each vertex, the vertex of the source primitive it is a copy of; with kCutVertex an index into cutVertices.
    /// Empty = vertices are the source's own.
    std::vector<uint32_t> sourceVertex;
    std::vector<CutVertex> cutVertices; ///< the ends of each are the source's or earlier entries
    int sourcePrimitive = -1;
    int lightmapTexCoord = 1; ///< n of the TEXCOORD_n that carries lightmapUv in the written file
    SurfaceSide side = SurfaceSide::Both;
    std::vector<TexelSide> texelSides; ///< by triangle, as the unwrapper decided; empty = all Front
    [[nodiscard]] std::size_t triangleCount() const { return indices.size() / 3; }
};

struct Mesh {
    std::string name;
    std::vector<MeshPart> parts;
    int sourceMesh = -1; ///< several meshes may share one source when its objects need different layouts
    [[nodiscard]] std::size_t triangleCount() const;
};

/// Where an object's lightmap and shadowmask texels are; page -1 = not lightmapped.
struct LightmapBinding {
    int page = -1;
    vec2 scale{1.0f};
    vec2 offset{0.0f};
};

/// Where an object without lightmap takes its probe light. Single: one sample for all of it, at its middle. Volume: a
/// proxy volume (LPPV), light and occlusion point by point. Automatic: a volume for static objects that are longer than
/// probes are apart, as one place does not speak for them; else one sample.
enum class ProbeLighting { Automatic, Single, Volume };

/// A mesh placed in the world: a node with a mesh, or one instance of an EXT_mesh_gpu_instancing node.
struct Object {
    std::string name;
    int mesh = -1;
    mat4 worldFromObject{1.0f}; ///< may mirror (negative determinant), scale non-uniformly and shear
    bool isStatic = true;       ///< lightmapped, casts into the bake; dynamic objects are lit by probes
    bool castShadows = true;
    bool receiveShadows = true;
    float lightmapScale = 1.0f; ///< multiplies texels per metre; 0 = casts into the bake but gets no texels
    TwoSided twoSided = TwoSided::Automatic; ///< stronger than the bake's setting
    LightmapBinding lightmap;
    ProbeLighting probeLighting = ProbeLighting::Automatic;
    ivec3 probeResolution{0}; ///< texels of its proxy volume along its own axes, 1…64; 0 = by the distance of probes
    /// Objects with ProbeLighting::Volume and the same group share one proxy volume, a box along the world's axes. -1:
    /// a volume of its own, along its own axes. The reader puts the instances of one node in one group.
    int probeGroup = -1;
    int sourceNode = -1;
    int sourceInstance = -1; ///< index within EXT_mesh_gpu_instancing, -1 = none
};

/// Rectangle and Disk are area lights: flat, one-sided, of one radiance (EXT_lights_area). They light surfaces and show
/// in highlights; cameras do not see them, and they throw no shadow.
enum class LightType { Directional, Point, Spot, Rectangle, Disk };
constexpr bool isAreaLight(LightType type)
{
    return type == LightType::Rectangle || type == LightType::Disk;
}
/// Realtime: nothing baked. Mixed: direct light at run time, indirect light (and by mode shadows) baked. Baked: all
/// baked.
enum class LightMode { Realtime, Mixed, Baked };
enum class MixedLightingMode { BakedIndirect, Shadowmask, Subtractive };

/// As files, reports and the command line write them: "directional", "point", "spot", "rectangle", "disk"; "realtime",
/// "mixed", "baked"; "baked-indirect", "shadowmask", "subtractive".
const char* nameOf(LightType type);
const char* nameOf(LightMode mode);
const char* nameOf(MixedLightingMode mode);

/// What the bake saw of a light's values that may be changed since: see changesSinceBake().
struct LightAtBake {
    bool known = false;              ///< false: not baked, or by a version that did not record it
    vec3 colorIntensity{0.0f};       ///< Light::color times Light::intensity
    float indirectMultiplier = 1.0f; ///< 0 where lightmap and probes hold no bounced light of this light
    float rangeMeters = 0.0f;        ///< as Light::rangeMeters: 0 = unlimited
    float innerConeRadians = 0.0f;
    bool castShadows = true;
    float shadowStrength = 1.0f;
    float radiusMeters = -1.0f;         ///< below 0: not recorded
    float angularRadiusRadians = -1.0f; ///< below 0: not recorded
    vec2 sizeMeters{-1.0f};             ///< of an area light; below 0: not recorded
};

/// What the bake holds of a light that turns (spec S34, turning_lights.h): light that surfaces reflect of it, by
/// direction.
struct TurningLight {
    int group = -1;               ///< index into BakedScene::groups of the first direction's; the others follow it
    std::vector<vec3> directions; ///< unit, along which it shone, in the world
};

/// What the bake did with a light (spec: baking output). The renderer follows this, not the light's authored mode.
struct BakingOutput {
    bool isBaked = false;                     ///< false for realtime lights and unbaked files
    LightMode bakeType = LightMode::Realtime; ///< what the light is after the bake: an overflowing mixed light is Baked
    MixedLightingMode mixedMode = MixedLightingMode::Shadowmask;
    int occlusionMaskChannel = -1; ///< -1 none; 0 to 3: R to A of the first mask layer, 4 to 7 of the second …
    /// Its shadow has a colour, that of glass (spec S35): it takes R, G and B of a layer, and the channel is R's.
    bool coloredMask = false;
    std::string reason;        ///< why bakeType differs from the authored mode; empty when it does not
    mat4 worldFromLight{1.0f}; ///< pose at bake time, to tell a light that was moved since
    /// Point, spot: the mask and the probes hold this light's shadow up to here, and B is 1 beyond (spec section 4).
    /// The range at bake time, or the effective reach of a light without one; 0 = unlimited.
    float reachMeters = 0.0f;
    float outerConeRadians = kPi / 2.0f; ///< spot: half angle at bake time; B is 1 outside of it
    LightAtBake atBake;
    int group = -1; ///< index into BakedScene::groups, -1 = none
    /// Of a member of a group, and of a light that turns, colour times intensity at the weight 1.
    vec3 white{0.0f};
    TurningLight turning; ///< of a light in no group
};

constexpr float kMaxShadowBias = 100.0f; ///< of a light's own depth bias and slope bias
constexpr float kMaxNormalBiasTexels = 8.0f;

/// Bias of one light's realtime shadow maps. Without a value the frame's setting counts (ShadowSettings, whose units
/// these have).
struct ShadowBias {
    std::optional<float> depthTexels;
    std::optional<float> slope;
    std::optional<float> normalTexels;
};

struct Light {
    std::string name;
    std::string group; ///< light group (light_groups.h); empty = none
    /// Directional: unit vectors along which it shall be able to shine after a bake, in the world (turning_lights.h);
    /// empty = it stays as it is.
    std::vector<vec3> directions;
    LightType type = LightType::Point;
    vec3 color{1.0f};
    /// Candela (point, spot) or lux (directional), as in KHR_lights_punctual; of area lights the radiance of their
    /// surface, cd/m2, as in EXT_lights_area.
    float intensity = 1.0f;
    float rangeMeters = 0.0f; ///< light is exactly 0 from here on, as seen from the light's position; 0 = unlimited
    float innerConeRadians = 0.0f;
    float outerConeRadians = kPi / 4.0f; ///< half angles
    mat4 worldFromLight{1.0f};           ///< rigid: position and direction (-Z)
    LightMode mode = LightMode::Mixed;
    bool castShadows = true;
    float shadowStrength = 1.0f;       ///< 0…1, applied once, after mixing
    float indirectMultiplier = 1.0f;   ///< scales this light's bounced light in the bake
    float radiusMeters = 0.0f;         ///< point, spot: radius of the emitting sphere or disc, for baked penumbrae
    float angularRadiusRadians = 0.0f; ///< directional: half the source's angular diameter (the sun: 0.00465)
    /// Rectangle: width along the light's X, height along its Y, the position in the middle. Disk: x is the diameter.
    vec2 sizeMeters{1.0f};
    float sourceScale = 1.0f; ///< area lights of a file: metres per unit of the size in the file (the node's scale)
    ShadowBias shadowBias;
    BakingOutput baking;
    int sourceNode = -1;

    [[nodiscard]] vec3 position() const { return vec3(worldFromLight[3]); }
    /// Unit vector along which the light shines.
    [[nodiscard]] vec3 direction() const { return -glm::normalize(vec3(worldFromLight[2])); }
    /// From the middle of an area light to the middles of its edges along X and Y, or to a disk's rim.
    [[nodiscard]] vec3 halfWidth() const { return 0.5f * sizeMeters.x * glm::normalize(vec3(worldFromLight[0])); }
    [[nodiscard]] vec3 halfHeight() const
    {
        const float height = type == LightType::Disk ? sizeMeters.x : sizeMeters.y;
        return 0.5f * height * glm::normalize(vec3(worldFromLight[1]));
    }
    /// Intensity over Light::intensity along the axis of an area light, seen from afar: its area in m2. 1 for others.
    [[nodiscard]] float area() const
    {
        if (type == LightType::Disk) return 0.25f * kPi * sizeMeters.x * sizeMeters.x;
        return type == LightType::Rectangle ? sizeMeters.x * sizeMeters.y : 1.0f;
    }
};

/// Whether the part of a mixed or baked light's pose that matters to its kind differs from the pose at bake time by
/// more than a millimetre or a milliradian (spec S29): its baked light and shadows are out of step then.
bool movedSinceBake(const Light& light);

/// The values of the light that LightAtBake keeps, as they are now.
LightAtBake lightAtBake(const Light& light);

/// A change of luminance by more than this factor leaves bounced light visibly out of step.
constexpr float kBouncedLightFactor = 4.0f;

/// Whether the light's direct light on static objects is in the lightmap: fully baked, or mixed in a subtractive bake.
bool directLightIsBaked(const Light& light);

/// Sentences about what was changed of a baked or mixed light since its bake and shows nowhere, or only in part (spec
/// S29), and what to do about it. Empty when the light is in step. `name` stands for the light in them: light "sun".
/// `bakedShadows`: the light's baked shadows are in use, so that a move is said of them.
std::vector<std::string> changesSinceBake(const Light& light, const std::string& name, bool bakedShadows);

struct Camera {
    std::string name;
    mat4 worldFromCamera{1.0f}; ///< rigid
    float verticalFovRadians = kPi / 3.0f;
    float nearMeters = 0.05f;
    float farMeters = 1000.0f;
    bool orthographic = false;
    float orthographicHeightMeters = 1.0f; ///< full height
    bool operator==(const Camera&) const = default;
};

/// Radiance of the surroundings (cd/m2) by direction: the picture, or skyRadiance() in shading/sky.h where there is
/// none. All zero = no sky.
struct Sky {
    vec3 zenith{0.0f}; ///< with a picture: the gradient nearest to it, which setPicture() finds
    vec3 horizon{0.0f};
    vec3 ground{0.0f};
    /// Equirectangular, filtered bilinearly; skyPictureUv() in shading/sky.h says which direction is where.
    std::shared_ptr<const ImageRgb32f> picture;
    float rotationRadians = 0.0f; ///< of the picture about +Y, by the right-hand rule
    bool pictureOfBake = false;   ///< the picture is the small one that an earlier bake kept in the file
    std::string group;            ///< light group (light_groups.h); empty = none
    bool changes = false;         ///< bakes keep its parts as light groups (spec S34)

    /// A picture with finite values of 0 and more, at least one texel.
    void setPicture(std::shared_ptr<const ImageRgb32f> radiance, float rotation);
    [[nodiscard]] bool black() const { return zenith == vec3(0) && horizon == vec3(0) && ground == vec3(0); }
};

/// Opaque copy of the glTF a scene was read from, so that writing changes only what baking adds. Seen only by
/// src/scene.
struct SourceDocument;

/// What emission in a file counts: cd/m2, or watts per m2 and steradian as Blender's exporter writes it, of which each
/// is kLumensPerWatt cd/m2 beside the lamps that it writes.
enum class EmissionUnit { Nits, Blender };
/// As settings and --emission-unit have it: "nits", "blender".
const char* nameOf(EmissionUnit unit);
constexpr float kLumensPerWatt = 683.0f; ///< by which Blender's exporter turns lamps' watts into candela and lux

struct Scene {
    std::string name;
    /// World position of the scene's local origin. All positions and transforms of the scene, its bake and its cameras
    /// are relative to it: world = originMeters + local. Zero unless the scene is far from the world's origin for its
    /// size (see recenter()). Directions and bounds' sizes are the same in both spaces.
    dvec3 originMeters{0.0};
    std::vector<Texture> textures;
    std::vector<Material> materials;
    std::vector<Mesh> meshes;
    std::vector<Object> objects;
    std::vector<Light> lights;
    std::vector<Camera> cameras;
    Sky sky;
    /// What materials' emission was multiplied by on reading; a written file has the product, and says that it is nits.
    float emissionScale = 1.0f;
    /// Lower limit of subtractive shadows that the author asks for, as irradiance in lux (spec S23); none: the bake's
    /// choice (BakedScene::defaultShadowColor).
    std::optional<vec3> subtractiveShadowColor;
    /// Centres that the file or settings give for light probes; empty = placed automatically.
    std::vector<vec3> probePositions;
    /// Boxes of the reflection probes that the file asks for, each from the cube [-1, 1]^3 to the world; empty = placed
    /// automatically.
    std::vector<mat4> reflectionBoxes;
    std::vector<std::string> warnings; ///< what was odd in the file: skipped primitives, invented normals, …
    std::shared_ptr<const SourceDocument> source; ///< null when the scene was not read from a file

    /// World-space bounds of all objects (static only, if asked).
    [[nodiscard]] Bounds bounds(bool staticOnly = false) const;
};

/// Makes a scene that an engine filled relative to a world position near its middle, before it is baked. Floats are
/// 6 cm apart at 1e6 m and rays need more, so positions far from the origin have to be relative to one near by. Does
/// nothing where the middle of most objects is nearer than 64 times the radius that holds them. Vertices far from
/// their mesh's origin move to it, and their objects' transforms make up for it. Returns whether it changed anything.
///
/// What the floats had lost before stays lost: at 5e6 m half a metre. An engine with far scenes should subtract a
/// local origin in double precision itself, and put it into originMeters. The glTF reader does so.
bool recenter(Scene& scene);
/// Whether recenter() would move the scene: floats are coarse where most of its objects are. bake() warns of it.
bool farFromOrigin(const Scene& scene);

/// glTF's default material.
const Material& defaultMaterial();
/// The part's material, the default one where it has none.
const Material& materialOf(const Scene& scene, const MeshPart& part);

/// Index of the part's material in the glTF file's "materials", or -1.
inline int sourceMaterialOf(const Scene& scene, const MeshPart& part)
{
    return part.material < 0 ? -1 : scene.materials[std::size_t(part.material)].sourceMaterial;
}

/// Whether both sides of the part are seen.
bool isDoubleSided(const Scene& scene, const MeshPart& part);

/// Whether the object throws any shadow: it does by its own switch and by some part's material.
bool throwsShadows(const Scene& scene, const Object& object);

} // namespace halflight
