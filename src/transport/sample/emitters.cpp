#include "transport/sample/emitters.h"

#include "halflight/shading/random.h"
#include "halflight/shading/sampling.h"

#include <algorithm>

namespace halflight {

Emitters::Emitters(const RayScene& scene, const LightComponents& components) : scene_(scene)
{
    const BakeGeometry& geometry = scene.geometry();
    std::vector<LightItem> items;
    for (uint32_t t = 0; t < geometry.triangleCount(); ++t) {
        const TransportMaterial& material = scene.materials().of(t);
        if (material.emission == vec3(0.0f) || geometry.partOf(t).side == SurfaceSide::Back) continue;
        const std::array<vec3, 3> corners = geometry.cornersOf(t);
        Emissive e;
        e.triangle = t;
        e.origin = corners[0];
        e.edge1 = corners[1] - e.origin;
        e.edge2 = corners[2] - e.origin;
        e.normal = geometry.geometricNormal(t);
        const float area = 0.5f * glm::length(glm::cross(e.edge1, e.edge2));
        if (!(area > 0.0f)) continue;
        e.inverseArea = 1.0f / area;
        e.uniform = !material.emissive && material.opaque;
        e.radiance = material.emission;
        e.doubleSided = material.doubleSided;
        e.rayVisible = geometry.partOf(t).castShadows;
        const int number = geometry.partOf(t).material;
        if (components.count > 0 && number >= 0) e.component = components.ofMaterial[std::size_t(number)];
        const float mean = meanEmission(material, t);
        if (!(mean > 0.0f)) continue;
        LightItem item;
        item.bounds.extend(e.origin);
        item.bounds.extend(e.origin + e.edge1);
        item.bounds.extend(e.origin + e.edge2);
        item.axis = e.normal;
        item.twoSided = e.doubleSided;
        item.power = area * mean * (e.doubleSided ? 2.0f : 1.0f);
        items.push_back(item);
        triangles_.push_back(e);
    }
    if (triangles_.empty()) return;
    firstOfPart_.assign(geometry.parts.size(), kNone);
    for (std::size_t i = 0; i < triangles_.size(); ++i) {
        const BakeGeometry::Part& part = geometry.partOf(triangles_[i].triangle);
        uint32_t& first = firstOfPart_[std::size_t(&part - geometry.parts.data())];
        if (first == kNone) {
            first = uint32_t(itemOfTriangle_.size());
            itemOfTriangle_.resize(first + part.triangleCount, kNone);
        }
        itemOfTriangle_[first + (triangles_[i].triangle - part.firstTriangle)] = uint32_t(i);
    }
    if (components.count > 1) shareAmongComponents(items, components.count);
    tree_ = LightTree(items);
}

/// Scales powers so that a component has half its share of all power and half of an even share: of what is chosen in
/// proportion to power, a dim component has samples too.
void Emitters::shareAmongComponents(std::vector<LightItem>& items, int count) const
{
    std::vector<double> power(std::size_t(count), 0.0);
    double all = 0.0;
    for (std::size_t i = 0; i < items.size(); ++i) {
        power[std::size_t(triangles_[i].component)] += double(items[i].power);
        all += double(items[i].power);
    }
    const auto emitting = double(std::count_if(power.begin(), power.end(), [](double p) { return p > 0.0; }));
    for (std::size_t i = 0; i < items.size(); ++i)
        items[i].power *= float(0.5 + 0.5 / emitting * all / power[std::size_t(triangles_[i].component)]);
}

/// Mean luminance over 16 points, at least the share of one of them: a textured triangle keeps a
/// probability above 0.
float Emitters::meanEmission(const TransportMaterial& material, uint32_t triangle) const
{
    const float full = luminance(material.emission);
    if (!material.emissive) return full;
    constexpr int kPoints = 16; // of a triangle: the mean guides sampling, and biases nothing
    float mean = 0.0f;
    for (int i = 0; i < kPoints; ++i) {
        const vec2 u = r2Point(i);
        mean += luminance(scene_.materials().emissionAt(triangle, shading::sampleTriangle(u))) / float(kPoints);
    }
    return std::max(mean, full / float(kPoints));
}

inline EmitterSample Emitters::at(const LightTree::Choice& choice, float v) const
{
    const Emissive& e = triangles_[choice.item];
    const vec2 barycentric = shading::sampleTriangle(vec2(choice.u, v));
    EmitterSample s;
    s.position = e.origin + barycentric.x * e.edge1 + barycentric.y * e.edge2;
    s.normal = e.normal;
    s.radiance = e.radiance;
    // Emission is scaled by coverage, as for rays that hit the surface by chance.
    if (!e.uniform) {
        const Materials& materials = scene_.materials();
        s.radiance = materials.emissionAt(e.triangle, barycentric) * materials.coverageAt(e.triangle, barycentric);
    }
    s.rayVisible = e.rayVisible;
    s.doubleSided = e.doubleSided;
    s.component = e.component;
    s.pdfArea = choice.probability * e.inverseArea;
    s.triangle = e.triangle;
    s.barycentric = barycentric;
    return s;
}

EmitterSample Emitters::sample(vec3 position, vec3 normal, vec2 u) const
{
    const LightTree::Choice choice = tree_.sample(position, normal, u.x);
    return choice.probability > 0.0f ? at(choice, u.y) : EmitterSample{};
}

void Emitters::sample(const LightTree::Cut& cut, const LightTree::Points& positions, const LightTree::Points& normals,
                      const LightTree::Cut::Lanes<bool>& wanted, const Vec2Lanes& u, EmitterLanes& samples) const
{
    LightTree::Cut::Lanes<LightTree::Choice> choices;
    tree_.sample(cut, positions, normals, wanted, u.x, choices);
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
        samples.pdfArea[lane] = 0.0f;
        if (choices[lane].probability > 0.0f) samples.set(lane, at(choices[lane], u.y[lane]));
    }
}

uint32_t Emitters::itemOf(uint32_t triangle) const
{
    if (triangles_.empty()) return kNone;
    const BakeGeometry& geometry = scene_.geometry();
    const uint32_t part = geometry.partNumberOf(triangle);
    if (firstOfPart_[part] == kNone) return kNone;
    return itemOfTriangle_[firstOfPart_[part] + (triangle - geometry.parts[part].firstTriangle)];
}

float Emitters::pdfArea(const Receiver& receiver, uint32_t triangle) const
{
    const uint32_t item = itemOf(triangle);
    if (item == kNone) return 0.0f;
    const float probability = receiver.cut != nullptr ? tree_.probability(*receiver.cut, receiver.lane, item,
                                                                          receiver.position, receiver.normal)
                                                      : tree_.probability(item, receiver.position, receiver.normal);
    return probability * triangles_[item].inverseArea;
}

} // namespace halflight
