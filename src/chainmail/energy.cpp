// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "chainmail/energy.h"

#include <algorithm>
#include <mutex>
#include <vector>

#include "chainmail/relax_links.h"

namespace pliant {
namespace {

/// Elastic parts of one brick's elements, by component; zero where there is no brick.
struct ElasticBrick {
    std::array<std::vector<Fixed>, 3> e;
    bool is_moved = false;

    void load(const Lattice& lattice, const PlasticRest& rest, Vec3i coord) {
        const auto count = std::size_t(lattice.elements_per_brick());
        const int index = lattice.find_brick(coord);
        const PlasticBrick* imprint = rest.find(coord);
        is_moved = index >= 0 || imprint;
        for (std::size_t a = 0; a < 3; ++a) {
            e[a].assign(count, 0);
            if (index >= 0) std::copy_n(lattice.brick(index).u[a], count, e[a].begin());
            if (!imprint) continue;
            for (std::size_t n = 0; n < count; ++n) e[a][n] -= imprint->imprint[a][n];
        }
    }
};

Energy energy_of_link(const ElasticBrick& low, std::size_t n, const ElasticBrick& high,
                      std::size_t m, std::uint16_t weight) {
    Energy sum = 0;
    for (std::size_t a = 0; a < 3; ++a) {
        const std::int64_t d = std::int64_t(high.e[a][m]) - low.e[a][n];
        sum += Energy(std::uint64_t(d * d)) * weight;
    }
    return sum;
}

/// Of the links inside a brick, those to the bricks above it, and those to bricks below that are
/// not there themselves.
Energy energy_of_brick(const Lattice& lattice, const PlasticRest& rest, const Brick& brick,
                       const BrickLinks& links) {
    ElasticBrick own, beside;
    own.load(lattice, rest, brick.coord);
    const int size = lattice.brick_size();
    Energy sum = 0;
    for (int b = 0; b < 3; ++b) {
        const auto& weights = links.weight[std::size_t(b)];
        const Vec3i strides = link_strides(size, b);
        const auto& low_face = lattice.face(b, false);
        const auto& high_face = lattice.face(b, true);
        const int stride = lattice.stride(b);
        const auto weight_below = [&](int n) {
            return weights[std::size_t(dot(lattice.element_of({0, 0, 0}, n), strides))];
        };
        for (const int first : low_face)
            for (int n = first + stride; n < first + size * stride; n += stride)
                sum += energy_of_link(own, std::size_t(n - stride), own, std::size_t(n),
                                      weight_below(n));
        Vec3i coord = brick.coord;
        coord[b] += 1;
        beside.load(lattice, rest, coord);
        for (std::size_t f = 0; f < high_face.size(); ++f) {
            const Vec3i local = lattice.element_of({0, 0, 0}, high_face[f]);
            sum += energy_of_link(own, std::size_t(high_face[f]), beside, std::size_t(low_face[f]),
                                  weights[std::size_t(dot(local, strides) + strides[b])]);
        }
        if (brick.neighbours[std::size_t(2 * b)] >= 0) continue;
        coord[b] -= 2;
        beside.load(lattice, rest, coord);
        for (std::size_t f = 0; f < low_face.size(); ++f)
            sum += energy_of_link(beside, std::size_t(high_face[f]), own, std::size_t(low_face[f]),
                                  weight_below(low_face[f]));
    }
    return sum;
}

}  // namespace

Energy elastic_energy(const Lattice& lattice, const PlasticRest& rest, const TaskArena& arena) {
    const std::vector<int> bricks = lattice.resident_bricks();
    BrickLinksMaker maker(lattice);
    Energy total = 0;
    std::mutex mutex;
    arena.for_each(std::int64_t(bricks.size()), 8, [&](std::int64_t begin, std::int64_t end) {
        Energy own = 0;
        for (std::int64_t n = begin; n < end; ++n) {
            const Brick& brick = lattice.brick(bricks[std::size_t(n)]);
            own += energy_of_brick(lattice, rest, brick, *maker.make(brick));
        }
        const std::lock_guard lock(mutex);
        total += own;  // whole numbers: in any order
    });
    return total;
}

}  // namespace pliant
