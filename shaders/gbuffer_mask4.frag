#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_nonuniform_qualifier : require
#define HALFLIGHT_MASK_TARGETS 4
#include "gbuffer_main.glsl"
