// The G-buffer, and how a surface is written to it and read from it:
//   0  RGBA16F   base colour; a: baked attenuation of subtractive's main light, the only one a frame without mask reads
//   1  RG32UI    normal and the triangle's normal, each as an octahedron in 2 x 16 bits
//   2  RGBA16UI  metallic, roughness, specular factor in 1/65535; flags
//   3            the picture: emissive and indirect light, to which the light pass adds direct light
//   4  RGBA16UI  baked attenuation by channel in 1/65535; there only in frames that use a mask. Eight bits would show in
//                nearly shadowed places, since probes know more than 256 values; a mask's own n/255 are exact.
//      RGBA32UI  where the frame reads two mask layers or more: the second in the upper 16 bits
//   5  RGBA32UI  the third and the fourth layer, likewise
// The material's occlusion dims indirect light only, so it is used up in 3; positions come from depth.
#ifndef HALFLIGHT_GBUFFER_GLSL
#define HALFLIGHT_GBUFFER_GLSL

const uint kGBufferLit = 1u; // not set: nothing here for the light pass
const uint kGBufferLightmapped = 2u;
const uint kGBufferReceiveShadows = 4u;

// Unit vectors on an octahedron unfolded to a square, [-1, 1]^2: Cigolle et al. 2014, "A Survey of Efficient
// Representations for Independent Unit Vectors".
uint packNormal(vec3 n)
{
    vec2 p = n.xy / (abs(n.x) + abs(n.y) + abs(n.z));
    vec2 side = vec2(p.x >= 0.0 ? 1.0 : -1.0, p.y >= 0.0 ? 1.0 : -1.0);
    return packSnorm2x16(n.z >= 0.0 ? p : (1.0 - abs(p.yx)) * side);
}

vec3 unpackNormal(uint packed)
{
    vec2 p = unpackSnorm2x16(packed);
    vec3 n = vec3(p, 1.0 - abs(p.x) - abs(p.y));
    float fold = max(-n.z, 0.0);
    n.xy -= vec2(p.x >= 0.0 ? fold : -fold, p.y >= 0.0 ? fold : -fold);
    return normalize(n);
}

// Values from 0 to 1 in 16 bits.
uvec4 pack16(vec4 values) { return uvec4(clamp(values, vec4(0.0), vec4(1.0)) * 65535.0 + 0.5); }

// Two mask layers in 32 bits.
uvec4 packLayers(vec4 low, vec4 high) { return pack16(low) | pack16(high) << 16; }

vec4 unpack16(uvec4 packed) { return vec4(packed) * (1.0 / 65535.0); }

#endif
