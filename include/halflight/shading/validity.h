// Which sample points are outside geometry: how many rays test them, and when the tests end.
#ifndef HALFLIGHT_SHADING_VALIDITY_H
#define HALFLIGHT_SHADING_VALIDITY_H

#include "language.h"

HL_NAMESPACE_BEGIN

// Seed of the tests' rays: not the bake's, as validity is a property of the scene.
HL_CONST uint kInsideSeed = 0x5eed0004u;
// Rays per group of points in solids, per point behind shells, and of a texel that find whether it has to be tested.
HL_CONST int kValidityRays = 8;
HL_CONST int kFewValidityRays = 3; // enough if all of them agree
// Two rays of each point of a whole texel.
HL_CONST int kShellRays = 32;

// Whether the test of a group of mutually visible points for solids ends: `inside` of `traced` rays leave more solids
// than they enter. Inside a closed solid all rays do, so the first ray that does not ends the test.
HL_FN bool solidIsFound(int inside, int traced)
{
    return inside == 0 || (traced == kFewValidityRays && inside == kFewValidityRays);
}

// Whether the test for shells ends after round `round` with so many open points: nearly all of as many rays as
// kShellRays hit hidden backs. `allHit`: all candidates of the round did; `allOpen`: none is closed.
HL_FN bool shellIsFound(int round, bool allHit, bool allOpen, int open)
{
    return (round == 0 ? allHit : allOpen) && open * (round + 1) >= kShellRays;
}

// Index of the n-th bit that is set, from 0 on.
HL_FN int nthBit(uint mask, int n)
{
    for (; n > 0; --n) mask &= mask - 1u;
    return findLSB(mask);
}

HL_NAMESPACE_END

#endif
