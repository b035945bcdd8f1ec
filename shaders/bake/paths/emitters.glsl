// Samples of emitters and of the sky's bright part, and the weights of rays that hit emitters: Emitters, SkyLight and
// DirectLight.
#ifndef HALFLIGHT_BAKE_PATH_EMITTERS_GLSL
#define HALFLIGHT_BAKE_PATH_EMITTERS_GLSL

#include "surface.glsl"

#include "../sky.glsl"

struct PathEmitterSample {
    vec3 position;
    vec3 normal;
    vec3 radiance;
    bool doubleSided;
    bool rayVisible;
    uint component;
    float pdfArea; // 0: no sample
};

// Emitters::at(): a point of a chosen emitter.
PathEmitterSample emitterAt(ChosenLight chosen, float v)
{
    PathEmitterSample result;
    result.pdfArea = 0.0;
    result.radiance = vec3(0.0);
    result.component = 0u;
    if (!(chosen.probability > 0.0)) return result;
    GpuEmitter e = paths().emitters.at[chosen.item];
    vec2 on = sampleTriangle(vec2(chosen.u, v));
    result.position = e.origin + on.x * e.edge1 + on.y * e.edge2;
    result.normal = e.normal;
    result.radiance = e.radiance;
    // Emission is scaled by coverage, as for rays that hit the surface by chance.
    if ((e.flags & kUniform) == 0u) {
        result.radiance = surfaceAt(e.hitIndex, on).emission;
        SceneData scene = push.tables.scene;
        if (e.masked != kNone) result.radiance *= coverageAt(scene, scene.masked.at[e.masked], on);
    }
    result.doubleSided = (e.flags & kDoubleSided) != 0u;
    result.rayVisible = (e.flags & kRayVisible) != 0u;
    result.component = e.flags >> kComponentShift;
    result.pdfArea = chosen.probability * e.inverseArea;
    return result;
}

struct PathSkySample {
    vec3 direction;
    vec3 radiance;
    float pdf;
};

// SkyLight::sample().
PathSkySample sampleSky(vec2 u)
{
    uint count = paths().all.brightAreas;
    u.x *= float(count);
    uint bin = min(uint(u.x), count - 1u);
    u.x = min(u.x - float(bin), kBelowOne);
    GpuAliasBin alias = paths().brightBins.at[bin];
    if (!selectsOwn(alias.share, u.x)) bin += alias.aliasOffset;
    uint area = paths().brightAreas.at[bin];
    ivec2 size = push.tables.all.pictureSize;
    SkyPoint point = skyPointOf(int(area % uint(size.x)), int(area / uint(size.x)), u, push.tables.all.turn, size);
    PathSkySample result;
    result.direction = point.direction;
    result.radiance = brightSkyAt(point.place);
    point.place.between = vec2(0.5);
    result.pdf = luminanceOf(brightSkyAt(point.place)) / paths().all.brightIlluminance;
    return result;
}

// Levels of the tree between an emitter's leaf and the root.
int levelsAbove(uint leaf)
{
    int levels = 0;
    for (uint n = leaf; n != 0u; n = paths().emitterTree.at[n].parent) ++levels;
    return levels;
}

// Emitters::pdfArea(): density of samples of an emitter, taken at a place.
float emitterPdfArea(uint emitter, vec3 from, vec3 normal)
{
    if (emitter == kNone) return 0.0;
    LightTree tree = paths().emitterTree;
    uint leaf = paths().leafOfEmitter.at[emitter];
    if (lightEndsBefore(tree.at[leaf], from, normal)) return 0.0;
    return probabilityOfLeaf(tree, leaf, levelsAbove(leaf), from, normal) * paths().emitters.at[emitter].inverseArea;
}

// DirectLight::weightedEmission(): what the end of a ray emits along it. `pdfArea`: of samples of emitters where the
// ray began.
vec3 weightedEmission(PathSurface s, vec3 direction, float distance, float directionPdf, float pdfArea)
{
    float cosine = abs(dot(s.geometricNormal, direction));
    if (directionPdf <= 0.0 || cosine <= 0.0) return s.emission;
    return s.emission * misWeightOfRay(directionPdf, pdfArea, distance, cosine);
}

#endif
