// Sampling of area lights (area_light.h) by solid angle, for path tracers.
#ifndef HALFLIGHT_SHADING_AREA_SAMPLING_H
#define HALFLIGHT_SHADING_AREA_SAMPLING_H

#include "area_light.h"
#include "sampling.h"

HL_NAMESPACE_BEGIN

// A point of a light, as seen from a receiver at the origin.
struct AreaSample {
    vec3 position;    // metres
    float solidAngle; // steradians that the sample stands for, 1 / pdf; 0 = the sample misses the light
};

// From this many times the longer half side on, points are uniform in area: solid angles are small there, their
// differences of angles round, and the density changes by less than a third over the light.
HL_CONST float kNearAreaLight = 6.0f;

// A rectangle seen from the origin: Urena, Fajardo and King 2013, "An Area-Preserving Parametrization for Spherical
// Rectangles", with z0 < 0 the distance of its plane, x0, x1, y0, y1 its sides.
struct SphericalRectangle {
    float x0;
    float x1;
    float y0;
    float y1;
    float z0;
    float b0;
    float b1;
    float k;
    float solidAngle;
};

// Normal of the plane through the origin and a side; zero where the origin is on the side's line.
HL_FN vec3 sideNormal(vec3 a, vec3 b)
{
    vec3 n = cross(a, b);
    return n / max(length(n), 1.0e-30f);
}

HL_FN SphericalRectangle sphericalRectangle(float x0, float x1, float y0, float y1, float z0)
{
    vec3 n0 = sideNormal(vec3(x0, y0, z0), vec3(x1, y0, z0));
    vec3 n1 = sideNormal(vec3(x1, y0, z0), vec3(x1, y1, z0));
    vec3 n2 = sideNormal(vec3(x1, y1, z0), vec3(x0, y1, z0));
    vec3 n3 = sideNormal(vec3(x0, y1, z0), vec3(x0, y0, z0));
    float g0 = acos(clamp(-dot(n0, n1), -1.0f, 1.0f));
    float g1 = acos(clamp(-dot(n1, n2), -1.0f, 1.0f));
    float g2 = acos(clamp(-dot(n2, n3), -1.0f, 1.0f));
    float g3 = acos(clamp(-dot(n3, n0), -1.0f, 1.0f));
    SphericalRectangle s;
    s.x0 = x0;
    s.x1 = x1;
    s.y0 = y0;
    s.y1 = y1;
    s.z0 = z0;
    s.b0 = n0.z;
    s.b1 = n2.z;
    s.k = 2.0f * kShadingPi - g2 - g3;
    s.solidAngle = max(g0 + g1 - s.k, 0.0f);
    return s;
}

// x and y of a point that is uniform in solid angle.
HL_FN vec2 sampleSphericalRectangle(SphericalRectangle s, vec2 u)
{
    float au = u.x * s.solidAngle + s.k;
    float sine = sin(au);
    float fu = (cos(au) * s.b0 - s.b1) / (abs(sine) > 1.0e-7f ? sine : 1.0e-7f);
    float norm = max(sqrt(fu * fu + s.b0 * s.b0), 1.0e-20f);
    float cu = clamp((fu > 0.0f ? 1.0f : -1.0f) / norm, -0.9999999f, 0.9999999f);
    float x = clamp(-cu * s.z0 / sqrt(1.0f - cu * cu), s.x0, s.x1);
    float d2 = max(x * x + s.z0 * s.z0, 1.0e-20f);
    float h0 = s.y0 / sqrt(d2 + s.y0 * s.y0);
    float h1 = s.y1 / sqrt(d2 + s.y1 * s.y1);
    float h = h0 + u.y * (h1 - h0);
    float y = h * h < 0.999999f ? h * sqrt(d2 / (1.0f - h * h)) : (h > 0.0f ? s.y1 : s.y0);
    return vec2(x, clamp(y, s.y0, s.y1));
}

// A point of an area light that nothing hides. Disks: points of their square, of which those outside miss. Receivers
// behind the light get none.
HL_FN AreaSample sampleAreaLight(int type, vec3 toCenter, vec3 halfX, vec3 halfY, vec2 u)
{
    AreaSample result;
    float lengthX = length(halfX);
    float lengthY = length(halfY);
    vec3 x = halfX / lengthX;
    vec3 y = halfY / lengthY;
    vec3 z = cross(x, y);
    float height = dot(toCenter, z); // above 0 in front of the light
    float nearest = kNearAreaLight * max(lengthX, lengthY);
    vec2 at = 2.0f * u - vec2(1.0f);
    bool isNear = dot(toCenter, toCenter) < nearest * nearest;
    float solidAngle = 0.0f;
    if (isNear && height > 0.0f) {
        float cx = dot(toCenter, x);
        float cy = dot(toCenter, y);
        SphericalRectangle s = sphericalRectangle(cx - lengthX, cx + lengthX, cy - lengthY, cy + lengthY, -height);
        vec2 p = sampleSphericalRectangle(s, u);
        at = vec2((p.x - cx) / lengthX, (p.y - cy) / lengthY);
        solidAngle = s.solidAngle;
    } else if (type == kLightDisk) {
        at = sampleDisc(u);
    }
    result.position = toCenter + at.x * halfX + at.y * halfY;
    if (!isNear && height > 0.0f) {
        float d2 = dot(result.position, result.position);
        float area = type == kLightDisk ? kShadingPi * lengthX * lengthY : 4.0f * lengthX * lengthY;
        solidAngle = area * height / (d2 * sqrt(d2));
    }
    bool misses = type == kLightDisk && dot(at, at) > 1.0f + 1.0e-5f;
    result.solidAngle = misses ? 0.0f : solidAngle;
    return result;
}

// Density of sampleAreaLight() per steradian for a point that it can choose, at `position` from the receiver.
HL_FN float areaSamplePdf(int type, vec3 toCenter, vec3 halfX, vec3 halfY, vec3 position)
{
    float lengthX = length(halfX);
    float lengthY = length(halfY);
    vec3 x = halfX / lengthX;
    vec3 y = halfY / lengthY;
    float height = dot(toCenter, cross(x, y));
    float nearest = kNearAreaLight * max(lengthX, lengthY);
    if (height <= 0.0f) return 0.0f;
    if (dot(toCenter, toCenter) < nearest * nearest) {
        float cx = dot(toCenter, x);
        float cy = dot(toCenter, y);
        SphericalRectangle s = sphericalRectangle(cx - lengthX, cx + lengthX, cy - lengthY, cy + lengthY, -height);
        return s.solidAngle > 0.0f ? 1.0f / s.solidAngle : 0.0f;
    }
    float d2 = dot(position, position);
    float area = type == kLightDisk ? kShadingPi * lengthX * lengthY : 4.0f * lengthX * lengthY;
    return d2 * sqrt(d2) / (area * height);
}

// Distance along a unit direction from the origin to a light's front; below 0 where it does not meet it.
HL_FN float meetAreaLight(int type, vec3 toCenter, vec3 halfX, vec3 halfY, vec3 direction)
{
    vec3 z = cross(halfX, halfY);
    float along = dot(direction, z);
    float distance = dot(toCenter, z) / (along > 0.0f ? along : 1.0f);
    vec3 p = direction * distance - toCenter;
    vec2 at = vec2(dot(p, halfX) / dot(halfX, halfX), dot(p, halfY) / dot(halfY, halfY));
    bool inside = type == kLightDisk ? dot(at, at) <= 1.0f : max(abs(at.x), abs(at.y)) <= 1.0f;
    return along > 0.0f && distance > 0.0f && inside ? distance : -1.0f;
}

// Inverse of sampleDisc().
HL_FN vec2 squareOfDisc(vec2 disc)
{
    vec2 a = abs(disc);
    float r = length(disc);
    if (r <= 0.0f) return vec2(0.5f);
    // In the quarter of the larger coordinate the smaller one is r times the angle over pi / 4.
    float share = atan(min(a.x, a.y), max(a.x, a.y)) / (kShadingPi / 4.0f);
    vec2 o = a.x > a.y ? vec2(r, r * share) : vec2(r * share, r);
    return 0.5f * (vec2(disc.x < 0.0f ? -o.x : o.x, disc.y < 0.0f ? -o.y : o.y) + vec2(1.0f));
}

HL_NAMESPACE_END

#endif
