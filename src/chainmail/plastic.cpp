// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "chainmail/plastic.h"

#include <algorithm>
#include <utility>

namespace pliant {

const PlasticBrick* PlasticRest::find(Vec3i brick_coord) const {
    if (m_bricks.empty()) return nullptr;
    const auto found = m_bricks.find(brick_coord);
    return found == m_bricks.end() ? nullptr : &found->second;
}

Vec3<Fixed> PlasticRest::imprint_at(const Lattice& lattice, Vec3i ijk) const {
    const PlasticBrick* brick = find(lattice.brick_of(ijk));
    if (!brick) return {0, 0, 0};
    const auto n = std::size_t(lattice.index_in_brick(ijk));
    return {brick->imprint[0][n], brick->imprint[1][n], brick->imprint[2][n]};
}

void PlasticRest::set(const Lattice& lattice, Vec3i brick_coord,
                      std::array<std::vector<Fixed>, 3> imprint) {
    const bool any = std::any_of(imprint.begin(), imprint.end(), [](const auto& component) {
        return std::any_of(component.begin(), component.end(), [](Fixed p) { return p != 0; });
    });
    m_formers.try_emplace(brick_coord,
                          replace(lattice, brick_coord, any ? std::move(imprint) : Imprint{}));
}

PlasticRest::Imprint PlasticRest::replace(const Lattice& lattice, Vec3i brick_coord,
                                          Imprint imprint) {
    ++m_version;
    Imprint former;
    if (const auto found = m_bricks.find(brick_coord); found != m_bricks.end()) {
        former = std::move(found->second.imprint);
        m_bricks.erase(found);
    }
    if (!imprint[0].empty()) m_bricks[brick_coord] = {std::move(imprint), lattice.clock()};
    return former;
}

void PlasticRest::clear() {
    for (auto& [coord, brick] : m_bricks) m_formers.try_emplace(coord, std::move(brick.imprint));
    m_bricks.clear();
    ++m_version;
}

void PlasticRest::forget_void(const Lattice& lattice, std::span<const Vec3i> coords) {
    for (const Vec3i& coord : coords) {
        const PlasticBrick* brick = find(coord);
        const BrickEdits* edits = lattice.edits_of(coord);
        if (!brick || !edits) continue;
        Imprint left = brick->imprint;
        for (auto& component : left)
            for (std::size_t n = 0; n < component.size(); ++n)
                if ((*edits)[n] & kVoid) component[n] = 0;
        if (left != brick->imprint) set(lattice, coord, std::move(left));
    }
}

std::vector<PlasticRest::Former> PlasticRest::take_changes() {
    std::vector<Former> changes;
    for (auto& [coord, former] : m_formers) {
        const PlasticBrick* now = find(coord);
        if (now ? now->imprint != former : !former[0].empty())
            changes.push_back({coord, std::move(former)});
    }
    m_formers.clear();
    return changes;
}

void PlasticRest::exchange(const Lattice& lattice, std::vector<Former>& formers) {
    for (Former& former : formers)
        former.imprint = replace(lattice, former.coord, std::move(former.imprint));
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
