// One libFuzzer program for each entry point: HALFLIGHT_FUZZ_ENTRY is its name (CMakeLists.txt).

#include "fuzz/entry_points.h"

#include <cstdint>

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, std::size_t size)
{
    halflight::fuzz::HALFLIGHT_FUZZ_ENTRY(std::as_bytes(std::span(data, size)));
    return 0;
}
