#pragma once
// What only the operating system can tell or do, beside files (file.h).

#include "halflight/base/result.h"

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace halflight {

/// Most memory that the process has had so far; 0 where the system does not tell.
uint64_t peakMemoryBytes();

/// CPU seconds of all threads of the process so far; 0 where the system does not tell.
double processCpuSeconds();

/// True when standard error is a terminal.
bool isErrorStreamTerminal();

/// Equal for all names of a file that exists, whatever links lead to it; empty without such a file, and where the
/// system has no numbers of files.
std::string fileIdentity(const std::filesystem::path& file);

/// The file of this program, links followed; empty where the system does not tell.
std::filesystem::path programPath();

/// Goes on as another program, where the system can: streams, folder and process stay. Elsewhere it waits for the other
/// one and returns its exit code. -1: it could not be started.
int runInstead(const std::filesystem::path& program, const std::vector<std::string>& arguments);

/// Gives a file the name of another, which it replaces: all of it or nothing. Windows refuses while another program has
/// the old file open: it is tried again for a second.
Status renameOver(const std::filesystem::path& from, const std::filesystem::path& to);

/// Calls `handler` when the user or the system asks the program to end: Ctrl-C, SIGTERM, a console that is closed. The
/// second time it ends at once, without a call. On Windows a program without a console can be asked, too: by the event
/// "Local\halflight-cancel-NUMBER", with the number of the process. The handler is a signal handler.
void listenForSignals(void (*handler)());

/// Call first in main(). Standard streams that are closed are opened on /dev/null for the wrong direction, so that
/// writing to them fails and no output file takes their descriptor. Broken pipes and file size limits become errors of
/// writing instead of signals. On Windows they take UTF-8 and leave line ends as they are.
void prepareStandardStreams();

/// For signal handlers: calls `handler` in so many seconds, whatever the process does then.
void callAfter(unsigned seconds, void (*handler)(int));

/// For signal handlers: removes a file (null or empty: none), writes to standard error, ends the process at once.
[[noreturn]] void endProcess(const char* fileToRemove, const char* message, int exitCode);

} // namespace halflight
