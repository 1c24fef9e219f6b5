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

struct Multigrid::Level {
    LatticePair pair;  ///< from the level above; not of the first level
    Slabs slabs;
    double greatest;  ///< bound of the spectrum
    const LatticeStiffness* stiffness;
    const HeldNodes* held;
    std::unique_ptr<LatticeStiffness> own_stiffness{};
    std::unique_ptr<HeldNodes> own_held{};
    std::unique_ptr<BlockJacobi> blocks{};
};

/// Levels that every rank has as a whole.
struct Multigrid::Rest {
    Slabs slabs;       ///< of the forces, before they are gathered
    LatticePair down;  ///< from the slab above to a slab
    LatticePair up;    ///< from the whole to the slab above
    std::unique_ptr<LatticeStiffness> stiffness;
    std::unique_ptr<HeldNodes> held;
    std::unique_ptr<Multigrid> multigrid;
};

Multigrid::~Multigrid() = default;

Multigrid::Multigrid(const LatticeStiffness& stiffness, const HeldNodes& held,
                     std::span<const ElasticMaterial> materials, const TaskArena& arena)
    : Multigrid({stiffness, held, Slabs(stiffness.lattice(), nullptr), stiffness, held}, materials,
                arena) {}

Multigrid::Multigrid(const Parts& parts, std::span<const ElasticMaterial> materials,
                     const TaskArena& arena) {
    const auto bound = [&](Vec3d spacing) {
        double most = 0;
        for (const ElasticMaterial& m : materials) most = std::max(most, element_bound(spacing, m));
        return most;
    };
    const HexLattice local = parts.slabs.local();
    m_levels.push_back(std::make_unique<Level>(Level{{local, local, {1, 1, 1}},
                                                     parts.slabs,
                                                     bound(local.spacing_mm),
                                                     &parts.stiffness,
                                                     &parts.held}));
    // Planes at a slab's end lack the cells beyond, so their blocks come from the whole stiffness.
    const auto add_blocks = [&](Level& level, const LatticeStiffness& stiffness) {
        const auto first = std::int64_t(level.slabs.plane()) * level.slabs.low();
        level.blocks = std::make_unique<BlockJacobi>(stiffness, *level.held, arena, first);
    };
    add_blocks(*m_levels.back(), parts.whole);
    const LatticeStiffness* whole = &parts.whole;  // of the last level
    const HeldNodes* whole_held = &parts.whole_held;
    std::unique_ptr<LatticeStiffness> kept;  // both, if the level has a slab
    std::unique_ptr<HeldNodes> kept_held;
    for (;;) {
        const Level& above = *m_levels.back();
        const HexLattice& fine = above.slabs.whole();
        const Vec3i factor = coarsening_factor(fine);
        if (node_count(fine) <= kLastNodes || factor == Vec3i{1, 1, 1}) break;
        const LatticePair pair = coarsened(fine, factor);
        const auto cells = cell_count(fine);
        auto stiffness = std::make_unique<LatticeStiffness>(
            pair.coarse, coarse_means(pair, whole->lambdas(cells)),
            coarse_means(pair, whole->mus(cells)));
        auto held = std::make_unique<HeldNodes>(coarse_held(pair, *whole_held));
        const Slabs slabs = above.slabs.coarse(pair.coarse, factor);
        const LatticePair down{above.slabs.local(), slabs.local(), factor, above.slabs.low(),
                               slabs.low()};
        if (!slabs.is_whole() && !slabs.are_thick()) {
            const LatticePair up{down.fine, pair.coarse, factor, down.fine_low, 0};
            auto multigrid = std::make_unique<Multigrid>(*stiffness, *held, materials, arena);
            m_rest.reset(new Rest{slabs, down, up, std::move(stiffness), std::move(held),
                                  std::move(multigrid)});
            break;
        }
        auto level = std::make_unique<Level>(
            Level{down, slabs, bound(pair.coarse.spacing_mm), nullptr, nullptr});
        whole = stiffness.get();
        whole_held = held.get();
        if (slabs.is_whole()) {
            level->own_stiffness = std::move(stiffness);
            level->own_held = std::move(held);
        } else {
            level->own_stiffness =
                std::make_unique<LatticeStiffness>(stiffness->slab(slabs.local(), slabs.low()));
            level->own_held = std::make_unique<HeldNodes>(slabs.local_held(*held));
            kept = std::move(stiffness);
            kept_held = std::move(held);
        }
        level->stiffness = level->own_stiffness.get();
        level->held = level->own_held.get();
        add_blocks(*level, *whole);
        m_levels.push_back(std::move(level));
    }
    if (!m_rest) factor_last(arena);
}

/// Factors the last level. Without a factor (the level is large or singular) its smoother is used.
void Multigrid::factor_last(const TaskArena& arena) {
    const Level& last = *m_levels.back();
    const HexLattice& lattice = last.pair.coarse;  // without slabs
    if (node_count(lattice) > kLastNodes) return;
    const auto cells = cell_count(lattice);
    const auto lambda = last.stiffness->lambdas(cells), mu = last.stiffness->mus(cells);
    ElasticSolid solid{hex_mesh(lattice), {}, {}};
    for (std::size_t c = 0; c < std::size_t(cells); ++c) {
        const double l = lambda[c], m = mu[c];
        solid.materials.push_back({m * (3 * l + 2 * m) / (l + m), l / (2 * (l + m))});
        solid.material_of.push_back(std::int32_t(c));
    }
    auto factor =
        CholeskyFactor::create(BlockMatrix(solid, HexElement::Trilinear, arena), *last.held);
    if (factor) m_factor.emplace(std::move(factor).value());
}

Multigrid::Work::Work(const Multigrid& multigrid) {
    for (const auto& level : multigrid.m_levels) {
        const NodeVector zero(node_count(level->pair.coarse));
        m_levels.push_back({zero, zero, zero, zero, zero});
    }
    if (!multigrid.m_rest) return;
    m_slab_force = std::make_unique<NodeVector>(node_count(multigrid.m_rest->down.coarse));
    m_rest = std::make_unique<Work>(*multigrid.m_rest->multigrid);
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
        l.slabs.exchange(w.residual);
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
    m_levels[level]->slabs.exchange(w.residual);
    smooth(level, true, w, arena);
    if (level + 1 < m_levels.size() || m_rest) {
        w.step.clear();
        if (level + 1 < m_levels.size()) {
            const Level& below = *m_levels[level + 1];
            Work::Level& next = work.m_levels[level + 1];
            gather_forces(below.pair, w.residual, next.force, arena);
            below.held->clear(next.force);
            cycle(level + 1, work, arena);
            add_interpolated(below.pair, next.displacement, w.step, arena);
        } else {
            solve_rest(w.residual, w.step, work, arena);
        }
        m_levels[level]->held->clear(w.step);
        add_scaled(w.displacement, 1, w.step, arena);
        m_levels[level]->stiffness->multiply(w.step, w.product, arena);
        m_levels[level]->held->clear(w.product);
        add_scaled(w.residual, -1, w.product, arena);
        m_levels[level]->slabs.exchange(w.residual);
    }
    smooth(level, false, w, arena);
}

void Multigrid::solve_rest(const NodeVector& residual, NodeVector& step, Work& work,
                           const TaskArena& arena) const {
    gather_forces(m_rest->down, residual, *work.m_slab_force, arena);
    NodeVector force = m_rest->slabs.gather(*work.m_slab_force), displacement = force;
    m_rest->held->clear(force);
    m_rest->multigrid->apply(force, displacement, *work.m_rest, arena);
    add_interpolated(m_rest->up, displacement, step, arena);
}

void Multigrid::apply(const NodeVector& force, NodeVector& displacement, Work& work,
                      const TaskArena& arena) const {
    work.m_levels[0].force = force;
    cycle(0, work, arena);
    displacement = work.m_levels[0].displacement;
}

std::int64_t Multigrid::bytes() const {
    std::int64_t sum = m_factor ? m_factor->bytes() : 0;
    for (const auto& level : m_levels)
        sum += level->blocks->bytes() + (level->own_stiffness ? level->own_stiffness->bytes() : 0);
    if (m_rest) sum += m_rest->stiffness->bytes() + m_rest->multigrid->bytes();
    return sum;
}

}  // namespace pliant
