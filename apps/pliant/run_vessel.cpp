// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Simulation of a catheter in a vessel from a scene file: motion of the hand, outputs.

#include <pliant/models/catheter.h>
#include <pliant/models/scene_files.h>
#include <pliant/scan_files.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <optional>

#include "options.h"
#include "output_names.h"
#include "output_text.h"
#include "progress.h"
#include "standard_output.h"
#include "vessel_extremes.h"
#include "vessel_outputs.h"

namespace pliant::app {
namespace {

const char* wall_model_name(WallModel model) {
    return model == WallModel::Solid       ? "solid"
           : model == WallModel::Distances ? "distances"
                                           : "rigid";
}

Error named(const std::string& file, const Error& error) {
    return {error.code, file + ": " + error.message};
}

nlohmann::ordered_json report_of(const CatheterScene& scene, const VesselExtremes& most,
                                 const CatheterMeasures& end, double step_ms, int every) {
    return {{"tetrahedra", scene.wall().mesh.cells.size()},
            {"ghost_triangles", scene.wall().ghost.cells.size()},
            {"steps", end.steps},
            {"time_s", end.time_s},
            {"inserted_mm", end.inserted_mm},
            {"rotated_deg", end.rotated_deg},
            {"farthest_way_mm", most.way_mm()},
            {"largest_depth_mm", most.depth_mm()},
            {"largest_force_n", most.force_n()},
            {"largest_wall_moved_mm", most.wall_moved_mm()},
            {"largest_energy_mj", most.energy_mj()},
            {"energy_every_steps", every},
            {"volume_error_mean", most.volume_mean()},
            {"volume_error_largest", most.volume_largest()},
            {"inverted_ever", most.inverted()},
            {"left_end", most.left_end()},
            {"warnings", most.warnings()},
            {"most_active_tetrahedra", most.active()},
            {"cell_mm", scene.wall().cell_mm},
            {"refined_because", scene.wall().refined_because},
            {"dropped_pieces", scene.wall().dropped_pieces},
            {"wall_model", wall_model_name(scene.settings().wall.model)},
            {"contact_mm_per_n", scene.settings().catheter.contact_mm_per_n},
            {"sub_steps", scene.settings().sub_steps},
            {"most_sub_steps", most.sub_steps()},
            {"reach_mm", scene.settings().reach_mm},
            {"wide_reach_mm", wide_reach_mm(scene.wall(), scene.settings().wall)},
            {"end_wall_moved_mm", end.wall_moved_mm},
            {"end_kinetic_energy_mj", end.kinetic_energy_mj},
            {"end_inverted", end.inverted},
            {"step_ms", step_ms},
            {"pace", step_ms > 0 ? 1000 * scene.settings().time_step_s / step_ms : 0},
            {"hash", hex_of(scene.hash())}};
}

/// Source of commands: the script, or a log.
class Hand {
  public:
    Hand(const VesselFile& file, const std::vector<Vec3d>& way, const HandLog* log)
        : m_script(file, way), m_log(log) {}

    double way_mm(const CatheterScene& scene) const { return m_script.way_mm(scene); }
    double progress() const { return m_script.progress(); }

    /// @returns false at the end
    bool next(const CatheterScene& scene, CatheterCommand& command) {
        if (!m_log) return m_script.next(scene, command);
        const std::int64_t steps = scene.quick_measures().steps;
        if (steps >= m_log->steps) return false;
        while (m_line < m_log->lines.size() && m_log->lines[m_line].step <= steps)
            command = m_log->lines[m_line++].command;
        return true;
    }

  private:
    VesselScript m_script;
    const HandLog* m_log;
    std::size_t m_line = 0;
};

/// All output files of the command, committed together at its end.
struct VesselOutputs {
    StagedFiles staged;
    TextFile csv, report;
    Frames frames;
    std::string record, volume;  ///< staged paths
    std::filesystem::path png;

    Status open(const VesselOptions& o) {
        if (!o.csv.empty())
            if (const Status s = csv.open(o.csv, staged); !s) return s;
        if (!o.report.empty())
            if (const Status s = report.open(o.report, staged); !s) return s;
        if (!o.frames.empty())
            if (const Status s = frames.open(o.frames, staged); !s) return s;
        for (const auto& [name, place] :
             {std::pair(&o.record, &record), std::pair(&o.volume, &volume)}) {
            if (name->empty()) continue;
            const auto path = staged.stage(*name);
            if (!path) return path.error();
            *place = path->string();
        }
        const OutputName names[] = {{"--png", o.png, png, {".png"}}};
        return stage_names(names, o.scene, staged);
    }
};

Status write_volume_of(const std::string& file, const Volume& scan, const CatheterScene& scene,
                       const TaskArena& arena) {
    auto carried = CarriedScan::create(scan, scene.wall().mesh, {}, arena);
    if (!carried) return named("--volume", carried.error());
    if (const Status s = carried->update(scene.wall_positions()); !s) return s;
    const auto deformed = deform_volume(carried->scan());
    if (!deformed) return named("--volume", deformed.error());
    return write_volume(file, deformed->volume);
}

}  // namespace

int run_vessel(const VesselOptions& o) {
    const TaskArena arena(o.threads);
    auto file = read_vessel_file(o.scene);
    if (!file) return bad_input(file.error().message);
    if (file->acts.empty())
        return bad_input(o.scene + ": [[script]]: expected one or more acts, found none");
    if (!o.volume.empty() && file->scan.empty())
        return bad_input("--volume: expected a scene with [vessel] scan, found none in " + o.scene);
    std::optional<HandLog> replayed;
    if (!o.replay.empty()) {
        auto log = read_log(o.replay);
        if (!log) return bad_input(log.error().message);
        if (double(log->steps) > file->max_steps)
            return bad_input(o.replay + ": has " + std::to_string(log->steps) +
                             " steps, expected up to [simulation] max_steps of " + o.scene + ", " +
                             std::to_string(std::llround(file->max_steps)));
        replayed = std::move(*log);
    }
    VesselOutputs outputs;
    if (const Status s = outputs.open(o); !s) return bad_input(s.error().message);
    auto& [staged, csv, report_file, frames, record, volume, png] = outputs;

    std::optional<ProgressBar> making(std::in_place, "vessel");
    auto made = make_vessel(*file, arena);
    if (!made) return bad_input(made.error().message);
    auto scene = CatheterScene::create(std::move(made->wall), made->settings);
    if (!scene) return bad_input(o.scene + ": " + scene.error().message);
    making.reset();

    const double way_mm = WayPilot(made->way).way_mm();
    for (const VesselAct& act : file->acts)
        if (act.until_way_mm && *act.until_way_mm > way_mm)
            return bad_input(o.scene + ": [[script]] until_way_mm: expected up to " +
                             std::to_string(std::lround(way_mm)) +
                             ", the length of the way, found " +
                             std::to_string(std::lround(*act.until_way_mm)));
    Hand hand(*file, made->way, replayed ? &*replayed : nullptr);
    HandLog log;
    CatheterCommand command, before;
    VesselExtremes most(*scene);
    double elapsed_ms = 0;
    if (csv.is_open()) csv.line(csv_names());
    {
        ProgressBar bar("catheter");
        while (double(scene->quick_measures().steps) < file->max_steps &&
               hand.next(*scene, command)) {
            const std::int64_t n = scene->quick_measures().steps;
            if (n == 0 || !(command == before)) log.lines.push_back({n, command});
            before = command;
            if (const Status s = scene->command(command); !s)
                return bad_input(o.scene + ": " + s.error().message);
            const auto start = std::chrono::steady_clock::now();
            if (const Status s = scene->step(1, arena); !s)
                return bad_input(o.scene + ": after " + std::to_string(n) +
                                 " steps: " + s.error().message);
            elapsed_ms +=
                std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start)
                    .count();
            const CatheterMeasures quick = scene->quick_measures();
            if (n == 0 && quick.depth_mm > 0.1)
                return bad_input(o.scene + ": [entry]: the catheter begins " +
                                 exact(std::round(100 * quick.depth_mm) / 100) +
                                 " mm beyond the wall, expected inside");
            if (csv.is_open()) csv.line(csv_line(quick));
            most.add(*scene, arena);
            most.add_way(hand.way_mm(*scene));
            if (n % o.every != 0) continue;
            bar.show(replayed ? double(n) / double(replayed->steps) : hand.progress());
            most.add_energy(*scene);
            if (!o.frames.empty())
                if (const Status s = frames.add(*scene); !s) return bad_input(s.error().message);
        }
    }
    const CatheterMeasures end = scene->measures();
    most.add_energy(*scene);
    const double step_ms = end.steps > 0 ? elapsed_ms / double(end.steps) : 0;
    log.steps = end.steps;
    log.hash = scene->hash();
    const auto report = report_of(*scene, most, end, step_ms, o.every);
    if (report_file.is_open()) report_file.line(report.dump(2));
    if (replayed && replayed->hash != log.hash)
        return bad_input(o.replay + ": plays differently: the checksum is not the log's");
    for (TextFile* out : {&csv, &report_file})
        if (out->is_open())
            if (const Status s = out->close(); !s) return bad_input(s.error().message);
    if (!o.frames.empty())
        if (const Status s = frames.close(); !s) return bad_input(s.error().message);
    if (!o.record.empty())
        if (const Status s = write_log(record, log); !s) return bad_input(s.error().message);
    if (!o.volume.empty()) {
        const ProgressBar bar("volume");
        if (const Status s = write_volume_of(volume, *made->scan, *scene, arena); !s)
            return bad_input(s.error().message);
    }
    if (!png.empty())
        if (const Status s = write_vessel_picture(png, *scene); !s)
            return bad_input(s.error().message);
    if (const Status s = staged.commit(); !s) return bad_input(s.error().message);

    if (o.json) {
        std::printf("%s\n", report.dump().c_str());
    } else if (!is_standard_output(o.report) && !is_standard_output(o.csv)) {
        std::printf("vessel              %zu tetrahedra, %zu ghost triangles\n",
                    scene->wall().mesh.cells.size(), scene->wall().ghost.cells.size());
        if (!scene->wall().refined_because.empty())
            std::printf("cells               refined to %.3g mm; with larger ones, %s\n",
                        scene->wall().cell_mm, scene->wall().refined_because.c_str());
        std::printf("steps               %lld, %.2f s, %.2f ms each, %d to %d sub-steps\n",
                    static_cast<long long>(end.steps), end.time_s, step_ms,
                    scene->settings().sub_steps, most.sub_steps());
        if (step_ms > 0)
            std::printf("pace                %.2f x real time\n",
                        1000 * scene->settings().time_step_s / step_ms);
        std::printf("along the way       %.1f mm at most, %.1f mm inserted at the end\n",
                    most.way_mm(), end.inserted_mm);
        std::printf("beyond the wall     %.4f mm at most\n", most.depth_mm());
        std::printf("force               %.3f N at most\n", most.force_n());
        std::printf("wall                moved %.3f mm at most, %.4f mm at the end\n",
                    most.wall_moved_mm(), end.wall_moved_mm);
        std::printf("volume              %.4f %% off on average, %.2f %% at most\n",
                    100 * most.volume_mean(), 100 * most.volume_largest());
        std::printf("tetrahedra          %d active at most, %lld inverted at the end\n",
                    most.active(), static_cast<long long>(end.inverted));
        const double wide = wide_reach_mm(scene->wall(), scene->settings().wall);
        const bool has_wide = scene->settings().wall.model == WallModel::Solid;
        if (scene->settings().local && has_wide && scene->settings().reach_mm < wide)
            std::printf(
                "reach               %g mm; %.1f mm keep the error of boxes below 2 %% on this "
                "support\n",
                scene->settings().reach_mm, wide);
        std::printf("energy              %.3f mJ at most, in every %dth step and the last one\n",
                    most.energy_mj(), int(o.every));
        std::printf("checksum            %s\n", report["hash"].get<std::string>().c_str());
        for (const std::string& warning : most.warnings())
            std::printf("warning             %s\n", warning.c_str());
    }
    return kExitOk;
}

}  // namespace pliant::app
