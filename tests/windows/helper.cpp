// What other programs of Windows do to halflight.exe, for wine_test.py:
//
//   helper cancel MILLISECONDS COMMAND LINE     starts it without a console and cancels it by its event after so long
//   helper console MILLISECONDS EVENT COMMAND LINE  tells it of its console after so long: 1 Ctrl-Break, 2 closed
//   helper hold MILLISECONDS FILE COMMAND LINE  keeps FILE open, and for so long after there is a FILE.tmp…
//   helper replace MILLISECONDS NEW COMMAND LINE  puts NEW in the program's place, so long after its end
//
// The exit code is the program's; 99 when something else fails.

#include <cstdint>
#include <cwchar>
#include <string>
#include <windows.h>

namespace {

constexpr int kFailed = 99;
constexpr DWORD kPatienceMs = 60'000; // until the event is there

bool start(int count, wchar_t** words, PROCESS_INFORMATION& process, DWORD flags = CREATE_NO_WINDOW)
{
    std::wstring line;
    for (int i = 0; i < count; ++i) line += (i > 0 ? L" \"" : L"\"") + std::wstring(words[i]) + L"\"";
    STARTUPINFOW info{};
    info.cb = sizeof info;
    info.dwFlags = STARTF_USESTDHANDLES;
    info.hStdOutput = GetStdHandle(STD_OUTPUT_HANDLE);
    info.hStdError = GetStdHandle(STD_ERROR_HANDLE);
    return CreateProcessW(nullptr, line.data(), nullptr, nullptr, TRUE, flags, nullptr, nullptr, &info, &process) != 0;
}

int exitCode(const PROCESS_INFORMATION& process)
{
    WaitForSingleObject(process.hProcess, INFINITE);
    DWORD code = kFailed;
    GetExitCodeProcess(process.hProcess, &code);
    return int(code);
}

/// The event by which it is cancelled, once it is there; null where it never comes.
HANDLE eventOf(const PROCESS_INFORMATION& process)
{
    const std::wstring name = L"Local\\halflight-cancel-" + std::to_wstring(process.dwProcessId);
    for (DWORD waited = 0; waited < kPatienceMs; waited += 10) {
        HANDLE event = OpenEventW(EVENT_MODIFY_STATE, FALSE, name.c_str());
        if (event != nullptr) return event;
        Sleep(10);
    }
    return nullptr;
}

int cancel(DWORD milliseconds, int count, wchar_t** words)
{
    PROCESS_INFORMATION process{};
    if (!start(count, words, process)) return kFailed;
    HANDLE event = eventOf(process);
    if (event == nullptr) return kFailed;
    Sleep(milliseconds);
    SetEvent(event);
    return exitCode(process);
}

/// Windows tells a process of its console by a thread in it that runs this function.
int console(DWORD milliseconds, DWORD event, int count, wchar_t** words)
{
    const auto routine = LPTHREAD_START_ROUTINE(
        reinterpret_cast<void*>(GetProcAddress(GetModuleHandleW(L"kernelbase.dll"), "CtrlRoutine")));
    PROCESS_INFORMATION process{};
    if (routine == nullptr || !start(count, words, process) || eventOf(process) == nullptr) return kFailed;
    Sleep(milliseconds);
    void* number = reinterpret_cast<void*>(std::uintptr_t(event));
    if (CreateRemoteThread(process.hProcess, nullptr, 0, routine, number, 0, nullptr) == nullptr) return kFailed;
    return exitCode(process);
}

int hold(DWORD milliseconds, const wchar_t* file, int count, wchar_t** words)
{
    HANDLE handle =
        CreateFileW(file, GENERIC_READ, FILE_SHARE_READ, nullptr, OPEN_EXISTING, FILE_ATTRIBUTE_NORMAL, nullptr);
    PROCESS_INFORMATION process{};
    if (handle == INVALID_HANDLE_VALUE || !start(count, words, process)) return kFailed;
    const std::wstring temporary = std::wstring(file) + L".tmp*";
    WIN32_FIND_DATAW found{};
    HANDLE search = INVALID_HANDLE_VALUE;
    while (search == INVALID_HANDLE_VALUE && WaitForSingleObject(process.hProcess, 10) == WAIT_TIMEOUT)
        search = FindFirstFileW(temporary.c_str(), &found);
    if (search != INVALID_HANDLE_VALUE) FindClose(search);
    WaitForSingleObject(process.hProcess, milliseconds);
    CloseHandle(handle);
    return exitCode(process);
}

int replace(DWORD milliseconds, const wchar_t* update, int count, wchar_t** words)
{
    PROCESS_INFORMATION process{};
    if (!start(count, words, process)) return kFailed;
    const int code = exitCode(process);
    CloseHandle(process.hProcess);
    CloseHandle(process.hThread);
    Sleep(milliseconds);
    return MoveFileExW(update, words[0], MOVEFILE_REPLACE_EXISTING) != 0 ? code : kFailed;
}

} // namespace

int wmain(int argc, wchar_t** argv)
{
    const std::wstring what = argc > 3 ? argv[1] : L"";
    const DWORD milliseconds = what.empty() ? 0 : DWORD(std::wcstoul(argv[2], nullptr, 10));
    if (what == L"cancel") return cancel(milliseconds, argc - 3, argv + 3);
    if (what == L"console" && argc > 4)
        return console(milliseconds, DWORD(std::wcstoul(argv[3], nullptr, 10)), argc - 4, argv + 4);
    if (what == L"hold" && argc > 4) return hold(milliseconds, argv[3], argc - 4, argv + 4);
    if (what == L"replace" && argc > 4) return replace(milliseconds, argv[3], argc - 4, argv + 4);
    return kFailed;
}
