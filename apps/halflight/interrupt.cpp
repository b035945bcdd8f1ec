#include "interrupt.h"

#include "halflight/base/file.h"
#include "halflight/base/system.h"

#include <array>
#include <cstring>
#include <string>

namespace halflight::cli {

namespace {

// The globals of the program: a signal handler can reach nothing else.
enum State : int { kRunning, kCancelled, kCommitted };
std::atomic<int> state{kRunning};
std::atomic<bool> cancelRequested{false};
std::array<char, 4096> temporaryFile{}; // written before listening starts to matter, empty = none
static_assert(std::atomic<int>::is_always_lock_free && std::atomic<bool>::is_always_lock_free,
              "a signal handler writes them");

constexpr unsigned kGraceSeconds = 1;

void endNow(int)
{
    if (state.load() == kCancelled) endProcess(temporaryFile.data(), "\nhalflight: interrupted\n", 1);
}

void requestCancel()
{
    int expected = kRunning;
    if (state.compare_exchange_strong(expected, kCancelled)) {
        cancelRequested.store(true);
        callAfter(kGraceSeconds, endNow);
    }
}

} // namespace

#ifdef __EMSCRIPTEN__
// No signal reaches WebAssembly, and the thread that runs main() answers no call meanwhile. Whoever runs the module
// (web/cli, web/bake) writes to its memory instead: where `state` is kRunning, kCancelled, then true. `temporaryFile`
// is for those who end the program.
extern "C" {
void* halflightState()
{
    return &state;
}
void* halflightCancelRequested()
{
    return &cancelRequested;
}
const char* halflightTemporaryFile()
{
    return temporaryFile.data();
}
}
#endif

const std::atomic<bool>& listenForInterrupts()
{
    listenForSignals(requestCancel);
    return cancelRequested;
}

bool interrupted()
{
    return cancelRequested.load();
}

void removeTemporaryOf(const std::filesystem::path& output)
{
    const Result<std::filesystem::path> file = replacedFile(output);
    if (!file) return; // writing it will say why
    const std::string name = temporaryOf(*file).string();
    if (name.size() < temporaryFile.size()) std::memcpy(temporaryFile.data(), name.c_str(), name.size() + 1);
}

bool commitOutput()
{
    int expected = kRunning;
    return state.compare_exchange_strong(expected, kCommitted) || expected == kCommitted;
}

} // namespace halflight::cli
