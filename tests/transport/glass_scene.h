#pragma once
// Coloured glass above a floor, and the closed forms of what passes it.

#include "reference/traced.h"

#include <gtest/gtest.h>

#include <cmath>

namespace halflight::test::glass {

constexpr int kPage = 16;
constexpr float kHeight = 0.5f; // of the glass above the floor, metres
constexpr float kThick = 0.2f;  // metres
inline const vec3 kColor(0.9f, 0.3f, 0.1f);
inline const vec3 kLeft(0.8f, 0.4f, 0.2f); // of white light after kDistance
constexpr float kDistance = 0.4f;
constexpr float kAlpha = 0.25f;

enum class Glass { Quad, Pane, Box, Thin };

/// Closed forms: 1 - alpha, or 96 % at each face, times the colour; in a volume c^(way / distance) (Beer's law).
inline vec3 expectedOf(Glass glass, float cosine)
{
    vec3 passed;
    for (int c = 0; c < 3; ++c) {
        const float volume = std::pow(kLeft[c], kThick / cosine / kDistance);
        const float face = 0.96f * kColor[c];
        passed[c] = glass == Glass::Quad   ? (1.0f - kAlpha) * kColor[c]
                    : glass == Glass::Pane ? face
                    : glass == Glass::Box  ? face * face * volume
                                           : face * volume;
    }
    return passed;
}

inline int addGlassMaterial(Scene& scene, Glass glass)
{
    const int number = addMaterial(scene, kColor);
    Material& m = scene.materials.back();
    if (glass == Glass::Quad) {
        m.alphaMode = Material::AlphaMode::Blend;
        m.baseColor.w = kAlpha;
        m.tinted = true;
    } else {
        m.transmission = 1.0f;
    }
    if (glass == Glass::Box || glass == Glass::Thin) {
        m.thickness = kThick;
        m.attenuationColor = kLeft;
        m.attenuationMeters = kDistance;
    }
    return number;
}

/// Wide glass above the floor.
inline void addGlass(Scene& scene, Glass glass, float height = kHeight, float half = 500.0f)
{
    const int material = addGlassMaterial(scene, glass);
    if (glass == Glass::Box) {
        const std::size_t first = scene.objects.size();
        addBox(scene, vec3(-half, height, -half), vec3(half, height + kThick, half), material, false);
        joinObjects(scene, first);
        return;
    }
    addRectangle(scene, {vec3(-half, height, half), vec3(2 * half, 0, 0), vec3(0, 0, -2 * half)}, material, kPage);
}

inline void expectColor(vec3 found, vec3 expected, float relative = 0.01f)
{
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(found[c], expected[c], relative * expected[c]) << "channel " << c;
}

} // namespace halflight::test::glass
