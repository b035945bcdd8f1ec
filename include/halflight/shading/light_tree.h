// Nodes of a tree over many lights (Conty Estevez and Kulla 2018, "Importance Sampling of Many Lights with Adaptive
// Tree Splitting").
#ifndef HALFLIGHT_SHADING_LIGHT_TREE_H
#define HALFLIGHT_SHADING_LIGHT_TREE_H

#include "language.h"

HL_NAMESPACE_BEGIN

// Lower bound of both cosines: rounding errors of a node's bounds must not give a light probability 0.
HL_CONST float kLeastLightCosine = 0.02f;

struct LightNode {
    vec3 center;     // metres
    float radius;    // of the sphere around the bounds
    vec3 axis;       // mean direction of the lights' normals
    float cosSpread; // cosine of the half angle of the cone of normals; -1 = all directions
    float sinSpread;
    float power;   // flux, in any unit common to all lights
    float range;   // largest of its lights, metres; 0 = unlimited
    uint second;   // second child (the first follows its parent); of a leaf, the item
    uint parent;   // of the root, 0xffffffff
    uint leaf;     // 1 or 0
    uint twoSided; // 1 or 0
};

HL_FN float sineOfCosine(float cosine)
{
    return sqrt(max(0.0f, 1.0f - cosine * cosine));
}

// cos(max(0, a - b)) from the cosines of two angles in 0...pi and the sine of the second.
HL_FN float cosineOfDifference(float cosA, float cosB, float sinB)
{
    return cosA > cosB ? 1.0f : cosA * cosB + sineOfCosine(cosA) * sinB;
}

// Estimate of the unshadowed illuminance, in power per square metre. `normal` zero = the point receives from all
// directions. Without branches on the point, so that loops over points are vectorized.
HL_FN float lightImportance(HL_IN(LightNode) node, vec3 position, vec3 normal)
{
    vec3 to = node.center - position;
    float distance2 = dot(to, to);
    float radius2 = node.radius * node.radius;
    float within = node.power / max(radius2, 1.0e-12f);
    float reach = node.range > 0.0f ? node.range + node.radius : 1.0e19f; // its square is a float
    // Angles of the node's bounding sphere, the receiver's normal and the emitters' normals.
    float inverse = 1.0f / sqrt(distance2);
    vec3 direction = to * inverse;
    float sinSphere = node.radius * inverse;
    float cosSphere = sineOfCosine(sinSphere);
    float cosine = min(dot(normal, direction), 1.0f);
    float facing = max(cosineOfDifference(cosine, cosSphere, sinSphere), kLeastLightCosine);
    float received = dot(normal, normal) > 0.0f ? facing : 1.0f;
    float front = min(max(-dot(node.axis, direction), -1.0f), 1.0f);
    float cosAxis = node.twoSided != 0u ? abs(front) : front;
    float cosOut = cosineOfDifference(cosAxis, node.cosSpread, node.sinSpread);
    float shining = max(cosineOfDifference(cosOut, cosSphere, sinSphere), kLeastLightCosine);
    float emitted = node.cosSpread > -1.0f ? shining : 1.0f;
    float outside = node.power * received * emitted * (inverse * inverse);
    float weight = distance2 <= radius2 || distance2 < 1.0e-12f ? within : outside;
    return distance2 > reach * reach ? 0.0f : weight;
}

HL_NAMESPACE_END

#endif
