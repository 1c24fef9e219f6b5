// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "relax/plastic.h"

#include <algorithm>
#include <utility>

namespace pliant {
namespace {

bool is_zero(const Imprint& imprint) {
    return std::all_of(imprint.begin(), imprint.end(), [](const auto& component) {
        return std::all_of(component.begin(), component.end(), [](Fixed p) { return p == 0; });
    });
}

}  // namespace

const PlasticBrick* PlasticRest::find(Vec3i brick_coord) const {
    if (m_bricks.empty()) return nullptr;
    const auto found = m_bricks.find(brick_coord);
    const bool none = found == m_bricks.end() || found->second.imprint[0].empty();
    return none ? nullptr : &found->second;
}

Vec3<Fixed> PlasticRest::imprint_at(const Lattice& lattice, Vec3i ijk) const {
    const PlasticBrick* brick = find(lattice.brick_of(ijk));
    if (!brick) return {0, 0, 0};
    const auto n = std::size_t(lattice.index_in_brick(ijk));
    return {brick->imprint[0][n], brick->imprint[1][n], brick->imprint[2][n]};
}

void PlasticRest::set(const Lattice& lattice, Vec3i brick_coord, Imprint imprint) {
    ++m_version;
    if (is_zero(imprint))
        m_bricks.erase(brick_coord);
    else
        m_bricks[brick_coord] = {std::move(imprint), lattice.clock()};
}

void PlasticRest::prepare(const Lattice& lattice, const ImprintMap& imprints) {
    try {
        for (const auto& [coord, brick] : imprints) {
            lattice.before_imprint(coord, find(coord));
            m_bricks.try_emplace(coord);
        }
    } catch (...) {
        finish(imprints);
        throw;
    }
}

void PlasticRest::exchange(const Lattice& lattice, ImprintMap& imprints) noexcept {
    for (auto& [coord, brick] : imprints) {
        if (is_zero(brick.imprint)) brick.imprint = {};
        brick.changed_at = lattice.clock();
        std::swap(m_bricks.find(coord)->second, brick);
        ++m_version;
    }
}

void PlasticRest::finish(const ImprintMap& imprints) noexcept {
    for (const auto& [coord, brick] : imprints)
        if (const auto own = m_bricks.find(coord);
            own != m_bricks.end() && own->second.imprint[0].empty())
            m_bricks.erase(own);
}

void PlasticRest::restore(const Lattice& lattice, ImprintMap& saved) noexcept {
    while (!saved.empty()) {
        // Nodes move between the maps, and room for them is reserved.
        auto node = saved.extract(saved.begin());
        const PlasticBrick* now = find(node.key());
        const Imprint& former = node.mapped().imprint;
        if (now ? now->imprint == former : former[0].empty()) continue;
        m_bricks.erase(node.key());
        node.mapped().changed_at = lattice.clock();
        if (!former[0].empty()) m_bricks.insert(std::move(node));
        ++m_version;
    }
}

void PlasticRest::clear() noexcept {
    m_bricks.clear();
    ++m_version;
}

std::size_t PlasticRest::bytes() const {
    std::size_t bytes = 0;
    for (const auto& [coord, brick] : m_bricks)
        bytes += sizeof coord + sizeof brick + 3 * brick.imprint[0].size() * sizeof(Fixed);
    return bytes;
}

PlasticPull pull_of(const Lattice& lattice, const Brick& brick, const BrickLinks& links,
                    const PlasticRest& rest) {
    PlasticPull pull{rest.version(), {}};
    if (rest.empty()) return pull;
    const PlasticBrick* own = rest.find(brick.coord);
    std::array<const PlasticBrick*, 6> beside{};
    bool any = own != nullptr;
    for (int side = 0; side < 6; ++side) {
        Vec3i coord = brick.coord;
        coord[side / 2] += side % 2 ? 1 : -1;
        beside[std::size_t(side)] = rest.find(coord);
        any |= beside[std::size_t(side)] != nullptr;
    }
    if (!any) return pull;
    const auto count = std::size_t(lattice.elements_per_brick());
    for (auto& force : pull.force) force.assign(count, 0);
    const int size = lattice.brick_size();
    for (int n = 0; n < int(count); ++n) {
        const Vec3i local = lattice.element_of({0, 0, 0}, n);
        for (int side = 0; side < 6; ++side) {
            const int b = side / 2, step = (side % 2 ? 1 : -1) * lattice.stride(b);
            const bool leaves = local[b] == (side % 2 ? size - 1 : 0);
            const PlasticBrick* there = leaves ? beside[std::size_t(side)] : own;
            const auto there_index = std::size_t(leaves ? n - step * (size - 1) : n + step);
            const Vec3i strides = link_strides(size, b);
            const int link = dot(local, strides) + (side % 2 ? strides[b] : 0);
            const double weight = links.weight[std::size_t(b)][std::size_t(link)];
            for (std::size_t a = 0; a < 3; ++a) {
                const double p = own ? own->imprint[a][std::size_t(n)] : 0;
                const double q = there ? there->imprint[a][there_index] : 0;
                pull.force[a][std::size_t(n)] += weight * (p - q);
            }
        }
    }
    return pull;
}

}  // namespace pliant
