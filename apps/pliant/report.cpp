// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "report.h"

#include <sys/resource.h>

#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>

namespace pliant::app {
namespace {

using Json = nlohmann::ordered_json;

Json json_of(Vec3d v) {
    return Json::array({v.x, v.y, v.z});
}
Json json_of(Vec3i v) {
    return Json::array({v.x, v.y, v.z});
}

std::string hex(std::uint64_t value) {
    char text[17];
    std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(value));
    return text;
}

double peak_memory_mb() {
    rusage usage{};
    ::getrusage(RUSAGE_SELF, &usage);
    return double(usage.ru_maxrss) * 1024 / 1e6;
}

Json push_json(const PushOption& option, const PushReport& report) {
    Json json;
    json["point_mm"] = json_of(option.point_mm);
    json["push_mm"] = json_of(option.push_mm);
    json["status"] = name_of(report.status);
    json["limited_by"] = name_of(report.limited_by);
    json["step_fraction"] = report.step_fraction;
    json["grabbed_elements"] = report.grabbed_elements;
    json["moved_elements"] = report.moved_elements;
    json["solve_ms"] = report.solve_ms;
    if (!report.message.empty()) json["message"] = report.message;
    return json;
}

Json slide_json(const SlideOption& option, const SlideReport& report) {
    Json json;
    json["point_mm"] = json_of(option.point_mm);
    json["way_mm"] = json_of(option.way_mm);
    json["limited_by"] = name_of(report.limited_by);
    json["way_fraction"] = report.way_fraction;
    json["contacts"] = report.contacts;
    json["end_mm"] = json_of(report.end_mm);
    json["inside_elements"] = report.inside_elements;
    json["slide_ms"] = report.slide_ms;
    return json;
}

Json springs_json(const SpringResult& springs) {
    Json json;
    json["cell_voxels"] = json_of(springs.cell_voxels);
    json["nodes"] = json_of(springs.nodes);
    json["fixed_nodes"] = springs.fixed_nodes;
    json["active_nodes"] = springs.active_nodes;
    json["depth"] = springs.depth;
    json["young_modulus_pa"] = springs.young_modulus_pa;
    json["time_step_ms"] = springs.time_step_ms;
    json["steps"] = springs.steps;
    json["settled"] = springs.settled;
    json["steps_ms"] = springs.solve_ms;
    json["force_n"] = json_of(springs.force_n);
    return json;
}

/// Converts a slide to a push along its path.
PushReport as_push(const SlideReport& slide) {
    PushReport push;
    push.status = slide.limited_by == LimitedBy::None            ? PushStatus::Applied
                  : slide.contacts > 0 || slide.way_fraction > 0 ? PushStatus::Limited
                                                                 : PushStatus::Rejected;
    push.limited_by = slide.limited_by;
    push.step_fraction = slide.way_fraction;
    push.solve_ms = slide.slide_ms;
    return push;
}

/// Summary of all pushes and slides: rejected if all were rejected, applied if all were applied in
/// full.
PushReport summary_of(const DeformResult& result) {
    std::vector<PushReport> pushes = result.pushes;
    for (const SlideReport& slide : result.slides) pushes.push_back(as_push(slide));
    PushReport all;
    const auto count = [&](PushStatus status) {
        return std::count_if(pushes.begin(), pushes.end(),
                             [&](const PushReport& p) { return p.status == status; });
    };
    const auto total = std::ptrdiff_t(pushes.size());
    all.status = count(PushStatus::Applied) == total    ? PushStatus::Applied
                 : count(PushStatus::Rejected) == total ? PushStatus::Rejected
                                                        : PushStatus::Limited;
    all.step_fraction = 1;
    for (const PushReport& push : pushes) {
        all.solve_ms += push.solve_ms;
        if (push.step_fraction >= all.step_fraction) continue;
        all.step_fraction = push.step_fraction;
        all.limited_by = push.limited_by;
        all.message = push.message;
    }
    return all;
}

/// Name of the quantity that the summary's fraction refers to.
const char* name_of_ways(std::size_t pushes, std::size_t slides) {
    if (pushes + slides == 0) return "the request";
    if (pushes + slides > 1) return slides == 0 ? "the shortest push" : "the shortest way";
    return slides == 0 ? "the push" : "the sphere's way";
}

}  // namespace

std::string report_json(const DeformOptions& options, const DeformResult& result) {
    const PushReport all = summary_of(result);
    const Deformed& deformed = result.deformed;
    Json json;
    json["status"] = name_of(all.status);
    json["limited_by"] = name_of(all.limited_by);
    json["step_fraction"] = all.step_fraction;
    json["moved_elements"] = result.state.moved_elements;
    json["max_movement_mm"] = result.state.max_movement_mm;
    json["max_violation_mm"] = result.state.max_violation_mm;
    json["folded_cells"] = result.state.folded_cells;
    if (!result.springs) {
        json["no_fold_certified"] = result.certificate.certified;
        json["certificate"] = {{"all", result.certificate.all},
                               {"tissue", result.certificate.tissue}};
    }
    json["cut_links"] = result.state.cut_links;
    json["carved_elements"] = result.state.carved_elements;
    json["solve_ms"] = all.solve_ms + (result.springs ? result.springs->solve_ms : 0);
    json["edit_ms"] = result.edit_ms;
    if (result.relax) {
        json["relax_ms"] = result.relax->relax_ms;
        json["relax_sweeps"] = result.relax->sweeps;
        json["relax_settled"] = result.relax->settled;
        json["energy_before"] = result.relax->energy_before_mm2;
        json["energy_after"] = result.relax->energy_after_mm2;
        json["energy_unit"] = "mm^2 * weight";
    }
    json["resample_ms"] = deformed.resample_ms;
    json["dirty_box_ijk"] =
        is_empty(deformed.dirty_box)
            ? Json(nullptr)
            : Json::array({json_of(deformed.dirty_box.begin), json_of(deformed.dirty_box.end)});
    json["written_voxels"] = deformed.written_voxels;
    json["gap_voxels"] = deformed.gap_voxels;
    json["resident_bricks"] = result.state.resident_bricks;
    json["bytes_per_resident_element"] = result.state.bytes_per_resident_element;
    json["peak_memory_mb"] = peak_memory_mb();
    json["hash"] = hex(result.hash);
    json["file"] = options.file;
    json["tool"] = options.sphere_radius_mm > 0 ? "sphere" : "point";
    if (options.sphere_radius_mm > 0) json["sphere_radius_mm"] = options.sphere_radius_mm;
    json["model"] = options.model;
    json["solver"] = result.springs           ? "force-transmittal"
                     : options.solver.empty() ? "sweep"
                                              : options.solver;
    if (result.springs) json["springs"] = springs_json(*result.springs);
    json["mapping"] = options.mapping;
    json["pushes"] = json["slides"] = Json::array();
    auto report = result.pushes.begin();
    auto slid = result.slides.begin();
    for (const DeformAction& action : options.actions)
        if (const auto* push = std::get_if<PushOption>(&action))
            json["pushes"].push_back(push_json(*push, *report++));
        else if (const auto* slide = std::get_if<SlideOption>(&action))
            json["slides"].push_back(slide_json(*slide, *slid++));
    json["notes"] = result.notes;
    return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string report_text(const DeformResult& result) {
    const PushReport all = summary_of(result);
    char line[256];
    std::snprintf(line, sizeof line,
                  "%s: %.1f %% of %s done, %lld elements moved by up to %.2f mm\n"
                  "solve %.2f ms, resample %.2f ms, %lld voxels written\n",
                  std::string(name_of(all.status)).c_str(), 100 * all.step_fraction,
                  name_of_ways(result.pushes.size(), result.slides.size()),
                  static_cast<long long>(result.state.moved_elements), result.state.max_movement_mm,
                  all.solve_ms + (result.springs ? result.springs->solve_ms : 0),
                  result.deformed.resample_ms,
                  static_cast<long long>(result.deformed.written_voxels));
    std::string text = line;
    if (result.state.cut_links + result.state.carved_elements > 0) {
        std::snprintf(line, sizeof line, "%lld links cut, %lld elements carved away\n",
                      static_cast<long long>(result.state.cut_links),
                      static_cast<long long>(result.state.carved_elements));
        text += line;
    }
    if (result.springs) {
        const SpringResult& springs = *result.springs;
        std::snprintf(line, sizeof line,
                      "%d x %d x %d control nodes, %d moved to depth %d, %lld steps of %.3g ms%s\n",
                      springs.nodes.x, springs.nodes.y, springs.nodes.z, springs.active_nodes,
                      springs.depth, static_cast<long long>(springs.steps), springs.time_step_ms,
                      springs.settled ? " (at rest)" : "");
        text += line;
    }
    if (result.relax) {
        std::snprintf(line, sizeof line, "relaxed %.2f ms, %d sweeps%s, energy %.4g to %.4g mm2\n",
                      result.relax->relax_ms, result.relax->sweeps,
                      result.relax->settled ? " (settled)" : "", result.relax->energy_before_mm2,
                      result.relax->energy_after_mm2);
        text += line;
    }
    for (const SlideReport& slide : result.slides)
        if (slide.inside_elements > 0) {
            std::snprintf(line, sizeof line, "%lld elements are still inside of the sphere\n",
                          static_cast<long long>(slide.inside_elements));
            text += line;
        }
    if (!all.message.empty()) text += all.message + "\n";
    return text;
}

}  // namespace pliant::app
