// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Vessels under pressure and under a push, drawn as sections through their tetrahedra.

#include <pliant/pbd.h>
#include <pliant/pbd_boxes.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "figures.h"
#include "plot.h"
#include "timing.h"
#include "tube_mesh.h"

namespace pliant::results {
namespace {

using bench::Tube;
constexpr double kStep = 1.0 / 256;

/// Lengths in mm, masses in g, moduli in Pa. Its ends are held.
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

double volume_of(const std::array<Vec3d, 4>& p) {
    return dot(cross(p[1] - p[0], p[2] - p[0]), p[3] - p[0]) / 6;
}

/// Red: less than its rest volume; blue: more. All colour at 10 %.
Rgb8 colour_of(double change) {
    const double t = std::clamp(change / 0.1, -1.0, 1.0);
    const Rgb8 full = t < 0 ? kRed : kBlue;
    const auto mix = [&](int from, int to) {
        return std::uint8_t(std::lround(from + (to - from) * std::abs(t)));
    };
    return {mix(232, full.r), mix(232, full.g), mix(228, full.b)};
}

struct Window {
    int width, height;
    Point2 low, high;
    int axis;      ///< the plane's normal: 1 or 2
    double place;  ///< along it
};

/// The plane's cut through each tetrahedron, coloured by what its volume has changed by.
Image section(const TetMesh& mesh, const std::vector<Vec3d>& places, const Window& window) {
    Plot plot(window.width, window.height, window.low, window.high);
    const int across = window.axis == 2 ? 0 : 2, up = window.axis == 2 ? 1 : 0;
    for (const auto& cell : mesh.cells) {
        std::array<Vec3d, 4> p, rest;
        for (std::size_t n = 0; n < 4; ++n) {
            p[n] = places[std::size_t(cell[n])];
            rest[n] = mesh.nodes_mm[std::size_t(cell[n])];
        }
        std::vector<Point2> cut;
        for (std::size_t a = 0; a < 4; ++a)
            for (std::size_t b = a + 1; b < 4; ++b) {
                const double u = p[a][window.axis] - window.place;
                const double v = p[b][window.axis] - window.place;
                if ((u < 0) == (v < 0)) continue;
                const Vec3d x = p[a] + (u / (u - v)) * (p[b] - p[a]);
                cut.push_back({x[across], x[up]});
            }
        if (cut.size() < 3) continue;
        // Around their middle, so that four corners don't cross.
        Point2 middle{0, 0};
        for (const Point2& c : cut) {
            middle.x += c.x / double(cut.size());
            middle.y += c.y / double(cut.size());
        }
        std::sort(cut.begin(), cut.end(), [&](const Point2& a, const Point2& b) {
            return std::atan2(a.y - middle.y, a.x - middle.x) <
                   std::atan2(b.y - middle.y, b.x - middle.x);
        });
        plot.polygon(cut, colour_of(volume_of(p) / volume_of(rest) - 1));
        plot.polyline(cut, {.colour = kDark, .width_px = 0.6, .opacity = 0.35}, true);
    }
    return plot.image();
}

std::vector<Vec3d> places_of(const PbdBody& body) {
    std::vector<Vec3d> places(std::size_t(body.particle_count()));
    body.get_positions(places);
    return places;
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
            const Vec3d p = parts.places[std::size_t(n)];
            nodes.push_back(n);
            forces.push_back((pressure * area / tube.inner) * Vec3d{p.x, p.y, 0});
        }
    must(body.load(nodes, forces));
}

struct Radii {
    double inner = 0, outer = 0;
};
Radii radii_of(const Tube& tube, const std::vector<Vec3d>& places) {
    Radii radii;
    for (int a = 0; a < tube.around; ++a) {
        const Vec3d p = places[std::size_t(tube.node(a, 0, tube.along / 2))];
        const Vec3d q = places[std::size_t(tube.node(a, tube.across, tube.along / 2))];
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
        bool to_and_fro;
    };
    const Run runs[] = {{5, false},  {10, false}, {20, false}, {40, false},
                        {80, false}, {40, true},  {80, true},  {160, true}};
    for (const auto [sub_steps, to_and_fro] : runs) {
        auto body = value_of(PbdBody::create(parts, {.time_step = kStep,
                                                     .sub_steps = sub_steps,
                                                     .iterations = to_and_fro ? 2 : 1,
                                                     .damping = 20,
                                                     .to_and_fro = to_and_fro}));
        press(tube, parts, 40, body);
        const double ms = processor_ms_of([&] { must(body.step(128, arena)); }) / 128;
        const VolumeChange loaded = volume_change(parts, places_of(body));
        const double radius = radii_of(tube, places_of(body)).inner;
        press(tube, parts, 0, body);
        must(body.step(128, arena));
        const VolumeChange after = volume_change(parts, places_of(body));
        rows.push_back({std::to_string(sub_steps), to_and_fro ? "to and fro" : "one way",
                        text_of(ms, 2), text_of(radius, 2), text_of(100 * loaded.mean, 3),
                        text_of(100 * loaded.largest, 2), text_of(100 * after.mean, 4),
                        text_of(100 * after.largest, 3)});
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
        "and nothing shakes; why, [pbd.md](../../pbd.md) says. There are more volumes, 17,280, "
        "than "
        "coordinates that are free, 11,040, so the tube gets the stiffer the better they are "
        "kept.");
}

}  // namespace

void add_pressure(Page& page, const TaskArena& arena) {
    const Tube tube{.around = 40, .across = 3, .along = 24, .outer = 8, .length = 30};
    const TetMesh mesh = bench::tube_mesh(tube);
    const double pressures[] = {0, 40, 80, 120};
    page.heading(2, "Pressure, with and without volume conservation");
    page.paragraph(
        "A tube of " + text_of(std::int64_t(mesh.cells.size())) +
        " tetrahedra, radii 6 and 8 mm, 30 mm long, its ends held; distances of 10⁻³, folds of 1, "
        "volumes of compliance 0 or none. Half a second for each pressure, at 256 steps a second "
        "with twenty sub-steps. Sections through the middle; colour is what a tetrahedron's "
        "volume has changed by: red less, blue more, full at 10 %.");
    std::vector<std::vector<std::string>> rows;
    for (const bool volumes : {true, false}) {
        const PbdParts parts = vessel(tube, mesh, volumes);
        const PbdParts all = vessel(tube, mesh, true);  // for its volumes
        auto body =
            value_of(PbdBody::create(parts, {.time_step = kStep, .sub_steps = 20, .damping = 20}));
        std::vector<Image> pictures;
        for (const double pressure : pressures) {
            press(tube, parts, pressure, body);
            must(body.step(128, arena));
            const std::vector<Vec3d> places = places_of(body);
            pictures.push_back(
                section(mesh, places, {230, 230, {-13, -13}, {13, 13}, 2, 0.51 * tube.length}));
            const VolumeChange change = volume_change(all, places);
            const Radii radii = radii_of(tube, places);
            rows.push_back({volumes ? "with" : "without", text_of(pressure, 0),
                            text_of(radii.inner, 2), text_of(radii.outer - radii.inner, 2),
                            text_of(100 * change.total, 3), text_of(100 * change.mean, 3),
                            text_of(100 * change.largest, 2)});
        }
        page.picture(volumes ? "pressure-with-volumes" : "pressure-without-volumes",
                     volumes ? "sections with volume conservation, pressure rising to the right"
                             : "the same without",
                     row_of(pictures));
    }
    page.table({"volumes", "pressure [Pa]", "inner radius [mm]", "wall [mm]", "volume: total [%]",
                "mean of tetrahedra [%]", "largest [%]"},
               rows);
    add_sub_steps(page, tube, mesh, arena);
}

void add_push(Page& page, const TaskArena& arena) {
    const Tube tube{};
    const TetMesh mesh = bench::tube_mesh(tube);
    PbdParts parts = vessel(tube, mesh, true);
    // What surrounds it: the outer nodes are tied to where they are at rest.
    for (int k = 0; k <= tube.along; ++k)
        for (int a = 0; a < tube.around; ++a) {
            const std::int32_t n = tube.node(a, tube.across, k);
            parts.attachments.push_back({.nodes = {n, 0, 0, 0},
                                         .target = parts.places[std::size_t(n)],
                                         .compliance = 5e-3});
        }
    const Vec3d tip{tube.inner, 0, 0.5 * tube.length};
    // The inner nodes within 2.5 mm of the tip are taken outwards.
    std::vector<std::int32_t> pushed;
    for (int k = 0; k <= tube.along; ++k)
        for (int a = 0; a < tube.around; ++a) {
            const std::int32_t n = tube.node(a, 0, k);
            if (norm(mesh.nodes_mm[std::size_t(n)] - tip) < 2.5) pushed.push_back(n);
        }
    page.heading(2, "A push, with and without locality");
    page.paragraph(
        "A vessel of " + text_of(std::int64_t(mesh.cells.size())) +
        " tetrahedra, radii 6 and 7.5 mm, 80 mm long, material as above with volume "
        "conservation. " +
        text_of(std::int64_t(pushed.size())) +
        " nodes of the inner wall are taken outwards, a millimetre in a quarter of a second, four "
        "times. Boxes of 6 mm; those within a reach of the tip are active. Pictures are sections "
        "along the axis, all of it active; then the same with a reach of 12 mm. Times include the "
        "ties, which are projected one by one.");
    const auto run = [&](double reach, std::vector<Image>& pictures, double& share, double& ms) {
        auto body = value_of(PbdBody::create(parts, {.time_step = kStep, .damping = 20}));
        auto boxes = value_of(PbdBoxes::create(mesh, {.side = 6, .blend_steps = 1}));
        if (reach > 0) must(boxes.update({&tip, 1}, reach, body));
        share = reach > 0 ? double(boxes.active_tetrahedra()) / double(mesh.cells.size()) : 1;
        for (const std::int32_t n : pushed) must(body.set_inverse_mass(n, 0));
        ms = 0;
        for (int step = 1; step <= 256; ++step) {
            for (const std::int32_t n : pushed) {
                const Vec3d p = mesh.nodes_mm[std::size_t(n)];
                must(body.set_state(n, p + Vec3d{4.0 * step / 256, 0, 0}, {0, 0, 0}));
            }
            ms += processor_ms_of([&] { must(body.step(1, arena)); });
            if (step % 64 == 0)
                pictures.push_back(
                    section(mesh, places_of(body), {230, 300, {25, 13}, {55, -9}, 1, 0.01}));
        }
        return places_of(body);
    };
    std::vector<Image> pictures;
    double share = 1, all_ms = 0;
    const std::vector<Vec3d> all = run(0, pictures, share, all_ms);
    page.picture("push-all", "sections of the pushed vessel, all of it active", row_of(pictures));
    std::vector<std::vector<std::string>> rows{
        {"all", "100", "", "", text_of(all_ms / 256, 2), "1"}};
    for (const double reach : {2.0, 6.0, 12.0, 18.0}) {
        pictures.clear();
        double ms = 0;
        const std::vector<Vec3d> local = run(reach, pictures, share, ms);
        double largest = 0;
        for (std::size_t n = 0; n < all.size(); ++n)
            largest = std::max(largest, norm(local[n] - all[n]));
        if (reach == 12)
            page.picture("push-local", "the same with boxes within 12 mm active", row_of(pictures));
        rows.push_back({text_of(reach, 0), text_of(100 * share, 1), text_of(largest, 3),
                        text_of(100 * largest / 4, 1), text_of(ms / 256, 2),
                        text_of(all_ms / ms, 1)});
    }
    page.table({"reach [mm]", "active tetrahedra [%]", "largest difference from all [mm]",
                "of the push [%]", "processor time of a step [ms]", "times faster"},
               rows);
}

}  // namespace pliant::results
