// GLSL of what a fragment's light depends on: uniforms, the surface, its masks and its probes.
import { table } from './table_text.js';

/** The sky by direction. */
export const skyText = `
uniform vec3 hlSky[3]; // zenith, horizon, ground
#ifdef HL_SKY_PICTURE
uniform vec3 hlSkyFactor; // on the picture
uniform highp sampler2D hlSkyPicture;
uniform vec4 hlSkyTurn; // cosine and sine of its rotation, width in texels, cd/m2 of a texel of 1
#endif
// Radiance from unit direction d, in a mirror of this roughness.
vec3 hlSkyTowards(vec3 d, float roughness)
{
#ifdef HL_SKY_PICTURE
    return textureLod(hlSkyPicture, hlSkyPictureUv(d, hlSkyTurn.xy), hlSkyPictureLevel(roughness, hlSkyTurn.z)).rgb * hlSkyTurn.w * hlSkyFactor;
#else
    return hlSkyRadiance(hlSky[0], hlSky[1], hlSky[2], d);
#endif
}
`;

/** Head of a fragment shader. */
export const surfaceText = `
flat varying int vHlRow;
varying vec2 vHlLightmapUv;
varying vec3 vHlPosition;
${table}
struct HlLight {
    vec4 flags; // x channel whose baked shadow is read, -1 none; y 1 = has a shadow map; z bits: 1 not on lightmapped
                // receivers, 2 not on others, 4 subtractive's main light, 8 counts in the overlap view,
                // 16 B has a colour; w shadow strength
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
uniform float hlMaskRange[4 * HL_MASK_LAYERS];
uniform float hlMaskPenumbra[4 * HL_MASK_LAYERS];
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
    vec4 baked[HL_MASK_LAYERS]; // B by mask layer and channel
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

float hlBakedOf(int channel)
{
#if HL_MASK_LAYERS > 1
    return hlSurface.baked[channel / 4][channel % 4];
#else
    return hlSurface.baked[0][channel];
#endif
}

// B by colour of a light with these flags; all alike where its mask is grey.
vec3 hlBakedByColor(vec4 flags)
{
    int channel = int(flags.x);
    return (int(flags.z) & 16) != 0 ? hlSurface.baked[channel / 4].rgb : vec3(hlBakedOf(channel));
}

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
    at.z += float(slab) / float(7 + HL_MASK_LAYERS);
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

vec4 hlProbeOcclusion(int layer)
{
#ifdef HL_VOLUMES
    if (hlSurface.volume >= 0) return hlVolumeTexture(layer == 0 ? 3 : 7 + layer);
#endif
    return hlCell(vHlRow, layer == 0 ? 2 : 11 + layer);
}

vec4 hlReadMask(int layer)
{
#ifdef HL_MASKS
    vec4 stored = textureLod(hlMasks, vec3(vHlLightmapUv, hlSurface.page * HL_MASK_LAYERS + layer), 0.0);
    vec2 size = vec2(textureSize(hlMasks, 0).xy);
    float footprint = max(length(dFdx(vHlLightmapUv) * size), length(dFdy(vHlLightmapUv) * size));
    vec4 attenuation;
    for (int c = 0; c < 4; ++c)
        attenuation[c] = hlDecodeMask(stored[c], hlMaskRange[4 * layer + c], hlMaskPenumbra[4 * layer + c], footprint);
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
    for (int layer = 0; layer < HL_MASK_LAYERS; ++layer) {
        vec4 mask = hlReadMask(layer); // derivatives want uniform control flow
        hlSurface.baked[layer] = hlSurface.lightmapped ? mask : hlProbeOcclusion(layer);
    }
    hlSurface.baseColor = baseColor;
    hlSurface.metallic = hlSaturate(metallic);
    hlSurface.roughness = hlSaturate(roughness);
    hlSurface.specular = specular;
}
`;
