// Sums over a block of the light of one component, an invocation each: ComponentSums.
#ifndef HALFLIGHT_BAKE_COMPONENT_SUMS_GLSL
#define HALFLIGHT_BAKE_COMPONENT_SUMS_GLSL

#include "../paths/tables.glsl"
#include "../block_sums.glsl"
#include "../sky.glsl"
#include "light.glsl"

// Number of a block's sums of a component; false beyond the list of blocks.
bool sumsOf(out uint place, out uint block, out uint component)
{
    place = invocation();
    block = place / push.tables.all.components;
    component = place % push.tables.all.components;
    return block < push.lists.blockCount;
}

#endif
