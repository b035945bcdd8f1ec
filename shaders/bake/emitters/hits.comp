#version 460
#extension GL_GOOGLE_include_directive : require
#include "cuts.glsl"

layout(local_size_x = 64) in;

// Adds what emitters send along the gather rays that hit them: FinalGather::emission().
void main()
{
    uint i = invocation();
    uint block;
    int stratum;
    if (!sampleOf(i, block, stratum)) return;
    GpuHit hit = push.lists.hits.at[i];
    if (isinf(hit.distance) || (push.tables.surfaces.at[hit.face & ~kBackBit].patches & kEmissive) == 0u) return;
    PathSurface s = surfaceAt(hit.face, hit.barycentric);
    if (s.emission == vec3(0.0)) return;
    GpuBlock b = push.lists.blocks.at[block];
    GpuPoint point = pointOf(push.lists.texels.at[b.texel], b.number, stratum);
    vec3 direction = push.lists.rays.at[i].direction;
    vec3 radiance =
        weightedEmission(s, direction, hit.distance, gatherDirectionPdf(point.normal, direction),
                         cutPdfArea(b.texel, s.face.emitter, point.position, point.normal));
    push.lists.gathered.at[i] += radiance * hit.tint * kShadingPi;
}
