#pragma once
// A bake in the background, for editors: it shows light soon, tells how far it is, and can be cancelled at any time.

#include "halflight/bake/bake.h"

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

namespace halflight {

struct BakeSessionState {
    std::string stage;              ///< "lightmap", …; "first light: lightmap" while the coarse bake runs
    double fraction = 0.0;          ///< 0…1 within the stage
    double seconds = 0.0;           ///< since the start
    double stageSecondsLeft = -1.0; ///< estimate from the stage so far; below 0 while there is none
    bool finished = false;          ///< takeResult() does not wait any more
};

/// Bakes on threads of its own. The result is that of bake() with the same arguments, byte for byte. Before it, a bake
/// of a few texels of each object (coarseSettings()) gives a first light, in a small part of the time.
class BakeSession {
public:
    BakeSession(Scene scene, BakeSettings settings, IntegratorFactory integratorFactory);
    /// Cancels and waits.
    ~BakeSession();
    BakeSession(const BakeSession&) = delete;
    BakeSession& operator=(const BakeSession&) = delete;

    [[nodiscard]] BakeSessionState state() const;
    /// The coarse bake's scene, once, as soon as it is there; nothing otherwise.
    std::optional<BakedScene> takeLight();
    /// The session ends with Cancelled soon, if it has not finished.
    void cancel();
    /// Waits for the end and hands the result over; call it once. Errors are those of bake().
    Result<BakeResult> takeResult();

private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

/// The settings of a session's first light: same lights, modes and directions, an eighth of the texels along each side,
/// few samples, no reflection probes.
BakeSettings coarseSettings(const BakeSettings& settings);

} // namespace halflight
