// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The published orderings beside the exact solvers (docs/method/published_orderings.md), on one
// lattice: time, number of violated links, distance from the exact solution. Timing alternates
// between the solvers, so that noise of the machine affects all equally; quality is evaluated in a
// separate run. Lengths are in voxels of 1 mm.

#include <pliant/research/orderings.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <functional>
#include <nlohmann/json.hpp>
#include <optional>

namespace pliant::results {
namespace {

using Json = nlohmann::ordered_json;

/// Smaller differences are ignored: limits are rounded to 10⁻⁶, float positions to 10⁻⁵.
constexpr double kNoticed = 1e-4;

constexpr double kMaxMs = 2000;  ///< for all timed runs of one solver on one case

struct Options {
    bool json = false;             ///< one object per case and solver, one on each line
    int size = 50;                 ///< elements along each edge of the lattice
    double pull_voxels = 5;        ///< length of the push, and of the drag's longest step
    std::string grab = "element";  ///< or "cell"
    bool homogeneous = false, heterogeneous = false;  ///< neither: both
    double shear_ratio = 0.5;  ///< shear / stretch of the heterogeneous materials
    int rounds = 9;
    int threads = 1;
};

struct Case {
    bool heterogeneous;
    bool drag;  ///< six steps, forth and back; otherwise one push
    ChainLattice lattice;
    std::vector<std::int32_t> grabbed;
    std::vector<Vec3d> steps;
};

/// Uniform interface to a solver.
struct Contestant {
    std::string name;
    std::function<void()> reset;
    std::function<bool(Vec3d)> push;  ///< false: it stopped early, or doesn't support the push
    std::function<Vec3d(std::int32_t)> displacement;
    std::vector<double> times_ms{};
    double used_ms = 0;
};

struct Verdict {
    std::int64_t moved_elements = 0;  ///< all steps together
    LinkState links;
    double max_distance = 0, mean_distance = 0;  ///< mean over the elements away from rest
    bool complete = true;
};

/// Makes wavy layers of four materials with slack from 0.02 to 0.4 of a link, or one material of
/// 0.2.
ChainLattice make_lattice(const Options& o, bool heterogeneous) {
    ChainLattice lattice{.size = {o.size, o.size, o.size}};
    for (const double slack : {0.02, 0.05, 0.15, 0.4}) {
        const double f = heterogeneous ? slack : 0.2;
        const double s = heterogeneous ? f * o.shear_ratio : f;
        lattice.materials.push_back({{f, f, f}, {f, f, f}, {s, s, s}, 500, false});
        if (!heterogeneous) return lattice;
    }
    for (int z = 0; z < o.size; ++z)
        for (int y = 0; y < o.size; ++y)
            for (int x = 0; x < o.size; ++x)
                lattice.material.push_back(
                    std::uint8_t((int(x + 5 * std::sin(0.2 * y)) / 7 +
                                  int(y + 4 * std::sin(0.3 * z)) / 9 + z / 11) &
                                 3));
    return lattice;
}

Case make_case(const Options& o, bool heterogeneous, bool drag) {
    Case made{heterogeneous, drag, make_lattice(o, heterogeneous), {}, {}};
    const int middle = o.size / 2;
    const Grid grid{.size = made.lattice.size};
    if (o.grab == "element") {
        made.grabbed = {std::int32_t(voxel_index(grid, {middle, middle, o.size - 1}))};
    } else {
        const int low = std::min(middle, o.size - 2);
        for (int c = 0; c < 8; ++c)
            made.grabbed.push_back(std::int32_t(
                voxel_index(grid, {low + (c & 1), low + (c >> 1 & 1), low + (c >> 2)})));
    }
    if (!drag) {
        // Straight outwards, as in published measurements; oblique for different components.
        made.steps = {o.pull_voxels * (heterogeneous ? Vec3d{0.48, -0.36, 0.8} : Vec3d{0, 0, 1})};
    } else {
        const Vec3d path[] = {{0, 0, 0.5},    {0.25, 0, 0.5},       {0.25, 0.25, -0.5},
                              {-0.25, 0, -1}, {-0.25, -0.25, 0.25}, {0.125, 0, 0.25}};
        for (const Vec3d step : path) made.steps.push_back(o.pull_voxels * step);
    }
    return made;
}

/// ChainMail needs a scan: voxel values are labels, and the lattice ends at its border.
class ScanOfLabels {
  public:
    explicit ScanOfLabels(const ChainLattice& lattice) {
        m_volume.grid.size = lattice.size;
        std::vector<std::int16_t> labels(voxel_count(m_volume.grid), 0);
        std::copy(lattice.material.begin(), lattice.material.end(), labels.begin());
        m_volume.voxels = std::move(labels);
        m_settings.bounded = true;
        m_settings.custom_law = [materials = lattice.materials](int value) {
            return materials[std::size_t(std::clamp(value, 0, int(materials.size()) - 1))];
        };
        for (int k = 0; k < lattice.size.z; ++k)
            for (int j = 0; j < lattice.size.y; ++j)
                for (int i = 0; i < lattice.size.x; ++i) m_positions.push_back({i, j, k});
    }

    Contestant contestant(const char* name, ChainMailSolver solver, const TaskArena& arena,
                          std::span<const std::int32_t> grabbed) const {
        ChainMailSettings settings = m_settings;
        settings.solver = solver;
        auto tissue = std::make_shared<std::optional<ChainMail>>();
        std::vector<Vec3i> elements;
        for (const std::int32_t e : grabbed) elements.push_back(m_positions[std::size_t(e)]);
        return {
            name,
            [this, tissue, settings, &arena] {
                tissue->emplace(std::move(ChainMail::create(m_volume, settings, arena)).value());
            },
            [tissue, elements](Vec3d push) {
                const auto report = (*tissue)->push_elements(elements, push);
                return report.ok() && report->status == PushStatus::Applied;
            },
            [this, tissue](std::int32_t e) {
                return (*tissue)->displacement_mm(m_positions[std::size_t(e)]);
            }};
    }

  private:
    Volume m_volume;
    ChainMailSettings m_settings;
    std::vector<Vec3i> m_positions;  ///< [element] ijk
};

Contestant graph_contestant(const Case& c, const ChainGraph& graph, const TaskArena& arena) {
    auto tissue = std::make_shared<GraphChainMail>(graph);
    return {"exact-graph", [tissue] { tissue->reset(); },
            [tissue, &c, &arena](Vec3d push) {
                const auto report = tissue->push(c.grabbed, push, arena);
                return report.ok() && report->status == PushStatus::Applied;
            },
            [tissue](std::int32_t e) { return tissue->displacement_mm(e); }};
}

std::vector<Contestant> contestants_of(const Case& c, const ChainGraph& graph,
                                       const ScanOfLabels& scan, const TaskArena& arena) {
    std::vector<Contestant> all;
    all.push_back(scan.contestant("exact-sweep", ChainMailSolver::Sweep, arena, c.grabbed));
    all.push_back(scan.contestant("exact-heap", ChainMailSolver::Heap, arena, c.grabbed));
    all.push_back(graph_contestant(c, graph, arena));
    for (const Ordering ordering :
         {Ordering::GibsonConvex, Ordering::GibsonLists, Ordering::SchillOnce,
          Ordering::SchillRequeue, Ordering::LiOnce, Ordering::LiRequeue, Ordering::Draeger,
          Ordering::DraegerMean}) {
        if (ordering == Ordering::GibsonConvex && (c.heterogeneous || c.grabbed.size() > 1))
            continue;
        auto made = make_ordering(c.lattice, ordering);
        if (!made.ok()) continue;
        std::shared_ptr<OrderingSolver> solver = std::move(made).value();
        all.push_back({std::string(name_of(ordering)), [solver] { solver->reset(); },
                       [solver, &c](Vec3d push) {
                           const OrderingReport report = solver->push(c.grabbed, push);
                           return report.status == PushStatus::Applied && !report.stopped_early;
                       },
                       [solver](std::int32_t e) { return solver->displacement_mm(e); }});
    }
    return all;
}

std::vector<Vec3d> places_of(const Contestant& contestant, std::int32_t count) {
    std::vector<Vec3d> positions;
    positions.reserve(std::size_t(count));
    for (std::int32_t e = 0; e < count; ++e) positions.push_back(contestant.displacement(e));
    return positions;
}

Verdict judge(const Case& c, const ChainGraph& graph, const Contestant& contestant,
              std::span<const Vec3d> exact) {
    Verdict verdict;
    contestant.reset();
    std::vector<Vec3d> positions(std::size_t(graph.element_count()), Vec3d{0, 0, 0});
    for (const Vec3d step : c.steps) {
        verdict.complete &= contestant.push(step);
        std::vector<Vec3d> next = places_of(contestant, graph.element_count());
        for (std::size_t e = 0; e < next.size(); ++e)
            verdict.moved_elements += norm(next[e] - positions[e]) > kNoticed;
        positions = std::move(next);
    }
    verdict.links = check_links(graph, positions, kNoticed);
    std::int64_t away = 0;
    double sum = 0;
    for (std::size_t e = 0; e < positions.size(); ++e) {
        const double distance = norm(positions[e] - exact[e]);
        verdict.max_distance = std::max(verdict.max_distance, distance);
        sum += distance;
        away += norm(positions[e]) > kNoticed || norm(exact[e]) > kNoticed;
    }
    verdict.mean_distance = away > 0 ? sum / double(away) : 0;
    return verdict;
}

double run_once(const Case& c, const Contestant& contestant) {
    contestant.reset();
    const auto start = std::chrono::steady_clock::now();
    for (const Vec3d step : c.steps) contestant.push(step);
    const std::chrono::duration<double, std::milli> elapsed =
        std::chrono::steady_clock::now() - start;
    return elapsed.count();
}

/// Times two runs per round, of which the second counts, with warm caches as in a drag. A
/// contestant that has used up its time is skipped.
void time_in_turns(const Case& c, std::span<Contestant> contestants, int rounds) {
    for (int round = 0; round < rounds; ++round)
        for (Contestant& contestant : contestants) {
            if (contestant.used_ms > kMaxMs) continue;
            double ms = run_once(c, contestant);
            contestant.used_ms += ms;
            if (ms < kMaxMs) contestant.used_ms += ms = run_once(c, contestant);
            contestant.times_ms.push_back(ms);
        }
}

double median(std::vector<double> values) {
    std::sort(values.begin(), values.end());
    return values[values.size() / 2];
}

void print(const Options& o, const Case& c, const Contestant& contestant, const Verdict& v) {
    const double ms = median(contestant.times_ms);
    const double ns = v.moved_elements > 0 ? ms * 1e6 / double(v.moved_elements) : 0;
    if (!o.json) {
        std::printf("%-15s %10.3f %9.1f %10lld %9lld %8.4f %9.4f %9.5f%s\n",
                    contestant.name.c_str(), ms, ns, static_cast<long long>(v.moved_elements),
                    static_cast<long long>(v.links.violated_links), v.links.max_violation_mm,
                    v.max_distance, v.mean_distance, v.complete ? "" : "  gave up");
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
                       {"moved_elements", v.moved_elements},
                       {"violated_links", v.links.violated_links},
                       {"max_violation_voxels", v.links.max_violation_mm},
                       {"max_distance_voxels", v.max_distance},
                       {"mean_distance_voxels", v.mean_distance},
                       {"complete", v.complete}};
    std::printf("%s\n", line.dump().c_str());
}

void print_heading(const Options& o, const Case& c) {
    std::printf("\n%s, %s; %d x %d x %d elements, pull of %g voxels, one %s grabbed\n",
                c.heterogeneous ? "four materials" : "one material",
                c.drag            ? "a drag of six steps with reversal"
                : c.heterogeneous ? "one oblique push from rest"
                                  : "one push from rest",
                o.size, o.size, o.size, o.pull_voxels, o.grab.c_str());
    std::printf("%-15s %10s %9s %10s %9s %8s %9s %9s\n", "solver", "ms", "ns/moved", "moved",
                "violated", "by", "from", "exact,");
    std::printf("%-15s %10s %9s %10s %9s %8s %9s %9s\n", "", "(median)", "", "elements", "links",
                "at most", "largest", "mean");
}

/// @returns line of the error; empty on success
std::string compare(const Options& o, const TaskArena& arena, bool heterogeneous, bool drag) {
    const Case c = make_case(o, heterogeneous, drag);
    const auto graph = graph_of_lattice(c.lattice, Neighbours::Faces);
    if (!graph.ok()) return graph.error().message;
    const ScanOfLabels scan(c.lattice);
    std::vector<Contestant> contestants = contestants_of(c, *graph, scan, arena);
    time_in_turns(c, contestants, o.rounds);
    const Contestant exact = graph_contestant(c, *graph, arena);
    for (const Vec3d step : c.steps)
        if (!exact.push(step)) return "the exact solver did not apply the push";
    const std::vector<Vec3d> positions = places_of(exact, graph->element_count());
    if (!o.json) print_heading(o, c);
    for (const Contestant& contestant : contestants)
        print(o, c, contestant, judge(c, *graph, contestant, positions));
    return {};
}

int run(const Options& o) {
    const TaskArena arena(o.threads);
    const bool both = o.homogeneous == o.heterogeneous;
    for (const bool heterogeneous : {false, true}) {
        if (!both && heterogeneous != o.heterogeneous) continue;
        for (const bool drag : {false, true})
            if (const std::string problem = compare(o, arena, heterogeneous, drag);
                !problem.empty()) {
                std::fprintf(stderr, "compare_orderings: %s\n", problem.c_str());
                return 2;
            }
    }
    return 0;
}

}  // namespace
}  // namespace pliant::results

int main(int argc, char** argv) {
    pliant::results::Options o;
    CLI::App app("Compares the published orderings of ChainMail with its exact solution");
    app.add_flag("--json", o.json, "one JSON object per case and solver, one on each line");
    app.add_option("--size", o.size, "elements along each edge (default 50)")
        ->check(CLI::Range(3, 400));
    app.add_option("--pull", o.pull_voxels, "length of the push [voxels] (default 5)")
        ->check(CLI::Range(0.01, 400.0));
    app.add_option("--grab", o.grab, "element (in the middle of a face), or cell (eight inside)")
        ->check(CLI::IsMember({"element", "cell"}));
    app.add_flag("--homogeneous", o.homogeneous, "only the case of one material");
    app.add_flag("--heterogeneous", o.heterogeneous, "only the case of four materials");
    app.add_option("--shear", o.shear_ratio, "shear / stretch of the four (default 0.5)")
        ->check(CLI::Range(0.0, 2.0));
    app.add_option("--rounds", o.rounds, "how often each is timed, turn by turn (default 9)")
        ->check(CLI::Range(1, 1000));
    app.add_option("--threads", o.threads, "threads of the exact solvers (default 1; 0: all)")
        ->check(CLI::Range(0, 256));
    CLI11_PARSE(app, argc, argv);
    return pliant::results::run(o);
}
