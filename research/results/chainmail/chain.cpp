// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// [Gibson1996], figures 1 to 3, and [Draeger2005], figure 3.4: the rule in one and two dimensions.
// All positions come from the solver.

#include <algorithm>
#include <cmath>

#include "figures.h"
#include "setups.h"

namespace pliant::results {
namespace {

constexpr double kTight = 1e-5;  ///< [mm], tolerance of a link at its limit
const Ink kTaut{kBlue, 4}, kCompressed{kOrange, 4}, kSlack{{170, 176, 186}, 2};

const Ink& ink_of_link(double length_mm) {
    if (length_mm > 1 + kChainRange - kTight) return kTaut;
    if (length_mm < 1 - kChainRange + kTight) return kCompressed;
    return kSlack;
}

/// One row: elements, links with their lengths, and the action.
void draw_chain(Plot& plot, const ChainMail& chain, double y, const std::string& name) {
    const auto place = [&](int n) { return n + chain.displacement_mm({n, 0, 0}).x; };
    plot.text({-3.3, y}, name, kText_px, kDark, Align::Left);
    for (int n = 0; n + 1 < kChainElements; ++n) {
        const double a = place(n), b = place(n + 1);
        plot.line({a, y}, {b, y}, ink_of_link(b - a));
        plot.text({0.5 * (a + b), y - 0.24}, fixed_text(b - a, 1), 8, {90, 96, 106});
    }
    for (int n = 0; n < kChainElements; ++n) {
        const bool moved = std::abs(place(n) - n) > kTight;
        plot.dot({place(n), y}, 7, n == kChainHeld ? kRed : moved ? kDark : kPaper);
        if (!moved && n != kChainHeld)
            for (int s = 0; s < 24; ++s) {
                const double angle = s * 2 * 3.14159265358979 / 24;
                const Point2 p = plot.pixel_of({place(n), y});
                plot.dot(plot.point_of({p.x + 7 * std::cos(angle), p.y + 7 * std::sin(angle)}), 1,
                         kDark);
            }
    }
}

void add_chain(Page& page, const TaskArena& arena) {
    page.heading(3, "Figure 1: the rule, in one dimension");
    page.paragraph(
        "A chain of nine elements, each link 1 mm long at rest and between minDx = 0.6 mm and "
        "maxDx = 1.4 mm. The red element is moved to the right step by step. A link that is "
        "neither taut nor compressed carries no motion, so the neighbours stay where they are "
        "(hollow). Once a link is at its limit the next element follows, by as much as keeps it "
        "there: the motion fades by 0.4 mm from link to link. [Draeger2005] draws the same rule as "
        "its figure 3.4. Numbers are the lengths of the links [mm], as solved.");
    Scenario s = chain_scenario(arena);
    Plot plot(900, 360, {-3.5, -0.6}, {10.4, 4.96});
    for (int n = 0; n < kChainElements; ++n)
        plot.dashed_line({double(n), -0.4}, {double(n), 4.6}, {kFaint, 1, 1}, 4);
    double pushed = 0;
    for (int row = 0; row < 5; ++row) {
        draw_chain(plot, *s.tissue, row + 0.15, "moved by " + fixed_text(pushed, 1) + " mm");
        constexpr double kStep_mm = 0.6;
        if (row < 4) s.push({{kChainHeld, 0, 0}}, {kStep_mm, 0, 0});
        pushed += kStep_mm;
    }
    using enum LegendEntry::Mark;
    const LegendEntry legend[] = {{"moved by the user", {kRed, 7}, Dot},
                                  {"follows", {kDark, 7}, Dot},
                                  {"link at maxDx = 1.4 mm (taut)", kTaut, Line},
                                  {"link at minDx = 0.6 mm (compressed)", kCompressed, Line},
                                  {"link between its limits", kSlack, Line},
                                  {"position at rest", {kFaint, 1.5}, Dashes}};
    const Image parts[] = {plot.image(), legend_of(legend, 900)};
    page.picture("gibson-1-chain", "a chain whose middle element is moved to the right",
                 column_of(parts, 0));
}

void add_mail(Page& page, const TaskArena& arena) {
    constexpr int kSide = 11;
    constexpr double kRange = 0.4, kShear = 0.3;
    page.heading(3, "Figures 2 and 3: in two dimensions");
    page.paragraph(
        "Chain mail of 11 × 11 elements, minDx = 0.6, maxDx = 1.4, maxHorizDy = maxVertDx = 0.3; "
        "the red element is moved by (1.7, −1.2) mm. Boxes are the regions of figure 3: where its "
        "right and its lower neighbour may be. Both lie on the edges of theirs, so they moved no "
        "farther than they had to. A motion along a row carries on along that row by the stretch "
        "limits, and from row to row by the shear limits.");
    Scenario s = gibson_object({{kSide, kSide, 1}, [](Vec3i) { return true; }, nullptr}, kRange,
                               kShear, arena);
    const Vec3i held{5, 5, 0};
    s.push({held}, {1.7, -1.2, 0});
    Plot plot(520, 520, {-1.3, -1.7}, {11.7, 11.3});
    const Slice slice{0, 1, 0};
    const Window window{0, kSide, 0, kSide};
    for (int n = 0; n < kSide; ++n) {
        plot.line({double(n), 0}, {double(n), kSide - 1}, {kFaint, 1});
        plot.line({0, double(n)}, {kSide - 1, double(n)}, {kFaint, 1});
    }
    draw_lattice(plot, *s.tissue, slice, window, {2.1, 1.6, 4});
    const Vec3d u = s.tissue->displacement_mm(held);
    const Point2 at{held.x + u.x, held.y + u.y};
    const auto region = [&](Point2 low, Point2 high) {
        const Point2 corners[] = {{at.x + low.x, at.y + low.y},
                                  {at.x + high.x, at.y + low.y},
                                  {at.x + high.x, at.y + high.y},
                                  {at.x + low.x, at.y + high.y}};
        plot.polyline(corners, {kOrange, 2}, true);
    };
    region({1 - kRange, -kShear}, {1 + kRange, kShear});
    region({-kShear, 1 - kRange}, {kShear, 1 + kRange});
    plot.dot(at, 6, kRed);
    using enum LegendEntry::Mark;
    const LegendEntry legend[] = {{"moved by the user", {kRed, 6}, Dot},
                                  {"regions of two neighbours", {kOrange, 2}, Line},
                                  {"at rest", {kFaint, 1.5}, Line}};
    const Image parts[] = {plot.image(), shade_bar(2.1, 1, "displacement [mm]"),
                           legend_of(legend, 520)};
    page.picture("gibson-2-mail", "chain mail whose middle element is moved", column_of(parts, 0));
}

}  // namespace

void add_chains(Page& page, const TaskArena& arena) {
    add_chain(page, arena);
    add_mail(page, arena);
}

}  // namespace pliant::results
