// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// In which order constraints are projected: chosen once, for any number of threads and lanes.
//
//   phase 0          phase 1 (moved by half)         rest
//   ┌───┬───┬───┐    ┌─┬───┬───┬─┐
//   │ a │ b │ c │    │ │   │   │ │     a constraint belongs to the first phase in which all its
//   ├───┼───┼───┤    ├─┼───┼───┼─┤     particles are in one domain; the few that never are come
//   │ d │ e │ f │    │ │   │   │ │     last, as one domain
//   └───┴───┴───┘    └─┴───┴───┴─┘
//
// Space is cut into domains whose particles stay in the first cache while all of their constraints
// are projected; domains of a phase share no particle, so each may have its thread. Within a domain
// constraints are put into packs of sixteen that share no particle: the lanes of a vector, or two
// or four vectors. Colouring the whole body instead would go through all of it once a colour, and
// wait for all threads as often.
//
// Particles are numbered by domain of phase 0. A pack's empty lanes work on a particle that nobody
// else has: each domain of a phase has its own, so that threads don't meet there.

#pragma once

#include <pliant/pbd.h>

#include <cstdint>
#include <vector>

namespace pliant::pbd {

inline constexpr int kPack = 16;
inline constexpr int kKinds = 4;
/// Of each PbdKind.
inline constexpr int kCorners[kKinds] = {2, 4, 4, 4};
inline constexpr int kNumbers[kKinds] = {2, 2, 2, 11};
inline constexpr int kMultipliers[kKinds] = {1, 1, 1, 2};

/// Packs begin and begin + 1 share no particle, and so on until paired_end: both may be on their
/// way at once.
struct PackRange {
    std::int32_t begin, paired_end, end;
};
struct Domain {
    PackRange packs[kKinds];
};
/// Domains that threads may work on at the same time.
struct Phase {
    std::int32_t begin, end;
};

struct KindPlan {
    std::vector<std::int32_t> constraints;  ///< [pack][lane]; −1: empty
    std::vector<std::uint32_t> corners;     ///< [pack][corner][lane]: 4 · particle
    std::vector<std::int32_t> slots;        ///< of each constraint: pack · kPack + lane
};

struct Plan {
    std::vector<std::int32_t>
        particle_of;                  ///< by the caller's number; with empty lanes' at the end
    std::int32_t particle_count = 0;  ///< with those of empty lanes
    KindPlan kinds[kKinds];
    std::vector<Domain> domains;
    std::vector<std::int32_t> spares;  ///< [domain]: the particle of its empty lanes
    std::vector<Phase> phases;
};

/// @pre the parts have been checked
Plan make_plan(const PbdParts& parts, std::int32_t domain_particles);

/// Where the constraints of some slots are. @pre kind.slots is large enough
void find_slots(KindPlan& kind, std::size_t begin, std::size_t end);

/// The nodes of a constraint.
std::span<const std::int32_t> nodes_of(const PbdParts& parts, int kind, std::size_t constraint);
std::size_t constraint_count(const PbdParts& parts, int kind);

}  // namespace pliant::pbd
