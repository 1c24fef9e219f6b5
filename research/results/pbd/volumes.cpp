// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The paper's constraints under a catheter's tip, with and without volume constraints.

#include <algorithm>

#include "cutaway.h"
#include "figures.h"
#include "pressed.h"

namespace pliant::results {
namespace {

constexpr Rgb8 kCatheter{226, 160, 60};
constexpr double kTip_deg = 120, kLargest_mm = 3, kLargest_percent = 30;
constexpr Camera kAlong{.right = 2,
                        .up = 0,
                        .low = {9, -10.5},
                        .high = {36, 11},
                        .px_per_mm = 12.5,
                        .cut_mm = 0.25,
                        .tick_mm = 5,
                        .bar_mm = 5};

Image picture_of(const PressedVessel& vessel, const PressedRun& run, bool as_volume,
                 std::string_view title) {
    const TetMesh& mesh = vessel.wall.mesh;
    Cutaway cutaway(kAlong);
    if (as_volume)
        cutaway.wall(mesh, run.wall_mm, volume_changes_of(mesh, run.wall_mm),
                     signed_to(kLargest_percent / 100));
    else
        cutaway.wall(mesh, run.wall_mm, displacements_of(mesh, run.wall_mm),
                     shaded_to(kLargest_mm));
    cutaway.wire(run.wire_mm, kPressingRadius_mm, kCatheter);
    cutaway.outline(mesh, mesh.nodes_mm);
    return cutaway.image(title);
}

}  // namespace

void add_volumes(Page& page, const TaskArena& arena) {
    const PressedVessel vessel = pressed_vessel();
    const PressedRun rest = run_pressed(vessel, true, 0, arena);
    const PressedRun with = run_pressed(vessel, true, kTip_deg, arena);
    const PressedRun without = run_pressed(vessel, false, kTip_deg, arena);
    page.heading(2, "The paper's constraints, with and without volumes");
    page.paragraph(
        "A straight vessel, inner radius 4 mm, 3 mm thick, 40 mm long, of " +
        grouped_text(std::int64_t(vessel.wall.mesh.cells.size())) +
        " tetrahedra with the constraints of the paper and its Eq. 1: each projection takes away "
        "the share k of a constraint, " +
        fixed_text(kStretch, 1) + " of a stretch, " + fixed_text(kBend, 2) + " of a bend, " +
        fixed_text(kVolume, 0) +
        " of a volume; or there are no volume constraints. One projection in each of 4,000 steps "
        "of 0.2 ms, outer surface and ends held. A catheter of radius "
        "1 mm (EI 7 N mm²) is held on the left, and its last 14 mm get a rest shape that is bent "
        "by 120° within half a second. The contact is that of `RodContact`.");
    const Image moved[] = {picture_of(vessel, rest, false, "before"),
                           picture_of(vessel, with, false, "with volume constraints"),
                           picture_of(vessel, without, false, "without volume constraints")};
    const LegendEntry entries[] = {{"edge of the cut at rest", {kRed, 1.4}},
                                   {"catheter", {kCatheter, 4}}};
    const Image legends[] = {
        shade_bar(kLargest_mm, 0, "displacement [mm]", std::max(with.moved_mm, without.moved_mm)),
        signed_bar(kLargest_percent, 0, "change of volume [%]",
                   100 * std::max(with.change.largest, without.change.largest)),
        legend_of(entries, moved[0].width)};
    const Image changed[] = {column_of(legends),
                             picture_of(vessel, with, true, "with: change of volume"),
                             picture_of(vessel, without, true, "without: change of volume")};
    const Image parts[] = {row_of(moved), row_of(changed)};
    page.picture("tip-volumes",
                 "a catheter's tip in the wall: mean error of the volumes within 4 mm of it " +
                     fixed_text(100 * with.mean_near_tip, 1) + " % with volume constraints and " +
                     fixed_text(100 * without.mean_near_tip, 1) + " % without",
                 column_of(parts));
    page.paragraph(
        "Mean error of the volumes of all tetrahedra: " + fixed_text(100 * with.change.mean, 2) +
        " % with volume constraints, " + fixed_text(100 * without.change.mean, 2) +
        " % without. Within 4 mm of the tip: " + fixed_text(100 * with.mean_near_tip, 1) + " and " +
        fixed_text(100 * without.mean_near_tip, 1) +
        " %. Without them the wall under the tip is lost rather than moved aside: of 3 mm, " +
        fixed_text(without.thinnest_mm, 2) + " mm are left, and " +
        std::to_string(without.inverted) + " tetrahedra are turned inside out; with them " +
        fixed_text(with.thinnest_mm, 2) + " mm are left, and " + std::to_string(with.inverted) +
        " are inverted.");
    std::vector<std::vector<std::string>> rows;
    for (const PressedRun* run : {&rest, &with, &without})
        rows.push_back({run == &rest   ? "before"
                        : run == &with ? "with"
                                       : "without",
                        fixed_text(run->moved_mm, 2), fixed_text(run->thinnest_mm, 2),
                        fixed_text(100 * run->change.mean, 2),
                        fixed_text(100 * run->mean_near_tip, 1),
                        fixed_text(100 * run->change.largest, 0), std::to_string(run->inverted)});
    page.table({"volumes", "wall moved [mm]", "thinnest wall [mm]", "volumes: mean error [%]",
                "within 4 mm of the tip [%]", "largest [%]", "inverted tetrahedra"},
               rows);
}

}  // namespace pliant::results
