// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Vessels under pressure and under a push, drawn as sections through their tetrahedra.

#include <pliant/models/pbd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "cutaway.h"
#include "figures.h"
#include "timing.h"
#include "tube_mesh.h"

namespace pliant::results {
namespace {

using bench::Tube;
constexpr double kStep = 1.0 / 256;

/// Lengths in mm, masses in g, moduli in Pa. The ends are held.
PbdParts vessel(const Tube& tube, const TetMesh& mesh, bool volumes) {
    PbdParts parts = value_of(pbd_of_mesh(mesh, {.density = 1e-3,
                                                 .edge_compliance = 1e-3,
                                                 .bend_compliance = 1,
                                                 .volumes = volumes,
                                                 .bends = true}));
    for (int k : {0, tube.along})
        for (int r = 0; r <= tube.across; ++r)
            for (int a = 0; a < tube.around; ++a)
                parts.inverse_masses[std::size_t(tube.node(a, r, k))] = 0;
    return parts;
}

constexpr double kFull_percent = 10;  ///< change of volume with the darkest colour
constexpr double kPush_mm = 4;

const LegendEntry kAtRest{"edge of the cut at rest", {kRed, 1.4}};

/// A cut across the vessel's middle, coloured by changes of volume.
Image across(const Tube& tube, const TetMesh& mesh, const std::vector<Vec3d>& positions,
             std::string_view title) {
    Cutaway cutaway({.right = 0,
                     .up = 1,
                     .low = {-10, -10},
                     .high = {10, 10},
                     .px_per_mm = 12,
                     .cut_mm = 0.51 * tube.length,
                     .tick_mm = 5,
                     .bar_mm = 2});
    cutaway.wall(mesh, positions, volume_changes_of(mesh, positions),
                 signed_to(kFull_percent / 100));
    cutaway.outline(mesh, mesh.nodes_mm);
    return cutaway.image(title);
}

/// A cut along the vessel, beside the nodes in the plane of its axis.
Image along(const TetMesh& mesh, const std::vector<Vec3d>& positions, const CornerValues& values,
            double largest_mm, std::string_view title) {
    Cutaway cutaway({.right = 2,
                     .up = 0,
                     .low = {15, -12},
                     .high = {65, 12},
                     .px_per_mm = 9,
                     .cut_mm = 0.3,
                     .tick_mm = 5,
                     .bar_mm = 5});
    cutaway.wall(mesh, positions, values, shaded_to(largest_mm));
    cutaway.outline(mesh, mesh.nodes_mm);
    return cutaway.image(title);
}

std::vector<Vec3d> places_of(const PbdBody& body) {
    std::vector<Vec3d> positions(std::size_t(body.particle_count()));
    body.get_positions(positions);
    return positions;
}

/// Forces of a pressure of 1 on the inner nodes at rest.
void press(const Tube& tube, const PbdParts& parts, double pressure, PbdBody& body) {
    std::vector<std::int32_t> nodes;
    std::vector<Vec3d> forces;
    const double side = 2 * tube.inner * std::sin(std::numbers::pi / tube.around);
    const double area = side * tube.length / tube.along;
    for (int k = 0; k <= tube.along; ++k)
        for (int a = 0; a < tube.around; ++a) {
            const std::int32_t n = tube.node(a, 0, k);
            const Vec3d p = parts.positions[std::size_t(n)];
            nodes.push_back(n);
            forces.push_back((pressure * area / tube.inner) * Vec3d{p.x, p.y, 0});
        }
    must(body.load(nodes, forces));
}

/// Four pictures in two rows, and a bar of colours below.
Image with_legend(std::span<const Image> pictures, const Image& bar) {
    const LegendEntry entries[] = {kAtRest};
    const Image legend[] = {bar, legend_of(entries, 300)};
    const Image parts[] = {row_of(pictures.first(2)), row_of(pictures.last(2)), row_of(legend)};
    return column_of(parts);
}

struct Radii {
    double inner = 0, outer = 0;
};
Radii radii_of(const Tube& tube, const std::vector<Vec3d>& positions) {
    Radii radii;
    for (int a = 0; a < tube.around; ++a) {
        const Vec3d p = positions[std::size_t(tube.node(a, 0, tube.along / 2))];
        const Vec3d q = positions[std::size_t(tube.node(a, tube.across, tube.along / 2))];
        radii.inner += std::hypot(p.x, p.y) / tube.around;
        radii.outer += std::hypot(q.x, q.y) / tube.around;
    }
    return radii;
}

/// Volume error against time.
void add_sub_steps(Page& page, const Tube& tube, const TetMesh& mesh, const TaskArena& arena) {
    page.paragraph(
        "Volumes of compliance 0 are not kept to the last bit under a load that lasts: each "
        "sub-step "
        "projects each of them once. The same tube under 40 Pa, with more and more sub-steps, "
        "after "
        "half a second; and at rest again, half a second after the pressure is gone.");
    std::vector<std::vector<std::string>> rows;
    const PbdParts parts = vessel(tube, mesh, true);
    struct Run {
        int sub_steps;
        bool alternates;
    };
    const Run runs[] = {{5, false},  {10, false}, {20, false}, {40, false},
                        {80, false}, {40, true},  {80, true},  {160, true}};
    for (const auto [sub_steps, alternates] : runs) {
        auto body = value_of(PbdBody::create(parts, {.time_step = kStep,
                                                     .sub_steps = sub_steps,
                                                     .iterations = alternates ? 2 : 1,
                                                     .damping = 20,
                                                     .alternates = alternates}));
        press(tube, parts, 40, body);
        const double ms = processor_ms_of([&] { must(body.step(128, arena)); }) / 128;
        const VolumeChange loaded = volume_change(parts, places_of(body));
        const double radius = radii_of(tube, places_of(body)).inner;
        press(tube, parts, 0, body);
        must(body.step(128, arena));
        const VolumeChange after = volume_change(parts, places_of(body));
        rows.push_back({std::to_string(sub_steps), alternates ? "to and fro" : "one way",
                        fixed_text(ms, 2), fixed_text(radius, 2), fixed_text(100 * loaded.mean, 3),
                        fixed_text(100 * loaded.largest, 2), fixed_text(100 * after.mean, 4),
                        fixed_text(100 * after.largest, 3)});
    }
    page.table({"sub-steps", "order", "processor time of a step [ms]", "inner radius [mm]",
                "under load: mean [%]", "largest [%]", "after it: mean [%]", "largest [%]"},
               rows);
    page.paragraph(
        "The radius, too, depends on the sub-steps: with few of them the vessel is too soft under "
        "a load that lasts. With 80 in one order the vessel shakes, without any load as well. To "
        "and "
        "fro, each sub-step goes through the constraints in one order and then in the opposite "
        "one, "
        "and nothing shakes; why, [pbd.md](../../method/pbd.md) says. There are more volumes, "
        "17,280, than "
        "coordinates that are free, 11,040, so the tube gets the stiffer the better they are "
        "kept.");
}

/// A wall in which a patch of nodes moves outwards.
struct Push {
    Tube tube{};
    TetMesh mesh = bench::tube_mesh(tube);
    PbdParts parts = vessel(tube, mesh, true);
    Vec3d tip{tube.inner, 0, 0.5 * tube.length};
    std::vector<std::int32_t> pushed;  ///< inner nodes within 2.5 mm of the tip

    Push() {
        for (int k = 0; k <= tube.along; ++k)
            for (int a = 0; a < tube.around; ++a) {
                // Surrounding tissue: outer nodes are attached to their rest positions.
                const std::int32_t outer = tube.node(a, tube.across, k);
                parts.attachments.push_back({.nodes = {outer, 0, 0, 0},
                                             .target = parts.positions[std::size_t(outer)],
                                             .compliance = 5e-3});
                const std::int32_t inner = tube.node(a, 0, k);
                if (norm(mesh.nodes_mm[std::size_t(inner)] - tip) < 2.5) pushed.push_back(inner);
            }
    }
};

struct PushRun {
    std::vector<std::vector<Vec3d>> positions;  ///< after each millimetre
    std::vector<bool> is_held;                  ///< [tetrahedron]
    double share = 1, ms = 0;                   ///< active tetrahedra; processor time
};
/// @param reach  of the boxes; 0: the whole wall moves
PushRun run_push(const Push& push, double reach, const TaskArena& arena) {
    PushRun run;
    auto body = value_of(PbdBody::create(push.parts, {.time_step = kStep, .damping = 20}));
    auto boxes = value_of(PbdBoxes::create(push.mesh, {.side = 6, .blend_steps = 1}));
    if (reach > 0) must(boxes.update({&push.tip, 1}, reach, body));
    if (reach > 0) run.share = double(boxes.active_tetrahedra()) / double(push.mesh.cells.size());
    for (const auto& cell : push.mesh.cells)
        run.is_held.push_back(std::any_of(cell.begin(), cell.end(), [&](std::int32_t n) {
            return reach > 0 && body.inverse_mass(n) == 0;
        }));
    for (const std::int32_t n : push.pushed) must(body.set_inverse_mass(n, 0));
    for (int step = 1; step <= 256; ++step) {
        for (const std::int32_t n : push.pushed) {
            const Vec3d p = push.mesh.nodes_mm[std::size_t(n)];
            must(body.set_state(n, p + Vec3d{kPush_mm * step / 256, 0, 0}, {0, 0, 0}));
        }
        run.ms += processor_ms_of([&] { must(body.step(1, arena)); });
        if (step % 64 == 0) run.positions.push_back(places_of(body));
    }
    return run;
}

double farthest_of(const std::vector<Vec3d>& a, const std::vector<Vec3d>& b) {
    double farthest = 0;
    for (std::size_t n = 0; n < a.size(); ++n) farthest = std::max(farthest, norm(a[n] - b[n]));
    return farthest;
}

void draw_push(Page& page, const Push& push, const PushRun& all, const PushRun& local) {
    std::vector<Image> frames;
    for (std::size_t n = 0; n < all.positions.size(); ++n)
        frames.push_back(along(push.mesh, all.positions[n],
                               displacements_of(push.mesh, all.positions[n]), kPush_mm,
                               "pushed by " + grouped_text(std::int64_t(n + 1)) + " mm"));
    page.picture("push-all", "the pushed vessel cut open, all of it active",
                 with_legend(frames, shade_bar(kPush_mm, 0, "displacement [mm]")));
    CornerValues moved = displacements_of(push.mesh, local.positions.back());
    for (std::size_t c = 0; c < moved.size(); ++c)
        if (local.is_held[c]) moved[c].fill(std::numeric_limits<double>::quiet_NaN());
    constexpr double kFull_um = 100;
    const LegendEntry entries[] = {kAtRest, {"held", {kHeld, 1}, LegendEntry::Mark::Box}};
    const Image left[] = {
        along(push.mesh, local.positions.back(), moved, kPush_mm, "boxes within 12 mm"),
        shade_bar(kPush_mm, 0, "displacement [mm]")};
    const Image right[] = {
        along(push.mesh, local.positions.back(),
              distances_of(push.mesh, all.positions.back(), local.positions.back()),
              kFull_um / 1000, "difference from all active"),
        shade_bar(kFull_um, 0, "distance [µm]",
                  1000 * farthest_of(all.positions.back(), local.positions.back()))};
    const Image both[] = {column_of(left), column_of(right)};
    const Image parts[] = {row_of(both), legend_of(entries, 600)};
    page.picture("push-local", "boxes within 12 mm active, and the difference from all",
                 column_of(parts));
}

}  // namespace

void add_pressure(Page& page, const TaskArena& arena) {
    const Tube tube{.around = 40, .across = 3, .along = 24, .outer = 8, .length = 30};
    const TetMesh mesh = bench::tube_mesh(tube);
    const double pressures[] = {0, 40, 80, 120};
    page.heading(2, "Pressure, with and without volume conservation");
    page.paragraph(
        "A tube of " + grouped_text(std::int64_t(mesh.cells.size())) +
        " tetrahedra, radii 6 and 8 mm, 30 mm long, its ends held; distances of 10⁻³, folds of 1, "
        "volumes of compliance 0 or none. Half a second for each pressure, at 256 steps a second "
        "with twenty sub-steps. The pictures are cut across the middle; a tetrahedron's colour is "
        "its change of volume, the red line is the edge of the cut at rest, and the narrow ring "
        "inside the cut "
        "is the inner surface behind it, down to the end that is held.");
    std::vector<std::vector<std::string>> rows;
    for (const bool volumes : {true, false}) {
        const PbdParts parts = vessel(tube, mesh, volumes);
        const PbdParts all = vessel(tube, mesh, true);  // for its volumes
        auto body =
            value_of(PbdBody::create(parts, {.time_step = kStep, .sub_steps = 20, .damping = 20}));
        std::vector<Image> pictures;
        double largest = 0;
        for (const double pressure : pressures) {
            press(tube, parts, pressure, body);
            must(body.step(128, arena));
            const std::vector<Vec3d> positions = places_of(body);
            pictures.push_back(across(tube, mesh, positions, fixed_text(pressure, 0) + " Pa"));
            const VolumeChange change = volume_change(all, positions);
            largest = std::max(largest, change.largest);
            const Radii radii = radii_of(tube, positions);
            rows.push_back({volumes ? "with" : "without", fixed_text(pressure, 0),
                            fixed_text(radii.inner, 2), fixed_text(radii.outer - radii.inner, 2),
                            fixed_text(100 * change.total, 3), fixed_text(100 * change.mean, 3),
                            fixed_text(100 * change.largest, 2)});
        }
        page.picture(volumes ? "pressure-with-volumes" : "pressure-without-volumes",
                     volumes ? "cuts across the tube with volume conservation, 0 to 120 Pa"
                             : "the same without",
                     with_legend(pictures, signed_bar(kFull_percent, 0, "change of volume [%]",
                                                      100 * largest)));
    }
    page.table({"volumes", "pressure [Pa]", "inner radius [mm]", "wall [mm]", "volume: total [%]",
                "mean of tetrahedra [%]", "largest [%]"},
               rows);
    add_sub_steps(page, tube, mesh, arena);
}

void add_push(Page& page, const TaskArena& arena) {
    const Push push;
    page.heading(2, "A push, with and without locality");
    page.paragraph(
        "A vessel of " + grouped_text(std::int64_t(push.mesh.cells.size())) +
        " tetrahedra, radii 6 and 7.5 mm, 80 mm long, material as above with volume "
        "conservation. " +
        grouped_text(std::int64_t(push.pushed.size())) +
        " nodes of the inner wall are taken outwards, a millimetre in a quarter of a second, four "
        "times. Boxes of 6 mm; those within a reach of the tip are active. The vessel is cut open "
        "along its axis: first with all of it active, then after the last millimetre with a reach "
        "of 12 mm, beside the distance of each point from where it is with all active. Times "
        "include the ties, which are projected one by one.");
    const PushRun all = run_push(push, 0, arena);
    std::vector<std::vector<std::string>> rows{
        {"all", "100", "", "", fixed_text(all.ms / 256, 2), "1"}};
    for (const double reach : {2.0, 6.0, 12.0, 18.0}) {
        const PushRun local = run_push(push, reach, arena);
        const double largest = farthest_of(local.positions.back(), all.positions.back());
        if (reach == 12) draw_push(page, push, all, local);
        rows.push_back({fixed_text(reach, 0), fixed_text(100 * local.share, 1),
                        fixed_text(largest, 3), fixed_text(100 * largest / kPush_mm, 1),
                        fixed_text(local.ms / 256, 2), fixed_text(all.ms / local.ms, 1)});
    }
    page.table({"reach [mm]", "active tetrahedra [%]", "largest difference from all [mm]",
                "of the push [%]", "processor time of a step [ms]", "times faster"},
               rows);
}

}  // namespace pliant::results
