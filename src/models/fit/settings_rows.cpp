// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The tables of settings of a fit and its methods.

#include <pliant/models/fit.h>

namespace pliant {
namespace {

using A = Annealing;
using F = FitSettings;
using G = GaussNewton;

constexpr Setting<F> kFit[] = {
    setting<&F::motion>({.name = "motion",
                         .choices = "linear|equilibrium|run",
                         .text = "how the network's displacement under a load is computed"}),
    setting<&F::cost>({.name = "cost",
                       .choices = "distances|squares",
                       .text = "sum over cases and nodes of the distances to the reference"}),
    setting<&F::spring_length>({.name = "spring_length",
                                .range = {.low = 0},
                                .text = "errors are in percent of this length; 0: the shortest "
                                        "link"}),
    setting<&F::duration>({.name = "duration",
                           .range = {.low = 0},
                           .above_low = true,
                           .text = "simulated time of a run"}),
};

constexpr Setting<G> kGaussNewton[] = {
    setting<&G::max_steps>({.name = "max_steps", .range = {.low = 1}, .text = "steps"}),
    setting<&G::tolerance>({.name = "tolerance",
                            .range = {.low = 0},
                            .above_low = true,
                            .text = "stops when all logarithms change by less"}),
};

constexpr Setting<A> kAnnealing[] = {
    setting<&A::start_temperature>({.name = "start_temperature",
                                    .range = {.low = 0},
                                    .text = "in the unit of the cost; 0: four of five uphill moves "
                                            "are accepted"}),
    setting<&A::end_temperature>({.name = "end_temperature",
                                  .range = {.low = 0},
                                  .text = "below the start's; 0: a thousandth of it"}),
    setting<&A::cooling>({.name = "cooling",
                          .range = {.low = 0},
                          .text = "β; 0: such that the evaluations lead from start to end"}),
    setting<&A::neighbourhood>({.name = "neighbourhood",
                                .range = {0, 1},
                                .above_low = true,
                                .text = "largest move of a logarithm, in parts of its range"}),
    setting<&A::by_turns>(
        {.name = "by_turns", .text = "a neighbour differs in one value, by turns, not in all"}),
    setting<&A::evaluations>(
        {.name = "evaluations", .range = {.low = 1}, .text = "of the cost, at most"}),
    setting<&A::preparation>(
        {.name = "preparation", .range = {.low = 1}, .text = "random moves beforehand"}),
    setting<&A::best_seen>(
        {.name = "best_seen", .text = "the answer is the best point instead of the last one"}),
};

}  // namespace

SettingRows<FitSettings> fit_rows() noexcept {
    return kFit;
}
SettingRows<GaussNewton> gauss_newton_rows() noexcept {
    return kGaussNewton;
}
SettingRows<Annealing> annealing_rows() noexcept {
    return kAnnealing;
}

}  // namespace pliant
