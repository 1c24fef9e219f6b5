// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// How the program ends when a signal, or an exception that nothing catches, ends it: at once, with
// one line or none, and without staged files.

#pragma once

#include <sys/types.h>

namespace pliant::app {

/// SIGINT, SIGTERM and SIGHUP end the program with 128 + their number, unless they were ignored
/// before. SIGPIPE and SIGXFSZ are ignored: writing fails instead. std::terminate prints one line
/// and ends the program with kExitBadInput.
void guard_process() noexcept;

/// Prints the line that says why the program ends; only the first one. Allocates nothing.
/// @returns kExitBadInput
int say_why(const char* why) noexcept;

/// A process that doesn't outlive this one; −1: none.
void end_with_program(pid_t child) noexcept;

}  // namespace pliant::app
