#include "transport/segments.h"

#include "halflight/base/parallel.h"

#include <vector>

namespace halflight {
namespace {

Ray rayAlong(vec3 from, vec3 to)
{
    const float length = glm::distance(from, to);
    if (!(length > 0.0f)) return {};
    return {from, 0.0f, (to - from) / length, length};
}

/// The first surfaces, by rays there; for segments that meet one, the last surfaces by rays back.
void traceBatch(const RayTracer& tracer, std::span<const Segment> segments, std::span<std::optional<vec2>> out)
{
    std::vector<Ray> rays(segments.size());
    std::vector<RayHit> first(segments.size());
    for (std::size_t i = 0; i < segments.size(); ++i) rays[i] = rayAlong(segments[i].from, segments[i].to);
    tracer.nearest(rays, first);
    std::vector<Ray> back;
    for (std::size_t i = 0; i < segments.size(); ++i) {
        if (first[i].found()) back.push_back({segments[i].to, 0.0f, -rays[i].direction, rays[i].tMax});
    }
    std::vector<RayHit> last(back.size());
    tracer.nearest(back, last);
    std::size_t blocked = 0;
    for (std::size_t i = 0; i < segments.size(); ++i) {
        out[i].reset();
        if (!first[i].found()) continue;
        const RayHit& end = last[blocked++];
        out[i] = vec2(first[i].distance, end.found() ? rays[i].tMax - end.distance : first[i].distance);
    }
}

} // namespace

Status traceSegments(const RayTracer& tracer, std::span<const Segment> segments, std::span<std::optional<vec2>> out)
{
    constexpr std::size_t kBatch = 256; // lines of one place follow one another, and their rays are traced together
    parallelFor(segments.size(), kBatch, [&](std::size_t begin, std::size_t end) {
        traceBatch(tracer, segments.subspan(begin, end - begin), out.subspan(begin, end - begin));
    });
    return tracer.outcome(true);
}

} // namespace halflight
