#pragma once
// Pieces of sentences for people.

#include <algorithm>
#include <cstddef>
#include <string>
#include <vector>

namespace halflight {

/// "A", "B" and 7 more: the first four names.
inline std::string listOf(const std::vector<std::string>& names)
{
    constexpr std::size_t kShown = 4;
    std::string text;
    for (std::size_t i = 0; i < std::min(names.size(), kShown); ++i) text += (i > 0 ? ", \"" : "\"") + names[i] + '"';
    if (names.size() > kShown) text += " and " + std::to_string(names.size() - kShown) + " more";
    return text;
}

} // namespace halflight
