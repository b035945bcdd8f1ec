#version 460
#extension GL_GOOGLE_include_directive : require
#include "gather.glsl"
#include "sky.glsl"

layout(local_size_x = 64) in;

// NextEvent::misWeightOfHit().
float sourceWeight(GpuGatherTexel texel, GpuPoint point, GpuRay ray, GpuHit hit, uint patchId)
{
    if (texel.sources == 0u || patchId >= push.tables.all.memberCount) return 1.0;
    GpuMember member = push.tables.members.at[patchId];
    if (!(member.pdfArea > 0.0)) return 1.0;
    float fraction = float(texel.sources) / float(kPatternBlock);
    float pdfArea = fraction * (probabilityOf(push.tables.guides.at[texel.guide], member.cluster) * member.pdfArea);
    vec3 normal = push.tables.normals.at[hit.face & ~kBackBit];
    float cosine = max(abs(dot(normal, ray.direction)), 1.0e-6);
    return misWeightOfRay(gatherDirectionPdf(point.normal, ray.direction), pdfArea, hit.distance, cosine);
}

// A ray whose light is that of a path (paths/paths.rgen).
GpuOpen openRay(uint block, int stratum, GpuRay ray, GpuHit hit)
{
    GpuOpen open;
    open.block = block;
    open.stratum = uint(stratum);
    open.face = hit.face;
    open.barycentric = hit.barycentric;
    open.distance = hit.distance;
    open.direction = ray.direction;
    return open;
}

// The light of a gather ray, but for what emitters send along it (emitters/hits.comp): FinalGather::weightHits(). True
// where it is a path's; then `open` is set.
bool gatherLight(uint i, out GpuOpen open)
{
    uint block;
    int stratum;
    if (!sampleOf(i, block, stratum)) return false;
    bool isOpen = false;
    GpuRay ray = push.lists.rays.at[i];
    GpuHit hit = push.lists.hits.at[i];
    vec3 radiance = vec3(0.0);
    GpuRayLight light = GpuRayLight(kNone, 1.0);
    if (isinf(hit.distance)) {
        radiance = dimSky(ray.direction);
    } else {
        GpuSurface surface = push.tables.surfaces.at[hit.face & ~kBackBit];
        vec2 at = placeInPatches(surface, hit.barycentric);
        uint patchId = kNone;
        uint lit = kNone;
        if ((surface.patches & kHasPatches) != 0u) {
            patchId = patchAt(surface, (hit.face & kBackBit) != 0u, at);
            lit = litPatchAt(surface, at, patchId, hit.distance);
        }
        if (lit == kNone) {
            isOpen = true;
        } else {
            GpuBlock b = push.lists.blocks.at[block];
            GpuGatherTexel texel = push.lists.texels.at[b.texel];
            GpuPatch from = push.tables.patches.at[lit];
            light = GpuRayLight(lit, sourceWeight(texel, pointOf(texel, b.number, stratum), ray, hit, patchId));
            radiance = patchRadianceAlong(from.radiance, from.tilt, ray.direction) * light.weight;
        }
        open = openRay(block, stratum, ray, hit);
    }
    push.lists.gathered.at[i] = radiance * hit.tint * kShadingPi;
    if (push.tables.all.components > 0u) push.lists.rayLights.at[i] = light;
    return isOpen;
}

shared uint openOf[kGroupSize];

// Open rays keep the order of all rays. An order by atomic counters would change from run to run, and on some devices
// a ray's neighbours decide which of two triangles it hits at their common edge.
void main()
{
    uint i = invocation();
    GpuOpen open;
    bool isOpen = gatherLight(i, open);
    openOf[gl_LocalInvocationIndex] = isOpen ? 1u : 0u;
    barrier();
    uint before = 0u; // in this group
    for (uint j = 0u; j < gl_LocalInvocationIndex; ++j) before += openOf[j];
    uint group = i / kGroupSize;
    if (isOpen) push.lists.open.at[group * kGroupSize + before] = open;
    if (gl_LocalInvocationIndex == kGroupSize - 1u)
        push.lists.openBefore.at[group] = before + openOf[gl_LocalInvocationIndex];
}
