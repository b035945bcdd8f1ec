#pragma once
// A floor whose charts lie on the page in all ways that seams have to cross.

#include "bake/test_scene.h"

namespace halflight::test {

/// A floor of 6 m x 4 m in four objects: left, a narrow strip, and two on the right that the others' edges meet midway.
/// Their charts lie on the page turned, mirrored, coarser, and at odd fractions of a texel.
inline void addPatchworkFloor(Scene& scene, int material, int pageSize)
{
    addRectangle(scene, {vec3(0, 0, 4), vec3(2, 0, 0), vec3(0, 0, -4)}, material, pageSize,
                 {vec2(3.3f, 2.6f), vec2(23.3f, 42.6f)});
    // Turned by 90°: u goes along -z.
    addRectangle(scene, {vec3(2.3f, 0, 4), vec3(0, 0, -4), vec3(-0.3f, 0, 0)}, material, pageSize,
                 {vec2(30.8f, 4.1f), vec2(70.8f, 7.1f)});
    // Mirrored on the page.
    addRectangle(scene, {vec3(2.3f, 0, 4), vec3(3.7f, 0, 0), vec3(0, 0, -1.5f)}, material, pageSize,
                 {vec2(70.2f, 14.7f), vec2(33.2f, 29.7f)});
    // Of texels as wide as 1.25 others.
    addRectangle(scene, {vec3(2.3f, 0, 2.5f), vec3(3.7f, 0, 0), vec3(0, 0, -2.5f)}, material, pageSize,
                 {vec2(34.9f, 40.3f), vec2(64.5f, 60.3f)});
}

} // namespace halflight::test
