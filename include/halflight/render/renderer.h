#pragma once
// The Vulkan renderer: a baked scene in, pictures out; no window needed.

#include "halflight/base/image.h"
#include "halflight/base/result.h"
#include "halflight/render/compose.h"
#include "halflight/render/frame.h"
#include "halflight/scene/baked_scene.h"

#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

// As vulkan/vulkan_core.h declares it, which only programs that draw by Vulkan themselves need.
struct VkCommandBuffer_T;

namespace halflight {

struct VulkanHandles;
struct VulkanTarget;

/// Formulas: halflight/shading/tone_mapping.h. Without one, what is brighter than 1 is cut off.
enum class ToneMapping { Neutral, Aces, Agx, None };
/// As --tone-mapping has it.
const char* nameOf(ToneMapping toneMapping);

enum class DebugView { Lit, Shadowmask, Lightmap, Probes, Cascades, Fade, Overlap, Texels };
/// As --view has it.
const char* nameOf(DebugView view);
/// Whether a view shows light, which is exposed and tone mapped; the others show values from 0 to 1 as they are.
constexpr bool showsLight(DebugView view)
{
    return view == DebugView::Lit || view == DebugView::Lightmap || view == DebugView::Probes;
}

/// Forward lights surfaces as they are drawn. Deferred draws them into a G-buffer and lights the pixels afterwards;
/// what has no single surface per pixel (blended parts), what the lightmap must be known for (static objects on which
/// subtractive's main light casts a realtime shadow this frame) and debug views go forward all the same.
enum class RenderPath { Forward, Deferred };
/// As --path has it.
const char* nameOf(RenderPath path);

struct RendererOptions {
    bool validation = false; ///< turn the Khronos validation layer on (also synchronization validation)
    bool preferCpu = false;  ///< choose the CPU driver even where a GPU is found
    /// Vulkan extensions to enable besides: those that a window system asks for, and VK_KHR_swapchain.
    std::vector<std::string> instanceExtensions;
    std::vector<std::string> deviceExtensions;
    /// The caller's device, which outlives the renderer, instead of one of its own; the options above then have no
    /// effect. Read by create() alone. See vulkan_target.h.
    const VulkanHandles* device = nullptr;
};

struct RenderSettings {
    RunMode mode = RunMode::Realtime;
    RenderPath path = RenderPath::Forward;
    ShadowSettings shadows;
    DebugView view = DebugView::Lit;
    /// Lower limit of subtractive shadows, irradiance in lux, each >= 0; none: the file's (subtractiveShadowColor() of
    /// baked_scene.h).
    std::optional<vec3> subtractiveShadowColor;
    bool directionalLightmaps = true; ///< let normal maps and mirrors see where lightmap light came from, if baked
    /// False: surfaces are diffuse, of shading::transportAlbedo(), so that a bake can be judged without what its
    /// renderer adds.
    bool specular = true;
    bool reflectionProbes = true; ///< reflect what the reflection probes show, in files that have some
    ivec2 size{1280, 720};
    int supersampling = 1; ///< 1…4: each pixel is the mean radiance of supersampling^2 samples on a regular grid
    /// Objects that have a proxy volume (Object::probeLighting) are lit by it; false: every object by one probe sample.
    bool proxyVolumes = true;
    bool lightRows = false; ///< fill RenderedFrame::lights
    /// Measure each pass. The device then ends one before it begins the next, so a frame may take a little longer.
    bool timings = false;
    /// record() shows the picture of its last call, or of render()'s, once more where nothing that it shows has
    /// changed: camera, settings, scene, lights, objects, lightmaps. Only exposure and tone mapping are done anew. For
    /// windows at rest.
    bool keepsPicture = false;
    bool operator==(const RenderSettings&) const = default;
};

/// What one pass of a frame drew and how long that took.
struct PassReport {
    std::string name;
    int draws = 0;             ///< draw calls
    int64_t instances = 0;     ///< mesh parts in them: a draw call of n instances counts n
    int64_t triangles = 0;     ///< of all instances
    double milliseconds = 0.0; ///< by the device's timestamps; 0 where RenderedFrame::timed is false
};

struct RenderedFrame {
    ImageRgba32f radiance; ///< linear, no exposure, no tone mapping; alpha 1
    FramePlan plan;
    std::vector<LightRow> lights; ///< one for each light of the scene; only where RenderSettings::lightRows asks
    /// In the order of drawing: "compose" where a light group's weight has changed, "directional shadows", "spot
    /// shadows", "point shadows", "depth", in the deferred path "g-buffer" and "deferred light", then "forward", "sky",
    /// "blended", and "readback" (the picture to the host) or "display" (the displayed picture into the caller's
    /// image).
    std::vector<PassReport> passes;
    bool isKept = false; ///< record() showed the last picture once more: RenderSettings::keepsPicture
    bool timed = false;  ///< settings asked for timings and the device has timestamps
    /// Targets of the G-buffer, the picture itself among them: 4, and a fifth for baked shadows in frames that use a
    /// mask (plan.usesMask); 0 when all was drawn forward.
    int gBufferTargets = 0;
    /// Whether surfaces lit as they were drawn read the shadowmask (spec S11): in frames where a light uses it, where
    /// subtractive shadows need it, and in the view of it.
    bool forwardReadsMask = false;
    int forwardObjects = 0; ///< objects in view whose opaque and masked parts were lit as they were drawn
};

/// A part of a lightmap page.
struct LightmapRectangle {
    int page = 0;
    ivec2 offset{0};                         ///< of its texel (0, 0) on the page
    const Image<uint32_t>* texels = nullptr; ///< RGB9E5
};

/// How large textures are on the device. Coarse ones have at most 128 texels along a side and come in a fraction of the
/// time, for a first picture.
enum class TextureDetail { Coarse, Full };

/// Frames that record() prepares while the device may still work on those before.
constexpr int kFramesInFlight = 2;

/// Holds the Vulkan device and one uploaded scene.
///
/// What lights a surface, by mode. Direct light: every light of the frame plan, times its shadow attenuation by the law
/// (shading/law.h). Indirect light: the lightmap on static objects that have one, else the probes, at the object's
/// middle or from its proxy volume; in realtime mode neither, but the open sky (nothing where the sky is black). Either
/// reflects diffusely and, blurred, in the specular lobe, dimmed by the material's occlusion texture.
///
/// Both sides of surfaces cast realtime shadows, as they stop the bake's rays; alpha-blended ones keep back the share
/// of light that their alpha says, as in the bake. They are drawn after all others, the farthest middle of a mesh part
/// first.
///
/// No function of it throws: a device that is lost or out of memory is ErrorCode::DeviceFailed.
class Renderer {
public:
    /// DeviceFailed with the reason when no Vulkan 1.3 device with the needed features is found.
    static Result<std::unique_ptr<Renderer>> create(const RendererOptions& options = {});
    ~Renderer();

    [[nodiscard]] std::string deviceName() const;
    [[nodiscard]] std::string driver() const; ///< its name and version

    /// Uploads the scene, replacing the one before. The scene is copied where the renderer needs it afterwards.
    Status load(const BakedScene& baked);

    /// load() in two steps, for windows that go on drawing meanwhile. upload() may run on a thread of its own while
    /// another one calls record() and the setters; the device then holds both scenes. It ends with Cancelled soon after
    /// `cancel` is set. show() replaces the scene by the
    /// uploaded one. What setters changed during the upload is in the scene before alone.
    class Uploaded;
    Result<std::shared_ptr<Uploaded>> upload(const BakedScene& baked, TextureDetail detail = TextureDetail::Full,
                                             const std::atomic<bool>* cancel = nullptr);
    Status show(const std::shared_ptr<Uploaded>& uploaded);

    /// Makes, on a thread of its own, what the forward path needs for pictures without or with a shadowmask, so that
    /// the first one does not wait for the driver's compiler: call it before a file is read, or when a bake that will
    /// have a mask begins. Never waits.
    void prepareForward(bool shadowmask);

    /// The scene as it is drawn, by the loaded scene's indices: objects, lights, sky; no vertices, no pixels. Empty
    /// before load().
    [[nodiscard]] const Scene& scene() const;

    /// What may change between frames without loading anew. InvalidArgument for an index or a value that cannot be;
    /// nothing changes then.
    ///
    /// Everything of a light but its name, its type and what the bake made of it. Baked shadows stay right when colour
    /// or intensity change. FramePlan::warnings names each change that shows nowhere or in part: changesSinceBake().
    ///
    /// S33. Where all lights of a light group then have their colour times intensity at the weight 1 times one factor
    /// by channel, to 1/10,000, that factor is the group's new weight: bounced light, baked lights and emission follow.
    /// A light that is a group by itself always sets it. Otherwise only the light's direct light changes.
    ///
    /// S34. The groups of a light that turns (turning_lights.h) have the weights of its direction and its light.
    Status setLight(int light, const Light& changed);

    /// S33. The weight of a light group, by channel, 0 to kMostGroupWeight: what its light at the weight 1 is
    /// multiplied with. Lights of the group have their colour times intensity at 1 times the weight, in scene() too,
    /// whatever setLight() made of them; emission, lightmap, probes, reflection probes and the drawn sky follow in the
    /// next frame. That one has a pass "compose" more, which adds up the lightmap's pages. FramePlan::warnings names
    /// groups with so little light in reflection probes that they keep it there. "sky" sets all parts of a sky that
    /// changes, the name of a light that turns its directions. InvalidArgument names a group that the scene lacks, a
    /// single direction, or a weight that cannot be.
    Status setLightGroup(const std::string& name, vec3 weight);
    /// The groups of the loaded scene with their weights now, in the file's order; a light that turns is one.
    [[nodiscard]] std::vector<GroupWeight> lightGroups() const;

    /// A dynamic object takes the probe light of its new place. A static one keeps its lightmap.
    Status setObjectTransform(int object, const mat4& worldFromObject);
    /// Baked shadows do not follow: FramePlan::warnings names static objects whose switches differ from the bake's.
    Status setObjectShadows(int object, bool castShadows, bool receiveShadows);

    /// Replaces rectangles of lightmap pages, of a bake that still runs, say (BakeSession). Texels are in the scene's
    /// lightmapUnitLux; in a scene with light groups they are the rest's. InvalidArgument for rectangles that are not
    /// on a page; nothing changes then.
    Status updateLightmaps(std::span<const LightmapRectangle> rectangles);

    /// S32. Irradiance (lux) that is added to the lightmap's in every mode that reads lightmaps, after subtraction: one
    /// page for each lightmap page, in the lightmap's layout and of any one size. Pages of the size before are written
    /// into the same image, so that a set may be passed each frame. It has no direction, and neither subtraction nor
    /// shadows dim it. An empty span takes the set away; load() does, too. InvalidArgument for another number of pages,
    /// pages that differ in size, and values that are below 0 or not finite; nothing changes then.
    Status setDynamicLightmaps(std::span<const ImageRgb32f> irradiance);

    /// InvalidArgument for settings outside their limits, a camera without extent, or a mode the bake holds no data
    /// for.
    Result<RenderedFrame> render(const Camera& camera, const RenderSettings& settings);

    /// Records a frame, tone mapped for display, into an image of the caller; exposure as in displayedPicture(). Its
    /// commands belong on the queue of handles(), in the order of the calls. Before the call the device has finished
    /// the commands of the call kFramesInFlight before (wait for their fence), and those of all calls before another
    /// function of the renderer than this and the setters is called, or the renderer goes (waitIdle()).
    ///
    /// The frame that is returned has no radiance, and its `passes` are those of the call kFramesInFlight before, none
    /// in the first ones. Errors are those of render(); the command buffer may then hold a part of the frame.
    Result<RenderedFrame> record(VkCommandBuffer_T* commands, const VulkanTarget& target, const Camera& camera,
                                 const RenderSettings& settings, float exposureEv,
                                 ToneMapping toneMapping = ToneMapping::Neutral);
    /// The device that the renderer uses, to make a swapchain, say.
    [[nodiscard]] VulkanHandles handles() const;
    /// Waits until the device has done all that was submitted to it.
    void waitIdle() const;

    /// Messages of the validation layer since creation: empty when all is well or validation is off.
    [[nodiscard]] std::vector<std::string> validationMessages() const;

private:
    Renderer();
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

/// Linear radiance to a displayed picture: exposure (EV: radiance * 2^-ev), tone mapping, sRGB.
ImageRgba8 displayedPicture(const ImageRgba32f& radiance, float exposureEv,
                            ToneMapping toneMapping = ToneMapping::Neutral);

/// Values from 0 to 1, as views that show no light have them (showsLight()), as they are.
ImageRgba8 plainPicture(const ImageRgba32f& values);

/// EV that puts the log-average luminance at middle grey 0.18 (Reinhard et al. 2002, "Photographic Tone Reproduction
/// for Digital Images", eq. 1), or up to 2 stops more, until at most 2 % of the pixels are burnt: more than 4, white.
float automaticExposure(const ImageRgba32f& radiance);

} // namespace halflight
