// GLSL between three.js's shaders and the shading headers (generated/shading.glsl.js). It reads textures and uniforms
// and calls the headers' functions; formulas are in the headers.
import { indirectText } from './indirect_text.js';
import { lightText } from './light_text.js';
import { surfaceText } from './surface_text.js';
import { table } from './table_text.js';

/** Location of the vertex attribute that holds an object's row in the table. */
export const ROW_LOCATION = 15;

export const vertexPars = `
layout(location = ${ROW_LOCATION}) in float hlRowAttribute;
attribute vec2 hlLightmapUv;
flat varying int vHlRow;
varying vec2 vHlLightmapUv;
varying vec3 vHlPosition;
${table}
`;

/** The bitangent is that of the mirrored surface, as in the program; three.js's is that of the surface before. */
export const vertexNormal = `
#if defined(USE_TANGENT) && !defined(FLAT_SHADED)
    if (determinant(mat3(modelMatrix)) < 0.0) vBitangent = -vBitangent;
#endif
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

export const fragmentPars = surfaceText + lightText + indirectText;

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

/** What glass lets through, in place of its light. */
export const fragmentGlass = `
gl_FragColor = vec4(hlPassedOf(diffuseColor.a, hlNoCutoff, HL_GLASS_BLENDED, HL_GLASS_SHARE, diffuseColor.rgb, HL_GLASS_TINTED, vec3(1.0)), 1.0);
`;

/** How much of the light of glass is seen. */
export const fragmentCoverage = `
#ifdef HL_GLASS_SHARE
diffuseColor.a = hlCoverageOf(diffuseColor.a, hlNoCutoff, HL_GLASS_BLENDED, HL_GLASS_SHARE);
#endif
`;

export const fragmentView = `
if (hlView != 0) outgoingLight = hlDebugView();
`;
