#version 460
#extension GL_GOOGLE_include_directive : require
#include "cuts.glsl"

layout(local_size_x = 64) in;

// NextEvent::setSky(): a sample of the sky as one of an emitter.
PathEmitterSample skyFrom(vec3 position, vec2 u)
{
    PathSkySample sky = sampleSky(u);
    PathEmitterSample result;
    result.position = position + sky.direction * kSkyMeters;
    result.normal = -sky.direction;
    result.radiance = sky.radiance;
    result.doubleSided = false;
    result.rayVisible = false;
    result.component = push.tables.all.skyComponents[0];
    result.pdfArea = sky.pdf / (kSkyMeters * kSkyMeters);
    return result;
}

// A sample of an emitter or the sky: NextEvent::sampleEmitters(). False where the block takes none in this stratum.
bool sampleEmission(uint block, int stratum, out GpuRay ray, out vec3 irradiance, out uint component)
{
    GpuBlock b = push.lists.blocks.at[block];
    GpuGatherTexel texel = push.lists.texels.at[b.texel];
    GpuEmitterShare share = push.lists.shares.at[block];
    uint roulette = hashCombine(push.tables.all.rouletteSeed ^ texel.id, b.number);
    int sampled = strataOfShare(share.survival, roulette);
    if (patternOrder(stratum, int(b.number)) >= sampled) return false;
    int shuffle = sampled < kPatternBlock ? strataShuffle(texel.id) : 0;
    vec2 u = patternUnit(
        patternPoint(hashCombine(push.tables.all.emitterSeed, texel.id), b.number, stratum ^ shuffle));
    GpuPoint point = pointOf(texel, b.number, stratum);
    float weight = float(kPatternBlock) / float(sampled);
    // Either the sky or an emitter; the number that chose is used again.
    bool sky = selectsOwn(share.sky, u.x);
    weight /= sky ? share.sky : 1.0 - share.sky;
    PathEmitterSample e;
    if (sky)
        e = skyFrom(point.position, u);
    else
        e = emitterAt(sampleCut(b.texel, point.position, point.normal, u.x), u.y);
    NextEventContribution next =
        nextEventContribution(point.position, point.normal, point.geometricNormal, e.position, e.normal, e.pdfArea,
                              e.doubleSided, e.rayVisible);
    if (e.radiance == vec3(0.0) || !(next.distance > 0.0)) return false;
    ray = rayTo(point.position, next);
    irradiance = e.radiance * (next.factor * weight);
    component = e.component;
    return true;
}

// Makes the rays to emitters and the sky's bright part of all blocks, and the light that they bring unless something is
// in the way.
void main()
{
    uint i = invocation();
    uint block;
    int stratum;
    bool inside = sampleOf(i, block, stratum);
    if (i >= rayCount()) return;
    GpuRay ray;
    vec3 irradiance;
    uint component = kNone;
    if (inside && sampleEmission(block, stratum, ray, irradiance, component)) {
        atomicAdd(push.lists.counts.at[kRayCount], 1u);
    } else {
        ray = noRay();
        irradiance = vec3(0.0);
    }
    push.lists.sourceRays.at[i] = ray;
    push.lists.sources.at[i] = irradiance;
    if (push.tables.all.components > 0u) push.lists.sourceLights.at[i] = GpuRayLight(component, 1.0);
}
