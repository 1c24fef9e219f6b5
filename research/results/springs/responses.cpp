// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// [Choi2004, 4.1.2 and 4.1.3]: a bar of springs under a constant, a periodic and a growing force; a
// block with one stiff axis.

#include <pliant/models/springs.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "chart.h"
#include "figures.h"

namespace pliant::results {
namespace {

constexpr std::array kDampings{2.0, 4.0, 8.0};
const std::array<Rgb8, 3> kColours{kOrange, kGreen, kBlue};

std::string damping_text(std::size_t n) {
    return "damping " + fixed_text(kDampings[n], 0);
}

/// 5 × 5 × 9 nodes, k = 1, spacing and masses 1; the bottom is fixed, the top is loaded.
class Bar {
  public:
    explicit Bar(double damping) : m_tissue(make(damping)) {
        for (std::int32_t n = 0; n < 25; ++n) m_top.push_back(n + 25 * 8);
    }
    void draw(double force) {
        must(m_tissue.load(m_top, std::vector<Vec3d>(m_top.size(), {0, 0, force / 25})));
    }
    double strain() const {
        double sum = 0;
        for (const std::int32_t n : m_top) sum += m_tissue.displacement(n).z;
        return sum / (25 * 8);
    }
    SpringTissue& tissue() { return m_tissue; }

  private:
    static SpringTissue make(double damping) {
        auto parts = value_of(springs_of_lattice({.size = {5, 5, 9}, .node_damping = damping}));
        for (SpringNode& node : parts.nodes) node.fixed = node.rest.z == 0;
        return value_of(SpringTissue::create(value_of(SpringNetwork::create(std::move(parts))),
                                             {.depth = 20, .time_step = 0.1}));
    }
    SpringTissue m_tissue;
    std::vector<std::int32_t> m_top;
};

double equilibrium_strain(double force) {
    Bar bar(1);
    bar.draw(force);
    must(bar.tissue().find_equilibrium());
    return bar.strain();
}

void add_creep(Page& page, const TaskArena& arena) {
    constexpr double kForce = 12, kEnd = 200;
    page.heading(3, "Figure 11 a: creep");
    page.paragraph(
        "A constant force of 12 from time 0 on; strain against time. In the paper the least "
        "viscous "
        "material has the highest rate, and all approach one strain: so here. The time in which "
        "63 % of it is reached is, but for inertia, proportional to the damping, as that of a "
        "Voigt link is (ε = F/k · (1 − e^(−kt/d)), which the tests of the room hold to 1 %).");
    const double last = equilibrium_strain(kForce);
    Chart chart(760, 400, {"time [units of sqrt(m/k)]", 0, kEnd, 25},
                {"strain [fraction of the bar's length]", 0, 0.25, 0.05, 2});
    std::vector<std::vector<std::string>> rows;
    for (std::size_t n = 0; n < 3; ++n) {
        Bar bar(kDampings[n]);
        bar.draw(kForce);
        std::vector<Point2> points{{0, 0}};
        double reached = 0;
        for (int t = 1; t <= int(kEnd); ++t) {
            value_of(bar.tissue().step(10, arena));
            points.push_back({double(t), bar.strain()});
            if (reached == 0 && bar.strain() >= (1 - std::exp(-1)) * last) reached = t;
        }
        chart.curve(points, {kColours[n], 2, 1}, damping_text(n));
        rows.push_back({fixed_text(kDampings[n], 1), fixed_text(reached, 0),
                        fixed_text(reached / kDampings[n], 0), fixed_text(bar.strain(), 4),
                        fixed_text(last, 4)});
    }
    page.picture("choi-11a-creep", "strain against time for three dampings", chart.image());
    page.table({"damping", "time to 63 %", "the same / damping", "strain at 200", "at equilibrium"},
               rows);
}

void add_hysteresis(Page& page, const TaskArena& arena) {
    constexpr double kMost = 12;
    constexpr int kSteps = 4000;  // up, and as many down
    page.heading(3, "Figure 11 b: hysteresis");
    page.paragraph(
        "The force grows at a constant rate to 12 in a time of 400, and falls back to 0 in the "
        "same. Force to the right, strain upwards. As in the paper, the way back is another one, "
        "and the loop is wider for greater damping.");
    Chart chart(760, 400, {"force [units of k times spacing]", 0, kMost, 2},
                {"strain [fraction of the bar's length]", 0, 0.25, 0.05, 2});
    std::vector<std::vector<std::string>> rows;
    for (std::size_t n = 0; n < 3; ++n) {
        Bar bar(kDampings[n]);
        std::vector<Point2> points{{0, 0}};
        for (int s = 1; s <= 2 * kSteps; ++s) {
            const double force = kMost * (s <= kSteps ? s : 2 * kSteps - s) / kSteps;
            bar.draw(force);
            value_of(bar.tissue().step(1, arena));
            if (s % 40 == 0) points.push_back({force, bar.strain()});
        }
        double area = 0, most = 0;
        for (std::size_t p = 1; p < points.size(); ++p) {
            area += 0.5 * (points[p].x + points[p - 1].x) * (points[p].y - points[p - 1].y);
            most = std::max(most, points[p].y);
        }
        chart.curve(points, {kColours[n], 2, 1}, damping_text(n));
        // Area of the loop; the remaining strain at zero force closes it.
        rows.push_back({fixed_text(kDampings[n], 1), fixed_text(area, 3), fixed_text(most, 3),
                        fixed_text(points.back().y, 3)});
    }
    page.picture("choi-11b-hysteresis", "strain against force, up and down", chart.image());
    page.table({"damping", "area of the loop", "largest strain", "strain left at the end"}, rows);
}

void add_load_curve(Page& page, const TaskArena& arena) {
    constexpr double kRate = 2;
    page.heading(3, "Figure 11 c: the load curve");
    page.paragraph(
        "The force grows at a constant rate of 2; strain to the right, up to the paper's 2.5, "
        "force upwards. The paper shows a curve that isn't straight. Here there are two reasons "
        "for one. At equilibrium (dark) each spring is linear, but diagonals turn into the "
        "direction of the force and begin to bear it: the bar stiffens. And in a given time "
        "(colours) the strain stays behind the force, the more the greater the damping.");
    Chart chart(760, 440, {"strain [fraction of the bar's length]", 0, 2.5, 0.5, 1},
                {"force [units of k times spacing]", 0, 300, 50});
    std::vector<Point2> rest{{0, 0}};
    Bar slow(1);
    for (double force = 2; force <= 300; force += 2) {
        slow.draw(force);
        must(slow.tissue().find_equilibrium());
        if (slow.strain() > 2.5) break;
        rest.push_back({slow.strain(), force});
    }
    chart.curve(rest, {kDark, 2, 1}, "at equilibrium");
    std::vector<std::vector<std::string>> rows;
    for (const double strain : {0.25, 0.5, 1.0, 1.5, 2.0}) {
        const auto above =
            std::find_if(rest.begin(), rest.end(), [&](Point2 p) { return p.x >= strain; });
        if (above == rest.begin() || above == rest.end()) continue;
        const Point2 a = above[-1], b = above[0];
        rows.push_back({fixed_text(strain, 2),
                        fixed_text(a.y + (strain - a.x) / (b.x - a.x) * (b.y - a.y), 2),
                        fixed_text((b.y - a.y) / (b.x - a.x), 2)});
    }
    for (std::size_t n = 0; n < 3; ++n) {
        Bar bar(kDampings[n]);
        std::vector<Point2> points{{0, 0}};
        for (int s = 1; points.back().x < 2.5 && points.back().y < 300; ++s) {
            const double force = kRate * 0.1 * s;
            bar.draw(force);
            value_of(bar.tissue().step(1, arena));
            if (s % 10 == 0) points.push_back({std::min(2.5, bar.strain()), force});
        }
        chart.curve(points, {kColours[n], 2, 1}, "running, " + damping_text(n));
    }
    page.picture("choi-11c-load", "force against strain", chart.image());
    page.table({"strain", "force at equilibrium", "slope there"}, rows);
}

/// Profile along the pressed face, from the middle; pressed along z on the top or along x on a
/// side.
std::vector<Point2> profile(Vec3d stiffness, bool down) {
    constexpr int kSide = 11, kMiddle = 5;
    auto parts =
        value_of(springs_of_lattice({.size = {kSide, kSide, kSide}, .stiffness = stiffness}));
    for (SpringNode& node : parts.nodes) node.fixed = node.rest.z == 0 || node.rest.x == kSide - 1;
    SpringTissue tissue = value_of(SpringTissue::create(
        value_of(SpringNetwork::create(std::move(parts))), {.solver = SpringSolver::Explicit}));
    const auto node = [&](int s) {
        const int i = down ? s : 0, k = down ? kSide - 1 : kSide - 1 - s;
        return i + kSide * (kMiddle + kSide * k);
    };
    must(tissue.load(std::array{node(kMiddle)},
                     std::array{down ? Vec3d{0, 0, -3} : Vec3d{3, 0, 0}}));
    must(tissue.find_equilibrium());
    std::vector<Point2> points;
    for (int s = 0; s < kSide; ++s) {
        const Vec3d u = tissue.displacement(node(s));
        points.push_back({s - kMiddle + (down ? u.x : -u.z), down ? u.z : -u.x});
    }
    return points;
}

void add_anisotropy(Page& page) {
    page.heading(2, "Figure 12: anisotropy");
    page.paragraph(
        "11 × 11 × 11 nodes; an isotropic block (10 along each axis, dark), model A with "
        "horizontal springs ten times softer (1, 1, 10; orange) and model B the other way round "
        "(10, 10, 1; blue). A diagonal along n has Σ n_a² k_a. The same force of 3 on a node in "
        "the middle of the top, downwards (left), and of a side, horizontally (right); the bottom "
        "and the opposite side are held, so that both ways are the same for the isotropic block. "
        "Profiles through the pressed node.");
    const std::array<std::pair<const char*, Vec3d>, 3> models{
        {{"isotropic", {10, 10, 10}}, {"A", {1, 1, 10}}, {"B", {10, 10, 1}}}};
    const std::array<Rgb8, 3> colours{kDark, kOrange, kBlue};
    std::array<Image, 2> pictures;
    std::vector<std::vector<std::string>> rows(3);
    std::array<std::vector<Point2>, 2> isotropic;
    for (const bool down : {true, false}) {
        Chart chart(480, 400, {"along the face [spacings]", -5, 5, 1},
                    {down ? "pushed down: profile [spacings]" : "from the side: profile [spacings]",
                     -0.7, 0.1, 0.1, 1});
        for (std::size_t m = 0; m < 3; ++m) {
            const auto points = profile(models[m].second, down);
            if (m == 0) isotropic[down] = points;
            chart.curve(points, {colours[m], 2, 1},
                        m == 0 ? "isotropic" : std::string("model ") + models[m].first);
            if (down) rows[m].push_back(models[m].first);
            rows[m].push_back(fixed_text(-points[5].y, 4));
        }
        pictures[down ? 0 : 1] = chart.image();
    }
    page.picture("choi-12-anisotropy", "profiles pushed down and from the side", row_of(pictures));
    page.table({"model", "dip, pushed down", "dip, pushed from the side"}, rows);
    double apart = 0;
    for (std::size_t n = 0; n < isotropic[0].size(); ++n)
        apart = std::max(apart, std::hypot(isotropic[0][n].x - isotropic[1][n].x,
                                           isotropic[0][n].y - isotropic[1][n].y));
    page.paragraph(
        "As in the paper: the isotropic profiles are the same (largest difference " +
        std::string(apart < 1e-6 ? "below a millionth of a spacing" : fixed_text(apart, 6)) +
        "), A gives more when it is pushed horizontally, and B less than when it is pushed down.");
}

}  // namespace

void add_responses(Page& page, const TaskArena& arena) {
    page.heading(2, "Figure 11: tissue's responses");
    page.paragraph(
        "The paper names neither lattice nor numbers. Here a bar of 5 × 5 × 9 nodes with edges and "
        "face diagonals, k = 1, masses and spacing 1, held at its foot and drawn at all nodes of "
        "its top; strain is the top's mean displacement over the bar's length of 8. Damping of the "
        "nodes is 2 (orange), 4 (green) and 8 (blue), the time step 0.1.");
    add_creep(page, arena);
    add_hysteresis(page, arena);
    add_load_curve(page, arena);
    add_crimp(page, arena);
    add_relaxation(page, arena);
    add_anisotropy(page);
}

}  // namespace pliant::results
