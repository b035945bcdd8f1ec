#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_nonuniform_qualifier : require
// S35. What glass volumes leave of the picture behind them: multiplied into it.
#include "bindings.glsl"
#include "halflight/shading/coverage.h"

layout(set = 0, binding = kBindOpticalDepths) uniform sampler2D opticalDepths;

layout(location = 0) out vec4 outShare;

void main()
{
    vec3 depth = max(texelFetch(opticalDepths, ivec2(gl_FragCoord.xy), 0).rgb, vec3(0.0));
    outShare = vec4(volumeLeaves(depth, 1.0), 1.0);
}
