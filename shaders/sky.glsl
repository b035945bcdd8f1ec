// The sky by direction.
#ifndef HALFLIGHT_SKY_GLSL
#define HALFLIGHT_SKY_GLSL

#include "bindings.glsl"
#include "halflight/shading/sky.h"

// Radiance from unit direction d. `level`: mip level of the picture; a gradient has none.
vec3 skyTowards(vec3 d, float level)
{
    if (frame.skyPicture.z == 0.0)
        return skyRadiance(frame.skyZenith.rgb, frame.skyHorizon.rgb, frame.skyGround.rgb, d);
    return textureLod(skyPicture, skyPictureUv(d, frame.skyPicture.xy), level).rgb * frame.skyPictureNits.rgb;
}

#endif
