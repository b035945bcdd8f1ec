// Filtering shadow maps beside creases, where a caster's surface meets the receiver's. Behind a thin wall the filter
// would find lit floor on the wall's other side, and in a lit corner the wall before the floor's plane. So the filter
// does not cross a crease: texels on its other side do not count.
#ifndef HALFLIGHT_SHADOW_CREASES_GLSL
#define HALFLIGHT_SHADOW_CREASES_GLSL

float storedDepth(Receiver r, ivec2 texel)
{
    texel = clamp(texel, ivec2(r.bounds.xy), ivec2(r.bounds.zw));
    return r.cascade ? texelFetch(cascadeDepths, ivec3(texel, int(tiles[r.tile].rectangle.w)), 0).r
                     : texelFetch(atlasDepths, ivec3(texel, 0), 0).r;
}

// Depth per texel along one axis of the surface that a texel shows: from the side whose three texels lie on a line, or
// nearly so (Harten, Engquist, Osher and Chakravarthy 1987, "Uniformly High Order Accurate Essentially Non-oscillatory
// Schemes"). False where neither does.
bool slopeAlong(Receiver r, ivec2 texel, ivec2 axis, float own, out float slope)
{
    const float kBent = 0.1;         // of the slope
    const float kRounding = 5.0e-7;  // of three depths near 1
    float ahead = storedDepth(r, texel + axis) - own;
    float behind = own - storedDepth(r, texel - axis);
    float bentAhead = abs(storedDepth(r, texel + 2 * axis) - own - 2.0 * ahead);
    float bentBehind = abs(own - storedDepth(r, texel - 2 * axis) - 2.0 * behind);
    slope = bentAhead < bentBehind ? ahead : behind;
    return min(bentAhead, bentBehind) <= kBent * abs(slope) + kRounding;
}

// How far the plane of a caster lies before that of the receiver, in depth, as a function of the place in texels from
// the receiver: before + dot(change, place). It is 0 on the crease.
struct Crease {
    float before;
    vec2 change;
    float bias; // of the caster's depths in the map
    float away; // texels from the receiver; kNoCrease where there is none
};
const float kNoCrease = 1.0e9;

float beforeAt(Crease crease, vec2 place) { return crease.before + dot(crease.change, place); }

// The receiver without bias: place on the map, depth, and its plane's depth per texel. False behind the light.
bool placeOf(Receiver r, out vec2 place, out float depth, out vec2 slope)
{
    vec4 clip = tiles[r.tile].clipFromWorld * vec4(r.position, 1.0);
    vec4 plane = tiles[r.tile].planeFromWorld * vec4(r.normal, -dot(r.normal, r.position));
    if (clip.w <= 0.0 || abs(plane.z) <= 1.0e-20) return false;
    vec4 rectangle = tiles[r.tile].rectangle;
    place = rectangle.xy + (clip.xy / clip.w * 0.5 + 0.5) * rectangle.z;
    depth = clip.z / clip.w;
    slope = -plane.xy / plane.z * (2.0 / rectangle.z);
    return true;
}

float biasOf(Receiver r, vec2 slope) { return r.slopeBias * max(abs(slope.x), abs(slope.y)); }

// The tent filter less the texels that a crease parts from the receiver: of the two nearest creases among those of
// casters in the filter's reach. `filtered`: what the filter found.
float tentWithinCreases(Receiver r, int h, float filtered)
{
    const float kSamePlane = 0.1; // of slopes: depths that rounding and a plane's continuation leave apart
    const float kRounding = 1.0e-6;
    vec2 place;
    float depth;
    vec2 slope;
    if (!placeOf(r, place, depth, slope)) return filtered;
    ivec2 base = ivec2(floor(r.texel - 0.5)) + 1 - h;
    int side = 2 * h;
    float ownBias = biasOf(r, slope);
    Crease first = Crease(0.0, vec2(0.0), 0.0, kNoCrease);
    Crease second = first;
    int step = max(h / 2, 1); // wide filters look at every other texel
    [[dont_unroll]] for (int i = 0; i < side * side; i += step) {
        ivec2 texel = base + ivec2(i % side, i / side);
        vec2 offset = vec2(texel) + 0.5 - place;
        float onPlane = depth + dot(slope, offset);
        float stored = storedDepth(r, texel);
        if (abs(stored - onPlane - ownBias) <= kSamePlane * length(slope) + kRounding) continue;
        vec2 ofCaster;
        if (!slopeAlong(r, texel, ivec2(1, 0), stored, ofCaster.x)) continue;
        if (!slopeAlong(r, texel, ivec2(0, 1), stored, ofCaster.y)) continue;
        Crease crease;
        crease.bias = biasOf(r, ofCaster);
        crease.change = slope - ofCaster;
        crease.before = depth - (stored - crease.bias - dot(ofCaster, offset));
        crease.away = abs(crease.before) / max(length(crease.change), 1.0e-20);
        if (stored - crease.bias >= onPlane || crease.away > float(side)) continue;
        bool isFirsts = first.away < kNoCrease && length(crease.change - first.change) <
                                                      0.2 * max(length(first.change), length(crease.change));
        if (crease.away < first.away) {
            if (!isFirsts) second = first;
            first = crease;
        } else if (!isFirsts && crease.away < second.away) {
            second = crease;
        }
    }
    if (first.away == kNoCrease) return filtered;

    float lit = 0.0;
    float weight = 0.0;
    [[dont_unroll]] for (int i = 0; i < side * side; ++i) {
        ivec2 texel = base + ivec2(i % side, i / side);
        vec2 centre = vec2(texel) + 0.5;
        vec2 offset = centre - place;
        float stored = storedDepth(r, texel);
        bool isLit = stored >= r.depth + dot(r.slope, centre - r.texel);
        bool isOwn = abs(stored - depth - dot(slope, offset) - ownBias) <= kSamePlane * length(slope) + kRounding;
        bool isParted = false;
        for (int k = 0; k < 2; ++k) {
            Crease crease = k == 0 ? first : second;
            if (crease.away == kNoCrease) continue;
            float before = beforeAt(crease, offset);
            isParted = isParted || (crease.before > 0.0) != (before > 0.0);
            // A texel of the caster, without its bias.
            float expected = depth + dot(slope, offset) - before + crease.bias;
            if (abs(stored - expected) <= kSamePlane * length(slope - crease.change) + kRounding) isLit = before <= 0.0;
            // Beside the crease, the caster's larger bias put it behind the receiver's surface, which the texel shows.
            if (isOwn && before > 0.0 && before <= crease.bias - ownBias) isLit = false;
        }
        if (isParted) continue;
        vec2 tent = max(vec2(0.0), 1.0 - abs(centre - r.texel) / float(h));
        weight += tent.x * tent.y;
        lit += isLit ? tent.x * tent.y : 0.0;
    }
    return weight > 0.0 ? lit / weight : filtered;
}

#endif
