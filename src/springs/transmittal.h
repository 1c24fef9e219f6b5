// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Steps of force transmittal. While a contact stays, its nodes live here, in the numbers of its
// plan; the state gets them back when somebody asks (give_back) or the contact changes. Three sets
// of places go round: now, one step before, and two, so that a step can be taken back.

#pragma once

#include <array>
#include <memory>

#include "springs/order.h"
#include "springs/state.h"
#include "springs/sweep.h"

namespace pliant {

class Transmittal {
  public:
    Transmittal(const SpringSettings& settings, double time_step);

    /// Makes ready for the state's loads and held nodes. Where it throws, steps go on as if it had
    /// not been called. @param everything  all nodes, no search
    void touch(const SpringNetwork& network, SpringState& state, std::int32_t depth,
               bool everything);
    /// @returns false where a node moved farther than is believed
    bool step(const TaskArena& arena, double farthest);
    /// After a step that returned false.
    void take_back();
    void give_back(SpringState& state) const;
    /// The same, and the state may be changed before the next touch().
    void leave(SpringState& state) noexcept;
    /// After a cut or changes of the state: plans are made anew.
    void forget(SpringState& state) noexcept;
    std::int32_t active_nodes() const { return m_plan ? m_plan->plan.active_nodes : 0; }

  private:
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
    bool sweep_packs(std::int32_t begin_pack, std::int32_t end_pack, const TaskArena& arena,
                     double farthest);
    void add_volume_forces(std::size_t group, const TaskArena& arena);
    SweepArrays arrays();

    SpringSettings m_settings;
    double m_time_step;
    SweepKernel m_kernel;
    OrderSearch m_search;
    SweepPlanner m_planner;
    TransmittalOrder m_order;
    std::vector<std::int32_t> m_sources, m_loaded, m_held;
    std::vector<std::int32_t> m_left;     ///< nodes of the last contact
    std::vector<std::uint8_t> m_reached;  ///< [node]; all 0 between calls
    std::vector<std::unique_ptr<Kept>> m_kept;
    std::unique_ptr<Kept> m_spare;  ///< the plan that was replaced last: memory for the next one
    std::size_t m_oldest = 0;
    Kept* m_plan = nullptr;
    std::vector<std::size_t> m_contact;  ///< local numbers of the loaded and held nodes
    using Three = std::array<AlignedArray, 3>;
    Three m_x, m_before, m_two_before, m_load, m_force;
    AlignedArray m_keep, m_push;
    std::vector<Vec3d> m_corner_force;  ///< [8 · cell + corner]
};

}  // namespace pliant
