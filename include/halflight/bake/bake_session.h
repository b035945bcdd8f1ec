#pragma once
// A bake in the background, for editors: it shows light soon, what a camera sees first, and can be cancelled at any
// time.

#include "halflight/bake/bake.h"

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace halflight {

struct BakeSessionState {
    std::string stage;              ///< "first light", "lightmap", …
    double fraction = 0.0;          ///< 0…1 within the stage
    double seconds = 0.0;           ///< since the start
    double stageSecondsLeft = -1.0; ///< estimate from the stage so far; below 0 while there is none
    bool finished = false;          ///< takeResult() does not wait any more
};

/// A rectangle of a lightmap page.
struct LightTile {
    int page = 0;
    ivec2 offset{0};        ///< of its texel (0, 0) on the page
    Image<uint32_t> texels; ///< as BakedScene::lightmaps, in units of the first light's lightmapUnitLux
};

/// Bakes on threads of its own. The result is that of bake() with the same arguments, byte for byte.
///
/// First the light of a coarse grid of probes, before the scene has its layout.
/// First light: few texels of each chart, path traced as soon as the scene has its layout, and spread over the others.
/// Then the lightmap's texels come in pieces of charts, before denoising; the finished pages follow once more. All that
/// is in the layout of the result. Until the bake ends, mixed lights have no baked shadows: first light is drawn in
/// mode baked indirect, whatever the bake's mode is.
///
/// Functions may be called from any thread.
class BakeSession {
public:
    /// `waits`: after the light of probes the bake waits for goOn(), so that a picture of that light gets the whole
    /// processor.
    BakeSession(Scene scene, BakeSettings settings, IntegratorFactory integratorFactory, bool waits = false);
    /// The same with integrators that are chosen on the bake's own thread: to open a GPU takes a while.
    BakeSession(Scene scene, BakeSettings settings, ChooseIntegrators choose, bool waits = false);
    /// Cancels and waits.
    ~BakeSession();
    BakeSession(const BakeSession&) = delete;
    BakeSession& operator=(const BakeSession&) = delete;

    [[nodiscard]] BakeSessionState state() const;
    /// What is computed next: pieces in view of the camera that face it, the nearest first, then the others by
    /// distance. `aspect` = width / height of its picture. It may change at any time, and changes no byte of the
    /// result. Without a call pieces come in the order of the pages.
    void setView(const Camera& camera, float aspect);
    /// The light of probes alone, once, until the first light is taken; nothing otherwise. No object has a lightmap.
    std::optional<BakedScene> takeProbeLight();
    /// The first light, once, as soon as it is there; nothing otherwise. It has no mask, directions or reflection
    /// probes, and a coarse grid of light probes.
    std::optional<BakedScene> takeLight();
    /// What has changed of the first light's pages since the last call, or since takeLight(); nothing before that.
    std::vector<LightTile> takeTiles();
    void goOn();
    /// The session ends with Cancelled soon, if it has not finished.
    void cancel();
    /// Waits for the end and hands the result over; call it once. Errors are those of bake().
    Result<BakeResult> takeResult();

private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

} // namespace halflight
