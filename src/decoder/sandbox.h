// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// What takes from a process all that it doesn't need to decode pixels. Damaged codestreams may make
// a decoder run code of their choice; here that code can compute, and write to one socket.
//
//   limits     address space, processor time, no core dumps, no files longer than 0, no more
//              descriptors
//   prctl      no new privileges, not traceable or dumpable, killed with its parent
//   seccomp    an allow-list of system calls: read and write of that socket, memory that is not
//              executable, threads, exit. Others fail with EPERM; another architecture's kill the
//              process
//
// Linux only. Where the kernel has no seccomp, the rest holds.

#pragma once

#include <cstdint>

namespace pliant::decoder {

/// @param memory_bytes  address space beside what the process has already
void set_limits(std::uint64_t memory_bytes, std::uint64_t seconds);

/// Closes all descriptors but those below first.
void close_descriptors_from(int first);

/// Allows this process to read and write one descriptor, to allocate, to start threads and to exit;
/// nothing else.
/// @returns whether the kernel does so
bool forbid_system_calls(int descriptor);

}  // namespace pliant::decoder
