// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// [Choi2004, 2.1 and 2.2]: the models of Figure 1 under a constant strain; a bar of crimped fibres.

#include <pliant/models/springs.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "chart.h"
#include "crimp.h"
#include "figures.h"

namespace pliant::results {
namespace {

struct Model {
    const char* name;
    double stiffness, damping, branch;
};
constexpr double kBranchTime = 20, kStep = 0.05;
constexpr std::array<Model, 3> kModels{{{"Voigt: k 1, damping 0.5", 1, 0.5, 0},
                                        {"Kelvin: k 0.5, branch 0.5", 0.5, 0, 0.5},
                                        {"Maxwell: branch 1", 0, 0, 1}}};

SpringTissue bar_of(const Model& model) {
    auto parts = value_of(springs_of_lattice({.size = {5, 5, kLayers}, .node_damping = 1}));
    for (SpringNode& node : parts.nodes) node.fixed = node.rest.z == 0;
    for (SpringLink& link : parts.links) {
        link.stiffness = model.stiffness;
        link.damping = model.damping;
        link.branch_stiffness = model.branch;
        link.branch_time = kBranchTime;
    }
    return value_of(SpringTissue::create(value_of(SpringNetwork::create(std::move(parts))),
                                         {.depth = 20, .time_step = kStep}));
}

/// A bar of elastic links, held at a strain, at its equilibrium.
SpringTissue stretched_bar(double stiffness, double strain) {
    SpringTissue bar = bar_of({"", stiffness, 0, 0});
    const auto top = top_nodes();
    must(bar.hold(top));
    must(bar.shift_held({0, 0, strain * (kLayers - 1)}));
    must(bar.find_equilibrium());
    return bar;
}

double force_on_top(SpringTissue& bar) {
    return -value_of(bar.reaction(top_nodes(), ReactionLaw::Held)).force.z;
}

/// Force on the top at every unit of time, after a sudden change to the shape of another bar.
std::vector<Point2> relaxation_of(const Model& model, const SpringTissue& shape, double end,
                                  const TaskArena& arena) {
    SpringTissue bar = bar_of(model);
    const auto top = top_nodes();
    must(bar.hold(top));
    std::vector<Vec3d> held;
    for (const std::int32_t n : top) held.push_back(shape.position(n));
    for (std::int32_t n = kLayer; n < top[0]; ++n) must(bar.set_state(n, shape.position(n), {}));
    must(bar.move_held(held));
    std::vector<Point2> points;
    for (double t = 0; t <= end; ++t) {
        points.push_back({t, force_on_top(bar)});
        value_of(bar.step(int(1 / kStep), arena));
    }
    return points;
}

}  // namespace

void add_relaxation(Page& page, const TaskArena& arena) {
    constexpr double kStrain = 0.05, kEnd = 100;
    page.heading(3, "Stress relaxation");
    page.paragraph(
        "The third of the phenomena that [Choi2004, 2.1] names, with the three models of its "
        "Figure 1. The paper uses Voigt links only; Maxwell and Kelvin links have a spring and a "
        "dashpot in series, here with a time constant of 20. The same bar gets the shape of an "
        "elastic bar at a strain of 0.05 at time 0, and its ends are held; force on its top, "
        "relative to that of the elastic bar. The closed form is (k + k' e^(−t/τ))/(k + k'); all "
        "links have the same ratio and time, so it holds for the bar too.");
    Chart chart(760, 400, {"time [units of sqrt(m/k)]", 0, kEnd, 20},
                {"force on the top [fraction of the first]", 0, 1.2, 0.2, 1});
    const std::array<Rgb8, 3> colours{kDark, kGreen, kOrange};
    std::vector<std::vector<std::string>> rows;
    SpringTissue elastic = stretched_bar(1, kStrain);
    const double first = force_on_top(elastic);
    for (std::size_t m = 0; m < kModels.size(); ++m) {
        const Model& model = kModels[m];
        auto points = relaxation_of(model, elastic, kEnd, arena);
        std::vector<std::string> row{model.name};
        double apart = 0;
        for (Point2& point : points) {
            const double expected =
                model.stiffness + model.branch * std::exp(-point.x / kBranchTime);
            point.y /= first;
            apart = std::max(apart, std::abs(point.y - expected));
            if (point.x == 20 || point.x == 40 || point.x == 100)
                row.push_back(fixed_text(point.y, 4) + " (" + fixed_text(expected, 4) + ")");
        }
        if (!(apart < 0.002))
            must(Error{ErrorCode::Unsupported, "expected a force that relaxes as in closed form"});
        row.push_back(fixed_text(100 * apart, 2));
        chart.curve(points, {colours[m], 2, 1}, model.name);
        rows.push_back(row);
    }
    page.picture("choi-2.1-relaxation", "force against time at a constant strain", chart.image());
    page.table(
        {"links", "at 20 (closed form)", "at 40", "at 100", "largest difference [% of the first]"},
        rows);
}

void add_crimp(Page& page, const TaskArena& arena) {
    page.heading(3, "A load curve that bends as that of tissue");
    page.paragraph(
        "Tissue is soft in its toe region and stiffens as its wavy collagen fibres become "
        "straight. "
        "The figure of the paper shows such a bend, and its links are linear, so it must come from "
        "geometry. The set-up here is ours: the same bar with links along its axis of stiffness 2, "
        "all others of 0.05, and every second layer shifted sideways, so that the stiff fibres are "
        "wavy at rest. They are straight at a strain of √(1 + shift²) − 1: 0, 0.25 and 0.80 for "
        "shifts of 0, 0.75 and 1.5. Equilibria (lines), and for a shift of 1.5 a force that grows "
        "at a constant rate of 0.01 with a node damping of 2 (dark).");
    constexpr double kMost = 40, kStrain = 1.6;
    Chart chart(760, 440, {"strain [fraction of the bar's length]", 0, kStrain, 0.2, 1},
                {"force [units of k times spacing]", 0, kMost, 5});
    const std::array<Rgb8, 3> colours{kBlue, kGreen, kOrange};
    std::vector<std::vector<std::string>> rows;
    const std::array<double, 3> shifts{0, 0.75, 1.5};
    for (std::size_t n = 0; n < shifts.size(); ++n) {
        SpringTissue bar = value_of(crimped_bar(shifts[n]));
        const auto curve = value_of(load_curve(bar, kMost));
        std::vector<Point2> points;
        for (const LoadPoint& point : curve) points.push_back({point.strain, point.force});
        const double first = slope_at(curve, 0), last = slope_at(curve, curve.size() - 2);
        if (n == 2 && !(last > 3 * first))
            must(Error{ErrorCode::Unsupported, "expected a curve that bends upwards"});
        chart.curve(points, {colours[n], 2, 1}, "shift " + fixed_text(shifts[n], 2));
        rows.push_back({fixed_text(shifts[n], 2),
                        fixed_text(std::sqrt(1 + shifts[n] * shifts[n]) - 1, 2),
                        fixed_text(first, 1), fixed_text(last, 1), fixed_text(last / first, 1)});
    }
    SpringTissue bar = value_of(crimped_bar(shifts[2]));
    std::vector<Point2> points{{0, 0}};
    for (int s = 1; points.back().y < kMost; ++s) {
        must(draw(bar, 0.001 * s));
        value_of(bar.step(1, arena));
        if (s % 250 == 0) points.push_back({strain_of(bar), 0.001 * s});
    }
    chart.curve(points, {kDark, 2, 1}, "shift 1.50, force that grows");
    page.picture("choi-11c-crimp", "force against strain for wavy fibres", chart.image());
    page.table({"shift", "strain of straight fibres", "first slope", "last slope", "ratio"}, rows);
}

}  // namespace pliant::results
