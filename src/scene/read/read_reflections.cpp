#include "scene/read/read_reflections.h"

#include "halflight/base/finite.h"
#include "scene/format/bake_members.h"
#include "scene/format/recorded_origin.h"
#include "scene/model/origin.h"
#include "scene/pictures/ktx2.h"
#include "scene/read/looks/read_pictures.h"

#include <cmath>

namespace halflight {

namespace {

const std::string kReflectionsPath = kBakePath + "/reflectionProbes";

/// Widest tile that is read: 32 of them are 768 MiB as floats.
constexpr int kMostTileTexels = 1024;
constexpr int kLeastTileTexels = 32;

std::optional<mat4> boxOf(const Json& json, const glm::dvec3& shift)
{
    glm::dmat4 matrix;
    if (!readMatrix(json, matrix)) return std::nullopt;
    matrix[3] += glm::dvec4(shift, 0.0);
    const mat4 box(matrix);
    return isBox(box) ? std::optional(box) : std::nullopt;
}

Result<ReflectionProbe> readProbe(const Json& json, const glm::dvec3& shift, const std::string& path)
{
    ReflectionProbe probe;
    if (!readVector(member(json, "position"), probe.position) || !isFinite(probe.position))
        return invalid(path, "position is not three numbers");
    probe.position = vec3(glm::dvec3(probe.position) + shift);
    const auto box = boxOf(member(json, "box"), shift);
    if (!box) return invalid(path, "box is not a transform of 16 numbers with an inverse, or thinner than 2e-7 m");
    probe.worldFromBox = *box;
    const Json& fade = member(json, "fade");
    probe.fadeMeters = fade.is_number() ? fade.get<float>() : 0.0f;
    if (!(probe.fadeMeters > 0.0f) || !std::isfinite(probe.fadeMeters))
        return invalid(path, "fade is not a number above 0");
    return probe;
}

} // namespace

bool isBox(const mat4& worldFromBox)
{
    constexpr double kSmallestMeters = 1.0e-7; // half a side: positions in a smaller box would leave the floats
    const glm::dmat3 axes{glm::dmat4(worldFromBox)};
    if (!isFinite(worldFromBox) || !(std::abs(glm::determinant(axes)) > 0.0)) return false;
    const glm::dmat3 inverse = glm::inverse(axes);
    for (int c = 0; c < 3; ++c) {
        for (int r = 0; r < 3; ++r) {
            if (!(std::abs(inverse[c][r]) <= 1.0 / kSmallestMeters)) return false;
        }
    }
    return true;
}

Status readReflectionPicture(const SourceDocument& document, const Json& json, std::size_t probes,
                             const std::string& path, ReflectionSet& set)
{
    const Json& unit = member(json, "unitNits");
    set.unitNits = unit.is_number() ? unit.get<float>() : 0.0f;
    if (!(set.unitNits > 0.0f) || !std::isfinite(set.unitNits))
        return invalid(path, "unitNits is not a number above 0");
    const Json& size = member(json, "size");
    set.size = size.is_number_unsigned() && size.get<uint64_t>() <= uint64_t(kMostTileTexels) ? size.get<int>() : 0;
    if (set.size < kLeastTileTexels || set.size % 16 != 0)
        return invalid(path, "size is not a multiple of 16 from 32 to 1024");
    const auto bytes = pictureBytes(document, member(json, "picture"), path + "/picture");
    if (!bytes) return bytes.error();
    auto picture = decodeKtx2(*bytes);
    if (!picture) return Error{picture.error().code, picture.error().message, path + "/picture"};
    set.picture = std::move(*picture);
    if (set.picture.size() != ivec2(set.size, int(probes) * (set.size + set.size / 2)))
        return invalid(path + "/picture", "is not as large as its probes' tiles");
    return {};
}

Result<ReflectionSet> readReflections(const SourceDocument& document, const Json& json, const glm::dvec3& shift)
{
    ReflectionSet set;
    if (json.is_null()) return set;
    const Json& probes = member(json, "probes");
    if (!probes.is_array() || probes.empty() || probes.size() > ReflectionSet::kMost)
        return invalid(kReflectionsPath, "probes is not a list of 1 to 32");
    for (std::size_t i = 0; i < probes.size(); ++i) {
        auto probe = readProbe(probes[i], shift, kReflectionsPath + "/probes/" + std::to_string(i));
        if (!probe) return probe.error();
        set.probes.push_back(*probe);
    }
    if (Status s = readReflectionPicture(document, json, set.probes.size(), kReflectionsPath, set); !s)
        return s.error();
    return set;
}

Status readReflectionBoxes(const SourceDocument& document, const std::vector<NodeState>& nodes, Scene& scene)
{
    for (const NodeState& state : nodes) {
        if (!state.visible || !state.settings.reflectionProbe.value_or(false)) continue;
        scene.reflectionBoxes.push_back(localFromWorld(state.worldFromNode, scene.originMeters));
        if (!isBox(scene.reflectionBoxes.back()))
            return invalid(pathOf("nodes", std::size_t(state.node)),
                           "asks for a reflection probe, but its scale leaves the box no volume");
    }
    const Json& root = extensionOf(document.json, "HALFLIGHT_mixed_lighting");
    const Json& recorded = member(root, "authoredReflectionProbes");
    if (!scene.reflectionBoxes.empty() || !recorded.is_array()) return {};
    const auto origin = recordedOrigin(document);
    if (!origin) return origin.error();
    for (const Json& json : recorded) {
        const auto box = boxOf(json, *origin - scene.originMeters);
        if (!box) return invalid(kBakePath + "/authoredReflectionProbes", "holds what is no transform with an inverse");
        scene.reflectionBoxes.push_back(*box);
    }
    return {};
}

} // namespace halflight
