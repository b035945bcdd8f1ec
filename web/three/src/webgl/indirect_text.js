// GLSL of light without single directions: lightmaps, probes, reflection probes, the sky; and the debug views. It follows
// surface_text.js.

export const indirectText = `
vec3 hlLightmap()
{
#ifdef HL_LIGHTMAPS
    return textureLod(hlLightmaps, vec3(vHlLightmapUv, hlSurface.page), 0.0).rgb * hlUnitLux;
#else
    return vec3(0.0);
#endif
}

vec3 hlSubtract(vec3 lightmap)
{
    if (hlMode != hlModeSubtractive || hlMainFlags.z < 0.5 || !hlSurface.receive) return lightmap;
    float faded = hlMixShadowsFullStrength(hlMode, false, 1.0, hlMainHasRealtime, hlMainRealtime, hlSurface.fade);
#ifdef HL_COLORED_MASKS
    vec3 baked = hlMainFlags.x >= 0.0 ? hlBakedByColor(hlMainFlags) : vec3(1.0);
    return hlSubtractiveIrradianceByColor(lightmap, hlMainIrradiance, baked, faded, hlShadowColor, hlMainFlags.w);
#else
    float baked = hlMainFlags.x >= 0.0 ? hlBakedOf(int(hlMainFlags.x)) : 1.0;
    return hlSubtractiveIrradiance(lightmap, hlMainIrradiance, baked, faded, hlShadowColor, hlMainFlags.w);
#endif
}

float hlLightmapScale(vec3 normal)
{
#ifdef HL_DIRECTIONS
    vec3 direction = textureLod(hlDirections, vec3(vHlLightmapUv, hlSurface.page), 0.0).rgb;
    return hlDirectionalIrradianceScale(hlDecodeMeanDirection(direction), hlSurface.side * hlSurface.vertexNormal,
                                        hlSurface.side * normal);
#else
    return 1.0;
#endif
}

float hlLightmapSpecularScale(vec3 lobe)
{
#ifdef HL_DIRECTIONS
    vec3 direction = textureLod(hlDirections, vec3(vHlLightmapUv, hlSurface.page), 0.0).rgb;
    return hlDirectionalSpecularScale(hlDecodeMeanDirection(direction), hlSurface.side * hlSurface.vertexNormal,
                                      hlSurface.side * hlSurface.normal, hlSurface.side * hlSurface.view,
                                      hlSurface.side * lobe, hlSurface.roughness);
#else
    return 1.0;
#endif
}

#ifdef HL_REFLECTIONS
// How far reflection probes serve this place better than the lightmap's own directions.
float hlReflectionTrust()
{
#ifdef HL_DIRECTIONS
    return textureLod(hlDirections, vec3(vHlLightmapUv, hlSurface.page), 0.0).a;
#else
    return 1.0;
#endif
}

vec3 hlReflectionAt(int probe, int level, vec3 direction)
{
    int size = int(hlReflections.y);
    vec2 texel = hlReflectionTexel(size, level, direction) + vec2(0.0, float(probe * hlReflectionTileHeight(size)));
    return textureLod(hlReflectionPicture, texel / vec2(textureSize(hlReflectionPicture, 0)), 0.0).rgb;
}

// Radiance that a lobe of this roughness about a direction meets, by one probe.
vec3 hlReflectionOf(int probe, mat4 boxFromWorld, vec3 position, vec3 direction, float roughness)
{
    vec3 boxPosition = (boxFromWorld * vec4(vHlPosition, 1.0)).xyz;
    vec4 at = hlLookUpReflection(vHlPosition, direction, boxPosition, mat3(boxFromWorld) * direction, position, roughness);
    float level = hlReflectionLevel(at.w);
    int low = min(int(level), hlReflectionLevels - 2);
    return mix(hlReflectionAt(probe, low, at.xyz), hlReflectionAt(probe, low + 1, at.xyz), level - float(low));
}

// surroundings, local: what the surface's own irradiance makes of them, about the lobe and on the normal.
vec3 hlReflected(vec3 surroundings, vec3 local)
{
    vec3 mirror = reflect(-hlSurface.view, hlSurface.normal);
    vec3 radiance = vec3(0.0);
    vec3 expected = vec3(0.0);
    float left = 1.0;
    float weights = 0.0;
    for (int i = 0; i < int(hlReflections.x) && left > 0.0; ++i) {
        int row = int(hlReflections.w) + i;
        mat4 boxFromWorld = mat4(hlCell(row, 0), hlCell(row, 1), hlCell(row, 2), hlCell(row, 3));
        vec4 place = hlCell(row, 4);
        vec3 boxPosition = (boxFromWorld * vec4(vHlPosition, 1.0)).xyz;
        float weight = left * hlReflectionCoverage(boxPosition, hlCell(row, 5).xyz, place.w);
        left -= weight;
        if (weight <= 0.0) continue;
        radiance += weight * hlReflectionOf(i, boxFromWorld, place.xyz, mirror, hlSurface.roughness);
        expected += weight * hlReflectionOf(i, boxFromWorld, place.xyz, hlSurface.normal, 1.0);
        weights += weight;
    }
    float trust = hlSurface.lightmapped ? hlReflectionTrust() : 1.0;
    float scale = hlReflections.z / max(weights, 1.0e-20);
    return hlReflectedSurroundings(radiance * scale, expected * scale, weights, trust, surroundings, local, hlSurface.roughness);
}
#endif

// Radiance of light without single directions: lightmap, probes, sky.
vec3 hlIndirect()
{
    bool openSky = hlMode == hlModeRealtime;
    vec3 irradiance;
    vec3 surroundings;
    vec3 lobe = hlSpecularLookup(hlSurface.view, hlSurface.normal, hlSurface.roughness);
    if (hlSurface.lightmapped && !openSky) {
        vec3 lightmap = hlSubtract(hlLightmap());
        irradiance = lightmap * hlLightmapScale(hlSurface.normal);
        surroundings = lightmap * hlLightmapSpecularScale(lobe);
    } else {
        irradiance = hlIrradiance(hlSurface.normal, openSky);
        surroundings = hlIrradiance(lobe, openSky);
    }
    surroundings *= 1.0 / hlShadingPi;
    if (openSky)
        surroundings = mix(hlSkyTowards(reflect(-hlSurface.view, hlSurface.normal), hlSurface.roughness), surroundings,
                           hlSurface.roughness);
#ifdef HL_REFLECTIONS
    if (!openSky) surroundings = hlReflected(surroundings, irradiance * (1.0 / hlShadingPi));
#endif
    float nDotV = clamp(abs(dot(hlSurface.normal, hlSurface.view)), 1.0e-4, 1.0);
    return hlReflectIndirect(hlSurface.baseColor, hlSurface.metallic, hlSurface.roughness, hlSurface.specular, nDotV,
                             irradiance, surroundings);
}

vec3 hlDebugView()
{
    if (hlView == 1) { // of all mask layers together
        vec4 mask = hlSurface.baked[0];
        for (int layer = 1; layer < HL_MASK_LAYERS; ++layer) mask = min(mask, hlSurface.baked[layer]);
        return mask.rgb * mix(0.5, 1.0, mask.a);
    }
    if (hlView == 2) return hlSurface.lightmapped ? hlLightmap() * (1.0 / hlShadingPi) : vec3(0.0);
    if (hlView == 3) return hlIrradiance(hlSurface.normal, false) * (1.0 / hlShadingPi);
    if (hlView == 4) return vec3(hlSurface.fade);
    vec3 ramp[6] = vec3[6](vec3(0.0), vec3(0.0, 0.0, 1.0), vec3(0.0, 1.0, 0.0), vec3(1.0, 1.0, 0.0), vec3(1.0, 0.0, 0.0),
                           vec3(1.0));
    return ramp[min(hlOverlap, 5)];
}
`;
