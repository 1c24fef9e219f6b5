// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The order in which constraints are projected: chosen once, for any number of threads and lanes.
//
//   phase 0          phase 1 (offset by half)        rest
//   ┌───┬───┬───┐    ┌─┬───┬───┬─┐
//   │ a │ b │ c │    │ │   │   │ │     a constraint belongs to the first phase in which all its
//   ├───┼───┼───┤    ├─┼───┼───┼─┤     particles are in one domain; the few without such a phase
//   │ d │ e │ f │    │ │   │   │ │     come last, as one domain
//   └───┴───┴───┘    └─┴───┴───┴─┘
//
// Space is divided into domains whose particles stay in the L1 cache while all of their constraints
// are projected. Domains of a phase share no particle, so they can be processed in parallel. Within
// a domain, constraints are assigned to packs of sixteen without common particles: the lanes of
// one, two or four vectors. Graph colouring of the whole body would instead traverse the body once
// per colour, with a barrier after each.
//
// Particles are numbered by domain of phase 0. A pack's empty lanes work on a dummy particle. Each
// domain of a phase has a separate one, to avoid data races.

#pragma once

#include <pliant/models/pbd.h>

#include <cstdint>
#include <vector>

namespace pliant::pbd {

inline constexpr int kPack = 16;
inline constexpr int kKinds = 4;
/// Properties of each PbdKind.
inline constexpr int kCorners[kKinds] = {2, 4, 4, 4};
inline constexpr int kNumbers[kKinds] = {2, 2, 2, 12};
inline constexpr int kMultipliers[kKinds] = {1, 1, 1, 2};

/// Packs begin and begin + 1 share no particle, and so on until paired_end: both may be processed
/// interleaved.
struct PackRange {
    std::int32_t begin, paired_end, end;
};
struct Domain {
    PackRange packs[kKinds];
};
/// Domains that may be processed concurrently.
struct Phase {
    std::int32_t begin, end;
};

struct KindPlan {
    std::vector<std::int32_t> constraints;  ///< [pack][lane]; −1: empty
    std::vector<std::uint32_t> corners;     ///< [pack][corner][lane]: 4 · particle
    std::vector<std::int32_t> slots;        ///< [constraint]: pack · kPack + lane
};

struct Plan {
    std::vector<std::int32_t> particle_of;  ///< by the caller's number; dummy particles at the end
    std::int32_t particle_count = 0;        ///< including dummy particles
    KindPlan kinds[kKinds];
    std::vector<Domain> domains;
    std::vector<std::int32_t> spares;  ///< [domain]: dummy particle of its empty lanes
    std::vector<Phase> phases;
};

/// @pre the parts have been checked
Plan make_plan(const PbdParts& parts, std::int32_t domain_particles);

/// Sets the slots of constraints. @pre kind.slots is large enough
void find_slots(KindPlan& kind, std::size_t begin, std::size_t end);

/// The nodes of a constraint.
std::span<const std::int32_t> nodes_of(const PbdParts& parts, int kind, std::size_t constraint);
std::size_t constraint_count(const PbdParts& parts, int kind);

}  // namespace pliant::pbd
