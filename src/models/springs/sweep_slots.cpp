// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Sorting of a plan's links into slots of eight.

#include <algorithm>
#include <bit>
#include <cstring>

#include "base/hash.h"
#include "springs/state.h"
#include "springs/sweep_plan.h"

namespace pliant {
namespace {

/// Cost of a slot with a list, relative to a slot with a row.
constexpr std::size_t kListCost = 8;
/// The same for the choice between sparse rows and lists of the same links.
constexpr std::size_t kDenseListCost = 3;

}  // namespace

/// Sorts a pack's links by the offset to their other end; rare offsets go to m_left.
void SweepPlanner::sort_links(const SpringNetwork& network, const SweepPlan& plan,
                              std::int32_t pack) {
    m_slots.clear();
    m_first_lane = (pack + 1) * kPack;
    for (auto& left : m_left) left.clear();
    for (int lane = 0; lane < kPack; ++lane) {
        const std::int32_t local = (pack + 1) * kPack + lane;
        if (!plan.is_active[std::size_t(local)]) continue;
        const std::int32_t node = plan.nodes[std::size_t(local)];
        std::size_t guess = 0;  // neighbours are sorted, so the next slot is the best guess
        for (const auto& neighbour : network.neighbours(node)) {
            const std::int32_t other = m_local_of[std::size_t(neighbour.node)];
            const std::int32_t offset = other - local;
            const std::uint32_t bit = 1u << lane;
            const auto fits = [&](const Slot& slot) {
                return slot.offset == offset && !(slot.lanes & bit);
            };
            if (guess >= m_slots.size() || !fits(m_slots[guess])) {
                guess = 0;
                while (guess < m_slots.size() && !fits(m_slots[guess])) ++guess;
                if (guess == m_slots.size()) m_slots.push_back({offset, 0, {}});
            }
            m_slots[guess].lanes |= bit;
            m_slots[guess].link[lane] = neighbour.link;
            ++guess;
        }
    }
    const int fewest = fewest_in_row();
    const auto is_rare = [&](const Slot& slot) { return std::popcount(slot.lanes) < fewest; };
    for (const Slot& slot : m_slots)
        if (is_rare(slot))
            for (int lane = 0; lane < kPack; ++lane)
                if (slot.lanes >> lane & 1)
                    m_left[lane].push_back(
                        {(pack + 1) * kPack + lane + slot.offset, slot.link[lane]});
    std::erase_if(m_slots, is_rare);
    merge_rows();
}

/// Moves the links of a pack's rows to its lists if the rows are sparse, as in meshes without
/// regular numbering. Each lane keeps the order of its links, so the sums have the same bits.
void SweepPlanner::merge_rows() {
    std::size_t links[kPack] = {}, listed = 0;
    for (const Slot& slot : m_slots)
        for (int lane = 0; lane < kPack; ++lane) links[lane] += slot.lanes >> lane & 1;
    for (int lane = 0; lane < kPack; ++lane) {
        listed = std::max(listed, m_left[lane].size());
        links[lane] += m_left[lane].size();
    }
    const std::size_t merged = *std::max_element(links, links + kPack);
    if (kDenseListCost * merged >= m_slots.size() + kDenseListCost * listed) return;
    for (int lane = 0; lane < kPack; ++lane) {
        m_merged.clear();
        for (const Slot& slot : m_slots)
            if (slot.lanes >> lane & 1)
                m_merged.push_back({m_first_lane + lane + slot.offset, slot.link[lane]});
        m_left[lane].insert(m_left[lane].begin(), m_merged.begin(), m_merged.end());
    }
    m_slots.clear();
}

/// Minimum number of links for an offset's row; links of rarer offsets share lists.
int SweepPlanner::fewest_in_row() const {
    std::size_t least = m_slots.size();
    int best = 1;
    std::size_t listed[kPack] = {};
    std::size_t rows = m_slots.size();
    for (int fewest = 2; fewest <= kPack + 1; ++fewest) {
        for (const Slot& slot : m_slots) {
            if (std::popcount(slot.lanes) != fewest - 1) continue;
            --rows;
            for (int lane = 0; lane < kPack; ++lane) listed[lane] += slot.lanes >> lane & 1;
        }
        const std::size_t cost = rows + kListCost * *std::max_element(listed, listed + kPack);
        if (cost < least) {
            least = cost;
            best = fewest;
        }
    }
    return best;
}

std::uint32_t SweepPlanner::block_of(const SpringNetwork& network,
                                     const std::int32_t (&links)[kPack], double time_step,
                                     SweepPlan& plan) {
    double block[7 * kPack] = {};
    for (int lane = 0; lane < kPack; ++lane) {
        if (links[lane] < 0) continue;
        const SpringLink& link = network.links()[std::size_t(links[lane])];
        block[lane] = link.stiffness;
        block[kPack + lane] = link.stiffness * link.rest_length;
        block[2 * kPack + lane] = link.damping / time_step;
        if (!plan.branched) continue;
        const MaxwellBranch branch = branch_of(link, time_step);
        block[3 * kPack + lane] = link.rest_length;
        block[4 * kPack + lane] = branch.pull;
        block[5 * kPack + lane] = branch.keep;
        block[6 * kPack + lane] = branch.gain;
    }
    const std::size_t size = plan.block_size();
    const auto is_equal = [&](std::uint32_t b) {
        return std::memcmp(plan.blocks.data() + b * size, block, size * sizeof(double)) == 0;
    };
    const std::size_t index = plan.slots.size() - plan.packs.back().begin;
    if (m_last_block.size() <= index) m_last_block.resize(index + 1, 0);
    if (!plan.blocks.empty() && is_equal(m_last_block[index])) return m_last_block[index];
    Hash64 hash;
    hash.add(std::span<const double>(block, size));
    const auto fresh = std::uint32_t(plan.blocks.size() / size);
    const auto [entry, is_new] = m_block_of.try_emplace(hash.value(), fresh);
    if (is_new || !is_equal(entry->second)) {
        plan.blocks.insert(plan.blocks.end(), block, block + size);
        entry->second = fresh;
    }
    return m_last_block[index] = entry->second;
}

void SweepPlanner::add_rows(const SpringNetwork& network, double time_step, SweepPlan& plan) {
    std::int32_t links[kPack];
    for (const Slot& slot : m_slots) {
        for (int lane = 0; lane < kPack; ++lane)
            links[lane] = slot.lanes >> lane & 1 ? slot.link[lane] : -1;
        const std::uint32_t block = block_of(network, links, time_step, plan);
        plan.slots.push_back({slot.offset, block});
        if (plan.branched) plan.slot_links.insert(plan.slot_links.end(), links, links + kPack);
    }
}

void SweepPlanner::add_lists(std::int32_t pack, const SpringNetwork& network, double time_step,
                             SweepPlan& plan) {
    std::size_t longest = 0;
    for (const auto& left : m_left) longest = std::max(longest, left.size());
    std::int32_t links[kPack];
    for (std::size_t n = 0; n < longest; ++n) {
        const auto first = std::int32_t(plan.others.size());
        for (int lane = 0; lane < kPack; ++lane) {
            const bool has = n < m_left[lane].size();
            links[lane] = has ? m_left[lane][n].link : -1;
            plan.others.push_back(has ? m_left[lane][n].local : (pack + 1) * kPack + lane);
        }
        const std::uint32_t block = block_of(network, links, time_step, plan);
        plan.slots.push_back({first, block});
        if (plan.branched) plan.slot_links.insert(plan.slot_links.end(), links, links + kPack);
    }
}

void SweepPlanner::make_slots(const SpringNetwork& network, double time_step, SweepPlan& plan) {
    m_block_of.clear();
    m_last_block.clear();
    const auto here = [&] { return std::uint32_t(plan.slots.size()); };
    const std::int32_t packs = plan.active_end / kPack - 1;
    for (std::int32_t pack = 0; pack < packs; ++pack) {
        sort_links(network, plan, pack);
        plan.packs.push_back({here(), 0, 0});
        add_rows(network, time_step, plan);
        plan.packs.back().rows_end = here();
        add_lists(pack, network, time_step, plan);
        plan.packs.back().end = here();
    }
}

}  // namespace pliant
