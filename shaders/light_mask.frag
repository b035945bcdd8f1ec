#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require
#extension GL_EXT_nonuniform_qualifier : require
#define HALFLIGHT_MASK_TARGETS 1
#include "light_main.glsl"
