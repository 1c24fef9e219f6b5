// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// From the deformed lattice back to the grid.
//
// The new value at grid point p is the original scan's value at φ⁻¹(p), where φ(X) = X + u(X). It
// is always the original that is read, so repeated pushes don't blur.
//
// Where memory runs out, functions return LimitExceeded.

#pragma once

#include <pliant/chainmail.h>
#include <pliant/volume.h>

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#pragma GCC visibility push(default)
namespace pliant {

/// A scan whose elements move, whatever moves them: all that the resampler asks of a tissue.
class MovingScan {
  public:
    virtual ~MovingScan() = default;
    virtual const Volume& volume() const = 0;  ///< at rest
    virtual const Lattice& lattice() const = 0;
    virtual const TaskArena& arena() const = 0;
    /// Moves the elements to where the tissue is now, if they don't follow it all the time.
    virtual Status update_lattice() const { return Ok{}; }
};

/// ChainMail's elements. Keeps a reference.
class ChainMailScan : public MovingScan {
  public:
    explicit ChainMailScan(const ChainMail& tissue) : m_tissue(tissue) {}
    const Volume& volume() const override { return m_tissue.volume(); }
    const Lattice& lattice() const override { return m_tissue.lattice(); }
    const TaskArena& arena() const override { return m_tissue.arena(); }

  private:
    const ChainMail& m_tissue;
};

/// How φ⁻¹ is found inside a deformed cell.
enum class Mapping {
    Cells,  ///< the trilinear map of the whole cell, inverted in vectors; the value is trilinear
            ///< too
    CellsScalar,  ///< the same in double precision, one voxel at a time: its readable twin
    Tetrahedra,   ///< twelve tetrahedra, barycentric [Draeger2005, 3.6.3]: the reference
};

struct Deformed {
    Volume volume;  ///< on the grid of the original, with its key/value pairs
    /// Smallest box with every voxel that was written; empty if nothing moved inside the scan.
    Box3i dirty_box;
    std::int64_t written_voxels = 0;
    std::int64_t gap_voxels = 0;  ///< of these: covered by no cell, filled with air
    double resample_ms = 0;
    /// φ⁻¹(p) − p [mm, LPS] for the voxels of dirty_box, i fastest; zero where p is at rest. Empty
    /// unless asked for.
    std::vector<Vec3f> inverse_mm;
};

/// Writes the deformed scan. The same bits for any number of threads.
Result<Deformed> deform_volume(const ChainMail& tissue, Mapping mapping = Mapping::Cells,
                               bool with_inverse = false) noexcept;
Result<Deformed> deform_volume(const MovingScan& scan, Mapping mapping = Mapping::Cells,
                               bool with_inverse = false) noexcept;

/// What one update of a LiveDeformation did.
struct LiveUpdate {
    /// Boxes of voxels that may have changed: whole bricks of the lattice, cut to the scan, with
    /// neighbours along i joined. Valid until the next update.
    std::span<const Box3i> boxes;
    /// Smallest box with every voxel that was computed; empty if there was none.
    Box3i dirty_box;
    std::int64_t written_voxels = 0;  ///< computed; voxels that are at rest again are put back too
    std::int64_t gap_voxels = 0;      ///< of these: covered by no cell, filled with air
    double resample_ms = 0;
};

/// A deformed scan that is kept up to date while the tissue is pushed.
///
///   Result<LiveDeformation> live = LiveDeformation::create(tissue);
///   tissue.push(…);
///   if (const Result<LiveUpdate> update = live->update())
///       for (const Box3i& box : update->boxes) show(live->volume(), box);
///
/// The first update writes all that is deformed, each later one only what cells that changed since
/// then have left or entered. After any number of updates the volume is, bit for bit, that of
/// deform_volume(tissue). Once the largest deformation has been seen, an update allocates nothing.
///
/// After an update that failed, the volume shows neither the state before nor the one after; the
/// next one that succeeds writes all that is deformed, and its boxes hold all that was or is.
class LiveDeformation {
  public:
    /// Copies the scan, and keeps a reference: the tissue must outlive it, and stay where it is.
    static Result<LiveDeformation> create(const ChainMail& tissue) noexcept;
    static Result<LiveDeformation> create(const MovingScan& scan) noexcept;
    ~LiveDeformation();
    LiveDeformation(LiveDeformation&&) noexcept;
    LiveDeformation& operator=(LiveDeformation&&) noexcept;

    Result<LiveUpdate> update() noexcept;
    /// Puts the scan's voxels back, and forgets the state of the tissue: another may take its place
    /// before the next update, whose boxes hold the voxels that were put back as well.
    void start_over() noexcept;
    const Volume& volume() const;

    /// Whether updates also keep, from now on, where each voxel's value came from: twelve bytes for
    /// each voxel of the scan, of which those that were ever deformed become resident. Keeping
    /// begins with writing all that is deformed once more, with the same values.
    /// @pre nothing has changed since the last update
    /// @returns whether they are kept; false also where there isn't enough memory
    bool keep_sources(bool keep) noexcept;
    bool keeps_sources() const;
    /// φ⁻¹(p) − p at a voxel p [mm, LPS]; 0 at rest, and in gaps. @pre keeps_sources()
    Vec3f source_offset_mm(Vec3i voxel) const;
    /// The tissue that is shown.
    const MovingScan& scan() const;

    // Of the tissue that is shown at each voxel p of a box, i fastest. @pre keeps_sources(), and
    // nothing has changed since the last update. @param[out] values  one for each

    /// How far it has moved, |p − φ⁻¹(p)| [mm]; 0 at rest, and in gaps.
    void displacement_mm(const Box3i& box, std::span<float> values) const;
    /// By how much it grew there: det ∂φ/∂X at φ⁻¹(p), of the trilinear map of the cell that the
    /// voxel lies in. 1 where p has not moved, and in gaps; below 0 where space is inside out.
    void jacobian(const Box3i& box, std::span<float> values) const;

  private:
    struct Impl;
    explicit LiveDeformation(std::unique_ptr<Impl> impl);
    std::unique_ptr<Impl> m_impl;
};

/// Forward displacement at every rest voxel centre of the scan.
Result<VectorField> displacement_field(const ChainMail& tissue) noexcept;

/// Inverse displacement on the whole grid, in the direction that resampling filters expect.
/// @pre deformed was made with_inverse
Result<VectorField> inverse_field(const Deformed& deformed) noexcept;

/// The same fields slice by slice, for write_vector_field. They keep references: tissue and
/// deformed must outlive them unchanged.
Result<FieldSlices> displacement_slices(const ChainMail& tissue) noexcept;
Result<FieldSlices> displacement_slices(const MovingScan& scan) noexcept;
FieldSlices inverse_slices(const Deformed& deformed) noexcept;

/// By how much the tissue around each rest voxel centre grew: det F with F = I + ∂u/∂X, from
/// central differences along the lattice's axes, one-sided beside a cut link or a void element.
/// @returns float, dimensionless: 1 at rest and at void elements, below 0 where space is inside out
Result<Volume> jacobian_field(const ChainMail& tissue) noexcept;
Result<Volume> jacobian_field(const MovingScan& scan) noexcept;

/// By how much the tissue is stretched where it is stretched most: the largest eigenvalue of the
/// Green–Lagrange strain E = ½(FᵀF − I), F as above.
/// @returns float, dimensionless: 0 at rest and at void elements
Result<Volume> strain_field(const ChainMail& tissue) noexcept;
Result<Volume> strain_field(const MovingScan& scan) noexcept;

/// What there is to say of the elements where no limits hold: all but violations and cuts.
Result<LatticeState> state_of(const MovingScan& scan) noexcept;

/// Of all voxels and their grid's size: to compare results.
std::uint64_t hash_volume(const Volume& volume);

}  // namespace pliant
#pragma GCC visibility pop
