#include "halflight/bake/bake.h"

namespace halflight {

BakeQuality resolveQuality(const BakeSettings& settings)
{
    BakeQuality q{};
    switch (settings.quality) {
    case Quality::Preview:
        q = {32, 16, 1024, 128, 128};
        break;
    case Quality::Medium:
        q = {96, 32, 2048, 256, 128};
        break;
    case Quality::High:
        q = {256, 64, 4096, 512, 256};
        break;
    case Quality::Ultra:
        q = {1024, 128, 4096, 1024, 256};
        break;
    }
    q.noiseTarget = settings.noiseTarget;
    if (q.noiseTarget > 0.0f) q.samples = 4096;
    if (settings.samples > 0) q.samples = settings.samples;
    if (settings.shadowSamples > 0) q.shadowSamples = settings.shadowSamples;
    q.bounces = settings.bounces;
    q.directional = settings.directional.value_or(settings.quality != Quality::Preview);
    if (settings.lightmapSize > 0) q.lightmapSize = settings.lightmapSize;
    return q;
}

} // namespace halflight
