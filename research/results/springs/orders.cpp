// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// [Choi2004, 3.1.4]: how far motions differ between the orders in which nodes are updated.

#include <pliant/research/springs.h>

#include <algorithm>
#include <array>
#include <utility>
#include <vector>

#include "chart.h"
#include "figures.h"

namespace pliant::results {
namespace {

constexpr Vec3i kSize{25, 25, 13};
constexpr std::int32_t kMiddle = 12 + 25 * (12 + 25 * 12), kDepth = 8;
constexpr double kEnd = 48;

/// The lattice of Figures 9 and 10, with damped nodes.
/// @param backwards  node n has the number N − 1 − n, which reverses the order in each layer
SpringNetwork lattice(bool backwards) {
    auto parts =
        value_of(springs_of_lattice({.size = kSize, .stiffness = {2, 2, 2}, .node_damping = 8}));
    for (SpringNode& node : parts.nodes) node.fixed = node.rest.z == 0;
    if (backwards) {
        std::reverse(parts.nodes.begin(), parts.nodes.end());
        const auto last = std::int32_t(parts.nodes.size()) - 1;
        for (SpringLink& link : parts.links) {
            link.a = last - link.a;
            link.b = last - link.b;
        }
        for (SpringCell& cell : parts.cells)
            for (std::int32_t& node : cell.nodes) node = last - node;
    }
    return value_of(SpringNetwork::create(std::move(parts)));
}

struct Reading {
    const char* name;
    SeenPositions seen;
    bool backwards;
};
constexpr std::array<Reading, 4> kReadings{
    {{"old positions", SeenPositions::Old, false},
     {"new in earlier layers", SeenPositions::NewLayers, false},
     {"new for all earlier nodes", SeenPositions::NewNodes, false},
     {"the same, nodes numbered backwards", SeenPositions::NewNodes, true}}};

/// Displacements of all nodes over time, in the numbering of the lattice.
std::vector<std::vector<Vec3d>> motion_of(const Reading& reading, double step) {
    SpringNetwork network = lattice(reading.backwards);
    const std::int32_t last = network.node_count() - 1;
    const std::array source{reading.backwards ? last - kMiddle : kMiddle};
    OrderedTransmittal tissue = value_of(
        OrderedTransmittal::create(std::move(network), source, kDepth, reading.seen, step));
    tissue.load(source[0], {0, 0, -1.5});
    std::vector<std::vector<Vec3d>> motion;
    for (double t = 0; t < kEnd; t += step) {
        tissue.step(1);
        motion.push_back(tissue.displacements());
        if (reading.backwards) std::reverse(motion.back().begin(), motion.back().end());
    }
    return motion;
}

double largest_difference(const std::vector<Vec3d>& a, const std::vector<Vec3d>& b) {
    double largest = 0;
    for (std::size_t n = 0; n < a.size(); ++n) largest = std::max(largest, norm(a[n] - b[n]));
    return largest;
}

}  // namespace

void add_orders(Page& page) {
    page.heading(2, "The order of updates");
    page.paragraph(
        "[Choi2004, 3.1.4] says that the order of nodes in a layer hardly matters, and doesn't say "
        "whether a node sees the old or the new positions of those before it. The lattice of "
        "Figure 9, masses 1, node damping 8, a force of 1.5 on the middle of the top from time 0 "
        "on, 8 layers, until a time of 48. The largest distance between the same node of two "
        "motions, at any time, in percent of the pressed node's displacement at the end:");
    std::vector<std::vector<std::string>> rows;
    Chart chart(760, 400, {"time [units of sqrt(m/k)]", 0, kEnd, 6},
                {"largest distance of a node [% of the dip]", 0, 1, 0.2, 1});
    const std::array<Rgb8, 3> colours{kOrange, kGreen, kBlue};
    for (const double step : {0.3, 0.15, 0.075}) {
        std::vector<std::vector<std::vector<Vec3d>>> motions;
        for (const Reading& reading : kReadings) motions.push_back(motion_of(reading, step));
        const double dip = norm(motions[0].back()[kMiddle]);
        std::vector<std::string> row{fixed_text(step, 3), fixed_text(dip, 4)};
        const std::array<std::array<std::size_t, 2>, 3> pairs{{{0, 1}, {0, 2}, {2, 3}}};
        const std::array<const char*, 3> names{"old, new in earlier layers",
                                               "old, new for all earlier nodes",
                                               "new for all, numbered backwards"};
        for (std::size_t p = 0; p < 3; ++p) {
            std::vector<Point2> points{{0, 0}};
            double largest = 0;
            for (std::size_t s = 0; s < motions[0].size(); ++s) {
                const double share =
                    100 / dip *
                    largest_difference(motions[pairs[p][0]][s], motions[pairs[p][1]][s]);
                points.push_back({step * double(s + 1), share});
                largest = std::max(largest, share);
            }
            row.push_back(fixed_text(largest, 3));
            row.push_back(fixed_text(points.back().y, 4));
            if (step == 0.15) chart.curve(points, {colours[p], 2, 1}, names[p]);
        }
        rows.push_back(row);
    }
    page.table({"time step", "dip at the end", "old and new in earlier layers: largest [%]",
                "at the end", "old and new for all earlier nodes: largest", "at the end",
                "new for all, forwards and backwards: largest", "at the end"},
               rows);
    page.picture("choi-orders", "largest distance of a node between two orders, against time",
                 chart.image());
    page.paragraph(
        "Curves are for a step of 0.15. The order in a layer matters least, as the paper says; it "
        "changes nothing for old positions and for new ones in earlier layers. The differences "
        "shrink with the time step and towards the equilibrium, which is the same for all.");
}

}  // namespace pliant::results
