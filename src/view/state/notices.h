#pragma once
// What the window tells the user: lines on standard output, a note at its bottom, and the panel's warnings.

#include <array>
#include <chrono>
#include <functional>
#include <string>
#include <utility>
#include <vector>

namespace halflight::view {

/// Keeps the last note and, for each subject, the warnings that hold now.
class Notices {
public:
    /// `say` prints a line; empty: nothing is printed.
    explicit Notices(std::function<void(const std::string& line)> say) : say_(std::move(say)) {}

    void say(const std::string& line) const;
    /// Shows a line at the bottom of the window for some seconds.
    void note(const std::string& line);
    void tell(const std::string& line); ///< both
    /// The last note, for some seconds; then nothing.
    [[nodiscard]] std::string currentNote() const;

    enum class About { File, Bake, Frame };
    /// In place of those about it before.
    void setWarnings(About about, std::vector<std::string> warnings);
    void addWarning(About about, const std::string& warning);
    /// All, in the order of their subjects.
    [[nodiscard]] std::vector<std::string> warnings() const;

private:
    using Clock = std::chrono::steady_clock;

    std::function<void(const std::string& line)> say_;
    std::string note_;
    Clock::time_point noteTime_;
    std::array<std::vector<std::string>, 3> warnings_; ///< by About
};

/// A line at the bottom of the window, in this frame of the panels.
void drawAtBottom(const std::string& text);

} // namespace halflight::view
