// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Remaining abilities of the pixel decoder's process after it has dropped its privileges.
// Covers: decoder/sandbox.cpp.

#include "decoder/sandbox.h"

#include <gtest/gtest.h>

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <functional>

namespace pliant {
namespace {

constexpr int kHasNone = 99;  ///< exit status where the kernel has no seccomp

/// Exit status of a process that runs work in the sandbox; −signal if it was killed.
/// @param work  gets the descriptor that may be used
int status_in_sandbox(const std::function<int(int)>& work) {
    int ends[2];
    EXPECT_EQ(::socketpair(AF_UNIX, SOCK_STREAM, 0, ends), 0);
    const pid_t process = ::fork();
    if (process == 0) {
        decoder::set_limits(~std::uint64_t(0), 5);
        if (!decoder::forbid_system_calls(ends[1])) ::_exit(kHasNone);
        const int status = work(ends[1]);
        ::syscall(SYS_exit_group, status);
    }
    ::close(ends[1]);
    int status = 0;
    EXPECT_EQ(::waitpid(process, &status, 0), process);
    ::close(ends[0]);
    return WIFSIGNALED(status) ? -WTERMSIG(status) : WEXITSTATUS(status);
}

/// Whether a call is refused, and the process goes on.
void expect_refused(const char* name, const std::function<long()>& call) {
    const int status = status_in_sandbox([&](int) { return call() == -1 ? errno : 0; });
    if (status == kHasNone) GTEST_SKIP() << "no seccomp here";
    EXPECT_EQ(status, EPERM) << name;
}

TEST(DicomSandbox, OpensNoFileSocketOrProcess) {
    expect_refused("openat", [] { return ::syscall(SYS_openat, AT_FDCWD, "/", O_RDONLY); });
    expect_refused("socket", [] { return ::syscall(SYS_socket, AF_INET, SOCK_STREAM, 0); });
    expect_refused("clone", [] { return ::syscall(SYS_clone, SIGCHLD, 0, 0, 0, 0); });
    expect_refused("unlinkat", [] { return ::syscall(SYS_unlinkat, AT_FDCWD, "/none", 0); });
    expect_refused("kill", [] { return ::syscall(SYS_kill, ::getppid(), 0); });
    expect_refused("ptrace", [] { return ::syscall(SYS_ptrace, 0, 0, 0, 0); });
    expect_refused("prctl", [] { return ::syscall(SYS_prctl, 0, 0, 0, 0, 0); });
    expect_refused("dup", [] { return ::syscall(SYS_dup, 0); });
    expect_refused("execve", [] {
        const char* const arguments[] = {"/bin/true", nullptr};
        return ::syscall(SYS_execve, arguments[0], arguments, arguments + 1);
    });
}

TEST(DicomSandbox, MemoryIsNeverExecutable) {
    constexpr int kAnonymous = MAP_PRIVATE | MAP_ANONYMOUS;
    expect_refused("mmap", [] {
        return ::syscall(SYS_mmap, 0, 4096, PROT_READ | PROT_EXEC, kAnonymous, -1, 0);
    });
    expect_refused("mmap of a file",
                   [] { return ::syscall(SYS_mmap, 0, 4096, PROT_READ, MAP_PRIVATE, 0, 0); });
    static char page[8192] = {};
    const auto start = (reinterpret_cast<std::uintptr_t>(page) + 4095) / 4096 * 4096;
    expect_refused("mprotect", [&] {
        return ::syscall(SYS_mprotect, start, 4096, PROT_READ | PROT_WRITE | PROT_EXEC);
    });
}

TEST(DicomSandbox, ComputesAndWritesToItsSocketOnly) {
    const int status = status_in_sandbox([](int socket) {
        void* memory =
            ::mmap(nullptr, 1 << 20, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
        if (memory == MAP_FAILED) return 1;
        static_cast<char*>(memory)[4096] = 1;
        if (::munmap(memory, 1 << 20) != 0) return 2;
        if (::write(socket, "x", 1) != 1) return 3;
        if (::write(1, "x", 1) != -1 || errno != EPERM) return 4;
        char byte = 0;
        if (::read(0, &byte, 1) != -1 || errno != EPERM) return 5;
        return 0;
    });
    if (status == kHasNone) GTEST_SKIP() << "no seccomp here";
    EXPECT_EQ(status, 0);
}

TEST(DicomSandbox, LimitsHoldWithoutAFilterToo) {
    const pid_t process = ::fork();
    if (process == 0) {
        decoder::set_limits(~std::uint64_t(0), 1);
        rlimit limit{};
        int wrong = 0;
        if (::getrlimit(RLIMIT_NOFILE, &limit) != 0 || limit.rlim_max != 0) wrong |= 1;
        if (::getrlimit(RLIMIT_FSIZE, &limit) != 0 || limit.rlim_max != 0) wrong |= 2;
        if (::getrlimit(RLIMIT_CORE, &limit) != 0 || limit.rlim_max != 0) wrong |= 4;
        if (::open("/dev/null", O_RDONLY) != -1 || errno != EMFILE) wrong |= 8;
        ::_exit(wrong);
    }
    int status = 0;
    ASSERT_EQ(::waitpid(process, &status, 0), process);
    EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0) << status;
}

}  // namespace
}  // namespace pliant
