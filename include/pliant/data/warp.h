// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A deformation as one map for everything on a scan's grid: images with any number of channels,
// label maps and points move by the same field, there and back.
//
//     φ(X) = X + u(X)      u: at the elements of a box, trilinear between them, zero beyond
//
//     image'(p)  = image(φ⁻¹(p))       labels'(p) = labels(φ⁻¹(p))       point' = φ(point)
//     image(X)   = image'(φ(X))        labels(X)  = labels'(φ(X))        point  = φ⁻¹(point')
//
// A warp is independent of the tissue that it was taken from. Its state (grid, box, displacements)
// gives the same bits again.
//
// @code
//   const Result<Warp> warp = Warp::create(tissue);
//   std::vector<std::uint8_t> labels(voxel_count(scan.grid)), moved(labels.size());
//   warp->warp_labels<std::uint8_t>(labels, moved, LabelSampling::Nearest, 0);
//   const Vec3d landmark = warp->forward(point);
// @endcode

#pragma once

#include <pliant/core/tasks.h>
#include <pliant/deformation.h>
#include <pliant/resample.h>
#include <pliant/volume.h>

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#pragma GCC visibility push(default)
namespace pliant {

/// How a label between voxel centres is found.
enum class LabelSampling {
    Nearest,   ///< the nearest voxel's
    Majority,  ///< the one with the largest trilinear weight; nearest if two have it
};

/// Displacements of the elements of a box, along the grid's axes [2⁻²⁰ mm].
struct WarpState {
    Grid grid;
    Box3i box;  ///< may reach beyond the grid; empty: everything is at rest
    /// Component 0 of all elements, i fastest; then component 1, and 2.
    std::vector<std::int32_t> units{};
};

/// Thread safety: concurrent reads.
class Warp {
  public:
    /// Takes a copy of the displacements.
    /// @param[out] deformed  the scan after the deformation, on request
    /// @returns InvalidArgument if elements are cut, carved or missing, so that there is no inverse
    static Result<Warp> create(const MovingScan& scan, Volume* deformed = nullptr) noexcept;
    /// @param with_inverse  false: without warp_image, warp_labels and inverse_field
    /// @returns InvalidArgument for an invalid grid, or another number of displacements
    static Result<Warp> create(WarpState state, const TaskArena& arena,
                               bool with_inverse = true) noexcept;

    const Grid& grid() const { return m_state.grid; }
    const WarpState& state() const { return m_state; }
    /// Voxels whose value may change. @pre made with the inverse
    const Box3i& changed_box() const { return m_changed; }
    bool has_inverse() const { return m_has_inverse; }

    // T: std::int8_t…std::int64_t, their unsigned twins, float, double. Arrays have a value for
    // each voxel, i fastest; `to` may not be `from`.

    /// to(p) = from(φ⁻¹(p)), trilinear; integers are rounded. @pre made with the inverse
    /// @param beyond  value outside of the grid
    template <class T>
    void warp_image(std::span<const T> from, std::span<T> to, T beyond) const;
    template <class T>
    void warp_labels(std::span<const T> from, std::span<T> to, LabelSampling sampling,
                     T beyond) const;
    /// to(X) = from(φ(X)): the way back.
    template <class T>
    void unwarp_image(std::span<const T> from, std::span<T> to, T beyond) const;
    template <class T>
    void unwarp_labels(std::span<const T> from, std::span<T> to, LabelSampling sampling,
                       T beyond) const;

    /// φ of a point [mm, LPS].
    Vec3d forward(Vec3d point_mm) const;
    /// φ⁻¹ of a point [mm, LPS], to 10⁻⁹ voxels. Where space is folded, one of several, or empty if
    /// Newton's method finds none; limits rule out folds.
    std::optional<Vec3d> inverse(Vec3d point_mm) const;

    /// Displacement field on the whole grid, and its inverse. @pre made with the inverse
    Result<VectorField> forward_field() const noexcept;
    Result<VectorField> inverse_field() const noexcept;

    /// Smallest det ∂φ/∂X at the corners of all cells; 1 at rest.
    double smallest_jacobian() const;
    /// Elements away from their rest position.
    std::int64_t moved_elements() const;
    /// Displacement of element ijk along the grid's axes [mm].
    Vec3d displacement_mm(Vec3i ijk) const;

  private:
    Warp() = default;

    WarpState m_state;
    Box3i m_changed;
    std::vector<Vec3f> m_back;  ///< φ⁻¹(p) − p over m_changed [mm, LPS]
    bool m_has_inverse = false;
};

}  // namespace pliant
#pragma GCC visibility pop
