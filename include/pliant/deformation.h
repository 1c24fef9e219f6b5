// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Present positions of a scan's elements: sparse bricks of displacement, with cut links and void
// elements, from any model. Resampling, rendering, haptics and the server read no other data of a
// tissue.
//
// There is one element per voxel, at the voxel's centre at rest:
//
//   φ(X) = X + u(X)      X = world_from_voxel(grid, ijk), u = displacement_mm(ijk)
//
// Elements beyond the scan's border may move as well. Bricks of 8³ elements exist only where
// elements have moved, 12 bytes per element. Displacements are stored in units of 2⁻²⁰ mm.
//
// Functions of one object may run on several threads as long as none of them writes.

#pragma once

#include <pliant/core/moving_scan.h>
#include <pliant/core/tasks.h>
#include <pliant/result.h>
#include <pliant/volume.h>

#include <cstdint>
#include <memory>
#include <new>
#include <span>
#include <vector>

#pragma GCC visibility push(default)
namespace pliant {

class Field;
class WritableField;

/// Edits of an element: one byte of flags each.
enum ElementEdit : std::uint8_t {
    kCutX = 1,  ///< the link to the neighbour at +i is cut
    kCutY = 2,
    kCutZ = 4,
    kVoid = 8,  ///< carved away
};

/// Thread safety: concurrent reads.
class Deformation {
  public:
    /// Creates a deformation with every element at rest.
    /// @returns InvalidArgument for a grid without voxels
    static Result<Deformation> create(const Grid& grid) noexcept;
    /// A view of another room's field, which must outlive it.
    explicit Deformation(const Field& field) noexcept;
    ~Deformation();
    Deformation(Deformation&&) noexcept;
    Deformation& operator=(Deformation&&) noexcept;

    const Grid& grid() const;
    /// Displacement of element ijk [mm, LPS]; zero at rest.
    Vec3d displacement_mm(Vec3i ijk) const;
    /// Whether element ijk was carved away.
    bool is_void(Vec3i ijk) const;
    /// Whether the link from element ijk to the next one along an axis exists: it is not cut, and
    /// neither end is void.
    bool is_linked(Vec3i ijk, int axis) const;
    /// Smallest box with every element away from its rest position; not cut to the grid.
    Box3i moved_box() const;
    /// Increases with every change.
    std::uint64_t version() const;
    /// Hash of all displacements and edits, independent of the order of writes.
    std::uint64_t hash() const;

    /// Displaces the elements of a box. Nothing changes on failure.
    /// @param displacements_mm  one per element of the box, i fastest [mm, LPS]
    /// @returns InvalidArgument for another count, or a displacement that is not finite or above
    ///          500 mm along an axis; LimitExceeded if memory runs out
    /// @pre made by create
    Status write(const Box3i& elements, std::span<const Vec3d> displacements_mm) noexcept;
    /// Displaces the elements of a box by a function of their index: Vec3d(Vec3i), [mm, LPS].
    template <class Displacement>
    Status displace(const Box3i& elements, const Displacement& displacement_mm) noexcept;
    /// Replaces the edits of the elements of a box. Nothing changes on failure.
    /// @param edits  ElementEdit flags, one byte per element of the box, i fastest
    /// @returns InvalidArgument for another count, LimitExceeded if memory runs out
    /// @pre made by create
    Status edit(const Box3i& elements, std::span<const std::uint8_t> edits) noexcept;
    /// Returns every element to rest, and removes all edits. @pre made by create
    void reset() noexcept;

    const Field& field() const { return *m_field; }  ///< for other rooms; opaque to users

  private:
    explicit Deformation(std::unique_ptr<WritableField> own) noexcept;
    std::unique_ptr<WritableField> m_own;  ///< null: a view
    const Field* m_field;
};

template <class Displacement>
Status Deformation::displace(const Box3i& elements, const Displacement& displacement_mm) noexcept
    try {
    std::vector<Vec3d> displacements_mm;
    for (int k = elements.begin.z; k < elements.end.z; ++k)
        for (int j = elements.begin.y; j < elements.end.y; ++j)
            for (int i = elements.begin.x; i < elements.end.x; ++i)
                displacements_mm.push_back(displacement_mm(Vec3i{i, j, k}));
    return write(elements, displacements_mm);
} catch (const std::bad_alloc&) {
    return Error{ErrorCode::LimitExceeded, "out of memory"};
}

/// Statistics of a deformation, from its elements and cells alone.
struct DeformationState {
    std::int64_t moved_elements = 0;  ///< away from their rest position
    std::int64_t resident_bricks = 0;
    double bytes_per_resident_element = 0;
    double max_movement_mm = 0;     ///< largest of all elements
    std::int64_t folded_cells = 0;  ///< whole cells with a corner at which space is inverted
    std::int64_t cut_links = 0;
    std::int64_t carved_elements = 0;
};

/// @returns LimitExceeded if memory runs out
Result<DeformationState> state_of(const MovingScan& scan) noexcept;

}  // namespace pliant
#pragma GCC visibility pop
