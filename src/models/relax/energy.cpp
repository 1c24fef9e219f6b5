// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "relax/energy.h"

#include <algorithm>
#include <mutex>
#include <vector>

#include "relax/relax_links.h"

namespace pliant {
namespace {

/// Elastic parts of one brick's elements, by component; zero where there is no brick. Without
/// imprints they are the displacements, which are not copied.
class ElasticBrick {
  public:
    void load(const Lattice& lattice, const PlasticRest& rest, Vec3i coord) {
        const auto count = std::size_t(lattice.elements_per_brick());
        const int index = lattice.find_brick(coord);
        const PlasticBrick* imprint = rest.find(coord);
        for (std::size_t a = 0; a < 3; ++a) {
            if (index >= 0 && !imprint) {
                e[a] = lattice.brick(index).u[a];
                continue;
            }
            m_own[a].assign(count, 0);
            if (index >= 0) std::copy_n(lattice.brick(index).u[a], count, m_own[a].begin());
            if (imprint)
                for (std::size_t n = 0; n < count; ++n) m_own[a][n] -= imprint->imprint[a][n];
            e[a] = m_own[a].data();
        }
    }

    std::array<const Fixed*, 3> e{};

  private:
    std::array<std::vector<Fixed>, 3> m_own;
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

/// Energy of the links inside a brick, of those to the bricks above it, and of those to missing
/// bricks below it.
Energy energy_of_brick(const Lattice& lattice, const PlasticRest& rest, const Brick& brick,
                       const BrickLinks& links) {
    static thread_local ElasticBrick own, above, below;
    own.load(lattice, rest, brick.coord);
    const int size = lattice.brick_size();
    Energy sum = 0;
    for (int b = 0; b < 3; ++b) {
        const auto& weights = links.weight[std::size_t(b)];
        const Vec3i strides = link_strides(size, b);
        const auto& low_face = lattice.face(b, false);
        const auto& high_face = lattice.face(b, true);
        const int stride = lattice.stride(b);
        Vec3i coord = brick.coord;
        coord[b] += 1;
        above.load(lattice, rest, coord);
        coord[b] -= 2;
        const bool is_lowest = brick.neighbours[std::size_t(2 * b)] < 0;
        if (is_lowest) below.load(lattice, rest, coord);
        for (std::size_t f = 0; f < low_face.size(); ++f) {
            // Links of one line of elements, from the one below it on.
            const int i = int(f) % size, j = int(f) / size;
            const int link = i * strides[(b + 1) % 3] + j * strides[(b + 2) % 3];
            const auto weight = [&](int layer) {
                return weights[std::size_t(link + layer * strides[b])];
            };
            const auto low = std::size_t(low_face[f]), high = std::size_t(high_face[f]);
            if (is_lowest) sum += energy_of_link(below, high, own, low, weight(0));
            for (int layer = 1; layer < size; ++layer) {
                const std::size_t n = low + std::size_t(layer * stride);
                sum += energy_of_link(own, n - std::size_t(stride), own, n, weight(layer));
            }
            sum += energy_of_link(own, high, above, low, weight(size));
        }
    }
    return sum;
}

/// Σ of share(brick index, maker) over all bricks, in whole numbers: exact in any order.
template <class Share>
Energy sum_over_bricks(const Lattice& lattice, const TaskArena& arena, const Share& share) {
    const std::vector<int> bricks = lattice.resident_bricks();
    BrickLinksMaker maker(lattice);
    Energy total = 0;
    std::mutex mutex;
    arena.for_each(std::int64_t(bricks.size()), 8, [&](std::int64_t begin, std::int64_t end) {
        Energy own = 0;
        for (std::int64_t n = begin; n < end; ++n) own += share(bricks[std::size_t(n)], maker);
        const std::lock_guard lock(mutex);
        total += own;
    });
    return total;
}

}  // namespace

Energy elastic_energy(const Lattice& lattice, const PlasticRest& rest, const TaskArena& arena) {
    return sum_over_bricks(lattice, arena, [&](int index, BrickLinksMaker& maker) {
        const Brick& brick = lattice.brick(index);
        return energy_of_brick(lattice, rest, brick, *maker.make_weights(brick));
    });
}

EnergyMemory::Stamps EnergyMemory::stamps_of(const Lattice& lattice, const Brick& brick) {
    Stamps stamps{brick.changed_at + 1};
    for (std::size_t side = 0; side < 6; ++side)
        if (const int there = brick.neighbours[side]; there >= 0)
            stamps[1 + side] = lattice.brick(there).changed_at + 1;
    return stamps;
}

Energy EnergyMemory::of(const Lattice& lattice, const PlasticRest& rest, const TaskArena& arena) {
    if (m_links_version != lattice.links_version() || m_rest_version != rest.version())
        m_shares.clear();
    m_links_version = lattice.links_version();
    m_rest_version = rest.version();
    m_shares.resize(std::size_t(lattice.brick_index_bound()));
    return sum_over_bricks(lattice, arena, [&](int index, BrickLinksMaker& maker) {
        const Brick& brick = lattice.brick(index);
        Share& share = m_shares[std::size_t(index)];
        const Stamps stamps = stamps_of(lattice, brick);
        if (share.stamps != stamps || share.coord != brick.coord)
            share = {brick.coord, stamps,
                     energy_of_brick(lattice, rest, brick, *maker.make_weights(brick))};
        return share.energy;
    });
}

}  // namespace pliant
