// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The lattices for timing solves: five sizes, of about 1 k, 10 k, 100 k, 1 M and 10 M moved
// elements, of one material or of four; and the bandwidth of the floor.

#pragma once

#include <benchmark/benchmark.h>
#include <pliant/chainmail.h>

#include <cstdint>
#include <vector>

namespace pliant::bench {

/// Four materials in wavy layers, or one.
Volume layered_volume(int side, bool heterogeneous);
/// Their limits, 0.02 to 0.4 of a link; or one of 0.2.
std::vector<ElementLimits> limits_of(bool heterogeneous);
ChainMailSettings settings_of(bool heterogeneous, ChainMailSolver solver);

/// Meaning of a case's three arguments.
struct Contact {
    explicit Contact(const benchmark::State& state);
    Contact(int decade, bool heterogeneous, int threads);

    Push diagonal_push() const;
    /// Cached until another one is requested: the largest take seconds to make.
    const Volume& volume() const;

    int decade;  ///< 0…4
    bool heterogeneous;
    int threads;
    int side;        ///< elements along each edge of the lattice
    double push_mm;  ///< along its diagonal
};

/// Registers a case for some decades, one and four materials, one and two threads. The number of
/// runs depends on its size; there are no trial runs.
using Case = void (*)(benchmark::State&);
bool register_contacts(const char* name, Case run, const std::vector<int>& decades);

/// Aborts if a push on these lattices isn't applied.
std::int64_t moved_by(const Result<PushReport>& report);

/// Necessary bytes per moved element of a push from rest: the value is read, the material and the
/// position are written.
inline constexpr double kPushBytes = 2 + 2 + 12;
/// The same for a frame of a drag from rest, along all axes: the field is read, and positions are
/// written without being read.
inline constexpr double kFrameBytes = 4 + 12;

/// Adds the floor of a case with ns/item: the necessary bytes at the bandwidth of a plain uncached
/// copy by the same threads.
void add_floor(benchmark::State& state, const TaskArena& arena, double bytes_per_item);

}  // namespace pliant::bench
