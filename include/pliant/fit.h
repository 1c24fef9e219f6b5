// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Identification: the stiffness of a spring network's links, such that it moves as a reference
// does [Choi2004, 3.2]. The reference are displacements of the network's nodes under some loads,
// by finite elements (fit_box.h) or measured.
//
//   auto box = fit_box({.young_modulus_pa = 6e5, .poisson_ratio = 0.45, …}, arena);
//   auto found = fit(box->problem, GaussNewton{}, arena);
//   found->values[0]                    // stiffness of the first group
//   found->at.cases[0].average_percent  // how far nodes are from the reference
//
// Parameters are the values of groups: a group's links, cells and nodes have value times the
// stiffness, bulk and damping that the parts say. All methods search in their logarithms, between
// bounds. docs/fit.md compares them.

#pragma once

#include <pliant/springs.h>

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <variant>
#include <vector>

#pragma GCC visibility push(default)
namespace pliant {

struct FitGroup {
    std::string name;
    std::vector<std::int32_t> links{}, cells{}, nodes{};
    double start = 1;          ///< where methods begin that need a point to begin at
    double low = 0, high = 0;  ///< bounds, 0 < low ≤ start ≤ high
};

struct FitCase {
    std::string name;
    std::vector<std::int32_t> held{};   ///< nodes that don't move, besides those fixed in the parts
    std::vector<std::int32_t> nodes{};  ///< that are loaded
    std::vector<Vec3d> forces{};        ///< on them
    std::vector<Vec3d> target{};        ///< [node] displacement of the reference
    double weight = 1;                  ///< of its distances in the cost
    bool held_out = false;              ///< only judged by, not fitted to
};

/// How the network's displacement under a load is found.
enum class FitMotion {
    Linear,       ///< K u = F at the rest shape: what a linear reference can be compared with
    Equilibrium,  ///< where all forces balance, however far it moves
    Run,          ///< where force transmittal is after a given time: here damping counts
};
enum class FitCost {
    Distances,  ///< Σ over cases and nodes of weight · |x − x_reference| [Choi2004, Eq. 17]
    Squares,    ///< of weight · |x − x_reference|²
};

struct FitSettings {
    FitMotion motion = FitMotion::Linear;
    FitCost cost = FitCost::Distances;
    double spring_length = 0;  ///< that errors are given in percent of; 0: the shortest link's
    SpringSettings run{};      ///< of Run: depth, seen positions, time step
    double duration = 1;       ///< of Run
};

struct FitCaseErrors {
    std::string name;
    bool held_out = false;
    double average_percent = 0, largest_percent = 0;  ///< of the spring length
    /// The same errors of a network that doesn't move at all: a fit near these has failed.
    double still_average_percent = 0, still_largest_percent = 0;
};
struct FitPoint {
    double cost = 0;  ///< of the cases that aren't held out
    std::vector<FitCaseErrors> cases;
};

/// What a network is fitted to. Immutable.
class FitProblem {
  public:
    /// @returns InvalidArgument that names the group, case or node: a group without members, one
    ///          that has what another has already, bounds that aren't in order, a load on a held
    ///          node, targets that aren't one for each node, no case to fit to, and whatever
    ///          SpringNetwork::create refuses
    static Result<FitProblem> create(SpringParts parts, std::vector<FitGroup> groups,
                                     std::vector<FitCase> cases, const FitSettings& settings);
    ~FitProblem();
    FitProblem(FitProblem&&) noexcept;
    FitProblem& operator=(FitProblem&&) noexcept;

    std::span<const FitGroup> groups() const;
    std::span<const FitCase> cases() const;
    const FitSettings& settings() const;
    double spring_length() const;

    /// @param values  of the groups, above 0, bounds aside
    /// @returns InvalidArgument for values that aren't above 0, or that leave the network loose
    Result<FitPoint> evaluate(std::span<const double> values) const;
    /// The network's displacements in a case, [node].
    Result<std::vector<Vec3d>> displacements(std::span<const double> values,
                                             std::size_t fit_case) const;
    /// The parts with the groups' values in them.
    SpringParts parts_at(std::span<const double> values) const;

    struct Impl;
    const Impl& impl() const { return *m_impl; }

  private:
    explicit FitProblem(std::unique_ptr<Impl> impl);
    std::unique_ptr<Impl> m_impl;
};

/// No search: values that are known otherwise, for example in closed form.
struct GivenValues {
    std::vector<double> values;
};

/// Least squares with sensitivities: of a linear motion K ∂u/∂p = −∂K/∂p u, of others by central
/// differences. For FitCost::Distances the squares are weighted anew in each step [Weiszfeld1937].
/// Directions that the displacements don't show are not moved along.
struct GaussNewton {
    int max_steps = 60;
    double tolerance = 1e-5;  ///< ends when no logarithm changes by more
};

/// Simulated annealing as the paper has it: a random start, random neighbours, Metropolis'
/// criterion, T ← T/(1 + βT) [Lundy1986], one iteration at each temperature. What the paper leaves
/// open is found by looking at a few random moves beforehand; 0 stands for that.
struct Annealing {
    std::uint64_t seed = 1;
    double start_temperature = 0;  ///< unit of the cost; 0: four of five uphill moves are taken
    double end_temperature = 0;    ///< 0: a thousandth of it
    double cooling = 0;            ///< β; 0: such that `evaluations` lead from start to end
    double neighbourhood = 0.1;    ///< largest move of a logarithm, in parts of its range
    int evaluations = 400;         ///< at most, those of the preparation aside
    int preparation = 16;          ///< moves looked at beforehand
    /// The paper's answer is where the search ends; true: the best place that it has seen.
    bool best_seen = false;
};

/// Methods of NLopt that need no derivatives [Johnson2007]: quadratic models [Powell2009], and the
/// simplex as a whole [Nelder1965] or in subspaces [Rowan1990].
enum class DirectMethod { Bobyqa, NelderMead, Subplex };
struct DirectSearch {
    DirectMethod method = DirectMethod::Bobyqa;
    int evaluations = 400;    ///< at most
    double tolerance = 1e-5;  ///< ends when no logarithm changes by more
};

using FitMethod = std::variant<GivenValues, GaussNewton, Annealing, DirectSearch>;

/// One direction in the space of the logarithms, and how much the fitted displacements change
/// along it: their root mean square, relative to the reference's, per unit of the logarithms.
/// Stiffer by a factor all over has an influence of 1 in a linear motion; damping has none at an
/// equilibrium.
struct FitDirection {
    std::vector<double> direction;  ///< unit vector, [group]
    double influence = 0;
};
/// Directions with a smaller influence are not identifiable.
inline constexpr double kLeastInfluence = 1e-3;

/// The best cost found so far, when it was found.
struct FitTrace {
    std::int64_t evaluation;
    double cost;
    double seconds;
};

/// Whether a value ended on a bound of its group. The cost may then be lower beyond it, and the
/// value says more about the bound than about the network.
enum class FitBound { None, Low, High };

struct FitResult {
    std::vector<double> values;        ///< [group]
    std::vector<FitBound> at_bound{};  ///< [group]; within 10⁻⁴ of the value
    FitPoint at;
    std::int64_t evaluations = 0;  ///< of all cases at one point; a derivative counts for one too
    std::int64_t refused = 0;      ///< evaluations of networks without an equilibrium
    double seconds = 0;
    std::vector<FitTrace> trace;
    std::vector<FitDirection> directions{};  ///< at the end, by ascending influence
    double start_temperature = 0, end_temperature = 0, cooling = 0;  ///< of Annealing
};

/// The same for any number of threads, apart from the seconds.
/// @returns InvalidArgument that names a setting
Result<FitResult> fit(const FitProblem& problem, const FitMethod& method, const TaskArena& arena);

/// At some values, by ascending influence.
Result<std::vector<FitDirection>> fit_directions(const FitProblem& problem,
                                                 std::span<const double> values,
                                                 const TaskArena& arena);

}  // namespace pliant
#pragma GCC visibility pop
