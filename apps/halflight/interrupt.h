#pragma once
// Ctrl-C: a run ends within about a second, with exit code 1 and no output, or it finishes its output.

#include <atomic>
#include <filesystem>

namespace halflight::cli {

/// From now on the first signal (listenForSignals()) sets the flag that is returned, for Progress::cancel. A run that
/// has not ended a second later ends as it is, whatever it does: stages check the flag between pieces of work, and
/// libraries (image codecs, the build of Embree's tree, matrix factors) do not. A second signal kills at once.
const std::atomic<bool>& listenForInterrupts();

/// True once a signal arrived.
bool interrupted();

/// The file that replaceAtomically() is about to write: what it has written is removed when the run ends as it is.
void removeTemporaryOf(const std::filesystem::path& output);

/// Call once, right before the output takes its name. True: the run finishes, and signals no longer end it (a second
/// one kills). False: a signal came first, and the output must not be written.
bool commitOutput();

} // namespace halflight::cli
