// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// [Choi2004, 3.3, Figures 8 and 15]: surfaces of a lung and a stomach as mass-spring networks,
// touched by the point of a probe that moves as a hand does, 1000 times a second.

#include <pliant/research/spring_probe.h>
#include <pliant/scan_files.h>
#include <pliant/volume.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "figures.h"
#include "organ_surface.h"
#include "plot.h"
#include "published_times.h"
#include "timing.h"

namespace pliant::results {
namespace {

constexpr double kTick_s = 1e-3, kHand_mm_s = 100;
constexpr int kSteps = 4;  ///< time steps in a tick
constexpr int kSide = 420;

struct Organ {
    std::string name;
    TriangleMesh surface;
    /// Of the wall, and of the home springs: an elastic layer under it.
    double wall_pa, wall_mm, inside_pa, inside_mm;
    Vec3d look;  ///< direction of view
    double push_mm;
    Vec3d aside_mm;
};

double area_of(const TriangleMesh& m) {
    double sum = 0;
    for (const auto& [a, b, c] : m.cells)
        sum += 0.5 * norm(cross(m.nodes_mm[std::size_t(b)] - m.nodes_mm[std::size_t(a)],
                                m.nodes_mm[std::size_t(c)] - m.nodes_mm[std::size_t(a)]));
    return sum;
}

/// Links along the edges: a wall of thickness t and modulus E as a triangular lattice of stiffness
/// √3/2·E·t. Each node has a link of rest length 0 to a fixed node at its rest position.
SpringNetwork network_of(const Organ& organ) {
    const auto& nodes = organ.surface.nodes_mm;
    const double node_mm2 = area_of(organ.surface) / double(nodes.size());
    const double mass = node_mm2 * organ.wall_mm * 1e-3;
    constexpr double kDecay_s = 0.005;
    SpringParts parts = value_of(
        springs_of_triangles(nodes, organ.surface.cells,
                             {.stiffness = 0.5 * std::sqrt(3.0) * organ.wall_pa * organ.wall_mm,
                              .node_damping = mass / kDecay_s,
                              .node_mass = mass}));
    const auto count = std::int32_t(nodes.size());
    for (std::int32_t n = 0; n < count; ++n) {
        parts.nodes.push_back({.rest = nodes[std::size_t(n)], .fixed = true});
        parts.links.push_back({.a = n,
                               .b = count + n,
                               .stiffness = organ.inside_pa * node_mm2 / organ.inside_mm,
                               .rest_length = 0});
    }
    return value_of(SpringNetwork::create(std::move(parts)));
}

/// The point of the surface that is nearest to the eye, near the line of sight through the organ's
/// middle.
Vec3d touched_point(const Organ& organ, Vec3d& normal) {
    constexpr double kOff_mm = 8;
    Vec3d middle{0, 0, 0};
    for (const Vec3d& p : organ.surface.nodes_mm)
        middle = middle + (1.0 / double(organ.surface.nodes_mm.size())) * p;
    double nearest = 1e300;
    Vec3d found = middle;
    for (const auto& t : organ.surface.cells) {
        const auto at = [&](std::size_t k) { return organ.surface.nodes_mm[std::size_t(t[k])]; };
        const Vec3d centre = (1.0 / 3) * (at(0) + at(1) + at(2)), v = centre - middle;
        const double away = dot(v, organ.look);
        if (norm(v - away * organ.look) > kOff_mm || away > nearest) continue;
        nearest = away;
        found = centre;
        normal = normalized(cross(at(1) - at(0), at(2) - at(0)));
    }
    return found;
}

/// Positions of the hand, one for each tick: to the surface, in, aside, out.
std::vector<Vec3d> hand_of(const Organ& organ) {
    Vec3d normal{0, 0, 0};
    const Vec3d point = touched_point(organ, normal);
    const std::array<Vec3d, 4> stops{point + 10.0 * normal, point - organ.push_mm * normal,
                                     point - organ.push_mm * normal + organ.aside_mm,
                                     point + 15.0 * normal + organ.aside_mm};
    std::vector<Vec3d> hand{stops[0]};
    for (std::size_t k = 0; k + 1 < stops.size(); ++k) {
        const Vec3d way = stops[k + 1] - stops[k];
        const int ticks = int(std::ceil(norm(way) / (kHand_mm_s * kTick_s)));
        // From rest to rest, as a hand moves.
        for (int n = 1; n <= ticks; ++n) {
            const double t = double(n) / ticks;
            hand.push_back(stops[k] + (t * t * (3 - 2 * t)) * way);
        }
    }
    return hand;
}

/// Index of the tick at the end of the push.
std::size_t pushed_tick(const Organ& organ) {
    return std::size_t(std::ceil((10 + organ.push_mm) / (kHand_mm_s * kTick_s)));
}
std::size_t aside_tick(const Organ& organ) {
    return pushed_tick(organ) +
           std::size_t(std::ceil(norm(organ.aside_mm) / (kHand_mm_s * kTick_s)));
}

// Pictures.

/// Parallel view of a surface, its triangles from far to near, coloured by displacement.
Image view_of(const Organ& organ, const SpringTissue& tissue, const Vec3d* tip, double darkest_mm,
              std::string_view title) {
    const Vec3d look = normalized(organ.look);
    const Vec3d right = normalized(
                    cross(look, std::abs(look.z) > 0.9 ? Vec3d{0, 1, 0} : Vec3d{0, 0, 1})),
                up = cross(right, look);
    Point2 low{1e300, 1e300}, high{-1e300, -1e300};
    for (const Vec3d& p : organ.surface.nodes_mm) {
        low = {std::min(low.x, dot(p, right)), std::min(low.y, dot(p, up))};
        high = {std::max(high.x, dot(p, right)), std::max(high.y, dot(p, up))};
    }
    const double half = 0.5 * std::max(high.x - low.x, high.y - low.y) + 12;
    const Point2 middle{0.5 * (low.x + high.x), 0.5 * (low.y + high.y)};
    Plot plot(kSide, kSide, {middle.x - half, middle.y + half}, {middle.x + half, middle.y - half});
    struct Face {
        double depth;
        std::array<Point2, 3> corners;
        Rgb8 colour;
    };
    std::vector<Face> faces;
    const Vec3d lamp = normalized(-1.0 * look + 0.7 * up - 0.5 * right);
    for (const auto& t : organ.surface.cells) {
        std::array<Vec3d, 3> x;
        Face face{};
        double moved_mm = 0;
        for (std::size_t k = 0; k < 3; ++k) {
            x[k] = tissue.position(t[k]);
            moved_mm += norm(tissue.displacement(t[k])) / 3;
            face.corners[k] = {dot(x[k], right), dot(x[k], up)};
            face.depth += dot(x[k], look) / 3;
        }
        const Vec3d normal = cross(x[1] - x[0], x[2] - x[0]);
        if (dot(normal, look) >= 0) continue;
        const double light = 0.45 + 0.6 * std::max(0.0, dot(normal, lamp) / norm(normal));
        const Rgb8 full = shade_of(moved_mm / darkest_mm);
        const auto lit = [&](std::uint8_t c) {
            return std::uint8_t(std::lround(std::min(255.0, light * c)));
        };
        face.colour = {lit(full.r), lit(full.g), lit(full.b)};
        faces.push_back(face);
    }
    std::sort(faces.begin(), faces.end(),
              [](const Face& a, const Face& b) { return a.depth > b.depth; });
    for (const Face& face : faces) plot.polygon(face.corners, face.colour);
    if (tip) {
        const Point2 at{dot(*tip, right), dot(*tip, up)};
        plot.line({at.x + 0.45 * half, at.y + 0.45 * half}, at, {kOrange, 2});
        plot.dot(at, 4, kOrange);
    }
    plot.scale_bar(20, "20 mm");
    return captioned(plot.image(), title);
}

/// The surface's cut with the plane through the hand's way, at rest (dashed) and now.
Image section_of(const Organ& organ, const SpringTissue& tissue, const std::vector<Vec3d>& hand,
                 Vec3d tip, std::string_view title) {
    const Vec3d in = normalized(hand[pushed_tick(organ)] - hand[0]);
    const Vec3d side = normalized(organ.aside_mm - dot(organ.aside_mm, in) * in);
    const Vec3d normal = cross(in, side), origin = hand[pushed_tick(organ)];
    constexpr double kHalf_mm = 45;
    Plot plot(kSide, kSide, {-kHalf_mm, -kHalf_mm}, {kHalf_mm, kHalf_mm});
    const auto flat = [&](Vec3d p) { return Point2{dot(p - origin, side), dot(p - origin, in)}; };
    for (const bool at_rest : {true, false})
        for (const auto& t : organ.surface.cells) {
            std::vector<Point2> ends;
            for (std::size_t k = 0; k < 3; ++k) {
                const auto place = [&](std::int32_t n) {
                    return at_rest ? organ.surface.nodes_mm[std::size_t(n)] : tissue.position(n);
                };
                const Vec3d a = place(t[k]), b = place(t[(k + 1) % 3]);
                const double u = dot(a - origin, normal), v = dot(b - origin, normal);
                if ((u <= 0) == (v <= 0)) continue;
                ends.push_back(flat(a + (u / (u - v)) * (b - a)));
            }
            if (ends.size() != 2) continue;
            if (at_rest)
                plot.line(ends[0], ends[1], {kFaint, 2});
            else
                plot.line(ends[0], ends[1], {kBlue, 2});
        }
    plot.line({flat(tip).x, flat(tip).y - 40}, flat(tip), {kOrange, 2});
    plot.dot(flat(tip), 4, kOrange);
    plot.scale_bar(20, "20 mm");
    return captioned(plot.image(), title);
}

// Measurements.

struct Touched {
    std::int32_t nodes = 0;
    double search_us = 0, update_us = 0, tick_us = 0, slowest_us = 0;
    double pushed_n = 0;  ///< force at the end of the push
};

SpringTissue tissue_of(const Organ& organ, std::int32_t depth) {
    return value_of(
        SpringTissue::create(network_of(organ), {.depth = depth, .time_step = kTick_s / kSteps}));
}

/// Search and update with the nodes that the tool holds now.
void measure(const Organ& organ, std::int32_t depth, const SpringTissue& tissue,
             const SpringProbe& probe, const TaskArena& arena, Touched& found) {
    constexpr int kTurns = 301, kRun = 20;
    SpringTissue still = tissue_of(organ, depth);
    std::vector<Vec3d> positions;
    for (const std::int32_t k : probe.nodes()) positions.push_back(tissue.position(k));
    must(still.hold(probe.nodes()));
    must(still.move_held(positions));
    std::vector<double> search_us, update_us;
    for (int turn = 0; turn < kTurns; ++turn) {
        search_us.push_back(1e3 * milliseconds_of([&] {
                                value_of(transmittal_order(tissue.network(), probe.nodes(), depth));
                            }));
        update_us.push_back(1e3 / kRun *
                            milliseconds_of([&] { value_of(still.step(kRun, arena)); }));
    }
    found.search_us = quantile(search_us, 0.5);
    found.update_us = quantile(update_us, 0.5);
}

/// The hand's way, several times: all runs are alike, and other work on the machine delays
/// different ticks of each.
Touched touch(const Organ& organ, std::int32_t depth, const TaskArena& arena) {
    constexpr int kRuns = 7;
    const std::vector<Vec3d> hand = hand_of(organ);
    Touched found;
    std::vector<double> least_us(hand.size(), 1e300);
    std::vector<std::uint8_t> is_touched(hand.size(), 0);
    for (int run = 0; run < kRuns; ++run) {
        SpringTissue tissue = tissue_of(organ, depth);
        SpringProbe probe = value_of(SpringProbe::create(tissue.network(), organ.surface.cells));
        must(probe.place(tissue, hand[0]));
        for (std::size_t n = 1; n < hand.size(); ++n) {
            Vec3d force{0, 0, 0};
            SpringProbeMove moved;
            const double us =
                1e3 * processor_ms_of([&] {
                    moved = value_of(probe.move(tissue, hand[n], kSteps, arena));
                    if (!probe.nodes().empty())
                        force = value_of(tissue.reaction(probe.nodes(), ReactionLaw::Held)).force;
                });
            least_us[n] = std::min(least_us[n], us);
            is_touched[n] = !probe.nodes().empty();
            if (run > 0 || n != pushed_tick(organ)) continue;
            found.pushed_n = 1e-6 * norm(force);
            found.nodes = moved.active_nodes + std::int32_t(probe.nodes().size());
            measure(organ, depth, tissue, probe, arena, found);
        }
    }
    std::vector<double> ticks_us;
    for (std::size_t n = 1; n < hand.size(); ++n)
        if (is_touched[n] != 0) ticks_us.push_back(least_us[n]);
    found.tick_us = quantile(ticks_us, 0.5);
    found.slowest_us = quantile(ticks_us, 1);
    return found;
}

Image pictures_of(const Organ& organ, const TaskArena& arena) {
    SpringTissue tissue = tissue_of(organ, 20);
    SpringProbe probe = value_of(SpringProbe::create(tissue.network(), organ.surface.cells));
    const std::vector<Vec3d> hand = hand_of(organ);
    must(probe.place(tissue, hand[0]));
    std::vector<Image> views, sections;
    const auto add = [&](std::size_t tick, std::string_view title) {
        const Vec3d tip = probe.position();
        views.push_back(view_of(organ, tissue, &tip, organ.push_mm, title));
        sections.push_back(section_of(organ, tissue, hand, hand[tick], "section"));
    };
    add(0, "at rest");
    for (std::size_t n = 1; n < hand.size(); ++n) {
        value_of(probe.move(tissue, hand[n], kSteps, arena));
        if (n == pushed_tick(organ)) add(n, "pressed");
        if (n == aside_tick(organ)) add(n, "drawn aside");
    }
    const Image rows[] = {row_of(views), row_of(sections),
                          shade_bar(organ.push_mm, 0, "displacement [mm]")};
    return column_of(rows, 6);
}

/// Air of the lungs, at every second voxel along each axis.
Volume lung_labels(const Volume& scan) {
    Volume labels;
    labels.grid = scan.grid;
    const Vec3i size{scan.grid.size.x / 2, scan.grid.size.y / 2, scan.grid.size.z / 2};
    labels.grid.size = size;
    labels.grid.spacing_mm = 2.0 * scan.grid.spacing_mm;
    std::vector<std::int16_t> voxels;
    for (int k = 0; k < size.z; ++k)
        for (int j = 0; j < size.y; ++j)
            for (int i = 0; i < size.x; ++i) {
                const double hu = scan.at({2 * i, 2 * j, 2 * k});
                voxels.push_back(hu > -950 && hu < -600 ? 1 : 0);
            }
    labels.voxels = std::move(voxels);
    return labels;
}

std::string times(const Touched& t) {
    return fixed_text(t.search_us, 2) + " + " + fixed_text(t.update_us, 2);
}

}  // namespace

void add_touched(Page& page, const std::filesystem::path& scans, const TaskArena& arena) {
    page.heading(2, "Figure 15: a lung and a stomach, touched");
    const auto thorax = read_volume(scans / "thorax_ct_256.nrrd");
    const auto abdomen = read_volume(scans / "abdomen_ct_3mm-label.nii.gz");
    if (!thorax.ok() || !abdomen.ok()) {
        page.paragraph("The scans are missing from this run: " +
                       (thorax.ok() ? abdomen.error() : thorax.error()).message);
        return;
    }
    constexpr std::size_t kLungNodes = 1769, kStomachNodes = 512;
    constexpr int kStomach = 6;
    const Organ organs[] = {{"lung",
                             value_of(organ_surface(lung_labels(*thorax), 1, 2, kLungNodes, arena)),
                             5e3,
                             10,
                             5e3,
                             50,
                             normalized({-1, 0.5, -0.1}),
                             20,
                             {0, 15, 25}},
                            {"stomach",
                             value_of(organ_surface(*abdomen, kStomach, 0.8, kStomachNodes, arena)),
                             20e3,
                             4,
                             2e3,
                             30,
                             normalized({0.1, 1, -0.1}),
                             12,
                             {-6, 0, -10}}};
    const TaskArena one_thread(1);
    page.paragraph(
        "The paper touches a lung of 1769 nodes and 3534 polygons and a stomach of 512 nodes and "
        "1020 polygons with the point of a PHANToM (3.3, Figure 8), and doesn't say how a hollow "
        "surface is kept up, nor its stiffness. Here: " +
        grouped_text(std::int64_t(organs[0].surface.nodes_mm.size())) + " nodes and " +
        grouped_text(std::int64_t(organs[0].surface.cells.size())) +
        " triangles of the left lung of `thorax_ct_256.nrrd` (−950 to −600 HU), and " +
        grouped_text(std::int64_t(organs[1].surface.nodes_mm.size())) + " and " +
        grouped_text(std::int64_t(organs[1].surface.cells.size())) +
        " of the stomach of `abdomen_ct_3mm-label.nii.gz`, which has labels in 90 mm of the height "
        "only, so that the stomach is cut off below and above. Surfaces are smoothed, made of "
        "triangles of one size, and reduced to exactly these numbers by collapsing their shortest "
        "edges. Links lie along the edges, with the stiffness √3/2·E·t of a wall (lung: 5 kPa, 10 "
        "mm; stomach: 20 kPa, 4 mm). Each node also has a link of rest length 0 to a fixed node "
        "at its rest position, for what is inside: an elastic layer (5 kPa, 50 mm thick; 2 kPa, 30 "
        "mm). Chords to the opposite wall would do it too, but forces would jump along them, and "
        "layers would no longer be those of the surface. The moduli are guesses.");
    page.paragraph(
        "The hand goes 10 mm to the surface, " + fixed_text(organs[0].push_mm, 0) + " and " +
        fixed_text(organs[1].push_mm, 0) +
        " mm in, aside while it presses, and out, at 100 mm/s on the average; 1000 positions a "
        "second, each with four time steps of 0.25 ms and the force (Eq. 19). Pictures are of 20 "
        "layers: displacement of each triangle, and below the section along the hand's way (pale: "
        "at rest), with the probe in orange. A point is on one triangle, which is held whole, so "
        "the dent's bottom is that triangle.");
    page.picture("choi-15-lung", "a lung, at rest, pressed and drawn aside",
                 pictures_of(organs[0], one_thread));
    page.picture("choi-15-stomach", "a stomach, at rest, pressed and drawn aside",
                 pictures_of(organs[1], one_thread));
    page.paragraph(
        "Times on one thread [µs]: search of the order from the three nodes, and update of all "
        "nodes reached in one step, at the end of the push (medians of 301 turns; the paper's are "
        "those of its Table 3, for a sheet: it gives none for the organs). Nodes of such meshes "
        "have no regular numbering, so that an update costs more than in the sheet. A tick is the "
        "whole servo step: contact with all triangles, search where the contact is new, four "
        "updates, force. The hand's way is run seven times, and each tick counts with its least "
        "processor time, since the machine had other work; median and slowest of the ticks that "
        "touched. The slowest are new contacts, whose nodes are searched and numbered. Beside "
        "ticks of 1 ms, both organs can be felt to 10 layers without a late one.");
    for (const Organ& organ : organs) {
        std::vector<std::vector<std::string>> rows;
        for (const Published& p : kTable3) {
            const Touched t = touch(organ, p.layers, one_thread);
            rows.push_back(
                {std::to_string(p.layers), std::to_string(p.nodes),
                 fixed_text(1000 * p.search_ms, 0) + " + " + fixed_text(1000 * p.update_ms, 0),
                 std::to_string(t.nodes), times(t), fixed_text(t.tick_us, 0),
                 fixed_text(t.slowest_us, 0), fixed_text(t.pushed_n, 3)});
        }
        page.table({"layers, " + organ.name, "2004: nodes", "2004: search + update", "nodes",
                    "search + update", "tick", "slowest tick", "force at the end [N]"},
                   rows);
    }
}

}  // namespace pliant::results
