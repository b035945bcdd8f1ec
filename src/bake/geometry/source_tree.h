#pragma once
// The scene before it is unwrapped, with rays through it.

#include "halflight/bake/integrator.h"

#include <cstddef>
#include <memory>
#include <vector>

namespace halflight {

/// Geometry of a scene that has no lightmap yet, and one integrator for all tests that come before the bake's own:
/// which crossings are hidden, which sides of sheets are seen, which faces bound cavities. Both are made when they are
/// first asked for, and again only where meshes have been cut since.
class SourceTree {
public:
    /// `factory` outlives the tree.
    SourceTree(const IntegratorFactory& factory, const IntegrationSettings& settings);

    const BakeGeometry& geometryOf(const Scene& scene);
    /// Null where none can be made: the bake stops at the same error in its own stage. `scene` need not outlive it.
    Integrator* integratorOf(const Scene& scene);
    /// Keeps the first error of a test, which cannot return one. The bake ends with it.
    void fail(const Error& error)
    {
        if (status_) status_ = error;
    }
    [[nodiscard]] const Status& status() const { return status_; }
    /// The one that was made last; null if none was.
    [[nodiscard]] const Integrator* integrator() const { return integrator_.get(); }

private:
    const IntegratorFactory& factory_;
    IntegrationSettings settings_;
    std::vector<std::size_t> triangles_; ///< by object, of the geometry
    BakeGeometry geometry_;
    Scene scene_; ///< without meshes: what the integrator refers to
    std::unique_ptr<Integrator> integrator_;
    Status status_;
};

} // namespace halflight
