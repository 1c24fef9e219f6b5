// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "fem/multigrid.h"

#include <algorithm>
#include <cmath>

#include "fem/hex_element.h"
#include "fem/multigrid_transfer.h"

namespace pliant {
namespace {

constexpr std::int64_t kLastNodes = 400;  ///< levels of this size are factored
constexpr int kDegree = 2;                ///< degree of the smoother's polynomial
constexpr double kUpperPart = 8;          ///< the spectrum above λ_max divided by this is smoothed
constexpr std::int64_t kGrain = 4096;

HexCorners box_corners(Vec3d h) {
    HexCorners corners;
    for (std::size_t c = 0; c < 8; ++c)
        corners[c] = {h.x * (kHexSigns[c][0] > 0), h.y * (kHexSigns[c][1] > 0),
                      h.z * (kHexSigns[c][2] > 0)};
    return corners;
}

/// Slight overestimate of the largest λ with K_e x = λ D_e x for one box, by power iteration.
double element_bound(Vec3d spacing, const ElasticMaterial& material) {
    constexpr int kIterations = 100;
    constexpr double kSafety = 1.05;
    const HexStiffness k =
        hex_stiffness(box_corners(spacing), lame_of(material), HexElement::Trilinear);
    std::array<double, 6> inverse[8];
    for (std::size_t c = 0; c < 8; ++c) {
        Block3 block;
        for (std::size_t i = 0; i < 3; ++i)
            for (std::size_t j = 0; j < 3; ++j) block[3 * i + j] = k[(3 * c + i) * 24 + 3 * c + j];
        inverse[c] = free_inverse(block, 0);
    }
    double x[24], bound = 0;
    for (int n = 0; n < 24; ++n) x[n] = std::sin(1.0 + 2.7 * n);
    for (int turn = 0; turn < kIterations; ++turn) {
        double y[24], z[24], most = 0;
        for (std::size_t i = 0; i < 24; ++i) {
            y[i] = 0;
            for (std::size_t j = 0; j < 24; ++j) y[i] += k[i * 24 + j] * x[j];
        }
        for (std::size_t c = 0; c < 8; ++c) {
            const Vec3d v = multiply(inverse[c], {y[3 * c], y[3 * c + 1], y[3 * c + 2]});
            for (int a = 0; a < 3; ++a) z[3 * c + std::size_t(a)] = v[a];
        }
        double zy = 0, xy = 0;  // z = D⁻¹K x: zᵀK x / xᵀK x is a lower bound of λ
        for (int n = 0; n < 24; ++n) {
            zy += z[n] * y[n];
            xy += x[n] * y[n];
            most = std::max(most, std::abs(z[n]));
        }
        bound = zy / xy;
        for (int n = 0; n < 24; ++n) x[n] = z[n] / most;
    }
    return kSafety * bound;
}

/// a += factor · b
void add_scaled(NodeVector& a, double factor, const NodeVector& b, const TaskArena& arena) {
    arena.for_each(a.node_count(), kGrain, [&](std::int64_t begin, std::int64_t end) {
        for (int axis = 0; axis < 3; ++axis) {
            double* const to = a.component(axis);
            const double* const from = b.component(axis);
            for (std::int64_t n = begin; n < end; ++n) to[n] += factor * from[n];
        }
    });
}

}  // namespace

double spectrum_bound(Vec3d spacing, std::span<const ElasticMaterial> materials) {
    double most = 0;
    for (const ElasticMaterial& m : materials) most = std::max(most, element_bound(spacing, m));
    return most;
}

struct Multigrid::Level {
    LatticePair pair;  ///< from the level above; not of the first level
    double greatest;   ///< bound of the spectrum
    const LatticeStiffness* stiffness;
    const HeldNodes* held;
    std::shared_ptr<const LatticeStiffness> own_stiffness{};
    std::unique_ptr<HeldNodes> own_held{};
    std::unique_ptr<BlockJacobi> blocks{};
};

Multigrid::~Multigrid() = default;

Multigrid::Multigrid(const LatticeStiffness& stiffness, const HeldNodes& held,
                     std::span<const ElasticMaterial> materials, const TaskArena& arena) {
    const HexLattice& first = stiffness.lattice();
    m_levels.push_back(std::make_unique<Level>(Level{{first, first, {1, 1, 1}},
                                                     spectrum_bound(first.spacing_mm, materials),
                                                     &stiffness,
                                                     &held}));
    m_levels.back()->blocks = std::make_unique<BlockJacobi>(stiffness, held, arena);
    for (;;) {
        const Level& above = *m_levels.back();
        const HexLattice& fine = above.pair.coarse;
        const Vec3i factor = coarsening_factor(fine);
        if (node_count(fine) <= kLastNodes || factor == Vec3i{1, 1, 1}) break;
        const LatticePair pair = coarsened(fine, factor);
        const auto cells = cell_count(fine);
        auto level = std::make_unique<Level>(
            Level{pair, spectrum_bound(pair.coarse.spacing_mm, materials), nullptr, nullptr});
        level->own_stiffness = std::make_shared<const LatticeStiffness>(
            pair.coarse, coarse_means(pair, above.stiffness->lambdas(cells)),
            coarse_means(pair, above.stiffness->mus(cells)));
        level->own_held = std::make_unique<HeldNodes>(coarse_held(pair, *above.held));
        level->stiffness = level->own_stiffness.get();
        level->held = level->own_held.get();
        level->blocks = std::make_unique<BlockJacobi>(*level->stiffness, *level->held, arena);
        m_levels.push_back(std::move(level));
    }
    assemble_last(arena);
    factor_last();
}

Multigrid::Multigrid(const Multigrid& other, const HeldNodes& held)
    : m_matrix(other.m_matrix), m_factor(other.m_factor) {
    for (const auto& old : other.m_levels) {
        auto level = std::make_unique<Level>(
            Level{old->pair, old->greatest, old->stiffness, &held, old->own_stiffness});
        if (!m_levels.empty()) {
            level->own_held =
                std::make_unique<HeldNodes>(coarse_held(level->pair, *m_levels.back()->held));
            level->held = level->own_held.get();
        }
        level->blocks = std::make_unique<BlockJacobi>(*old->blocks, *old->held, *level->stiffness,
                                                      *level->held);
        m_levels.push_back(std::move(level));
    }
    if (m_levels.back()->held->axes != other.m_levels.back()->held->axes) factor_last();
}

void Multigrid::assemble_last(const TaskArena& arena) {
    const Level& last = *m_levels.back();
    const HexLattice& lattice = last.pair.coarse;
    if (node_count(lattice) > kLastNodes) return;
    const auto cells = cell_count(lattice);
    const auto lambda = last.stiffness->lambdas(cells), mu = last.stiffness->mus(cells);
    ElasticSolid solid{hex_mesh(lattice), {}, {}};
    for (std::size_t c = 0; c < std::size_t(cells); ++c) {
        const double l = lambda[c], m = mu[c];
        solid.materials.push_back({m * (3 * l + 2 * m) / (l + m), l / (2 * (l + m))});
        solid.material_of.push_back(std::int32_t(c));
    }
    m_matrix = std::make_shared<const BlockMatrix>(solid, HexElement::Trilinear, arena);
}

/// Factors the last level. Without a factor (the level is large or singular) its smoother is used.
void Multigrid::factor_last() {
    m_factor.reset();
    if (!m_matrix) return;
    auto factor = CholeskyFactor::create(*m_matrix, *m_levels.back()->held);
    if (factor) m_factor = std::make_shared<const CholeskyFactor>(std::move(factor).value());
}

Multigrid::Work::Work(const Multigrid& multigrid) {
    for (const auto& level : multigrid.m_levels) {
        const NodeVector zero(node_count(level->pair.coarse));
        m_levels.push_back({zero, zero, zero, zero, zero});
    }
}

/// displacement += polynomial(D⁻¹K) D⁻¹ residual.
/// @param with_residual  updates the residual too
void Multigrid::smooth(std::size_t level, bool with_residual, Work::Level& w,
                       const TaskArena& arena) const {
    const Level& l = *m_levels[level];
    const double least = l.greatest / kUpperPart;
    const double middle = (l.greatest + least) / 2, half = (l.greatest - least) / 2;
    const double sigma = middle / half;
    double rho = 1 / sigma;
    for (int n = 0; n < kDegree; ++n) {
        if (n == 0) {
            l.blocks->renew(w.residual, 1 / middle, 0, w.step, arena);
        } else {
            const double next = 1 / (2 * sigma - rho);
            l.blocks->renew(w.residual, 2 * next / half, next * rho, w.step, arena);
            rho = next;
        }
        add_scaled(w.displacement, 1, w.step, arena);
        if (n + 1 == kDegree && !with_residual) break;
        l.stiffness->multiply(w.step, w.product, arena);
        l.held->clear(w.product);
        add_scaled(w.residual, -1, w.product, arena);
    }
}

/// Approximate solution for the level's force, from zero.
void Multigrid::cycle(std::size_t level, Work& work, const TaskArena& arena) const {
    Work::Level& w = work.m_levels[level];
    if (level + 1 == m_levels.size() && m_factor) {
        w.displacement = m_factor->solve(w.force);
        return;
    }
    w.displacement.clear();
    w.residual = w.force;
    smooth(level, true, w, arena);
    if (level + 1 < m_levels.size()) {
        const Level& below = *m_levels[level + 1];
        Work::Level& next = work.m_levels[level + 1];
        w.step.clear();
        gather_forces(below.pair, w.residual, next.force, arena);
        below.held->clear(next.force);
        cycle(level + 1, work, arena);
        add_interpolated(below.pair, next.displacement, w.step, arena);
        m_levels[level]->held->clear(w.step);
        add_scaled(w.displacement, 1, w.step, arena);
        m_levels[level]->stiffness->multiply(w.step, w.product, arena);
        m_levels[level]->held->clear(w.product);
        add_scaled(w.residual, -1, w.product, arena);
    }
    smooth(level, false, w, arena);
}

void Multigrid::apply(const NodeVector& force, NodeVector& displacement, Work& work,
                      const TaskArena& arena) const {
    work.m_levels[0].force = force;
    cycle(0, work, arena);
    displacement = work.m_levels[0].displacement;
}

std::int64_t Multigrid::bytes() const {
    std::int64_t sum = (m_matrix ? m_matrix->bytes() : 0) + (m_factor ? m_factor->bytes() : 0);
    for (const auto& level : m_levels)
        sum += level->blocks->bytes() + (level->own_stiffness ? level->own_stiffness->bytes() : 0);
    return sum;
}

}  // namespace pliant
