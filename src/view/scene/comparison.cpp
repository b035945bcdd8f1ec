#include "view/scene/comparison.h"

#include "halflight/render/vulkan_target.h"
#include "view/state/picture_size.h"

#include <imgui.h>
#include <spdlog/fmt/fmt.h>

#include <chrono>
#include <string>
#include <utility>

namespace halflight::view {
namespace {

/// A small picture compiles what the first frame needs.
Result<std::unique_ptr<Renderer>> makeRenderer(const VulkanHandles& handles, const BakedScene& baked,
                                               const Camera& camera, const RenderSettings& settings)
{
    RendererOptions options;
    options.device = &handles;
    Result<std::unique_ptr<Renderer>> renderer = Renderer::create(options);
    if (!renderer) return renderer;
    if (Status status = (*renderer)->load(baked); !status) return status.error();
    if (const auto drawn = (*renderer)->render(camera, settings); !drawn) return drawn.error();
    return renderer;
}

} // namespace

void Comparison::keepEarlier(std::optional<BakedScene> earlier)
{
    earlierLoading_ = {};
    if (earlierRenderer_) earlierRenderer_->waitIdle(); // frames in flight show it
    earlierRenderer_.reset();
    earlier_ = std::move(earlier);
}

void Comparison::forget()
{
    keepEarlier(std::nullopt);
    report_.hasEarlier = false;
    if (state_.compareWith != Compare::BeforeBake) return;
    state_.compares = false;
    state_.compareWith = Compare::Mode;
}

void Comparison::leaveDevice()
{
    earlierLoading_ = {};
    earlierRenderer_.reset();
    pathTraced_.reset(); // its picture is on that device
}

bool Comparison::wantsEarlier() const
{
    return state_.compares && state_.compareWith == Compare::BeforeBake && earlier_;
}

RunMode Comparison::earlierMode() const
{
    const RunMode mode = state_.settings.mode;
    return checkRunMode(*earlier_, mode) ? mode : defaultRunMode(*earlier_);
}

Status Comparison::followEarlier(const Renderer& renderer, const EditedScene& edited, ivec2 size)
{
    if (!earlierLoading_.valid()) {
        if (!wantsEarlier() || earlierRenderer_) return {};
        RenderSettings settings = settingsOfFrame(state_, edited.bounds(), smallPicture(vec2(size)));
        settings.mode = earlierMode();
        earlierLoading_ = std::async(std::launch::async, [handles = renderer.handles(), &earlier = *earlier_, settings,
                                                          camera = state_.navigator.camera()] {
            return makeRenderer(handles, earlier, camera, settings);
        });
    }
    if (earlierLoading_.wait_for(std::chrono::seconds(0)) != std::future_status::ready) return {};
    Result<std::unique_ptr<Renderer>> made = earlierLoading_.get();
    if (!made) return made.error();
    earlierRenderer_ = std::move(*made);
    return {};
}

void Comparison::followReference(EditedScene& edited, ivec2 size, UiRenderer& ui)
{
    const bool wanted = state_.compares && state_.compareWith == Compare::Reference;
    constexpr std::chrono::milliseconds kRest(250); // while an object is dragged, nothing is copied
    if (!wanted || size.x < 1 || EditedScene::Clock::now() - edited.lastChange() < kRest) {
        if (reference_) reference_->pause();
        pathTraced_.reset();
        report_.referenceSamples = 0;
        return;
    }
    if (!reference_) reference_.emplace();
    if (reference_->follow(edited.snapshot(), state_.navigator.camera(), size, state_.settings.specular)) {
        pathTraced_.reset();
        report_.referenceSamples = 0;
    }
    std::optional<ReferencePicture::Picture> picture = reference_->take();
    const bool isNew = picture.has_value();
    if (isNew) pathTraced_ = std::move(picture);
    if (!pathTraced_ || (!isNew && pathTracedEv_ == state_.exposureEv && pathTracedTone_ == state_.toneMapping)) return;
    pathTracedEv_ = state_.exposureEv;
    pathTracedTone_ = state_.toneMapping;
    report_.referenceSamples = pathTraced_->samples;
    ui.setPicture(displayedPicture(pathTraced_->radiance, state_.exposureEv, state_.toneMapping));
}

std::optional<Comparison::Side> Comparison::rightSide(Renderer& renderer) const
{
    if (state_.compares && state_.compareWith == Compare::Mode) return Side{&renderer, state_.otherMode};
    if (wantsEarlier() && earlierRenderer_) return Side{earlierRenderer_.get(), earlierMode()};
    return std::nullopt;
}

void Comparison::drawLine() const
{
    ImDrawList* list = ImGui::GetBackgroundDrawList();
    const ImVec2 size = ImGui::GetIO().DisplaySize;
    const float x = state_.split * size.x;
    std::string right = nameOf(state_.otherMode);
    if (state_.compareWith == Compare::BeforeBake) right = report_.hasEarlier ? "before the bake" : "";
    if (state_.compareWith == Compare::Reference) {
        right = pathTraced_ ? fmt::format("path traced, samples a pixel: {}", pathTraced_->samples) : "path tracing";
        if (pathTraced_) {
            list->PushClipRect(ImVec2(x, 0.0f), size);
            list->AddImage(reinterpret_cast<ImTextureID>(UiRenderer::kPicture), ImVec2(0.0f, 0.0f), size);
            list->PopClipRect();
        }
    }
    list->AddLine(ImVec2(x, 0.0f), ImVec2(x, size.y), IM_COL32(255, 255, 255, 160));
    const std::string left =
        state_.compareWith == Compare::BeforeBake ? "after the bake" : std::string(nameOf(state_.settings.mode));
    const float gap = 0.5f * ImGui::GetFontSize();
    const float y = size.y - 2.0f * ImGui::GetFontSize();
    const auto label = [&](const std::string& text, float at) {
        const ImVec2 extent = ImGui::CalcTextSize(text.c_str());
        list->AddRectFilled(ImVec2(at - gap, y - 2.0f), ImVec2(at + extent.x + gap, y + extent.y + 2.0f),
                            IM_COL32(0, 0, 0, 140));
        list->AddText(ImVec2(at, y), IM_COL32_WHITE, text.c_str());
    };
    label(left, x - 2.0f * gap - ImGui::CalcTextSize(left.c_str()).x);
    if (!right.empty()) label(right, x + 2.0f * gap);
}

} // namespace halflight::view
