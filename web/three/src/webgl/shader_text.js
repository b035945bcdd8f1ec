// GLSL between three.js's shaders and the shading headers (generated/shading.glsl.js). It reads textures and uniforms
// and calls the headers' functions; formulas are in the headers.

/** Texels of one object in the table: see ObjectTable. */
export const COLUMNS = 12;
export const ROWS = 1024;
/** Location of the vertex attribute that holds an object's row in the table. */
export const ROW_LOCATION = 15;

const table = `
uniform highp sampler2D hlTable;
vec4 hlCell(int row, int column)
{
    return texelFetch(hlTable, ivec2((row / ${ROWS}) * ${COLUMNS} + column, row % ${ROWS}), 0);
}
// From the world to the space of the bake that an object belongs to.
mat4 hlBakeFromWorld(int row)
{
    int place = int(hlCell(row, 1).w);
    return mat4(hlCell(place, 0), hlCell(place, 1), hlCell(place, 2), hlCell(place, 3));
}
`;

export const vertexPars = `
layout(location = ${ROW_LOCATION}) in float hlRowAttribute;
attribute vec2 hlLightmapUv;
flat varying int vHlRow;
varying vec2 vHlLightmapUv;
varying vec3 vHlPosition;
${table}
`;

export const vertexMain = `
{
    vHlRow = int(hlRowAttribute);
    vec4 hlPosition = vec4(transformed, 1.0);
#ifdef USE_INSTANCING
    vHlRow += gl_InstanceID;
    hlPosition = instanceMatrix * hlPosition;
#endif
    vHlPosition = (hlBakeFromWorld(vHlRow) * (modelMatrix * hlPosition)).xyz;
    vec4 hlPlace = hlCell(vHlRow, 0);
    vHlLightmapUv = hlLightmapUv * hlPlace.xy + hlPlace.zw;
}
`;

/** Before three.js's lights: attenuation by distance and cone as KHR_lights_punctual has it. */
export const attenuation = `
float getDistanceAttenuation(const in float lightDistance, const in float cutoffDistance, const in float decayExponent);
float hlLightScale = 1.0; // of the file that the light belongs to: intensities are those of its own metres
float hlLightDistance(float lightDistance, float range, float decay)
{
    if (decay != 2.0) return getDistanceAttenuation(lightDistance / hlLightScale, range / hlLightScale, decay);
    return hlDistanceAttenuation(lightDistance / hlLightScale, range / hlLightScale);
}
float hlLightCone(float cosOuter, float cosInner, float cosAngle)
{
    return hlSpotAttenuation(cosAngle, hlSpotConstantsOfCosines(cosInner, cosOuter));
}
`;

/** The sky by direction. */
export const skyText = `
uniform vec3 hlSky[3]; // zenith, horizon, ground
#ifdef HL_SKY_PICTURE
uniform highp sampler2D hlSkyPicture;
uniform vec4 hlSkyTurn; // cosine and sine of its rotation, width in texels, cd/m2 of a texel of 1
#endif
// Radiance from unit direction d, in a mirror of this roughness.
vec3 hlSkyTowards(vec3 d, float roughness)
{
#ifdef HL_SKY_PICTURE
    return textureLod(hlSkyPicture, hlSkyPictureUv(d, hlSkyTurn.xy), hlSkyPictureLevel(roughness, hlSkyTurn.z)).rgb * hlSkyTurn.w;
#else
    return hlSkyRadiance(hlSky[0], hlSky[1], hlSky[2], d);
#endif
}
`;

export const fragmentPars = `
flat varying int vHlRow;
varying vec2 vHlLightmapUv;
varying vec3 vHlPosition;
${table}
struct HlLight {
    vec4 flags; // x channel whose baked shadow is read, -1 none; y 1 = has a shadow map; z bits: 1 not on lightmapped
                // receivers, 2 not on others, 4 subtractive's main light, 8 counts in the overlap view; w shadow strength
    vec4 reach; // xyz where it was baked; w metres for which its channel holds, 0 = all
    vec4 cone;  // xyz its axis at the bake; w cosine of the cone for which its channel holds, -2 = all
    vec2 own;   // x row of the file or clone that it belongs to, -1 none; y scale of that
};
#if NUM_POINT_LIGHTS > 0
uniform HlLight hlPointLights[NUM_POINT_LIGHTS];
#endif
#if NUM_SPOT_LIGHTS > 0
uniform HlLight hlSpotLights[NUM_SPOT_LIGHTS];
#endif
#if NUM_DIR_LIGHTS > 0
uniform HlLight hlDirectionalLights[NUM_DIR_LIGHTS];
#endif
uniform int hlMode;
uniform int hlView;
uniform vec2 hlShadow; // shadow distance, fade range
uniform float hlUnitLux;
uniform vec3 hlShadowColor;
${skyText}uniform vec3 hlSkySh[9];
#ifdef HL_LIGHTMAPS
uniform highp sampler2DArray hlLightmaps;
#endif
#ifdef HL_DIRECTIONS
uniform highp sampler2DArray hlDirections;
#endif
#ifdef HL_MASKS
uniform highp sampler2DArray hlMasks;
uniform vec4 hlMaskRange;
uniform vec4 hlMaskPenumbra;
#endif
#ifdef HL_VOLUMES
uniform highp sampler3D hlVolumes;
#endif
#ifdef HL_REFLECTIONS
uniform highp sampler2D hlReflectionPicture;
uniform vec4 hlReflections; // probes, width of a tile, cd/m2 of a texel of 1, first row in the table
#endif

struct HlSurface {
    mat4 bakeFromWorld; // all that follows is in bake space
    int place;         // row of that matrix
    vec3 normal;       // with the normal map
    vec3 vertexNormal; // interpolated, towards the camera
    vec3 view;         // unit, to the camera
    float side;        // 1 front, -1 back
    float cameraDistance;
    float fade;
    bool lightmapped;
    bool receive;
    int page;
    int volume;
    vec4 baked; // B by channel
    vec3 baseColor;
    float metallic;
    float roughness;
    float specular;
};
HlSurface hlSurface;
// What subtraction needs of the main light.
vec4 hlMainFlags = vec4(-1.0, 0.0, 0.0, 1.0);
vec3 hlMainIrradiance = vec3(0.0);
float hlMainRealtime = 1.0;
bool hlMainHasRealtime = false;
int hlOverlap = 0;

// From view space.
vec3 hlToBake(vec3 v) { return normalize(mat3(hlSurface.bakeFromWorld) * (vec4(v, 0.0) * viewMatrix).xyz); }

#ifdef HL_VOLUMES
// Textures 0, 1, ... of a proxy volume; filtering keeps to the volume's own texels.
vec4 hlVolumeTexture(int slab)
{
    mat4 slabFromWorld = mat4(hlCell(hlSurface.volume, 0), hlCell(hlSurface.volume, 1), hlCell(hlSurface.volume, 2),
                              hlCell(hlSurface.volume, 3));
    vec3 at = (slabFromWorld * vec4(vHlPosition, 1.0)).xyz;
    at = clamp(at, hlCell(hlSurface.volume, 4).xyz, hlCell(hlSurface.volume, 5).xyz);
    at.z += float(slab) * 0.125;
    return textureLod(hlVolumes, at, 0.0);
}
#endif

// Irradiance from what surrounds the object: its probes, in realtime mode the open sky.
vec3 hlIrradiance(vec3 n, bool openSky)
{
    vec3 irradiance = vec3(0.0);
    if (openSky) {
        for (int i = 0; i < 9; ++i) irradiance += hlSkySh[i] * hlShIrradianceWeight(i, n);
        return max(irradiance, vec3(0.0));
    }
#ifdef HL_VOLUMES
    if (hlSurface.volume >= 0) {
        for (int c = 0; c < 3; ++c) {
            vec4 low = hlVolumeTexture(c);
            vec4 high = hlVolumeTexture(4 + c);
            for (int i = 0; i < 4; ++i)
                irradiance[c] += low[i] * hlShIrradianceWeight(i, n) + high[i] * hlShIrradianceWeight(4 + i, n);
        }
        irradiance += hlVolumeTexture(7).rgb * hlShIrradianceWeight(8, n);
        return max(irradiance * hlCell(hlSurface.volume, 4).w, vec3(0.0));
    }
#endif
    for (int i = 0; i < 9; ++i) irradiance += hlCell(vHlRow, 3 + i).rgb * hlShIrradianceWeight(i, n);
    return max(irradiance, vec3(0.0));
}

vec4 hlProbeOcclusion()
{
#ifdef HL_VOLUMES
    if (hlSurface.volume >= 0) return hlVolumeTexture(3);
#endif
    return hlCell(vHlRow, 2);
}

vec4 hlReadMask()
{
#ifdef HL_MASKS
    vec4 stored = textureLod(hlMasks, vec3(vHlLightmapUv, hlSurface.page), 0.0);
    vec2 size = vec2(textureSize(hlMasks, 0).xy);
    float footprint = max(length(dFdx(vHlLightmapUv) * size), length(dFdy(vHlLightmapUv) * size));
    vec4 attenuation;
    for (int c = 0; c < 4; ++c)
        attenuation[c] = hlDecodeMask(stored[c], hlMaskRange[c], hlMaskPenumbra[c], footprint);
    return attenuation;
#else
    return vec4(1.0);
#endif
}

void hlReadSurface(vec3 normal, vec3 vertexNormal, vec3 viewDirection, float side, vec3 baseColor, float metallic,
                   float roughness, float specular)
{
    vec4 info = hlCell(vHlRow, 1);
    int flags = int(info.x);
    hlSurface.place = int(info.w);
    hlSurface.bakeFromWorld = hlBakeFromWorld(vHlRow);
    hlSurface.normal = hlToBake(normal);
    hlSurface.vertexNormal = hlToBake(vertexNormal);
    hlSurface.view = hlToBake(viewDirection);
    hlSurface.side = side;
    hlSurface.cameraDistance = length((hlSurface.bakeFromWorld * vec4(cameraPosition, 1.0)).xyz - vHlPosition);
    hlSurface.fade = hlShadowFade(hlSurface.cameraDistance, hlFadeConstants(hlShadow.x, hlShadow.y));
    hlSurface.lightmapped = (flags & 1) != 0;
    hlSurface.receive = receiveShadow;
    hlSurface.page = int(info.y);
    hlSurface.volume = int(info.z);
    vec4 mask = hlReadMask(); // derivatives want uniform control flow
    hlSurface.baked = hlSurface.lightmapped ? mask : hlProbeOcclusion();
    hlSurface.baseColor = baseColor;
    hlSurface.metallic = hlSaturate(metallic);
    hlSurface.roughness = hlSaturate(roughness);
    hlSurface.specular = specular;
}

// Whether the light belongs to another clone of the file, whose surfaces have that of their own.
bool hlIsForeign(HlLight light) { return light.own.x >= 0.0 && int(light.own.x) != hlSurface.place; }
bool hlIsMain(HlLight light) { return (int(light.flags.z) & 4) != 0 && !hlIsForeign(light); }
bool hlSkips(HlLight light)
{
    return hlIsForeign(light) || (int(light.flags.z) & (hlSurface.lightmapped ? 1 : 2)) != 0;
}

// Whether the light's shadow map is sampled at all.
bool hlReads(HlLight light, bool visible)
{
    bool wanted = !hlSkips(light) || hlIsMain(light);
    return visible && wanted && hlSurface.receive && hlReadsShadowMap(light.flags.y > 0.5, hlSurface.fade);
}

float hlBakedAttenuation(HlLight light)
{
    vec3 fromLight = vHlPosition - light.reach.xyz;
    float distanceMeters = max(length(fromLight), 1.0e-6);
    float cosAngle = dot(fromLight, light.cone.xyz) / distanceMeters;
    return hlBakedWithinReach(hlSurface.baked[int(light.flags.x)], distanceMeters, light.reach.w, cosAngle, light.cone.w);
}

#ifdef HL_AREA_LIGHTS
struct HlAreaLight {
    HlLight light;
    vec4 place; // xyz world, w range in metres of its file
    vec3 color; // cd/m2
    vec3 halfX; // from the middle to the edges, world
    vec3 halfY;
    int type;
};
uniform HlAreaLight hlAreaLights[HL_AREA_LIGHTS];

// Radiance towards the camera by an area light. three.js draws no shadow map of it.
vec3 hlAreaLight(HlAreaLight area)
{
    if (hlIsForeign(area.light)) return vec3(0.0);
    vec3 toCenter = (hlSurface.bakeFromWorld * vec4(area.place.xyz, 1.0)).xyz - vHlPosition;
    vec3 halfX = mat3(hlSurface.bakeFromWorld) * area.halfX;
    vec3 halfY = mat3(hlSurface.bakeFromWorld) * area.halfY;
    vec3 radiance = area.color * hlRangeWindow(dot(toCenter, toCenter), area.place.w);
    if (radiance == vec3(0.0) || dot(toCenter, cross(halfX, halfY)) <= 0.0) return vec3(0.0);
    if ((int(area.light.flags.z) & 8) != 0) hlOverlap += 1;
    if (hlSkips(area.light)) return vec3(0.0);
    vec3 reflected = hlReflectAreaLight(hlSurface.baseColor, hlSurface.metallic, hlSurface.roughness, hlSurface.specular, hlSurface.normal,
                                        hlSurface.view, area.type, toCenter, halfX, halfY, radiance);
    if (!hlSurface.receive) return reflected;
    bool hasBaked = area.light.flags.x >= 0.0;
    float baked = hasBaked ? hlBakedAttenuation(area.light) : 1.0;
    return reflected * hlMixShadows(hlMode, hasBaked, baked, false, 1.0, hlSurface.fade, area.light.flags.w);
}
#endif

// The light after shadows.
void hlShade(HlLight light, float realtime, inout IncidentLight incoming)
{
    bool hasRealtime = light.flags.y > 0.5;
    if (hlIsMain(light)) {
        hlMainFlags = light.flags;
        hlMainIrradiance = incoming.color * hlSaturate(dot(hlSurface.vertexNormal, hlToBake(incoming.direction)));
        hlMainRealtime = realtime;
        hlMainHasRealtime = hasRealtime;
    }
    if ((int(light.flags.z) & 8) != 0 && !hlIsForeign(light) && incoming.color != vec3(0.0)) hlOverlap += 1;
    if (hlSkips(light)) {
        incoming.color = vec3(0.0);
        incoming.visible = false;
        return;
    }
    if (!hlSurface.receive) return;
    bool hasBaked = light.flags.x >= 0.0;
    float baked = hasBaked ? hlBakedAttenuation(light) : 1.0;
    incoming.color *= hlMixShadows(hlMode, hasBaked, baked, hasRealtime, realtime, hlSurface.fade, light.flags.w);
}

void hlDirect(IncidentLight incoming, vec3 position, vec3 normal, vec3 viewDirection, vec3 clearcoatNormal,
              PhysicalMaterial material, inout ReflectedLight reflectedLight)
{
#ifdef HL_THREE_BRDF
    RE_Direct(incoming, position, normal, viewDirection, clearcoatNormal, material, reflectedLight);
#else
    reflectedLight.directDiffuse +=
        hlReflectLight(hlSurface.baseColor, hlSurface.metallic, hlSurface.roughness, hlSurface.specular, normal,
                       viewDirection, incoming.direction, incoming.color);
#endif
}

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
    float baked = hlMainFlags.x >= 0.0 ? hlSurface.baked[int(hlMainFlags.x)] : 1.0;
    return hlSubtractiveIrradiance(lightmap, hlMainIrradiance, baked, faded, hlShadowColor, hlMainFlags.w);
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
    if (hlView == 1) return hlSurface.baked.rgb * mix(0.5, 1.0, hlSurface.baked.a);
    if (hlView == 2) return hlSurface.lightmapped ? hlLightmap() * (1.0 / hlShadingPi) : vec3(0.0);
    if (hlView == 3) return hlIrradiance(hlSurface.normal, false) * (1.0 / hlShadingPi);
    if (hlView == 4) return vec3(hlSurface.fade);
    vec3 ramp[6] = vec3[6](vec3(0.0), vec3(0.0, 0.0, 1.0), vec3(0.0, 1.0, 0.0), vec3(1.0, 1.0, 0.0), vec3(1.0, 0.0, 0.0),
                           vec3(1.0));
    return ramp[min(hlOverlap, 5)];
}
`;

/** After three.js has set up its material, before its lights. */
export const fragmentBegin = `
#ifdef IOR
float hlSpecularFactor = specularIntensityFactor;
#else
float hlSpecularFactor = 1.0;
#endif
hlReadSurface(normal, nonPerturbedNormal, isOrthographic ? vec3(0.0, 0.0, 1.0) : normalize(vViewPosition), faceDirection,
              diffuseColor.rgb, metalnessFactor, roughnessFactor, hlSpecularFactor);
float hlRealtime = 1.0;
`;

/** After three.js's lights. */
export const fragmentAreaLights = `
#ifdef HL_AREA_LIGHTS
for (int i = 0; i < HL_AREA_LIGHTS; ++i) reflectedLight.directDiffuse += hlAreaLight(hlAreaLights[i]);
#endif
`;

/** After three.js's lights and occlusion texture. */
export const fragmentIndirect = `
{
    vec3 hlRadiance = hlIndirect();
#ifdef USE_AOMAP
    hlRadiance *= ambientOcclusion;
#endif
    reflectedLight.indirectDiffuse += hlRadiance;
}
`;

export const fragmentView = `
if (hlView != 0) outgoingLight = hlDebugView();
`;
