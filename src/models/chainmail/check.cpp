// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "chainmail/check.h"

#include <algorithm>
#include <cmath>
#include <mutex>

#include "field/field_state.h"

namespace pliant {
namespace {

/// Distance of a link from its limits [mm].
double violation_mm(const ElementLimits& low, const ElementLimits& high, int axis, int b,
                    double spacing_mm, double difference_mm) {
    const auto mean = [&](Vec3d ElementLimits::*field) {
        return spacing_mm * ((low.*field)[b] + (high.*field)[b]) / 2;
    };
    if (b != axis) return std::abs(difference_mm) - mean(&ElementLimits::shear);
    return std::max(difference_mm - mean(&ElementLimits::stretch),
                    -difference_mm - mean(&ElementLimits::compress));
}

/// A block's elements and those that its links lead to.
struct Elements {
    std::vector<ElementLimits> limits;  ///< by CellBlock::index
    std::vector<bool> is_void;
};

/// Calls visit(low, high, b, n) for the upward links along b from a block's elements of which an
/// end moved; n is the lower end's index in its brick.
template <class Visit>
void for_each_moved_link(const CellBlock& block, const Visit& visit) {
    int n = 0;
    for (int z = 0; z < block.size(); ++z)
        for (int y = 0; y < block.size(); ++y)
            for (int x = 0; x < block.size(); ++x, ++n)
                for (int b = 0; b < 3; ++b) {
                    const int low = block.index(x, y, z);
                    const int high = block.index(x + (b == 0), y + (b == 1), z + (b == 2));
                    if (block.is_moved(low) || block.is_moved(high)) visit(low, high, b, n);
                }
}

/// Limits directly from the law, evaluated only where something moved.
Elements elements_of(const Lattice& lattice, const LimitsAt& limits_at, const CellBlock& block) {
    Elements elements;
    const int last = block.size();
    const auto count = std::size_t(block.index(last, last, last)) + 1;
    std::vector<bool> is_needed(count);
    for_each_moved_link(block, [&](int low, int high, int, int) {
        is_needed[std::size_t(low)] = is_needed[std::size_t(high)] = true;
    });
    elements.limits.resize(count);
    elements.is_void.resize(count);
    for (int z = 0; z <= last; ++z)
        for (int y = 0; y <= last; ++y)
            for (int x = 0; x <= last; ++x) {
                const auto n = std::size_t(block.index(x, y, z));
                if (!is_needed[n]) continue;
                const Vec3i e = block.first_element() + Vec3i{x, y, z};
                elements.limits[n] = limits_at(e);
                elements.is_void[n] = lattice.is_void(e);
            }
    return elements;
}

struct Checked {
    double worst_mm = 0;
    std::int64_t excused = 0;
};

/// Checks one component. A link outside of its limits is excused up to its value at the change of
/// materials.
void check_link(Checked& checked, double violation, Vec3i coord, int index, int b, int a,
                Fixed difference, const Allowance* allowance) {
    const Fixed excused = violation > 0 && allowance ? allowance->excused(coord, index, b, a) : 0;
    if (excused != 0 && (excused > 0) == (difference > 0)) {
        checked.excused += 1;
        violation = std::abs(mm_from_units(difference)) - std::abs(mm_from_units(excused));
    }
    checked.worst_mm = std::max(checked.worst_mm, violation);
}

Checked check_links(const Lattice& lattice, Vec3i coord, const CellBlock& block,
                    const LimitsAt& limits_at, const Allowance* allowance) {
    Checked checked;
    const Elements elements = elements_of(lattice, limits_at, block);
    const BrickEdits* edits = lattice.edits_of(coord);
    for_each_moved_link(block, [&](int low, int high, int b, int n) {
        const auto from = std::size_t(low), to = std::size_t(high);
        if (elements.is_void[from] || elements.is_void[to]) return;
        if (edits && ((*edits)[std::size_t(n)] & (kCutX << b))) return;
        for (int a = 0; a < 3; ++a) {
            const Fixed difference = block.displacement(high)[a] - block.displacement(low)[a];
            const double violation =
                violation_mm(elements.limits[from], elements.limits[to], a, b,
                             lattice.grid().spacing_mm[b], mm_from_units(difference));
            check_link(checked, violation, coord, n, b, a, difference, allowance);
        }
    });
    return checked;
}

}  // namespace

LatticeState check_lattice(const Lattice& lattice, const LimitsAt& limits_at,
                           const TaskArena& arena, const Allowance* allowance) {
    std::mutex mutex;
    Checked all;
    const auto look_at_links = [&](Vec3i coord, const CellBlock& block) {
        const Checked checked = check_links(lattice, coord, block, limits_at, allowance);
        const std::lock_guard lock(mutex);
        all.worst_mm = std::max(all.worst_mm, checked.worst_mm);
        all.excused += checked.excused;
    };
    LatticeState state{state_of_field(lattice, arena, look_at_links)};
    state.max_violation_mm = all.worst_mm;
    state.excused_links = all.excused;
    return state;
}

}  // namespace pliant
