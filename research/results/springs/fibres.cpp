// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Springs identified against a transversely isotropic block.

#include "fibre_block.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "chart.h"
#include "figures.h"

namespace pliant::results {
namespace {

constexpr std::size_t kSides = 3;  // the first of the two loads on sides in loads_of()

std::string joined(const std::vector<double>& values) {
    std::string text;
    for (const double v : values) text += (text.empty() ? "" : ", ") + fixed_text(v / 1000, 1);
    return text;
}

/// Displacement of the middle of a pulled side along the traction.
/// @returns [µm] against height [mm]
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

struct Profile {
    const char* name;
    Ink ink;
    std::vector<Point2> points;
};
/// Of one load; the first one is the reference.
using Profiles = std::vector<Profile>;

constexpr int kWidth = 480;

Axis height_axis() {
    return {"height of the node [mm]", 0, 40, 10};
}

Image displacement_chart(const Profiles& profiles, const std::string& name) {
    Chart chart(kWidth, 400, height_axis(), {name + " [µm]", 0, 500, 100});
    for (const Profile& p : profiles) chart.curve(p.points, p.ink, p.name);
    return chart.image();
}

/// Differences from the reference of all profiles but that of one stiffness, which is far from it.
Image difference_chart(const Profiles& profiles) {
    constexpr double kStep_um = 2;
    std::vector<Profile> differences(profiles.begin() + 2, profiles.end());
    double most = kStep_um;
    for (Profile& p : differences)
        for (std::size_t n = 0; n < p.points.size(); ++n) {
            p.points[n].y -= profiles[0].points[n].y;
            most = std::max(most, std::abs(p.points[n].y));
        }
    most = kStep_um * std::ceil(most / kStep_um);
    Chart chart(kWidth, 260, height_axis(),
                {"difference from finite elements [µm]", -most, most, most / 2, most < 4 ? 1 : 0});
    for (const Profile& p : differences) chart.curve(p.points, {p.ink.colour, 2}, p.name);
    return chart.image();
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
        fixed_text(m.fibre_young_modulus_pa / 1000, 1) + " kPa along and " +
        fixed_text(m.young_modulus_pa / 1000, 1) + " kPa across, Poisson's ratios " +
        fixed_text(m.fibre_poisson_ratio, 2) + " and " + fixed_text(m.poisson_ratio, 2) +
        ", shear moduli 8 kPa in planes with fibres and 5 kPa across. Links alone obey Cauchy's "
        "relations, and so does this solid; the stiffness of each direction is then known in "
        "closed form. Held at its foot; five tractions on whole faces are fitted, a pressure on a "
        "quarter of the top isn't. Gauss–Newton, one stiffness for all links or one for each of "
        "four groups: edges along the fibres, edges across, diagonals in planes with fibres, "
        "diagonals across [N/m]. Errors in percent of the spring length of 5 mm, average of all "
        "nodes.");
    std::vector<std::vector<std::string>> rows;
    std::array<Profiles, 2> profiles;
    const auto add = [&](const char* name, bool by_direction, const FitMethod& method,
                         const Ink& ink) {
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
            rows.push_back({"nothing moves", "", fixed_text(fitted_still, 3),
                            fixed_text(other.still_average_percent, 3),
                            fixed_text(other.still_largest_percent, 2)});
            for (std::size_t c = 0; c < 2; ++c)
                profiles[c].push_back({"finite elements",
                                       {{170, 176, 186}, 7},
                                       profile(block, problem.cases()[kSides + c].target, c == 0)});
        }
        rows.push_back({name, joined(found.values), fixed_text(fitted, 3),
                        fixed_text(other.average_percent, 3),
                        fixed_text(other.largest_percent, 2)});
        for (std::size_t c = 0; c < 2; ++c)
            profiles[c].push_back(
                {name, ink,
                 profile(block, value_of(problem.displacements(found.values, kSides + c)),
                         c == 0)});
        return other.average_percent;
    };
    const double one = add("one stiffness", false, GaussNewton{}, {kBlue, 2});
    add("by direction, closed form", true, GivenValues{block.closed_form()}, {kGreen, 4});
    const double four = add("by direction, fitted", true, GaussNewton{}, {kOrange, 1.6});
    if (!(four < 0.5 * one))
        must(Error{ErrorCode::Unsupported, "expected springs by direction to fit better"});
    page.table({"springs", "values [N/m]", "average error, fitted loads [%]",
                "other load: average [%]", "other load: largest [%]"},
               rows);
    const Image rows_of_charts[] = {
        row_of(std::array{displacement_chart(profiles[0], "pulled along the fibres: displacement"),
                          displacement_chart(profiles[1], "pulled across: displacement")}),
        row_of(std::array{difference_chart(profiles[0]), difference_chart(profiles[1])})};
    page.picture("fibres", "displacement of a side that is pulled along and across the fibres",
                 column_of(rows_of_charts));
    page.paragraph(
        "The pictures show the middle line of a side under a traction on it, along the fibres "
        "(left) and across (right): its displacement along the traction, and below how far the "
        "springs by direction are from the finite elements, whose curves lie on each other above. "
        "One stiffness follows the solid across, and is too soft along.");
}

}  // namespace pliant::results
