// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Identification of link stiffnesses, such that a spring network moves as a reference does
// [Choi2004, 3.2]. The reference consists of displacements of the network's nodes under some loads,
// computed by finite elements (fit.h) or measured.
//
// @code
//   auto box = fit_box({.young_modulus_pa = 6e5, .poisson_ratio = 0.45}, arena);
//   auto found = fit(box->problem, GaussNewton{}, arena);
//   double stiffness = found->values[0];                        // of the first group
//   double distance = found->at.cases[0].average_percent;       // of nodes from the reference
// @endcode
//
// The parameters are one value per group. It multiplies the stiffness, bulk and damping that the
// parts give for the group's links, cells and nodes. All methods search over the logarithms of the
// values, between bounds. docs/method/fit.md compares them.

#pragma once

#include <pliant/core/record.h>
#include <pliant/models/fem.h>
#include <pliant/models/springs.h>

#include <array>
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
    double start = 1;          ///< initial value for methods that need one
    double low = 0, high = 0;  ///< bounds, 0 < low ≤ start ≤ high
};

/// A displacement that was measured at a point, as the weighted mean of those of four nodes.
struct FitPointTarget {
    std::array<std::int32_t, 4> nodes{};
    std::array<double, 4> weights{1, 0, 0, 0};
    Vec3d displacement{0, 0, 0};
};

struct FitCase {
    std::string name;
    std::vector<std::int32_t> held{};   ///< immobile nodes, besides those fixed in the parts
    std::vector<std::int32_t> nodes{};  ///< loaded nodes
    std::vector<Vec3d> forces{};        ///< forces on these nodes
    std::vector<Vec3d> target{};        ///< [node] displacement of the reference; empty: `points`
    std::vector<FitPointTarget> points{};  ///< measured displacements, in place of `target`
    double weight = 1;                     ///< weight of its distances in the cost
    bool held_out = false;                 ///< used for evaluation only
};

/// Method that computes the network's displacement under a load.
enum class FitMotion {
    Linear,       ///< K u = F at the rest shape: comparable with a linear reference
    Equilibrium,  ///< all forces balance at any displacement
    Run,          ///< state of force transmittal after a given time: here damping matters
};
enum class FitCost {
    Distances,  ///< Σ over cases and nodes of weight · |x − x_reference| [Choi2004, Eq. 17]
    Squares,    ///< Σ over cases and nodes of weight · |x − x_reference|²
};

struct FitSettings {
    FitMotion motion = FitMotion::Linear;
    FitCost cost = FitCost::Distances;
    double spring_length = 0;  ///< errors are given in percent of this length; 0: the shortest link
    SpringSettings run{};      ///< of Run: depth, seen positions, time step
    double duration = 1;       ///< of Run
};
SettingRows<FitSettings> fit_rows() noexcept;

struct FitCaseErrors {
    std::string name;
    bool held_out = false;
    double average_percent = 0, largest_percent = 0;  ///< of the spring length
    /// The errors of a network that doesn't move at all. A fit near these has failed.
    double still_average_percent = 0, still_largest_percent = 0;
};
struct FitPoint {
    double cost = 0;  ///< of the cases with held_out = false
    std::vector<FitCaseErrors> cases;
};

/// A network, its groups and the reference. Immutable.
/// Thread safety: immutable.
class FitProblem {
  public:
    /// @returns InvalidArgument that names the group, case or node: a group without members, a
    ///          member of two groups, unordered bounds, a load on a held node, a number of targets
    ///          other than the number of nodes, no case to fit, and every error of
    ///          SpringNetwork::create
    static Result<FitProblem> create(SpringParts parts, std::vector<FitGroup> groups,
                                     std::vector<FitCase> cases, const FitSettings& settings);
    ~FitProblem();
    FitProblem(FitProblem&&) noexcept;
    FitProblem& operator=(FitProblem&&) noexcept;

    std::span<const FitGroup> groups() const;
    std::span<const FitCase> cases() const;
    const FitSettings& settings() const;
    double spring_length() const;

    /// @param values  one per group, above 0; the bounds don't apply
    /// @returns InvalidArgument if a value isn't above 0 or the network has a free rigid motion
    Result<FitPoint> evaluate(std::span<const double> values) const;
    /// Displacement of the network minus each target of a case: [node], or [point].
    Result<std::vector<Vec3d>> residuals(std::span<const double> values,
                                         std::size_t fit_case) const;
    /// The network's displacements in a case, [node].
    Result<std::vector<Vec3d>> displacements(std::span<const double> values,
                                             std::size_t fit_case) const;
    /// Parts with the groups' values inserted.
    SpringParts parts_at(std::span<const double> values) const;

    struct Impl;
    const Impl& impl() const { return *m_impl; }

  private:
    explicit FitProblem(std::unique_ptr<Impl> impl);
    std::unique_ptr<Impl> m_impl;
};

/// No search: values that are known from elsewhere, for example in closed form.
struct GivenValues {
    std::vector<double> values;
};

/// Least squares with sensitivities. For a linear motion they solve K ∂u/∂p = −∂K/∂p u; for the
/// others they are central differences. FitCost::Distances is solved by iteratively reweighted
/// least squares [Weiszfeld1937]. Steps leave out directions without influence on the
/// displacements.
struct GaussNewton {
    int max_steps = 60;
    double tolerance = 1e-5;  ///< stops when all logarithms change by less
};
SettingRows<GaussNewton> gauss_newton_rows() noexcept;

/// Simulated annealing as in the paper: a random start, random neighbours, Metropolis' criterion, T
/// ← T/(1 + βT) [Lundy1986], one iteration at each temperature. A setting of 0 stands for a value
/// that the paper leaves open; some random moves beforehand determine it.
struct Annealing {
    std::uint64_t seed = 1;
    double start_temperature = 0;  ///< unit of the cost; 0: four of five uphill moves are accepted
    double end_temperature = 0;    ///< 0: a thousandth of the start
    double cooling = 0;            ///< β; 0: such that `evaluations` lead from start to end
    double neighbourhood = 0.1;    ///< largest move of a logarithm, in parts of its range
    /// A neighbour differs in one value, by turns, instead of in all of them. Where one value is
    /// determined more sharply than another, moves of all are refused because of the former, and
    /// the latter stays where it is (docs/method/fit.md).
    bool by_turns = false;
    int evaluations = 400;  ///< maximum, without those of the preparation
    int preparation = 16;   ///< random moves beforehand
    /// false: the answer is the last point, as in the paper; true: the best point of the search.
    bool best_seen = false;
};
SettingRows<Annealing> annealing_rows() noexcept;

using FitMethod = std::variant<GivenValues, GaussNewton, Annealing>;

/// A direction in the space of the logarithms and its influence: the root mean square of the change
/// of the fitted displacements, relative to the reference's, per unit of the logarithms. A uniform
/// factor of all stiffnesses has an influence of 1 in a linear motion. Damping has no influence on
/// an equilibrium.
struct FitDirection {
    std::vector<double> direction;  ///< unit vector, [group]
    double influence = 0;
};
/// Directions with a smaller influence are not identifiable.
inline constexpr double kMinInfluence = 1e-3;

/// A point of the history of the best cost.
struct FitTrace {
    std::int64_t evaluation;
    double cost;
    double seconds;
};

/// Whether a value ended on a bound of its group. The cost may be lower beyond the bound, so the
/// value then reflects the bound more than the network.
enum class FitBound { None, Low, High };

struct FitResult {
    std::vector<double> values;        ///< [group]
    std::vector<FitBound> at_bound{};  ///< [group]; within 10⁻⁴ of the value
    FitPoint at;
    std::int64_t evaluations = 0;  ///< evaluations of all cases at one point; a derivative counts
                                   ///< as one
    std::int64_t refused = 0;      ///< evaluations of networks without an equilibrium
    double seconds = 0;
    std::vector<FitTrace> trace;
    std::vector<FitDirection> directions{};  ///< at the end, by ascending influence
    double start_temperature = 0, end_temperature = 0, cooling = 0;  ///< of Annealing
};

/// Fits the values. The result, apart from the seconds, is equal for any number of threads.
/// @returns InvalidArgument that names a setting
Result<FitResult> fit(const FitProblem& problem, const FitMethod& method, const TaskArena& arena);

/// Directions at the given values, by ascending influence.
Result<std::vector<FitDirection>> fit_directions(const FitProblem& problem,
                                                 std::span<const double> values,
                                                 const TaskArena& arena);

/// Interval of a value that contains the true one in 95 of 100 repetitions of a measurement.
struct FitInterval {
    double low = 0, high = 0;  ///< 0 and infinity if the value isn't identifiable
    bool identifiable = true;
};

/// Confidence intervals of the values at an optimum, from the derivatives there (the linearised
/// covariance of their logarithms). The noise is Gaussian and independent in each component of each
/// displacement. The difference between network and tissue is no noise, and isn't covered.
/// @param noise  standard deviation of a component, in the network's unit of length
/// @returns InvalidArgument if the noise isn't above 0
Result<std::vector<FitInterval>> fit_intervals(const FitProblem& problem,
                                               std::span<const double> values, double noise,
                                               const TaskArena& arena);

// The set-up of [Choi2004, 4.3] with any numbers: a box of elastic material, held at a face and
// loaded at nodes of another face, by finite elements and as a lattice of springs.
//
//          +z, pressed            the four nodes around the middle of a face
//        ┌──▪▪──┐
//       ╱      ╱│                 size      nodes along x, y, z
//      ├──────┤ │                 spacing   between them, along each axis
//      │      │╱
//      └──────┘  −z, held
//
// The interface uses mm. The network uses m, kg, s: stiffness in N/m, bulk in Pa, damping in kg/s,
// cost in m.

enum class BoxFace { LowX, HighX, LowY, HighY, LowZ, HighZ };

struct FitBoxLoad {
    std::string name{};
    Vec3d force_n{0, 0, -10};  ///< total force, spread evenly over the nodes
    BoxFace face = BoxFace::HighZ;
    double across = 0.5, along = 0.5;  ///< centre of the load on the face, 0…1 along its two axes
                                       ///< in their order
    std::int32_t nodes_across = 2;     ///< loaded nodes on either axis
    double weight = 1;
    bool held_out = false;
};

/// Partition of links and cells into groups.
enum class FitBoxGroups {
    Uniform,     ///< "links"
    Kinds,       ///< "edges", "face diagonals", "body diagonals"
    Directions,  ///< "edges x", …, "diagonals yz", …
};

struct FitBox {
    Vec3i size{10, 10, 10};
    Vec3d spacing_mm{100.0 / 9, 100.0 / 9, 100.0 / 9};
    double young_modulus_pa = 6e5;
    double poisson_ratio = 0.45;
    /// Fibres of the reference, see ElasticMaterial: the two constants above are then those across
    /// them. {0, 0, 0}: isotropic.
    Vec3d fibre{0, 0, 0};
    double fibre_young_modulus_pa = 0, fibre_poisson_ratio = 0, fibre_shear_modulus_pa = 0;
    double density_kg_per_m3 = 1040;
    HexElement element = HexElement::Trilinear;  ///< of the reference
    BoxFace held = BoxFace::LowZ;
    std::vector<FitBoxLoad> loads{};

    LatticeLinks links = LatticeLinks::EdgesAndFaces;
    FitBoxGroups groups = FitBoxGroups::Uniform;
    bool volume_energy = false;    ///< group "volume"
    bool shared_by_cells = false;  ///< see SpringLattice
    bool damping = false;          ///< group "damping", of the nodes
    double damping_start_kg_s = 1;
    double range = 10;  ///< bounds of the values: start/range and start·range
    FitSettings settings{};
};

struct FitBoxProblem {
    FitProblem problem;
    /// k = 0.4·E·a without volume energy; µa and λ − µ with it. a is the edge of a cube with a
    /// cell's volume. Methods start there. It is derived for cubic cells, and inaccurate for
    /// others. With fibres, E is Young's modulus along each link, averaged over its group: a start
    /// only.
    std::vector<double> closed_form;
    bool cubic_cells = true;  ///< whether spacings differ by less than 1 %
};

/// @returns InvalidArgument that names the field; Poisson's ratio must be above 1/4 for a volume
///          energy, and the constants of fibres need a positive energy
Result<FitBoxProblem> fit_box(const FitBox& box, const TaskArena& arena);

}  // namespace pliant
#pragma GCC visibility pop
