// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "mutate/child.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>

extern "C" char** environ;

namespace pliant::mutate {
namespace {

void limit(int what, std::uint64_t soft, std::uint64_t hard) {
    const rlimit both{soft, hard};
    (void)::setrlimit(__rlimit_resource_t(what), &both);
}

/// Between fork and exec: calls that are safe after a signal only.
[[noreturn]] void become(const char* program, char** arguments, char** environment,
                         const char* folder, const int (&outputs)[2], const Limits& limits) {
    (void)::setpgid(0, 0);
    const int nothing = ::open("/dev/null", O_RDONLY | O_CLOEXEC);
    if (::chdir(folder) || ::dup2(nothing, 0) < 0 || ::dup2(outputs[0], 1) < 0 ||
        ::dup2(outputs[1], 2) < 0)
        ::_exit(127);
    limit(RLIMIT_CORE, 0, 0);
    if (limits.cpu_s > 0) limit(RLIMIT_CPU, limits.cpu_s, limits.cpu_s + 2);
    limit(RLIMIT_FSIZE, limits.file_bytes, limits.file_bytes);
    if (limits.memory > 0) limit(RLIMIT_AS, limits.memory, limits.memory);
    ::alarm(limits.wall_s);  // stays over exec
    ::execve(program, arguments, environment);
    ::_exit(127);
}

std::string all_of(int descriptor) {
    struct stat status {};
    (void)::fstat(descriptor, &status);
    std::string bytes(std::size_t(status.st_size), '\0');
    std::size_t at = 0;
    while (at < bytes.size()) {
        const ssize_t got = ::pread(descriptor, &bytes[at], bytes.size() - at, off_t(at));
        if (got <= 0) break;
        at += std::size_t(got);
    }
    bytes.resize(at);
    return bytes;
}

std::vector<char*> pointers_to(std::vector<std::string>& texts) {
    std::vector<char*> pointers;
    for (std::string& text : texts) pointers.push_back(text.data());
    pointers.push_back(nullptr);
    return pointers;
}

std::vector<std::string> environment_with(const std::string& temporary_folder) {
    std::vector<std::string> all{"TMPDIR=" + temporary_folder};
    for (char** variable = environ; *variable; ++variable)
        if (std::strncmp(*variable, "TMPDIR=", 7) != 0) all.emplace_back(*variable);
    return all;
}

}  // namespace

Child::Child(const std::filesystem::path& program, const std::vector<std::string>& arguments,
             const std::filesystem::path& folder, const Limits& limits)
    : m_limits(limits),
      m_outputs{::memfd_create("out", MFD_CLOEXEC), ::memfd_create("err", MFD_CLOEXEC)} {
    std::vector<std::string> words = arguments;
    words.insert(words.begin(), program.string());
    std::vector<std::string> variables = environment_with((folder / ".tmp").string());
    const std::vector<char*> argv = pointers_to(words), envp = pointers_to(variables);
    const std::string where = folder.string();
    m_process = ::fork();
    if (m_process == 0)
        become(argv[0], const_cast<char**>(argv.data()), const_cast<char**>(envp.data()),
               where.c_str(), m_outputs, limits);
}

Child::~Child() {
    if (m_process > 0) {
        (void)::kill(-m_process, SIGKILL);
        (void)wait();
    }
    for (const int output : m_outputs) ::close(output);
}

bool Child::has_ended() {
    siginfo_t info{};
    return m_process <= 0 ||
           (::waitid(P_PID, id_t(m_process), &info, WEXITED | WNOHANG | WNOWAIT) == 0 &&
            info.si_pid == m_process);
}

Ended Child::wait() {
    Ended ended;
    int raw = 0;
    rusage used{};
    if (m_process > 0) {
        while (::wait4(m_process, &raw, 0, &used) < 0 && errno == EINTR) {
        }
        (void)::kill(-m_process, SIGKILL);
        m_process = -1;
        if (WIFEXITED(raw)) ended.status = WEXITSTATUS(raw);
        if (WIFSIGNALED(raw)) ended.signal = WTERMSIG(raw);
    }
    ended.seconds =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - m_start).count();
    const double cpu_s = double(used.ru_utime.tv_sec + used.ru_stime.tv_sec) +
                         1e-6 * double(used.ru_utime.tv_usec + used.ru_stime.tv_usec);
    ended.too_long =
        ended.signal == SIGALRM || ended.signal == SIGXCPU ||
        (ended.signal == SIGKILL && m_limits.cpu_s > 0 && cpu_s >= double(m_limits.cpu_s));
    ended.peak_mb = double(used.ru_maxrss) / 1024;
    ended.out = out();
    ended.err = err();
    return ended;
}

std::string Child::out() const {
    return all_of(m_outputs[0]);
}

std::string Child::err() const {
    return all_of(m_outputs[1]);
}

Ended run_child(const std::filesystem::path& program, const std::vector<std::string>& arguments,
                const std::filesystem::path& folder, const Limits& limits) {
    return Child(program, arguments, folder, limits).wait();
}

}  // namespace pliant::mutate
