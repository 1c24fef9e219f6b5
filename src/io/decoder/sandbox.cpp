// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "decoder/sandbox.h"

#include <linux/audit.h>
#include <linux/filter.h>
#include <linux/seccomp.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstddef>
#include <cstdio>
#include <initializer_list>
#include <limits>
#include <vector>

namespace pliant::decoder {
namespace {

#if defined(__x86_64__)
constexpr std::uint32_t kArchitecture = AUDIT_ARCH_X86_64;
#elif defined(__aarch64__)
constexpr std::uint32_t kArchitecture = AUDIT_ARCH_AARCH64;
#else
constexpr std::uint32_t kArchitecture = 0;  // no filter on others
#endif
/// First call number of x32, which has the same architecture id as x86-64.
constexpr std::uint32_t kX32 = 0x40000000;

constexpr std::uint32_t kAllow = SECCOMP_RET_ALLOW, kKill = SECCOMP_RET_KILL_PROCESS,
                        kRefuse = SECCOMP_RET_ERRNO | EPERM, kMissing = SECCOMP_RET_ERRNO | ENOSYS;

/// Flags of a new thread in the C library; new processes have other flags.
constexpr int kThread = CLONE_VM | CLONE_FS | CLONE_FILES | CLONE_SYSVSEM | CLONE_SIGHAND |
                        CLONE_THREAD | CLONE_SETTLS | CLONE_PARENT_SETTID | CLONE_CHILD_CLEARTID;

/// Builds a program for the kernel's BPF filter, which reads a seccomp_data in units of 32 bits.
class Filter {
  public:
    Filter() {
        load(offsetof(seccomp_data, arch));
        end_unless_equal(kArchitecture, kKill);
        load(offsetof(seccomp_data, nr));
        jump(BPF_JGE, kX32, 0, 1);
        end(kKill);
    }
    void allow(std::uint32_t call) {
        jump(BPF_JEQ, call, 0, 1);
        end(kAllow);
    }
    /// Makes a call fail as if the kernel didn't implement it.
    void hide(std::uint32_t call) {
        jump(BPF_JEQ, call, 0, 1);
        end(kMissing);
    }
    /// Allows a call if the argument is one of these numbers.
    void allow_if_one_of(std::uint32_t call, int argument, std::initializer_list<int> numbers) {
        begin(call, argument, 1 + 2 * numbers.size());
        for (const int number : numbers) {
            jump(BPF_JEQ, std::uint32_t(number), 0, 1);
            end(kAllow);
        }
        end(kRefuse);
    }
    /// Allows a call if the argument has none of these bits.
    void allow_without(std::uint32_t call, int argument, std::uint32_t bits) {
        begin(call, argument, 3);
        jump(BPF_JSET, bits, 1, 0);
        end(kAllow);
        end(kRefuse);
    }
    /// Allows anonymous mappings that are not executable.
    void allow_anonymous_memory(std::uint32_t call) {
        constexpr int kProtection = 2, kFlags = 3;
        begin(call, kProtection, 6);
        jump(BPF_JSET, PROT_EXEC, 3, 0);
        load(low_word(kFlags));
        jump(BPF_JSET, MAP_ANONYMOUS, 0, 1);
        end(kAllow);
        end(kRefuse);
        end(kRefuse);
    }
    bool install() {
        end(kRefuse);
        const sock_fprog program{static_cast<unsigned short>(m_code.size()), m_code.data()};
        return ::prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &program) == 0;
    }

  private:
    static std::uint32_t low_word(int argument) {
        // Both architectures are little endian.
        return std::uint32_t(offsetof(seccomp_data, args) + 8 * std::size_t(argument));
    }
    void load(std::size_t offset) {
        m_code.push_back({BPF_LD | BPF_W | BPF_ABS, 0, 0, std::uint32_t(offset)});
    }
    void jump(std::uint16_t test, std::uint32_t number, std::uint8_t yes, std::uint8_t no) {
        m_code.push_back({std::uint16_t(BPF_JMP | test | BPF_K), yes, no, number});
    }
    void end(std::uint32_t action) { m_code.push_back({BPF_RET | BPF_K, 0, 0, action}); }
    void end_unless_equal(std::uint32_t number, std::uint32_t action) {
        jump(BPF_JEQ, number, 1, 0);
        end(action);
    }
    /// Skips the following instructions unless it is this call; otherwise loads the argument. The
    /// instructions must end in a decision, because the call's number is no longer loaded.
    /// @param count  number of these instructions
    void begin(std::uint32_t call, int argument, std::size_t count) {
        jump(BPF_JEQ, call, 0, std::uint8_t(count + 1));
        load(low_word(argument));
    }

    std::vector<sock_filter> m_code;
};

void set_limit(int resource, std::uint64_t number) {
    rlimit limit{};
    if (::getrlimit(__rlimit_resource_t(resource), &limit) != 0) return;
    limit.rlim_max = limit.rlim_max < number ? limit.rlim_max : rlim_t(number);
    limit.rlim_cur = limit.rlim_max;
    ::setrlimit(__rlimit_resource_t(resource), &limit);
}

/// Address space of this process [bytes].
std::uint64_t own_address_space() {
    unsigned long long pages = 0;
    if (std::FILE* file = std::fopen("/proc/self/statm", "r")) {
        if (std::fscanf(file, "%llu", &pages) != 1) pages = 0;
        std::fclose(file);
    }
    return pages * std::uint64_t(::sysconf(_SC_PAGESIZE));
}

}  // namespace

void set_limits(std::uint64_t memory_bytes, std::uint64_t seconds) {
    constexpr std::uint64_t kMost = std::numeric_limits<std::uint64_t>::max();
    const std::uint64_t own = own_address_space();
    if (memory_bytes < kMost - own) set_limit(RLIMIT_AS, own + memory_bytes);
    set_limit(RLIMIT_CPU, seconds);
    set_limit(RLIMIT_CORE, 0);
    set_limit(RLIMIT_FSIZE, 0);
    set_limit(RLIMIT_NOFILE, 0);
    ::prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0);
    ::prctl(PR_SET_DUMPABLE, 0, 0, 0, 0);
    ::prctl(PR_SET_PDEATHSIG, SIGKILL, 0, 0, 0);
}

void close_descriptors_from(int first) {
#if defined(SYS_close_range)
    if (::syscall(SYS_close_range, unsigned(first), ~0u, 0u) == 0) return;
#endif
    rlimit limit{};
    const bool known = ::getrlimit(RLIMIT_NOFILE, &limit) == 0 && limit.rlim_cur < 65536;
    for (int descriptor = first; descriptor < (known ? int(limit.rlim_cur) : 65536); ++descriptor)
        ::close(descriptor);
}

bool forbid_system_calls(int descriptor) {
    if (!kArchitecture) return false;
    Filter filter;
    filter.allow_if_one_of(SYS_read, 0, {descriptor});
    filter.allow_if_one_of(SYS_write, 0, {descriptor, 2});  // messages of libraries
    filter.allow_anonymous_memory(SYS_mmap);
    filter.allow_without(SYS_mprotect, 2, PROT_EXEC);
    // OpenJPEG uses threads. The flags of clone3 are in memory, invisible to the filter.
    filter.hide(SYS_clone3);
    filter.allow_if_one_of(SYS_clone, 0, {kThread});
    for (const long call : {SYS_brk, SYS_munmap, SYS_mremap, SYS_madvise, SYS_exit, SYS_exit_group,
                            SYS_rt_sigreturn, SYS_rt_sigprocmask, SYS_futex, SYS_set_robust_list,
                            SYS_rseq, SYS_sched_getaffinity, SYS_sched_yield})
        filter.allow(std::uint32_t(call));
    return filter.install();
}

}  // namespace pliant::decoder
