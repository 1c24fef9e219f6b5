// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "mutate/child.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/resource.h>
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
    limit(RLIMIT_CPU, limits.cpu_s, limits.cpu_s + 2);
    limit(RLIMIT_FSIZE, limits.file_bytes, limits.file_bytes);
    if (limits.memory > 0) limit(RLIMIT_AS, limits.memory, limits.memory);
    ::alarm(limits.wall_s);  // stays over exec
    ::execve(program, arguments, environment);
    ::_exit(127);
}

std::string all_of(int descriptor) {
    const off_t size = ::lseek(descriptor, 0, SEEK_END);
    std::string bytes(std::size_t(size > 0 ? size : 0), '\0');
    std::size_t at = 0;
    while (at < bytes.size()) {
        const ssize_t got = ::pread(descriptor, &bytes[at], bytes.size() - at, off_t(at));
        if (got <= 0) break;
        at += std::size_t(got);
    }
    bytes.resize(at);
    ::close(descriptor);
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

Ended run_child(const std::filesystem::path& program, const std::vector<std::string>& arguments,
                const std::filesystem::path& folder, const Limits& limits) {
    std::vector<std::string> words = arguments;
    words.insert(words.begin(), program.string());
    std::vector<std::string> variables = environment_with((folder / ".tmp").string());
    const std::vector<char*> argv = pointers_to(words), envp = pointers_to(variables);
    const std::string where = folder.string();
    const int outputs[2] = {::memfd_create("out", MFD_CLOEXEC), ::memfd_create("err", MFD_CLOEXEC)};
    const auto start = std::chrono::steady_clock::now();
    const pid_t child = ::fork();
    if (child == 0)
        become(argv[0], const_cast<char**>(argv.data()), const_cast<char**>(envp.data()),
               where.c_str(), outputs, limits);
    Ended ended;
    int raw = 0;
    rusage used{};
    if (child > 0) {
        while (::wait4(child, &raw, 0, &used) < 0 && errno == EINTR) {
        }
        (void)::kill(-child, SIGKILL);
        if (WIFEXITED(raw)) ended.status = WEXITSTATUS(raw);
        if (WIFSIGNALED(raw)) ended.signal = WTERMSIG(raw);
    }
    ended.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    const double cpu_s = double(used.ru_utime.tv_sec + used.ru_stime.tv_sec) +
                         1e-6 * double(used.ru_utime.tv_usec + used.ru_stime.tv_usec);
    ended.too_long = ended.signal == SIGALRM || ended.signal == SIGXCPU ||
                     (ended.signal == SIGKILL && cpu_s >= double(limits.cpu_s));
    ended.peak_mb = double(used.ru_maxrss) / 1024;
    ended.out = all_of(outputs[0]);
    ended.err = all_of(outputs[1]);
    return ended;
}

}  // namespace pliant::mutate
