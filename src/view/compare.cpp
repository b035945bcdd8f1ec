// The picture: one scene, or two sides of a line, and what is drawn over it.
#include "view/panels.h"
#include "view/viewer.h"

#include <imgui.h>
#if __has_include(<backends/imgui_impl_sdl2.h>)
#include <backends/imgui_impl_sdl2.h>
#else
#include <backends/imgui_impl_sdl.h>
#endif
#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace halflight::view {

RenderSettings Viewer::settingsFor(ivec2 size) const
{
    RenderSettings settings = state_.settings;
    settings.size = size;
    const Camera camera = state_.navigator.camera();
    if (state_.followsShadowDistance)
        settings.shadows = shadowsReaching(farthestInView({camera, size}, bounds_), settings.shadows);
    return settings;
}

bool Viewer::wantsEarlier() const
{
    return state_.compares && state_.compareWith == Compare::BeforeBake && earlier_;
}

/// Makes the renderer of what was shown before the bake, on the same device and another thread. A small picture
/// compiles what its first frame needs.
Status Viewer::followEarlier()
{
    if (!wantsEarlier() || earlierRenderer_) return {};
    if (!earlierLoading_.valid()) {
        RenderSettings settings = settingsFor(smallPicture(vec2(size_)));
        if (!checkRunMode(*earlier_, settings.mode)) settings.mode = defaultRunMode(*earlier_);
        earlierLoading_ = std::async(std::launch::async,
                                     [handles = renderer_->handles(), &earlier = *earlier_, settings,
                                      camera = state_.navigator.camera()]() -> Result<std::unique_ptr<Renderer>> {
                                         RendererOptions options;
                                         options.device = &handles;
                                         Result<std::unique_ptr<Renderer>> renderer = Renderer::create(options);
                                         if (!renderer) return renderer;
                                         if (Status status = (*renderer)->load(earlier); !status) return status.error();
                                         if (const auto drawn = (*renderer)->render(camera, settings); !drawn)
                                             return drawn.error();
                                         return renderer;
                                     });
    }
    if (earlierLoading_.wait_for(std::chrono::seconds(0)) != std::future_status::ready) return {};
    Result<std::unique_ptr<Renderer>> renderer = earlierLoading_.get();
    if (!renderer) return renderer.error();
    earlierRenderer_ = std::move(*renderer);
    return {};
}

/// Right of the line.
Status Viewer::drawOther(const Swapchain::Frame& frame, RenderSettings settings, VulkanTarget target)
{
    Renderer* renderer = renderer_.get();
    if (state_.compareWith == Compare::Mode) {
        settings.mode = state_.otherMode;
    } else {
        renderer = earlierRenderer_.get();
        if (!checkRunMode(*earlier_, settings.mode)) settings.mode = defaultRunMode(*earlier_);
    }
    auto drawn = renderer->record(frame.commands, target, state_.navigator.camera(), settings, state_.exposureEv,
                                  state_.toneMapping);
    if (!drawn) return drawn.error();
    drewPicture_ = !drawn->isKept;
    return {};
}

/// Coarse while the view changes and soon after, where frames take long; no finer than half while a bake needs the
/// processor, or while textures are coarse.
PictureDetail Viewer::chooseDetail(ivec2 size)
{
    const Camera camera = state_.navigator.camera();
    const bool moves =
        frames_ > 0 && (camera != drawnCamera_ || state_.settings != drawnSettings_ || lastEdit_ != drawnEdit_);
    drawnCamera_ = camera;
    drawnSettings_ = state_.settings;
    drawnEdit_ = lastEdit_;
    if (state_.settings.timings) return PictureDetail::Full; // what is measured is a whole frame
    const bool pauses = Clock::now() - lastInput_ < kAfterInput;
    const Motion motion = moves ? Motion::Moves : pauses ? Motion::Pauses : Motion::Rests;
    return details_.next(size, motion, session_ || texturesAreCoarse_ ? PictureDetail::Half : PictureDetail::Full);
}

Status Viewer::drawScene(const Swapchain::Frame& frame)
{
    if (!shown_) return {};
    const PictureDetail detail = chooseDetail(frame.size);
    RenderSettings settings = settingsOf(settingsFor(pictureSize(frame.size, detail)), detail);
    settings.keepsPicture = !settings.timings;
    state_.shadowDistanceMeters = settings.shadows.distanceMeters;
    VulkanTarget target{frame.view, swapchain_->format(), frame.size};
    const int line = int(std::lround(state_.split * float(frame.size.x)));
    const bool draws = (state_.compares && state_.compareWith == Compare::Mode) || (wantsEarlier() && earlierRenderer_);
    const bool twice = draws && state_.compareWith == Compare::Mode;
    // Frames that compare modes record twice, and record() wants all but the last recording done.
    if (twice || compared_) swapchain_->waitIdle();
    compared_ = twice;
    if (draws) {
        target.begin = ivec2(line, 0);
        if (Status status = drawOther(frame, settings, target); !status) return status;
        target.begin = ivec2(0);
        target.end = ivec2(line, frame.size.y);
    }
    if (!draws || line > 0) {
        auto drawn = renderer_->record(frame.commands, target, state_.navigator.camera(), settings, state_.exposureEv,
                                       state_.toneMapping);
        if (!drawn) return drawn.error();
        drewPicture_ = drewPicture_ || !drawn->isKept;
        state_.passes = std::move(drawn->passes);
        state_.timed = drawn->timed;
        if (drawn->timed) addFrame(state_.passesOfFrames, state_.passes);
        if (!settings.timings) state_.passesOfFrames.clear();
        frameWarnings_ = std::move(drawn->plan.warnings);
    }
    return {};
}

/// Traces the view while it rests, if it is compared with.
void Viewer::followReference()
{
    const bool wanted = shown_ && state_.compares && state_.compareWith == Compare::Reference;
    constexpr std::chrono::milliseconds kRest(250); // while an object is dragged, nothing is copied
    if (!wanted || size_.x < 1 || (!referenceScene_ && Clock::now() - lastEdit_ < kRest)) {
        if (reference_) reference_->pause();
        pathTraced_.reset();
        state_.referenceSamples = 0;
        return;
    }
    if (!referenceScene_) referenceScene_ = std::make_shared<const Scene>(scene_);
    if (!reference_) reference_.emplace();
    if (reference_->follow(referenceScene_, state_.navigator.camera(), size_)) {
        pathTraced_.reset();
        state_.referenceSamples = 0;
    }
    std::optional<ReferencePicture::Picture> picture = reference_->take();
    const bool isNew = picture.has_value();
    if (isNew) pathTraced_ = std::move(picture);
    if (!pathTraced_ || (!isNew && pathTracedEv_ == state_.exposureEv && pathTracedTone_ == state_.toneMapping)) return;
    pathTracedEv_ = state_.exposureEv;
    pathTracedTone_ = state_.toneMapping;
    state_.referenceSamples = pathTraced_->samples;
    ui_->setPicture(displayedPicture(pathTraced_->radiance, state_.exposureEv, state_.toneMapping));
}

void Viewer::buildPanels(bool isDrawn)
{
    ImGui_ImplSDL2_NewFrame();
    panelInput_.beginFrame();
    ImGui::NewFrame();
    if (shown_) {
        collectWarnings();
        drawPanels(state_, scene_);
        if (state_.compares) drawCompared();
        drawGizmo();
    }
    if (isDrawn) drawNotice();
    ImGui::Render();
    applyEdits();
}

/// What is being read, or what was said just now, at the bottom.
void Viewer::drawNotice() const
{
    constexpr std::chrono::seconds kShown(4);
    std::string text;
    if (opening_) {
        const double seconds = std::chrono::duration<double>(Clock::now() - opening_->start).count();
        const std::string name = opening_->file.filename().string();
        const OpeningStage stage = openingStage_;
        text = fmt::format("{} {}, {:.0f} s",
                           stage == OpeningStage::Read     ? "loading"
                           : stage == OpeningStage::Upload ? "uploading"
                                                           : "preparing the picture of",
                           name, seconds);
    } else if (earlierLoading_.valid()) {
        text = "preparing the light before the bake";
    } else if (Clock::now() - noticeTime_ < kShown) {
        text = notice_;
    } else if (shown_ && details_.last() != PictureDetail::Full && !state_.settings.timings) {
        text = details_.last() == PictureDetail::Coarse ? "coarse picture" : "picture of half the resolution";
    }
    if (text.empty()) return;
    const ImVec2 size = ImGui::GetIO().DisplaySize;
    const float gap = 0.5f * ImGui::GetFontSize();
    const float width = std::max(size.x - 4.0f * gap, ImGui::GetFontSize());
    const ImVec2 extent = ImGui::CalcTextSize(text.c_str(), nullptr, false, width);
    const ImVec2 at(0.5f * (size.x - extent.x), size.y - extent.y - 4.0f * gap - ImGui::GetFontSize());
    ImDrawList* list = ImGui::GetForegroundDrawList();
    list->AddRectFilled(ImVec2(at.x - gap, at.y - gap), ImVec2(at.x + extent.x + gap, at.y + extent.y + gap),
                        IM_COL32(0, 0, 0, 200), gap);
    list->AddText(nullptr, 0.0f, at, IM_COL32_WHITE, text.c_str(), nullptr, width);
}

/// The line, what is on both sides of it, and the path-traced picture.
void Viewer::drawCompared()
{
    ImDrawList* list = ImGui::GetBackgroundDrawList();
    const ImVec2 size = ImGui::GetIO().DisplaySize;
    const float x = state_.split * size.x;
    std::string right = nameOf(state_.otherMode);
    if (state_.compareWith == Compare::BeforeBake) right = state_.hasEarlier ? "before the bake" : "";
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

/// Arrows of the selected object, if it is a dynamic one.
void Viewer::drawGizmo()
{
    if (state_.selectedObject < 0 || scene_.objects[std::size_t(state_.selectedObject)].isStatic) return;
    const vec2 size(ImGui::GetIO().DisplaySize.x, ImGui::GetIO().DisplaySize.y);
    const vec3 place(scene_.objects[std::size_t(state_.selectedObject)].worldFromObject[3]);
    const std::optional<Gizmo::Shape> shape = Gizmo::shapeOf(state_.navigator.camera(), place, size);
    if (!shape) return;
    const vec2 mouse(ImGui::GetIO().MousePos.x, ImGui::GetIO().MousePos.y);
    const int under = gizmo_.arrow() >= 0 ? gizmo_.arrow() : Gizmo::arrowAt(*shape, mouse);
    constexpr std::array kColors = {IM_COL32(235, 70, 60, 255), IM_COL32(90, 200, 70, 255),
                                    IM_COL32(70, 120, 240, 255)};
    ImDrawList* list = ImGui::GetBackgroundDrawList();
    for (int arrow = 0; arrow < 3; ++arrow) {
        const vec2 tip = shape->tips[std::size_t(arrow)];
        const ImU32 color = arrow == under ? IM_COL32(255, 220, 60, 255) : kColors[std::size_t(arrow)];
        list->AddLine(ImVec2(shape->center.x, shape->center.y), ImVec2(tip.x, tip.y), color, 3.0f);
        list->AddCircleFilled(ImVec2(tip.x, tip.y), 5.0f, color);
    }
}

/// Takes hold of an arrow under the mouse.
bool Viewer::dragGizmo(vec2 mouse)
{
    if (state_.selectedObject < 0 || scene_.objects[std::size_t(state_.selectedObject)].isStatic) return false;
    const vec2 size(ImGui::GetIO().DisplaySize.x, ImGui::GetIO().DisplaySize.y);
    const vec3 place(scene_.objects[std::size_t(state_.selectedObject)].worldFromObject[3]);
    const Camera camera = state_.navigator.camera();
    const std::optional<Gizmo::Shape> shape = Gizmo::shapeOf(camera, place, size);
    const int arrow = shape ? Gizmo::arrowAt(*shape, mouse) : -1;
    if (arrow >= 0) gizmo_.grab(camera, place, arrow, mouse, size);
    return arrow >= 0;
}

} // namespace halflight::view
