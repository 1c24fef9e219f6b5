// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "fit_report.h"

#include <pliant/core/output_file.h>

#include <algorithm>
#include <charconv>
#include <cstdio>

namespace pliant::app {
namespace {

const char* name_of(FitBound bound) {
    return bound == FitBound::Low ? "lower" : "upper";
}

Json interval_json(const FitInterval& interval) {
    if (!interval.identifiable) return {{"identifiable", false}};
    return {{"identifiable", true}, {"low", interval.low}, {"high", interval.high}};
}

}  // namespace

std::vector<double> numbers_of(std::string_view text) {
    std::vector<double> numbers;
    for (;;) {
        const auto comma = text.find(',');
        const std::string_view part = text.substr(0, comma);
        double number = 0;
        const auto [end, error] = std::from_chars(part.data(), part.data() + part.size(), number);
        if (error != std::errc{} || end != part.data() + part.size()) return {};
        numbers.push_back(number);
        if (comma == std::string_view::npos) return numbers;
        text.remove_prefix(comma + 1);
    }
}

Error bad_option(const std::string& option, const std::string& expected, const std::string& found) {
    return {ErrorCode::InvalidArgument,
            option + ": expected " + expected + ", found '" + found + "'"};
}

FitSettings settings_of(const FitOptions& o) {
    FitSettings settings;
    if (o.motion == "equilibrium") settings.motion = FitMotion::Equilibrium;
    if (o.motion == "run") settings.motion = FitMotion::Run;
    if (o.cost == "squares") settings.cost = FitCost::Squares;
    settings.duration = o.duration_s;
    settings.run.depth = o.depth;
    return settings;
}

std::vector<std::string> methods_of(const FitOptions& o) {
    if (o.methods.empty()) return {"closed-form", "gauss-newton"};
    return o.methods;
}

FitMethod method_of(const std::string& name, const FitOptions& o,
                    const std::vector<double>& closed_form) {
    if (name == "closed-form") return GivenValues{closed_form};
    if (name == "gauss-newton") return GaussNewton{};
    return Annealing{.seed = o.seed,
                     .start_temperature = o.start_temperature,
                     .cooling = o.cooling,
                     .by_turns = !o.mesh.empty(),
                     .evaluations = o.evaluations};
}

Json method_json(const std::string& method, const FitTable& table) {
    const FitResult& r = table.result;
    Json values, intervals, at_bound = Json::object(), cases = Json::array(),
                            directions = Json::array(), trace = Json::array();
    const auto groups = table.problem.groups();
    for (std::size_t g = 0; g < groups.size(); ++g) {
        values[groups[g].name] = r.values[g];
        if (r.at_bound[g] != FitBound::None)
            at_bound[groups[g].name] = {{"bound", name_of(r.at_bound[g])},
                                        {"low", groups[g].low},
                                        {"high", groups[g].high}};
        if (!table.intervals.empty()) intervals[groups[g].name] = interval_json(table.intervals[g]);
    }
    for (const FitCaseErrors& c : r.at.cases)
        cases.push_back({{"load", c.name},
                         {"held_out", c.held_out},
                         {"average_percent", c.average_percent},
                         {"largest_percent", c.largest_percent},
                         {"still_average_percent", c.still_average_percent},
                         {"still_largest_percent", c.still_largest_percent}});
    for (const FitDirection& d : r.directions) {
        Json direction;
        for (std::size_t g = 0; g < groups.size(); ++g) direction[groups[g].name] = d.direction[g];
        directions.push_back({{"influence", d.influence},
                              {"identifiable", d.influence >= kMinInfluence},
                              {"direction", direction}});
    }
    for (const FitTrace& t : r.trace)
        trace.push_back({{"evaluation", t.evaluation}, {"cost", t.cost}, {"seconds", t.seconds}});
    Json json{{"method", method},
              {"values", values},
              {"at_bound", at_bound},
              {"cost", r.at.cost},
              {"evaluations", r.evaluations},
              {"refused", r.refused},
              {"seconds", r.seconds},
              {"cases", cases},
              {"directions", directions},
              {"trace", trace}};
    if (!table.intervals.empty()) json["intervals_95"] = intervals;
    if (!table.note.empty()) json["note"] = table.note;
    if (method == "annealing")
        json["annealing"] = {{"start_temperature", r.start_temperature},
                             {"end_temperature", r.end_temperature},
                             {"cooling", r.cooling}};
    return json;
}

void print(const std::string& method, const FitTable& table) {
    const FitResult& r = table.result;
    std::printf("\n%s: cost %g, %lld evaluations, %.2f s\n", method.c_str(), r.at.cost,
                static_cast<long long>(r.evaluations), r.seconds);
    const auto groups = table.problem.groups();
    for (std::size_t g = 0; g < groups.size(); ++g) {
        std::printf("  %-16s %.6g", groups[g].name.c_str(), r.values[g]);
        if (!table.intervals.empty() && table.intervals[g].identifiable)
            std::printf("  (95 %%: %.6g to %.6g)", table.intervals[g].low, table.intervals[g].high);
        if (r.at_bound[g] != FitBound::None)
            std::printf("  at its %s bound; a larger --range may fit better",
                        name_of(r.at_bound[g]));
        std::printf("\n");
    }
    if (!table.note.empty()) std::printf("  note: %s\n", table.note.c_str());
    const std::string heading = std::string("error [% of the ") + table.length + "]";
    std::printf("  %-32s %9s %9s   %s\n", heading.c_str(), "average", "largest", "nothing moves");
    for (const FitCaseErrors& c : r.at.cases)
        std::printf("  %-32s %9.3f %9.3f   %.3f %.3f%s\n", c.name.c_str(), c.average_percent,
                    c.largest_percent, c.still_average_percent, c.still_largest_percent,
                    c.held_out ? "  held out" : "");
    for (const FitDirection& d : r.directions) {
        if (d.influence >= kMinInfluence) continue;
        std::printf("  not identifiable:");
        for (std::size_t g = 0; g < groups.size(); ++g)
            if (d.direction[g] * d.direction[g] > 1e-4)
                std::printf(" %s %+.2f", groups[g].name.c_str(), d.direction[g]);
        std::printf("\n");
    }
}

std::vector<std::string> large_loads(const FitProblem& problem, double smallest_side, double mm) {
    constexpr double kLargeShare = 0.15;
    std::vector<std::string> warnings;
    for (const FitCase& c : problem.cases()) {
        // A network in equilibrium can follow large measured displacements.
        if (c.target.empty() && problem.settings().motion != FitMotion::Linear) continue;
        double largest = 0;
        for (const Vec3d& u : c.target) largest = std::max(largest, norm(u));
        for (const FitPointTarget& point : c.points)
            largest = std::max(largest, norm(point.displacement));
        if (!(largest > kLargeShare * smallest_side)) continue;
        char text[200];
        std::snprintf(text, sizeof text,
                      "moves up to %.3g mm, %.0f %% of the smallest side: too far for linear "
                      "elements, expected at most %.0f %%",
                      mm * largest, 100 * largest / smallest_side, 100 * kLargeShare);
        warnings.push_back("load " + c.name + ": " + text);
    }
    return warnings;
}

void print_warnings(const std::vector<std::string>& warnings) {
    for (const std::string& warning : warnings) std::printf("warning: %s\n", warning.c_str());
}

Status write_report(const std::filesystem::path& path, const Json& report) {
    OutputFile file(path);
    file.write(report.dump(2) + '\n');
    return file.close();
}

}  // namespace pliant::app
