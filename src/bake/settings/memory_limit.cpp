#include "bake/settings/memory_limit.h"

#include <cmath>
#include <iomanip>
#include <sstream>
#include <string>

namespace halflight {
namespace {

// Measured in WebAssembly: scripts/build-wasm.sh, then bakes of the courtyard and of the tests' scenes with --report.
constexpr uint64_t kBytesAtAll = 80'000'000;
constexpr uint64_t kBytesPerTexel = 400;
constexpr uint64_t kBytesPerTriangle = 600;

double gigabytes(uint64_t bytes)
{
    return double(bytes) / double(uint64_t(1) << 30);
}

} // namespace

uint64_t trianglesOf(const Scene& scene)
{
    uint64_t count = 0;
    for (const Object& object : scene.objects)
        if (object.mesh >= 0) count += scene.meshes[std::size_t(object.mesh)].triangleCount();
    return count;
}

uint64_t expectedMemory(const BakeSize& size)
{
    return kBytesAtAll + kBytesPerTexel * size.texels + kBytesPerTriangle * size.triangles;
}

Status checkMemory(const BakeSize& size, uint64_t mostBytes)
{
    const uint64_t bytes = expectedMemory(size);
    if (bytes <= mostBytes) return {};
    std::ostringstream text;
    text << std::fixed << std::setprecision(1) << "takes about " << gigabytes(bytes) << " GB of memory for "
         << size.texels << " texels and " << size.triangles << " triangles, and WebAssembly has "
         << gigabytes(mostBytes) << " GB: ";
    const uint64_t others = expectedMemory({0, size.triangles, 0.0});
    if (others < mostBytes && size.texelsPerMeter > 0.0) {
        // Texels go with the square of their density. A tenth is left for charts that grow.
        const double share = 0.9 * double(mostBytes - others) / double(kBytesPerTexel * size.texels);
        text << "--texels-per-meter " << std::defaultfloat << std::setprecision(2)
             << size.texelsPerMeter * std::sqrt(share) << " fits; ";
    } else {
        text << "parts of the scene fit; ";
    }
    text << "Halflight's package for this system has no such limit";
    return Error{ErrorCode::Unsupported, text.str()};
}

} // namespace halflight
