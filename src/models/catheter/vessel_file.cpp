// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Conversion of TOML to a VesselFile, and the rules between its settings.

#include <pliant/core/files.h>
#include <pliant/models/catheter.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "base/errors.h"
#include "base/record_toml.h"
#include "base/text.h"

namespace pliant {
namespace {

bool has(const TomlTable& table, std::string_view key) {
    return std::any_of(table.values.begin(), table.values.end(),
                       [&](const NamedValue& named) { return named.name == key; });
}

Error expected_in(const TomlTable& table, std::string_view key, std::string expected,
                  std::string found) {
    return expected_error(title_of(table) + (key.empty() ? "" : " ") + std::string(key),
                          std::move(expected), std::move(found));
}

Status check_vessel(const TomlTable& table, const VesselFile& v) {
    const int sources = !v.phantom.empty() + !v.mesh.empty() + !v.surface.empty() +
                        !v.centreline.empty() + !v.labels_file.empty() + !v.scan.empty();
    if (sources != 1)
        return expected_in(table, "",
                           "one of phantom, mesh, surface, centreline, label_volume, scan",
                           std::to_string(sources));
    for (const char* key : {"thickness_mm", "cell_mm", "layers"})
        if (!v.mesh.empty() && has(table, key))
            return expected_in(table, key, "none beside mesh, which has its own tetrahedra", "one");
    if (!v.ghost.empty() && v.mesh.empty())
        return expected_in(table, "ghost", "mesh beside it", "none");
    if (!v.phantom.empty() && v.phantom != "aorta" && has(table, "cell_mm"))
        return expected_in(table, "cell_mm", "none beside phantom, which is swept in layers",
                           "one");
    if (!v.scan.empty() && !has(table, "window_hu"))
        return expected_in(table, "window_hu", "the lumen's values in the scan", "none");
    if (has(table, "window_hu") && !(v.low_hu < v.high_hu))
        return expected_in(table, "window_hu", "low below high",
                           text_of(v.low_hu) + ", " + text_of(v.high_hu));
    return Ok{};
}

Status check_way(const TomlTable& table, const VesselFile& v) {
    const std::string count = std::to_string(v.way_mm.size());
    if (!v.way_file.empty() && !v.way_mm.empty())
        return expected_in(table, "points_mm", "either this or file", "both");
    if (!v.way_mm.empty() && v.way_mm.size() < 2)
        return expected_in(table, "points_mm", "two points or more", count);
    if (!v.scan.empty() && v.way_mm.size() < 2)
        return expected_in(table, "points_mm", "where the way through the scan begins and ends",
                           count);
    return Ok{};
}

Status check_act(const TomlTable& table, const VesselAct& act, const VesselFile& v) {
    if (!act.for_s && !act.until_inserted_mm && !act.until_way_mm)
        return expected_in(table, "for_s", "this, until_inserted_mm or until_way_mm", "none");
    if ((act.follow || act.until_way_mm) && v.way_file.empty() && v.way_mm.empty() &&
        v.phantom.empty() && v.mesh.empty())
        return expected_in(table, "follow", "a [way] to follow", "none");
    return Ok{};
}

/// Checks the total number of steps of all acts with a for_s bound.
Status check_steps(const VesselFile& v) {
    double seconds = 0;
    for (const VesselAct& act : v.acts) seconds += act.for_s.value_or(0);
    const double steps = std::round(seconds / v.settings.time_step_s);
    const double most = std::max(v.max_steps, VesselFile{}.max_steps);
    if (steps <= most) return Ok{};
    return Error{ErrorCode::LimitExceeded,
                 v.file + ": [[script]] for_s: asks for " + std::to_string(std::int64_t(steps)) +
                     " steps in all, expected up to " + std::to_string(std::int64_t(most)) +
                     "; [simulation] max_steps raises that up to " +
                     std::to_string(kMaxVesselSteps)};
}

/// Sets the values of one table, for the catheter and for the rest of the file.
Status read_values(const TomlTable& table, VesselFile& v) {
    TomlTable catheter{table.name, table.number, {}}, others = catheter;
    std::string known;
    const auto has_row = [&](const auto& rows, const NamedValue& named) {
        return std::any_of(rows.begin(), rows.end(), [&](const SettingInfo& row) {
            return row.table == table.name && row.key_in_file() == named.name;
        });
    };
    for (const NamedValue& named : table.values) {
        if (has_row(catheter_rows(), named))
            catheter.values.push_back(named);
        else if (has_row(vessel_file_rows(), named))
            others.values.push_back(named);
        else if (table.name == "catheter" && named.name == "model") {  // a key until 0.2
            if (named.value != SettingValue("rod"))
                return expected_in(table, named.name, "\"rod\", as each catheter is", "another");
        } else
            return in_table(table, named.name,
                            unknown_setting(named.name, keys_in_table(table.name, catheter_rows(),
                                                                      vessel_file_rows())));
    }
    if (const Status s = read_table(catheter, catheter_rows(), v.settings); !s) return s;
    return read_table(others, vessel_file_rows(), v);
}

Status read_act(const TomlTable& table, VesselFile& v) {
    VesselAct act;
    if (const Status s = read_table(table, vessel_act_rows(), act); !s) return s;
    if (const Status s = check_act(table, act, v); !s) return s;
    v.acts.push_back(act);
    return Ok{};
}

/// Finds a table by its name; empty if absent.
TomlTable find_table(const std::vector<TomlTable>& tables, std::string_view name) {
    for (const TomlTable& table : tables)
        if (table.name == name) return table;
    return {std::string(name), 0, {}};
}

Status read_tables(const std::vector<TomlTable>& tables, VesselFile& v) {
    constexpr std::string_view kTables[] = {"vessel", "way",      "entry",
                                            "wall",   "catheter", "simulation"};
    for (const TomlTable& table : tables) {
        const bool is_script = table.name == "script";
        if (is_script == (table.number == 0) ||
            (!is_script &&
             std::find(std::begin(kTables), std::end(kTables), table.name) == std::end(kTables)))
            return expected_error(title_of(table),
                                  "[vessel], [wall], [catheter], [entry], [simulation], [way] "
                                  "and [[script]]",
                                  "another table");
    }
    for (const std::string_view name : kTables) {
        const TomlTable table = find_table(tables, name);
        if (const Status s = read_values(table, v); !s) return s;
        if (name == "vessel")
            if (const Status s = check_vessel(table, v); !s) return s;
        if (name == "way")
            if (const Status s = check_way(table, v); !s) return s;
        v.entry_given = v.entry_given || (name == "entry" && has(table, "place_mm"));
        if (name == "entry" && v.entry_given && !has(table, "direction"))
            return expected_in(table, "direction", "three numbers beside place_mm", "none");
    }
    for (const TomlTable& table : tables)
        if (table.name == "script")
            if (const Status s = read_act(table, v); !s) return s;
    return Ok{};
}

Result<VesselFile> read_scene(const std::string& file) {
    const auto content = read_small_file(file, kMaxSmallFileBytes, "a scene file");
    if (!content) return content.error();
    const auto tables = parse_toml(*content);
    if (!tables) return within(file, tables.error());
    VesselFile v;
    v.file = file;
    if (const Status s = read_tables(*tables, v); !s) return within(file, s.error());
    if (const Status s = check_steps(v); !s) return s.error();
    const auto folder = std::filesystem::path(file).parent_path();
    for (std::string* name : {&v.mesh, &v.ghost, &v.surface, &v.centreline, &v.labels_file, &v.scan,
                              &v.ends, &v.way_file})
        if (!name->empty()) *name = (folder / *name).string();
    return v;
}

}  // namespace

Result<VesselFile> read_vessel_file(const std::string& file) noexcept {
    return attempt([&] {
        Result<VesselFile> read = read_scene(file);
        return read.ok() ? std::move(read) : in_one_line(read.error());
    });
}

}  // namespace pliant
