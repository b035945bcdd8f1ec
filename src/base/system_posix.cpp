#include "halflight/base/system.h"

#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <fcntl.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#ifdef __EMSCRIPTEN__
#include <emscripten/em_js.h>
#include <emscripten/heap.h>

// Node tells the CPU time of its process, browsers of nothing.
EM_JS(double, cpuSecondsOfNode, (), {
    if (typeof process == "undefined" || !process.cpuUsage) return 0;
    const usage = process.cpuUsage();
    return 1e-6 * (usage.user + usage.system);
})
#endif

#ifdef __APPLE__
extern "C" int _NSGetExecutablePath(char* name, uint32_t* size); // of mach-o/dyld.h
#endif

namespace halflight {

namespace {

void openIfClosed(int descriptor, int flags)
{
    if (::fcntl(descriptor, F_GETFD) != -1 || errno != EBADF) return;
    const int opened = ::open("/dev/null", flags);
    if (opened >= 0 && opened != descriptor) {
        ::dup2(opened, descriptor);
        ::close(opened);
    }
}

void (*signalHandler)() = nullptr;

void onSignal(int signal)
{
    signalHandler();
    std::signal(signal, SIG_DFL);
}

} // namespace

#ifdef __EMSCRIPTEN__

uint64_t peakMemoryBytes()
{
    return emscripten_get_heap_size(); // never shrinks
}

double processCpuSeconds()
{
    return cpuSecondsOfNode();
}

#else

uint64_t peakMemoryBytes()
{
    rusage usage{};
    if (::getrusage(RUSAGE_SELF, &usage) != 0) return 0;
#ifdef __APPLE__
    return uint64_t(usage.ru_maxrss); // bytes there, kilobytes elsewhere
#else
    return uint64_t(usage.ru_maxrss) * 1024u;
#endif
}

double processCpuSeconds()
{
    timespec time{};
    if (::clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time) != 0) return 0.0;
    return double(time.tv_sec) + 1.0e-9 * double(time.tv_nsec);
}

#endif

bool isErrorStreamTerminal()
{
    return ::isatty(STDERR_FILENO) != 0;
}

std::string fileIdentity(const std::filesystem::path& file)
{
    struct stat found = {};
    if (::stat(file.c_str(), &found) != 0) return {};
    return std::to_string(found.st_dev) + ":" + std::to_string(found.st_ino);
}

std::filesystem::path programPath()
{
#ifdef __APPLE__ // written without a build
    uint32_t size = 0;
    _NSGetExecutablePath(nullptr, &size);
    std::string name(size, '\0');
    if (_NSGetExecutablePath(name.data(), &size) != 0) return {};
    const char* link = name.c_str();
#else
    const char* link = "/proc/self/exe";
#endif
    std::error_code error;
    return std::filesystem::canonical(link, error);
}

int runInstead(const std::filesystem::path& program, const std::vector<std::string>& arguments)
{
    std::vector<std::string> words = {program.string()};
    words.insert(words.end(), arguments.begin(), arguments.end());
    std::vector<char*> pointers;
    for (std::string& word : words) pointers.push_back(word.data());
    pointers.push_back(nullptr);
    return ::execv(program.c_str(), pointers.data());
}

void prepareStandardStreams()
{
    openIfClosed(STDIN_FILENO, O_WRONLY);
    openIfClosed(STDOUT_FILENO, O_RDONLY);
    openIfClosed(STDERR_FILENO, O_RDONLY);
    std::signal(SIGPIPE, SIG_IGN);
    std::signal(SIGXFSZ, SIG_IGN);
}

Status renameOver(const std::filesystem::path& from, const std::filesystem::path& to)
{
    std::error_code ec;
    std::filesystem::rename(from, to, ec);
    return ec ? Error{ErrorCode::WriteFailed, "cannot be replaced (" + ec.message() + ")"} : Status();
}

void listenForSignals(void (*handler)())
{
    signalHandler = handler;
    std::signal(SIGINT, onSignal);
    std::signal(SIGTERM, onSignal);
}

// Here and below only functions that POSIX calls async-signal-safe.
void callAfter(unsigned seconds, void (*handler)(int))
{
    struct sigaction action = {};
    action.sa_handler = handler;
    ::sigaction(SIGALRM, &action, nullptr);
    ::alarm(seconds);
}

void endProcess(const char* fileToRemove, const char* message, int exitCode)
{
    if (fileToRemove != nullptr && fileToRemove[0] != '\0') ::unlink(fileToRemove);
    [[maybe_unused]] const auto written = ::write(STDERR_FILENO, message, std::strlen(message));
    ::_exit(exitCode);
}

} // namespace halflight
