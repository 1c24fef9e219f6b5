// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// [Draeger2005], figures 5.9, 5.11 and 5.12: the way through the nose, walls that face each other,
// and a bump that stands out into the air.

#include <pliant/phantom.h>
#include <pliant/resample.h>

#include <algorithm>
#include <cmath>

#include "chart.h"
#include "figures.h"
#include "setups.h"

namespace pliant::results {
namespace {

constexpr double kIso_hu = -500;

// --- Figure 5.9 ---

void add_nose(Page& page, const TaskArena& arena) {
    page.heading(3, "Figure 5.9: through the nose");
    page.paragraph(
        "The thesis's CT of a head is not at hand; this is `pliant phantom sinus`, 160³ voxels of "
        "0.8 mm. The endoscope is in the right-hand passage of the picture, between septum and "
        "turbinate, and looks towards the sphenoid sinus. Offset 0.2, scale factor 1.2, tool: a "
        "sphere of 2.5 mm. From left to right: at rest; the septum pushed aside; once more, "
        "farther in; then the turbinate, on the opposite side.");
    PhantomSettings phantom;
    phantom.name = "sinus";
    phantom.size = {160, 160, 160};
    ChainMailSettings settings;
    settings.scale = 1.2;
    Scenario s = make_scenario(must(make_phantom(phantom, arena)).volume, settings, arena);
    Endoscope camera;
    camera.eye_mm = {4.6, -42, -9};
    camera.look = {0, 1, -0.04};
    camera.field_of_view_deg = 75;
    const auto view = [&](const Volume& volume) {
        return RayCaster(volume, arena).endoscope_view(camera, 310, 310);
    };
    /// Where a ray from the endoscope meets the wall, a little inside.
    const auto wall = [&](const Volume& volume, Vec3d direction) {
        const auto hit =
            RayCaster(volume, arena).first_hit(camera.eye_mm, direction, kIso_hu, Polarity::Rising);
        const double distance = hit ? hit->distance_mm + 0.6 : 10;
        return camera.eye_mm + distance * normalized(direction);
    };
    const std::pair<Vec3d, Vec3d> pushes[] = {{{-0.3, 1, 0.1}, {-2.5, 0.8, 0}},
                                              {{-0.17, 1, -0.1}, {-2.5, 1, 0}},
                                              {{0.3, 1, -0.32}, {0.6, 2.5, -1}}};
    std::vector<Image> pictures{view(*s.scan)};
    std::vector<std::vector<std::string>> rows;
    for (const auto& [direction, push_mm] : pushes) {
        const Vec3d place = wall(deform_volume(*s.tissue).volume, direction);
        const PushReport& report = s.push({place, push_mm, 2.5});
        pictures.push_back(view(deform_volume(*s.tissue).volume));
        rows.push_back({std::to_string(rows.size() + 1), text_of(report.step_fraction, 3),
                        report.limited_by == LimitedBy::Bone ? "bone" : "–",
                        text_of(report.moved_elements), text_of(report.solve_ms, 2)});
    }
    page.picture("draeger-5-9-nose", "the passage at rest and after each of three pushes",
                 row_of(pictures, 8));
    page.table({"push", "done", "limited by", "moved elements", "solve [ms]"}, rows);
}

// --- Figure 5.11 ---

/// Pushes the near wall in half millimetres, and reads the far wall's element opposite the tool.
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
    draw_values(plot, deform_volume(*s.tissue).volume, slice, 3600, -900);
    draw_lattice(plot, *s.tissue, slice, window, {10, 1, 0});
    return plot.image();
}

/// The first push after which the far wall has moved by more than a tenth of a millimetre.
std::string onset_of(const std::vector<Point2>& motion) {
    constexpr double kMoved_mm = 0.1;
    for (const Point2 p : motion)
        if (std::abs(p.y) > kMoved_mm) return text_of(p.x, 1) + " mm";
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
        rows.push_back({air ? "on" : "off", onset_of(near), text_of(near[before].y, 2),
                        text_of(near.back().y, 2), text_of(far.back().y, 2)});
        curves.push_back(near);
        curves.push_back(far);
    };
    add(false, "draeger-5-11-walls", "air as a tissue: pushed across the gap, and away from it");
    const bool air = has_air(arena);
    if (air)
        add(true, "draeger-5-11-walls-air", "air as a material of its own: the same two pushes");
    Chart chart(720, 320, {0, 10, 1}, {-10, 10, 2});
    for (std::size_t n = 0; n < curves.size(); ++n)
        chart.curve(curves[n], {n < 2 ? kRed : kBlue, 2, 1});
    chart.mark(kGap_mm, {kDark, 1.2, 1});
    page.picture("draeger-5-11-motion", "motion of the far wall over the push", chart.image());
    page.paragraph(
        std::string("Motion of the far wall [mm] over the push [mm]; red: air follows the law of "
                    "its value, as in the thesis") +
        (air ? "; blue: air as a material of its own" : "") +
        ". Upper curves: pushed across the gap; lower ones: away from it. Dashed: the walls "
        "touch.");
    page.table({"air of its own", "far wall moves after", "at 6 mm [mm]", "at 10 mm [mm]",
                "at 10 mm away [mm]"},
               rows);
    page.paragraph(
        "Off, the artefact of the thesis: the far wall moves long before contact, and follows when "
        "the near wall is pushed away." +
        std::string(air ? " On, it stands still until the walls touch, then it is pushed; pushed "
                          "away, the near wall leaves it alone."
                        : ""));
}

// --- Figure 5.12 ---

/// How far the bump stands out of the wall around it, by rays along the push.
double bump_height_mm(const Volume& volume, const TaskArena& arena) {
    const RayCaster caster(volume, arena);
    const auto surface = [&](double x, double z) {
        const auto hit = caster.first_hit({x, 1, z}, {0, 1, 0}, kIso_hu, Polarity::Rising);
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
    draw_values(plot, deform_volume(*s.tissue).volume, slice, 3600, -900);
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

void add_bump(Page& page, const TaskArena& arena) {
    page.heading(3, "Figure 5.12: the bump");
    page.paragraph(
        "A bump, ten voxels high and eight wide, stands out of a wall of 50 HU; voxels of 1 mm, "
        "offset 0.2. A sphere of 3 mm on its tip pushes it by (2, 8, 0) mm: into the wall and a "
        "little to the side. In the thesis the bump vanishes; it says that it should rather be "
        "pushed or bent to a side.");
    Scenario rest = bump_scenario(false, arena);
    std::vector<Image> views{bump_view(*rest.scan, arena, 400)}, cuts{bump_picture(rest, 400)};
    std::vector<std::vector<std::string>> rows{
        {"at rest", "", "", text_of(bump_height_mm(*rest.scan, arena), 2)}};
    for (const bool air : {false, true}) {
        if (air && !has_air(arena)) continue;
        Scenario s = bump_scenario(air, arena);
        const PushReport report =
            s.push({{double(kBumpTip.x), kBumpTip.y + 1.0, double(kBumpTip.z)}, {2, 8, 0}, 3});
        const Volume deformed = deform_volume(*s.tissue).volume;
        views.push_back(bump_view(deformed, arena, 400));
        cuts.push_back(bump_picture(s, 400));
        rows.push_back({air ? "pushed, air of its own" : "pushed, air as a tissue",
                        text_of(report.step_fraction, 3), text_of(report.moved_elements),
                        text_of(bump_height_mm(deformed, arena), 2)});
    }
    page.picture("draeger-5-12-bump", "the bump from outside, before and after", row_of(views));
    page.picture("draeger-5-12-bump-cut", "cut through the tool", row_of(cuts));
    page.table({"state", "done", "moved elements", "the bump's height [mm]"}, rows);
}

}  // namespace

void add_passages(Page& page, const TaskArena& arena) {
    page.heading(2, "Dräger 2005, chapter 5: passages");
    add_nose(page, arena);
    add_opposite_walls(page, arena);
    add_bump(page, arena);
}

}  // namespace pliant::results
