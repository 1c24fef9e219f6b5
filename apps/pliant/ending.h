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

/// Called before a child is started: a signal ends the program after the next end_with_program, so
/// that no child remains that it doesn't know.
void expect_child() noexcept;

/// Names the child that a signal ends together with the program; −1: none.
/// @pre a child that was named before is not reaped yet
void end_with_program(pid_t child) noexcept;

}  // namespace pliant::app
