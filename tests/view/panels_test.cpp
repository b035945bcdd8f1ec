// Panels and keys, without a window: every section is drawn, and what is clicked and typed reaches the state.
#include "view/panels/light_direction.h"
#include "view/panels/panel_sections.h"
#include "view/panels/panels.h"

#include <SDL_keycode.h>
#include <gtest/gtest.h>
#include <imgui.h>

#include <cmath>
#include <optional>
#include <random>
#include <set>
#include <utility>

namespace halflight::view::panels_test {
namespace {

Scene smallScene()
{
    Scene scene;
    for (const LightType type : {LightType::Directional, LightType::Point, LightType::Spot}) {
        Light& light = scene.lights.emplace_back();
        light.name = "a light";
        light.type = type;
    }
    for (int i = 0; i < 200; ++i) scene.objects.emplace_back().name = "thing";
    scene.cameras.resize(2);
    return scene;
}

class Panels : public testing::Test {
protected:
    void SetUp() override
    {
        ImGui::CreateContext();
        ImGuiIO& io = ImGui::GetIO();
        io.IniFilename = nullptr;
        io.DisplaySize = ImVec2(400.0f, 4000.0f); // all sections at once
        io.DeltaTime = 1.0f / 60.0f;
        unsigned char* texels = nullptr;
        int width = 0;
        int height = 0;
        io.Fonts->GetTexDataAsRGBA32(&texels, &width, &height);
        report.modes = {RunMode::Realtime, RunMode::BakedIndirect, RunMode::Shadowmask};
        picture.passes = {{"depth", 3, 3, 100, 1.0}};
        window.frameMilliseconds = {16.0f, 17.0f};
        window.warnings = {"something is odd"};
        window.title = "file.glb";
    }
    void TearDown() override { ImGui::DestroyContext(); }

    /// One frame; the vertices that were drawn.
    int frame()
    {
        ImGui::NewFrame();
        take(drawPanels(shown()));
        ImGui::Render();
        return ImGui::GetDrawData()->TotalVtxCount;
    }
    /// Ctrl and a click, text, and a click elsewhere, where typing ends: show() draws a frame, typed() comes after each
    /// character.
    template<typename Show, typename Typed>
    static void type(ImVec2 place, const char* text, const Show& show, const Typed& typed)
    {
        ImGuiIO& io = ImGui::GetIO();
        io.MousePos = place;
        show();
        io.KeyCtrl = io.MouseDown[0] = true;
        show();
        io.KeyCtrl = io.MouseDown[0] = false;
        show();
        for (const char* c = text; *c != '\0'; ++c) {
            io.AddInputCharacter(unsigned(*c));
            show();
            typed(*c);
        }
        io.MousePos = ImVec2(395.0f, 395.0f);
        io.MouseDown[0] = true;
        show();
        io.MouseDown[0] = false;
        show();
    }
    void click(float x, float y)
    {
        ImGuiIO& io = ImGui::GetIO();
        io.MousePos = ImVec2(x, y);
        frame();
        io.MouseDown[0] = true;
        frame();
        io.MouseDown[0] = false;
        frame();
    }

    void press(int key, bool control = false) { take(answerKey(shown(), key, control)); }
    Shown shown() const { return {state, scene, report, bake, picture, comparison, window, groups}; }
    void take(Answer answer)
    {
        state = std::move(answer.choices);
        changes.insert(changes.end(), answer.changes.begin(), answer.changes.end());
        requests.insert(requests.end(), answer.requests.begin(), answer.requests.end());
    }
    /// What was asked for last, and no more than that.
    std::optional<Action> onlyAction()
    {
        const std::vector<Request> asked = std::exchange(requests, {});
        const auto* action = asked.size() == 1 ? std::get_if<Action>(&asked[0]) : nullptr;
        return action != nullptr ? std::optional(*action) : std::nullopt;
    }

    Scene scene = smallScene();
    ViewState state;
    SceneReport report;
    BakeStatus bake;
    PictureReport picture;
    CompareReport comparison;
    WindowReport window;
    std::vector<GroupReport> groups;
    std::vector<SceneChange> changes; ///< and requests, since they were last looked at
    std::vector<Request> requests;
};

TEST(PanelScale, IsOneAtUsualDisplays)
{
    for (const float usual : {0.0f, -1.0f, 72.0f, 96.0f, 100.0f, std::nanf("")}) EXPECT_EQ(panelScale(usual), 1.0f);
    EXPECT_EQ(panelScale(144.0f), 1.5f);
    EXPECT_EQ(panelScale(163.0f), 1.75f);
    EXPECT_EQ(panelScale(192.0f), 2.0f);
    EXPECT_EQ(panelScale(5000.0f), 4.0f);
}

TEST(PanelLightS34, HasAHeightAndABearing)
{
    const LightSource east = sourceOf(vec3(-1.0f, 0.0f, 0.0f)); // from +X
    EXPECT_NEAR(east.height, 0.0f, 1e-3f);
    EXPECT_NEAR(east.bearing, 90.0f, 1e-3f);
    EXPECT_NEAR(sourceOf(glm::normalize(vec3(0.0f, -1.0f, 1.0f))).height, 45.0f, 1e-3f);
    for (const float height : {-30.0f, 0.0f, 20.0f, 89.9f})
        for (const float bearing : {-170.0f, -90.0f, 0.0f, 45.0f, 179.0f}) {
            const mat4 pose = poseFrom({height, bearing}, vec3(1, 2, 3));
            EXPECT_NEAR(glm::determinant(mat3(pose)), 1.0f, 1e-5f) << "rigid";
            EXPECT_EQ(vec3(pose[3]), vec3(1, 2, 3));
            const LightSource again = sourceOf(-vec3(pose[2]));
            EXPECT_NEAR(again.height, height, 0.01f);
            EXPECT_NEAR(again.bearing, bearing, 0.1f);
        }
}

TEST_F(Panels, AreAtTheLeftOfThePicture)
{
    frame();
    EXPECT_TRUE(overPanels(state, vec2(20.0f, 500.0f)));
    EXPECT_FALSE(overPanels(state, vec2(390.0f, 500.0f)));
    state.panels = false;
    EXPECT_FALSE(overPanels(state, vec2(20.0f, 500.0f)));
}

TEST_F(Panels, AreDrawnUnlessHidden)
{
    frame();
    EXPECT_GT(frame(), 500);
    state.panels = false;
    frame();
    EXPECT_EQ(frame(), 0);
}

TEST_F(Panels, GraphOfPassesHasAColumnForEachFrame)
{
    const auto vertices = [&] {
        ImGui::NewFrame();
        ImGui::Begin("panels");
        ImGui::SetNextItemOpen(true);
        Answer answer{state, {}, {}};
        frameSection(shown(), answer);
        ImGui::End();
        ImGui::Render();
        return ImGui::GetDrawData()->TotalVtxCount;
    };
    window.frameMilliseconds.clear();
    vertices();
    const int none = vertices();
    window.frameMilliseconds.assign(kShownFrames, 16.0f);
    EXPECT_GE(vertices(), none + 100) << "the frames' own graph";
    picture.timed = true;
    state.settings.timings = true;
    vertices();
    const int without = vertices();
    picture.passes = {{"depth", 3, 3, 100, 1.0}, {"light", 3, 3, 100, 2.0}};
    for (int i = 0; i < 10; ++i) addFrame(picture.passesOfFrames, picture.passes);
    vertices(); // the window takes its size
    const int some = vertices();
    EXPECT_GE(some, without + 10 * 2 * 4) << "a rectangle for each pass of each frame";
    for (int i = 0; i < 1000; ++i) addFrame(picture.passesOfFrames, picture.passes);
    EXPECT_EQ(picture.passesOfFrames.size(), kShownFrames);
    EXPECT_EQ(vertices(), some + int(kShownFrames - 10) * 2 * 4);
}

TEST_F(Panels, NumbersThatAreTypedStayWithinTheirLimits)
{
    float value = 0.5f;
    const auto show = [&] {
        ImGui::NewFrame();
        ImGui::SetNextWindowPos(ImVec2(0, 0));
        ImGui::SetNextWindowSize(ImVec2(300, 100));
        ImGui::Begin("panels");
        drag("number", value, 0.01f, 0.25f, 4.0f, "%.2f");
        const ImVec2 corner = ImGui::GetItemRectMin();
        ImGui::End();
        ImGui::Render();
        return corner;
    };
    const ImVec2 corner = show();
    for (const char* text : {"0.1", "-3", "99", "1e30"}) {
        type(ImVec2(corner.x + 5.0f, corner.y + 5.0f), text, show, [&](char c) {
            EXPECT_GE(value, 0.25f) << text << " at " << c;
            EXPECT_LE(value, 4.0f) << text << " at " << c;
        });
        EXPECT_EQ(value, *text == '0' || *text == '-' ? 0.25f : 4.0f) << text;
    }
}

// Weights are typed beyond the slider's end, and what is no weight is cut; off keeps the colour.
TEST_F(Panels, GroupsHaveASliderAndAColourS33)
{
    groups = {{"lamps", vec3(0.5f, 0.25f, 0.0f), vec3(1.0f), vec3(1.0f, 0.5f, 0.0f)}};
    const auto show = [&] {
        ImGui::NewFrame();
        ImGui::SetNextWindowPos(ImVec2(0, 0));
        ImGui::SetNextWindowSize(ImVec2(390, 390));
        ImGui::Begin("panels");
        Answer answer{state, {}, {}};
        groupSection(shown(), answer);
        ImGui::End();
        ImGui::Render();
        take(std::move(answer));
    };
    const auto typed = [&](float y, const char* text) -> std::optional<vec3> {
        changes.clear();
        type(ImVec2(30.0f, y), text, show, [](char) {});
        if (changes.empty()) return std::nullopt;
        const auto* change = std::get_if<ChangeGroup>(&changes.back());
        EXPECT_TRUE(change != nullptr && change->name == "lamps");
        return change != nullptr ? std::optional(change->weight) : std::nullopt;
    };
    float slider = -1.0f;
    for (float y = 30.0f; y < 120.0f && slider < 0.0f; y += 4.0f) // below the title
        if (typed(y, "7") == vec3(7.0f, 3.5f, 0.0f)) slider = y;
    ASSERT_GT(slider, 0.0f) << "no slider takes a weight";
    EXPECT_EQ(typed(slider, "-3"), vec3(0.0f));
    groups[0].weight = vec3(0.0f);
    EXPECT_EQ(typed(slider, "0.5"), vec3(0.5f, 0.25f, 0.0f));
    const std::optional<vec3> huge = typed(slider, "1e30");
    ASSERT_TRUE(huge);
    EXPECT_TRUE(std::isfinite(huge->x) && huge->x >= 1.0e9f);
}

TEST(ShownName, HidesNothing)
{
    EXPECT_EQ(shownName("a##b"), "a# #b");
    EXPECT_EQ(shownName("###"), "# # #");
    EXPECT_EQ(shownName("a#b"), "a#b");
}

/// Random clicks open sections and press what is in them. Whatever they do, values stay within their limits, and what
/// is asked for names things that exist.
TEST_F(Panels, SurviveRandomClicks)
{
    std::mt19937 random(3);
    std::set<Action> seen;
    int changedLights = 0;
    int changedSwitches = 0;
    for (int i = 0; i < 12000; ++i) {
        click(float(random() % 360), float(random() % 2600));
        if (i % 500 == 0) bake.running = !bake.running;
        for (const Request& request : std::exchange(requests, {})) {
            if (const auto* action = std::get_if<Action>(&request)) seen.insert(*action);
            if (const auto* through = std::get_if<LookThrough>(&request)) ASSERT_LT(through->camera, 2);
        }
        for (const SceneChange& change : std::exchange(changes, {})) {
            if (const auto* light = std::get_if<ChangeLight>(&change)) {
                ++changedLights;
                ASSERT_LT(std::size_t(light->light), scene.lights.size());
                scene.lights[std::size_t(light->light)] = light->value;
            }
            if (const auto* switches = std::get_if<ChangeSwitches>(&change)) {
                ++changedSwitches;
                ASSERT_LT(std::size_t(switches->object), scene.objects.size());
            }
        }
        ASSERT_TRUE(checkShadowSettings(state.settings.shadows)) << i;
        ASSERT_GE(state.settings.supersampling, 1);
        ASSERT_LE(state.settings.supersampling, 4);
    }
    for (const Action action : {Action::Bake, Action::CancelBake, Action::Screenshot, Action::Expose, Action::Reload})
        EXPECT_TRUE(seen.contains(action)) << int(action);
    EXPECT_GT(changedLights, 0);
    EXPECT_GT(changedSwitches, 0);
}

TEST_F(Panels, KeysDoWhatTheHelpSays)
{
    press(SDLK_3);
    EXPECT_EQ(state.settings.mode, RunMode::Shadowmask);
    press(SDLK_5);
    EXPECT_EQ(state.settings.mode, RunMode::Shadowmask) << "the file has no data for subtractive";
    press(SDLK_p);
    EXPECT_EQ(state.settings.path, RenderPath::Deferred);
    for (int i = 0; i < 8; ++i) press(SDLK_v);
    EXPECT_EQ(state.settings.view, DebugView::Lit) << "once round";
    press(SDLK_b, true);
    EXPECT_TRUE(requests.empty()) << "with control it is another command";
    press(SDLK_s, true);
    EXPECT_EQ(onlyAction(), Action::Save);
    press(SDLK_b);
    EXPECT_EQ(onlyAction(), Action::Bake);
    press(SDLK_TAB);
    EXPECT_FALSE(state.panels);
    for (const Compare with : {Compare::Mode, Compare::Reference}) {
        press(SDLK_c);
        EXPECT_TRUE(state.compares);
        EXPECT_EQ(state.compareWith, with);
    }
    press(SDLK_c);
    EXPECT_FALSE(state.compares);
    comparison.hasEarlier = true;
    press(SDLK_c);
    EXPECT_EQ(state.compareWith, Compare::BeforeBake);
    press(SDLK_r);
    EXPECT_EQ(state.compareWith, Compare::Reference);
    press(SDLK_r);
    EXPECT_FALSE(state.compares);
    EXPECT_TRUE(requests.empty()) << "choices are no requests";
    press(SDLK_ESCAPE);
    EXPECT_EQ(onlyAction(), Action::Leave);
}

} // namespace
} // namespace halflight::view::panels_test
