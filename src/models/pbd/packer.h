// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Assigns constraints of a domain to packs without common particles, for the plan of a whole body
// and for its active part.

#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "pbd/plan.h"

namespace pliant::pbd {

/// Greedy: each constraint goes to the first pack that contains none of its particles.
class Packer {
  public:
    /// @param particle_of  as in Plan. Both arguments outlive the object
    Packer(const std::vector<std::int32_t>& particle_of, const PbdParts& parts);

    /// Appends packs to the constraints and corners. @param members  constraints of one kind.
    /// @param spare  particle of empty lanes
    PackRange pack(std::span<const std::int32_t> members, int kind, std::int32_t spare,
                   KindPlan& to);

  private:
    static constexpr int kWindow = 64;  ///< packs considered

    void pack_all(std::span<const std::int32_t> members, int kind, KindPlan& to);
    void add(KindPlan& to, int kind, std::int32_t constraint);
    void forget_first(const KindPlan& to, int kind);
    std::int32_t pair_up(KindPlan& to, int kind, std::int32_t first);
    void write_corners(KindPlan& to, int kind, std::int32_t first, std::int32_t spare) const;

    const std::vector<std::int32_t>& m_particle_of;
    const PbdParts& m_parts;
    std::vector<std::uint64_t> m_packs_of;  ///< [particle]: packs of the window
    std::int32_t m_first = 0, m_next = 0;   ///< of the window
    std::uint64_t m_open = 0;
    std::array<int, kWindow> m_used{};
    std::vector<std::int32_t> m_pair_of;  ///< [particle]
    std::int32_t m_pair = 0;
    std::vector<std::int32_t> m_left, m_order, m_alone, m_packs;
};

}  // namespace pliant::pbd
