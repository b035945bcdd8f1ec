// Rectangle and disk lights: flat, one-sided, of one radiance. Diffuse light is exact (Lambert's contour integral of
// the part above the horizon). Specular light is that of a linearly transformed cosine (Heitz, Dupuy, Hill and Neubelt
// 2016, "Real-Time Polygonal-Light Shading with Linearly Transformed Cosines").
//
// A light is given by the vector from the receiver to its middle and by half its width and height as vectors along its
// X and Y; of a disk both have the length of the radius. It shines along -Z = -cross(X, Y).
#ifndef HALFLIGHT_SHADING_AREA_LIGHT_H
#define HALFLIGHT_SHADING_AREA_LIGHT_H

#include "brdf.h"
#include "light.h"

HL_NAMESPACE_BEGIN

HL_FN bool isAreaLight(int lightType)
{
    return lightType >= kLightRectangle;
}

// Angle between a and b times the z of their plane's unit normal. Half the sum over the edges of a polygon is the
// irradiance at the origin on a surface whose normal is +Z, for radiance 1 (Lambert 1760, Photometria).
HL_FN float edgeIntegral(vec3 a, vec3 b)
{
    vec3 n = cross(a, b);
    float sine = length(n);
    return sine > 1.0e-30f ? n.z * (atan(sine, dot(a, b)) / sine) : 0.0f;
}

// Where the edge from a to b crosses the horizon z = 0; a where it does not.
HL_FN vec3 horizonCrossing(vec3 a, vec3 b)
{
    float t = a.z * b.z < 0.0f ? a.z / (a.z - b.z) : 0.0f;
    vec3 p = mix(a, b, t);
    return t > 0.0f ? vec3(p.x, p.y, 0.0f) : a;
}

// edgeIntegral() of the edge's part above the horizon.
HL_FN float edgeAboveHorizon(vec3 a, vec3 b)
{
    vec3 from = a.z < 0.0f ? horizonCrossing(a, b) : a;
    vec3 to = b.z < 0.0f ? horizonCrossing(a, b) : b;
    return max(a.z, b.z) >= 0.0f ? edgeIntegral(from, to) : 0.0f;
}

// The edge's point on the horizon if it goes down there from a to b, else zero.
HL_FN vec3 horizonExit(vec3 a, vec3 b)
{
    return a.z >= 0.0f && b.z < 0.0f ? horizonCrossing(a, b) : vec3(0.0f);
}

// Irradiance at the origin on a surface with normal +Z, for radiance 1: a, b, c, d are the corners of a flat convex
// quadrilateral, counter-clockwise as seen from its back. 0 at its back. From 100 times its size on it counts as a
// point, since the sum over edges rounds there.
HL_FN float quadIrradiance(vec3 a, vec3 b, vec3 c, vec3 d)
{
    vec3 middle = 0.25f * (a + b + c + d);
    vec3 area = 0.5f * cross(c - a, d - b);
    float d2 = dot(middle, middle);
    float size2 = max(dot(c - a, c - a), dot(d - b, d - b));
    float ofPoint = max(middle.z, 0.0f) * max(dot(middle, area), 0.0f) / max(d2 * d2, 1.0e-30f);
    vec3 exit = horizonExit(a, b) + horizonExit(b, c) + horizonExit(c, d) + horizonExit(d, a); // one at most
    vec3 entry = horizonExit(b, a) + horizonExit(c, b) + horizonExit(d, c) + horizonExit(a, d);
    float sum = edgeAboveHorizon(a, b) + edgeAboveHorizon(b, c) + edgeAboveHorizon(c, d) + edgeAboveHorizon(d, a) +
                edgeIntegral(exit, entry);
    return d2 > 1.0e4f * size2 ? ofPoint : 0.5f * max(sum, 0.0f);
}

// atan(x y) / x, also where x is 0.
HL_FN float atanOver(float x, float y)
{
    float p = x * y;
    return abs(p) < 1.0e-2f ? y * (1.0f - p * p * (1.0f / 3.0f)) : atan(p) / x;
}

// log(1 + x y) / x, also where x is 0.
HL_FN float logOver(float x, float y)
{
    float p = x * y;
    return abs(p) < 1.0e-2f ? y * (1.0f - p * (0.5f - p * (1.0f / 3.0f)))
                            : log2(max(1.0f + p, 1.0e-30f)) * 0.69314718f / x;
}

// Irradiance at the origin on a surface with normal +Z of the disk around `center` with unit normal `back` (its Z), for
// radiance 1. The contour integral over the arc above the horizon, with u, v, back an orthonormal frame in which
// center = h back + r u, is that of
//   (R^2 back.z + R (r back.z - h u.z) cos t - R h v.z sin t) / (D + E cos t),  D = h^2 + r^2 + R^2,  E = 2 R r,
// whose antiderivatives are elementary; the chord on the horizon closes it. Whole disks: Naraghi 1988, "Radiative View
// Factors from Spherical Segments to Planar Surfaces", has the same value.
HL_FN float diskIrradiance(vec3 center, vec3 back, float radius)
{
    float h = dot(center, back);
    vec3 across = center - back * h;
    float r = length(across);
    vec3 other = abs(back.y) < 0.9f ? vec3(0.0f, 1.0f, 0.0f) : vec3(1.0f, 0.0f, 0.0f);
    vec3 u = r > 1.0e-6f * radius ? across / max(r, 1.0e-30f) : normalize(cross(other, back));
    vec3 v = cross(back, u);

    // The arc from `from` to `to` is above the horizon.
    float swing = radius * sqrt(u.z * u.z + v.z * v.z);
    float halfArc = acos(clamp(-center.z / max(swing, 1.0e-30f), -1.0f, 1.0f));
    float middle = swing > 0.0f ? atan(v.z, u.z) : 0.0f;
    float from = middle - halfArc;
    float to = middle + halfArc;
    vec3 exit = center + radius * (cos(to) * u + sin(to) * v);
    vec3 entry = center + radius * (cos(from) * u + sin(from) * v);
    bool whole = center.z >= swing;

    float d = h * h + r * r + radius * radius;
    float e = 2.0f * radius * r;
    float q = sqrt(max((d - e) * (d + e), 1.0e-30f));
    float sinFrom = sin(from) / (d + q + e * cos(from));
    float sinTo = sin(to) / (d + q + e * cos(to));
    float turn = whole ? 2.0f * kShadingPi : 2.0f * halfArc;
    float bend = whole ? 0.0f : 2.0f * (atanOver(e, sinTo) - atanOver(e, sinFrom));
    float ofOne = (turn - e * bend) / q;
    float ofCos = (d * bend - turn * e / (d + q)) / q;
    float ofSin = whole ? 0.0f : -logOver(e, (cos(to) - cos(from)) / (d + e * cos(from)));
    float arc = radius * (radius * back.z * ofOne + (r * back.z - h * u.z) * ofCos - h * v.z * ofSin);
    float chord = whole ? 0.0f : edgeIntegral(vec3(exit.x, exit.y, 0.0f), vec3(entry.x, entry.y, 0.0f));
    return center.z > -swing ? 0.5f * max(arc + chord, 0.0f) : 0.0f;
}

// Unit tangent at n away from the view: with cross(n, it) and n the frame of the functions below.
HL_FN vec3 tangentFromView(vec3 n, vec3 v)
{
    vec3 t = n * dot(n, v) - v;
    vec3 other = abs(n.y) < 0.9f ? vec3(0.0f, 1.0f, 0.0f) : vec3(1.0f, 0.0f, 0.0f);
    return dot(t, t) > 1.0e-8f ? normalize(t) : normalize(cross(other, n));
}

HL_FN vec3 inFrame(vec3 tangent, vec3 n, vec3 x)
{
    return vec3(dot(x, tangent), dot(x, cross(n, tangent)), dot(x, n));
}

// Irradiance on a surface with normal n of an area light of radiance 1 that nothing hides.
HL_FN float areaIrradiance(int shape, vec3 n, vec3 toCenter, vec3 halfX, vec3 halfY)
{
    vec3 t = tangentFromView(n, n);
    vec3 c = inFrame(t, n, toCenter);
    vec3 x = inFrame(t, n, halfX);
    vec3 y = inFrame(t, n, halfY);
    return shape == kLightDisk ? diskIrradiance(c, normalize(cross(x, y)), length(x))
                               : quadIrradiance(c - x - y, c + x - y, c + x + y, c - x + y);
}

// The transformed cosine nearest to the specular lobe of reflectLight() times N.l, in the frame of tangentFromView().
// It is that of directions d whose (d.x - z d.z) / x, d.y / y, d.z are cosine-distributed. The transform leaves the
// horizon where it is. A fit to 64 roughnesses and angles of view, by the mean absolute difference of densities, 0.16
// on average (the best such transform for each alone: 0.14).
HL_FN vec3 specularTransform(float roughness, float nDotV)
{
    float a = square(max(roughness, 0.045f));
    float c = clamp(nDotV, 0.0f, 1.0f);
    float s2 = 1.0f - c * c;
    float y = 2.0f * a * (1.0f + a * (0.0841f + a * (-1.1430f + 0.6219f * a) + s2 * s2 * (-0.1661f + 0.2782f * a)));
    float z =
        sqrt(s2) * (1.0f - a) * (1.0f + a * (-0.8229f + 9.6826f * a)) / (c + a * (0.3621f - 2.4186f * c + 9.5871f * a));
    float x =
        y * (1.0f + z * z) * (1.0f + a * s2 * (0.0010f - 0.0162f * a + (1.0f - a) * s2 * (0.6206f + 0.2462f * s2)));
    return vec3(x, y, z);
}

HL_FN vec3 inLobe(vec3 transform, vec3 p)
{
    return vec3((p.x - transform.z * p.z) / transform.x, p.y / transform.y, p.z);
}

// quadIrradiance() of a part of a disk between two chords along `up`, in the lobe's frame. cosine and sine: of the
// chords' ends.
HL_FN float diskStrip(vec3 center, vec3 right, vec3 up, vec2 first, vec2 second)
{
    return quadIrradiance(center + second.x * right - second.y * up, center + first.x * right - first.y * up,
                          center + first.x * right + first.y * up, center + second.x * right + second.y * up);
}

// Share of the specular lobe's light that an area light of radiance 1 sends: 1 if it fills the lobe. A disk counts as
// the regular polygon of 12 corners with its area.
HL_FN float areaSpecular(int shape, float roughness, vec3 n, vec3 v, vec3 toCenter, vec3 halfX, vec3 halfY)
{
    vec3 transform = specularTransform(roughness, abs(dot(n, v)));
    vec3 t = tangentFromView(n, v);
    vec3 c = inLobe(transform, inFrame(t, n, toCenter));
    vec3 x = inLobe(transform, inFrame(t, n, halfX));
    vec3 y = inLobe(transform, inFrame(t, n, halfY));
    vec3 r = 1.0233f * x; // sqrt(pi / (6 sin 30 degrees))
    vec3 up = 1.0233f * y;
    // Corners at 15, 45, 75, 105, 135 and 165 degrees.
    vec2 c15 = vec2(0.96592583f, 0.25881905f);
    vec2 c45 = vec2(0.70710678f, 0.70710678f);
    vec2 c75 = vec2(0.25881905f, 0.96592583f);
    vec2 c105 = vec2(-0.25881905f, 0.96592583f);
    vec2 c135 = vec2(-0.70710678f, 0.70710678f);
    vec2 c165 = vec2(-0.96592583f, 0.25881905f);
    float irradiance = shape == kLightDisk ? diskStrip(c, r, up, c15, c45) + diskStrip(c, r, up, c45, c75) +
                                                 diskStrip(c, r, up, c75, c105) + diskStrip(c, r, up, c105, c135) +
                                                 diskStrip(c, r, up, c135, c165)
                                           : quadIrradiance(c - x - y, c + x - y, c + x + y, c - x + y);
    return irradiance * (1.0f / kShadingPi);
}

// Reflectance of the specular lobe of reflectLight() for an area light that sends `share` of the lobe's light.
// Fresnel's is that of the light's middle (or of the horizon above it) for a small light, and the lobe's mean for one
// that fills the lobe. The exponent is a fit to integrals of the BRDF. The mean for all lights, as usual tables have it
// (Hill and Heitz 2016), makes highlights of dielectrics wrong by up to 80 % at grazing views.
HL_FN vec3 areaReflectance(vec3 f0, float f90, float roughness, vec3 n, vec3 v, vec3 toCenter, float share)
{
    float nDotV = clamp(abs(dot(n, v)), 0.0f, 1.0f);
    vec3 l = toCenter - n * min(dot(n, toCenter), 0.0f);
    float lDotV = dot(l, v) / max(length(l), 1.0e-30f);
    vec3 ofMiddle = fresnelSchlick(f0, f90, sqrt(saturate(0.5f + 0.5f * lDotV))) *
                    environmentSpecular(vec3(1.0f), 1.0f, roughness, nDotV);
    return mix(ofMiddle, environmentSpecular(f0, f90, roughness, nDotV), pow(clamp(share, 0.0f, 1.0f), 0.75f));
}

// Radiance reflected to v from an area light that nothing hides, as reflectLight() does for light from one direction:
// the diffuse part by the mean Fresnel reflectance (diffuseShare()).
HL_FN vec3 reflectAreaLight(vec3 baseColor, float metallic, float roughness, float specularFactor, vec3 n, vec3 v,
                            int shape, vec3 toCenter, vec3 halfX, vec3 halfY, vec3 radiance)
{
    vec3 f0 = specularF0Of(baseColor, metallic, specularFactor);
    float f90 = specularF90Of(metallic, specularFactor);
    float nDotV = clamp(abs(dot(n, v)), 0.0f, 1.0f);
    vec3 diffuse = diffuseRadiance(diffuseAlbedoOf(baseColor, metallic) * diffuseShare(f0, f90, nDotV),
                                   vec3(areaIrradiance(shape, n, toCenter, halfX, halfY)));
    float share = areaSpecular(shape, roughness, n, v, toCenter, halfX, halfY);
    return (diffuse + areaReflectance(f0, f90, roughness, n, v, toCenter, share) * share) * radiance;
}

HL_NAMESPACE_END

#endif
