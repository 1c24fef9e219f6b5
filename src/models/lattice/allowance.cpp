// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "lattice/allowance.h"

#include <algorithm>
#include <cstdlib>
#include <functional>
#include <tuple>

#include "field/cell_block.h"

namespace pliant {
namespace {

auto order_of(Vec3i c) {
    return std::tuple(c.z, c.y, c.x);
}

/// Distance of a difference from a link's limits [units]; ≤ 0 if it is within them.
Fixed excess(const HalfLimits& low, const HalfLimits& high, int b, int a, Fixed difference) {
    if (a != b) return std::abs(difference) - (low.shear[b] + high.shear[b]);
    return difference > 0 ? difference - (low.stretch[b] + high.stretch[b])
                          : -difference - (low.compress[b] + high.compress[b]);
}

Vec3i upper_end(Vec3i e, int b) {
    e[b] += 1;
    return e;
}

/// Whether the brick or one that its links lead to has changed since.
bool has_changed(const Lattice& lattice, Vec3i coord, std::uint64_t since) {
    for (int n = 0; n < 4; ++n) {
        const int index = lattice.find_brick(n == 0 ? coord : upper_end(coord, n - 1));
        // A missing brick is at rest: it has moved since the record was taken.
        if (index < 0 || lattice.brick(index).changed_at > since) return true;
    }
    return false;
}

}  // namespace

void Allowance::find_exceeding(const Lattice& lattice, Block& block) {
    CellBlock cells;
    cells.load(lattice, block.coord);
    const int found = lattice.find_brick(block.coord);
    const BrickEdits* edits = lattice.edits_of(block.coord);
    for (int n = 0; n < lattice.elements_per_brick(); ++n) {
        const Vec3i e = lattice.element_of(block.coord, n);
        const Vec3i local = e - cells.first_element();
        const int low = cells.index(local.x, local.y, local.z);
        for (int b = 0; b < 3; ++b) {
            const Vec3i up = upper_end(local, b);
            const int high = cells.index(up.x, up.y, up.z);
            const Vec3<Fixed> difference = cells.displacement(high) - cells.displacement(low);
            if (difference == Vec3<Fixed>{0, 0, 0}) continue;
            if (edits && ((*edits)[std::size_t(n)] & (kCutX << b))) continue;
            const MaterialTable& table = lattice.materials();
            const HalfLimits& own =
                table[found < 0 ? lattice.material_at(e) : lattice.brick(found).material[n]];
            const HalfLimits& other = table[lattice.material_at(upper_end(e, b))];
            for (int a = 0; a < 3; ++a)
                if (excess(own, other, b, a, difference[a]) > 0)
                    block.entries.push_back({std::uint32_t(9 * n + 3 * b + a), difference[a]});
        }
    }
}

void Allowance::shrink_block(const Lattice& lattice, Block& block) {
    std::erase_if(block.entries, [&](Entry& entry) {
        const int n = int(entry.code / 9), b = int(entry.code / 3 % 3), a = int(entry.code % 3);
        const Vec3i e = lattice.element_of(block.coord, n), f = upper_end(e, b);
        const Fixed difference = lattice.displacement_at(f)[a] - lattice.displacement_at(e)[a];
        const MaterialTable& table = lattice.materials();
        const HalfLimits& own = table[lattice.material_at(e)];
        const HalfLimits& other = table[lattice.material_at(f)];
        if (excess(own, other, b, a, difference) <= 0) return true;
        // Never larger than before: if a solver lets it grow, the check must report it.
        if (std::abs(difference) < std::abs(entry.difference)) entry.difference = difference;
        return false;
    });
}

void Allowance::excuse_present(Lattice& lattice, const TaskArena& arena) {
    std::vector<Block> blocks;
    for (const Vec3i& coord : cell_blocks(lattice)) blocks.push_back({coord, {}});
    arena.for_each(std::int64_t(blocks.size()), 4, [&](std::int64_t begin, std::int64_t end) {
        for (std::int64_t n = begin; n < end; ++n) find_exceeding(lattice, blocks[std::size_t(n)]);
    });
    std::erase_if(blocks, [](const Block& block) { return block.entries.empty(); });
    std::sort(blocks.begin(), blocks.end(),
              [](const Block& p, const Block& q) { return order_of(p.coord) < order_of(q.coord); });
    m_blocks = std::move(blocks);
    m_seen = lattice.clock();
    lattice.set_may_exceed_limits(!m_blocks.empty());
}

void Allowance::shrink(Lattice& lattice, const TaskArena& arena) {
    if (m_blocks.empty()) return;
    const auto shrink_some = [&](std::int64_t begin, std::int64_t end) {
        for (std::int64_t n = begin; n < end; ++n) {
            Block& block = m_blocks[std::size_t(n)];
            if (has_changed(lattice, block.coord, m_seen)) shrink_block(lattice, block);
        }
    };
    arena.for_each(std::int64_t(m_blocks.size()), 4, std::ref(shrink_some));
    std::erase_if(m_blocks, [](const Block& block) { return block.entries.empty(); });
    m_seen = lattice.clock();
    lattice.set_may_exceed_limits(!m_blocks.empty());
}

void Allowance::restore(Lattice& lattice, Allowance former) noexcept {
    *this = std::move(former);
    lattice.set_may_exceed_limits(!m_blocks.empty());
}

std::int64_t Allowance::size() const {
    std::int64_t count = 0;
    for (const Block& block : m_blocks) count += std::int64_t(block.entries.size());
    return count;
}

Fixed Allowance::excused(Vec3i brick_coord, int index, int b, int a) const {
    const auto block = std::lower_bound(
        m_blocks.begin(), m_blocks.end(), brick_coord,
        [](const Block& p, Vec3i coord) { return order_of(p.coord) < order_of(coord); });
    if (block == m_blocks.end() || block->coord != brick_coord) return 0;
    const auto code = std::uint32_t(9 * index + 3 * b + a);
    const auto entry =
        std::lower_bound(block->entries.begin(), block->entries.end(), code,
                         [](const Entry& e, std::uint32_t wanted) { return e.code < wanted; });
    return entry == block->entries.end() || entry->code != code ? 0 : entry->difference;
}

}  // namespace pliant
