// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A vessel of 23,040 tetrahedra with fixed ends under a pulsing pressure: steps per second with all
// tetrahedra movable and with only the boxes around a tip, and changes of volume. Also nodes in
// tetrahedra, for two vessels as large as those of [Teschner2003].

#include <pliant/mesh.h>
#include <pliant/models/pbd.h>
#include <pliant/research/overlap.h>

#include <cmath>
#include <vector>

#include "interleaved.h"
#include "tube_mesh.h"

namespace pliant::bench {
namespace {

constexpr Tube kVessel{};
constexpr double kStep = 1.0 / 256;

struct Vessel {
    TetMesh mesh = tube_mesh(kVessel);
    PbdParts parts;
    std::vector<std::int32_t> inner;
    std::vector<Vec3d> forces;  ///< of a pressure of 1

    explicit Vessel(double density = 1e-3)
        : parts(*pbd_of_mesh(
              mesh,
              {.density = density, .edge_compliance = 1e-3, .bend_compliance = 1, .bends = true})) {
        for (int k = 0; k <= kVessel.along; ++k)
            for (int a = 0; a < kVessel.around; ++a) {
                for (int r = 0; r <= kVessel.across && (k == 0 || k == kVessel.along); ++r)
                    parts.inverse_masses[std::size_t(kVessel.node(a, r, k))] = 0;
                const std::int32_t n = kVessel.node(a, 0, k);
                const Vec3d p = mesh.nodes_mm[std::size_t(n)];
                const double side = 2 * kVessel.inner * std::sin(std::numbers::pi / kVessel.around);
                const double area = side * kVessel.length / kVessel.along;
                inner.push_back(n);
                forces.push_back((area / kVessel.inner) * Vec3d{p.x, p.y, 0});
            }
    }
    double constraints() const {
        return double(parts.distances.size() + parts.bends.size() + parts.volumes.size());
    }
};

void press(const Vessel& vessel, double pressure, PbdBody& body) {
    std::vector<Vec3d> forces;
    for (const Vec3d& f : vessel.forces) forces.push_back(pressure * f);
    (void)body.load(vessel.inner, forces);
}
/// Pressure that widens the vessel by about a tenth and back, four times a second.
void pulse(const Vessel& vessel, int step, PbdBody& body) {
    press(vessel, 20 * (1 - std::cos(2 * std::numbers::pi * 4 * step * kStep)), body);
}

/// One item is a tetrahedron. The reference is the scalar version on one thread. Arguments:
/// sub-steps, threads.
void pbd_vessel(benchmark::State& state) {
    const TaskArena arena(int(state.range(1))), one(1);
    const Vessel vessel;
    PbdSettings settings{
        .time_step = kStep, .sub_steps = std::int32_t(state.range(0)), .damping = 2};
    auto body = PbdBody::create(vessel.parts, settings);
    settings.vectors = false;
    auto plain = PbdBody::create(vessel.parts, settings);
    int step = 0, plain_step = 0;
    double mean = 0, largest = 0;
    const auto turns = run_interleaved(
        state, "without vectors, one thread", [] {},
        [&] {
            pulse(vessel, step++, *body);
            if (!body->step(1, arena).ok()) state.SkipWithError("unstable");
        },
        [&] {
            pulse(vessel, plain_step++, *plain);
            if (!plain->step(1, one).ok()) state.SkipWithError("unstable");
        });
    std::vector<Vec3d> positions(vessel.parts.positions.size());
    body->get_positions(positions);
    const VolumeChange change = volume_change(vessel.parts, positions);
    mean = std::max(mean, change.mean);
    largest = std::max(largest, change.largest);
    turns.count(double(vessel.mesh.cells.size()));
    state.counters["steps/s"] =
        1e9 / (state.counters["ns/item"].value * double(vessel.mesh.cells.size()));
    state.counters["constraints"] = vessel.constraints();
    state.counters["mean_%"] = 100 * mean;
    state.counters["largest_%"] = 100 * largest;
}
BENCHMARK(pbd_vessel)
    ->ArgNames({"sub_steps", "threads"})
    ->ArgsProduct({{5, 10}, {1, 2}})
    ->Iterations(96)  // half a period after the highest pressure
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond);

/// The whole vessel under a pressure of 20 that has lasted for 1.5 s, with recovery; its mass is
/// that of the wall in pliant vessel. One item is a tetrahedron; the reference is without recovery.
/// Argument: threads.
void pbd_vessel_lasting(benchmark::State& state) {
    const TaskArena arena(int(state.range(0)));
    const Vessel vessel(0.02);
    PbdSettings settings{.time_step = kStep, .sub_steps = 5, .damping = 20, .volume_recovery = 10};
    auto body = PbdBody::create(vessel.parts, settings);
    settings.volume_recovery = 0;
    auto without = PbdBody::create(vessel.parts, settings);
    for (PbdBody* b : {&*body, &*without}) {
        press(vessel, 20, *b);
        if (!b->step(384, arena).ok()) state.SkipWithError("unstable");
    }
    const auto turns = run_interleaved(
        state, "without recovery", [] {},
        [&] {
            if (!body->step(1, arena).ok()) state.SkipWithError("unstable");
        },
        [&] {
            if (!without->step(1, arena).ok()) state.SkipWithError("unstable");
        });
    turns.count(double(vessel.mesh.cells.size()));
    std::vector<Vec3d> positions(vessel.parts.positions.size());
    const auto change = [&](const PbdBody& b) {
        b.get_positions(positions);
        return volume_change(vessel.parts, positions);
    };
    state.counters["steps/s"] =
        1e9 / (state.counters["ns/item"].value * double(vessel.mesh.cells.size()));
    state.counters["without_mean_%"] = 100 * change(*without).mean;
    const VolumeChange with = change(*body);
    state.counters["mean_%"] = 100 * with.mean;
    state.counters["largest_%"] = 100 * with.largest;
    const Vec3d p = positions[std::size_t(kVessel.node(0, 0, kVessel.along / 2))];
    state.counters["inner_radius_mm"] = std::hypot(p.x, p.y);
}
BENCHMARK(pbd_vessel_lasting)
    ->ArgName("threads")
    ->Arg(1)
    ->Arg(2)
    ->Iterations(41)
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond);

/// The boxes around a tip in the middle, against the whole vessel. One item is a tetrahedron of the
/// vessel. Argument: reach of the tip.
void pbd_active_part(benchmark::State& state) {
    const TaskArena arena(1);
    const Vessel vessel;
    PbdSettings settings{.time_step = kStep, .sub_steps = 10, .damping = 2};
    auto all = PbdBody::create(vessel.parts, settings);
    settings.repacks = true;  // as in pliant vessel
    auto local = PbdBody::create(vessel.parts, settings);
    auto boxes = PbdBoxes::create(vessel.mesh, {.side = 6, .blend_steps = 1});
    const Vec3d tip{kVessel.inner, 0, 0.5 * kVessel.length};
    const double reach = double(state.range(0));
    const auto update = [&] {
        if (!boxes->update({&tip, 1}, reach, *local).ok()) state.SkipWithError("boxes");
    };
    update();
    const auto turns = run_interleaved(
        state, "all of it", [] {},
        [&] {
            update();
            if (!local->step(1, arena).ok()) state.SkipWithError("unstable");
        },
        [&] {
            if (!all->step(1, arena).ok()) state.SkipWithError("unstable");
        });
    turns.count(double(vessel.mesh.cells.size()));
    state.counters["active_%"] =
        100.0 * boxes->active_tetrahedra() / double(vessel.mesh.cells.size());
    state.counters["time_%"] = 100 / state.counters["times_faster"].value;
    state.counters["steps/s"] =
        1e9 / (state.counters["ns/item"].value * double(vessel.mesh.cells.size()));
}
BENCHMARK(pbd_active_part)
    ->ArgName("reach")
    ->Arg(3)
    ->Arg(10)
    ->Arg(20)
    ->Iterations(41)
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond);

/// One item is a tetrahedron. The reference first tests every node with every tetrahedron's box.
void pbd_overlap(benchmark::State& state) {
    TetMesh mesh = tube_mesh({.around = 23, .across = 1, .along = 56, .length = 56});
    const TetMesh other = tube_mesh({.around = 26, .across = 2, .along = 41, .length = 41});
    const auto first = std::int32_t(mesh.nodes_mm.size());
    for (const Vec3d& p : other.nodes_mm) mesh.nodes_mm.push_back({p.x + 2, p.z - 20, p.y + 28});
    for (auto cell : other.cells) {
        for (std::int32_t& n : cell) n += first;
        mesh.cells.push_back(cell);
    }
    OverlapSearch search(mesh);
    std::size_t found = 0, expected = 0;
    const auto turns = run_interleaved(
        state, "all pairs", [] {}, [&] { found = search.find(mesh.nodes_mm).size(); },
        [&] {
            expected = 0;
            for (const auto& cell : mesh.cells) {
                std::array<Vec3d, 4> corners;
                for (std::size_t n = 0; n < 4; ++n)
                    corners[n] = mesh.nodes_mm[std::size_t(cell[n])];
                for (std::size_t n = 0; n < mesh.nodes_mm.size(); ++n)
                    if (is_inside_tetrahedron(mesh.nodes_mm[n], corners) &&
                        std::find(cell.begin(), cell.end(), std::int32_t(n)) == cell.end())
                        ++expected;
            }
        });
    if (found != expected) state.SkipWithError("not the same pairs");
    turns.count(double(mesh.cells.size()));
    state.counters["pairs"] = double(found);
}
BENCHMARK(pbd_overlap)->Iterations(21)->UseManualTime()->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace pliant::bench
