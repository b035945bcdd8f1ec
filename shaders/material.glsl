// Reading glTF materials.
#ifndef HALFLIGHT_MATERIAL_GLSL
#define HALFLIGHT_MATERIAL_GLSL

#include "bindings.glsl"
#include "halflight/shading/coverage.h"

// A texture's value, or `absent` where the material has none. The material is the same for a whole draw, so the index
// is dynamically uniform.
vec4 materialTexture(int material, int slot, vec4 uv, vec4 absent)
{
    ivec4 info = materials[material].textures[slot].info;
    if (info.x < 0) return absent;
    vec4 m = materials[material].textures[slot].matrix;
    vec2 t = info.y == 0 ? uv.xy : uv.zw;
    t = vec2(dot(m.xy, t), dot(m.zw, t)) + materials[material].textures[slot].offset.xy;
    vec4 value = texture(textures[info.x], t);
    // Where all pixels have one coordinate, anisotropy is nothing over nothing, and some drivers (Mesa's llvmpipe)
    // answer with black.
    if (all(lessThan(fwidth(t), vec2(1.0e-9)))) value = textureLod(textures[info.x], t, 0.0);
    return value;
}

// Share of light that passes as through glass.
float glassShare(int material, vec4 uv)
{
    float through = materials[material].reflection.y;
    if (through <= 0.0) return 0.0;
    float metallic = saturate(materials[material].emissiveMetallic.a *
                              materialTexture(material, kTextureMetallicRoughness, uv, vec4(1.0)).b);
    return through * materialTexture(material, kTextureTransmission, uv, vec4(1.0)).r * (1.0 - metallic);
}

// Share of light that the surface stops where base colour and vertices have this alpha: Material::coverage().
float coverage(int material, vec4 uv, float alpha)
{
    return coverageOf(alpha, materials[material].parameters.w, materials[material].info.z != 0,
                      glassShare(material, uv));
}

// Light that the surface lets through where base colour and vertices are this: Material::passed(). behind: what a
// thickness behind the surface lets through.
vec3 passed(int material, vec4 uv, vec4 base, vec3 behind)
{
    return passedOf(base.a, materials[material].parameters.w, materials[material].info.z != 0,
                    glassShare(material, uv), base.rgb, materials[material].reflection.z > 0.0, behind);
}

// What the thickness behind a surface leaves of light. normal: of the triangle, in the world.
vec3 paneLeaves(int material, vec4 uv, vec3 normal, mat3 worldFromObject, vec3 direction)
{
    vec4 volume = materials[material].volume;
    float thickness = volume.a * materialTexture(material, kTextureThickness, uv, vec4(1.0)).g;
    return volumeLeaves(volume.rgb, wayThroughPane(thickness, normal, transpose(worldFromObject) * normal, direction));
}

#endif
