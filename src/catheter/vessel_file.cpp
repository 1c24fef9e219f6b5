// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// TOML to a VesselFile: which keys there are, and what they may be.

#include <pliant/vessel_scene.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <sstream>

#include "catheter/vessel_table.h"
#include "core/errors.h"
#include "core/read_file.h"

namespace pliant {
namespace {

using catheter::VesselTable;

void read_vessel(VesselTable&& t, VesselFile& v) {
    t.text("phantom", v.phantom);
    t.text("surface", v.surface);
    t.text("centreline", v.centreline);
    t.text("label_volume", v.labels_file);
    t.text("scan", v.scan);
    t.wholes("labels", v.labels);
    t.text("ends", v.ends);
    t.number("trim", v.trim, 0, 100);
    std::vector<double> window;
    t.numbers("window_hu", window, 2);
    if (window.size() == 2) {
        v.low_hu = window[0];
        v.high_hu = window[1];
        if (!(v.low_hu < v.high_hu)) t.fail("window_hu", "expected low below high");
    }
    t.number("within_mm", v.within_mm, 0.1, 1000);
    t.number("smoothing_voxels", v.smoothing_voxels, 0, 20);
    t.number("thickness_mm", v.wall.thickness_mm, 0.01, 100);
    t.number("cell_mm", v.wall.cell_mm, 0, 100);
    t.whole("layers", v.wall.layers, 1, 16);
    const int sources = !v.phantom.empty() + !v.surface.empty() + !v.centreline.empty() +
                        !v.labels_file.empty() + !v.scan.empty();
    if (sources != 1)
        t.fail("", "expected one of phantom, surface, centreline, label_volume, scan, found " +
                       std::to_string(sources));
    if (!v.phantom.empty() && v.phantom != "bend" && v.phantom != "arch")
        t.fail("phantom", "expected \"bend\" or \"arch\", found \"" + shown(v.phantom) + "\"");
    if (!v.phantom.empty() && t.has("cell_mm"))
        t.fail("cell_mm", "expected none beside phantom, which is swept in layers, found one");
    if (!v.scan.empty() && window.empty())
        t.fail("window_hu", "expected the lumen's values in the scan, found none");
    t.finish();
}

void read_way(VesselTable&& t, VesselFile& v) {
    t.text("file", v.way_file);
    t.whole("branch", v.way_branch, 1, 1000000);
    t.flag("reverse", v.way_reverse);
    t.places("points_mm", v.way_mm);
    t.number("ahead_mm", v.ahead_mm, 0.1, 1000);
    t.number("gain", v.gain, 0, 100);
    t.number("most_deg", v.most_deg, 0, 360);
    if (!v.way_file.empty() && !v.way_mm.empty())
        t.fail("points_mm", "expected either this or file, found both");
    if (!v.way_mm.empty() && v.way_mm.size() < 2)
        t.fail("points_mm", "expected two places or more, found 1");
    if (!v.scan.empty() && v.way_mm.size() < 2)
        t.fail("points_mm", "expected where the way through the scan begins and ends");
    t.finish();
}

void read_entry(VesselTable&& t, VesselFile& v) {
    t.whole("end", v.entry_end, 1, 1000000);
    t.number("inwards", v.entry_inwards, -10, 10);
    t.number("inserted_mm", v.settings.entry.inserted_mm, 0, 3000);
    v.entry_given = t.has("place_mm");
    t.place("place_mm", v.settings.entry.place_mm);
    t.place("direction", v.settings.entry.direction);
    if (v.entry_given && !t.has("direction"))
        t.fail("direction", "expected three numbers beside place_mm");
    t.finish();
}

void read_act(VesselTable&& t, VesselFile& v) {
    VesselAct act;
    t.number("insert_mm_s", act.command.insert_mm_s, -1000, 1000);
    t.number("rotate_deg_s", act.command.rotate_deg_s, -36000, 36000);
    std::vector<double> bends;
    t.numbers("bend_deg", bends, 2);
    if (bends.size() == 2) {
        act.command.bend_first_deg = bends[0];
        act.command.bend_second_deg = bends[1];
    }
    t.flag("follow", act.follow);
    t.bound("for_s", act.for_s);
    t.bound("until_inserted_mm", act.until_inserted_mm);
    t.bound("until_way_mm", act.until_way_mm);
    if (!act.for_s && !act.until_inserted_mm && !act.until_way_mm)
        t.fail("for_s", "expected this, until_inserted_mm or until_way_mm, found none");
    if ((act.follow || act.until_way_mm) && v.way_file.empty() && v.way_mm.empty() &&
        v.phantom.empty())
        t.fail("follow", "expected a [way] to follow, found none");
    v.acts.push_back(act);
    t.finish();
}

/// Steps of all acts together, as far as for_s bounds them.
Status check_steps(const VesselFile& v) {
    double seconds = 0;
    for (const VesselAct& act : v.acts) seconds += act.for_s.value_or(0);
    const double steps = std::round(seconds / v.settings.time_step_s);
    const double most = std::max(v.most_steps, VesselFile{}.most_steps);
    if (steps <= most) return Ok{};
    return Error{ErrorCode::LimitExceeded,
                 v.file + ": [[script]] for_s: asks for " + catheter::number_text(steps) +
                     " steps in all, expected up to " + catheter::number_text(most) +
                     "; [simulation] most_steps raises that up to " +
                     catheter::number_text(double(kMaxVesselSteps))};
}

template <class Tables>
void read_rest(const Tables& table, VesselFile& v) {
    CatheterSettings& s = v.settings;
    {
        VesselTable t = table("catheter");
        t.number("length_mm", s.catheter.length_mm, 10, 3000);
        t.number("segment_mm", s.catheter.segment_mm, 0.2, 20);
        t.number("radius_mm", s.catheter.radius_mm, 0.1, 5);
        t.number("bend_n_mm2", s.catheter.bend_n_mm2, 1e-3, 1e4);
        t.number("twist_n_mm2", s.catheter.twist_n_mm2, 1e-3, 1e4);
        t.number("tip_mm", s.catheter.tip_mm, 0, 3000);
        t.number("tip_bend_n_mm2", s.catheter.tip_bend_n_mm2, 1e-3, 1e4);
        t.number("mass_g_mm", s.catheter.mass_g_mm, 1e-5, 1);
        t.number("damping_per_s", s.catheter.damping_per_s, 0, 1000);
        t.number("friction", s.catheter.friction, 0, 2);
        std::string model = "rod";
        t.text("model", model);
        if (model != "rod" && model != "tetrahedra")
            t.fail("model", "expected \"rod\" or \"tetrahedra\", found \"" + shown(model) + "\"");
        if (model == "tetrahedra") s.catheter.model = CatheterModel::Tetrahedra;
        t.finish();
    }
    {
        VesselTable t = table("wall");
        t.number("young_modulus_pa", s.wall.young_modulus_pa, 1e3, 1e8);
        t.number("poisson_ratio", s.wall.poisson_ratio, 0.01, 0.499);
        t.number("density_g_mm3", s.wall.density_g_mm3, 1e-4, 10);
        t.number("support_pa_per_mm", s.wall.support_pa_per_mm, 0, 1e6);
        t.number("damping_per_s", s.wall.damping_per_s, 0, 1000);
        t.finish();
    }
    VesselTable t = table("simulation");
    t.flag("local", s.local);
    t.number("box_mm", s.box_mm, 1, 1000);
    t.number("reach_mm", s.reach_mm, -1, 1000);
    t.number("time_step_s", s.time_step_s, 1e-5, 0.05);
    t.whole("sub_steps", s.sub_steps, 1, 1000);
    t.whole("iterations", s.iterations, 1, 100);
    t.number("most_steps", v.most_steps, 1, double(kMaxVesselSteps));
    t.finish();
}

Result<VesselFile> read_tables(const std::string& file) {
    const auto content = read_small_file(file, kMaxSmallFileBytes, "a scene file");
    if (!content) return content.error();
    if (const Status s = check_nesting(*content, TextSyntax::Toml); !s)
        return unreadable(file, s.error().message);
    toml::table root;
    try {
        get_memory_for_tables(content->size());
        root = toml::parse(*content);
    } catch (const toml::parse_error& error) {
        std::ostringstream text;
        text << file << ": line " << error.source().begin.line << ": " << error.description();
        return Error{ErrorCode::InvalidArgument, text.str()};
    }
    Status status = Ok{};
    VesselFile v;
    v.file = file;
    for (const auto& [key, node] : root) {
        constexpr const char* kTables[] = {"vessel",     "wall", "catheter", "entry",
                                           "simulation", "way",  "script"};
        const bool known =
            std::find(std::begin(kTables), std::end(kTables), key.str()) != std::end(kTables);
        const bool right = key.str() == "script" ? node.is_array_of_tables() : node.is_table();
        if (!known || !right)
            return Error{ErrorCode::InvalidArgument,
                         file + ": " + shown(key.str()) +
                             ": expected [vessel], [wall], [catheter], [entry], [simulation], "
                             "[way] and [[script]]"};
    }
    const auto table = [&](const char* name) {
        const toml::node* node = root.get(name);
        return VesselTable(file, "[" + std::string(name) + "]", node ? node->as_table() : nullptr,
                           status);
    };
    read_vessel(table("vessel"), v);
    read_way(table("way"), v);
    read_entry(table("entry"), v);
    read_rest(table, v);
    if (const toml::array* script = root["script"].as_array())
        for (const toml::node& act : *script)
            read_act(VesselTable(file, "[[script]]", act.as_table(), status), v);
    if (!status.ok()) return status.error();
    if (Status steps = check_steps(v); !steps) return steps.error();
    const auto folder = std::filesystem::path(file).parent_path();
    for (std::string* name :
         {&v.surface, &v.centreline, &v.labels_file, &v.scan, &v.ends, &v.way_file})
        if (!name->empty()) *name = (folder / *name).string();
    return v;
}

}  // namespace

Result<VesselFile> read_vessel_file(const std::string& file) noexcept {
    return attempt([&] {
        Result<VesselFile> read = read_tables(file);
        return read.ok() ? std::move(read) : in_one_line(read.error());
    });
}

}  // namespace pliant
