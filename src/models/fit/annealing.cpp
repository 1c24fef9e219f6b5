// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Simulated annealing of [Choi2004, 3.2.4], as in its Figure 7, with one iteration at each
// temperature and T ← T/(1 + βT) [Lundy1986]:
//
//   1/T after n iterations = 1/T₀ + nβ
//
// So β follows from both ends of the range and the number of iterations. The paper leaves
// neighbours, range and the Boltzmann constant's unit open. Here a neighbour differs in all
// logarithms, by at most a fraction of their ranges; temperatures have the cost's unit; and the
// range is determined from the uphill moves of a few random pairs.

#include <cmath>
#include <random>
#include <string>

#include "fit/search.h"

namespace pliant {
namespace {

constexpr double kTaken = 0.8;   // accepted share of uphill moves at the start
constexpr double kRange = 1000;  // ratio of start to end temperature

/// Random numbers that are identical in every standard library.
class Numbers {
  public:
    explicit Numbers(std::uint64_t seed) : m_engine(seed) {}
    /// Uniform in 0 ≤ x < 1.
    double next() { return double(m_engine() >> 11) * 0x1p-53; }

  private:
    std::mt19937_64 m_engine;
};

Search::Point anywhere(const Search& search, Numbers& numbers) {
    Search::Point point(search.size());
    for (std::size_t g = 0; g < point.size(); ++g)
        point[g] = search.low(g) + numbers.next() * (search.high(g) - search.low(g));
    return point;
}

/// Random neighbour, reflected at the bounds. @param turn  of the value that moves by turns
Search::Point neighbour_of(const Search& search, const Annealing& settings,
                           const Search::Point& point, int turn, Numbers& numbers) {
    const double reach = settings.neighbourhood;
    Search::Point next(point);
    for (std::size_t g = 0; g < next.size(); ++g) {
        if (settings.by_turns && g != std::size_t(turn) % next.size()) continue;
        const double low = search.low(g), high = search.high(g);
        next[g] += (2 * numbers.next() - 1) * reach * (high - low);
        if (next[g] < low) next[g] = 2 * low - next[g];
        if (next[g] > high) next[g] = 2 * high - next[g];
    }
    return search.within_bounds(std::move(next));
}

Status check(const Annealing& s) {
    const auto bad = [](const std::string& text) {
        return Error{ErrorCode::InvalidArgument, "Annealing: " + text};
    };
    if (const Status status = pliant::check(s, annealing_rows()); !status.ok())
        return bad(status.error().message);
    if (s.start_temperature > 0 && s.end_temperature >= s.start_temperature)
        return bad("end_temperature: expected less than the start's " +
                   std::to_string(s.start_temperature) + ", found " +
                   std::to_string(s.end_temperature));
    return Ok{};
}

/// Mean uphill move between random points and their neighbours; 0 if there is none.
double mean_uphill(Search& search, const Annealing& settings, Numbers& numbers) {
    std::vector<Search::Point> points;
    for (int n = 0; n < settings.preparation; ++n) {
        points.push_back(anywhere(search, numbers));
        points.push_back(neighbour_of(search, settings, points.back(), n, numbers));
    }
    const std::vector<double> costs = search.costs(points);
    double sum = 0;
    int count = 0;
    for (std::size_t n = 0; n < costs.size(); n += 2) {
        const double change = std::abs(costs[n + 1] - costs[n]);
        if (!std::isfinite(change)) continue;
        sum += change;
        ++count;
    }
    return count > 0 ? sum / count : 0;
}

}  // namespace

Result<FitResult> search_annealing(Search& search, const Annealing& settings) {
    if (const Status status = check(settings); !status.ok()) return status.error();
    Numbers numbers(settings.seed);
    double start = settings.start_temperature;
    if (start == 0) start = mean_uphill(search, settings, numbers) / -std::log(kTaken);
    if (!(start > 0))
        return Error{ErrorCode::InvalidArgument,
                     "Annealing: found no move that changes the cost; expected parameters that the "
                     "cases depend on"};
    const double end = settings.end_temperature > 0 ? settings.end_temperature : start / kRange;
    const double cooling =
        settings.cooling > 0 ? settings.cooling : (1 / end - 1 / start) / settings.evaluations;
    Search::Point point = anywhere(search, numbers);
    double cost = search.cost(point);
    double temperature = start;
    for (int n = 0; n < settings.evaluations && temperature > end; ++n) {
        Search::Point next = neighbour_of(search, settings, point, n, numbers);
        const double there = search.cost(next);
        const bool downhill = there < cost || !std::isfinite(cost);
        if (downhill || numbers.next() < std::exp((cost - there) / temperature)) {
            point = std::move(next);
            cost = there;
        }
        temperature /= 1 + cooling * temperature;
    }
    FitResult& result = search.result();
    result.start_temperature = start;
    result.end_temperature = temperature;
    result.cooling = cooling;
    if (settings.best_seen && !search.best().empty()) point = search.best();
    return search.finish(point);
}

}  // namespace pliant
