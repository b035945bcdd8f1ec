#version 460
// Panels: vertices in pixels of the window.
layout(location = 0) in vec2 inPosition;
layout(location = 1) in vec2 inUv;
layout(location = 2) in vec4 inColor;

layout(push_constant) uniform PushBlock { vec2 scale; vec2 offset; };

layout(location = 0) out vec2 outUv;
layout(location = 1) out vec4 outColor;

void main()
{
    outUv = inUv;
    outColor = inColor;
    gl_Position = vec4(inPosition * scale + offset, 0.0, 1.0);
}
