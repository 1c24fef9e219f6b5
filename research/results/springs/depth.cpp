// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// [Choi2004, 4.1.1]: profiles for depths of penetration, and the optimum depth for three
// stiffnesses, at the equilibrium and after a given time.

#include <pliant/models/springs.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "chart.h"
#include "figures.h"

namespace pliant::results {
namespace {

constexpr int kSide = 25, kDeep = 13, kMiddle = kSide / 2;
constexpr std::int32_t kTop = kSide * kSide * (kDeep - 1);
constexpr std::int32_t kPressed = kMiddle + kSide * kMiddle + kTop;

/// The bottom is fixed; edges and face diagonals, spacing and masses 1.
SpringNetwork lattice(double stiffness, double damping) {
    auto parts = value_of(springs_of_lattice({.size = {kSide, kSide, kDeep},
                                              .stiffness = {stiffness, stiffness, stiffness},
                                              .node_damping = damping}));
    for (SpringNode& node : parts.nodes) node.fixed = node.rest.z == 0;
    return value_of(SpringNetwork::create(std::move(parts)));
}

/// Displacement of the row through the pressed node, at the equilibrium of a depth.
std::vector<Point2> profile(const SpringNetwork& network, double force, int depth) {
    SpringTissue tissue = value_of(SpringTissue::create(network, {.depth = depth}));
    must(tissue.load(std::array{kPressed}, std::array{Vec3d{0, 0, -force}}));
    must(tissue.find_equilibrium());
    std::vector<Point2> points;
    for (int i = 0; i < kSide; ++i) {
        const Vec3d u = tissue.displacement(i + kSide * kMiddle + kTop);
        points.push_back({i - kMiddle + u.x, u.z});
    }
    return points;
}

std::vector<double> changes(const SpringNetwork& network, double force, double duration,
                            const TaskArena& arena) {
    return value_of(find_depth(network, {}, std::array{kPressed}, std::array{Vec3d{0, 0, -force}},
                               {.threshold = 1e-12, .max_depth = 10, .duration = duration}, arena))
        .changes;
}

/// As in find_depth: the first depth from which one more layer changes less. 0: none.
int depth_of(const std::vector<double>& changes, double threshold) {
    for (std::size_t n = 0; n < changes.size(); ++n)
        if (changes[n] < threshold) return int(n) + 1;
    return 0;
}

void add_figure_9(Page& page) {
    page.heading(2, "Figure 9: profiles for several depths");
    page.paragraph(
        "The paper presses a node on the top of a lattice, lets forces go 2, 4 and 8 layers deep, "
        "and sees no change beyond four. Here: " +
        std::to_string(kSide) + " × " + std::to_string(kSide) + " × " + std::to_string(kDeep) +
        " nodes, edges and face diagonals, k = 2, spacing 1, held at its foot; a force of 1.5 on "
        "the middle of the top; equilibrium of the nodes that each depth reaches. Curves are the "
        "profile through the pressed node for 2 layers (orange), 4 (green), 8 (blue) and 12 "
        "(dark), in spacings.");
    const SpringNetwork network = lattice(2, 0);
    Chart chart(760, 440, {"along the top, from the pressed node [spacings]", -12, 12, 3},
                {"profile [spacings]", -0.5, 0.1, 0.1, 1});
    std::vector<std::vector<std::string>> rows;
    double last = 0;
    for (int depth = 1; depth <= 12; ++depth) {
        const std::vector<Point2> points = profile(network, 1.5, depth);
        const double dip = -points[kMiddle].y;
        rows.push_back({std::to_string(depth), fixed_text(dip, 4),
                        depth == 1 ? "" : fixed_text(100 * (dip - last) / dip, 2)});
        last = dip;
        if (depth == 2) chart.curve(points, {kOrange, 2, 1}, "2 layers");
        if (depth == 4) chart.curve(points, {kGreen, 2, 1}, "4");
        if (depth == 8) chart.curve(points, {kBlue, 2, 1}, "8");
        if (depth == 12) chart.curve(points, {kDark, 1.2, 1}, "12");
    }
    page.picture("choi-9-depth", "profiles of a pressed lattice for 2, 4, 8 and 12 layers",
                 chart.image());
    page.table({"layers", "dip [spacings]", "more than with one layer fewer [%]"}, rows);
    page.paragraph(
        "It agrees in what the eye sees: the step from 2 layers to 4 shows, the one from 4 to 8 "
        "hardly does at the pressed node. But a surface goes down as 1/r [Boussinesq1885], so each "
        "layer still adds something, and the dip's wide rim is cut off: at 4 layers everything "
        "beyond four spacings stands still.");
}

/// Thresholds that give 4, 6 and 8, if they exist.
std::string thresholds_for_the_paper(const std::array<std::vector<double>, 3>& changes) {
    const int wanted[] = {4, 6, 8};
    double low = 0, high = 1e9;
    for (int n = 0; n < 3; ++n) {
        const auto& c = changes[std::size_t(n)];
        const auto at = std::size_t(wanted[n]);
        if (c.size() < at) return "none";
        low = std::max(low, c[at - 1]);
        high = std::min(high, *std::min_element(c.begin(), c.begin() + std::ptrdiff_t(at) - 1));
    }
    return low < high ? fixed_text(1e4 * low, 2) + "–" + fixed_text(1e4 * high, 2) + " · 10⁻⁴"
                      : "none";
}

void add_figure_10(Page& page, const TaskArena& arena) {
    constexpr double kForce = 0.5, kDamping = 8;
    const double stiffnesses[] = {0.5, 2.0, 5.0};
    page.heading(2, "Figure 10: the optimum depth for three stiffnesses");
    page.paragraph(
        "The paper finds 4, 6 and 8 layers for k = 0.5, 2 and 5 under the same force, and "
        "concludes "
        "that a stiffer lattice needs a greater depth. It explains this by a hard object being "
        "deformed in a very localised region only, so that a *small* depth would do: **the "
        "explanation contradicts the figure.** The same lattice as above, a force of 0.5; profiles "
        "at equilibrium with 10 layers for k = 0.5 (orange), 2 (green) and 5 (blue).");
    Chart chart(760, 400, {"along the top, from the pressed node [spacings]", -12, 12, 3},
                {"profile [spacings]", -0.6, 0.1, 0.1, 1});
    const Rgb8 colours[] = {kOrange, kGreen, kBlue};
    for (int n = 0; n < 3; ++n)
        chart.curve(profile(lattice(stiffnesses[n], 0), kForce, 10), {colours[n], 2, 1},
                    "k = " + fixed_text(stiffnesses[n], 1));
    page.picture("choi-10-stiffness", "profiles for three stiffnesses", chart.image());
    page.paragraph(
        "**At equilibrium** the explanation is right and the figure can't be had. In the linear "
        "range all displacements scale with 1/k, so an absolute threshold asks for fewer layers of "
        "a stiffer lattice, and one relative to the dip for nearly the same number. Largest change "
        "of a "
        "node's position by one layer more, and the depth at which it falls below a threshold:");
    std::vector<std::vector<std::string>> rows;
    for (const double k : stiffnesses) {
        const auto c = changes(lattice(k, 0), kForce, 0, arena);
        rows.push_back({fixed_text(k, 1), fixed_text(c[1], 4), fixed_text(c[3], 4),
                        fixed_text(c[5], 4), fixed_text(c[7], 4),
                        std::to_string(depth_of(c, 0.004)),
                        std::to_string(depth_of(c, 0.003 / k))});
    }
    page.table({"k", "2 → 3", "4 → 5", "6 → 7", "8 → 9", "threshold 0.004", "threshold 0.003/k"},
               rows);
    page.paragraph(
        "**After a fixed time** it can. Forces that are switched on travel farther in the same "
        "time where springs are stiffer. With masses of 1, node damping of 8 (which is more than "
        "critical) and runs that stop after a given time, this is the range of thresholds (in "
        "spacings) for which find_depth gives exactly 4, 6 and 8:");
    rows.clear();
    for (const double duration : {2.0, 4.0, 6.0, 8.0, 12.0, 16.0, 32.0}) {
        std::array<std::vector<double>, 3> all;
        for (std::size_t n = 0; n < 3; ++n)
            all[n] = changes(lattice(stiffnesses[n], kDamping), kForce, duration, arena);
        const auto depths = [&](double threshold) {
            std::string text;
            for (const auto& c : all) {
                const int depth = depth_of(c, threshold);
                text += (text.empty() ? "" : ", ") + (depth ? std::to_string(depth) : "> 10");
            }
            return text;
        };
        rows.push_back(
            {fixed_text(duration, 0), thresholds_for_the_paper(all), depths(7e-5), depths(1e-3)});
    }
    page.table({"time", "thresholds for 4, 6, 8", "depths at 0.7 · 10⁻⁴", "depths at 10⁻³"}, rows);
    page.paragraph(
        "So the paper's numbers can be those of runs that were stopped on their way, and then "
        "measure how far the force had come. It names neither time, damping nor threshold.");
}

}  // namespace

void add_depth(Page& page, const TaskArena& arena) {
    add_figure_9(page);
    add_figure_10(page, arena);
}

}  // namespace pliant::results
