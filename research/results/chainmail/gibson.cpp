// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// [Gibson1996]: sheets and a cube in the paper's style, as points, grid lines and polygons.

#include <algorithm>
#include <cmath>
#include <tuple>

#include "collision.h"
#include "figures.h"
#include "setups.h"
#include "timing.h"

namespace pliant::results {
namespace {

constexpr int kSheet = 180;

ObjectShape sheet_of(int side, std::function<bool(Vec3i)> inside,
                     std::function<bool(Vec3i)> fixed) {
    return {{side, side, 1}, std::move(inside), std::move(fixed)};
}
bool everywhere(Vec3i) {
    return true;
}

/// A sheet of paper with a margin around the object, which may leave its window.
Plot paper_for(int side, double margin, int pixels) {
    return Plot(pixels, pixels, {-margin, -margin}, {side - 1 + margin, side - 1 + margin});
}

Image lattice_picture(const Scenario& scenario, double margin, int pixels, LatticeStyle style) {
    const int side = scenario.scan->grid.size.x;
    Plot plot = paper_for(side, margin, pixels);
    draw_lattice(plot, *scenario.tissue, {0, 1, 0}, {0, side, 0, side}, style);
    return plot.image();
}

/// Quadrilaterals between elements, shaded by their stretch.
Image polygon_picture(const Scenario& scenario, double margin, int pixels) {
    const int side = scenario.scan->grid.size.x;
    Plot plot = paper_for(side, margin, pixels);
    const auto place = [&](int x, int y) {
        const Vec3d u = scenario.tissue->displacement_mm({x, y, 0});
        return Point2{x + u.x, y + u.y};
    };
    for (int y = 0; y + 1 < side; ++y)
        for (int x = 0; x + 1 < side; ++x) {
            const Point2 c[] = {place(x, y), place(x + 1, y), place(x + 1, y + 1), place(x, y + 1)};
            const double area = 0.5 * ((c[2].x - c[0].x) * (c[3].y - c[1].y) -
                                       (c[3].x - c[1].x) * (c[2].y - c[0].y));
            plot.polygon(c, shade_of(std::clamp(0.4 + 0.55 * (1 - area), 0.0, 1.0)));
        }
    return plot.image();
}

void add_stiffness(Page& page, const TaskArena& arena) {
    constexpr int kSweeps = 200;
    page.heading(3, "Figure 5: sheets of different stiffness");
    page.paragraph(
        "A sheet of 180 × 180 elements, the largest that the paper names in two dimensions. The "
        "element at (60, 90) is pulled by (30, −18) element distances. The limits are the same on "
        "all links; the paper's text gives none, so these are ours: nearly rigid, deformable, "
        "slack. Every fourth grid line is drawn. Upper row: the propagation alone. Lower row: "
        "relaxed, as in the paper, by " +
        grouped_text(std::int64_t(kSweeps)) +
        " sweeps of `ChainMail::relax` while the tool holds on: creases fade, no link leaves its "
        "limits, and elements that the pull did not reach stay at rest.");
    std::vector<Image> moved, relaxed;
    std::vector<std::vector<std::string>> rows;
    const std::tuple<double, double, const char*> limits[] = {
        {0.02, 0.02, "nearly rigid"}, {0.25, 0.25, "deformable"}, {0.6, 0.6, "slack"}};
    const std::vector<Vec3i> held{{60, 90, 0}};
    for (const auto& [range, shear, name] : limits) {
        Scenario sheet = gibson_object(sheet_of(kSheet, everywhere, nullptr), range, shear, arena);
        const auto& report = sheet.push(held, {30, -18, 0});
        const auto picture = [&, name = name](const char* state) {
            return captioned(lattice_picture(sheet, 24, 420, {30, 1, 0, -500, 4}),
                             std::string(name) + ", " + state);
        };
        moved.push_back(picture("moved"));
        const RelaxReport relax = must(
            sheet.tissue->relax({.max_sweeps = kSweeps, .held = held, .measure_energy = true}));
        relaxed.push_back(picture("relaxed"));
        rows.push_back(
            {"minDx = " + fixed_text(1 - range, 2) + ", maxDx = " + fixed_text(1 + range, 2) +
                 ", shear = " + fixed_text(shear, 2),
             grouped_text(report.moved_elements),
             fixed_text(100 * relax.energy_after_mm2 / relax.energy_before_mm2, 0) + " %",
             fixed_text(sheet.tissue->state().max_violation_mm, 6)});
    }
    const Image rows_of_pictures[] = {row_of(moved), row_of(relaxed)};
    page.picture("gibson-5-stiffness", "three sheets, the stiffest on the left; moved and relaxed",
                 column_of(rows_of_pictures));
    page.table({"limits", "moved of 32 400", "energy left by the relaxation",
                "worst link outside its limits [mm]"},
               rows);
}

void add_renderings(Page& page, const TaskArena& arena) {
    page.heading(3, "Figure 6: points, grid lines, shaded polygons");
    page.paragraph(
        "The same state drawn in the three ways that the paper names (its section 3.6): a sheet of "
        "40 × 40 elements, limits ±0.3, shear 0.3, one element pulled by (9, 6).");
    Scenario sheet = gibson_object(sheet_of(40, everywhere, nullptr), 0.3, 0.3, arena);
    sheet.push({{20, 20, 0}}, {9, 6, 0});
    const Image pictures[] = {lattice_picture(sheet, 5, 420, {9, 0, 2.2}),
                              lattice_picture(sheet, 5, 420, {9, 1.2, 0}),
                              polygon_picture(sheet, 5, 420)};
    page.picture("gibson-6-renderings", "the same sheet as points, lines and polygons",
                 row_of(pictures));
}

/// An open ring: not convex, so that motion must go round.
bool in_open_ring(Vec3i e) {
    const double x = e.x - 39.5, y = e.y - 39.5, r = std::hypot(x, y);
    return r < 36 && r > 20 && !(x > 0 && std::abs(y) < 9);
}

void add_objects(Page& page, const TaskArena& arena) {
    page.heading(3, "Figure 7: objects that are not convex, elements that are fixed");
    page.paragraph(
        "Left: an open ring, not convex; its lower end is pulled down and to the left. The motion "
        "reaches the upper end only through the ring, not across the opening. Right: a sheet whose "
        "left column and lower right corner are fixed (red); the pull (24, −14) at (40, 30) would "
        "move "
        "them, so it stops at the largest permitted fraction.");
    Scenario ring = gibson_object({{80, 80, 1}, in_open_ring, nullptr}, 0.15, 0.15, arena);
    ring.push({{70, 52, 0}, {69, 52, 0}, {68, 52, 0}, {67, 52, 0}}, {-14, 16, 0});
    const auto is_fixed = [](Vec3i e) { return e.x == 0 || (e.x > 70 && e.y > 70); };
    Scenario sheet = gibson_object(sheet_of(80, everywhere, is_fixed), 0.25, 0.25, arena);
    const PushReport report = sheet.push({{40, 30, 0}}, {24, -14, 0});
    Plot fixed = paper_for(80, 8, 520);
    draw_lattice(fixed, *sheet.tissue, {0, 1, 0}, {0, 80, 0, 80}, {12, 1, 1.4});
    for (int y = 0; y < 80; ++y)
        for (int x = 0; x < 80; ++x)
            if (is_fixed({x, y, 0})) fixed.dot({double(x), double(y)}, 2.2, kRed);
    const Image pictures[] = {lattice_picture(ring, 8, 520, {18, 1, 1.4}), fixed.image()};
    page.picture("gibson-7-objects", "an open ring, and a sheet with fixed elements",
                 row_of(pictures));
    page.paragraph(
        "Fraction of the pull that was done beside the fixed elements: " +
        fixed_text(report.step_fraction, 4) + " (limited by " +
        (report.limited_by == LimitedBy::Bone ? "fixed elements" : "something else") +
        "). The paper reduces the step and tries again until an allowed one is found; here the "
        "fraction is computed, and the next larger one would move a fixed element.");
}

/// The surface points of a cube, seen from a corner; distant ones are paler.
Image surface_points(const Scenario& scenario, int pixels) {
    const int side = scenario.scan->grid.size.x;
    struct Drawn {
        Point2 at;
        double depth, moved;
    };
    std::vector<Drawn> points;
    const double middle = 0.5 * (side - 1);
    for (int z = 0; z < side; ++z)
        for (int y = 0; y < side; ++y)
            for (int x = 0; x < side; ++x) {
                const auto edge = [&](int n) { return n == 0 || n == side - 1; };
                if (!edge(x) && !edge(y) && !edge(z)) continue;
                const Vec3d u = scenario.tissue->displacement_mm({x, y, z});
                const Vec3d p = Vec3d{x - middle, y - middle, z - middle} + u;
                points.push_back({{0.82 * p.x + 0.57 * p.y, 0.30 * p.x - 0.43 * p.y - 0.85 * p.z},
                                  -0.49 * p.x + 0.70 * p.y - 0.52 * p.z,
                                  norm(u)});
            }
    std::sort(points.begin(), points.end(),
              [](const Drawn& a, const Drawn& b) { return a.depth > b.depth; });
    Plot plot(pixels, pixels, {-0.95 * side, -1.15 * side}, {1.25 * side, 1.05 * side});
    for (const Drawn& p : points)
        plot.dot(p.at, 1.3, shade_of(0.2 + 0.8 * p.moved / 26),
                 std::clamp(0.6 - 0.6 * p.depth / side, 0.08, 1.0));
    return plot.image();
}

void add_solid(Page& page, const TaskArena& arena) {
    page.heading(3, "Figure 8: a cube of 50 × 50 × 50 elements");
    page.paragraph(
        "125 000 elements, the largest object of the paper; surface points, as there. A corner is "
        "pulled outwards by (15, 15, 15) element distances; limits ±0.3 and shear 0.3 (left), ±0.1 "
        "and shear 0.1 (right).");
    constexpr int kRuns = 21;
    const std::vector<Vec3i> corner{{49, 49, 49}};
    std::vector<Image> pictures;
    std::vector<std::vector<std::string>> rows;
    for (const double limit : {0.3, 0.1}) {
        std::vector<double> times_ms;
        Scenario cube;
        for (int n = 0; n < kRuns; ++n) {
            cube = gibson_object({{50, 50, 50}, everywhere, nullptr}, limit, limit, arena);
            times_ms.push_back(milliseconds_of([&] { cube.push(corner, {15, 15, 15}); }));
        }
        pictures.push_back(surface_points(cube, 560));
        rows.push_back({"±" + fixed_text(limit, 1), grouped_text(cube.reports[0].moved_elements),
                        fixed_text(quantile(times_ms, 0.5), 2)});
    }
    page.picture("gibson-8-cube", "surface points of a pulled cube, soft and stiff",
                 row_of(pictures));
    page.table({"limits", "moved of 125 000", "the pull, median of 21 fresh cubes [ms]"}, rows);
    page.paragraph(
        "The paper reports at least three frames a second for this cube on an SGI Indy, drawing "
        "and relaxation included. Its deformation alone is not timed there.");
}

void add_collisions(Page& page, const TaskArena& arena) {
    page.heading(3, "Section 3.5: objects that collide");
    page.paragraph(
        "The paper checks each element that moves against the other objects and the walls of the "
        "space, and takes the motion back where two would overlap. `ObjectSpace` computes the time "
        "of the first impact instead. A free ring and tissue with a bay, fixed at its back, 1 mm "
        "between elements, links ±30 %: the ring is pulled by its front until it meets the bay; "
        "pushed from behind, it is squeezed as far as its front can stay; the lip of the tissue is "
        "pulled down onto it; and it is pulled back to the wall. Squares are the boxes of the "
        "elements, which never overlap those of another object.");
    const std::vector<collision::Frame> frames = must(collision::play(arena));
    page.picture("gibson-collision", "a ring that is pulled into a bay of tissue and back",
                 collision::picture_of(frames));
    std::vector<std::vector<std::string>> rows;
    for (const collision::Frame& frame : frames) {
        if (frame.pushed < 0) continue;
        const PushReport& push = frame.report.push;
        rows.push_back({frame.title, fixed_text(norm(frame.push_mm), 1),
                        fixed_text(push.step_fraction * norm(frame.push_mm), 3),
                        frame.report.wall >= 0                    ? "wall"
                        : frame.report.object == collision::kRing ? "ring"
                                                                  : "tissue",
                        grouped_text(push.moved_elements)});
    }
    page.table({"push", "requested [mm]", "done [mm]", "stopped by", "moved elements"}, rows);
    page.paragraph(
        "The picture is also written by the example `research/examples/colliding_objects` "
        "(`colliding_objects "
        "collision.png`); with `--check` it compares all pairs of boxes after each push, and the "
        "tests run it so.");
}

void add_recovery(Page& page, const TaskArena& arena) {
    constexpr double kYield = 0.4;
    page.heading(3, "Section 5: elastic and plastic");
    page.paragraph(
        "The paper's conclusion claims rigid, deformable, elastic and plastic materials in one "
        "system. A sheet of 60 × 60 elements, limits ±0.5, shear 0.5, held at its left and right "
        "edges (red), is pulled in its middle by (6, −9) mm and relaxed while the tool holds on. "
        "Then the tool lets go, and the sheet is relaxed until nothing moves. Without a yield "
        "limit it goes back to where it was. With `yield` = 0.4, strain beyond 40 % of the limits "
        "stays: an imprint of 1 − 0.4 of the pull.");
    std::vector<Image> seen;  // held and released, elastic and then plastic
    std::vector<std::vector<std::string>> rows;
    for (const double yield : {0.0, kYield}) {
        const Recovery found = recovery_of(yield, arena, [&](const Scenario& sheet) {
            Plot plot = paper_for(kRecoverySide, 5, 380);
            draw_lattice(plot, *sheet.tissue, {0, 1, 0}, {0, kRecoverySide, 0, kRecoverySide},
                         {11, 1, 0, -500, 2});
            for (int y = 0; y < kRecoverySide; y += 2)
                for (const int x : {0, kRecoverySide - 1})
                    plot.dot({double(x), double(y)}, 2.2, kRed);
            seen.push_back(plot.image());
        });
        rows.push_back({yield > 0 ? "plastic" : "elastic", fixed_text(yield, 1),
                        fixed_text(found.pulled_mm, 3), fixed_text(found.left_mm, 3)});
    }
    const Image pictures[] = {captioned(seen[0], "pulled, the tool holds on"),
                              captioned(seen[1], "let go: elastic"),
                              captioned(seen[3], "let go: plastic")};
    page.picture("gibson-recovery", "a sheet that is pulled; elastic and plastic, after letting go",
                 row_of(pictures));
    page.table(
        {"material", "yield", "largest displacement while held [mm]", "after letting go [mm]"},
        rows);
}

}  // namespace

void add_gibson(Page& page, const TaskArena& arena) {
    page.heading(2, "Gibson 1996");
    add_chains(page, arena);
    page.paragraph(
        "For its figures 5 to 8, [Gibson1996] shows sheets, objects with holes and fixed elements, "
        "and a cube, without naming limits or motions; the text that we have holds no captions for "
        "these figures. What they show follows from its section 4. Elements are 1 mm apart, "
        "colours go from pale (at rest) to dark (moved farthest). The paper relaxes the object "
        "after each move; here that is shown for figure 5, and the others show the propagation "
        "alone.");
    add_stiffness(page, arena);
    add_renderings(page, arena);
    add_objects(page, arena);
    add_solid(page, arena);
    add_collisions(page, arena);
    add_recovery(page, arena);
}

}  // namespace pliant::results
