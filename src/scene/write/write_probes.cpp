#include "scene/write/write_probes.h"

#include "halflight/scene/probe_cells.h"
#include "scene/document/references.h"

namespace halflight {

namespace {

constexpr int kFloat = gltf::kFloat;

class ProbeAccessors {
public:
    ProbeAccessors(DocumentPatcher& patcher, uint64_t& bytes) : patcher_(patcher), bytes_(bytes) {}

    template<typename T> int add(const char* type, int componentType, std::size_t count, const std::vector<T>& values,
                                 const Json& more = Json::object())
    {
        Json accessor = {{"componentType", componentType}, {"count", count}, {"type", type}};
        accessor.update(more);
        NewView view{bytesOf(values)};
        bytes_ += view.bytes.size();
        return patcher_.addAccessor(std::move(accessor), std::move(view));
    }

private:
    DocumentPatcher& patcher_;
    uint64_t& bytes_;
};

// The tetrahedra of the set: vertices and neighbours, one VEC4 each.
void addTetrahedra(ProbeAccessors& accessors, const ProbeSet& set, Json& json)
{
    const std::vector<Tetrahedron> cells = fileTetrahedra(probeCells(set));
    if (cells.empty()) return;
    std::vector<uint32_t> vertices;
    std::vector<uint32_t> neighbors;
    for (const Tetrahedron& cell : cells) {
        vertices.insert(vertices.end(), cell.vertex.begin(), cell.vertex.end());
        neighbors.insert(neighbors.end(), cell.neighbor.begin(), cell.neighbor.end());
    }
    constexpr int kUnsigned = gltf::kUnsignedInt;
    json["tetrahedra"] = accessors.add("VEC4", kUnsigned, cells.size(), vertices);
    json["neighbors"] = accessors.add("VEC4", kUnsigned, cells.size(), neighbors);
}

// How far probes see: a range of each, and the maps of those whose range is above 0.
void addSight(ProbeAccessors& accessors, const ProbeSight& sight, Json& json)
{
    if (sight.corners.empty()) return;
    json["sightRanges"] = accessors.add("SCALAR", kFloat, sight.rangeMeters.size(), sight.rangeMeters);
    json["sight"] = accessors.add("VEC2", gltf::kUnsignedShort, sight.corners.size(), sight.corners);
}

} // namespace

Json probesJson(DocumentPatcher& patcher, const ProbeSet& set, int maskLayers, uint64_t& bytes)
{
    if (set.probes.empty()) return {};
    std::vector<vec3> positions;
    std::vector<vec3> radiance;
    std::vector<uint8_t> valid;
    vec3 low(kInfinity);
    vec3 high(-kInfinity);
    for (const Probe& probe : set.probes) {
        positions.push_back(probe.position);
        radiance.insert(radiance.end(), probe.radiance.begin(), probe.radiance.end());
        valid.push_back(probe.valid ? 1 : 0);
        low = glm::min(low, probe.position);
        high = glm::max(high, probe.position);
    }
    const std::size_t count = set.probes.size();
    ProbeAccessors accessors(patcher, bytes);
    Json json = {
        {"count", count},
        {"positions", accessors.add("VEC3", kFloat, count, positions, {{"min", numbers(low)}, {"max", numbers(high)}})},
        {"radiance", accessors.add("VEC3", kFloat, radiance.size(), radiance)}};
    for (std::size_t layer = 0; layer < std::size_t(maskLayers); ++layer) {
        std::vector<vec4> occlusion;
        occlusion.reserve(count);
        for (const Probe& probe : set.probes) occlusion.push_back(probe.occlusion.layers[layer]);
        json[kOcclusionAccessors[layer]] = accessors.add("VEC4", kFloat, count, occlusion);
    }
    json["valid"] = accessors.add("SCALAR", gltf::kUnsignedByte, count, valid);
    addTetrahedra(accessors, set, json);
    addSight(accessors, set.sight, json);
    if (Json grid = gridJson(set, dvec3(set.origin)); !grid.is_null()) json["grid"] = std::move(grid);
    return json;
}

Json gridJson(const ProbeSet& set, dvec3 origin)
{
    if (set.size.x <= 0 || set.size.y <= 0 || set.size.z <= 0) return {};
    return {{"origin", numbers(origin)}, {"spacing", numbers(set.spacingMeters)}, {"size", numbers(set.size)}};
}

} // namespace halflight
