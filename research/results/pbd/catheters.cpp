// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A catheter that deforms a vessel: before and after, whole and local, rod and tetrahedra.

#include <pliant/models/scene_files.h>
#include <pliant/research/tet_catheter.h>

#include "catheters.h"

#include <algorithm>
#include <limits>

#include "cutaway.h"
#include "figures.h"
#include "timing.h"

namespace pliant::results {
namespace {

constexpr Rgb8 kCatheter{226, 160, 60};
constexpr double kLargest_mm = 3;
/// The bend's plane; the cut is beside the nodes in the plane.
constexpr Camera kBend{.low = {-9, 52}, .high = {71, 104}, .px_per_mm = 6.4, .cut_mm = 0.3};

struct Bend {
    VesselFile file;
    MadeVessel vessel;
    const TetMesh& mesh() const { return vessel.wall.mesh; }
};

Image picture_of(const Bend& bend, const BendRun& run, const CornerValues& values, double largest,
                 std::string_view title, double px_per_mm = kBend.px_per_mm) {
    Camera camera = kBend;
    camera.px_per_mm = px_per_mm;
    Cutaway cutaway(camera);
    cutaway.wall(bend.mesh(), run.wall_mm, values, shaded_to(largest));
    if (run.catheter.cells.empty())
        cutaway.wire(run.wire_mm, run.radius_mm, kCatheter);
    else
        cutaway.body(run.catheter, kCatheter);
    cutaway.outline(bend.mesh(), bend.mesh().nodes_mm);
    return cutaway.image(title);
}

Image moved_bar(double darkest, int width, double largest = 0) {
    const LegendEntry entries[] = {{"edge of the cut at rest", {kRed, 1.4}},
                                   {"catheter", {kCatheter, 4}}};
    const Image parts[] = {shade_bar(darkest, 0, "displacement of the wall [mm]", largest),
                           legend_of(entries, width)};
    return row_of(parts);
}

/// NaN at held corners.
CornerValues with_held(const TetMesh& mesh, const BendRun& run, CornerValues values) {
    for (std::size_t c = 0; c < values.size(); ++c)
        for (std::size_t n = 0; n < 4; ++n)
            if (run.is_held[std::size_t(mesh.cells[c][n])])
                values[c].fill(std::numeric_limits<double>::quiet_NaN());
    return values;
}

std::vector<std::string> row_of_run(std::string name, const BendRun& run) {
    const CatheterMeasures& m = run.measures;
    return {std::move(name),
            fixed_text(run.moved_mm, 2),
            fixed_text(m.contact_n, 2),
            fixed_text(m.force_n, 2),
            fixed_text(run.depth_mm, 3),
            fixed_text(100 * m.volume.mean, 3),
            fixed_text(100 * m.volume.largest, 1),
            std::to_string(run.inverted),
            fixed_text(run.ms / 1000, 1)};
}

void add_before_and_after(Page& page, const Bend& bend, const BendRun& run,
                          const TaskArena& arena) {
    page.heading(2, "A catheter that deforms a vessel");
    page.paragraph(
        "A bend of a vessel, inner radius 4 mm, 1.2 mm thick, of " +
        grouped_text(std::int64_t(bend.mesh().cells.size())) +
        " neo-Hookean tetrahedra (E 100 kPa, ν 0.45) in soft tissue (250 Pa for each mm), and a "
        "stiff wire of radius 0.8 mm (EI 400 N mm², at the tip 200) that is fed in at 100 mm/s, "
        "steered along the middle, and left there for 0.3 s. The wire is too stiff for the bend: "
        "it presses on the wall inside the bend and, with its tip, on the wall behind it. "
        "`pliant vessel scenes/vessel_soft.toml --frames soft` runs the same scene.");
    VesselFile file = bend.file;
    file.acts.resize(1);
    file.acts[0].until_way_mm = 58;
    const BendRun before = run_bend(file, bend.vessel, arena);
    const Image pair[] = {picture_of(bend, before, displacements_of(bend.mesh(), before.wall_mm),
                                     kLargest_mm, "before: the tip at the bend"),
                          picture_of(bend, run, displacements_of(bend.mesh(), run.wall_mm),
                                     kLargest_mm, "after: the wire round the bend")};
    const Image parts[] = {row_of(pair), moved_bar(kLargest_mm, 420, run.moved_mm)};
    page.picture("bend", "the bend cut open, before and after the wire has gone round it",
                 column_of(parts));
    page.paragraph(
        "The vessel is cut open in the plane of the bend; both pictures have the same "
        "camera and the same colours.");
}

/// Three pictures with legends below.
Image boxes_picture(const Bend& bend, const BendRun& all, const BendRun& boxes, double full_um) {
    constexpr double kSmall_px_mm = 4.8;
    const CornerValues moved = displacements_of(bend.mesh(), boxes.wall_mm);
    const LegendEntry lines[] = {{"edge of the cut at rest", {kRed, 1.4}},
                                 {"catheter", {kCatheter, 4}}};
    const LegendEntry held[] = {{"held", {kHeld, 1}, LegendEntry::Mark::Box}};
    const Image first[] = {picture_of(bend, all, displacements_of(bend.mesh(), all.wall_mm),
                                      kLargest_mm, "all of the wall moves", kSmall_px_mm),
                           shade_bar(kLargest_mm, 0, "displacement [mm]", all.moved_mm),
                           legend_of(lines, 420)};
    const Image second[] = {picture_of(bend, boxes, with_held(bend.mesh(), boxes, moved),
                                       kLargest_mm, "boxes near the wire move", kSmall_px_mm),
                            shade_bar(kLargest_mm, 0, "displacement [mm]", boxes.moved_mm),
                            legend_of(held, 420)};
    const Image third[] = {
        picture_of(bend, boxes, distances_of(bend.mesh(), all.wall_mm, boxes.wall_mm),
                   full_um / 1000, "difference of the two", kSmall_px_mm),
        shade_bar(full_um, 0, "distance [µm]", 1000 * farthest_mm(all.wall_mm, boxes.wall_mm))};
    const Image columns[] = {column_of(first, 4), column_of(second, 4), column_of(third, 4)};
    return row_of(columns);
}

double apart_um(const BendRun& a, const BendRun& b) {
    return 1000 * farthest_mm(a.wall_mm, b.wall_mm);
}

void add_boxes(Page& page, const Bend& bend, const BendRun& all, std::span<const BendRun> runs) {
    page.heading(3, "All of the wall, and boxes of which only some move");
    const BendRun& shown = runs[1];
    const double um = apart_um(all, shown);
    page.picture("bend-boxes", "all of the wall, boxes, and their difference",
                 boxes_picture(bend, all, shown,
                               um > 500   ? 1000
                               : um > 200 ? 500
                                          : 200));
    page.paragraph("Boxes of 6 mm (`box_mm`); the picture is with those within " +
                   fixed_text(shown.reach_mm, 0) +
                   " mm of the wire (`reach_mm`). What the tip pushes bends the vessel as a whole, "
                   "and the edge of the boxes holds it. `reach_mm = -1` is as wide as that "
                   "spreads, here " +
                   fixed_text(runs.back().reach_mm, 1) + " mm.");
    std::vector<std::vector<std::string>> rows;
    for (const BendRun& run : runs)
        rows.push_back({fixed_text(run.reach_mm, 1),
                        fixed_text(100.0 * run.active / double(bend.mesh().cells.size()), 0),
                        fixed_text(apart_um(all, run), 0),
                        fixed_text(0.1 * apart_um(all, run) / all.moved_mm, 1),
                        fixed_text(all.ms / run.ms, 1)});
    page.table({"reach [mm]", "active tetrahedra at most [%]", "largest difference from all [µm]",
                "of the largest displacement [%]", "times faster than all"},
               rows);
}

void add_models(Page& page, const Bend& bend, const BendRun& rod, const BendRun& body) {
    page.heading(3, "A rod, and a catheter of tetrahedra");
    const Image pair[] = {
        picture_of(bend, rod, displacements_of(bend.mesh(), rod.wall_mm), kLargest_mm, "rod"),
        picture_of(bend, body, displacements_of(bend.mesh(), body.wall_mm), kLargest_mm,
                   "tetrahedra")};
    const Image parts[] = {row_of(pair),
                           moved_bar(kLargest_mm, 420, std::max(rod.moved_mm, body.moved_mm))};
    page.picture("bend-models", "a rod and a body of tetrahedra in the same bend",
                 column_of(parts));
    page.paragraph(
        "The catheter of [VesselPbd2016] is a body of tetrahedra "
        "(`<pliant/research/tet_catheter.h>`): "
        "the same EI and GJ, segments of 2 mm, moved by the hand that steered the rod, " +
        grouped_text(std::int64_t(body.catheter.cells.size())) +
        " tetrahedra, whose surface is drawn with its edges. The tips are " +
        fixed_text(norm(rod.wire_mm.back() - body.wire_mm.back()), 2) + " mm apart, the walls " +
        fixed_text(farthest_mm(rod.wall_mm, body.wall_mm), 2) + " mm at most.");
}

/// Walls of the scene that gives way in real time.
struct WallCase {
    const char* name;
    BendRun run;
};

/// Columns of pictures: displacements above changes of volume.
Image walls_picture(const Bend& bend, std::span<const WallCase> walls) {
    constexpr double kSmall_px_mm = 4.8, kFull_percent = 5, kMoved_mm = 6;
    std::vector<Image> moved, volumes;
    double moved_mm = 0, changed = 0;
    for (const WallCase& wall : walls) {
        moved_mm = std::max(moved_mm, wall.run.moved_mm);
        changed = std::max(changed, wall.run.measures.volume.largest);
        moved.push_back(picture_of(bend, wall.run, displacements_of(bend.mesh(), wall.run.wall_mm),
                                   kMoved_mm, wall.name, kSmall_px_mm));
        Camera camera = kBend;
        camera.px_per_mm = kSmall_px_mm;
        Cutaway cutaway(camera);
        cutaway.wall(bend.mesh(), wall.run.wall_mm,
                     volume_changes_of(bend.mesh(), wall.run.wall_mm),
                     signed_to(kFull_percent / 100));
        cutaway.wire(wall.run.wire_mm, wall.run.radius_mm, kCatheter);
        cutaway.outline(bend.mesh(), bend.mesh().nodes_mm);
        volumes.push_back(cutaway.image(wall.name));
    }
    const Image parts[] = {row_of(moved), moved_bar(kMoved_mm, 420, moved_mm), row_of(volumes),
                           signed_bar(kFull_percent, 0, "change of volume [%]", 100 * changed)};
    return column_of(parts);
}

MadeVessel with_distances(const MadeVessel& vessel, double stretch, double bend, double volume) {
    MadeVessel changed = vessel;
    WallTissue& wall = changed.settings.wall;
    wall.model = WallModel::Distances;
    wall.stretch_stiffness = stretch;
    wall.bend_stiffness = bend;
    wall.volume_stiffness = volume;
    return changed;
}

void hold_nodes(const PbdBody& body, BendRun& run) {
    for (std::int32_t n = 0; n < body.particle_count(); ++n)
        run.is_held.push_back(body.inverse_mass(n) == 0);
}

/// A catheter of tetrahedra, moved by the same hand as the rod.
BendRun run_body(const MadeVessel& vessel, std::span<const CatheterCommand> hand,
                 const TaskArena& arena) {
    auto catheter = value_of(TetCatheter::create(vessel.wall, vessel.settings));
    BendRun run;
    for (std::size_t n = 0; n < hand.size(); ++n) {
        run.ms += processor_ms_of([&] { must(catheter.step(hand[n], arena)); });
        run.depth_mm = std::max(run.depth_mm, catheter.depth_mm());
        if (n % 20 == 19) run.inverted = std::max(run.inverted, catheter.measures().inverted);
    }
    run.wall_mm.resize(vessel.wall.mesh.nodes_mm.size());
    catheter.body().get_positions(run.wall_mm);
    const auto wire = catheter.wire_positions();
    run.wire_mm.assign(wire.begin() + catheter.first_inserted(), wire.end());
    run.catheter = catheter.mesh();
    run.radius_mm = vessel.settings.catheter.radius_mm;
    run.measures = catheter.measures();
    run.moved_mm = run.measures.wall_moved_mm;
    hold_nodes(catheter.body(), run);
    return run;
}

}  // namespace

void add_wall_models(Page& page, const std::string& scenes, const TaskArena& arena) {
    constexpr double kStretch = 0.015, kBendShare = 0.015;
    Bend bend{value_of(read_vessel_file(scenes + "/vessel_soft_wall.toml")), {}};
    bend.vessel = value_of(make_vessel(bend.file, arena));
    bend.vessel.settings.local = false;
    const auto run = [&](const MadeVessel& vessel) { return run_bend(bend.file, vessel, arena); };
    const WallCase walls[] = {
        {"solids", run(bend.vessel)},
        {"distances", run(with_distances(bend.vessel, kStretch, kBendShare, 1))},
        {"distances, no volumes", run(with_distances(bend.vessel, kStretch, kBendShare, 0))}};
    page.heading(2, "Two walls: solids, and the paper's constraints");
    const WallTissue& tissue = bend.vessel.settings.wall;
    page.paragraph(
        "`scenes/vessel_soft_wall.toml`: the same bend, of " +
        grouped_text(std::int64_t(bend.mesh().cells.size())) +
        " tetrahedra, with the same catheter and the same push, by 100 mm at 40 mm/s and not "
        "steered. The wall is of neo-Hookean tetrahedra (`[wall] model = \"solid\"`, E " +
        fixed_text(tissue.young_modulus_pa / 1000, 0) + " kPa, ν " +
        fixed_text(tissue.poisson_ratio, 2) +
        "), or of the paper's constraints and its Eq. 1 (`\"distances\"`): a sub-step removes the "
        "share " +
        fixed_text(kStretch, 3) + " of the error of each length and " + fixed_text(kBendShare, 3) +
        " of each fold, and all of that of each volume, or none. All of the wall moves.");
    page.picture("bend-walls",
                 "the bend with a wall of solids, of distances, and of distances without volumes: "
                 "displacement above, change of volume below",
                 walls_picture(bend, walls));
    std::vector<std::vector<std::string>> rows;
    for (const WallCase& wall : walls) {
        const CatheterMeasures& m = wall.run.measures;
        rows.push_back(
            {wall.name, fixed_text(wall.run.moved_mm, 2),
             fixed_text(farthest_mm(walls[0].run.wall_mm, wall.run.wall_mm), 2),
             fixed_text(m.contact_n, 3), fixed_text(wall.run.depth_mm, 3),
             fixed_text(100 * m.volume.mean, 3), fixed_text(100 * m.volume.largest, 1),
             std::to_string(wall.run.inverted), fixed_text(wall.run.ms / double(m.steps), 2),
             fixed_text(1000 * bend.vessel.settings.time_step_s * double(m.steps) / wall.run.ms,
                        2)});
    }
    page.table({"wall", "moved [mm]", "farthest from that of solids [mm]", "contact [N]",
                "largest depth beyond the wall [mm]", "volumes: mean error [%]", "largest [%]",
                "inverted tetrahedra", "processor time of a step [ms]",
                "simulated time over processor time"},
               rows);
    page.paragraph(
        "Young's modulus and the support's stiffness have units, and hold for any step; a share "
        "belongs to one length of sub-step, and a wall of shares is the stiffer the shorter they "
        "are. The shares are chosen here so that both walls give way by about as much.");
}

BendRun run_bend(const VesselFile& file, const MadeVessel& vessel, const TaskArena& arena,
                 std::vector<CatheterCommand>* hand) {
    auto scene = value_of(CatheterScene::create(vessel.wall, vessel.settings));
    VesselScript script(file, vessel.way);
    CatheterCommand command;
    BendRun run;
    while (script.next(scene, command)) {
        must(scene.command(command));
        if (hand) hand->push_back(command);
        run.ms += processor_ms_of([&] { must(scene.step(1, arena)); });
        const CatheterMeasures m = scene.quick_measures();
        run.depth_mm = std::max(run.depth_mm, m.depth_mm);
        run.active = std::max(run.active, m.active_tetrahedra);
        if (m.steps % 20 == 0) run.inverted = std::max(run.inverted, scene.inverted_tetrahedra());
    }
    run.wall_mm = scene.wall_positions();
    const auto wire = scene.wire_positions();
    run.wire_mm.assign(wire.begin() + scene.first_inserted(), wire.end());
    run.radius_mm = vessel.settings.catheter.radius_mm;
    run.measures = scene.measures();
    run.reach_mm = scene.settings().reach_mm;
    run.moved_mm = run.measures.wall_moved_mm;
    hold_nodes(scene.body(), run);
    return run;
}

double farthest_mm(std::span<const Vec3d> a, std::span<const Vec3d> b) {
    double farthest = 0;
    for (std::size_t n = 0; n < a.size(); ++n) farthest = std::max(farthest, norm(a[n] - b[n]));
    return farthest;
}

void add_catheters(Page& page, const std::string& scenes, const TaskArena& arena) {
    Bend bend{value_of(read_vessel_file(scenes + "/vessel_soft.toml")), {}};
    bend.vessel = value_of(make_vessel(bend.file, arena));
    bend.vessel.settings.local = false;
    std::vector<CatheterCommand> hand;
    const BendRun all = run_bend(bend.file, bend.vessel, arena, &hand);
    std::vector<BendRun> boxes;
    for (const double reach : {2.0, 6.0, -1.0}) {
        MadeVessel vessel = bend.vessel;
        vessel.settings.local = true;
        vessel.settings.box_mm = 6;
        vessel.settings.reach_mm = reach;
        boxes.push_back(run_bend(bend.file, vessel, arena));
    }
    MadeVessel other = bend.vessel;
    other.settings.catheter.segment_mm = 2;
    const BendRun body = run_body(other, hand, arena);
    add_before_and_after(page, bend, all, arena);
    page.table({"run", "wall moved [mm]", "contact [N]", "force on the hand [N]",
                "largest depth beyond the wall [mm]", "volumes: mean error [%]", "largest [%]",
                "inverted tetrahedra", "processor time [s]"},
               {row_of_run("rod, all of the wall", all), row_of_run("rod, boxes", boxes[1]),
                row_of_run("tetrahedra, all of the wall", body)});
    page.paragraph(
        "Displacement, contact, force and volumes are those at the end, depth and inverted "
        "tetrahedra the largest of the whole run; a depth below 0 is a distance from the wall.");
    add_boxes(page, bend, all, boxes);
    add_models(page, bend, all, body);
}

}  // namespace pliant::results
