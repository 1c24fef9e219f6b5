// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Steps of force transmittal. During a contact, its nodes live here in the plan's numbering. The
// state receives them on demand (give_back) or when the contact changes. Three sets of positions
// rotate (current, previous, and one earlier), so that a step can be undone.

#pragma once

#include <array>
#include <memory>

#include "springs/state.h"
#include "springs/sweep.h"
#include "springs/volume_sweep.h"

namespace pliant {

// Breadth-first search with reused memory.

/// @param argument  its name in the message
Status check_sources(const SpringNetwork& network, std::span<const std::int32_t> sources,
                     const char* argument);

Status check_depth(std::int32_t depth);

class OrderSearch {
  public:
    /// @pre sources and depth are checked. @param[out] order  has fewer nodes than sources if one
    /// occurs twice
    void run(const SpringNetwork& network, std::span<const std::int32_t> sources,
             std::int32_t depth, TransmittalOrder& order);

  private:
    std::vector<std::uint32_t> m_seen;  ///< [node]: last search that reached it
    std::uint32_t m_turn = 0;
};

class Transmittal {
  public:
    Transmittal(const SpringSettings& settings, double time_step);

    /// Prepares for the state's loads and held nodes. If it throws, steps continue as if it had not
    /// been called. @param everything  all nodes, without a search
    void touch(const SpringNetwork& network, SpringState& state, std::int32_t depth,
               bool everything);
    /// @returns false if a node moved farther than `farthest`
    bool step(const TaskArena& arena, double farthest);
    /// Call it after a step that returned false.
    void take_back();
    void give_back(SpringState& state) const;
    /// give_back, after which the state may be changed before the next touch().
    void leave(SpringState& state) noexcept;
    /// Discards plans after a cut or changes of the state.
    void forget(SpringState& state) noexcept;
    std::int32_t active_nodes() const { return m_plan ? m_plan->plan.active_nodes : 0; }

  private:
    using Three = std::array<AlignedArray, 3>;
    struct Kept {
        std::vector<std::int32_t> sources;
        std::int32_t depth = 0;
        SweepPlan plan;
    };
    void reserve(const SpringState& state, const SweepPlan& plan);
    void enter(const SpringNetwork& network, const SpringState& state);
    void renew_contact(const SpringNetwork& network, const SpringState& state);
    void set_node(const SpringNetwork& network, const SpringState& state, std::size_t local);
    Kept& find_plan(const SpringNetwork& network, std::int32_t depth, bool everything);
    bool sweep_packs(const TaskArena& arena, double farthest);
    void add_volume_forces(const TaskArena& arena);
    SweepArrays arrays();

    double m_time_step;
    SweepKernel m_kernel;
    VolumeKernel m_volume_kernel;
    OrderSearch m_search;
    SweepPlanner m_planner;
    TransmittalOrder m_order;
    std::vector<std::int32_t> m_sources, m_loaded, m_held;
    std::vector<std::int32_t> m_left;     ///< nodes of the last contact
    std::vector<std::uint8_t> m_reached;  ///< [node]; all 0 between calls
    std::vector<std::unique_ptr<Kept>> m_kept;
    std::unique_ptr<Kept> m_spare;  ///< the last replaced plan, whose memory is reused
    std::size_t m_oldest = 0;
    Kept* m_plan = nullptr;
    std::vector<std::size_t> m_contact;  ///< local numbers of the loaded and held nodes
    Three m_x, m_before, m_two_before, m_load, m_force;
    AlignedArray m_keep, m_push;
    AlignedArray m_branch, m_other_branch;  ///< [8 · slot + lane] of the next and the last step
    AlignedArray m_seen;                    ///< [local] x, y, z, 0: positions that cells see
    AlignedArray m_corner_force;            ///< [index in cell_nodes] x, y, z, 0
};

}  // namespace pliant
