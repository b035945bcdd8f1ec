// What other programs of Windows do to halflight.exe, for wine_test.py:
//
//   helper cancel MILLISECONDS COMMAND LINE     starts it without a console and cancels it by its event after so long
//   helper hold MILLISECONDS FILE COMMAND LINE  keeps FILE open, and for so long after there is a FILE.tmp…
//
// The exit code is the program's; 99 when something else fails.

#include <cwchar>
#include <string>
#include <windows.h>

namespace {

constexpr int kFailed = 99;
constexpr DWORD kPatienceMs = 60'000; // until the event is there

bool start(int count, wchar_t** words, PROCESS_INFORMATION& process)
{
    std::wstring line;
    for (int i = 0; i < count; ++i) line += (i > 0 ? L" \"" : L"\"") + std::wstring(words[i]) + L"\"";
    STARTUPINFOW info{};
    info.cb = sizeof info;
    info.dwFlags = STARTF_USESTDHANDLES;
    info.hStdOutput = GetStdHandle(STD_OUTPUT_HANDLE);
    info.hStdError = GetStdHandle(STD_ERROR_HANDLE);
    return CreateProcessW(nullptr, line.data(), nullptr, nullptr, TRUE, CREATE_NO_WINDOW, nullptr, nullptr, &info,
                          &process) != 0;
}

int exitCode(const PROCESS_INFORMATION& process)
{
    WaitForSingleObject(process.hProcess, INFINITE);
    DWORD code = kFailed;
    GetExitCodeProcess(process.hProcess, &code);
    return int(code);
}

int cancel(DWORD milliseconds, int count, wchar_t** words)
{
    PROCESS_INFORMATION process{};
    if (!start(count, words, process)) return kFailed;
    const std::wstring name = L"Local\\halflight-cancel-" + std::to_wstring(process.dwProcessId);
    HANDLE event = nullptr;
    for (DWORD waited = 0; event == nullptr && waited < kPatienceMs; waited += 10) {
        event = OpenEventW(EVENT_MODIFY_STATE, FALSE, name.c_str());
        if (event == nullptr) Sleep(10);
    }
    if (event == nullptr) return kFailed;
    Sleep(milliseconds);
    SetEvent(event);
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

} // namespace

int wmain(int argc, wchar_t** argv)
{
    const std::wstring what = argc > 3 ? argv[1] : L"";
    const DWORD milliseconds = what.empty() ? 0 : DWORD(std::wcstoul(argv[2], nullptr, 10));
    if (what == L"cancel") return cancel(milliseconds, argc - 3, argv + 3);
    if (what == L"hold" && argc > 4) return hold(milliseconds, argv[3], argc - 4, argv + 4);
    return kFailed;
}
