// The sky: the dim part, which rays receive, and the bright part of a picture, which is sampled (SkyLight). After
// gather.glsl.
#ifndef HALFLIGHT_BAKE_SKY_GLSL
#define HALFLIGHT_BAKE_SKY_GLSL

#include "halflight/shading/sky_picture.h"

vec3 skyTexel(int column, int row)
{
    return push.tables.picture.at[row * push.tables.all.pictureSize.x + column];
}
vec3 dimTexel(int column, int row)
{
    vec3 texel = skyTexel(column, row);
    return texel * skyDimShare(texel, push.tables.all.limit);
}
vec3 brightTexel(int column, int row)
{
    vec3 texel = skyTexel(column, row);
    return texel * (1.0 - skyDimShare(texel, push.tables.all.limit));
}

vec3 dimSkyAt(SkyPlace at)
{
    return mix(mix(dimTexel(at.low.x, at.low.y), dimTexel(at.high.x, at.low.y), at.between.x),
               mix(dimTexel(at.low.x, at.high.y), dimTexel(at.high.x, at.high.y), at.between.x), at.between.y);
}
vec3 brightSkyAt(SkyPlace at)
{
    return mix(mix(brightTexel(at.low.x, at.low.y), brightTexel(at.high.x, at.low.y), at.between.x),
               mix(brightTexel(at.low.x, at.high.y), brightTexel(at.high.x, at.high.y), at.between.x), at.between.y);
}

vec3 dimSky(vec3 direction)
{
    GpuGatherConstants all = push.tables.all;
    if ((all.sky & kSky) == 0u) return vec3(0.0);
    if ((all.sky & kSkyPicture) == 0u) return skyRadiance(all.zenith, all.horizon, all.ground, direction);
    return dimSkyAt(skyPlaceOf(direction, all.turn, all.pictureSize));
}

#endif
