#pragma once
// Embree's devices by instruction set, and the identity of what they compute.

#include "bake_cpu/trace/embree.h"

#include "halflight/bake/integrator.h"

#include <string>

namespace halflight::embree {

/// Null where the processor lacks the instructions, or there is no memory. The caller releases it.
RTCDevice openDevice(InstructionSet set);

/// IntegratorFactory::identity: "cpu-embree-3.13.5-avx2-" and eight digits, of which the hash of a fixed set of rays
/// and functions begins. Takes a few milliseconds.
Result<std::string> identityOf(InstructionSet set);

} // namespace halflight::embree
