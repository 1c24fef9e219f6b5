// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Identification of a network on an organ's mesh: table, report, network file, VTU.

#include <pliant/core/files.h>
#include <pliant/mesh_files.h>
#include <pliant/models/fit_mesh.h>
#include <pliant/models/scene_files.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <limits>
#include <optional>

#include "fit_mesh_input.h"
#include "fit_report.h"
#include "progress.h"

namespace pliant::app {
namespace {

/// Staged outputs; empty: not wanted.
struct FitFiles {
    StagedFiles staged;
    std::filesystem::path report, network, vtu;
};

Status stage(const FitOptions& o, FitFiles& files) {
    for (const auto& [target, place] :
         {std::pair(&o.report, &files.report), std::pair(&o.network_out, &files.network),
          std::pair(&o.out, &files.vtu)}) {
        if (target->empty()) continue;
        auto staged = files.staged.stage(*target);
        if (!staged) return staged.error();
        *place = std::move(*staged);
    }
    return Ok{};
}

/// Root mean square of a component of the fitted cases' residuals [mm].
Result<double> residual_rms(const FitMeshProblem& fitted, std::span<const double> values) {
    double sum = 0;
    std::size_t count = 0;
    for (std::size_t c = 0; c < fitted.problem.cases().size(); ++c) {
        if (fitted.problem.cases()[c].held_out) continue;
        const auto residuals = fitted.problem.residuals(values, c);
        if (!residuals) return residuals.error();
        for (const Vec3d r : *residuals) sum += dot(r, r);
        count += 3 * residuals->size();
    }
    return std::sqrt(sum / double(count));
}

/// Arrays per load: displacement of the finite elements and of the network, and the residual. A
/// measured point's residual is at its nearest node.
Status write_fitted(const std::filesystem::path& path, const FitMeshInput& input,
                    const FitMeshProblem& fitted, std::span<const double> values) {
    const auto cases = fitted.problem.cases();
    std::vector<std::vector<Vec3d>> vectors;
    std::vector<std::string> names;
    for (std::size_t c = 0; c < cases.size(); ++c) {
        auto moved = fitted.problem.displacements(values, c);
        const auto residuals = fitted.problem.residuals(values, c);
        if (!moved) return moved.error();
        if (!residuals) return residuals.error();
        std::vector<Vec3d> at_nodes(moved->size(), Vec3d{0, 0, 0});
        for (std::size_t p = 0; p < residuals->size(); ++p) {
            std::size_t node = p;
            if (!cases[c].points.empty()) {
                const FitPointTarget& point = cases[c].points[p];
                const auto most = std::max_element(point.weights.begin(), point.weights.end());
                node = std::size_t(point.nodes[std::size_t(most - point.weights.begin())]);
            }
            at_nodes[node] = (*residuals)[p];
        }
        const std::string number = cases.size() > 1 ? "_" + std::to_string(c + 1) : "";
        if (!cases[c].target.empty()) {
            names.push_back("reference_mm" + number);
            vectors.push_back(cases[c].target);
        }
        names.push_back("displacement_mm" + number);
        vectors.push_back(std::move(*moved));
        names.push_back("residual_mm" + number);
        vectors.push_back(std::move(at_nodes));
    }
    std::vector<double> regions, shear, bulk;
    const auto groups = fitted.problem.groups();
    const auto value = [&](const std::string& name) {
        for (std::size_t g = 0; g < groups.size(); ++g)
            if (groups[g].name == name) return values[g];
        return 0.0;
    };
    for (const std::int32_t r : fitted.region_of) {
        const std::string& name = input.fit.regions[std::size_t(r)].name;
        const std::string ending = name.empty() ? "" : " " + name;
        regions.push_back(input.labels.empty() ? 0 : input.labels[std::size_t(r)]);
        shear.push_back(value("links" + ending));
        bulk.push_back(value("volume" + ending));
    }
    VtuFields fields{{}, {{"region", regions}, {"links_pa", shear}, {"volume_pa", bulk}}};
    for (std::size_t v = 0; v < vectors.size(); ++v)
        fields.node_vectors.push_back({names[v], vectors[v]});
    return write_vtu(path, fitted.mesh, fields);
}

Result<CreepResult> find_creep(const FitOptions& o, const FitMeshInput& input,
                               const FitMeshProblem& fitted, const FitResult& found,
                               const TaskArena& arena) {
    auto samples = read_creep(o.creep, input);
    if (!samples) return samples.error();
    return fit_creep(fitted, found.values, {.samples = std::move(*samples), .noise_mm = o.noise_mm},
                     arena);
}

Json json_of(const CreepResult& creep) {
    Json json{{"damping_per_s", creep.damping_per_s},
              {"rms_mm", creep.rms_mm},
              {"evaluations", creep.evaluations}};
    if (creep.at_bound != FitBound::None)
        json["at_bound"] = creep.at_bound == FitBound::Low ? "lower" : "upper";
    if (!creep.interval.identifiable)
        json["identifiable"] = false;
    else if (creep.interval.high > 0)
        json["interval_95"] = {creep.interval.low, creep.interval.high};
    return json;
}

void print(const CreepResult& creep) {
    std::printf("\ncreep: residual %.3g mm rms, %lld evaluations\n  %-16s %.6g 1/s", creep.rms_mm,
                static_cast<long long>(creep.evaluations), "damping", creep.damping_per_s);
    if (!creep.interval.identifiable)
        std::printf("  not identifiable");
    else if (creep.interval.high > 0)
        std::printf("  (95 %%: %.6g to %.6g)", creep.interval.low, creep.interval.high);
    if (creep.at_bound != FitBound::None)
        std::printf("  at its %s bound", creep.at_bound == FitBound::Low ? "lower" : "upper");
    std::printf("\n");
}

/// One method: fitted, printed and reported.
Result<FitResult> run_method(const std::string& method, const FitOptions& o,
                             const FitMeshProblem& fitted, std::vector<FitInterval>& intervals,
                             Json& report, const TaskArena& arena) {
    std::optional<ProgressBar> bar(std::in_place, method);
    auto result = fit(fitted.problem, method_of(method, o, fitted.closed_form), arena);
    if (!result) return Error{result.error().code, method + ": " + result.error().message};
    intervals.clear();
    std::string note;
    const auto rms = residual_rms(fitted, result->values);
    if (!rms) return rms.error();
    if (o.noise_mm > 0) {
        auto found = fit_intervals(fitted.problem, result->values, o.noise_mm, arena);
        if (!found) return found.error();
        intervals = std::move(*found);
        // The residual contains the noise of measurements, but none of finite elements.
        if (*rms > 2 * o.noise_mm)
            note =
                "the residual is larger than the noise: the intervals don't cover the difference "
                "between network and tissue";
    }
    bar.reset();
    const FitTable table{fitted.problem, *result, intervals, note, "mean edge"};
    print(method, table);
    std::printf("  residual %.4g mm rms\n", *rms);
    Json json = method_json(method, table);
    json["residual_rms_mm"] = *rms;
    report["methods"].push_back(std::move(json));
    return result;
}

double smallest_side_mm(const TetMesh& mesh) {
    double smallest = std::numeric_limits<double>::infinity();
    for (int a = 0; a < 3; ++a) {
        double low = std::numeric_limits<double>::infinity(), high = -low;
        for (const Vec3d& node : mesh.nodes_mm) {
            low = std::min(low, node[a]);
            high = std::max(high, node[a]);
        }
        smallest = std::min(smallest, high - low);
    }
    return smallest;
}

Status check_options(const FitOptions& o) {
    if (o.motion == "run")
        return bad_option("--motion", "linear or equilibrium with --mesh", o.motion);
    if (!o.creep.empty() && o.motion != "linear")
        return bad_option("--motion", "linear with --creep", o.motion);
    return Ok{};
}

}  // namespace

int run_fit_mesh(const FitOptions& o) {
    if (const Status s = check_options(o); !s) return bad_input(s.error().message);
    FitFiles files;
    if (const Status s = stage(o, files); !s) return bad_input(s.error().message);
    const TaskArena arena(o.threads);
    std::optional<ProgressBar> bar(std::in_place, "fit");
    const auto input = read_fit_mesh(o, arena);
    if (!input) {
        bar.reset();
        return bad_input(input.error().message);
    }
    const auto fitted = fit_mesh(input->fit, arena);
    bar.reset();
    if (!fitted) return bad_input("fit: " + fitted.error().message);
    std::printf("%zu nodes, %zu tetrahedra, %zu held\n", fitted->mesh.nodes_mm.size(),
                fitted->mesh.cells.size(), input->fit.held.size());
    Json report{
        {"mesh", input->name}, {"motion", o.motion}, {"cost", o.cost}, {"methods", Json::array()}};
    const auto warnings = large_loads(fitted->problem, smallest_side_mm(fitted->mesh), 1);
    print_warnings(warnings);
    if (!warnings.empty()) report["warnings"] = warnings;
    if (o.noise_mm > 0) report["noise_mm"] = o.noise_mm;
    std::optional<FitResult> last;
    std::vector<FitInterval> intervals;
    for (const std::string& method : methods_of(o)) {
        auto result = run_method(method, o, *fitted, intervals, report, arena);
        if (!result) return bad_input(result.error().message);
        last = std::move(*result);
    }
    std::optional<CreepResult> creep;
    if (!o.creep.empty()) {
        bar.emplace("creep");
        const auto found = find_creep(o, *input, *fitted, *last, arena);
        bar.reset();
        if (!found) return bad_input(found.error().message);
        creep = *found;
        print(*creep);
        report["creep"] = json_of(*creep);
    }
    if (!files.network.empty()) {
        NetworkFile network = network_of(*fitted, *last, intervals, creep ? &*creep : nullptr);
        network.mesh = input->name;
        if (const Status s = write_network(files.network, network); !s)
            return bad_input(s.error().message);
    }
    if (!files.vtu.empty())
        if (const Status s = write_fitted(files.vtu, *input, *fitted, last->values); !s)
            return bad_input(s.error().message);
    if (!files.report.empty())
        if (const Status s = write_report(files.report, report); !s)
            return bad_input(s.error().message);
    if (const Status s = files.staged.commit(); !s) return bad_input(s.error().message);
    return kExitOk;
}

}  // namespace pliant::app
