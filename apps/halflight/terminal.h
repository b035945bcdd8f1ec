#pragma once
// Text to the two standard streams. Messages (standard error) are best effort: a stream that is closed, full or a
// broken pipe never ends the program. Results (standard output) are checked: one that cannot be written is a failure.

#include "halflight/base/result.h"

#include <spdlog/fmt/fmt.h>

#include <string>
#include <string_view>

namespace halflight::cli {

/// UTF-8 text that cannot steer a terminal: controls (C0, C1, DEL), bidirectional overrides, line separators and bytes
/// that are not UTF-8 become escapes such as \x1b or \u009b. Use for names, which files choose.
std::string printable(std::string_view text);

/// One piece of a message to standard error, without further change; what cannot be written is dropped.
void say(std::string_view text);

/// A piece of a result to standard output. Line breaks stay, other controls are escaped as by printable().
void printText(std::string_view text);
template<typename... Arguments> void print(fmt::format_string<Arguments...> format, Arguments&&... arguments)
{
    printText(fmt::format(format, std::forward<Arguments>(arguments)...));
}

/// JSON text to standard output; C1 controls in its strings become \u escapes, which change no value.
void printJson(std::string_view json);

/// WriteFailed when any result since the start could not be written. Call last.
Status finishResults();

} // namespace halflight::cli
