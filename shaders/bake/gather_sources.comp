#version 460
#extension GL_GOOGLE_include_directive : require
#include "gather.glsl"

layout(local_size_x = 64) in;

struct Source
{
    GpuSourceTriangle triangle;
    uint masked;
    vec2 barycentric;
    vec3 position;
    float pdfArea; // 0: none
};

// Guides::choosePoint().
Source chooseSource(GpuSourceGuide guide, vec2 u)
{
    Source source;
    source.pdfArea = 0.0;
    uint first = guide.localFirst;
    uint count = guide.localCount;
    if (guide.sharedCount > 0u && selectsOwn(sharedFraction(guide), u.x)) {
        first = guide.sharedFirst;
        count = guide.sharedCount;
    }
    if (count == 0u) return source;
    uint number = first;
    for (uint n = count; n > 1u;) {
        uint middle = n / 2u;
        if (push.tables.cumulative.at[number + middle - 1u] <= u.x) number += middle;
        n -= middle;
    }
    float begin = number == first ? 0.0 : push.tables.cumulative.at[number - 1u];
    u.x = clamp((u.x - begin) / max(push.tables.cumulative.at[number] - begin, 1.0e-12), 0.0, kBelowOne);
    GpuEntry entry = push.tables.entries.at[number];
    float probability = guide.sharedCount > 0u ? probabilityOf(guide, entry.cluster) : entry.probability;
    GpuCluster cluster = push.tables.clusters.at[entry.cluster];
    if (cluster.triangleCount == 0u) return source;
    // SourceClusters::choosePoint().
    float at = u.x * float(cluster.triangleCount);
    uint bin = min(uint(at), cluster.triangleCount - 1u);
    u.x = at - float(bin);
    uint chosen = cluster.firstTriangle + bin;
    GpuAliasBin alias = push.tables.bins.at[chosen];
    if (!selectsOwn(alias.share, u.x)) chosen += alias.aliasOffset;
    GpuSourceTriangle t = push.tables.triangles.at[chosen];
    vec2 on = sampleTriangle(u);
    source.triangle = t;
    source.masked = push.tables.sourceMasks.at[chosen];
    source.barycentric = t.corners[0] + on.x * (t.corners[1] - t.corners[0]) + on.y * (t.corners[2] - t.corners[0]);
    source.position = t.origin + on.x * t.edge1 + on.y * t.edge2;
    source.pdfArea = probability * t.pdfArea;
    return source;
}

// Makes the rays to secondary sources of all blocks, and the light that they bring unless something is in the way:
// NextEvent::setSource().
void main()
{
    uint i = invocation();
    uint block;
    int stratum;
    bool inside = sampleOf(i, block, stratum);
    if (i >= rayCount()) return;
    GpuRay ray = noRay();
    vec3 irradiance = vec3(0.0);
    GpuRayLight kept = GpuRayLight(kNone, 0.0);
    if (inside) {
        GpuBlock b = push.lists.blocks.at[block];
        GpuGatherTexel texel = push.lists.texels.at[b.texel];
        if (takesSourceSample(int(texel.sources), int(b.number), stratum)) {
            int shuffle = int(texel.sources) < kPatternBlock ? strataShuffle(texel.id) : 0;
            uint bits = patternPoint(hashCombine(push.tables.all.sourceSeed, texel.id), b.number, stratum ^ shuffle);
            Source source = chooseSource(push.tables.guides.at[texel.guide], patternUnit(bits));
            GpuPoint point = pointOf(texel, b.number, stratum);
            vec3 way = source.position - point.position;
            if (source.pdfArea > 0.0) {
                uint hitIndex = source.triangle.face & ~kBackBit;
                GpuSurface surface = push.tables.surfaces.at[hitIndex];
                vec2 at = placeInPatches(surface, source.barycentric);
                uint lit = litPatchAt(surface, at, source.triangle.patchId, length(way));
                if (lit != kNone) {
                    GpuPatch light = push.tables.patches.at[lit];
                    // A ray passes through the uncovered part.
                    float coverage = source.masked == kNone ? 1.0
                                                            : coverageAt(push.tables.scene,
                                                                         push.tables.scene.masked.at[source.masked],
                                                                         source.barycentric);
                    vec3 radiance = patchRadianceAlong(light.radiance, light.tilt, normalize(way)) * coverage;
                    float pdfArea = source.pdfArea * (float(texel.sources) / float(kPatternBlock));
                    NextEventContribution next =
                        nextEventContribution(point.position, point.normal, point.geometricNormal, source.position,
                                              source.triangle.normal, pdfArea, false, true);
                    if (radiance != vec3(0.0) && next.distance > 0.0) {
                        irradiance = radiance * next.factor;
                        kept = GpuRayLight(lit, coverage * next.factor);
                        ray = rayTo(point.position, next);
                        atomicAdd(push.lists.counts.at[kRayCount], 1u);
                    }
                }
            }
        }
    }
    push.lists.sourceRays.at[i] = ray;
    push.lists.sources.at[i] = irradiance;
    if (push.tables.all.components > 0u) push.lists.sourceLights.at[i] = kept;
}
