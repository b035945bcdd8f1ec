#version 460
#extension GL_GOOGLE_include_directive : require
#include "gather.glsl"
#include "halflight/shading/sky.h"

layout(local_size_x = 64) in;

// A picture's texel without what its luminance exceeds the limit by: SkyLight::pictureDim().
vec3 dimTexel(int column, int row)
{
    vec3 texel = push.tables.picture.at[row * push.tables.all.pictureSize.x + column];
    float bright = luminanceOf(texel);
    return bright > push.tables.all.limit ? texel * (push.tables.all.limit / bright) : texel;
}

vec3 dimSky(vec3 direction)
{
    GpuGatherConstants all = push.tables.all;
    if ((all.sky & kSky) == 0u) return vec3(0.0);
    if ((all.sky & kSkyPicture) == 0u) return skyRadiance(all.zenith, all.horizon, all.ground, direction);
    vec2 at = skyPictureUv(direction, all.turn) * vec2(all.pictureSize) + vec2(-0.5, 0.5);
    vec2 low = floor(at);
    vec2 between = at - low;
    int width = all.pictureSize.x;
    int height = all.pictureSize.y;
    int column = (int(low.x) + width) % width;
    int row = clamp(int(low.y), 0, height);
    int next = (column + 1) % width;
    int upper = max(row - 1, 0);
    int lower = min(row, height - 1);
    return mix(mix(dimTexel(column, upper), dimTexel(next, upper), between.x),
               mix(dimTexel(column, lower), dimTexel(next, lower), between.x), between.y);
}

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

void leaveOpen(uint block, int stratum, GpuRay ray, GpuHit hit, uint flag)
{
    uint place = atomicAdd(push.lists.counts.at[0], 1u);
    GpuOpen open;
    open.block = block;
    open.stratum = uint(stratum) | flag;
    open.face = hit.face;
    open.barycentric = hit.barycentric;
    open.distance = hit.distance;
    open.direction = ray.direction;
    push.lists.open.at[place] = open;
}

// The light of each gather ray: FinalGather::weightHits().
void main()
{
    uint i = invocation();
    uint block;
    int stratum;
    if (!sampleOf(i, block, stratum)) return;
    GpuRay ray = push.lists.rays.at[i];
    GpuHit hit = push.lists.hits.at[i];
    vec3 radiance = vec3(0.0);
    if (isinf(hit.distance)) {
        radiance = dimSky(ray.direction);
    } else {
        GpuSurface surface = push.tables.surfaces.at[hit.face & ~kBackBit];
        vec2 at = surface.origin + hit.barycentric.x * surface.edgeU + hit.barycentric.y * surface.edgeV;
        uint patchId = kNone;
        uint lit = kNone;
        if ((surface.patches & kHasPatches) != 0u) {
            patchId = patchAt(surface, (hit.face & kBackBit) != 0u, at);
            lit = litPatchAt(surface, at, patchId, hit.distance);
        }
        if (lit == kNone) {
            leaveOpen(block, stratum, ray, hit, 0u);
        } else {
            GpuBlock b = push.lists.blocks.at[block];
            GpuGatherTexel texel = push.lists.texels.at[b.texel];
            GpuPatch light = push.tables.patches.at[lit];
            radiance = patchRadianceAlong(light.radiance, light.tilt, ray.direction) *
                       sourceWeight(texel, pointOf(texel, b.number, stratum), ray, hit, patchId);
            if ((surface.patches & kEmissive) != 0u) leaveOpen(block, stratum, ray, hit, kReflectionIsIn);
        }
    }
    push.lists.gathered.at[i] = radiance * kShadingPi;
}
