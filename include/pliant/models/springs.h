// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Tissue as a mass-spring network that moves in time steps, by force transmittal [Choi2004] or by
// one of two solvers of all nodes.
//
// @code
//   auto tissue = SpringTissue::create(std::move(*network), {.depth = 10});
//   tissue->load(std::array{55}, std::array{Vec3d{0, 0, -10}});  // the tool's force
//   tissue->step(100, arena);
//   Vec3d position = tissue->position(55);
// @endcode
//
// Force transmittal traverses the links breadth-first from the nodes in contact, to a depth of n
// layers. In each step only these nodes move, by central differences, layer by layer:
//
//   m (x⁺ − 2x + x⁻)/h² + d (x⁺ − x⁻)/2h = F − Σ f        [Choi2004, Eq. 5, 7, 8]
//
// The order is computed once per contact. docs/method/springs.md has the paper's open points, and
// the costs.

#pragma once

#include <pliant/core/record.h>
#include <pliant/core/tasks.h>
#include <pliant/core/vec.h>
#include <pliant/result.h>
#include <pliant/volume.h>

#include <array>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#pragma GCC visibility push(default)
namespace pliant {

// Mass-spring networks: point masses, and Voigt links between pairs of them.
//
// A link from i to j with r = x_i − x_j pulls node i with −f [Choi2004, Eq. 6],
//
//   f = ( stiffness · (|r| − rest_length) + damping · (v_i − v_j)·n + q ) n,     n = r/|r|
//
// with q the force of a Maxwell branch, a spring and a dashpot in series [Choi2004, 2.2, Fig. 1]:
//
//   dq/dt = branch_stiffness · d|r|/dt − q / branch_time
//
//   Voigt                 Maxwell              Kelvin (standard linear solid)
//   ──┬─/\/\─┬──          ──/\/\──┤▯──          ──┬───/\/\───┬──
//     └──┤▯──┘              k'    k'·τ            └─/\/\─┤▯──┘
//   no branch             stiffness 0          stiffness k, branch k', τ
//
// A node is also damped by −damping · v. A cell of four or eight nodes may have a volume energy, ½
// bulk · (V − V₀)²/V₀. Links alone obey Cauchy's relations for every stiffness, so they always have
// a Poisson's ratio of 1/4.
//
// Any consistent units apply. Pliant uses mm, g, s, with forces in µN and moduli in Pa. The figures
// of [Choi2004] use m, kg, s, with forces in N.

struct SpringNode {
    Vec3d rest{0, 0, 0};
    double mass = 1;
    double damping = 0;  ///< force per velocity of the node itself
    bool fixed = false;  ///< never moves
};

struct SpringLink {
    std::int32_t a, b;
    double stiffness = 1;  ///< force per length
    double damping = 0;    ///< force per velocity along the link
    /// Negative: the distance at rest.
    double rest_length = -1;
    double branch_stiffness = 0;  ///< force per length of a Maxwell branch; 0: none
    double branch_time = 0;       ///< time in which the branch's force falls to 1/e; above 0
};

/// A tetrahedron of four nodes with positive volume (n1−n0)×(n2−n0)·(n3−n0)/6, or a hexahedron of
/// eight: n0…n3 around its bottom, n4…n7 above them, as in VTK.
///
///       7────6
///      ╱│   ╱│
///     4────5 │
///     │ 3──│─2
///     │╱   │╱
///     0────1
struct SpringCell {
    std::array<std::int32_t, 8> nodes{};
    std::int32_t node_count = 8;  ///< 4 or 8
    double bulk = 0;              ///< modulus of the volume energy; 0: none
};

/// Parts of a network, from a builder (springs.h). They may be changed before the network
/// is created.
struct SpringParts {
    std::vector<SpringNode> nodes;
    std::vector<SpringLink> links;
    std::vector<SpringCell> cells;
};

/// Connectivity after a cut.
struct SpringCut {
    std::int64_t cut_links = 0, cut_cells = 0;  ///< by this call
    std::int32_t pieces = 1;                    ///< connected components of the network
    std::int32_t loose_nodes = 0;               ///< in pieces without a fixed node
};

/// Thread safety: immutable.
class SpringNetwork {
  public:
    /// @returns InvalidArgument that names the node, link or cell: a mass that isn't above 0, a
    ///          negative stiffness, damping or bulk, a node that doesn't exist, a cell without
    ///          volume, or nodes that aren't connected to node 0
    static Result<SpringNetwork> create(SpringParts parts) noexcept;

    std::int32_t node_count() const { return std::int32_t(m_parts.nodes.size()); }
    std::span<const SpringNode> nodes() const { return m_parts.nodes; }
    /// Links in the order of the parts, with computed rest lengths.
    std::span<const SpringLink> links() const { return m_parts.links; }
    std::span<const SpringCell> cells() const { return m_parts.cells; }
    bool is_cut(std::size_t link) const { return m_link_cut[link]; }
    bool is_cell_cut(std::size_t cell) const { return m_cell_cut[cell]; }
    bool has_volume_energy() const { return m_has_volume_energy; }
    bool has_branches() const { return m_has_branches; }

    /// A link seen from one of its ends. 8 bytes.
    struct Neighbour {
        std::int32_t node, link;
    };
    /// Neighbours over uncut links, by ascending node.
    std::span<const Neighbour> neighbours(std::int32_t node) const {
        const auto n = std::size_t(node);
        return {m_neighbours.data() + m_first[n], m_neighbours.data() + m_end[n]};
    }
    /// Cells of a node, including cut ones.
    std::span<const std::int32_t> cells_of(std::int32_t node) const {
        const auto n = std::size_t(node);
        return {m_cells_of.data() + m_first_cell[n], m_cells_of.data() + m_first_cell[n + 1]};
    }

    /// Stability bound of central differences near the rest shape: h²λ + 2hγ ≤ 4 [Courant1928],
    /// where λ and γ bound the eigenvalues of M⁻¹K and of M⁻¹C, C the damping of links. It is
    /// independent of the nodes' own damping. A Maxwell branch counts with its whole stiffness.
    /// Exact for a chain; for lattices within a few percent of the first unstable step.
    double stable_time_step() const;

    /// Cuts links, and the volume energy of all cells that have one of them as an edge or diagonal.
    /// Links that are already cut stay cut.
    /// @returns InvalidArgument for a link that doesn't exist, LimitExceeded if memory runs out;
    ///          then nothing is cut
    Result<SpringCut> cut_links(std::span<const std::int32_t> links) noexcept;
    /// Cuts cells out: their volume energy, and all links that lie in no other cell.
    Result<SpringCut> cut_cells(std::span<const std::int32_t> cells) noexcept;

  private:
    struct PieceMemory;
    void index();
    void drop_cut_neighbours(std::int32_t node);
    void cut_link(std::size_t link, SpringCut& cut);
    void cut_cell(std::size_t cell, SpringCut& cut);
    SpringCut cut_out(std::span<const std::int32_t> cells);
    void count_pieces(SpringCut& cut, PieceMemory& memory) const;

    SpringParts m_parts;
    std::vector<std::int64_t> m_first, m_end, m_first_cell;  ///< offsets of each node
    std::vector<Neighbour> m_neighbours;
    std::vector<std::int32_t> m_cells_of;
    std::vector<std::uint8_t> m_link_cut, m_cell_cut;
    bool m_has_volume_energy = false, m_has_branches = false;
};

/// Masses that were raised for a longer time step.
struct RaisedMasses {
    std::int64_t nodes = 0;  ///< with a raised mass
    double share = 0;        ///< added mass, relative to the mass of all nodes before
};
/// Raises the mass of each free node to (h²λ + 2hγ)/4, where it is lower, with λ and γ the bounds
/// of its stiffness and damping in SpringNetwork::stable_time_step. Thin cells of a mesh have
/// light, stiff nodes that would determine the step of all. Equilibria don't depend on masses; the
/// raised nodes move more slowly.
/// @param time_step  to become stable, [time], above 0
/// @returns InvalidArgument for the time step, and every error of SpringNetwork::create
Result<RaisedMasses> raise_masses(SpringParts& parts, double time_step) noexcept;

// Networks from lattices, meshes and scans.
//
// @code
//   auto parts = springs_of_lattice({.size = {10, 10, 10}, .stiffness = {2575, 2575, 2575}});
//   for (int n = 0; n < 100; ++n) parts->nodes[n].fixed = true;   // the bottom layer
//   auto network = SpringNetwork::create(std::move(*parts));
// @endcode
//
// For an isotropic material with Lamé constants λ and µ: a cubic lattice of spacing a, with edges
// and face diagonals of stiffness k, has C₁₂ = C₄₄ = k/a. So k = µa, and the volume energy adds the
// rest of λ: bulk = λ − µ (closed_form).

enum class LatticeLinks {
    Edges,             ///< 6 neighbours: no resistance to shear
    EdgesAndFaces,     ///< 18: edges and face diagonals
    EdgesFacesAndBody  ///< 26: edges, face and body diagonals
};

/// Stiffness and bulk modulus for a cubic lattice with edges and face diagonals.
struct SpringMaterial {
    double stiffness, bulk;
};
/// Computes k = µa and λ − µ. Below a Poisson's ratio of 1/4 the bulk is negative, which a network
/// refuses.
SpringMaterial closed_form(double young_modulus, double poisson_ratio, double spacing);

struct SpringLattice {
    Vec3i size{2, 2, 2};  ///< nodes along x, y, z; i fastest
    Vec3d spacing{1, 1, 1};
    LatticeLinks links = LatticeLinks::EdgesAndFaces;
    Vec3d stiffness{1, 1, 1};  ///< along x, y, z; a link along n has Σ n_a² stiffness_a
    double link_damping = 0, node_damping = 0;
    double node_mass = 1;
    double density = 0;  ///< above 0: masses are computed from the cells around a node
    double bulk = 0;     ///< of each cell
    /// Each cell has separate springs: a link in c of its possible cells has that share of its
    /// stiffness. A free surface is then as soft as the inside.
    bool shared_by_cells = false;
};
Result<SpringParts> springs_of_lattice(const SpringLattice& lattice) noexcept;

/// Equilateral triangles with six neighbours inside [Choi2004, Fig. 3], in the plane z = 0. Every
/// second row is shifted by half a spacing.
struct SpringSheet {
    std::int32_t columns = 2, rows = 2;
    double spacing = 1, stiffness = 1, link_damping = 0, node_damping = 0, node_mass = 1;
};
Result<SpringParts> springs_of_sheet(const SpringSheet& sheet) noexcept;

/// Properties of all nodes and links of a mesh.
struct SpringMesh {
    double stiffness = 1, link_damping = 0, node_damping = 0, node_mass = 1, density = 0;
    double bulk = 0;  ///< of each cell
};
/// Makes one link per edge. Surfaces have no density: node_mass applies.
Result<SpringParts> springs_of_triangles(std::span<const Vec3d> nodes,
                                         std::span<const std::array<std::int32_t, 3>> triangles,
                                         const SpringMesh& mesh) noexcept;
/// Makes one link per edge.
Result<SpringParts> springs_of_tetrahedra(std::span<const Vec3d> nodes,
                                          std::span<const std::array<std::int32_t, 4>> tetrahedra,
                                          const SpringMesh& mesh) noexcept;
/// Makes one link per edge, with mesh.stiffness as a shear modulus: the stiffness of a link is
/// (√2/5)·length·modulus, summed over the edge's tetrahedra. Exact for regular tetrahedra at
/// Poisson's ratio 1/4 [Lloyd2007], where it is (2√2/25)·E·length.
Result<SpringParts> springs_of_elastic_tetrahedra(
    std::span<const Vec3d> nodes, std::span<const std::array<std::int32_t, 4>> tetrahedra,
    const SpringMesh& mesh) noexcept;
/// Makes one link per edge and face diagonal of the hexahedra.
Result<SpringParts> springs_of_hexahedra(std::span<const Vec3d> nodes,
                                         std::span<const std::array<std::int32_t, 8>> hexahedra,
                                         const SpringMesh& mesh) noexcept;

/// Tissue of some voxels of a scan. Empty: as for voxels without a tissue of their own.
struct SpringOrgan {
    std::optional<double> young_modulus_pa{};
    std::optional<double> poisson_ratio{};
    /// Voxels with a larger value are hard; −∞: all of them, ∞: none.
    std::optional<double> fixed_hu{};
};

/// A control lattice over a part of a scan [Choi2004, 4.2.2]. Nodes have world positions [mm, LPS]
/// and properties from the mean voxel value around them. Units: mm, g, s.
struct SpringScan {
    Box3i region{};          ///< voxels; empty: the whole scan
    Vec3i size{10, 10, 10};  ///< nodes along i, j, k; the outermost lie on the region's border
    LatticeLinks links = LatticeLinks::EdgesAndFaces;
    double fixed_hu = 300;  ///< nodes with a larger value are fixed
    /// Cells with a larger share of such voxels have fixed nodes, so that thin bones keep their
    /// position. 1: only the nodes' own values count.
    double fixed_share = 0.05;
    bool fixed_border = true;  ///< the outermost nodes are fixed
    /// Young's modulus at a value; empty: 15 kPa, and 1 % of it in air, below −500 HU. The
    /// stiffness of a link is 0.4·E·a with the mean E of its ends; a is the edge of a cube with a
    /// cell's volume.
    std::function<double(double hu)> young_modulus_pa{};
    /// Poisson's ratio at a value, from 0.25, below 0.5; empty: 1/4, that of links alone. Above 1/4
    /// a link takes µ·a, and a cell the volume energy λ − µ, means of their nodes (closed_form).
    std::function<double(double hu)> poisson_ratio{};
    /// See SpringLattice; it matters where the outermost nodes are free.
    bool shared_by_cells = false;
    /// Tissues whose properties don't follow from the values, such as labelled organs. A node takes
    /// the mean of the voxels around it.
    std::vector<SpringOrgan> organs{};
    /// Index of a voxel's organ, −1: none. Required by organs.
    std::function<int(Vec3i ijk)> organ_at{};
    double node_damping = 0;       ///< g/s
    double density_g_mm3 = 0.001;  ///< of all nodes, in air too: it determines the time step
};
Result<SpringParts> springs_of_scan(const Volume& volume, const SpringScan& scan) noexcept;

enum class SpringSolver {
    ForceTransmittal,  ///< the nodes within `depth` layers of the contact
    Explicit,          ///< all nodes by central differences
    ImplicitEuler,     ///< all nodes; backward Euler by conjugate gradients [Baraff1998]
};

struct SpringSettings {
    SpringSolver solver = SpringSolver::ForceTransmittal;
    std::int32_t depth = 10;  ///< layers beyond the contact
    /// 0: 90 % of the stability bound. ImplicitEuler takes any step.
    double time_step = 0;
    bool vectors = true;            ///< vector instructions; the scalar code gives the same bits
    double solve_tolerance = 1e-8;  ///< ImplicitEuler: relative residual
    std::int32_t solve_iterations = 1000;
    /// ImplicitEuler: an assembled matrix of single precision with a coarse space. The equilibria
    /// are the same. Made for whole organs: a step takes a fraction of the time, and the first one
    /// some tenths of a second longer.
    bool assembled = false;
};
SettingRows<SpringSettings> spring_solver_rows() noexcept;

struct SpringStep {
    std::int64_t steps = 0;
    std::int32_t active_nodes = 0;  ///< nodes that could move
    std::int64_t iterations = 0;    ///< of conjugate gradients
};

/// Force of the tissue on the tool, and its linearisation in a common shift of the touched nodes:
/// force(shift) ≈ force + stiffness · shift.
struct SpringReaction {
    Vec3d force{0, 0, 0};
    Mat3d stiffness{};  ///< symmetric, negative definite or 0
};
enum class ReactionLaw {
    Held,     ///< the other nodes are held: exact within a step, too stiff later
    Relaxed,  ///< the other nodes follow to their equilibrium (to first order)
};

/// Nodes in the order in which forces reach them.
struct TransmittalOrder {
    std::vector<std::int32_t> nodes;
    std::vector<std::int32_t> layers;  ///< first node of each layer, and the total
};
/// Breadth-first order from all sources at once; layers of equal distance are merged [Choi2004,
/// 3.1.6]. Fixed nodes transmit no force and are left out.
/// @returns InvalidArgument for a source that doesn't exist or is fixed, or a negative depth
Result<TransmittalOrder> transmittal_order(const SpringNetwork& network,
                                           std::span<const std::int32_t> sources,
                                           std::int32_t depth) noexcept;

/// If memory runs out, calls return LimitExceeded and the tissue is unchanged.
/// Thread safety: concurrent reads.
class SpringTissue {
  public:
    /// @returns InvalidArgument that names the setting; for a time step beyond the stability bound
    ///          it names the bound
    static Result<SpringTissue> create(SpringNetwork network,
                                       const SpringSettings& settings) noexcept;
    ~SpringTissue();
    SpringTissue(SpringTissue&&) noexcept;
    SpringTissue& operator=(SpringTissue&&) noexcept;

    const SpringNetwork& network() const;
    double time_step() const;

    /// Replaces the loads. Force transmittal starts at these nodes.
    /// @returns InvalidArgument for a node that doesn't exist, is fixed or occurs twice, or a force
    ///          that isn't finite
    Status load(std::span<const std::int32_t> nodes, std::span<const Vec3d> forces) noexcept;
    /// Replaces the nodes that a tool holds: only move_held moves them.
    Status hold(std::span<const std::int32_t> nodes) noexcept;
    /// @param positions  of the held nodes, in the order of hold()
    Status move_held(std::span<const Vec3d> positions) noexcept;
    /// Shifts all held nodes.
    Status shift_held(Vec3d shift) noexcept;
    /// Sets the number of layers that forces reach.
    Status set_depth(std::int32_t depth) noexcept;

    /// Advances by `count` time steps. Nodes that are no longer reached stay at their positions, at
    /// rest.
    /// @returns InvalidArgument if the distorted shape makes the time step unstable: one line with
    ///          the new bound. The last step is undone
    Result<SpringStep> step(std::int32_t count, const TaskArena& arena) noexcept;

    /// Finds a static equilibrium of the active nodes: minimises the energy by Newton's method with
    /// a trust region; velocities and the forces of Maxwell branches become 0. Large loads may push
    /// nodes through the lattice into a folded equilibrium: see folded_cells().
    /// @param tolerance  largest remaining force on a node, relative to the largest load or
    ///                   reaction; clamped to the rounding error
    /// @param give_up    polled in each iteration; may be empty
    /// @returns LimitExceeded if it isn't reached, or give_up returned true: then nothing has
    ///          changed
    Status find_equilibrium(double tolerance = 1e-9,
                            const std::function<bool()>& give_up = {}) noexcept;

    Vec3d position(std::int32_t node) const;
    Vec3d velocity(std::int32_t node) const;
    Vec3d displacement(std::int32_t node) const;
    std::vector<Vec3d> displacements() const;
    /// Sets a node's state, for initial conditions.
    Status set_state(std::int32_t node, Vec3d position, Vec3d velocity) noexcept;

    /// Computes −Σ over the nodes of Σ f over their links, plus the force of the volume energy
    /// [Choi2004, Eq. 19].
    Result<SpringReaction> reaction(std::span<const std::int32_t> nodes, ReactionLaw law) noexcept;

    /// Number of cells with an inverted corner. Springs alone resist inversion weakly, so a cell
    /// may snap through and stay inverted.
    std::int64_t folded_cells() const;
    /// Energy of links, their branches, and volumes.
    double elastic_energy() const;
    double kinetic_energy() const;
    Vec3d momentum() const;

    Result<SpringCut> cut_links(std::span<const std::int32_t> links) noexcept;
    Result<SpringCut> cut_cells(std::span<const std::int32_t> cells) noexcept;

    /// Hash of all positions, equal for any number of threads.
    std::uint64_t hash() const noexcept;
    /// Returns all nodes to their rest positions; loads and held nodes stay.
    void reset() noexcept;

  private:
    friend class SpringRollback;
    struct Impl;
    explicit SpringTissue(std::unique_ptr<Impl> impl);
    std::unique_ptr<Impl> m_impl;
};

/// A sphere that triangles touch: of a tool, or of an eye.
struct TouchTool {
    Vec3d position{0, 0, 0};
    double radius = 0;
    /// In contact, ascending. Contact doesn't allocate if there is room for all triangles.
    std::vector<std::int32_t> triangles{};
};

/// Search for the necessary depth [Choi2004, 3.1.3]: raises the depth by one layer until the shape
/// changes by less than the threshold.
struct DepthSearch {
    double threshold = 0.01;  ///< of the largest change of a node's position, absolute (a length)
    std::int32_t max_depth = 64;
    /// Simulated time per depth; 0: until the reached nodes are in equilibrium. In a given time,
    /// forces travel farther in a stiffer network.
    double duration = 0;
};
struct DepthFound {
    std::int32_t depth = 0;       ///< 0: not found up to max_depth
    std::vector<double> changes;  ///< [n]: from n to n + 1 layers
};
Result<DepthFound> find_depth(const SpringNetwork& network, const SpringSettings& settings,
                              std::span<const std::int32_t> nodes, std::span<const Vec3d> forces,
                              const DepthSearch& search, const TaskArena& arena) noexcept;

}  // namespace pliant
#pragma GCC visibility pop
