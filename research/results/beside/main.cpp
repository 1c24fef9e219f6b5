// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Bodies and rods of the library for the scripts of this folder: each run prints a line of JSON for
// each checkpoint, with processor and wall time so far and the positions.
//
//   results_beside block|beam|rod|laid NAME=NUMBER…
//
// Lengths are in metres.

#include <pliant/core/tasks.h>
#include <pliant/models/pbd.h>
#include <pliant/models/vessel.h>
#include <pliant/research/rod.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <map>
#include <numbers>
#include <string>

#include "value_of.h"

namespace pliant::results {
namespace {

using Numbers = std::map<std::string, double>;

double cpu_s() {
    timespec t{};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return double(t.tv_sec) + 1e-9 * double(t.tv_nsec);
}
double wall_s() {
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch())
        .count();
}

/// Processor and wall time, without what lies between stop() and start().
class Watch {
  public:
    void start() {
        m_cpu -= cpu_s();
        m_wall -= wall_s();
    }
    void stop() {
        m_cpu += cpu_s();
        m_wall += wall_s();
    }
    double cpu() const { return m_cpu; }
    double wall() const { return m_wall; }

  private:
    double m_cpu = 0, m_wall = 0;
};

void print(const char* kind, const Watch& watch, std::span<const Vec3d> positions) {
    std::printf("{\"kind\": \"%s\", \"cpu\": %.9g, \"wall\": %.9g, \"x\": [", kind, watch.cpu(),
                watch.wall());
    for (std::size_t n = 0; n < positions.size(); ++n)
        std::printf("%s%.9g,%.9g,%.9g", n ? "," : "", positions[n].x, positions[n].y,
                    positions[n].z);
    std::printf("]}\n");
}

/// Whether the positions after a step are printed: about twelve of them, and the last.
bool is_checkpoint(int step, int steps) {
    return step == steps || step % std::max(1, steps / 12) == 0;
}

PbdParts solid_of(const TetMesh& mesh, const Numbers& with) {
    return value_of(pbd_of_mesh(mesh, {.density = 1000,
                                       .edges = false,
                                       .volumes = false,
                                       .solids = true,
                                       .young_modulus = with.at("young"),
                                       .poisson_ratio = with.at("nu")}));
}

PbdBody body_of(PbdParts parts, const Numbers& with) {
    const double step = with.at("dt");
    const double needed = with.at("waves") * wave_sub_steps(parts, step);
    const bool doubles = with.at("double") > 0;
    return value_of(PbdBody::create(
        std::move(parts), {.time_step = step,
                           .sub_steps = std::int32_t(std::ceil(std::max(1.0, needed))),
                           .gravity = {0, 0, -with.at("gravity")},
                           .damping = with.at("damping"),
                           .precision = doubles ? PbdPrecision::Double : PbdPrecision::Float,
                           .warm_starts = with.at("warm") > 0}));
}

/// Nodes in metres of a box of five tetrahedra for each cell.
TetMesh box_of(const Numbers& with) {
    const Vec3i cells{int(with.at("nx")), int(with.at("ny")), int(with.at("nz"))};
    TetMesh mesh = five_tet_block(cells, 1);
    for (Vec3d& p : mesh.nodes_mm)
        p = {p.x * with.at("lx") / cells.x, p.y * with.at("ly") / cells.y,
             p.z * with.at("lz") / cells.z};
    return mesh;
}

int block_or_beam(const Numbers& with, bool is_block) {
    const TaskArena arena(1);
    Watch setup, solve;
    setup.start();
    PbdParts parts = solid_of(box_of(with), with);
    std::vector<std::int32_t> patch;
    const auto near = [](double a, double b) { return std::abs(a - b) < 1e-9; };
    for (std::size_t n = 0; n < parts.positions.size(); ++n) {
        const Vec3d p = parts.positions[n];
        const bool pressed = is_block && near(p.z, with.at("lz")) &&
                             std::abs(p.x - with.at("lx") / 2) < with.at("patch") / 2 + 1e-9 &&
                             std::abs(p.y - with.at("ly") / 2) < with.at("patch") / 2 + 1e-9;
        if (pressed) patch.push_back(std::int32_t(n));
        if (pressed || near(is_block ? p.z : p.x, 0)) parts.inverse_masses[n] = 0;
    }
    const std::vector<Vec3d> rest = parts.positions;
    PbdBody body = body_of(std::move(parts), with);
    setup.stop();
    print("rest", setup, rest);
    std::vector<Vec3d> now(rest.size());
    const int steps = int(with.at("steps")), ramp = int(with.at("ramp"));
    for (int step = 1; step <= steps; ++step) {
        solve.start();
        if (step <= ramp)
            for (const std::int32_t n : patch) {
                const double down = with.at("depth") * step / ramp;
                must(body.set_state(n, rest[std::size_t(n)] - Vec3d{0, 0, down}, {0, 0, 0}));
            }
        must(body.step(1, arena));
        solve.stop();
        if (!is_checkpoint(step, steps)) continue;
        body.get_positions(now);
        print("now", solve, now);
    }
    return 0;
}

/// Along x, with z upwards.
Rod rod_of(const Numbers& with) {
    const double half = std::sqrt(0.5);
    return value_of(Rod::create({.segments = int(with.at("segments")),
                                 .length = 1,
                                 .mass = 1,
                                 .bend_stiffness = 1,
                                 .twist_stiffness = 0.8,
                                 .stretch_stiffness = with.at("stretch"),
                                 .shear_stiffness = with.at("stretch"),
                                 .frame = {half, 0, half, 0},
                                 .time_step = with.at("dt"),
                                 .iterations = int(with.at("iterations")),
                                 .gravity = {0, 0, -with.at("gravity")},
                                 .damping = with.at("damping")}));
}

std::vector<Vec3d> nodes_of(const Rod& rod) {
    std::vector<Vec3d> nodes;
    for (int n = 0; n <= rod.settings().segments; ++n) nodes.push_back(rod.position(n));
    return nodes;
}

int loaded_rod(const Numbers& with) {
    Watch setup, solve;
    setup.start();
    Rod rod = rod_of(with);
    setup.stop();
    print("rest", setup, nodes_of(rod));
    const int steps = int(with.at("steps")), ramp = int(with.at("ramp"));
    for (int step = 1; step <= steps; ++step) {
        solve.start();
        if (step <= ramp)
            must(rod.load(rod.settings().segments, {0, 0, -with.at("force") * step / ramp}));
        must(rod.step(1));
        solve.stop();
        if (is_checkpoint(step, steps)) print("now", solve, nodes_of(rod));
    }
    return 0;
}

/// A heavy rod in a rigid tube, on whose lowest line it comes to lie.
int laid_rod(const Numbers& with) {
    const TaskArena arena(1);
    Watch setup, solve;
    setup.start();
    Rod rod = rod_of(with);
    const double inner = with.at("drop") + with.at("radius");
    const CentrePoint way[] = {{{-0.2, 0, 0}, inner}, {{1.2, 0, 0}, inner}};
    VesselWall wall = value_of(swept_tube(
        way,
        {.thickness_mm = 0.05, .layers = 1, .sectors = int(with.at("sectors")), .ring_mm = 0.1}));
    PbdParts parts = value_of(pbd_of_mesh(wall.mesh, {.density = 1, .volumes = false}));
    std::ranges::fill(parts.inverse_masses, 0.0);
    PbdBody body =
        value_of(PbdBody::create(std::move(parts), {.time_step = with.at("dt"), .sub_steps = 1}));
    auto contact = value_of(
        RodContact::create(wall.mesh, wall.ghost, wall.ghost_positions,
                           {.radius = with.at("radius"), .iterations = int(with.at("rounds"))}));
    setup.stop();
    print("rest", setup, nodes_of(rod));
    const int steps = int(with.at("steps"));
    for (int step = 1; step <= steps; ++step) {
        solve.start();
        must(contact.step(1, rod, body, arena));
        solve.stop();
        if (is_checkpoint(step, steps)) print("now", solve, nodes_of(rod));
    }
    return 0;
}

int run(const std::string& what, const Numbers& with) {
    if (what == "block" || what == "beam") return block_or_beam(with, what == "block");
    if (what == "rod") return loaded_rod(with);
    if (what == "laid") return laid_rod(with);
    std::fprintf(stderr, "results_beside: expected block, beam, rod or laid, found %s\n",
                 what.c_str());
    return 1;
}

}  // namespace
}  // namespace pliant::results

int main(int count, char** words) {
    pliant::results::Numbers with{{"waves", 1},      {"damping", 20}, {"gravity", 0},
                                  {"warm", 1},       {"double", 0},   {"patch", 0},
                                  {"iterations", 2}, {"rounds", 8},   {"ramp", 1}};
    for (int n = 2; n < count; ++n) {
        const std::string word = words[n];
        const auto is = word.find('=');
        if (is == std::string::npos) return 1;
        with[word.substr(0, is)] = std::atof(word.c_str() + is + 1);
    }
    return pliant::results::run(count > 1 ? words[1] : "", with);
}
