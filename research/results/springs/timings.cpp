// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// [Choi2004, 4.5]: search and update of one step for depths of 1 to 20 layers, beside the paper's
// Pentium III and a naive port on this machine. A turn runs all three programs, so that noise of
// the machine affects them alike.

#include <pliant/models/springs.h>

#include "figures.h"
#include "naive_springs.h"
#include "published_times.h"
#include "timing.h"

namespace pliant::results {
namespace {

constexpr int kMiddle = 25 + 50 * 25, kTurns = 301, kSteps = 20;
const Vec3d kForce{0.02, 0.01, 0};

}  // namespace

void add_timings(Page& page, const TaskArena&) {
    const TaskArena one_thread(1);
    page.heading(2, "Table 3: time of a step");
    page.paragraph(
        "A sheet of 50 × 50 nodes with six neighbours, pressed in its middle: microseconds for "
        "the search of the order, and for the update of all nodes in one step, on one thread. "
        "Medians of " +
        grouped_text(std::int64_t(kTurns)) +
        " turns. The naive port is written as the paper's text reads, and runs on the same "
        "machine; Pliant keeps the order, so that it searches once for a contact and not in each "
        "step. The paper's “32 Hz to over 7 kHz” leaves the search out: with it its table gives 17 "
        "Hz to 6.25 kHz. More, in three dimensions and for each reading of what a node sees: "
        "`./dev bench springs`.");
    const SpringNetwork sheet = value_of(SpringNetwork::create(
        value_of(springs_of_sheet({.columns = 50, .rows = 50, .node_damping = 10}))));
    std::vector<std::vector<std::string>> rows;
    for (const Published& published : kTable3) {
        SpringTissue tissue = value_of(SpringTissue::create(sheet, {.depth = published.layers}));
        value_of(tissue.load(std::array{kMiddle}, std::array{kForce}));
        bench::NaivePort naive(sheet, tissue.time_step());
        naive.load(kMiddle, kForce);
        const auto first = value_of(tissue.step(1, one_thread));
        std::vector<double> search, update, naive_search, naive_update;
        for (int turn = 0; turn < kTurns; ++turn) {
            naive_search.push_back(
                1e3 * milliseconds_of([&] { naive.search(kMiddle, published.layers); }));
            naive_update.push_back(1e3 / kSteps * milliseconds_of([&] {
                                       for (int n = 0; n < kSteps; ++n) naive.step();
                                   }));
            search.push_back(
                1e3 * milliseconds_of([&] {
                    value_of(transmittal_order(sheet, std::array{kMiddle}, published.layers));
                }));
            update.push_back(1e3 / kSteps *
                             milliseconds_of([&] { value_of(tissue.step(kSteps, one_thread)); }));
        }
        const double a = quantile(update, 0.5), b = quantile(naive_update, 0.5);
        rows.push_back({std::to_string(published.layers), std::to_string(first.active_nodes),
                        fixed_text(1000 * published.search_ms, 0) + " + " +
                            fixed_text(1000 * published.update_ms, 0),
                        fixed_text(quantile(naive_search, 0.5), 2), fixed_text(b, 2),
                        fixed_text(quantile(search, 0.5), 2), fixed_text(a, 2),
                        fixed_text(b / a, 1)});
    }
    page.table({"layers", "nodes", "2004: search + update", "naive: search", "naive: update",
                "search", "update", "update, times faster than naive"},
               rows);
}

}  // namespace pliant::results
