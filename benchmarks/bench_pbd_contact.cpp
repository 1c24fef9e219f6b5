// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Contact of a rod with the ghost surface of a vessel with a quarter bend and a fixed wall. The
// time is that of the whole step: rod, search in the grid, and projections. The reference makes the
// rod's step, and tests the box of each segment with that of every triangle, the minimum of a
// search without a grid; it projects nothing.
//
// Contact of five solids on each other, into which a sphere is pushed; the reference is the body's
// step without contact.

#include <pliant/models/body_contact.h>
#include <pliant/models/pbd.h>
#include <pliant/models/vessel.h>
#include <pliant/research/rod.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numbers>
#include <vector>

#include "interleaved.h"

namespace pliant::bench {
namespace {

constexpr double kRadius = 0.5, kReach = 0.5, kContactStep = 2e-4;

VesselWall quarter(int sectors) {
    std::vector<CentrePoint> way;
    for (int n = -2; n < 32; ++n) way.push_back({{0, 0, 2.0 * n}, 3});
    for (int n = 0; n <= 24; ++n) {
        const double angle = std::numbers::pi / 2 * n / 24;
        way.push_back({{30 * (1 - std::cos(angle)), 0, 64 + 30 * std::sin(angle)}, 3});
    }
    for (int n = 1; n < 10; ++n) way.push_back({{30 + 2.0 * n, 0, 94}, 3});
    auto wall = swept_tube(way, {.thickness_mm = 1, .layers = 1, .sectors = sectors});
    if (!wall) std::abort();
    return std::move(*wall);
}

struct Box {
    Vec3d low, high;
    explicit Box(Vec3d a) : low(a), high(a) {}
    void add(Vec3d p) {
        for (int c = 0; c < 3; ++c) {
            low[c] = std::min(low[c], p[c]);
            high[c] = std::max(high[c], p[c]);
        }
    }
};

class RodInTube {
  public:
    explicit RodInTube(const VesselWall& wall)
        : m_wall(wall), m_rod(make_rod()), m_body(make_body(wall)), m_contact(make_contact(wall)) {}

    /// Pushed round the bend.
    bool with_contact(const TaskArena& arena) {
        push();
        return m_contact.step(1, m_rod, m_body, arena).ok();
    }
    /// Copies the state of the other: measures the search only, not the way to this state.
    std::int64_t without_grid(const RodInTube& other, const TaskArena& arena) {
        push();
        if (!m_rod.step(1).ok() || !m_body.step(1, arena).ok()) std::abort();
        std::int64_t near = 0;
        for (int s = 0; s < m_rod.settings().segments; ++s) {
            Box box(other.m_rod.position(s));
            box.add(other.m_rod.position(s + 1));
            for (const auto& cell : m_wall.ghost.cells) {
                Box triangle(m_wall.ghost.nodes_mm[std::size_t(cell[0])]);
                for (const std::size_t k : {1u, 2u})
                    triangle.add(m_wall.ghost.nodes_mm[std::size_t(cell[k])]);
                bool apart = false;
                for (int c = 0; c < 3; ++c)
                    apart |= triangle.low[c] > box.high[c] + kRadius + kReach ||
                             triangle.high[c] < box.low[c] - kRadius - kReach;
                near += !apart;
            }
        }
        return near;
    }
    int segments() const { return m_rod.settings().segments; }
    std::size_t touches() const { return m_contact.touches().size(); }

  private:
    static Rod make_rod() {
        auto rod = Rod::create({.segments = 30,
                                .length = 60,
                                .mass = 0.06,
                                .bend_stiffness = 1e6,
                                .twist_stiffness = 1e6,
                                .stretch_stiffness = 1e7,
                                .shear_stiffness = 1e7,
                                .time_step = kContactStep,
                                .damping = 20});
        if (!rod) std::abort();
        return std::move(*rod);
    }
    static PbdBody make_body(const VesselWall& wall) {
        PbdParts parts;
        parts.positions = wall.mesh.nodes_mm;
        parts.inverse_masses.assign(parts.positions.size(), 0);
        auto body = PbdBody::create(std::move(parts), {.time_step = kContactStep, .sub_steps = 1});
        if (!body) std::abort();
        return std::move(*body);
    }
    static RodContact make_contact(const VesselWall& wall) {
        auto contact = RodContact::create(wall.mesh, wall.ghost, wall.ghost_positions,
                                          {.radius = kRadius, .friction = 0.1});
        if (!contact) std::abort();
        return std::move(*contact);
    }
    void push() {
        m_fed = std::min(m_fed + 0.08, 45.0);
        if (!m_rod.set_base({0, 0, m_fed}, Rotation{}).ok()) std::abort();
    }

    const VesselWall& m_wall;
    Rod m_rod;
    PbdBody m_body;
    RodContact m_contact;
    double m_fed = 0;
};

/// One item is a segment. Argument: sectors of the wall around; the number of triangles grows with
/// its square.
void pbd_contact(benchmark::State& state) {
    const TaskArena arena(1);
    const VesselWall wall = quarter(int(state.range(0)));
    RodInTube subject(wall), reference(wall);
    for (int n = 0; n < 600; ++n)
        if (!subject.with_contact(arena)) state.SkipWithError("unstable");
    std::int64_t near = 0;
    const auto turns = run_interleaved(
        state, "every segment's box with every triangle's", [] {},
        [&] {
            if (!subject.with_contact(arena)) state.SkipWithError("unstable");
        },
        [&] { near = reference.without_grid(subject, arena); });
    turns.count(subject.segments());
    state.counters["triangles"] = double(wall.ghost.cells.size());
    state.counters["near_pairs"] = double(near);
    state.counters["touches"] = double(subject.touches());
}
BENCHMARK(pbd_contact)
    ->ArgName("sectors")
    ->Arg(12)
    ->Arg(24)
    ->Arg(48)
    ->Iterations(51)
    ->UseManualTime()
    ->Unit(benchmark::kMicrosecond);

/// Five blocks on each other, 60,000 tetrahedra, whose surfaces coincide.
class FiveBlocks {
  public:
    FiveBlocks() : m_body(make_body(m_mesh)), m_contact(make_contact(m_mesh)) {}

    bool with_contact(const TaskArena& arena) {
        const auto at = [&](int n) {
            const Vec3d p{16, 15, 104.1 - 0.02 * n};
            return BodyTool{p, p, 4};
        };
        const BodyTool from = at(m_step), to = at(m_step + 1);
        ++m_step;
        return m_contact.step(1, m_body, {&from, 1}, {&to, 1}, arena).ok();
    }
    bool alone(const TaskArena& arena) { return m_body.step(1, arena).ok(); }
    std::int64_t touches() const { return m_contact.touches(); }
    std::size_t tetrahedra() const { return m_mesh.cells.size(); }

  private:
    static TetMesh make_mesh() {
        TetMesh all;
        for (int k = 0; k < 5; ++k) {
            const TetMesh block = five_tet_block({16, 15, 10}, 2);
            const auto first = std::int32_t(all.nodes_mm.size());
            for (const Vec3d p : block.nodes_mm) all.nodes_mm.push_back(p + Vec3d{0, 0, 20.0 * k});
            for (auto cell : block.cells) {
                for (std::int32_t& node : cell) node += first;
                all.cells.push_back(cell);
            }
        }
        return all;
    }
    static PbdBody make_body(const TetMesh& mesh) {
        auto parts = pbd_of_mesh(mesh, {.density = 1e-3,
                                        .edges = false,
                                        .volumes = false,
                                        .solids = true,
                                        .young_modulus = 15000});
        if (!parts) std::abort();
        for (std::size_t n = 0; n < parts->positions.size(); ++n)
            if (parts->positions[n].z < 1e-9) parts->inverse_masses[n] = 0;
        auto body =
            PbdBody::create(std::move(*parts), {.time_step = 1e-3, .sub_steps = 1, .damping = 5});
        if (!body) std::abort();
        return std::move(*body);
    }
    static BodyContact make_contact(const TetMesh& mesh) {
        auto contact = BodyContact::create(mesh, {}, {});
        if (!contact) std::abort();
        return std::move(*contact);
    }

    TetMesh m_mesh = make_mesh();
    PbdBody m_body;
    BodyContact m_contact;
    int m_step = 0;
};

/// One item is a tetrahedron. Argument: threads.
void pbd_pieces(benchmark::State& state) {
    const TaskArena arena(int(state.range(0)));
    FiveBlocks subject, reference;
    const auto turns = run_interleaved(
        state, "the step without contact", [] {},
        [&] {
            if (!subject.with_contact(arena)) state.SkipWithError("unstable");
        },
        [&] {
            if (!reference.alone(arena)) state.SkipWithError("unstable");
        },
        int(state.range(0)));
    turns.count(double(subject.tetrahedra()));
    state.counters["touches"] = double(subject.touches());
}
BENCHMARK(pbd_pieces)
    ->ArgName("threads")
    ->Arg(1)
    ->Arg(2)
    ->Iterations(201)
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace pliant::bench
