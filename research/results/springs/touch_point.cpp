// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// [Choi2004, 3.3, Figure 8]: the point of a device (HIP) against a net of triangles. The collided
// triangle is translated by the point's penetration, and the reaction is the sum of the forces at
// its three vertices (Eq. 19), here beside the derivative of the net's energy.

#include <pliant/research/spring_probe.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "chart.h"
#include "figures.h"

namespace pliant::results {
namespace {

constexpr int kNet = 21;  ///< nodes along each side
constexpr double kEdge_mm = 6, kDeepest_mm = 6, kDepthStep_mm = 0.25;
constexpr std::int32_t kLayers = 2 * kNet;  ///< all of the net

struct Net {
    std::vector<Vec3d> nodes;
    std::vector<std::array<std::int32_t, 3>> triangles;  ///< their outer side is +z
    std::int32_t pressed = 0;                            ///< triangle in the middle
};

Net flat_net() {
    Net net;
    const double row = 0.5 * std::sqrt(3.0) * kEdge_mm;
    for (int j = 0; j < kNet; ++j)
        for (int i = 0; i < kNet; ++i)
            net.nodes.push_back({(i - 0.5 * (kNet - 1) + 0.5 * (j % 2) - 0.25) * kEdge_mm,
                                 (j - 0.5 * (kNet - 1)) * row, 0});
    const auto node = [](int i, int j) { return std::int32_t(i + kNet * j); };
    for (int j = 0; j + 1 < kNet; ++j)
        for (int i = 0; i + 1 < kNet; ++i) {
            const int odd = j % 2;
            net.triangles.push_back({node(i, j), node(i + 1, j), node(i + odd, j + 1)});
            net.triangles.push_back({node(i + 1 - odd, j), node(i + 1, j + 1), node(i, j + 1)});
        }
    double least = 1e300;
    for (std::size_t t = 0; t < net.triangles.size(); ++t) {
        Vec3d middle{0, 0, 0};
        for (const std::int32_t n : net.triangles[t])
            middle = middle + (1.0 / 3) * net.nodes[std::size_t(n)];
        if (norm(middle) >= least) continue;
        least = norm(middle);
        net.pressed = std::int32_t(t);
    }
    return net;
}

/// A wall of 20 kPa, 4 mm thick, on an elastic layer of 2 kPa, 30 mm thick, as of the stomach of
/// Figure 15; its border is fixed.
SpringTissue tissue_of(const Net& net) {
    constexpr double kWall_pa = 20e3, kWall_mm = 4, kInside_pa = 2e3, kInside_mm = 30;
    constexpr double kDecay_s = 0.005, kStep_s = 0.25e-3;
    const double node_mm2 = 0.5 * std::sqrt(3.0) * kEdge_mm * kEdge_mm;
    const double mass = node_mm2 * kWall_mm * 1e-3;
    SpringParts parts =
        value_of(springs_of_triangles(net.nodes, net.triangles,
                                      {.stiffness = 0.5 * std::sqrt(3.0) * kWall_pa * kWall_mm,
                                       .node_damping = mass / kDecay_s,
                                       .node_mass = mass}));
    const auto count = std::int32_t(net.nodes.size());
    for (std::int32_t n = 0; n < count; ++n) {
        const int i = n % kNet, j = n / kNet;
        if (std::min({i, j, kNet - 1 - i, kNet - 1 - j}) == 0)
            parts.nodes[std::size_t(n)].fixed = true;
        parts.nodes.push_back({.rest = net.nodes[std::size_t(n)], .fixed = true});
        parts.links.push_back({.a = n,
                               .b = count + n,
                               .stiffness = kInside_pa * node_mm2 / kInside_mm,
                               .rest_length = 0});
    }
    return value_of(SpringTissue::create(value_of(SpringNetwork::create(std::move(parts))),
                                         {.depth = kLayers, .time_step = kStep_s}));
}

struct Pressed {
    double depth_mm = 0;
    double off_mm = 0;                  ///< of the point from its triangle
    std::array<double, 3> vertex_mn{};  ///< force of each vertex, along z
    double force_mn = 0;                ///< Eq. 19, along z
    double energy_uj = 0;
};

/// Parallel view from the side and above, with the force at each vertex of the pressed triangle and
/// their sum at the point.
Image view_of(const Net& net, const SpringTissue& tissue, Vec3d tip, const Pressed& now) {
    constexpr int kWidth = 600, kHeight = 330;
    constexpr double kHalf_mm = 40, kMm_mn = 0.25;  // of an arrow
    const double mm = 2 * kHalf_mm / kWidth;
    Plot plot(kWidth, kHeight, {-kHalf_mm, 0.62 * kHeight * mm}, {kHalf_mm, -0.38 * kHeight * mm});
    const auto away = [](Vec3d p) { return 0.94 * p.y - 0.34 * p.x; };
    const auto flat = [&](Vec3d p) {
        return Point2{0.94 * p.x + 0.34 * p.y, 0.4 * away(p) + 0.92 * p.z};
    };
    const auto place = [&](std::int32_t n) { return flat(tissue.position(n)); };
    std::vector<std::array<std::int32_t, 3>> sorted = net.triangles;
    std::stable_sort(sorted.begin(), sorted.end(), [&](const auto& a, const auto& b) {
        return away(net.nodes[std::size_t(a[0])]) > away(net.nodes[std::size_t(b[0])]);
    });
    for (const auto& nodes : sorted) {
        const std::array<Point2, 3> corners{place(nodes[0]), place(nodes[1]), place(nodes[2])};
        double moved_mm = 0;
        for (const std::int32_t n : nodes) moved_mm += norm(tissue.displacement(n)) / 3;
        plot.polygon(corners, shade_of(moved_mm / kDeepest_mm));
        plot.polyline(corners, {kDark, 1, 0.3}, true);
    }
    const auto& pressed = net.triangles[std::size_t(net.pressed)];
    const std::array<Point2, 3> corners{place(pressed[0]), place(pressed[1]), place(pressed[2])};
    plot.polyline(corners, {kOrange, 2.5}, true);
    for (std::size_t k = 0; k < 3; ++k) {
        const Vec3d foot = tissue.position(pressed[k]);
        plot.arrow(flat(foot), flat(foot + Vec3d{0, 0, kMm_mn * now.vertex_mn[k]}), {kRed, 2});
    }
    plot.arrow(flat(tip), flat(tip + Vec3d{0, 0, kMm_mn * now.force_mn}), {kBlue, 3});
    plot.dot(flat(tip), 4, kOrange);
    plot.scale_bar(10, "10 mm");
    const LegendEntry entries[] = {{"pressed triangle and HIP", {kOrange, 2.5}},
                                   {"force at a vertex", {kRed, 2}},
                                   {"their sum, Eq. 19", {kBlue, 3}}};
    const Image parts[] = {
        captioned(plot.image(), "pressed by " + fixed_text(now.depth_mm, 0) +
                                    " mm; a force of 40 mN is an arrow of 10 mm"),
        shade_bar(kDeepest_mm, 0, "displacement [mm]"), legend_of(entries, kWidth)};
    return column_of(parts, 2);
}

Pressed measure(SpringTissue& tissue, const SpringProbe& probe, double depth_mm) {
    must(tissue.find_equilibrium(1e-9));
    Pressed now{.depth_mm = depth_mm, .off_mm = probe.clearance(tissue, 1)};
    const auto up_mn = [&](std::span<const std::int32_t> nodes) {
        return 1e-3 * value_of(tissue.reaction(nodes, ReactionLaw::Held)).force.z;
    };
    const auto nodes = probe.nodes();
    if (nodes.size() != 3) must(Error{ErrorCode::Unsupported, "expected a point on one triangle"});
    for (std::size_t k = 0; k < 3; ++k) now.vertex_mn[k] = up_mn(nodes.subspan(k, 1));
    now.force_mn = up_mn(nodes);
    now.energy_uj = 1e-3 * tissue.elastic_energy();  // from µN mm
    return now;
}

}  // namespace

void add_touch_point(Page& page, const TaskArena& arena) {
    page.heading(2, "Figure 8: a point against a net of triangles");
    const Net net = flat_net();
    SpringTissue tissue = tissue_of(net);
    SpringProbe probe = value_of(SpringProbe::create(tissue.network(), net.triangles));
    Vec3d middle{0, 0, 0};
    for (const std::int32_t n : net.triangles[std::size_t(net.pressed)])
        middle = middle + (1.0 / 3) * net.nodes[std::size_t(n)];
    must(probe.place(tissue, middle + Vec3d{0, 0, 1}));
    std::vector<Pressed> all;
    Image picture;
    for (int n = 1; n * kDepthStep_mm <= kDeepest_mm; ++n) {
        const double depth = n * kDepthStep_mm;
        const Vec3d tip = middle - Vec3d{0, 0, depth};
        value_of(probe.move(tissue, tip, 4, arena));
        all.push_back(measure(tissue, probe, depth));
        if (depth == 4) picture = view_of(net, tissue, tip, all.back());
    }
    std::vector<Point2> felt{{0, 0}}, slopes;
    std::vector<std::vector<std::string>> rows;
    double apart = 0;
    for (std::size_t n = 0; n < all.size(); ++n) {
        const Pressed& p = all[n];
        felt.push_back({p.depth_mm, p.force_mn});
        if (n == 0 || n + 1 == all.size()) continue;
        // Central difference, in µJ/mm = mN.
        const double slope = (all[n + 1].energy_uj - all[n - 1].energy_uj) / (2 * kDepthStep_mm);
        slopes.push_back({p.depth_mm, slope});
        if (p.depth_mm >= 1) apart = std::max(apart, std::abs(slope / p.force_mn - 1));
        if (p.depth_mm != std::round(p.depth_mm)) continue;
        rows.push_back({fixed_text(p.depth_mm, 0), fixed_text(1000 * std::abs(p.off_mm), 3),
                        fixed_text(p.vertex_mn[0], 2) + " + " + fixed_text(p.vertex_mn[1], 2) +
                            " + " + fixed_text(p.vertex_mn[2], 2),
                        fixed_text(p.force_mn, 2), fixed_text(slope, 2)});
    }
    if (!(apart < 0.02))
        must(Error{ErrorCode::Unsupported, "expected the derivative of the energy as the force"});
    page.paragraph(
        "The figure is a sketch: the point of the device, the haptic interface point (HIP), hits a "
        "triangle, which is translated by the point's penetration; force transmittal begins at its "
        "three vertices, and the reaction is the sum of the spring forces at them (Eq. 19). Here: "
        "a flat net of " +
        std::to_string(kNet) + " × " + std::to_string(kNet) +
        " nodes with edges of 6 mm, its border fixed, with the wall and the elastic layer of the "
        "stomach of Figure 15; the point of a `SpringProbe` is pressed into the middle of a "
        "triangle, and all nodes come to rest. The point stays on its triangle. At equilibrium the "
        "force along the way is the derivative of the energy; its central difference over 0.25 mm "
        "agrees with Eq. 19 to " +
        fixed_text(100 * apart, 2) + " % from 1 mm on.");
    const double most = felt.back().y, step = most > 100 ? 50 : most > 40 ? 20 : most > 20 ? 10 : 5;
    Chart chart(440, 360, {"depth of the point [mm]", 0, kDeepest_mm, 1},
                {"force [mN]", 0, step * std::ceil(most / step), step});
    chart.curve(felt, {kBlue, 2}, "sum over the vertices, Eq. 19");
    chart.dots(slopes, {kDark, 2.5}, "derivative of the energy");
    const Image both[] = {picture, chart.image()};
    page.picture("choi-8-point", "a point that presses a net of triangles, and its force",
                 row_of(both));
    page.table(
        {"depth of the point [mm]", "point off its triangle [µm]", "forces at the vertices [mN]",
         "their sum, Eq. 19 [mN]", "derivative of the energy [mN]"},
        rows);
}

}  // namespace pliant::results
