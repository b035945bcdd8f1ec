// One sample of each kind of light at a surface, for its diffuse part or for its specular lobe: DirectLight and
// SceneLight.
#ifndef HALFLIGHT_BAKE_PATH_LIGHTS_GLSL
#define HALFLIGHT_BAKE_PATH_LIGHTS_GLSL

#include "components.glsl"
#include "rays.glsl"

#include "bake_gpu/paths/start_layout.h"
#include "halflight/shading/brdf_sampling.h"
#include "halflight/shading/sobol.h"

// transport/sample/specular_lobe.h; `on` is false where the surface's diffuse part reflects.
struct PathLobe {
    bool on;
    vec3 f0;
    float f90;
    float alpha;
    vec3 normal;
    vec3 view;
};

PathLobe noLobe()
{
    PathLobe lobe;
    lobe.on = false;
    lobe.f0 = vec3(0.0);
    lobe.f90 = 0.0;
    lobe.alpha = 1.0;
    lobe.normal = vec3(0.0);
    lobe.view = vec3(0.0);
    return lobe;
}

// SpecularLobe::reflected().
vec3 reflectedBy(PathLobe lobe, vec3 direction, vec3 illuminance)
{
    return reflectSpecular(lobe.f0, lobe.f90, lobe.alpha, lobe.normal, lobe.view, direction, illuminance);
}

// What a light gives: irradiance, or the radiance that the lobe reflects.
vec3 contributionOf(LightSource light, PathSurface s, PathLobe lobe, vec2 disc, float probability)
{
    if (!lobe.on) return sampledIrradiance(light, s.position, s.normal, disc, light.indirectMultiplier, probability);
    float scale = light.indirectMultiplier / probability;
    LightRay ray = sampleLightRay(light, s.position, disc);
    vec3 illuminance = isAreaLight(light.type) ? areaRadianceAt(light, s.position) * (ray.solidAngle * scale)
                                               : lightAt(light, s.position).illuminance * scale;
    return reflectedBy(lobe, ray.direction, illuminance);
}

// Light that a ray from the surface may bring: irradiance, or radiance that the lobe reflects.
struct PathLightSample {
    vec3 light; // without shadows; zero: there is no ray
    vec3 origin;
    vec3 direction;
    float tMax;
    float shadowStrength;
    vec3 fromSurface; // of lamps: direction from the surface itself
    uint component;
};

PathLightSample noLight()
{
    PathLightSample result;
    result.light = vec3(0.0);
    result.origin = vec3(0.0);
    result.direction = vec3(0.0, 0.0, 1.0);
    result.tMax = -1.0;
    result.shadowStrength = 1.0;
    result.fromSurface = vec3(0.0);
    result.component = 0u;
    return result;
}

// DirectLight::shadowOrigin().
vec3 shadowOriginOf(PathSurface s)
{
    float epsilon = epsilonAt(s);
    vec3 onFlat = s.position + s.geometricNormal * epsilon;
    uvec3 v = verticesOf(s.face, s.part);
    vec3 curved = pointOnCurvedSurface(s.position, s.weights, positionInWorld(s.part, v.x),
                                       positionInWorld(s.part, v.y), positionInWorld(s.part, v.z),
                                       normalInWorld(s.part, v.x), normalInWorld(s.part, v.y),
                                       normalInWorld(s.part, v.z), s.geometricNormal, s.back);
    vec3 origin = curved + s.geometricNormal * epsilon;
    // The raised origin must not be behind another surface.
    float lift = distance(onFlat, origin);
    if (lift <= kLeastLift * epsilon) return origin;
    return isOccluded(onFlat, (origin - onFlat) / lift, lift) ? onFlat : origin;
}

// A sample among the lights: SceneLight::LightChoice.
struct PathLightChoice {
    LightReservoir of;
    vec2 disc;
    float probability; // of the set of lights
    uint component;
};

// SceneLight::chooseFrom().
LightReservoir reservoirOf(uint chooser, PathSurface s, PathLobe lobe, float u, vec2 disc, inout PathSampler numbers)
{
    LightChooser from = paths().choosers.at[chooser];
    LightReservoir reservoir = lightReservoir(u);
    ChosenLight chosen = chosenLight(kNone, 0.0, 0.0);
    if (from.nodes > 0u) chosen = sampleLightsBelow(from.tree, 0u, s.position, s.normal, nextNumber(numbers));
    for (uint i = 0u; i <= from.alwaysCount; ++i) {
        bool ofTree = i == from.alwaysCount;
        if (ofTree && !(chosen.probability > 0.0)) break;
        uint number = ofTree ? from.lightOfItem.at[chosen.item] : from.always.at[i];
        considerLight(reservoir, number, contributionOf(paths().lights.at[number], s, lobe, disc,
                                                        ofTree ? chosen.probability : 1.0));
    }
    return reservoir;
}

// SceneLight::chooseLight() among the sets of lights from `first` on. Several sets are gone through twice, with the
// same numbers: what they have in all decides which of them is chosen.
PathLightChoice chooseLight(uint first, uint count, PathSurface s, PathLobe lobe, inout PathSampler numbers)
{
    PathLightChoice choice;
    float within = nextNumber(numbers);
    choice.disc = sampleDisc(nextPair(numbers));
    choice.of = lightReservoir(0.0);
    choice.probability = 1.0;
    choice.component = 0u;
    PathSampler start = numbers;
    float all = 0.0;
    int reaching = 0;
    float u = 0.0;
    for (int turn = count > 1u ? 0 : 1; turn < 2; ++turn) {
        PathSampler walk = start;
        for (uint c = first; c < first + count; ++c) {
            LightReservoir of = reservoirOf(c, s, lobe, within, choice.disc, walk);
            if (turn == 0) all += of.total;
            if (turn == 0 && of.total > 0.0) ++reaching;
            if (turn == 0 || (count > 1u && !(of.total > 0.0))) continue;
            choice.of = of;
            choice.component = paths().choosers.at[c].component;
            if (count == 1u) break;
            choice.probability = probabilityOfSet(of.total, all, reaching);
            if (u < choice.probability) break;
            u -= choice.probability;
        }
        if (turn == 1 && count > 1u) break;
        numbers = walk;
        if (turn == 0) u = nextNumber(numbers);
    }
    return choice;
}

// One light's of the sets of lights from `first` on.
PathLightSample sampleSources(uint first, uint count, PathSurface s, PathLobe lobe, inout PathSampler numbers)
{
    PathLightSample result = noLight();
    if (paths().all.anyLights == 0u) return result;
    PathLightChoice choice = chooseLight(first, count, s, lobe, numbers);
    LightReservoir reservoir = choice.of;
    if (reservoir.chosen == kNone) return result;
    vec2 disc = choice.disc;
    result.component = choice.component;
    result.light = contributionOfChosen(reservoir) / choice.probability;
    LightSource light = paths().lights.at[reservoir.chosen];
    result.fromSurface = sampleLightRay(light, s.position, disc).direction;
    if (light.castShadows == 0u || s.part.receivesShadows == 0u) return result;
    result.origin = shadowOriginOf(s);
    LightRay ray = sampleLightRay(light, result.origin, disc);
    result.direction = ray.direction;
    result.tMax = ray.distance * kShortOfSurface;
    result.shadowStrength = light.shadowStrength;
    return result;
}

const float kUniformPdf = 1.0 / (4.0 * kShadingPi); // of directions, per steradian

// Whether light counts from all directions: a point in space has no normal.
bool isInSpace(PathSurface s)
{
    return s.normal == vec3(0.0);
}

// DirectLight::emitterInSpace(): radiance over its density, per steradian.
PathLightSample sampleInSpace(PathEmitterSample e, vec3 origin)
{
    PathLightSample result = noLight();
    result.component = e.component;
    SeenEmitter seen = emitterSeenFrom(origin, e.position, e.normal, e.pdfArea, e.doubleSided);
    if (!(seen.pdf > 0.0)) return result;
    result.light = e.radiance * ((e.rayVisible ? powerHeuristic(seen.pdf, kUniformPdf) : 1.0) / seen.pdf);
    result.origin = origin;
    result.direction = seen.direction;
    result.tMax = seen.distance * kShortOfSurface;
    return result;
}

// DirectLight::emitterIrradiance() and reflectedEmitters().
PathLightSample sampleEmitters(PathSurface s, PathLobe lobe, float otherIlluminance, inout PathSampler numbers)
{
    PathLightSample result = noLight();
    if (paths().all.emitterNodes == 0u) return result;
    vec3 origin = rayOriginOf(s);
    float survival = 1.0;
    if (!lobe.on && otherIlluminance > 0.0)
        survival = rouletteSurvival(lightImportance(paths().emitterTree.at[0], origin, s.normal), otherIlluminance);
    if (survival < 1.0 && nextNumber(numbers) >= survival) return result;
    vec2 u = nextPair(numbers);
    PathEmitterSample e = emitterAt(sampleLightsBelow(paths().emitterTree, 0u, origin, s.normal, u.x), u.y);
    if (isInSpace(s)) return sampleInSpace(e, origin);
    result.component = e.component;
    NextEventContribution next = nextEventContribution(origin, s.normal, s.geometricNormal, e.position, e.normal,
                                                       e.pdfArea, e.doubleSided, e.rayVisible);
    if (!(next.distance > 0.0)) return result;
    result.light = e.radiance * (next.factor / survival);
    if (lobe.on) {
        float front = -dot(e.normal, next.direction);
        float pdf = e.pdfArea * next.distance * next.distance / (e.doubleSided ? abs(front) : front);
        float other = brdfPdf(lobe.normal, lobe.view, next.direction, lobe.alpha, 1.0);
        float weight = e.rayVisible ? powerHeuristic(pdf, other) : 1.0;
        result.light = reflectedBy(lobe, next.direction, e.radiance * (weight / pdf));
    }
    result.origin = origin;
    result.direction = next.direction;
    result.tMax = next.distance * kShortOfSurface;
    return result;
}

// DirectLight::skyIrradiance(), skyInSpace() and reflectedSky().
PathLightSample sampleBrightSky(PathSurface s, PathLobe lobe, float otherIlluminance, inout PathSampler numbers)
{
    PathLightSample result = noLight();
    if (paths().all.brightAreas == 0u) return result;
    float survival = lobe.on ? 1.0 : rouletteSurvival(paths().all.brightIlluminance, otherIlluminance);
    if (survival < 1.0 && nextNumber(numbers) >= survival) return result;
    PathSkySample sky = sampleSky(nextPair(numbers));
    float cosine = isInSpace(s) ? 1.0 : dot(s.normal, sky.direction);
    if (cosine <= 0.0 || (!isInSpace(s) && dot(s.geometricNormal, sky.direction) <= 0.0)) return result;
    result.light = lobe.on ? reflectedBy(lobe, sky.direction, sky.radiance / sky.pdf)
                           : sky.radiance * (cosine / (sky.pdf * survival));
    result.origin = rayOriginOf(s);
    result.direction = sky.direction;
    result.tMax = kLongestRay;
    result.component = push.tables.all.skyComponents[0];
    return result;
}

// A sample of a kind: lamps 0, emitters 1, the sky 2. `other`: illuminance of what was sampled before.
PathLightSample sampleKind(int kind, PathSurface s, PathLobe lobe, float other, inout PathSampler numbers)
{
    if (kind == 0) return sampleSources(0u, paths().all.choosers, s, lobe, numbers);
    if (kind == 1) return sampleEmitters(s, lobe, other, numbers);
    return sampleBrightSky(s, lobe, other, numbers);
}

// A sample's light with its shadow.
vec3 shadowed(PathLightSample next)
{
    if (next.light == vec3(0.0) || next.tMax < 0.0) return next.light;
    Passed passed = transmittance(next.origin, next.direction, next.tMax);
    return next.light * mix(Passed(1.0), passed, next.shadowStrength);
}

// Where a path starts it takes samples of emitters and the sky alone, without roulette. What they bring is kept apart.
bool atStart = false;
GpuEmission emission;
uint emitterAtStart = 0u; // its component

void keepEmission(int kind, vec3 light, PathLightSample next)
{
    vec3 direction = next.direction;
    if (kind == 1) {
        emission.ofEmitter = light;
        emission.toEmitter = direction;
        emitterAtStart = next.component;
    } else {
        emission.ofSky = light;
        emission.toSky = direction;
    }
}

// One sample of each kind with its shadow: irradiance, or the radiance that the lobe reflects. All in one loop, so that
// the code of a shadow ray is there once. `throughput`: of the path times what the surface reflects of that light.
// Components have no roulette: beside others' light, that of a dim one would be noise.
vec3 sampledLight(PathSurface s, PathLobe lobe, vec3 throughput, inout PathSampler numbers)
{
    vec3 sum = vec3(0.0);
    for (int kind = atStart ? 1 : 0; kind < 3; ++kind) {
        float other = atStart || components > 0u ? 0.0 : luminanceOf(sum);
        int which = lobe.on && kind > 0 ? 3 - kind : kind; // lobes have the sky first
        PathLightSample next = sampleKind(which, s, lobe, other, numbers);
        vec3 light = shadowed(next);
        sum += light;
        if (atStart)
            keepEmission(kind, light, next);
        else
            noteLight(next.component, throughput * light);
    }
    return sum;
}

#endif
