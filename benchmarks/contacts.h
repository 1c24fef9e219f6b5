// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The lattices on which solves are timed: five sizes, of about 1 k, 10 k, 100 k, 1 M and 10 M moved
// elements, of one material or of four; and the bandwidth that is the floor beside them.

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

/// What a case's three arguments say.
struct Contact {
    explicit Contact(const benchmark::State& state);
    Contact(int decade, bool heterogeneous, int threads);

    Push diagonal_push() const;
    /// Kept until another one is asked for: the largest take seconds to make.
    const Volume& volume() const;

    int decade;  ///< 0…4
    bool heterogeneous;
    int threads;
    int side;        ///< elements along each edge of the lattice
    double push_mm;  ///< along its diagonal
};

/// Registers a case for some decades, one and four materials, one and two threads. It runs as often
/// as its size allows, without trial runs before it.
using Case = void (*)(benchmark::State&);
bool register_contacts(const char* name, Case run, const std::vector<int>& decades);

/// Aborts where a push on these lattices isn't done.
std::int64_t moved_by(const Result<PushReport>& report);

/// Bytes per moved element that a push from rest can't do without: the value read, the material
/// and the place written.
inline constexpr double kPushBytes = 2 + 2 + 12;
/// And a frame of a drag from rest, along all axes: the field read, and places written, which can
/// be done without reading them.
inline constexpr double kFrameBytes = 4 + 12;

/// Adds the floor of a case whose ns/item are counted: the bytes that must be moved, at the
/// bandwidth of a plain copy by the same threads that no cache holds.
void add_floor(benchmark::State& state, const TaskArena& arena, double bytes_per_item);

}  // namespace pliant::bench
