// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The scene files of real vessels, run as by `pliant vessel`.

#include <pliant/models/catheter.h>
#include <pliant/models/scene_files.h>

#include <algorithm>
#include <cmath>

#include "figures.h"
#include "timing.h"

namespace pliant::results {
namespace {

struct RealRun {
    CatheterMeasures end{};
    double depth_mm = -1e9, force_n = 0, moved_mm = 0, mean = 0, largest = 0;
    double way_mm = 0, ms = 0;
    std::int64_t inverted = 0;
    std::int32_t active = 0;
};

RealRun play(const VesselFile& file, const MadeVessel& vessel, const TaskArena& arena) {
    auto scene = value_of(CatheterScene::create(vessel.wall, vessel.settings));
    VesselScript script(file, vessel.way);
    CatheterCommand command;
    RealRun run;
    while (script.next(scene, command)) {
        must(scene.command(command));
        run.ms += processor_ms_of([&] { must(scene.step(1, arena)); });
        const CatheterMeasures quick = scene.quick_measures();
        run.depth_mm = std::max(run.depth_mm, quick.depth_mm);
        run.force_n = std::max(run.force_n, std::abs(quick.force_n));
        run.active = std::max(run.active, quick.active_tetrahedra);
        if (quick.steps % 10 != 1) continue;
        const CatheterMeasures m = scene.measures();
        run.moved_mm = std::max(run.moved_mm, m.wall_moved_mm);
        run.mean = std::max(run.mean, m.volume.mean);
        run.largest = std::max(run.largest, m.volume.largest);
        run.inverted = std::max(run.inverted, m.inverted);
        run.way_mm = std::max(run.way_mm, script.way_mm(scene));
    }
    run.end = scene.measures();
    return run;
}

}  // namespace

void add_walls(Page& page, const std::string& scenes, const TaskArena& arena) {
    page.heading(2, "Real vessels");
    page.paragraph(
        "The scenes of two real vessels, played to their end: VMTK's aorta from its surface, and "
        "an aorta straight from its CT angiography (`shared/data/README.md` has their sources). "
        "The walls are checked before: one piece, no opening of the inner surface but the ends, "
        "two layers of tetrahedra at least (`check_wall`). Largest values are over every tenth "
        "step, depth and force over all of them; a depth below 0 is a distance from the wall. The "
        "default wall and wire move the wall by less than can be seen, so there is no picture.");
    std::vector<std::vector<std::string>> walls, runs;
    for (const std::string name : {"vessel_aorta", "vessel_cta"}) {
        const VesselFile file = value_of(read_vessel_file(scenes + "/" + name + ".toml"));
        const MadeVessel vessel = value_of(make_vessel(file, arena));
        must(check_wall(vessel.wall, file.wall.layers));
        const RealRun run = play(file, vessel, arena);
        const std::int64_t cells = std::int64_t(vessel.wall.mesh.cells.size());
        walls.push_back({"`pliant vessel scenes/" + name + ".toml`", grouped_text(cells),
                         grouped_text(std::int64_t(vessel.wall.ghost.cells.size())),
                         fixed_text(vessel.wall.cell_mm, 2), std::to_string(vessel.wall.min_layers),
                         std::to_string(vessel.wall.ends.size())});
        runs.push_back({name, grouped_text(run.end.steps), fixed_text(run.way_mm, 0),
                        fixed_text(run.moved_mm, 3), fixed_text(run.depth_mm, 3),
                        fixed_text(run.force_n, 3), fixed_text(100 * run.mean, 4),
                        fixed_text(100 * run.largest, 1), std::to_string(run.inverted),
                        fixed_text(100.0 * run.active / double(cells), 0),
                        fixed_text(run.ms / double(run.end.steps), 2)});
    }
    page.table({"command", "tetrahedra", "triangles of the inner surface", "cells [mm]",
                "layers at least", "ends"},
               walls);
    page.table({"scene", "steps", "tip along the way [mm]", "wall moved [mm]",
                "depth beyond the wall [mm]", "force on the hand [N]", "volumes: mean error [%]",
                "largest [%]", "inverted tetrahedra", "active at most [%]",
                "processor time of a step [ms]"},
               runs);
}

}  // namespace pliant::results
