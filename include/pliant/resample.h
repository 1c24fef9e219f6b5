// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Resampling of the deformed lattice to the grid.
//
// The new value at grid point p is the original scan's value at φ⁻¹(p), where φ(X) = X + u(X). The
// source is always the original, so repeated pushes don't blur.
//
// If memory runs out, functions return LimitExceeded.

#pragma once

#include <pliant/deformation.h>
#include <pliant/volume.h>

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#pragma GCC visibility push(default)
namespace pliant {

/// Methods to find φ⁻¹ inside a deformed cell.
enum class Mapping {
    Cells,        ///< inverse of the cell's trilinear map, vectorised; the value is trilinear too
    CellsScalar,  ///< the same in double precision, voxel by voxel: the readable reference
    Tetrahedra,   ///< twelve tetrahedra, barycentric [Draeger2005, 3.6.3]: the reference
};

struct Deformed {
    Volume volume;  ///< on the original's grid, with its key/value pairs
    /// Smallest box around all written voxels; empty if nothing moved inside of the scan.
    Box3i dirty_box;
    std::int64_t written_voxels = 0;
    std::int64_t gap_voxels = 0;  ///< written voxels that no cell covers, filled with air
    double resample_ms = 0;
    /// φ⁻¹(p) − p [mm, LPS] for the voxels of dirty_box, i fastest; zero at rest. Empty unless
    /// requested.
    std::vector<Vec3f> inverse_mm;
};

/// Writes the deformed scan. The same bits for any number of threads.
Result<Deformed> deform_volume(const MovingScan& scan, Mapping mapping = Mapping::Cells,
                               bool with_inverse = false) noexcept;

/// Puts a label map on a grid, wherever its own voxels are: each voxel takes the value of the map's
/// nearest one, and 0 beyond the map. A map that is on the grid, to 0.01 voxels, stays as it is.
/// @returns InvalidArgument if no label is on the grid
Result<Volume> labels_on(const Volume& labels, const Grid& grid, const TaskArena& arena) noexcept;
/// Moves a label map with the scan: labels'(p) = labels(φ⁻¹(p)) on the scan's grid, by labels_on; 0
/// in gaps and beyond the scan. @pre deformed is the scan's, made with_inverse
Result<Volume> deform_labels(const MovingScan& scan, const Deformed& deformed,
                             const Volume& labels) noexcept;

/// Result of one update of a LiveDeformation.
struct LiveUpdate {
    /// Boxes of voxels that may have changed: whole bricks of the lattice, clipped to the scan,
    /// with neighbours along i joined. Valid until the next update.
    std::span<const Box3i> boxes;
    /// Smallest box around all computed voxels; empty if there are none.
    Box3i dirty_box;
    std::int64_t written_voxels = 0;  ///< computed voxels, without those restored to their rest
                                      ///< value
    std::int64_t gap_voxels = 0;      ///< computed voxels that no cell covers, filled with air
    double resample_ms = 0;
    bool is_complete = true;  ///< whether the volume shows the tissue's present state
};

/// Incrementally updated deformed scan.
///
/// @code
///   Result<LiveDeformation> live = LiveDeformation::create(tissue);
///   tissue.push({.point_mm = point, .push_mm = {5, 0, 0}});
///   if (const Result<LiveUpdate> update = live->update())
///       for (const Box3i& box : update->boxes) show(live->volume(), box);
/// @endcode
///
/// The first update writes all deformed voxels. Each later one writes only the voxels that changed
/// cells have left or entered. After any number of updates, the volume is bit-identical to
/// deform_volume(tissue). An update doesn't allocate unless the deformation is the largest so far.
///
/// After a failed update, the volume is in an intermediate state. The next successful update writes
/// all deformed voxels, and its boxes contain all voxels that were or are deformed.
/// Thread safety: concurrent reads.
class LiveDeformation {
  public:
    /// Copies the scan, and keeps a reference: the tissue must outlive it, or start_over().
    static Result<LiveDeformation> create(const MovingScan& scan) noexcept;
    /// The same, with the deformed scan in a volume of the caller, such as one of
    /// VoxelArray::viewed. Its voxels are overwritten by the scan's.
    /// @returns InvalidArgument if it doesn't have the scan's size and type of voxels
    static Result<LiveDeformation> create(const MovingScan& scan, Volume target) noexcept;
    ~LiveDeformation();
    LiveDeformation(LiveDeformation&&) noexcept;
    LiveDeformation& operator=(LiveDeformation&&) noexcept;

    Result<LiveUpdate> update() noexcept;
    /// Updates the volume to a state near the tissue's; see MovingScan::approach_deformation. Call
    /// it until it is complete, or update().
    Result<LiveUpdate> approach(std::int64_t max_elements) noexcept;
    /// Restores the scan's voxels, and goes on with another tissue of the same scan. The boxes of
    /// the next update also contain the restored voxels.
    void start_over(const MovingScan& scan) noexcept;
    const Volume& volume() const;

    /// Switches the storage of each voxel's source position for future updates: twelve bytes per
    /// voxel of the scan, resident for voxels that were ever deformed. Switching on rewrites all
    /// deformed voxels with the same values.
    /// @pre nothing has changed since the last update
    /// @returns whether sources are kept; false if memory is lacking
    bool keep_sources(bool keep) noexcept;
    bool keeps_sources() const;
    /// φ⁻¹(p) − p at a voxel p [mm, LPS]; 0 at rest, and in gaps. @pre keeps_sources()
    Vec3f source_offset_mm(Vec3i voxel) const;
    /// The source of this deformation.
    const MovingScan& scan() const;

    // Fields at the voxels p of a box, i fastest. @pre keeps_sources(), and
    // nothing has changed since the last update. @param[out] values  one per voxel

    /// Displacement |p − φ⁻¹(p)| [mm]; 0 at rest, and in gaps.
    void displacement_mm(const Box3i& box, std::span<float> values) const;
    /// Volume ratio det ∂φ/∂X at φ⁻¹(p), of the trilinear map of the cell around p. 1 at rest and
    /// in gaps; negative in folded space.
    void jacobian(const Box3i& box, std::span<float> values) const;

  private:
    struct Impl;
    explicit LiveDeformation(std::unique_ptr<Impl> impl);
    std::unique_ptr<Impl> m_impl;
};

/// Forward displacement at every rest voxel centre of the scan.
Result<VectorField> displacement_field(const MovingScan& scan) noexcept;

/// Inverse displacement on the whole grid, as resampling filters expect.
/// @pre deformed was made with_inverse
Result<VectorField> inverse_field(const Deformed& deformed) noexcept;

/// The same fields slice by slice, for write_vector_field. They keep references: tissue and
/// deformed must outlive them unchanged.
Result<FieldSlices> displacement_slices(const MovingScan& scan) noexcept;
FieldSlices inverse_slices(const Deformed& deformed) noexcept;

/// Trilinear interpolation of a field [mm, LPS]; zero beyond the outermost voxel centres.
Vec3d sample_field(const VectorField& field, Vec3d point_mm);

/// Resamples a volume by an inverse field: out(p) = volume(p + field(p)), trilinear, on the field's
/// grid. Values of 16 bits are rounded.
/// @returns InvalidArgument for a field of kind Modeling
Result<Volume> apply_field(const VectorField& field, const Volume& volume,
                           const TaskArena& arena) noexcept;

/// det(I + ∂u/∂X) of a field u alone, from central differences along the grid's axes, one-sided at
/// its border. jacobian_field of a tissue also knows its cuts.
/// @returns float, dimensionless: 1 at rest
Result<Volume> jacobian_field(const VectorField& field) noexcept;

/// Local growth of the tissue at each rest voxel centre: det F with F = I + ∂u/∂X, from central
/// differences along the lattice's axes, one-sided beside a cut link or a void element.
/// @returns float, dimensionless: 1 at rest and at void elements, below 0 where space is inverted
Result<Volume> jacobian_field(const MovingScan& scan) noexcept;

/// Largest principal stretch: the largest eigenvalue of the Green–Lagrange strain E = ½(FᵀF − I), F
/// as above.
/// @returns float, dimensionless: 0 at rest and at void elements
Result<Volume> strain_field(const MovingScan& scan) noexcept;

/// Hash of all voxels and the grid's size, for comparisons of results.
std::uint64_t hash_volume(const Volume& volume);

// A scan embedded in a coarse lattice of control nodes [Choi2004, 4.2.2]. Every voxel keeps its
// local coordinates in the cell that holds it at rest, and moves with the cell's eight nodes.
//
//     o---------o---------o      o control nodes, on voxel centres, `cell` voxels apart
//     | . . . . | . . . . |      . voxels: u = Σ (trilinear weight) · (displacement of the node)
//     | . . . . | . . . . |
//     o---------o---------o
//
// The model that moves the nodes is independent of this class. The nodes' displacements are written
// to a lattice of the scan's elements; from there the volume, its fields and pictures come as with
// ChainMail. This conversion is exact: a control cell is a whole number of voxels long, so each
// voxel cell lies in one control cell, and the trilinear map of the large cell is that of the small
// one.

struct ControlGrid {
    Vec3i first{0, 0, 0};  ///< voxel of node 0
    Vec3i cell{8, 8, 8};   ///< voxels from one node to the next
    Vec3i size{2, 2, 2};   ///< nodes along i, j, k; i fastest
};

/// Material point: a control cell and local coordinates in it.
struct ControlPosition {
    std::array<std::int32_t, 8> nodes{};  ///< corner c is at + (c & 1, c >> 1 & 1, c >> 2)
    Vec3d at{0, 0, 0};                    ///< local coordinates, 0…1 along i, j, k
};

/// A triangle of a cut: its corners at rest [mm, LPS].
using CutTriangle = std::array<Vec3d, 3>;

/// Thread safety: one thread.
class ControlLattice : public MovingScan {
  public:
    /// Keeps references: volume and arena must outlive it.
    /// @returns InvalidArgument if a node lies outside of the scan
    static Result<std::unique_ptr<ControlLattice>> create(const Volume& volume,
                                                          const ControlGrid& grid,
                                                          const TaskArena& arena) noexcept;
    ~ControlLattice() override;

    /// Moves the elements with the nodes. Visits only cells with a node that moved since the last
    /// call. Voxels outside of the control lattice never move.
    /// @param displacements_mm  of all nodes [mm, LPS]
    /// @returns InvalidArgument if a displacement isn't finite or exceeds 500 mm along an axis,
    ///          LimitExceeded if memory runs out; then nothing has changed
    Status place(std::span<const Vec3d> displacements_mm) noexcept;
    /// Likewise, but moves only nodes that lag by more than least_mm along an axis, in blocks of
    /// 4³, those with the largest lag first, until the cells around them have max_elements. With
    /// cuts it moves all nodes.
    /// @returns whether all nodes have these displacements
    Result<bool> approach(std::span<const Vec3d> displacements_mm, std::int64_t max_elements,
                          double least_mm) noexcept;

    /// Replaces all cuts. Links of elements that a triangle crosses are cut. In the crossed cells
    /// an element follows the nodes that it sees, and takes the displacement of a hidden one from
    /// the nodes beside it on the element's side. Nodes keep their displacements.
    /// @returns InvalidArgument for a corner that isn't finite or far away, LimitExceeded if memory
    ///          runs out; then nothing has changed
    Status set_cuts(std::span<const CutTriangle> triangles_mm) noexcept;
    std::span<const CutTriangle> cuts_mm() const;
    /// Whether a cut passes between two points at rest [mm, LPS].
    bool is_cut(Vec3d from_mm, Vec3d to_mm) const;

    /// Material point at a position in the deformed scan [mm, LPS]. The first cell wins if cells
    /// overlap.
    std::optional<ControlPosition> find(Vec3d point_mm) const;
    /// Likewise, at other displacements of all nodes [mm, LPS] than those that were placed.
    std::optional<ControlPosition> find(Vec3d point_mm,
                                        std::span<const Vec3d> displacements_mm) const;
    /// Whether some control cell is folded or nearly so: at one of its corners, less than `share`
    /// of the volume is left. @pre as many displacements as nodes
    bool folds(std::span<const Vec3d> displacements_mm, double share = 0) const;

    const ControlGrid& grid() const;
    std::int32_t node_count() const;
    Vec3d node_mm(std::int32_t node) const;  ///< rest position [mm, LPS]

    const Volume& volume() const override;
    const Deformation& deformation() const override;
    const TaskArena& arena() const override;

  private:
    struct Impl;
    explicit ControlLattice(std::unique_ptr<Impl> impl);
    std::unique_ptr<Impl> m_impl;
};

// Coarse field of rest positions in a deformed scan. Patterns on a wall (vessels, folds) use it to
// move, stretch and be cut with the tissue.
//
//   position at rest = position − offset      offset(p) = p − φ⁻¹(p), φ from rest to deformed
//
//     voxels   0 1 2 3 4 5 6 7 8 9        nodes at every 4th voxel of the deformed scan; the last
//     nodes    0       1       2       3  one may lie beyond the border, and has the value of the
//                                         border's voxel
//
// A node holds four half floats: the offset [mm, LPS], and whether the tissue is raw (carved or cut
// open). That is 8 bytes for 64 voxels. A field at rest has no memory.

/// Spacing of the nodes [voxels].
inline constexpr int kRestStep = 4;
/// Tissue is raw up to two voxels from a carved element or a cut link. The rawness fades out up to
/// this distance [voxels at rest].
inline constexpr double kRawReach = 6;

/// Thread safety: concurrent reads.
class RestField {
  public:
    struct Sample {
        Vec3f offset_mm{0, 0, 0};  ///< LPS; position at rest = position − offset
        float raw = 0;             ///< 0…1: 1 at carved or cut tissue
    };

    RestField() = default;
    /// Creates a field at rest.
    explicit RestField(const Grid& grid);

    /// Creates the field of a scan after a complete deformation.
    /// @param deformed  deform_volume(scan, …, with_inverse = true)
    /// @returns InvalidArgument if it has no inverse or another grid; LimitExceeded
    static Result<RestField> create(const MovingScan& scan, const Deformed& deformed) noexcept;

    /// Follows an update. The result is bit-identical to a new field.
    ///
    /// @code
    ///   live.keep_sources(true);
    ///   auto rest = RestField::create(tissue, *deform_volume(tissue, Mapping::Cells, true));
    ///   const Result<LiveUpdate> update = live.update();  // after a push
    ///   rest->update(live, update->boxes);
    /// @endcode
    ///
    /// Call it after each update of live, even one without boxes: a closed cut changes no voxel,
    /// but its tissue is raw. Another tissue of the same scan needs a new field.
    /// @pre live.keeps_sources()
    /// @param boxes  disjoint boxes of voxels that may have changed since the last call
    /// @returns boxes of changed nodes, valid until the next call; LimitExceeded, after which a new
    ///          field is needed
    Result<std::span<const Box3i>> update(const LiveDeformation& live,
                                          std::span<const Box3i> boxes) noexcept;

    const Grid& grid() const { return m_grid; }
    /// Nodes along each axis: ⌈(size − 1) / kRestStep⌉ + 1.
    Vec3i counts() const { return m_counts; }
    /// Whether every node is zero.
    bool at_rest() const { return m_halves.empty(); }
    /// Interpolates trilinearly between nodes, constant beyond them. @param ijk  voxels of the
    /// deformed scan
    Sample at(Vec3d ijk) const;
    /// Four half floats (IEEE 754 binary16) per node, i fastest: x, y, z of the offset, raw. Empty
    /// at rest.
    std::span<const std::uint16_t> halves() const { return m_halves; }
    /// Copies the halves of a box of nodes; zeros at rest. @param[out] halves  four per node
    void copy(const Box3i& nodes, std::span<std::uint16_t> halves) const;

  private:
    class Writer;
    std::size_t index(Vec3i node) const {
        return 4 * (std::size_t(node.x) +
                    std::size_t(m_counts.x) *
                        (std::size_t(node.y) + std::size_t(m_counts.y) * std::size_t(node.z)));
    }

    Grid m_grid;
    Vec3i m_counts{0, 0, 0};
    std::vector<std::uint16_t> m_halves;
    std::int64_t m_moved = 0;                           ///< nodes other than zero
    std::uint64_t m_links_version = ~std::uint64_t(0);  ///< of the lattice, at the last update
    bool m_had_edits = false;                           ///< likewise: there were cuts or carvings
    std::vector<Box3i> m_boxes;
};

/// Number of nodes in a box of them.
constexpr std::int64_t node_count(const Box3i& nodes) {
    const Vec3i n = nodes.end - nodes.begin;
    return std::int64_t(n.x) * n.y * n.z;
}

}  // namespace pliant
#pragma GCC visibility pop
