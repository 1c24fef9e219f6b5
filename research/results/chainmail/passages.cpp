// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// [Draeger2005], figures 5.11 and 5.12: walls that face each other, and a bump that protrudes into
// the air.

#include <pliant/chainmail.h>
#include <pliant/resample.h>

#include <algorithm>
#include <cmath>

#include "chart.h"
#include "figures.h"
#include "setups.h"

namespace pliant::results {
namespace {

constexpr double kIso_hu = -500;

// --- Figure 5.11 ---

/// Pushes the near wall in steps of 0.5 mm, and records the far wall's element opposite the tool.
/// @returns x: the push, y: the far wall's motion [mm]
std::vector<Point2> far_wall_motion(Scenario& s, double sign) {
    constexpr double kStep_mm = 0.5;
    constexpr int kSteps = 20;
    std::vector<Point2> motion{{0, 0}};
    double pushed = 0;
    for (int n = 0; n < kSteps; ++n) {
        pushed += kStep_mm * s.push(near_wall_patch(), {sign * kStep_mm, 0, 0}).step_fraction;
        motion.push_back({pushed, s.tissue->displacement_mm(kFarWall).x});
    }
    return motion;
}

/// The plane through the tool, deformed scan and lattice; the push goes to the right.
Image passage_picture(const Scenario& s, int pixels) {
    const Slice slice{0, 1, kNearWall.z};
    const Window window{22, 68, 9, 56};
    Plot plot(pixels, pixels, {22, 9}, {68, 55});
    draw_values(plot, deform_volume(*s.tissue).value().volume, slice, 3600, -900);
    draw_lattice(plot, *s.tissue, slice, window, {10, 1, 0});
    return plot.image();
}

/// First push after which the far wall has moved by more than 0.1 mm.
std::string onset_of(const std::vector<Point2>& motion) {
    constexpr double kMoved_mm = 0.1;
    for (const Point2 p : motion)
        if (std::abs(p.y) > kMoved_mm) return fixed_text(p.x, 1) + " mm";
    return "never";
}

void add_opposite_walls(Page& page, const TaskArena& arena) {
    page.heading(3, "Figure 5.11: walls that face each other");
    page.paragraph(
        "The thesis pushes one wall of a narrow passage, and a bump appears on the other one, "
        "although air is between them. To measure it: two walls of 50 HU, voxels of 1 mm, six "
        "voxels of air between them. A patch of the near wall's face, 4 mm in radius, is pushed "
        "across the gap (left pictures) and, in a second scan, away from it (right pictures), by "
        "10 mm in steps of 0.5 mm. Offset 0.2.");
    std::vector<std::vector<std::string>> rows;
    std::vector<std::vector<Point2>> curves;
    const auto add = [&](bool air, std::string_view name, std::string_view description) {
        Scenario towards = passage_scenario(air, arena), away = passage_scenario(air, arena);
        const auto near = far_wall_motion(towards, 1), far = far_wall_motion(away, -1);
        const Image pictures[] = {passage_picture(towards, 420), passage_picture(away, 420)};
        page.picture(name, description, row_of(pictures));
        const auto before = std::size_t(kGap_mm / 0.5);
        rows.push_back({air ? "on" : "off", onset_of(near), fixed_text(near[before].y, 2),
                        fixed_text(near.back().y, 2), fixed_text(far.back().y, 2)});
        curves.push_back(near);
        curves.push_back(far);
    };
    add(false, "draeger-5-11-walls", "air as a tissue: pushed across the gap, and away from it");
    add(true, "draeger-5-11-walls-air", "air as a material of its own: the same two pushes");
    Chart chart(720, 360, {"push of the near wall [mm]", 0, 10, 1},
                {"motion of the far wall [mm]", -10, 10, 2});
    const char* names[] = {"air as a tissue", "", "air of its own", ""};
    for (std::size_t n = 0; n < curves.size(); ++n)
        chart.curve(curves[n], {n < 2 ? kRed : kBlue, 2, 1}, names[n]);
    chart.mark(kGap_mm, {kDark, 1.2, 1}, "the faces touch");
    page.picture("draeger-5-11-motion", "motion of the far wall over the push", chart.image());
    page.paragraph(
        "Motion of the far wall [mm] over the push [mm]; red: air follows the law of its value, as "
        "in the thesis; blue: air as a material of its own, the default of Pliant. Upper curves: "
        "pushed across the gap; lower ones: away from it. Dashed: the faces touch.");
    page.table({"air of its own", "far wall moves after", "at 6 mm [mm]", "at 10 mm [mm]",
                "at 10 mm away [mm]"},
               rows);
    page.paragraph(
        "Off, the artefact of the thesis: the far wall moves long before contact, and follows when "
        "the near wall is pushed away. On, it stands still until the walls touch, then it is "
        "pushed; pushed away, the near wall leaves it alone.");
}

// --- Figure 5.12 ---

/// Height of the bump above the surrounding wall at rest.
double bump_height_mm(const Volume& volume, const TaskArena& arena) {
    const RayCaster caster(volume, arena);
    const auto surface = [&](int x, int z) {
        const auto hit =
            caster.first_hit({double(x), 1, double(z)}, {0, 1, 0}, kIso_hu, Polarity::Rising);
        return hit ? hit->point_mm.y : double(volume.grid.size.y);
    };
    double top = 1e9;
    for (int x = 20; x <= 60; ++x)
        for (int z = 16; z <= 48; ++z) top = std::min(top, surface(x, z));
    return surface(4, 4) - top;
}

Image bump_picture(const Scenario& s, int pixels) {
    const Slice slice{0, 1, kBumpTip.z};
    Plot plot(pixels, pixels, {20, 14}, {60, 54});
    draw_values(plot, deform_volume(*s.tissue).value().volume, slice, 3600, -900);
    draw_lattice(plot, *s.tissue, slice, {20, 61, 14, 55}, {8, 1, 0});
    return plot.image();
}

Image bump_view(const Volume& volume, const TaskArena& arena, int pixels) {
    Endoscope camera;
    camera.eye_mm = {16, 2, 46};
    camera.look = Vec3d{40, 27, 32} - camera.eye_mm;
    camera.field_of_view_deg = 58;
    camera.barrel_distortion = 0;
    camera.fog_distance_mm = 0;
    return RayCaster(volume, arena).endoscope_view(camera, pixels, pixels);
}

constexpr int kBumpSide_px = 400;

/// A bump at rest and pushed into the wall, with air as tissue and as a separate material.
void add_bump_pushes(Page& page, Bump bump, const TaskArena& arena) {
    const bool overhanging = bump == Bump::Overhang;
    const Vec3i tip = overhanging ? kHeadEnd : kBumpTip;
    std::vector<Image> views, cuts;
    std::vector<std::vector<std::string>> rows;
    for (const char* state : {"at rest", "pushed, off", "pushed, on"}) {
        Scenario s = bump_scenario(bump, state == std::string_view("pushed, on"), arena);
        const bool pushed = state != std::string_view("at rest");
        if (pushed) s.push(bump_push(bump));
        const Volume deformed = deform_volume(*s.tissue).value().volume;
        views.push_back(bump_view(deformed, arena, kBumpSide_px));
        cuts.push_back(bump_picture(s, kBumpSide_px));
        const Vec3i floor{tip.x, kWallFront + 1, tip.z};
        rows.push_back({state, pushed ? grouped_text(s.reports[0].moved_elements) : "",
                        fixed_text(bump_height_mm(deformed, arena), 2),
                        fixed_text(norm(s.tissue->displacement_mm(tip)), 2),
                        fixed_text(norm(s.tissue->displacement_mm(floor)), 2)});
    }
    const std::string name = overhanging ? "draeger-5-12-overhang" : "draeger-5-12-bump";
    page.picture(name, "from outside: at rest; pushed, air as a tissue; pushed, air of its own",
                 row_of(views, 8));
    page.picture(name + "-cut", "the same, cut through the tool", row_of(cuts, 8));
    page.table({"air of its own", "moved elements", "highest point over the wall [mm]",
                "motion of the pushed point [mm]", "of the wall below it [mm]"},
               rows);
}

/// The finger at rest, pushed, and bent aside by a sliding tool.
void add_finger(Page& page, const TaskArena& arena) {
    std::vector<Image> views, cuts;
    std::vector<std::vector<std::string>> rows;
    const auto add = [&](bool air, const char* tool) {
        Scenario s = bump_scenario(Bump::Finger, air, arena);
        if (tool == std::string_view("sticks")) push_finger(s);
        if (tool == std::string_view("slides")) slide_off_finger(s);
        const Volume deformed = deform_volume(*s.tissue).value().volume;
        if (air) {
            views.push_back(bump_view(deformed, arena, kBumpSide_px));
            cuts.push_back(bump_picture(s, kBumpSide_px));
        }
        const Vec3d tip = s.tissue->displacement_mm(kBumpTip);
        const Vec3i floor{kBumpTip.x, kWallFront + 1, kBumpTip.z};
        rows.push_back({tool, air ? "on" : "off", grouped_text(s.tissue->state().moved_elements),
                        fixed_text(bump_height_mm(deformed, arena), 2),
                        fixed_text(std::abs(tip.x), 2), fixed_text(tip.y, 2),
                        fixed_text(s.tissue->displacement_mm(floor).y, 2)});
    };
    add(true, "at rest");
    for (const char* tool : {"sticks", "slides"})
        for (const bool air : {false, true}) add(air, tool);
    page.picture("draeger-5-12-finger",
                 "from outside: at rest; a tool that sticks; one that it slides off",
                 row_of(views, 8));
    page.picture("draeger-5-12-finger-cut", "the same, cut through the tool", row_of(cuts, 8));
    page.table({"tool", "air of its own", "moved elements", "highest point over the wall [mm]",
                "tip aside [mm]", "tip down [mm]", "wall below it down [mm]"},
               rows);
}

void add_bump(Page& page, const TaskArena& arena) {
    page.heading(3, "Figure 5.12: the bump");
    page.paragraph(
        "In the thesis a bump vanishes when it is pushed: it goes into the wall, and nothing is "
        "left where it was. It should rather be pushed or bent to a side, the thesis says, and "
        "blames that the object does not know the tissue's shape. Two things are mixed in this: "
        "air that carries motion, and a tool that takes the bump along wherever it goes itself. "
        "Three bumps on a wall of 50 HU, voxels of 1 mm, offset 0.2, tell them apart. First a "
        "column, ten voxels high and nine wide, pushed into the wall by 8 mm; tool: a sphere of "
        "2.5 mm. Heights are over the wall where nothing moved.");
    add_bump_pushes(page, Bump::Column, arena);
    page.paragraph(
        "The column goes down with the wall: over the wall at rest next to nothing of it is left, "
        "which is the thesis's picture. Air of its own does not change that, and no propagation "
        "or relaxation can: the column's links give way by 0.19 of their length, so in every "
        "valid state the wall below is at most 0.19 times the column's height behind the tip. "
        "The column is not lost: it stands in the dent nearly as high as before. Second, a bump "
        "that hangs over, with six voxels of air below its head, pushed by 6 mm at its free end:");
    add_bump_pushes(page, Bump::Overhang, arena);
    page.paragraph(
        "Here air decides. Off, the wall below goes down long before the head touches it, and the "
        "bump sinks as a whole. On, the head bends down into the gap, and the wall below rests. "
        "The price is a small smear beside the stalk, where the air next to it is sheared far. "
        "Third, a finger, ten voxels high and three wide, and a sphere of 3 mm that comes down "
        "2 mm beside its axis, to 9 mm below the tip's height. Once it sticks, as the thesis's "
        "tool does: what it holds goes where it goes (`ChainMail::push`). Once tissue slides off "
        "it: what is in its way leaves it as its surface faces (`slide_sphere`).");
    add_finger(page, arena);
    page.paragraph(
        "Sticking, it goes down with the wall as the column does. Sliding, it is bent to a side, "
        "and the "
        "tool goes past it; the wall below hardly moves. Air of its own makes little difference "
        "to the finger here, and much to how much around it moves along: on an even wall the way "
        "through "
        "the tissue is as short as that through the air. A tool that comes down straight on the "
        "axis still pushes a finger into the wall: ChainMail knows no buckling.");
}

}  // namespace

void add_passages(Page& page, const std::filesystem::path& scans, const TaskArena& arena) {
    page.heading(2, "Dräger 2005, chapter 5: passages");
    add_nose(page, scans, arena);
    add_opposite_walls(page, arena);
    add_bump(page, arena);
}

}  // namespace pliant::results
