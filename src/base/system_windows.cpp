#include "halflight/base/system.h"

#include <atomic>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fcntl.h>
#include <io.h>
#include <process.h>
#include <thread>

#ifndef NOMINMAX
#define NOMINMAX
#endif
#include <windows.h>

#include <psapi.h>

namespace halflight {

namespace {

/// How long a file that another program has open is asked for again.
constexpr auto kPatience = std::chrono::seconds(1);
/// Between two attempts.
constexpr auto kPause = std::chrono::milliseconds(50);
/// The most files that the C library has open.
constexpr int kMostFiles = 2048;

UINT outputCodePage = 0; // of the console, before this program
void (*signalHandler)() = nullptr;
std::atomic<bool> signalCame{false};

/// Called in a thread of its own.
BOOL WINAPI onConsoleEvent(DWORD event)
{
    if (signalCame.exchange(true)) return FALSE; // what Windows does: the end
    signalHandler();
    // Windows ends the program as soon as this returns when the console is closed or the user leaves.
    if (event != CTRL_C_EVENT && event != CTRL_BREAK_EVENT) Sleep(INFINITE);
    return TRUE;
}

bool isOpenElsewhere(const std::filesystem::path& file)
{
    HANDLE handle = CreateFileW(file.c_str(), DELETE, FILE_SHARE_READ | FILE_SHARE_WRITE | FILE_SHARE_DELETE, nullptr,
                                OPEN_EXISTING, FILE_ATTRIBUTE_NORMAL, nullptr);
    if (handle == INVALID_HANDLE_VALUE) return GetLastError() == ERROR_SHARING_VIOLATION;
    CloseHandle(handle);
    return false;
}

} // namespace

uint64_t peakMemoryBytes()
{
    PROCESS_MEMORY_COUNTERS counters{};
    return GetProcessMemoryInfo(GetCurrentProcess(), &counters, sizeof counters) ? counters.PeakWorkingSetSize : 0;
}

double processCpuSeconds()
{
    FILETIME created{}, ended{}, kernel{}, user{};
    if (!GetProcessTimes(GetCurrentProcess(), &created, &ended, &kernel, &user)) return 0.0;
    const auto seconds = [](FILETIME t) { // of 100 ns
        return 1.0e-7 * double((uint64_t(t.dwHighDateTime) << 32) | t.dwLowDateTime);
    };
    return seconds(kernel) + seconds(user);
}

bool isErrorStreamTerminal()
{
    DWORD mode = 0;
    return GetConsoleMode(GetStdHandle(STD_ERROR_HANDLE), &mode) != 0;
}

std::string fileIdentity(const std::filesystem::path& file)
{
    // Folders open with this flag alone.
    HANDLE handle = CreateFileW(file.c_str(), 0, FILE_SHARE_READ | FILE_SHARE_WRITE | FILE_SHARE_DELETE, nullptr,
                                OPEN_EXISTING, FILE_FLAG_BACKUP_SEMANTICS, nullptr);
    if (handle == INVALID_HANDLE_VALUE) return {};
    BY_HANDLE_FILE_INFORMATION found{};
    const bool known = GetFileInformationByHandle(handle, &found) != 0;
    CloseHandle(handle);
    if (!known) return {};
    const uint64_t index = (uint64_t(found.nFileIndexHigh) << 32) | found.nFileIndexLow;
    return std::to_string(found.dwVolumeSerialNumber) + ":" + std::to_string(index);
}

std::filesystem::path programPath()
{
    std::wstring path(32768, L'\0'); // the longest that there is
    path.resize(GetModuleFileNameW(nullptr, path.data(), DWORD(path.size())));
    return path;
}

int runInstead(const std::filesystem::path& program, const std::vector<std::string>& arguments)
{
    std::vector<std::string> quoted = {'"' + program.string() + '"'};
    for (const std::string& argument : arguments) quoted.push_back('"' + argument + '"');
    std::vector<const char*> words;
    for (const std::string& word : quoted) words.push_back(word.c_str());
    words.push_back(nullptr);
    return int(_spawnv(_P_WAIT, program.string().c_str(), words.data()));
}

Status renameOver(const std::filesystem::path& from, const std::filesystem::path& to)
{
    std::error_code ec;
    const auto end = std::chrono::steady_clock::now() + kPatience;
    while (true) {
        std::filesystem::rename(from, to, ec);
        if (!ec) return {};
        const bool isOpen = isOpenElsewhere(to);
        // Permission is denied for a moment where several processes replace one file, as workers of a farm do.
        const bool waits = isOpen || ec == std::errc::permission_denied;
        if (waits && std::chrono::steady_clock::now() < end) {
            std::this_thread::sleep_for(kPause);
            continue;
        }
        const std::string reason = isOpen ? "another program has it open" : ec.message();
        return Error{ErrorCode::WriteFailed, "cannot be replaced (" + reason + ")"};
    }
}

void listenForSignals(void (*handler)())
{
    signalHandler = handler;
    static const bool listens = [] {
        SetConsoleCtrlHandler(onConsoleEvent, TRUE);
        const std::wstring name = L"Local\\halflight-cancel-" + std::to_wstring(GetCurrentProcessId());
        HANDLE event = CreateEventW(nullptr, TRUE, FALSE, name.c_str());
        if (event == nullptr) return false;
        std::thread([event] {
            WaitForSingleObject(event, INFINITE);
            if (!signalCame.exchange(true)) signalHandler();
        }).detach();
        return true;
    }();
    (void)listens;
}

void prepareStandardStreams()
{
    _setmode(_fileno(stdout), _O_BINARY);
    _setmode(_fileno(stderr), _O_BINARY);
    outputCodePage = GetConsoleOutputCP();
    if (outputCodePage == 0) return; // no console
    SetConsoleOutputCP(CP_UTF8);
    std::atexit([] { SetConsoleOutputCP(outputCodePage); });
    HANDLE errors = GetStdHandle(STD_ERROR_HANDLE);
    DWORD mode = 0;
    // The progress bar erases lines by an escape sequence.
    if (GetConsoleMode(errors, &mode)) SetConsoleMode(errors, mode | ENABLE_VIRTUAL_TERMINAL_PROCESSING);
}

void callAfter(unsigned seconds, void (*handler)(int))
{
    // Handlers of Ctrl-C run in a thread of their own, in which anything may be called.
    std::thread([=] {
        std::this_thread::sleep_for(std::chrono::seconds(seconds));
        handler(0);
    }).detach();
}

void endProcess(const char* fileToRemove, const char* message, int exitCode)
{
    if (fileToRemove != nullptr && fileToRemove[0] != '\0' && !DeleteFileA(fileToRemove)) {
        // An open file cannot be removed.
        _set_invalid_parameter_handler([](const wchar_t*, const wchar_t*, const wchar_t*, unsigned, uintptr_t) {});
        for (int file = 3; file < kMostFiles; ++file) _close(file);
        DeleteFileA(fileToRemove);
    }
    _write(2, message, unsigned(std::strlen(message)));
    std::_Exit(exitCode);
}

} // namespace halflight
