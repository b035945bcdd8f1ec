// Number of an invocation: ComputePipeline::run() has rows of so many groups.
#ifndef HALFLIGHT_BAKE_INVOCATION_GLSL
#define HALFLIGHT_BAKE_INVOCATION_GLSL

uint invocationOf(uint groupSize)
{
    return (gl_WorkGroupID.y * 65535u + gl_WorkGroupID.x) * groupSize + gl_LocalInvocationIndex;
}

#endif
