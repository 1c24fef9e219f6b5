// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "fem/multigrid_transfer.h"

#include <algorithm>
#include <limits>

namespace pliant {
namespace {

/// Range of the one or two related nodes of the other lattice along an axis.
struct Span {
    int first, last;
};

/// Fine nodes that coarse node i affects, clipped to the lattice.
Span moved_by(int i, int factor, int fine_size) {
    return {std::max(0, factor * (i - 1) + 1), std::min(fine_size - 1, factor * (i + 1) - 1)};
}
/// Coarse nodes that affect fine node i.
Span movers_of(int i, int factor) {
    return {i / factor, (i + factor - 1) / factor};
}
double weight(int fine, int coarse, int factor) {
    return fine == factor * coarse ? 1 : 0.5;
}

template <class Body>
void for_each_node(const HexLattice& lattice, const TaskArena& arena, Body&& body) {
    arena.for_each(lattice.size.z, 1, [&](std::int64_t begin, std::int64_t end) {
        for (int k = int(begin); k < int(end); ++k)
            for (int j = 0; j < lattice.size.y; ++j)
                for (int i = 0; i < lattice.size.x; ++i) body(Vec3i{i, j, k});
    });
}

template <class Body>
void for_each_in(Span x, Span y, Span z, Body&& body) {
    for (int k = z.first; k <= z.last; ++k)
        for (int j = y.first; j <= y.last; ++j)
            for (int i = x.first; i <= x.last; ++i) body(Vec3i{i, j, k});
}

double weight(Vec3i fine, Vec3i coarse, const LatticePair& pair) {
    const Vec3i f = pair.factor;
    return weight(fine.x, coarse.x, f.x) * weight(fine.y, coarse.y, f.y) *
           weight(fine.z + pair.fine_low, coarse.z + pair.coarse_low, f.z);
}

Span fine_planes(const LatticePair& pair, int coarse) {
    const int low = pair.fine_low;
    const Span whole = moved_by(coarse + pair.coarse_low, pair.factor.z, low + pair.fine.size.z);
    return {std::max(whole.first - low, 0), whole.last - low};
}
Span coarse_planes(const LatticePair& pair, int fine) {
    const Span whole = movers_of(fine + pair.fine_low, pair.factor.z);
    return {whole.first - pair.coarse_low, whole.last - pair.coarse_low};
}

}  // namespace

Vec3i coarsening_factor(const HexLattice& lattice) {
    constexpr double kAlike = 1.5;
    double least = std::numeric_limits<double>::max();
    for (int a = 0; a < 3; ++a)
        if (lattice.size[a] > 2) least = std::min(least, lattice.spacing_mm[a]);
    Vec3i factor{1, 1, 1};
    for (int a = 0; a < 3; ++a)
        if (lattice.size[a] > 2 && lattice.spacing_mm[a] < kAlike * least) factor[a] = 2;
    return factor;
}

LatticePair coarsened(const HexLattice& lattice, Vec3i factor) {
    LatticePair pair{lattice, lattice, factor};
    for (int a = 0; a < 3; ++a) {
        pair.coarse.size[a] = (lattice.size[a] - 1 + factor[a] - 1) / factor[a] + 1;
        pair.coarse.spacing_mm[a] *= factor[a];
    }
    return pair;
}

std::vector<double> coarse_means(const LatticePair& pair, std::span<const double> fine) {
    const Vec3i cells = pair.fine.size - Vec3i{1, 1, 1}, f = pair.factor;
    std::vector<double> means(std::size_t(cell_count(pair.coarse)), 0);
    const double share = 1.0 / (f.x * f.y * f.z);
    for_each_in({0, cells.x - 1}, {0, cells.y - 1}, {0, cells.z - 1}, [&](Vec3i c) {
        means[std::size_t(cell_index(pair.coarse, {c.x / f.x, c.y / f.y, c.z / f.z}))] +=
            share * fine[std::size_t(cell_index(pair.fine, c))];
    });
    return means;
}

HeldNodes coarse_held(const LatticePair& pair, const HeldNodes& fine) {
    const auto nodes = node_count(pair.coarse);
    HeldNodes held{std::vector<std::uint8_t>(std::size_t(nodes), 0), NodeVector(nodes), {}};
    const Vec3i n = pair.fine.size, f = pair.factor;
    for (const std::int32_t node : fine.nodes) {
        const Vec3i at{node % n.x, node / n.x % n.y, node / n.x / n.y};
        for_each_in(movers_of(at.x, f.x), movers_of(at.y, f.y), movers_of(at.z, f.z), [&](Vec3i c) {
            auto& axes = held.axes[std::size_t(node_index(pair.coarse, c))];
            axes = std::uint8_t(axes | fine.axes[std::size_t(node)]);
        });
    }
    for (std::size_t c = 0; c < held.axes.size(); ++c)
        if (held.axes[c]) held.nodes.push_back(std::int32_t(c));
    return held;
}

void gather_forces(const LatticePair& pair, const NodeVector& fine, NodeVector& coarse,
                   const TaskArena& arena) {
    const Vec3i n = pair.fine.size, f = pair.factor;
    for_each_node(pair.coarse, arena, [&](Vec3i c) {
        Vec3d sum{0, 0, 0};
        for_each_in(
            moved_by(c.x, f.x, n.x), moved_by(c.y, f.y, n.y), fine_planes(pair, c.z), [&](Vec3i p) {
                sum = sum + weight(p, c, pair) * fine.at(std::size_t(node_index(pair.fine, p)));
            });
        coarse.set(std::size_t(node_index(pair.coarse, c)), sum);
    });
}

void add_interpolated(const LatticePair& pair, const NodeVector& coarse, NodeVector& fine,
                      const TaskArena& arena) {
    const Vec3i f = pair.factor;
    for_each_node(pair.fine, arena, [&](Vec3i p) {
        const auto node = std::size_t(node_index(pair.fine, p));
        Vec3d sum{0, 0, 0};
        for_each_in(
            movers_of(p.x, f.x), movers_of(p.y, f.y), coarse_planes(pair, p.z), [&](Vec3i c) {
                sum = sum + weight(p, c, pair) * coarse.at(std::size_t(node_index(pair.coarse, c)));
            });
        fine.set(node, fine.at(node) + sum);
    });
}

}  // namespace pliant
