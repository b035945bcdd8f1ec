// Sums over a block in two halves, in the order of the strata: the same bits whatever else is gathered. BlockSums.
#ifndef HALFLIGHT_BAKE_BLOCK_SUMS_GLSL
#define HALFLIGHT_BAKE_BLOCK_SUMS_GLSL

GpuHalf halves[2];

void beginSums()
{
    for (uint h = 0u; h < 2u; ++h) {
        halves[h].irradiance = vec3(0.0);
        halves[h].moment = vec3(0.0);
    }
}

void addToSums(int stratum, vec3 irradiance, vec3 direction)
{
    uint h = patternHalf(uint(stratum));
    halves[h].irradiance += irradiance;
    halves[h].moment += luminanceOf(irradiance) * direction;
}

// What surfaces let through of a source ray's light.
vec3 passedOf(uint ray)
{
    if (push.tables.scene.tinted != 0u) return Vectors(uvec2(push.lists.passed)).at[ray];
    return vec3(push.lists.passed.at[ray]);
}

// What the source rays of a block bring.
void addSources(uint block)
{
    for (int s = 0; s < kPatternBlock; ++s) {
        uint i = rayOf(block, s);
        GpuRay ray = push.lists.sourceRays.at[i];
        if (ray.tMax < ray.tMin) continue;
        addToSums(s, push.lists.sources.at[i] * passedOf(i), ray.direction);
    }
}

#endif
