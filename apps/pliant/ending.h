// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Termination by a signal or an uncaught exception: immediate, with at most one line, and with
// removal of staged files.

#pragma once

#include <sys/types.h>

namespace pliant::app {

/// Installs the handlers. SIGINT, SIGTERM and SIGHUP end the program with 128 + their number,
/// unless they were ignored before. SIGPIPE and SIGXFSZ are ignored: writing fails instead.
/// std::terminate prints one line and ends the program with kExitBadInput.
void guard_process() noexcept;

/// Prints the reason of the program's end; only the first call prints. Doesn't allocate.
/// @returns kExitBadInput
int say_why(const char* why) noexcept;

/// Call it before a child is started: a signal then ends the program after the next
/// end_with_program, so that no unknown child survives.
void expect_child() noexcept;

/// Sets the child that a signal kills together with the program; −1: none.
/// @pre the previous child is not reaped yet
void end_with_program(pid_t child) noexcept;

}  // namespace pliant::app
