// Light of a path by component: PathLights of PathTracer::pathRadiance(), added up.
#ifndef HALFLIGHT_BAKE_PATH_COMPONENTS_GLSL
#define HALFLIGHT_BAKE_PATH_COMPONENTS_GLSL

#include "emitters.glsl"
#include "../components/light.glsl"

uint components = 0u; // of the path's light; 0: it is estimated as one
Vectors ofComponents; // radiance of each, from firstOfPath on
uint firstOfPath;

void beginComponents(Vectors list, uint path)
{
    components = push.tables.all.components;
    ofComponents = list;
    firstOfPath = path * components;
    for (uint c = 0u; c < components; ++c) list.at[firstOfPath + c] = vec3(0.0);
}

void noteLight(uint component, vec3 radiance)
{
    if (components == 0u || radiance == vec3(0.0)) return;
    ofComponents.at[firstOfPath + component] += radiance;
}

void noteEmission(PathSurface s, vec3 radiance)
{
    if (components > 0u) noteLight(paths().materials.at[s.part.material].component, radiance);
}

void noteSky(vec3 direction, vec3 throughput)
{
    for (int part = 0; part < 3 && components > 0u; ++part)
        noteLight(push.tables.all.skyComponents[part], throughput * skyPart(part, direction));
}

// PathTracer::noteCached(), where the solution has the light, and where one of the levels has it.
void notePatch(uint lit, vec3 direction, vec3 throughput)
{
    for (uint c = 0u; c < components; ++c) noteLight(c, throughput * componentAlong(lit, c, direction));
}
void noteLevel(int level, uint patchId, vec3 throughput)
{
    for (uint c = 0u; c < components; ++c)
        noteLight(c, throughput * paths().componentLevels[level - 1].at[patchId * components + c]);
}

#endif
