#version 460
// Panels: text and shapes, blended with premultiplied alpha.
layout(location = 0) in vec2 inUv;
layout(location = 1) in vec4 inColor;

layout(set = 0, binding = 0) uniform sampler2D font;

layout(location = 0) out vec4 outColor;

void main()
{
    vec4 color = inColor * texture(font, inUv);
    outColor = vec4(color.rgb * color.a, color.a);
}
