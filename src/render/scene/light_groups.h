#pragma once
// Light groups on the device (spec S33): pages of the rest and of each group, what they are added up to, and the state
// of weights, and what follows them besides the pages.

#include "gpu/resources.h"
#include "halflight/base/result.h"
#include "halflight/render/probes.h"
#include "halflight/scene/baked_scene.h"
#include "render/scene/gpu_layout.h"

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace halflight {

/// Of composed pages: RGB9E5 where shaders can write it, else half floats, which every device has.
VkFormat composedFormat(const gpu::Device& device);

/// Pages with light are layers of one array, so that one pass adds up all pages of all groups.
class GroupPages {
public:
    GroupPages() = default; ///< no groups
    /// Of a scene that checkScene() has passed.
    GroupPages(gpu::Device& device, gpu::Uploader& uploader, const BakedScene& baked);

    [[nodiscard]] bool any() const { return unitLux_.size() > 1; }
    [[nodiscard]] bool hasDirections() const { return hasDirections_; }
    [[nodiscard]] const gpu::Image& pages() const { return pages_; }
    [[nodiscard]] const gpu::Image& directions() const { return directions_; }
    [[nodiscard]] ivec2 size() const { return {int(pages_.info().width), int(pages_.info().height)}; }
    [[nodiscard]] int pageCount() const { return int(layers_.empty() ? 0 : layers_[0].size()); }

    /// Images for the sum, in no layout yet.
    [[nodiscard]] gpu::Image makeLight(const gpu::Device& device, VkFormat format) const;
    [[nodiscard]] gpu::Image makeDirections(const gpu::Device& device) const;

    /// Lux that a texel of 1 of the sum stands for: the power of two by which no texel is above half of what half
    /// floats and RGB9E5 hold (65,504 and 65,408).
    [[nodiscard]] float unitLux(std::span<const vec3> weights) const;
    /// What each page is made of, a list of listLength() for each. `weights`: by group.
    [[nodiscard]] std::vector<shading::GpuLightSource> sources(std::span<const vec3> weights) const;
    [[nodiscard]] int listLength() const { return int(layers_.size()); }
    /// Rectangles of the rest's pages have changed: their brightest channel, in texels.
    void raisePeak(float brightest);

private:
    struct Layers {
        int page = -1; ///< of pages_; -1: a page without light
        int directions = -1;
    };
    gpu::Image pages_;
    gpu::Image directions_;
    bool hasDirections_ = false;
    // The rest's first, then by group.
    std::vector<std::vector<Layers>> layers_; ///< by page; those of the rest are its pages' numbers
    std::vector<float> unitLux_;
    std::vector<float> peakLux_;
};

struct GpuScene;

struct GroupState {
    GroupPages pages;
    std::vector<vec3> weights;       ///< by GpuScene::outline's groups
    bool pagesChanged = false;       ///< the next frame composes the lightmap
    bool membersChanged = false;     ///< probes, reflections and emission on the device are of other weights
    Scene saved;                     ///< lights, materials and sky as the file has them, nothing else
    SphericalHarmonicsL2 savedSky{}; ///< skyProbe() of the saved sky
};

/// Makes the images of lightmap and directions, to be composed, and lights probes and reflection probes. `scene` has
/// its outline and its probes.
void uploadGroups(gpu::Device& device, gpu::Uploader& uploader, const BakedScene& baked, GpuScene& scene);
/// Sets one weight, by the name of its group; InvalidArgument as groupWeights() has it.
Status setGroupWeight(GpuScene& scene, const std::string& name, vec3 weight);
/// Members have the light of these weights at once, the rest of the scene in the next frame.
void setGroupWeights(GpuScene& scene, std::vector<vec3> weights);
/// The next frame composes the lightmap.
void pagesOfGroupsChanged(GpuScene& scene);
/// A light of the outline has changed: the weight of its group follows where all its lights agree.
void followLight(GpuScene& scene, int light);
/// Brings the light of probes, reflection probes and emission to the device; all objects count as changed.
void uploadGroupMembers(gpu::Device& device, GpuScene& scene);

} // namespace halflight
