// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Position-based blocks: cubes of 0.25 m, five tetrahedra each, the face x = 0 fixed, 1 kg per
// node, gravity, steps of 5 ms with ten sub-steps of one iteration; edges of 1e-5 m/N and volumes
// of 1e-9. One item is a projection, including prediction and velocities. The reference is the
// naive loop: structures of floats, constraints in the mesh's order, one after the other.

#include <pliant/models/pbd.h>
#include <pliant/research/rod.h>

#include <cmath>
#include <cstdlib>
#include <vector>

#include "interleaved.h"

namespace pliant::bench {
namespace {

constexpr double kTimeStep = 0.005;
constexpr int kSubSteps = 10;
constexpr Vec3i kSmall{20, 10, 10}, kLarge{40, 20, 20};

PbdParts block(Vec3i cells) {
    PbdParts parts = *pbd_of_mesh(five_tet_block(cells, 0.25),
                                  {.edge_compliance = 1e-5, .volume_compliance = 1e-9});
    for (std::size_t n = 0; n < parts.positions.size(); ++n)
        parts.inverse_masses[n] = parts.positions[n].x == 0 ? 0 : 1;
    return parts;
}

class NaiveBlock {
  public:
    explicit NaiveBlock(const PbdParts& parts) {
        for (std::size_t n = 0; n < parts.positions.size(); ++n)
            m_particles.push_back({as_float(parts.positions[n]),
                                   as_float(parts.positions[n]),
                                   {0, 0, 0},
                                   float(parts.inverse_masses[n])});
        for (const PbdDistance& d : parts.distances)
            m_distances.push_back({d.nodes[0], d.nodes[1], float(length(d.nodes[0], d.nodes[1])),
                                   float(d.compliance)});
        for (const PbdVolume& v : parts.volumes)
            m_volumes.push_back(
                {{v.nodes[0], v.nodes[1], v.nodes[2], v.nodes[3]}, 0, float(v.compliance)});
        for (Volume& v : m_volumes) v.rest = volume(v);
    }
    void step() {
        for (int n = 0; n < kSubSteps; ++n) sub_step(float(kTimeStep / kSubSteps));
    }
    float place_z(std::size_t n) const { return m_particles[n].x.z; }

  private:
    struct Particle {
        Vec3f x, old, v;
        float w;
    };
    struct Distance {
        int a, b;
        float rest, compliance;
    };
    struct Volume {
        int nodes[4];
        float rest, compliance;
    };
    static Vec3f as_float(Vec3d v) { return {float(v.x), float(v.y), float(v.z)}; }
    Particle& at(int n) { return m_particles[std::size_t(n)]; }
    double length(int a, int b) {
        const Vec3f d = at(a).x - at(b).x;
        return std::sqrt(double(dot(d, d)));
    }
    float volume(const Volume& v) {
        const Vec3f p = at(v.nodes[0]).x;
        return dot(cross(at(v.nodes[1]).x - p, at(v.nodes[2]).x - p), at(v.nodes[3]).x - p) / 6;
    }
    void sub_step(float h) {
        for (Particle& p : m_particles) {
            p.old = p.x;
            if (p.w == 0) continue;
            p.v.z -= h * 9.81F;
            p.x = p.x + h * p.v;
        }
        for (const Distance& c : m_distances) {
            Particle &a = at(c.a), &b = at(c.b);
            const Vec3f d = a.x - b.x;
            const float l = std::sqrt(dot(d, d));
            const float s = (l - c.rest) / ((a.w + b.w + c.compliance / (h * h)) * l);
            a.x = a.x - s * a.w * d;
            b.x = b.x + s * b.w * d;
        }
        for (const Volume& c : m_volumes) {
            Particle *p[4], **q = p;
            for (const int n : c.nodes) *q++ = &at(n);
            const Vec3f e = p[1]->x - p[0]->x, f = p[2]->x - p[0]->x, g = p[3]->x - p[0]->x;
            Vec3f grad[4];
            grad[1] = (1.0F / 6) * cross(f, g);
            grad[2] = (1.0F / 6) * cross(g, e);
            grad[3] = (1.0F / 6) * cross(e, f);
            grad[0] = -(grad[1] + grad[2] + grad[3]);
            float weight = c.compliance / (h * h);
            for (int n = 0; n < 4; ++n) weight += p[n]->w * dot(grad[n], grad[n]);
            const float s = (dot(grad[3], g) - c.rest) / weight;
            for (int n = 0; n < 4; ++n) p[n]->x = p[n]->x - s * p[n]->w * grad[n];
        }
        for (Particle& p : m_particles) p.v = (1 / h) * (p.x - p.old);
    }

    std::vector<Particle> m_particles;
    std::vector<Distance> m_distances;
    std::vector<Volume> m_volumes;
};

void compare(benchmark::State& state, Vec3i cells, bool vectors, int threads) {
    const TaskArena arena(threads);
    const PbdParts parts = block(cells);
    NaiveBlock naive(parts);
    auto body = PbdBody::create(parts, {.time_step = kTimeStep,
                                        .sub_steps = kSubSteps,
                                        .gravity = {0, 0, -9.81},
                                        .vectors = vectors});
    const double constraints = double(parts.distances.size() + parts.volumes.size());
    const auto turns = run_interleaved(
        state, "plain loop", [] {},
        [&] {
            if (!body->step(1, arena).ok()) state.SkipWithError("unstable");
        },
        [&] { naive.step(); });
    turns.count(constraints * kSubSteps);
    state.counters["tetrahedra"] = double(parts.volumes.size());
    state.counters["ms/step"] = state.counters["ns/item"].value * constraints * kSubSteps * 1e-6;
}

/// The two blocks of published timings. Arguments: block, vector instructions, threads.
void pbd_block(benchmark::State& state) {
    compare(state, state.range(0) ? kLarge : kSmall, state.range(1) != 0, int(state.range(2)));
}
BENCHMARK(pbd_block)
    ->ArgNames({"large", "vectors", "threads"})
    ->ArgsProduct({{0, 1}, {0, 1}, {1, 2}})
    ->Iterations(41)
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond);

/// Scaling with size. Arguments: thousands of tetrahedra (about), threads.
void pbd_size(benchmark::State& state) {
    const int side = int(std::lround(std::cbrt(double(state.range(0)) * 200)));
    compare(state, {side, side, side}, true, int(state.range(1)));
}
BENCHMARK(pbd_size)
    ->ArgNames({"thousands", "threads"})
    ->ArgsProduct({{1, 4, 16, 64, 250, 1000}, {1, 2}})
    ->Iterations(11)
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond);

/// Volume error against time: a neo-Hookean block of 3840 tetrahedra, two seconds after it fell to
/// the floor. Argument: sub-steps of a sixtieth of a second. One item is a tetrahedron's pair of
/// constraints; the reference is the scalar version.
void pbd_volume(benchmark::State& state) {
    const TaskArena arena(1);
    PbdParts parts = *pbd_of_mesh(five_tet_block({12, 8, 8}, 0.1), {.density = 1000,
                                                                    .edges = false,
                                                                    .volumes = false,
                                                                    .solids = true,
                                                                    .young_modulus = 1e5,
                                                                    .poisson_ratio = 0.4999});
    parts.planes = {{{0, 0, -0.5}, {0, 0, 1}, 0.5}};
    PbdSettings settings{.sub_steps = int(state.range(0)), .gravity = {0, 0, -10}};
    auto body = PbdBody::create(parts, settings);
    settings.vectors = false;
    auto plain = PbdBody::create(parts, settings);
    const auto turns = run_interleaved(
        state, "without vectors", [] {},
        [&] {
            if (!body->step(1, arena).ok()) state.SkipWithError("unstable");
        },
        [&] {
            if (!plain->step(1, arena).ok()) state.SkipWithError("unstable");
        });
    std::vector<Vec3d> positions(parts.positions.size());
    body->get_positions(positions);
    const VolumeChange change = volume_change(parts, positions);
    turns.count(double(parts.solids.size()) * double(state.range(0)));
    state.counters["total_%"] = 100 * change.total;
    state.counters["mean_%"] = 100 * change.mean;
    state.counters["largest_%"] = 100 * change.largest;
}
BENCHMARK(pbd_volume)
    ->ArgName("sub_steps")
    ->Arg(1)
    ->Arg(2)
    ->Arg(5)
    ->Arg(10)
    ->Arg(20)
    ->Iterations(121)
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond);

/// A rod bent by a load: one item is a segment of a Newton iteration, two of them a step.
void pbd_rod(benchmark::State& state) {
    auto rod = Rod::create({.segments = std::int32_t(state.range(0)), .damping = 4});
    if (!rod->load(std::int32_t(state.range(0)), {2, 0, 0}).ok()) std::abort();
    Turns turns(state, "none");
    for (auto _ : state)
        turns.add_subject(seconds_of([&] {
            if (!rod->step(1).ok()) state.SkipWithError("unstable");
        }));
    turns.count(double(state.range(0)) * 2);
}
BENCHMARK(pbd_rod)
    ->ArgName("segments")
    ->Arg(50)
    ->Arg(200)
    ->Arg(1000)
    ->Iterations(101)
    ->UseManualTime()
    ->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace pliant::bench
