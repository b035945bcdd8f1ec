#version 460
#extension GL_GOOGLE_include_directive : require
#include "trace.glsl"

layout(location = 0) rayPayloadInEXT NearestPayload payload;
hitAttributeEXT vec2 barycentric;

void main()
{
    GpuSlot slot = push.scene.slots.at[gl_InstanceCustomIndexEXT + gl_GeometryIndexEXT];
    payload.face = slot.firstHit + uint(gl_PrimitiveID);
    if (gl_HitKindEXT == gl_HitKindBackFacingTriangleEXT) {
        payload.face |= kBackBit;
        uint face = byteAt(push.scene.faces, slot.firstFace + uint(gl_PrimitiveID));
        if ((face & kFaceHiddenBack) != 0u) payload.face |= kHiddenBit;
    }
    payload.barycentric = slot.mirrored != 0u ? barycentric.yx : barycentric;
    payload.distance = gl_HitTEXT;
}
