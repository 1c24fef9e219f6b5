// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The scene files of real vessels, played as `pliant vessel` does.

#include <pliant/vessel_scene.h>

#include <algorithm>

#include "figures.h"
#include "timing.h"

namespace pliant::results {
namespace {

struct RealRun {
    CatheterMeasures end{};
    double depth_mm = -1e9, force_n = 0, moved_mm = 0, energy_mj = 0, mean = 0, largest = 0;
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
        run.energy_mj =
            std::max(run.energy_mj, m.wire_energy_mj + m.wall_energy_mj + m.kinetic_energy_mj);
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
    std::vector<std::vector<std::string>> walls, runs;
    for (const std::string name : {"vessel_aorta", "vessel_cta"}) {
        const VesselFile file = value_of(read_vessel_file(scenes + "/" + name + ".toml"));
        const MadeVessel vessel = value_of(make_vessel(file, arena));
        must(check_wall(vessel.wall, file.wall.layers));
        const RealRun run = play(file, vessel, arena);
        std::printf(
            "%s %zu steps %d ms %.2f depth %.4f moved %.3f way %.1f inverted %d vol %.5f %.3f\n",
            name.c_str(), vessel.wall.mesh.cells.size(), int(run.end.steps),
            run.ms / double(run.end.steps), run.depth_mm, run.moved_mm, run.way_mm,
            int(run.inverted), 100 * run.mean, 100 * run.largest);
    }
}

}  // namespace pliant::results
