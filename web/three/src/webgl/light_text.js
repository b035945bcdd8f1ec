// GLSL of direct light: which lights reach a surface, their shadows, area lights. It follows surface_text.js.

export const lightText = `
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

// B of a light where its mask says "baked".
float hlWithinReach(HlLight light, float baked)
{
    vec3 fromLight = vHlPosition - light.reach.xyz;
    float distanceMeters = max(length(fromLight), 1.0e-6);
    float cosAngle = dot(fromLight, light.cone.xyz) / distanceMeters;
    return hlBakedWithinReach(baked, distanceMeters, light.reach.w, cosAngle, light.cone.w);
}

// What shadows leave of the light, by colour.
vec3 hlAttenuation(HlLight light, bool hasRealtime, float realtime)
{
    bool hasBaked = light.flags.x >= 0.0;
#ifdef HL_COLORED_MASKS
    vec3 baked = hasBaked ? max(hlBakedByColor(light.flags), vec3(hlWithinReach(light, 0.0))) : vec3(1.0);
    return hlMixShadowsByColor(hlMode, hasBaked, baked, hasRealtime, realtime, hlSurface.fade, light.flags.w);
#else
    float baked = hasBaked ? hlWithinReach(light, hlBakedOf(int(light.flags.x))) : 1.0;
    return vec3(hlMixShadows(hlMode, hasBaked, baked, hasRealtime, realtime, hlSurface.fade, light.flags.w));
#endif
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
    return reflected * hlAttenuation(area.light, false, 1.0);
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
    incoming.color *= hlAttenuation(light, hasRealtime, realtime);
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
`;
