#version 460
#extension GL_GOOGLE_include_directive : require
#include "cuts.glsl"

layout(local_size_x = 64) in;

// What an emitter sends along a gather ray that hits it: FinalGather::emission().
GpuEmitterHit emitterHit(uint i, uint block, int stratum)
{
    GpuEmitterHit result = GpuEmitterHit(kNone, vec3(0.0));
    GpuHit hit = push.lists.hits.at[i];
    if (isinf(hit.distance) || (push.tables.surfaces.at[hit.face & ~kBackBit].patches & kEmissive) == 0u) return result;
    PathSurface s = surfaceAt(hit.face, hit.barycentric);
    if (s.emission == vec3(0.0)) return result;
    GpuBlock b = push.lists.blocks.at[block];
    GpuPoint point = pointOf(push.lists.texels.at[b.texel], b.number, stratum);
    vec3 direction = push.lists.rays.at[i].direction;
    vec3 radiance =
        weightedEmission(s, direction, hit.distance, gatherDirectionPdf(point.normal, direction),
                         cutPdfArea(b.texel, s.face.emitter, point.position, point.normal));
    return GpuEmitterHit(paths().materials.at[s.part.material].component, radiance * hit.tint * kShadingPi);
}

void main()
{
    uint i = invocation();
    uint block;
    int stratum;
    if (!sampleOf(i, block, stratum)) return;
    GpuEmitterHit hit = emitterHit(i, block, stratum);
    if (push.tables.all.components > 0u) push.lists.emitterHits.at[i] = hit;
    if (hit.irradiance != vec3(0.0)) push.lists.gathered.at[i] += hit.irradiance;
}
