// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Identification of spring lattices: table and report.

#include <pliant/files.h>
#include <pliant/fit.h>

#include <charconv>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <optional>
#include <string_view>

#include "options.h"
#include "progress.h"

namespace pliant::app {
namespace {

using Json = nlohmann::ordered_json;
constexpr const char* kFaces[] = {"-x", "+x", "-y", "+y", "-z", "+z"};

/// Parses numbers separated by commas; empty for invalid text.
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

std::optional<BoxFace> face_of(std::string_view text) {
    for (int n = 0; n < 6; ++n)
        if (text == kFaces[n]) return BoxFace(n);
    return std::nullopt;
}

/// Parses FACE:FX,FY,FZ[:ACROSS,ALONG[:NODES]].
std::optional<FitBoxLoad> load_of(const std::string& text) {
    std::vector<std::string> parts{""};
    for (const char c : text) {
        if (c == ':') {
            parts.emplace_back();
        } else {
            parts.back() += c;
        }
    }
    if (parts.size() < 2 || parts.size() > 4) return std::nullopt;
    const auto face = face_of(parts[0]);
    const auto force = numbers_of(parts[1]);
    if (!face || force.size() != 3) return std::nullopt;
    FitBoxLoad load{.name = text, .force_n = {force[0], force[1], force[2]}, .face = *face};
    if (parts.size() > 2) {
        const auto place = numbers_of(parts[2]);
        if (place.size() != 2) return std::nullopt;
        load.across = place[0];
        load.along = place[1];
    }
    if (parts.size() > 3) {
        const auto nodes = numbers_of(parts[3]);
        if (nodes.size() != 1 || !(nodes[0] >= 1 && nodes[0] <= 10000)) return std::nullopt;
        load.nodes_across = std::int32_t(nodes[0]);
    }
    return load;
}

Error bad_option(const std::string& option, const std::string& expected, const std::string& found) {
    return {ErrorCode::InvalidArgument,
            option + ": expected " + expected + ", found '" + found + "'"};
}

Result<FitBox> box_of(const FitOptions& o) {
    FitBox box;
    const auto size = numbers_of(o.size);
    if (size.size() != 3) return bad_option("--size", "three numbers", o.size);
    for (int a = 0; a < 3; ++a) {
        const double n = size[std::size_t(a)];
        if (!(n >= 2 && n <= 10000) || n != double(int(n)))
            return bad_option("--size", "whole numbers from 2 on", o.size);
        box.size[a] = int(n);
    }
    auto spacing = numbers_of(o.spacing_mm);
    if (spacing.size() == 1) spacing.resize(3, spacing[0]);
    if (spacing.size() != 3) return bad_option("--spacing", "one or three numbers", o.spacing_mm);
    box.spacing_mm = {spacing[0], spacing[1], spacing[2]};
    box.young_modulus_pa = o.young_pa;
    box.poisson_ratio = o.poisson;
    box.density_kg_per_m3 = o.density_kg_m3;
    if (o.element == "incompatible") box.element = HexElement::IncompatibleModes;
    box.held = face_of(o.held).value_or(BoxFace::LowZ);
    for (const auto& [loads, held_out] : {std::pair(&o.loads, false), std::pair(&o.held_out, true)})
        for (const std::string& text : *loads) {
            auto load = load_of(text);
            if (!load)
                return bad_option(held_out ? "--held-out" : "--load",
                                  "FACE:FX,FY,FZ[:ACROSS,ALONG[:NODES]]", text);
            load->held_out = held_out;
            box.loads.push_back(std::move(*load));
        }
    if (o.loads.empty()) box.loads.push_back({.name = "+z:0,0,-40", .force_n = {0, 0, -40}});
    if (o.links == "edges") box.links = LatticeLinks::Edges;
    if (o.links == "edges+faces+body") box.links = LatticeLinks::EdgesFacesAndBody;
    if (o.groups == "kinds") box.groups = FitBoxGroups::Kinds;
    if (o.groups == "directions") box.groups = FitBoxGroups::Directions;
    box.volume_energy = o.volume;
    box.shared_by_cells = o.by_cells;
    box.damping = o.damping_kg_s > 0;
    box.damping_start_kg_s = o.damping_kg_s;
    box.range = o.range;
    if (o.motion == "equilibrium") box.settings.motion = FitMotion::Equilibrium;
    if (o.motion == "run") box.settings.motion = FitMotion::Run;
    if (o.cost == "squares") box.settings.cost = FitCost::Squares;
    box.settings.duration = o.duration_s;
    box.settings.run.depth = o.depth;
    return box;
}

FitMethod method_of(const std::string& name, const FitOptions& o, const FitBoxProblem& box) {
    if (name == "closed-form") return GivenValues{box.closed_form};
    if (name == "gauss-newton") return GaussNewton{};
    if (name == "annealing")
        return Annealing{.seed = o.seed,
                         .start_temperature = o.start_temperature,
                         .cooling = o.cooling,
                         .evaluations = o.evaluations};
    const auto method = name == "bobyqa"        ? DirectMethod::Bobyqa
                        : name == "nelder-mead" ? DirectMethod::NelderMead
                                                : DirectMethod::Subplex;
    return DirectSearch{.method = method, .evaluations = o.evaluations};
}

const char* name_of(FitBound bound) {
    return bound == FitBound::Low ? "lower" : "upper";
}

/// Warning if the box violates an assumption of the method; otherwise empty.
std::string note_on(const std::string& method, const FitBoxProblem& box) {
    if (method != "closed-form" || box.cubic_cells) return {};
    return "the closed form is derived for cubic cells; these are not, and it may be far off";
}

Json method_json(const std::string& method, const FitBoxProblem& box, const FitResult& r) {
    Json values, at_bound = Json::object(), cases = Json::array(), directions = Json::array(),
                 trace = Json::array();
    const auto groups = box.problem.groups();
    for (std::size_t g = 0; g < groups.size(); ++g) {
        values[groups[g].name] = r.values[g];
        if (r.at_bound[g] != FitBound::None)
            at_bound[groups[g].name] = {{"bound", name_of(r.at_bound[g])},
                                        {"low", groups[g].low},
                                        {"high", groups[g].high}};
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
    if (const std::string note = note_on(method, box); !note.empty()) json["note"] = note;
    if (method == "annealing")
        json["annealing"] = {{"start_temperature", r.start_temperature},
                             {"end_temperature", r.end_temperature},
                             {"cooling", r.cooling}};
    return json;
}

void print(const std::string& method, const FitBoxProblem& box, const FitResult& r) {
    std::printf("\n%s: cost %g, %lld evaluations, %.2f s\n", method.c_str(), r.at.cost,
                static_cast<long long>(r.evaluations), r.seconds);
    const auto groups = box.problem.groups();
    for (std::size_t g = 0; g < groups.size(); ++g) {
        std::printf("  %-16s %.6g", groups[g].name.c_str(), r.values[g]);
        if (r.at_bound[g] != FitBound::None)
            std::printf("  at its %s bound; a larger --range may fit better",
                        name_of(r.at_bound[g]));
        std::printf("\n");
    }
    if (const std::string note = note_on(method, box); !note.empty())
        std::printf("  note: %s\n", note.c_str());
    std::printf("  %-32s %9s %9s   %s\n", "error [% of the spacing]", "average", "largest",
                "nothing moves");
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

Status write_report(const std::filesystem::path& path, const Json& report) {
    std::ofstream file(path, std::ios::binary);
    file << report.dump(2) << '\n';
    file.close();
    if (file) return Ok{};
    return Error{ErrorCode::Unwritable, path.string() + ": can't be written"};
}

}  // namespace

int run_fit(const FitOptions& o) {
    const auto settings = box_of(o);
    if (!settings) return bad_input(settings.error().message);
    // Stage the report before the long work.
    StagedFiles files;
    std::filesystem::path report_file;
    if (!o.report.empty()) {
        const auto place = files.stage(o.report);
        if (!place) return bad_input(place.error().message);
        report_file = *place;
    }
    const TaskArena arena(o.threads);
    std::optional<ProgressBar> bar(std::in_place, "fit");
    const auto box = fit_box(*settings, arena);
    bar.reset();
    if (!box) return bad_input("fit: " + box.error().message);
    std::vector<std::string> methods = o.methods;
    if (methods.empty()) methods = {"closed-form", "gauss-newton"};
    Json report{{"motion", o.motion}, {"cost", o.cost}, {"methods", Json::array()}};
    for (const std::string& method : methods) {
        bar.emplace(method);
        const auto result = fit(box->problem, method_of(method, o, *box), arena);
        bar.reset();
        if (!result) return bad_input(method + ": " + result.error().message);
        print(method, *box, *result);
        report["methods"].push_back(method_json(method, *box, *result));
    }
    if (!report_file.empty())
        if (const Status s = write_report(report_file, report); !s)
            return bad_input(s.error().message);
    if (const Status s = files.commit(); !s) return bad_input(s.error().message);
    return kExitOk;
}

}  // namespace pliant::app
