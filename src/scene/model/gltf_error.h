#pragma once
// Errors that name a place of a glTF file.

#include "halflight/base/result.h"

#include <cstddef>
#include <string>
#include <utility>

namespace halflight {

/// A broken rule of glTF at the given glTF path.
inline Error invalid(std::string object, std::string message)
{
    return Error{ErrorCode::FileInvalid, std::move(message), std::move(object)};
}

/// "/nodes/3", "/meshes/0/primitives/1".
inline std::string pathOf(const char* array, std::size_t index)
{
    return std::string("/") + array + "/" + std::to_string(index);
}

} // namespace halflight
