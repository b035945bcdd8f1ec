#include "scene/read/geometry/skin.h"

#include <algorithm>
#include <cmath>

namespace halflight {

namespace {

// worldFromJoint * inverseBind of each joint; inverse bind matrices that the skin leaves out are identities.
Result<std::vector<glm::dmat4>> jointMatrices(const SourceDocument& document, int skinIndex,
                                              const std::vector<glm::dmat4>& worldFromNode)
{
    const Json& skin = element(document.json, "skins", skinIndex);
    const std::string path = pathOf("skins", std::size_t(skinIndex));
    std::vector<glm::dmat4> matrices;
    for (const Json& joint : skin["joints"]) {
        if (!isIndexInto(document.json, "nodes", joint))
            return invalid(path, "refers to node " + joint.dump() + ", which does not exist");
        matrices.push_back(worldFromNode[joint.get<std::size_t>()]);
    }
    if (matrices.empty()) return invalid(path, "has no joints");
    const Json& inverseBinds = member(skin, "inverseBindMatrices");
    if (inverseBinds.is_null()) return matrices;
    if (!isIndexInto(document.json, "accessors", inverseBinds))
        return invalid(path, "inverseBindMatrices refers to an accessor that does not exist");
    const auto view = viewAccessor(document, inverseBinds.get<int>());
    if (!view) return view.error();
    if (view->components != 16 || view->componentType != gltf::kFloat || view->count < matrices.size())
        return invalid(path, "inverseBindMatrices are not one 4x4 matrix of floats for each joint");
    for (std::size_t j = 0; j < matrices.size(); ++j) {
        glm::dmat4 inverseBind(1.0);
        for (int i = 0; i < 16; ++i) {
            const float number = view->number(j, i);
            if (!std::isfinite(number)) return invalid(path, "an inverse bind matrix is not finite");
            if (i % 4 != 3) inverseBind[i / 4][i % 4] = double(number); // the last row is 0, 0, 0, 1
        }
        matrices[j] = matrices[j] * inverseBind;
    }
    return matrices;
}

// Reads JOINTS_n and WEIGHTS_n of a primitive for all n that it has.
struct Influences {
    std::vector<AccessorView> joints;
    std::vector<AccessorView> weights;
};
Result<Influences> readInfluences(const SourceDocument& document, const Json& primitive, const std::string& path)
{
    Influences influences;
    for (int n = 0;; ++n) {
        const int joints = attributeOf(primitive, "JOINTS_" + std::to_string(n));
        const int weights = attributeOf(primitive, "WEIGHTS_" + std::to_string(n));
        if (joints < 0 || weights < 0) return influences;
        auto jointView = viewAccessor(document, joints);
        if (!jointView) return jointView.error();
        auto weightView = viewAccessor(document, weights);
        if (!weightView) return weightView.error();
        if (jointView->components != 4 || weightView->components != 4 || jointView->componentType == gltf::kFloat) {
            return invalid(path, "JOINTS_" + std::to_string(n) + " and WEIGHTS_" + std::to_string(n) +
                                     " are not four integers and four weights for each vertex");
        }
        influences.joints.push_back(std::move(*jointView));
        influences.weights.push_back(std::move(*weightView));
    }
}

// The mean of the joints' matrices by the vertex's weights, whose sum need not be 1: exporters round, and integer
// weights may lack their "normalized". A vertex that no joint holds follows the first.
glm::dmat4 blend(const Influences& influences, const std::vector<glm::dmat4>& joints, std::size_t vertex,
                 std::size_t& beyond)
{
    glm::dmat4 sum(0.0);
    double total = 0.0;
    for (std::size_t n = 0; n < influences.joints.size(); ++n) {
        for (int c = 0; c < 4; ++c) {
            const auto weight = double(influences.weights[n].number(vertex, c));
            if (!(weight > 0.0) || !std::isfinite(weight)) continue;
            const uint32_t joint = influences.joints[n].integer(vertex, c);
            if (joint >= joints.size()) {
                ++beyond;
                continue;
            }
            sum += weight * joints[joint];
            total += weight;
        }
    }
    return total > 0.0 ? sum / total : joints[0];
}

/// Linear maps of a vertex's surroundings.
struct Frame {
    explicit Frame(const glm::dmat4& m)
        : linear(m),
          cofactor(glm::cross(linear[1], linear[2]), glm::cross(linear[2], linear[0]), glm::cross(linear[0], linear[1]))
    {
        if (glm::determinant(linear) < 0.0) cofactor *= -1.0;
    }
    glm::dmat3 linear;
    glm::dmat3 cofactor; // inverse transpose up to scale: takes normals, also where the map flattens
};

vec3 unitOr(glm::dvec3 v, vec3 otherwise)
{
    const double length = glm::length(v);
    return length > 0.0 && std::isfinite(length) ? vec3(v / length) : otherwise;
}

void turn(MeshPart& part, std::size_t v, const Frame& frame)
{
    if (!part.normals.empty()) part.normals[v] = unitOr(frame.cofactor * glm::dvec3(part.normals[v]), vec3(0, 1, 0));
    if (part.tangents.empty()) return;
    const glm::dvec3 n(part.normals[v]);
    const glm::dvec3 t = frame.linear * glm::dvec3(vec3(part.tangents[v]));
    const glm::dvec3 side = std::abs(n.x) < 0.9 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0);
    const vec3 tangent = unitOr(t - n * glm::dot(n, t), vec3(glm::normalize(glm::cross(n, side))));
    part.tangents[v] = vec4(tangent, part.tangents[v].w);
}

} // namespace

bool isSkinned(const SourceDocument& document, int node)
{
    const Json& json = element(document.json, "nodes", node);
    if (integerOf(json, "skin") < 0 || !extensionOf(json, "EXT_mesh_gpu_instancing").is_null()) return false;
    const Json& primitives = member(element(document.json, "meshes", integerOf(json, "mesh")), "primitives");
    return std::any_of(primitives.begin(), primitives.end(), [](const Json& primitive) {
        return attributeOf(primitive, "JOINTS_0") >= 0 && attributeOf(primitive, "WEIGHTS_0") >= 0;
    });
}

Result<std::vector<glm::dmat4>> worldTransforms(const SourceDocument& document)
{
    const Json& nodes = member(document.json, "nodes");
    std::vector<glm::dmat4> world(nodes.size(), glm::dmat4(1.0));
    const std::vector<int> parent = parentsOf(nodes);
    std::vector<int> stack;
    for (std::size_t i = 0; i < nodes.size(); ++i) {
        if (parent[i] < 0) stack.push_back(int(i));
    }
    while (!stack.empty()) {
        const auto node = std::size_t(stack.back());
        stack.pop_back();
        const auto local = localTransform(nodes[node], pathOf("nodes", node));
        if (!local) return local.error();
        world[node] = parent[node] >= 0 ? world[std::size_t(parent[node])] * *local : *local;
        for (const Json& child : member(nodes[node], "children")) stack.push_back(child.get<int>());
    }
    return world;
}

Result<glm::dmat4> skinMesh(const SourceDocument& document, int node, const std::vector<glm::dmat4>& worldFromNode,
                            Mesh& mesh, std::vector<std::string>& warnings)
{
    const std::string path = pathOf("nodes", std::size_t(node));
    const auto joints =
        jointMatrices(document, integerOf(element(document.json, "nodes", node), "skin"), worldFromNode);
    if (!joints) return joints.error();
    const bool mirrored = glm::determinant(glm::dmat3((*joints)[0])) < 0.0;
    const glm::dmat4 mirror = glm::dmat4(glm::dvec4(mirrored ? -1.0 : 1.0, 0, 0, 0), glm::dvec4(0, 1, 0, 0),
                                         glm::dvec4(0, 0, 1, 0), glm::dvec4(0, 0, 0, 1));
    std::vector<std::vector<glm::dvec3>> positions(mesh.parts.size());
    glm::dvec3 low(std::numeric_limits<double>::infinity());
    glm::dvec3 high(-std::numeric_limits<double>::infinity());
    std::size_t beyond = 0;
    for (std::size_t p = 0; p < mesh.parts.size(); ++p) {
        MeshPart& part = mesh.parts[p];
        const auto influences = readInfluences(document, primitiveOf(document, mesh.sourceMesh, part.sourcePrimitive),
                                               pathOf("meshes", std::size_t(mesh.sourceMesh)) + "/primitives/" +
                                                   std::to_string(part.sourcePrimitive));
        if (!influences) return influences.error();
        positions[p].resize(part.positions.size());
        for (std::size_t v = 0; v < part.positions.size(); ++v) {
            const std::size_t source = part.sourceVertex.empty() ? v : part.sourceVertex[v];
            const glm::dmat4 placed =
                mirror * (influences->joints.empty() ? worldFromNode[std::size_t(node)]
                                                     : blend(*influences, *joints, source, beyond));
            positions[p][v] = glm::dvec3(placed * glm::dvec4(glm::dvec3(part.positions[v]), 1.0));
            constexpr double kEnd = std::numeric_limits<float>::max() / 4; // differences of positions are floats too
            if (!glm::all(glm::lessThan(glm::abs(positions[p][v]), glm::dvec3(kEnd))))
                return invalid(path, "its skin puts a vertex where numbers end");
            low = glm::min(low, positions[p][v]);
            high = glm::max(high, positions[p][v]);
            turn(part, v, Frame(placed));
        }
    }
    if (beyond > 0) {
        warnings.push_back(path + ": " + std::to_string(beyond) +
                           " weights name joints that its skin does not have; they are left out");
    }
    const glm::dvec3 middle = 0.5 * low + 0.5 * high;
    for (std::size_t p = 0; p < mesh.parts.size(); ++p) {
        for (std::size_t v = 0; v < positions[p].size(); ++v)
            mesh.parts[p].positions[v] = vec3(positions[p][v] - middle);
    }
    glm::dmat4 toMiddle(1.0);
    toMiddle[3] = glm::dvec4(middle, 1.0);
    return mirror * toMiddle; // the mirror is its own inverse
}

} // namespace halflight
