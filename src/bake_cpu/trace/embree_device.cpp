#include "bake_cpu/trace/embree_device.h"

#include "bake_cpu/trace/ray_packet.h"

#include "halflight/base/hash.h"
#include "halflight/base/mathematics.h"
#include "halflight/shading/random.h"

#include <utility>

namespace halflight::embree {
namespace {

constexpr uint32_t kTriangles = 256; ///< enough for a tree with nodes above its leaves
constexpr uint32_t kPackets = 64;

#ifdef __aarch64__
constexpr bool kHasOneSet = true; // Embree takes the names of x86's there
#else
constexpr bool kHasOneSet = false;
#endif

/// What `set` is on this processor: its first set, Sse2, on others than x86.
RTCDevice newDevice(InstructionSet& set)
{
    if (set == InstructionSet::Automatic) {
        for (const InstructionSet one : {InstructionSet::Avx2, InstructionSet::Sse2}) {
            set = one;
            if (RTCDevice device = newDevice(set)) return device;
        }
        return nullptr;
    }
    if (kHasOneSet && set != InstructionSet::Sse2) return nullptr;
    return rtcNewDevice(("isa=" + std::string(nameOf(set))).c_str());
}

const char* processorsNameOf([[maybe_unused]] InstructionSet set)
{
#if defined(__aarch64__)
    return "neon";
#elif defined(__wasm__)
    return "wasm";
#else
    return nameOf(set);
#endif
}

/// Embree's handles, released in the end.
class FixedScene {
public:
    explicit FixedScene(RTCDevice device) : device_(device), scene_(rtcNewScene(device)), packets_(takesPackets(device))
    {
        rtcSetSceneBuildQuality(scene_, RTC_BUILD_QUALITY_HIGH);
        RTCGeometry mesh = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
        auto* corners = static_cast<float*>(rtcSetNewGeometryBuffer(mesh, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                                                    3 * sizeof(float), std::size_t(3) * kTriangles));
        auto* indices = static_cast<uint32_t*>(rtcSetNewGeometryBuffer(mesh, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                                                       3 * sizeof(uint32_t), kTriangles));
        for (uint32_t i = 0; i < 3 * kTriangles; ++i) {
            // Triangles of half the cube's side, around places in it.
            for (uint32_t axis = 0; axis < 3; ++axis)
                corners[3 * i + axis] = number(i / 3, axis) + 0.5f * number(kTriangles + i, axis);
            indices[i] = i;
        }
        rtcCommitGeometry(mesh);
        rtcAttachGeometry(scene_, mesh);
        rtcReleaseGeometry(mesh);
        rtcCommitScene(scene_);
    }
    ~FixedScene()
    {
        rtcReleaseScene(scene_);
        rtcReleaseDevice(device_);
    }
    FixedScene(const FixedScene&) = delete;
    FixedScene& operator=(const FixedScene&) = delete;

    void addRays(Hasher& hasher) const
    {
        RayContext context(false);
        for (uint32_t packet = 0; packet < kPackets; ++packet) {
            std::array<Ray, kPacket> fixed;
            for (uint32_t lane = 0; lane < kPacket; ++lane) {
                const uint32_t ray = 4 * kTriangles + packet * kPacket + lane;
                fixed[lane] = {{number(ray, 0), number(ray, 1), number(ray, 2)},
                               0.0f,
                               {number(ray, 3) - 0.5f, number(ray, 4) - 0.5f, number(ray, 5) - 0.5f},
                               kInfinity};
            }
            RTCRayHit8 rays{};
            const LaneMask all = fill(rays.ray, fixed);
            for (unsigned& geomID : rays.hit.geomID) geomID = RTC_INVALID_GEOMETRY_ID;
            for (int lane = 0; lane < kPacket; ++lane) {
                RTCRayHit one = rtcGetRayHitFromRayHitN(reinterpret_cast<RTCRayHitN*>(&rays), kPacket, unsigned(lane));
                intersect(scene_, context, one);
                add(hasher, one.hit.geomID, one.hit.primID, {one.ray.tfar, one.hit.u, one.hit.v, one.hit.Ng_x});
            }
            intersect8(scene_, context, all, rays, packets_);
            for (int i = 0; i < kPacket; ++i)
                add(hasher, rays.hit.geomID[i], rays.hit.primID[i],
                    {rays.ray.tfar[i], rays.hit.u[i], rays.hit.v[i], rays.hit.Ng_x[i]});
        }
    }

private:
    static float number(uint32_t index, uint32_t axis) { return unitFloat(hashCombine(index, axis)); } ///< 0…1

    static void add(Hasher& hasher, uint32_t geometry, uint32_t triangle, const vec4& numbers)
    {
        hasher.add(geometry);
        if (geometry != RTC_INVALID_GEOMETRY_ID) hasher.add(triangle).add(numbers);
    }

    RTCDevice device_;
    RTCScene scene_;
    bool packets_;
};

/// The project's own functions, which a compiler may yet compile otherwise.
void addFunctions(Hasher& hasher)
{
    for (int i = 1; i <= 64; ++i) {
        const float x = 0.37f * float(i);
        for (const float y : {math::sin(x), math::cos(x), math::tan(x), math::acos(x / 32.0f), math::atan(x, 3.0f),
                              math::exp(x), math::exp2(x), math::log2(x), math::pow(x, 0.7f), math::cbrt(x)})
            hasher.add(y);
        hasher.add(math::pow(double(x), 0.7)).add(math::log2(double(x))).add(math::cos(double(x)));
        hasher.add(glm::normalize(vec3(x, 1.0f, -2.0f)));
    }
}

} // namespace

RTCDevice openDevice(InstructionSet set)
{
    return newDevice(set);
}

Result<std::string> identityOf(InstructionSet set)
{
    RTCDevice device = newDevice(set);
    if (device == nullptr) {
        return Error{ErrorCode::Unsupported, "this processor cannot trace rays with " + std::string(nameOf(set)) +
                                                 ": leave --isa out, or say --isa sse2, which all have"};
    }
    // The library that runs, which need not be the one of the headers: 31305 is 3.13.5.
    const auto version = unsigned(rtcGetDeviceProperty(device, RTC_DEVICE_PROPERTY_VERSION));
    std::string identity = "cpu-embree-";
    for (const unsigned unit : {10000u, 100u, 1u})
        identity += std::to_string(version / unit % 100) + (unit > 1 ? "." : "-");
    Hasher hasher;
    FixedScene(device).addRays(hasher);
    addFunctions(hasher);
    return identity + processorsNameOf(set) + "-" + hasher.hash().hex().substr(0, 8);
}

} // namespace halflight::embree
