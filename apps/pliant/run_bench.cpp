// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Compares ChainMail's solvers on one lattice: time, and distance from the heap's solution, which
// is 0. Timing alternates between the solvers, so that noise of the machine affects all equally.
// Lengths are in voxels of 1 mm.

#include <pliant/chainmail.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>

#include "json.h"
#include "options.h"
#include "progress.h"

namespace pliant::app {
namespace {

constexpr double kMaxMs = 2000;  ///< for all timed runs of one solver on one case

struct Case {
    bool heterogeneous;
    bool drag;  ///< six steps, forth and back; otherwise one push
    Volume labels;
    ChainMailSettings settings;
    std::vector<Vec3i> grabbed;
    std::vector<Vec3d> steps;
};

struct Contestant {
    const char* name;
    ChainMailSolver solver;
    std::vector<double> times_ms{};
    double used_ms = 0;
};

/// Displacements after the last step, and the moved elements of all steps together.
struct Outcome {
    std::vector<Vec3d> displacements{};
    std::int64_t moved_elements = 0;
    bool complete = true;
};

/// Wavy layers of four materials with slack from 0.02 to 0.4 of a link, or one material of 0.2.
void set_materials(Case& made, const BenchOptions& o) {
    std::vector<ElementLimits> limits;
    for (const double slack : {0.02, 0.05, 0.15, 0.4}) {
        const double f = made.heterogeneous ? slack : 0.2;
        const double s = made.heterogeneous ? f * o.shear_ratio : f;
        limits.push_back({{f, f, f}, {f, f, f}, {s, s, s}, 500, false});
    }
    made.labels.grid.size = {o.size, o.size, o.size};
    std::vector<std::int16_t> labels;
    for (int z = 0; z < o.size; ++z)
        for (int y = 0; y < o.size; ++y)
            for (int x = 0; x < o.size; ++x)
                labels.push_back(std::int16_t((int(x + 5 * std::sin(0.2 * y)) / 7 +
                                               int(y + 4 * std::sin(0.3 * z)) / 9 + z / 11) &
                                              3));
    made.labels.voxels = std::move(labels);
    made.settings.bounded = true;
    made.settings.custom_law = [limits](int value) {
        return limits[std::size_t(std::clamp(value, 0, 3))];
    };
}

Case make_case(const BenchOptions& o, bool heterogeneous, bool drag) {
    Case made{heterogeneous, drag, {}, {}, {}, {}};
    set_materials(made, o);
    const int middle = o.size / 2, low = std::min(middle, o.size - 2);
    if (o.grab == "element")
        made.grabbed = {{middle, middle, o.size - 1}};
    else
        for (int c = 0; c < 8; ++c)
            made.grabbed.push_back({low + (c & 1), low + (c >> 1 & 1), low + (c >> 2)});
    if (!drag) {
        // Straight outwards, as in published measurements; oblique for different components.
        made.steps = {o.pull_voxels * (heterogeneous ? Vec3d{0.48, -0.36, 0.8} : Vec3d{0, 0, 1})};
        return made;
    }
    const Vec3d path[] = {{0, 0, 0.5},    {0.25, 0, 0.5},       {0.25, 0.25, -0.5},
                          {-0.25, 0, -1}, {-0.25, -0.25, 0.25}, {0.125, 0, 0.25}};
    for (const Vec3d step : path) made.steps.push_back(o.pull_voxels * step);
    return made;
}

Result<ChainMail> make_tissue(const Case& c, const Contestant& contestant, const TaskArena& arena) {
    ChainMailSettings settings = c.settings;
    settings.solver = contestant.solver;
    return ChainMail::create(c.labels, settings, arena);
}

bool push(const Case& c, ChainMail& tissue, Vec3d step) {
    const auto report = tissue.push_elements(c.grabbed, step);
    return report.ok() && report->status == PushStatus::Applied;
}

Result<Outcome> run_untimed(const Case& c, const Contestant& contestant, const TaskArena& arena) {
    auto tissue = make_tissue(c, contestant, arena);
    if (!tissue.ok()) return tissue.error();
    const Vec3i size = c.labels.grid.size;
    Outcome outcome{std::vector<Vec3d>(voxel_count(c.labels.grid), Vec3d{0, 0, 0})};
    for (const Vec3d step : c.steps) {
        outcome.complete &= push(c, *tissue, step);
        std::size_t element = 0;
        for (int k = 0; k < size.z; ++k)
            for (int j = 0; j < size.y; ++j)
                for (int i = 0; i < size.x; ++i) {
                    const Vec3d now = tissue->displacement_mm({i, j, k});
                    Vec3d& before = outcome.displacements[element++];
                    outcome.moved_elements += norm(now - before) > 0;
                    before = now;
                }
    }
    return outcome;
}

/// Times two runs per round, of which the second counts, with warm caches as in a drag. A
/// contestant that has used up its time is skipped. Making the tissue isn't timed.
Status time_in_turns(const Case& c, std::span<Contestant> contestants, int rounds,
                     const TaskArena& arena) {
    const ProgressBar bar("bench");
    for (int round = 0; round < rounds; ++round)
        for (Contestant& contestant : contestants) {
            if (contestant.used_ms > kMaxMs) continue;
            auto tissue = make_tissue(c, contestant, arena);
            if (!tissue.ok()) return tissue.error();
            double ms = 0;
            for (int run = 0; run < 2 && ms < kMaxMs; ++run) {
                tissue->reset();
                const auto start = std::chrono::steady_clock::now();
                for (const Vec3d step : c.steps) push(c, *tissue, step);
                const std::chrono::duration<double, std::milli> elapsed =
                    std::chrono::steady_clock::now() - start;
                contestant.used_ms += ms = elapsed.count();
            }
            contestant.times_ms.push_back(ms);
        }
    return Ok{};
}

void print(const BenchOptions& o, const Case& c, const Contestant& contestant,
           const Outcome& outcome, double distance) {
    std::vector<double> times = contestant.times_ms;
    std::sort(times.begin(), times.end());
    const double ms = times[times.size() / 2];
    const double ns = outcome.moved_elements > 0 ? ms * 1e6 / double(outcome.moved_elements) : 0;
    if (!o.json) {
        std::printf("%-17s %10.3f %9.1f %10lld %9.4f%s\n", contestant.name, ms, ns,
                    static_cast<long long>(outcome.moved_elements), distance,
                    outcome.complete ? "" : "  gave up");
        return;
    }
    const Json line = {{"material", c.heterogeneous ? "heterogeneous" : "homogeneous"},
                       {"motion", c.drag ? "drag" : "push"},
                       {"size", o.size},
                       {"pull_voxels", o.pull_voxels},
                       {"grab", o.grab},
                       {"threads", o.threads},
                       {"solver", contestant.name},
                       {"ms", ms},
                       {"ns_per_moved_element", ns},
                       {"moved_elements", outcome.moved_elements},
                       {"max_distance_voxels", distance},
                       {"complete", outcome.complete}};
    std::printf("%s\n", line.dump().c_str());
}

void print_heading(const BenchOptions& o, const Case& c) {
    std::printf("\n%s, %s; %d x %d x %d elements, pull of %g voxels, one %s grabbed\n",
                c.heterogeneous ? "four materials" : "one material",
                c.drag            ? "a drag of six steps with reversal"
                : c.heterogeneous ? "one oblique push from rest"
                                  : "one push from rest",
                o.size, o.size, o.size, o.pull_voxels, o.grab.c_str());
    std::printf("%-17s %10s %9s %10s %9s\n", "solver", "ms", "ns/moved", "moved", "largest");
    std::printf("%-17s %10s %9s %10s %9s\n", "", "(median)", "", "elements", "distance");
}

Status compare(const BenchOptions& o, const TaskArena& arena, bool heterogeneous, bool drag) {
    const Case c = make_case(o, heterogeneous, drag);
    Contestant contestants[] = {{"exact-heap", ChainMailSolver::Heap},
                                {"exact-sweep", ChainMailSolver::Sweep},
                                {"exact-plain-sweep", ChainMailSolver::PlainSweep}};
    if (const Status s = time_in_turns(c, contestants, o.rounds, arena); !s.ok()) return s;
    const auto exact = run_untimed(c, contestants[0], arena);
    if (!exact.ok()) return exact.error();
    if (!o.json) print_heading(o, c);
    for (const Contestant& contestant : contestants) {
        const auto outcome = run_untimed(c, contestant, arena);
        if (!outcome.ok()) return outcome.error();
        double distance = 0;
        for (std::size_t e = 0; e < exact->displacements.size(); ++e)
            distance =
                std::max(distance, norm(outcome->displacements[e] - exact->displacements[e]));
        print(o, c, contestant, *outcome, distance);
    }
    return Ok{};
}

}  // namespace

int run_bench(const BenchOptions& o) {
    if (!o.compare) return bad_input("bench chainmail: expected --compare");
    const TaskArena arena(o.threads);
    const bool both = o.homogeneous == o.heterogeneous;
    for (const bool heterogeneous : {false, true}) {
        if (!both && heterogeneous != o.heterogeneous) continue;
        for (const bool drag : {false, true})
            if (const Status s = compare(o, arena, heterogeneous, drag); !s.ok())
                return bad_input("bench: " + s.error().message);
    }
    return kExitOk;
}

}  // namespace pliant::app
