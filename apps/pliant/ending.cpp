// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "ending.h"

#include <pliant/core/files.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <csignal>
#include <cstring>
#include <exception>
#include <new>

#include "options.h"

namespace pliant::app {
namespace {

constexpr pid_t kNone = -1, kExpected = -2;
std::atomic<pid_t> g_child{kNone};
/// Signal that came while a child was expected; 0: none.
std::atomic<int> g_waiting_signal{0};

void on_signal(int number) {
    g_waiting_signal = number;  // before g_child is read: end_with_program uses the opposite order
    const pid_t child = g_child;
    if (child == kExpected) return;
    if (child > 0) ::kill(child, SIGKILL);
    end_process(128 + number);  // returns during a commit of outputs
}

/// Prints the line once. Doesn't allocate, because memory may be exhausted.
void write_line(const char* why) noexcept {
    static std::atomic_flag was_said;
    if (was_said.test_and_set()) return;
    std::array<char, 420> line;
    std::size_t length = 0;
    for (const char* part : {"pliant: ", why})
        for (; *part && length + 1 < line.size(); ++part)
            line[length++] = *part == '\n' ? ' ' : *part;
    line[length++] = '\n';
    (void)!::write(STDERR_FILENO, line.data(), length);
}

[[noreturn]] void on_terminate() {
    // One thread prints; others wait for the end.
    static std::atomic_flag taken;
    while (taken.test_and_set()) ::pause();
    const char* why = "ended by an error of the program";
    try {
        if (std::current_exception()) std::rethrow_exception(std::current_exception());
    } catch (const std::bad_alloc&) {
        why = "out of memory";
    } catch (const std::exception& error) {
        // Copy the text, because it may be destroyed with the exception.
        static std::array<char, 300> text;
        std::strncpy(text.data(), error.what(), text.size() - 1);
        why = text.data();
    } catch (...) {
    }
    write_line(why);
    if (const pid_t child = g_child; child > 0) ::kill(child, SIGKILL);
    end_process(kExitBadInput);
    ::_exit(kExitBadInput);
}

#if defined(__ELF__) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
/// Runs before the initialisation of shared libraries, which may run out of memory too.
void guard_initialisation() {
    std::set_terminate(on_terminate);
}
[[gnu::section(".preinit_array"), gnu::used]] void (*const g_first)() = guard_initialisation;
#endif

}  // namespace

int say_why(const char* why) noexcept {
    write_line(why);
    return kExitBadInput;
}

void guard_process() noexcept {
    std::set_terminate(on_terminate);
    for (const int number : {SIGPIPE, SIGXFSZ}) std::signal(number, SIG_IGN);
    struct sigaction action {};
    action.sa_handler = on_signal;
    action.sa_flags = SA_RESTART;  // the handler returns during a commit of outputs
    constexpr int kEnding[] = {SIGINT, SIGTERM, SIGHUP};
    for (const int number : kEnding) sigaddset(&action.sa_mask, number);
    for (const int number : kEnding) {
        struct sigaction before {};
        ::sigaction(number, nullptr, &before);
        if (before.sa_handler != SIG_IGN) ::sigaction(number, &action, nullptr);
    }
}

void expect_child() noexcept {
    g_child = kExpected;
}

void end_with_program(pid_t child) noexcept {
    g_child = child;
    if (const int number = g_waiting_signal; number != 0) on_signal(number);
}

}  // namespace pliant::app
