#pragma once
#include <string_view>

namespace halflight {

/// `*` stands for any text, `?` for one character.
bool matchesPattern(std::string_view pattern, std::string_view text);

} // namespace halflight
