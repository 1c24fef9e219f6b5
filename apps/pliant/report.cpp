// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "report.h"

#include <sys/resource.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <type_traits>
#include <utility>
#include <variant>

#include "json.h"
#include "output_text.h"

namespace pliant::app {
namespace {

Json json_of(Vec3d v) {
    return Json::array({v.x, v.y, v.z});
}
Json json_of(Vec3i v) {
    return Json::array({v.x, v.y, v.z});
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

/// Writes a figure; a name with a dot is a member of an object.
void put(const NamedValue& figure, Json& json) {
    const auto dot = figure.name.find('.');
    if (dot == std::string::npos)
        json[figure.name] = value_json(figure.value);
    else
        json[figure.name.substr(0, dot)][figure.name.substr(dot + 1)] = value_json(figure.value);
}

/// A number by its name, or 0.
double number_of(const Record& record, std::string_view name) {
    const SettingValue* value = find_figure(record, name);
    if (!value) return 0;
    const auto* whole = std::get_if<std::int64_t>(value);
    const auto* number = std::get_if<double>(value);
    return whole ? double(*whole) : number ? *number : 0;
}

/// Time step among the figures of a tissue, whose objects have different names; 0: none.
double time_step_ms_of(const Record& figures) {
    for (const NamedValue& figure : figures)
        if (figure.name.ends_with(".time_step_ms")) return number_of(figures, figure.name);
    return 0;
}

/// Keys in the order in which a report has them; figures of a single model come after them.
constexpr const char* kOrder[] = {"status",
                                  "limited_by",
                                  "step_fraction",
                                  "moved_elements",
                                  "max_movement_mm",
                                  "max_violation_mm",
                                  "folded_cells",
                                  "no_fold_certified",
                                  "certificate",
                                  "cut_links",
                                  "carved_elements",
                                  "solve_ms",
                                  "edit_ms",
                                  "relax_ms",
                                  "relax_sweeps",
                                  "relax_settled",
                                  "energy_before",
                                  "energy_after",
                                  "energy_unit",
                                  "resample_ms",
                                  "dirty_box_ijk",
                                  "written_voxels",
                                  "gap_voxels",
                                  "resident_bricks",
                                  "bytes_per_resident_element",
                                  "peak_memory_mb",
                                  "hash",
                                  "file",
                                  "tool",
                                  "sphere_radius_mm",
                                  "model",
                                  "solver"};

/// Time after the actions, as a part of the model's figures, or as a relaxation.
void put(const DeformOptions& options, const Advanced& advanced, Json& json) {
    const AdvanceReport& report = advanced.report;
    if (advanced.energy_before_mm2 && advanced.energy_after_mm2) {
        json["relax_ms"] = report.ms;
        json["relax_sweeps"] = report.steps;
        json["relax_settled"] = report.settled;
        json["energy_before"] = *advanced.energy_before_mm2;
        json["energy_after"] = *advanced.energy_after_mm2;
        json["energy_unit"] = "mm^2 * weight";
        return;
    }
    Json& own = json[options.model];
    own["steps"] = report.steps;
    own["settled"] = report.settled;
    own["steps_ms"] = report.ms;
    if (!report.message.empty()) own["stopped"] = report.message;
    if (advanced.force_n) own["force_n"] = json_of(*advanced.force_n);
}

/// Time of the pushes, and of the steps of a tissue that moves by itself.
double solve_ms_of(const PushReport& all, const DeformResult& result) {
    const bool moves = result.advanced && !result.advanced->energy_before_mm2;
    return all.solve_ms + (moves ? result.advanced->report.ms : 0);
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
    push.message = slide.message;
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

const SettingValue* find_figure(const Record& record, std::string_view name) {
    for (const NamedValue& figure : record)
        if (figure.name == name) return &figure.value;
    return nullptr;
}

void add_figures(const DeformationState& state, Record& record) {
    const auto add = [&](const char* name, SettingValue value) {
        if (!find_figure(record, name)) record.emplace_back(name, std::move(value));
    };
    add("moved_elements", state.moved_elements);
    add("max_movement_mm", state.max_movement_mm);
    add("max_violation_mm", 0.0);
    add("folded_cells", state.folded_cells);
    add("cut_links", state.cut_links);
    add("carved_elements", state.carved_elements);
    add("resident_bricks", state.resident_bricks);
    add("bytes_per_resident_element", state.bytes_per_resident_element);
}

std::string report_json(const DeformOptions& options, const DeformResult& result) {
    const PushReport all = summary_of(result);
    const Deformed& deformed = result.deformed;
    Json json;
    for (const char* key : kOrder) json[key] = Json();
    for (const NamedValue& figure : result.figures)
        if (figure.name != "summary") put(figure, json);
    json["status"] = name_of(all.status);
    json["limited_by"] = name_of(all.limited_by);
    json["step_fraction"] = all.step_fraction;
    json["solve_ms"] = solve_ms_of(all, result);
    json["edit_ms"] = result.edit_ms;
    if (result.advanced) put(options, *result.advanced, json);
    json["resample_ms"] = deformed.resample_ms;
    json["written_voxels"] = deformed.written_voxels;
    json["gap_voxels"] = deformed.gap_voxels;
    json["peak_memory_mb"] = peak_memory_mb();
    json["hash"] = hex_of(result.hash);
    json["file"] = options.file;
    json["tool"] = options.sphere_radius_mm > 0 ? "sphere" : "point";
    if (options.sphere_radius_mm > 0) json["sphere_radius_mm"] = options.sphere_radius_mm;
    json["model"] = options.model;
    for (const char* key : kOrder)
        if (json[key].is_null() && std::string_view(key) != "dirty_box_ijk") json.erase(key);
    if (!is_empty(deformed.dirty_box))
        json["dirty_box_ijk"] =
            Json::array({json_of(deformed.dirty_box.begin), json_of(deformed.dirty_box.end)});
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

std::string report_text(const DeformOptions& options, const DeformResult& result) {
    const PushReport all = summary_of(result);
    const Record& figures = result.figures;
    char line[256];
    std::snprintf(line, sizeof line,
                  "%s: %.1f %% of %s done, %.0f elements moved by up to %.2f mm\n"
                  "solve %.2f ms, resample %.2f ms, %lld voxels written\n",
                  std::string(name_of(all.status)).c_str(), 100 * all.step_fraction,
                  name_of_ways(result.pushes.size(), result.slides.size()),
                  number_of(figures, "moved_elements"), number_of(figures, "max_movement_mm"),
                  solve_ms_of(all, result), result.deformed.resample_ms,
                  static_cast<long long>(result.deformed.written_voxels));
    std::string text = line;
    const double cut = number_of(figures, "cut_links"),
                 carved = number_of(figures, "carved_elements");
    if (cut + carved > 0) {
        std::snprintf(line, sizeof line, "%.0f links cut, %.0f elements carved away\n", cut,
                      carved);
        text += line;
    }
    if (const SettingValue* summary = find_figure(figures, "summary"))
        text += std::get<std::string>(*summary);
    else if (result.advanced)
        text += options.model;
    if (result.advanced) {
        const AdvanceReport& time = result.advanced->report;
        const auto& before = result.advanced->energy_before_mm2;
        const auto& after = result.advanced->energy_after_mm2;
        if (before && after)
            std::snprintf(line, sizeof line,
                          "relaxed %.2f ms, %lld sweeps%s, energy %.4g to %.4g mm2\n", time.ms,
                          static_cast<long long>(time.steps), time.settled ? " (settled)" : "",
                          *before, *after);
        else
            std::snprintf(line, sizeof line, ", %lld steps of %.3g ms%s\n",
                          static_cast<long long>(time.steps), time_step_ms_of(figures),
                          !time.message.empty() ? " (stopped)"
                          : time.settled        ? " (at rest)"
                          : options.steps       ? ""
                                                : " (still moving; --steps N goes on for longer)");
        text += line;
        if (!time.message.empty()) text += "warning: motion stopped: " + time.message + "\n";
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
