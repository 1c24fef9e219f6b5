// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "errors.h"

#include <algorithm>
#include <cmath>

#include "timing.h"

namespace pliant::results {

Errors errors_of(const Displacements& found, const Displacements& reference, const Body& body,
                 const Load& load) {
    constexpr double kMoved = 0.01;
    const Vec3d h = body.lattice.spacing_mm;
    const double push_mm = norm({load.push.x * h.x, load.push.y * h.y, load.push.z * h.z});
    std::vector<bool> is_free(body.held.size(), true);
    for (std::size_t n = 0; n < is_free.size(); ++n) is_free[n] = !body.held[n];
    for (const Vec3i& node : nodes_of(load, body.lattice))
        is_free[std::size_t(node_index(body.lattice, node))] = false;
    std::vector<double> moved;
    double sum = 0, whole = 0, squares = 0, reference_squares = 0;
    std::size_t free_count = 0;
    for (std::size_t n = 0; n < is_free.size(); ++n) {
        if (!is_free[n]) continue;
        const Vec3d difference = found[n] - reference[n];
        const double error = 100 * norm(difference) / push_mm;
        squares += dot(difference, difference);
        reference_squares += dot(reference[n], reference[n]);
        ++free_count;
        whole += error;
        if (norm(reference[n]) <= kMoved * push_mm) continue;
        moved.push_back(error);
        sum += error;
    }
    return {sum / double(std::max<std::size_t>(1, moved.size())), quantile(moved, 0.95),
            whole / double(std::max<std::size_t>(1, free_count)),
            100 * std::sqrt(squares / std::max(reference_squares, 1e-300))};
}

Errors ErrorsOfLoads::mean() const {
    Errors mean;
    const double share = 1.0 / double(std::max<std::size_t>(1, all.size()));
    for (const Errors& e : all)
        mean.mean += share * e.mean, mean.p95 += share * e.p95, mean.whole += share * e.whole,
            mean.l2 += share * e.l2;
    return mean;
}

double ErrorsOfLoads::worst_mean() const {
    double worst = 0;
    for (const Errors& e : all) worst = std::max(worst, e.mean);
    return worst;
}

Displacements of_tool_alone(const Body& body, const Load& load) {
    Displacements still(body.held.size(), {0, 0, 0});
    const Vec3d h = body.lattice.spacing_mm;
    for (const Vec3i& node : nodes_of(load, body.lattice))
        still[std::size_t(node_index(body.lattice, node))] = {load.push.x * h.x, load.push.y * h.y,
                                                              load.push.z * h.z};
    return still;
}

Errors best_offset(const ChainBody& chain, const Displacements& reference, const Body& body,
                   const Load& load, double* offset) {
    Errors best{.mean = 1e9};
    for (const double tried :
         {0.02, 0.03, 0.04, 0.06, 0.08, 0.1, 0.14, 0.2, 0.28, 0.4, 0.56, 0.8}) {
        const Answer answer = chain.push(load, {.offset = tried});
        // A shortened push is no answer to the load.
        if (answer.fraction < 1) continue;
        const Errors errors = errors_of(answer.displacement_mm, reference, body, load);
        if (errors.mean >= best.mean) continue;
        best = errors;
        if (offset) *offset = tried;
    }
    return best;
}

}  // namespace pliant::results
