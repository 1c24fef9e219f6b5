// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The only user of NLopt: derivative-free searches.

#include <nlopt.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "fit/search.h"

namespace pliant {
namespace {

nlopt_algorithm algorithm_of(DirectMethod method) {
    switch (method) {
        case DirectMethod::Bobyqa:
            return NLOPT_LN_BOBYQA;
        case DirectMethod::NelderMead:
            return NLOPT_LN_NELDERMEAD;
        case DirectMethod::Subplex:
            return NLOPT_LN_SBPLX;
    }
    return NLOPT_LN_BOBYQA;
}

struct Asked {
    Search& search;
    double worst = 0;
};

/// Cost function for NLopt. Models of the cost need finite numbers: a refused network is worse than
/// all others.
double ask(unsigned size, const double* point, double*, void* data) {
    Asked& asked = *static_cast<Asked*>(data);
    const double cost = asked.search.cost(Search::Point(point, point + size));
    if (!std::isfinite(cost)) return 2 * asked.worst + 1;
    asked.worst = std::max(asked.worst, cost);
    return cost;
}

}  // namespace

Result<FitResult> search_direct(Search& search, const DirectSearch& settings) {
    const auto bad = [](const std::string& text) {
        return Error{ErrorCode::InvalidArgument, "DirectSearch: " + text};
    };
    if (const Status s = check(settings, direct_search_rows()); !s.ok())
        return bad(s.error().message);
    const auto size = unsigned(search.size());
    std::vector<double> low, high, first;
    for (std::size_t g = 0; g < search.size(); ++g) {
        low.push_back(search.low(g));
        high.push_back(search.high(g));
        // Initial step: a factor of e^½, less for narrow bounds.
        first.push_back(std::max(1e-9, std::min(0.5, (high[g] - low[g]) / 4)));
    }
    const std::unique_ptr<nlopt_opt_s, void (*)(nlopt_opt)> solver(
        nlopt_create(algorithm_of(settings.method), size), nlopt_destroy);
    Asked asked{search};
    bool set = solver != nullptr;
    set = set && nlopt_set_min_objective(solver.get(), ask, &asked) > 0;
    set = set && nlopt_set_lower_bounds(solver.get(), low.data()) > 0;
    set = set && nlopt_set_upper_bounds(solver.get(), high.data()) > 0;
    set = set && nlopt_set_initial_step(solver.get(), first.data()) > 0;
    set = set && nlopt_set_xtol_abs1(solver.get(), settings.tolerance) > 0;
    set = set && nlopt_set_maxeval(solver.get(), settings.evaluations) > 0;
    if (!set) return bad("NLopt refuses the settings");
    Search::Point point = search.start();
    double cost = 0;
    const nlopt_result ended = nlopt_optimize(solver.get(), point.data(), &cost);
    // A search stopped by rounding has converged.
    if (ended < 0 && ended != NLOPT_ROUNDOFF_LIMITED)
        return bad("NLopt ends with its code " + std::to_string(int(ended)));
    return search.finish(search.best().empty() ? point : search.best());
}

}  // namespace pliant
