// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Description of a scan, as text or as one JSON object.

#include "options.h"
#include "progress.h"
#include "scan_defaults.h"
#include "shell_word.h"
#include "suggest_push.h"
#include "value_range.h"

#include <pliant/core/files.h>
#include <pliant/core/text.h>
#include <pliant/scan_files.h>
#include <pliant/volume.h>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <optional>

namespace pliant::app {
namespace {

/// Letter of an axis's dominant direction.
char letter_of(Vec3d axis) {
    int largest = 0;
    for (int a = 1; a < 3; ++a)
        if (std::abs(axis[a]) > std::abs(axis[largest])) largest = a;
    return (axis[largest] > 0 ? "LPS" : "RAI")[largest];
}

std::string orientation_of(const Grid& grid) {
    std::string letters;
    for (const Vec3d& axis : grid.direction.columns) letters += letter_of(axis);
    return letters;
}

/// Largest angle between an axis of the grid and the nearest axis of the body.
double oblique_angle_deg(const Grid& grid) {
    double smallest = 1;
    for (const Vec3d& v : grid.direction.columns)
        smallest = std::min(smallest, std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)}));
    constexpr double kDegrees = 57.29577951308232;
    return kDegrees * std::acos(std::min(1.0, smallest));
}

Vec3d extent_mm(const Grid& grid) {
    return {grid.size.x * grid.spacing_mm.x, grid.size.y * grid.spacing_mm.y,
            grid.size.z * grid.spacing_mm.z};
}

Vec3d centre_of(const Grid& grid) {
    return world_from_voxel(
        grid, {0.5 * (grid.size.x - 1), 0.5 * (grid.size.y - 1), 0.5 * (grid.size.z - 1)});
}

Vec3d ras_of(Vec3d lps_mm) {
    return {0 - lps_mm.x, 0 - lps_mm.y, lps_mm.z};  // no -0
}

WorldBox ras_box(const WorldBox& lps) {
    return {{-lps.high_mm.x, -lps.high_mm.y, lps.low_mm.z},
            {-lps.low_mm.x, -lps.low_mm.y, lps.high_mm.z}};
}

double memory_mb(const Volume& volume) {
    return double(voxel_count(volume.grid)) * (volume.is_16_bit() ? 2 : 4) / 1e6;
}

std::string vector_text(Vec3d v, const char* separator) {
    return short_text(v.x) + separator + short_text(v.y) + separator + short_text(v.z);
}

nlohmann::ordered_json list_of(Vec3d v) {
    return {v.x, v.y, v.z};
}

void print_object(const nlohmann::ordered_json& json) {
    // Invalid UTF-8 in a file is replaced, not refused.
    const std::string text =
        json.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
    std::printf("%s\n", text.c_str());
}

void print_json(const InfoOptions& options, const Volume& volume, const ReadNotes& notes,
                const ValueDefaults& values, const ValueRange& range,
                const std::optional<PushOption>& push) {
    const Grid& grid = volume.grid;
    nlohmann::ordered_json json;
    json["file"] = options.file;
    json["format"] = notes.format;
    json["stored_type"] = notes.stored_type;
    json["voxel_type"] = volume.is_16_bit() ? "int16" : "float32";
    json["size"] = {grid.size.x, grid.size.y, grid.size.z};
    json["spacing_mm"] = list_of(grid.spacing_mm);
    json["extent_mm"] = list_of(extent_mm(grid));
    json["origin_mm"] = list_of(grid.origin_mm);
    for (int row = 0; row < 3; ++row) {  // rows of the matrix, not a list of axes
        const auto& c = grid.direction.columns;
        json["direction"].push_back({c[0][row], c[1][row], c[2][row]});
    }
    json["orientation"] = orientation_of(grid);
    json["right_handed"] = determinant(grid.direction) > 0;
    const WorldBox box = centre_bounds(grid);
    const Vec3d centre = centre_of(grid);
    json["bounds_mm"] = {{"lps", {list_of(box.low_mm), list_of(box.high_mm)}},
                         {"ras", {list_of(ras_box(box).low_mm), list_of(ras_box(box).high_mm)}}};
    json["centre_mm"] = {{"lps", list_of(centre)}, {"ras", list_of(ras_of(centre))}};
    json["oblique_angle_deg"] = oblique_angle_deg(grid);
    json["modality"] = notes.modality;
    json["rescale_type"] = notes.rescale_type;
    json["taken_as"] = name_of(values.kind);
    json["reason"] = values.reason;
    json["unit"] = values.kind == ValueKind::Hounsfield ? "HU" : "";
    json["min"] = range.min;
    json["max"] = range.max;
    for (std::size_t p = 0; p < kPercentCount; ++p)
        json["percentiles"][std::to_string(int(kPercents[p]))] = range.percentiles[p];
    json["defaults"] = {{"window", values.window},
                        {"level", values.level},
                        {"iso", values.iso},
                        {"polarity", values.lumen_is_bright ? "falling" : "rising"},
                        {"range", {values.range.low, values.range.high}},
                        {"air_enabled", values.has_air},
                        {"air_threshold", values.air_threshold},
                        {"bone_threshold", values.bone_threshold},
                        {"background", values.background}};
    json["memory_mb"] = memory_mb(volume);
    json["key_values"] = nlohmann::ordered_json::object();
    for (const auto& [key, value] : volume.key_values) json["key_values"][key] = value;
    json["notes"] = notes.notes;
    if (push)
        json["suggested_push"] = {{"point_mm", list_of(push->point_mm)},
                                  {"push_mm", list_of(push->push_mm)},
                                  {"sphere_radius_mm", suggested_radius_mm(grid)}};
    print_object(json);
}

/// "1…2, 3…4, 5…6"
std::string bounds_text(const WorldBox& box) {
    std::string text;
    for (int a = 0; a < 3; ++a)
        text += (a ? ", " : "") + short_text(box.low_mm[a]) + "…" + short_text(box.high_mm[a]);
    return text;
}

void print_line(const char* name, const std::string& text) {
    constexpr std::size_t kMaxShownBytes = 300;
    std::printf("%-12s %s\n", name, printable(text, kMaxShownBytes).c_str());
}

void print_geometry(const Grid& grid) {
    const Vec3d size{double(grid.size.x), double(grid.size.y), double(grid.size.z)};
    print_line("size", vector_text(size, " × ") + " voxels");
    print_line("spacing", vector_text(grid.spacing_mm, " × ") + " mm");
    print_line("extent", vector_text(extent_mm(grid), " × ") + " mm");
    const std::string letters = orientation_of(grid);
    std::string orientation = {letters[0], ' ', letters[1], ' ', letters[2]};
    orientation += determinant(grid.direction) > 0 ? ", right-handed" : ", left-handed";
    if (const double angle = oblique_angle_deg(grid); angle > 0.01)
        orientation += ", oblique by " + short_text(std::round(100 * angle) / 100) + " degrees";
    print_line("orientation", orientation);
    print_line("origin", vector_text(grid.origin_mm, ", ") + " mm (LPS)");
    const Vec3d centre = centre_of(grid);
    print_line("centre", vector_text(centre, ", ") + " mm (LPS); " +
                             vector_text(ras_of(centre), ", ") + " mm (RAS)");
    print_line("bounds", bounds_text(centre_bounds(grid)) + " mm (LPS)");
    print_line("", bounds_text(ras_box(centre_bounds(grid))) + " mm (RAS)");
}

/// Prints commands for this scan.
void print_next(const InfoOptions& options, const Grid& grid,
                const std::optional<PushOption>& push) {
    std::string file = shell_word(options.file);
    const ScanChoice& scan = options.scan;
    if (!scan.series.empty()) file += " --series " + shell_word(scan.series);
    if (scan.frame) file += " --frame " + std::to_string(*scan.frame);
    if (scan.straighten) file += " --straighten";
    if (scan.spacing_mm) file += " --spacing " + vector_text(*scan.spacing_mm, ",");
    if (options.iso_hu) file += " --iso " + short_text(*options.iso_hu);
    if (options.polarity) file += " --polarity " + *options.polarity;
    std::printf("\nTry next:    pliant render %s --out view.png\n", file.c_str());
    if (push) {
        std::printf(
            "             pliant deform %s --push \"%s:%s\" --tool sphere:%s --out "
            "pushed.nrrd --png pushed.png\n",
            file.c_str(), vector_text(push->point_mm, ",").c_str(),
            vector_text(push->push_mm, ",").c_str(), short_text(suggested_radius_mm(grid)).c_str());
    } else if (options.suggest_push) {
        std::printf("             no wall that gives way is in view; see pliant deform --help\n");
    } else {
        std::printf("             pliant info %s --suggest-push\n", file.c_str());
    }
}

void print_text(const InfoOptions& options, const Volume& volume, const ReadNotes& notes,
                const ValueDefaults& values, const ValueRange& range,
                const std::optional<PushOption>& push) {
    const std::string unit = unit_of(values.kind);
    print_line("file", options.file);
    print_line("format", notes.format + ", stored as " + notes.stored_type);
    print_geometry(volume.grid);
    if (!notes.modality.empty())
        print_line("modality",
                   notes.modality +
                       (notes.rescale_type.empty() ? "" : ", rescaled to " + notes.rescale_type));
    print_line("taken as", kind_text(values));
    print_line("defaults", defaults_text(values));
    print_line("values", short_text(range.min) + " to " + short_text(range.max) + unit);
    std::string percentiles;
    for (std::size_t p = 0; p < kPercentCount; ++p)
        percentiles +=
            (p ? ", " : "") + short_text(kPercents[p]) + " %: " + short_text(range.percentiles[p]);
    print_line("percentiles", percentiles + unit);
    print_line("memory", short_text(std::round(10 * memory_mb(volume)) / 10) + " MB as " +
                             (volume.is_16_bit() ? "int16" : "float32"));
    for (const auto& [key, value] : volume.key_values) print_line("key", key + ": " + value);
    for (const std::string& note : notes.notes) print_line("note", note);
    print_next(options, volume.grid, push);
}

/// Prints the series of a folder of which none was chosen.
int print_series(const InfoOptions& options) {
    const auto list = list_series(options.file);
    if (!list) return bad_input(list.error());
    if (!options.json) {
        std::printf(
            "%s: %zu series; choose one with --series and its number or a part of its "
            "description\n%s",
            printable(options.file).c_str(), list->size(), table_of_series(*list).c_str());
        return kExitOk;
    }
    nlohmann::ordered_json json;
    json["file"] = options.file;
    for (const DicomSeries& series : *list) {
        nlohmann::ordered_json one = {{"number", series.number},
                                      {"description", series.description},
                                      {"modality", series.modality},
                                      {"slices", series.slices},
                                      {"volumes", series.volumes},
                                      {"size", {series.size.x, series.size.y, series.size.z}},
                                      {"spacing_mm", list_of(series.spacing_mm)},
                                      {"uid", series.uid}};
        if (!series.fault.empty()) one["fault"] = series.fault;
        json["series"].push_back(std::move(one));
    }
    print_object(json);
    return kExitOk;
}

}  // namespace

int run_info(const InfoOptions& options) {
    ReadNotes notes;
    std::optional<ProgressBar> bar(std::in_place, "info");
    auto volume = read_volume(options.file, options.scan.options(), &notes);
    if (!volume) {
        bar.reset();
        const bool is_open = options.scan.series.empty() && volume.error().field == "series";
        return is_open ? print_series(options) : bad_input(volume.error());
    }
    const ValueRange range = value_range(*volume);
    const ValueDefaults values = take_values(*volume, notes);
    std::optional<PushOption> push;
    if (options.suggest_push)
        push = suggest_push(*volume, values, options.iso_hu.value_or(values.iso),
                            polarity_of(options.polarity, values), TaskArena());
    bar.reset();
    if (options.json)
        print_json(options, *volume, notes, values, range, push);
    else
        print_text(options, *volume, notes, values, range, push);
    return kExitOk;
}

}  // namespace pliant::app
