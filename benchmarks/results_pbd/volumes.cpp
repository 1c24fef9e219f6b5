// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The paper's constraints under a catheter's tip, with and without those of volume.

#include "cutaway.h"
#include "figures.h"
#include "pressed.h"

namespace pliant::results {
namespace {

constexpr Rgb8 kCatheter{226, 160, 60};
constexpr double kTip_deg = 120, kLargest_mm = 3, kLargest_percent = 30;
constexpr Camera kAlong{.right = 2,
                        .up = 0,
                        .low = {9, -9},
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
    page.heading(2, "A catheter's tip in the paper's constraints, with and without volumes");
    const Image moved[] = {picture_of(vessel, rest, false, "before"),
                           picture_of(vessel, with, false, "with volume constraints"),
                           picture_of(vessel, without, false, "without")};
    const Image changed[] = {picture_of(vessel, with, true, "with volume constraints"),
                             picture_of(vessel, without, true, "without")};
    const LegendEntry entries[] = {{"edge of the cut at rest", {kRed, 1.4}},
                                   {"catheter", {kCatheter, 4}}};
    const Image legend[] = {shade_bar(kLargest_mm, 0, "displacement of the wall [mm]"),
                            signed_bar(kLargest_percent, 0, "change of volume [%]"),
                            legend_of(entries, 420)};
    const Image parts[] = {row_of(moved), row_of(changed), row_of(legend)};
    page.picture("tip-volumes", "x", column_of(parts));
    std::vector<std::vector<std::string>> rows;
    for (const PressedRun* run : {&rest, &with, &without})
        rows.push_back({run == &rest   ? "before"
                        : run == &with ? "with"
                                       : "without",
                        text_of(run->moved_mm, 2), text_of(run->thinnest_mm, 2),
                        text_of(100 * run->change.mean, 2), text_of(100 * run->mean_near_tip, 1),
                        text_of(100 * run->change.largest, 0), std::to_string(run->inverted)});
    page.table({"volumes", "wall moved [mm]", "thinnest wall [mm]", "volumes: mean error [%]",
                "within 4 mm of the tip [%]", "largest [%]", "inverted tetrahedra"},
               rows);
}

}  // namespace pliant::results
