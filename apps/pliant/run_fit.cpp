// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Identification of spring lattices: table and report.

#include <pliant/core/files.h>
#include <pliant/models/fit.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <optional>
#include <string_view>
#include <utility>

#include "fit_report.h"
#include "options.h"
#include "progress.h"

namespace pliant::app {
namespace {

constexpr const char* kFaces[] = {"-x", "+x", "-y", "+y", "-z", "+z"};

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

/// Sets the fibres: all of their constants, or none.
Status set_fibres(const FitOptions& o, FitBox& box) {
    const std::pair<const char*, const std::optional<double>*> constants[] = {
        {"--fibre-young", &o.fibre_young_pa},
        {"--fibre-poisson", &o.fibre_poisson},
        {"--fibre-shear", &o.fibre_shear_pa}};
    for (const auto& [option, value] : constants) {
        if (o.fibre.empty() && value->has_value())
            return Error{ErrorCode::InvalidArgument,
                         std::string(option) + ": expected --fibre X,Y,Z too, found none"};
        if (!o.fibre.empty() && !value->has_value())
            return Error{ErrorCode::InvalidArgument,
                         std::string(option) + ": expected a number beside --fibre, found none"};
    }
    if (o.fibre.empty()) return Ok{};
    const auto fibre = numbers_of(o.fibre);
    if (fibre.size() == 3) box.fibre = {fibre[0], fibre[1], fibre[2]};
    const double length = norm(box.fibre);
    if (!(std::isfinite(length) && length > 0))
        return bad_option("--fibre", "a direction of three numbers", o.fibre);
    for (const auto& [option, value] : {std::pair("--fibre-young", o.fibre_young_pa),
                                        std::pair("--fibre-shear", o.fibre_shear_pa)})
        if (!(std::isfinite(*value) && *value > 0))
            return Error{ErrorCode::InvalidArgument, std::string(option) +
                                                         ": expected a modulus above 0, found " +
                                                         std::to_string(*value)};
    box.fibre_young_modulus_pa = *o.fibre_young_pa;
    box.fibre_poisson_ratio = *o.fibre_poisson;
    box.fibre_shear_modulus_pa = *o.fibre_shear_pa;
    return Ok{};
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
    box.young_modulus_pa = o.young_pa.value_or(box.young_modulus_pa);
    box.poisson_ratio = o.poisson;
    if (const Status s = set_fibres(o, box); !s) return s.error();
    box.density_kg_per_m3 = o.density_kg_m3.value_or(box.density_kg_per_m3);
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
    box.settings = settings_of(o);
    return box;
}

Json fibre_json(const FitBox& box) {
    return {{"young_modulus_pa", box.young_modulus_pa},
            {"poisson_ratio", box.poisson_ratio},
            {"fibre", {box.fibre.x, box.fibre.y, box.fibre.z}},
            {"fibre_young_modulus_pa", box.fibre_young_modulus_pa},
            {"fibre_poisson_ratio", box.fibre_poisson_ratio},
            {"fibre_shear_modulus_pa", box.fibre_shear_modulus_pa}};
}

/// Warning if the box violates an assumption of the method; otherwise empty.
std::string note_on(const std::string& method, const FitBoxProblem& box, bool has_fibres) {
    if (method != "closed-form") return {};
    if (has_fibres)
        return "the closed form is derived for isotropic solids; with fibres it is only a start";
    if (box.cubic_cells) return {};
    return "the closed form is derived for cubic cells; these are not, and it may be far off";
}

}  // namespace

int run_fit(const FitOptions& o) {
    if (!o.mesh.empty()) return run_fit_mesh(o);
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
    Json report{{"motion", o.motion}, {"cost", o.cost}};
    constexpr double kMm = 1e3;  // per metre
    double side = std::numeric_limits<double>::infinity();
    for (int a = 0; a < 3; ++a)
        side = std::min(side, settings->spacing_mm[a] / kMm * (settings->size[a] - 1));
    const auto warnings = large_loads(box->problem, side, kMm);
    print_warnings(warnings);
    if (!warnings.empty()) report["warnings"] = warnings;
    if (!o.fibre.empty()) report["reference"] = fibre_json(*settings);
    report["methods"] = Json::array();
    for (const std::string& method : methods_of(o)) {
        bar.emplace(method);
        const auto result = fit(box->problem, method_of(method, o, box->closed_form), arena);
        bar.reset();
        if (!result) return bad_input(method + ": " + result.error().message);
        std::vector<FitInterval> intervals;
        if (o.noise_mm > 0) {
            constexpr double kMetres = 1e-3;  // per mm; the box's network is in metres
            auto found = fit_intervals(box->problem, result->values, kMetres * o.noise_mm, arena);
            if (!found) return bad_input(method + ": " + found.error().message);
            intervals = std::move(*found);
        }
        const FitTable table{box->problem, *result, intervals,
                             note_on(method, *box, !o.fibre.empty()), "spacing"};
        print(method, table);
        report["methods"].push_back(method_json(method, table));
    }
    if (!report_file.empty())
        if (const Status s = write_report(report_file, report); !s)
            return bad_input(s.error().message);
    if (const Status s = files.commit(); !s) return bad_input(s.error().message);
    return kExitOk;
}

}  // namespace pliant::app
