// Light of patches and of the sky by component (spec S33). After gather.glsl and sky.glsl.
#ifndef HALFLIGHT_BAKE_COMPONENT_LIGHT_GLSL
#define HALFLIGHT_BAKE_COMPONENT_LIGHT_GLSL

// ComponentRadiance::along(); `lit`: a patch or element.
vec3 componentAlong(uint lit, uint component, vec3 direction)
{
    GpuComponentLight light = push.tables.components.at[lit * push.tables.all.components + component];
    return patchRadianceAlong(light.radiance, light.tilt, direction);
}

// SceneLight::splitSky(): what of the sky's dim radiance in a direction is its zenith's, horizon's or ground's (0 to
// 2). Where all are of one component, the first has all of it.
vec3 skyPart(int part, vec3 direction)
{
    GpuGatherConstants all = push.tables.all;
    if ((all.sky & kSkySplit) == 0u) return part == 0 ? dimSky(direction) : vec3(0.0);
    vec3 shares = skyRadiance(vec3(1, 0, 0), vec3(0, 1, 0), vec3(0, 0, 1), direction);
    return part == 0 ? shares.x * all.zenith : part == 1 ? shares.y * all.horizon : shares.z * all.ground;
}

vec3 skyOfComponent(uint component, vec3 direction)
{
    vec3 sum = vec3(0.0);
    for (int part = 0; part < 3; ++part)
        if (push.tables.all.skyComponents[part] == component) sum += skyPart(part, direction);
    return sum;
}

#endif
