// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Springs identified against a transversely isotropic block.

#include "fibre_block.h"

#include <array>

#include "chart.h"
#include "figures.h"

namespace pliant::results {
namespace {

constexpr std::size_t kSides = 3;  // the first of the two loads on sides in loads_of()

std::string joined(const std::vector<double>& values) {
    std::string text;
    for (const double v : values) text += (text.empty() ? "" : ", ") + text_of(v / 1000, 1);
    return text;
}

/// Motion of the middle of a pulled side, along the traction. @returns [µm] against height [mm]
std::vector<Point2> profile(const FibreBlock& block, const std::vector<Vec3d>& moved, bool along) {
    std::vector<Point2> points;
    const std::int32_t last = block.side - 1, middle = last / 2;
    for (std::int32_t k = 0; k <= last; ++k) {
        const auto n =
            std::size_t(along ? block.node(last, middle, k) : block.node(middle, last, k));
        points.push_back({block.spacing_mm * k, 1000 * (along ? moved[n].x : moved[n].y)});
    }
    return points;
}

}  // namespace

void add_fibres(Page& page, const TaskArena& arena) {
    const FibreBlock block{.side = 9};
    const ElasticMaterial m = block.material();
    page.heading(2, "Fibres: identification against an anisotropic solid");
    page.paragraph(
        "The paper writes Hooke's law with its full tensor (Eq. 3), and identifies springs against "
        "isotropic elastin only. Here the reference is a block of 9 × 9 × 9 nodes, 40 mm wide, "
        "with fibres along x: " +
        text_of(m.fibre_young_modulus_pa / 1000, 1) + " kPa along and " +
        text_of(m.young_modulus_pa / 1000, 1) + " kPa across, Poisson's ratios " +
        text_of(m.fibre_poisson_ratio, 2) + " and " + text_of(m.poisson_ratio, 2) +
        ", shear moduli 8 kPa in planes with fibres and 5 kPa across. Links alone obey Cauchy's "
        "relations, and so does this solid; the stiffness of each direction is then known in "
        "closed form. Held at its foot; five tractions on whole faces are fitted, a pressure on a "
        "quarter of the top isn't. Gauss–Newton, one stiffness for all links or one for each of "
        "four groups: edges along the fibres, edges across, diagonals in planes with fibres, "
        "diagonals across [N/m]. Errors in percent of the spring length of 5 mm, average of all "
        "nodes.");
    std::vector<std::vector<std::string>> rows;
    std::array<Chart, 2> charts{Chart(480, 400, {"height of the node [mm]", 0, 40, 10},
                                      {"pulled along the fibres: way [µm]", 0, 500, 100}),
                                Chart(480, 400, {"height of the node [mm]", 0, 40, 10},
                                      {"pulled across: way [µm]", 0, 500, 100})};
    const auto draw = [&](std::size_t chart, const std::vector<Vec3d>& moved, Rgb8 colour,
                          const char* name) {
        charts[chart].curve(profile(block, moved, chart == 0), {colour, 2, 1}, name);
    };
    const auto add = [&](const char* name, bool by_direction, const FitMethod& method,
                         Rgb8 colour) {
        const FitProblem problem = value_of(fibre_problem(block, by_direction, arena));
        const FitResult found = value_of(fit(problem, method, arena));
        double fitted = 0, fitted_still = 0;
        for (const FitCaseErrors& c : found.at.cases)
            if (!c.held_out) {
                fitted += c.average_percent / 5;
                fitted_still += c.still_average_percent / 5;
            }
        const FitCaseErrors& other = found.at.cases.back();
        if (rows.empty()) {
            rows.push_back({"nothing moves", "", text_of(fitted_still, 3),
                            text_of(other.still_average_percent, 3),
                            text_of(other.still_largest_percent, 2)});
            for (std::size_t c = 0; c < 2; ++c)
                draw(c, problem.cases()[kSides + c].target, kDark, "finite elements");
        }
        rows.push_back({name, joined(found.values), text_of(fitted, 3),
                        text_of(other.average_percent, 3), text_of(other.largest_percent, 2)});
        for (std::size_t c = 0; c < 2; ++c)
            draw(c, value_of(problem.displacements(found.values, kSides + c)), colour, name);
        return other.average_percent;
    };
    const double one = add("one stiffness", false, GaussNewton{}, kBlue);
    add("by direction, closed form", true, GivenValues{block.closed_form()}, kGreen);
    const double four = add("by direction, fitted", true, GaussNewton{}, kOrange);
    if (!(four < 0.5 * one))
        must(Error{ErrorCode::Unsupported, "expected springs by direction to fit better"});
    page.table({"springs", "values [N/m]", "average error, fitted loads [%]",
                "other load: average [%]", "other load: largest [%]"},
               rows);
    page.picture("fibres", "motion of a side that is pulled along and across the fibres",
                 row_of(std::array{charts[0].image(), charts[1].image()}));
    page.paragraph(
        "The pictures show the middle line of a side under a traction on it, along the fibres "
        "(left) and across (right): one stiffness follows the solid across, and is too soft "
        "along.");
}

}  // namespace pliant::results
