// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The passivity observer, for each tissue with each hand, and for settings that violate passivity.

#include <algorithm>
#include <cmath>
#include <vector>

#include "figures.h"
#include "hands.h"
#include "tissues.h"

namespace pliant::results {
namespace {

const char* name_of(Hand hand) {
    return hand == Hand::Free ? "free" : hand == Hand::Spring ? "spring-damper" : "10 Hz, 2 N";
}

}  // namespace

void add_energies(Page& page, const TaskArena& arena) {
    page.heading(2, "Energy");
    page.paragraph(
        "Energy that the device and the tissue that it shows have taken from a hand that applies a "
        "sinusoidal force of 2 N at 10 Hz, in a minute; a value below 0 was made from nothing. A "
        "tissue that hardens, F = 80 d + 30 000 d², whose laws come 33 ms late: as it is, and "
        "without `bounded_energy`; forces of a wall of 300 N/m held for 33 ms, and extrapolated "
        "for one update. Left: all of it; right: the same curves, cut off beyond ±600 mJ.");
    const auto forces = [](Vec3d x) { return force_of_wall(300, x); };
    struct Row {
        const char* name;
        HapticScheme scheme;
        HapticTissue tissue;
        int delay;
        bool bounded;
        Ink ink;
    };
    const Row rows[] = {
        {"local model, 33 ms late", HapticScheme::LinearLaw, hardening(), 33, true, {kBlue, 2.5}},
        {"the same, energy not bounded",
         HapticScheme::LinearLaw,
         hardening(),
         33,
         false,
         {kOrange, 1.5}},
        {"forces held", HapticScheme::Hold, forces, 0, false, {kRed, 1.5}},
        {"forces extrapolated", HapticScheme::Extrapolate, forces, 0, false, {kDark, 1.5}},
    };
    std::vector<std::vector<std::string>> table;
    std::vector<std::vector<Point2>> curves;
    double low = 0, high = 0;
    for (const Row& row : rows) {
        std::vector<std::string> cells{row.name};
        for (const Hand hand : kHands) {
            const TimeInHand m = in_hand(hand, row.tissue, {row.scheme, row.delay, row.bounded});
            if (hand == Hand::Active) {
                std::vector<Point2> shown;
                for (const auto& [time_s, mj] : m.passivity) {
                    shown.push_back({time_s, mj});
                    low = std::min(low, mj);
                    high = std::max(high, mj);
                }
                curves.push_back(std::move(shown));
            }
            cells.push_back(fixed_text(m.lowest_mj, 3));
        }
        table.push_back(cells);
    }
    constexpr double kStep_mj = 1000, kNear_mj = 600;
    const Axis time{"time [s]", 0, 60, 10};
    Chart charts[] = {{440,
                       420,
                       time,
                       {"energy taken from the hand [mJ]", kStep_mj * std::floor(low / kStep_mj),
                        kStep_mj * std::ceil(high / kStep_mj), kStep_mj}},
                      {440, 420, time, {"the same, up to ±600 mJ [mJ]", -kNear_mj, kNear_mj, 200}}};
    for (Chart& chart : charts)
        for (std::size_t n = 0; n < curves.size(); ++n)
            chart.curve(curves[n], rows[n].ink, rows[n].name);
    const Image pictures[] = {charts[0].image(), charts[1].image()};
    page.picture("energy", "energy taken from a hand that shakes", row_of(pictures));
    page.table({"lowest in a minute [mJ], hand", "free", "spring-damper", "10 Hz, 2 N"}, table);

    page.paragraph("And of the tissues, solved at 30 Hz, all as it is by default:");
    const std::pair<const char*, HapticTissue> tissues[] = {
        {"ChainMail on a scan, bone 6 mm deep", chainmail(layers(6), arena)},
        {"springs", springs()},
        {"position-based block", pbd(arena)},
        {"catheter in a vessel", vessel(arena)}};
    table.clear();
    for (const auto& [name, tissue] : tissues)
        for (const Hand hand : kHands) {
            const TimeInHand m = in_hand(hand, tissue, {});
            table.push_back({name, name_of(hand), fixed_text(m.lowest_mj, 3),
                             fixed_text(m.most_n, 2), fixed_text(m.step_n, 3)});
        }
    page.table({"tissue", "hand", "lowest in a minute [mJ]", "largest force [N]",
                "largest step of the force in a period with a new model [N]"},
               table);
}

}  // namespace pliant::results
