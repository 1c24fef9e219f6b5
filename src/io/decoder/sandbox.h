// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Sandbox that drops everything a process doesn't need to decode pixels. A damaged codestream may
// exploit a decoder to run arbitrary code; here such code can only compute, and write to one
// socket.
//
//   limits     address space, processor time, no core dumps, no files longer than 0, no more
//              descriptors
//   prctl      no new privileges, not traceable or dumpable, killed with its parent
//   seccomp    an allow-list of system calls: read and write of that socket, memory that is not
//              executable, threads, exit. Others fail with EPERM; another architecture's kill the
//              process
//
// Linux only. On kernels without seccomp, the other measures still apply.

#pragma once

#include <cstdint>

namespace pliant::decoder {

/// @param memory_bytes  address space beyond the present size of the process
void set_limits(std::uint64_t memory_bytes, std::uint64_t seconds);

/// Closes all descriptors from `first` on.
void close_descriptors_from(int first);

/// Restricts this process to reading and writing one descriptor, allocating, starting threads and
/// exiting.
/// @returns whether the kernel enforces it
bool forbid_system_calls(int descriptor);

}  // namespace pliant::decoder
