#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require
#extension GL_EXT_nonuniform_qualifier : require
// The forward lit pass: material, direct lights of the fragment's cluster, baked indirect light.
#include "indirect.glsl"
#include "lighting.glsl"

layout(constant_id = 0) const int kAlphaMode = kAlphaOpaque;

layout(location = 0) out vec4 outRadiance;

// Lightmap texels as squares, coloured by their number per metre on a scale of powers of 4.
vec3 texelView()
{
    vec2 texel = inLightmapUv * vec2(textureSize(lightmaps, 0).xy);
    vec2 dx = dFdx(texel);
    vec2 dy = dFdy(texel);
    float squareMeters = length(cross(dFdx(inPosition), dFdy(inPosition)));
    float perMeter = sqrt(abs(dx.x * dy.y - dx.y * dy.x) / max(squareMeters, 1.0e-20));
    vec3 ramp[5] = vec3[5](vec3(0.0, 0.0, 1.0), vec3(0.0, 1.0, 1.0), vec3(0.0, 1.0, 0.0), vec3(1.0, 1.0, 0.0),
                           vec3(1.0, 0.0, 0.0));
    float level = clamp(0.5 * log2(max(perMeter, 1.0)), 0.0, 4.0);
    int below = min(int(level), 3);
    vec3 color = mix(ramp[below], ramp[below + 1], level - float(below));
    bool odd = ((int(floor(texel.x)) + int(floor(texel.y))) & 1) != 0;
    // Squares smaller than a pixel are their mean.
    float blur = saturate(2.0 * max(length(dx), length(dy)) - 1.0);
    return color * mix(odd ? 0.5 : 1.0, 0.75, blur);
}

// S31. Debug views.
vec3 debugView(MeshSurface mesh)
{
    Surface s = mesh.lit;
    float shade = 0.25 + 0.75 * abs(dot(s.normal, s.view));
    if (frame.mode.y == kViewShadowmask) { // of all layers together
        vec4 mask = min(min(s.baked[0], s.baked[1]), min(s.baked[2], s.baked[3]));
        return mask.rgb * mix(0.5, 1.0, mask.a);
    }
    if (frame.mode.y == kViewLightmap)
        return s.lightmapped ? (lightmapIrradiance() + dynamicIrradiance()) * (1.0 / kShadingPi) : vec3(0.0);
    if (frame.mode.y == kViewProbes) return irradianceFrom(mesh.probes, s.normal) * (1.0 / kShadingPi);
    if (frame.mode.y == kViewTexels) return s.lightmapped ? texelView() : vec3(0.0);
    if (frame.mode.y == kViewFade) return vec3(s.fade);
    if (frame.mode.y == kViewCascades) {
        vec3 colors[4] = vec3[4](vec3(1.0, 0.3, 0.3), vec3(0.3, 1.0, 0.3), vec3(0.3, 0.4, 1.0), vec3(1.0, 1.0, 0.3));
        float nextWeight;
        int cascade = selectCascade(s.cameraDistance, nextWeight);
        vec3 color = mix(colors[cascade], colors[min(cascade + 1, 3)], nextWeight);
        return mix(color, vec3(1.0), s.fade) * shade;
    }
    // Lights with a mask channel, or for which none was left, that reach the fragment: none black, 1 blue, 2 green,
    // 3 yellow, 4 red, more white.
    int count = 0;
    int cluster = clusterOf(s.position);
    for (int light = 0; light < frame.mode.w; ++light) {
        if ((clusterWords[cluster + light / 32] >> (light % 32) & 1u) == 0u) continue;
        if ((lights[light].info.y & (kLightHasBaked | kLightOverflowed)) == 0) continue;
        if (sampleFrameLight(light, s.position).illuminance != vec3(0.0)) ++count;
    }
    vec3 ramp[6] = vec3[6](vec3(0.0), vec3(0.0, 0.0, 1.0), vec3(0.0, 1.0, 0.0), vec3(1.0, 1.0, 0.0), vec3(1.0, 0.0, 0.0),
                           vec3(1.0));
    return ramp[min(count, 5)];
}

void main()
{
    if (kAlphaMode == kAlphaPass) { // multiplies what is behind, before the surface's own light is added
        vec4 base = materials[push.info.x].baseColor * inColor *
                    materialTexture(push.info.x, kTextureBaseColor, inUv, vec4(1.0));
        vec3 behind = vec3(1.0);
        if (push.info.w == 0 && materials[push.info.x].volume.rgb != vec3(0.0)) {
            vec3 across = cross(dFdx(inPosition), dFdy(inPosition));
            vec3 normal = dot(across, across) > 0.0 ? normalize(across) : vec3(0.0, 1.0, 0.0);
            behind = paneLeaves(push.info.x, inUv, normal, mat3(objects[inObject].worldFromObject), viewRay(inPosition));
        }
        outRadiance =
            vec4(passed(push.info.x, inUv, base, behind), 1.0 - coverage(push.info.x, inUv, base.a));
        return;
    }
    MeshSurface mesh = readSurface();
    vec3 radiance;
    if (frame.mode.y != kViewLit) {
        radiance = debugView(mesh);
    } else if (mesh.unlit) {
        radiance = mesh.lit.baseColor;
    } else {
        vec3 lightmap = vec3(0.0);
        if (usesLightmap(mesh.lit))
            lightmap = subtractDynamicShadows(lightmapIrradiance(), mesh.lit, mesh.vertexNormal);
        radiance = mesh.emissive + indirectLight(mesh, lightmap) + directLight(mesh.lit);
    }
    float alpha = kAlphaMode == kAlphaBlend ? coverage(push.info.x, inUv, mesh.alpha) : 1.0;
    outRadiance = vec4(radiance * alpha, alpha);
}
