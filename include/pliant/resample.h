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

#include <cstdint>
#include <memory>
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
};

/// Incrementally updated deformed scan.
///
///   Result<LiveDeformation> live = LiveDeformation::create(tissue);
///   tissue.push(…);
///   if (const Result<LiveUpdate> update = live->update())
///       for (const Box3i& box : update->boxes) show(live->volume(), box);
///
/// The first update writes all deformed voxels. Each later one writes only the voxels that changed
/// cells have left or entered. After any number of updates, the volume is bit-identical to
/// deform_volume(tissue). An update doesn't allocate unless the deformation is the largest so far.
///
/// After a failed update, the volume is in an intermediate state. The next successful update writes
/// all deformed voxels, and its boxes contain all voxels that were or are deformed.
class LiveDeformation {
  public:
    /// Copies the scan, and keeps a reference: the tissue must outlive it, at the same address.
    static Result<LiveDeformation> create(const MovingScan& scan) noexcept;
    /// The same, with the deformed scan in a volume of the caller, such as one of
    /// VoxelArray::viewed. Its voxels are overwritten by the scan's.
    /// @returns InvalidArgument if it doesn't have the scan's size and type of voxels
    static Result<LiveDeformation> create(const MovingScan& scan, Volume target) noexcept;
    ~LiveDeformation();
    LiveDeformation(LiveDeformation&&) noexcept;
    LiveDeformation& operator=(LiveDeformation&&) noexcept;

    Result<LiveUpdate> update() noexcept;
    /// Restores the scan's voxels and discards the state of the tissue. Another tissue may then
    /// replace it before the next update, whose boxes also contain the restored voxels.
    void start_over() noexcept;
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

}  // namespace pliant
#pragma GCC visibility pop
