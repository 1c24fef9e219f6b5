// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Motion of an organ between two phases, from its shape at both, from known points, or from both.
//
//       FROM (exhale)                      TO (inhale)
//     o X   ───────── φ(X) = X + u(X) ───────▶  o
//      \__ surface slides along its image; normal gaps close
//       \__ known points are met
//
// Points alone: the thin plate spline of three dimensions (kernel r, affine trend). Shapes alone:
// each part of the organ is an elastic body in sliding contact with its image. Both: the elastic
// body first, and a spline of the rest through points and surfaces. docs/howto/morph.md has the
// formulas and the errors on measured lungs.
//
// u is stored at the nodes of a lattice, trilinear between them and constant beyond. The
// determinant of ∂φ/∂X is positive everywhere, by a bound of each cell, so that φ has an inverse
// in all of space. A spline that folds is made softer where it does.
//
// @code
//   const MorphInput input{.from_mm = known, .to_mm = found, .from = &exhale, .to = &inhale};
//   auto morph = Morph::create(input, {}, arena);
//   const Vec3d predicted = morph->forward(point);
//   auto field = morph->forward_field(exhale.grid, arena);   // as registrations write it
// @endcode

#pragma once

#include <pliant/core/record.h>
#include <pliant/core/tasks.h>
#include <pliant/core/vec.h>
#include <pliant/mesh.h>
#include <pliant/result.h>
#include <pliant/volume.h>

#include <memory>
#include <span>

#pragma GCC visibility push(default)
namespace pliant {

/// Whether the lungs of a patient who lies on the back are assumed, which compresses their back and
/// base at exhale. A prior that was fitted to five patients.
enum class MorphPrior {
    Auto,    ///< Supine, where a map is of one label and has the shape of two lungs
    Supine,  ///< for each part
    None,
};

struct MorphSettings {
    MorphPrior prior = MorphPrior::Auto;
    double point_softness_mm = 1;    ///< λ of a known point
    double slide_softness_mm = 300;  ///< λ of a surface point in the last rounds
    double poisson_ratio = 0;        ///< of the elastic bodies
    double bending_mm2 = 1000;       ///< their second-order modulus over the shear modulus
    double least_volume = 0.05;      ///< smallest det ∂φ/∂X that is allowed
};
SettingRows<MorphSettings> morph_rows() noexcept;

/// Young's modulus of a label over that of the others, whose modulus is 1.
struct MorphModulus {
    int label = 0;
    double relative = 1;  ///< 0.001…1000
};

/// Points, or label maps, or both. Nothing is kept.
struct MorphInput {
    std::span<const Vec3d> from_mm{}, to_mm{};  ///< pairs of known points [mm, LPS]
    /// Label maps at the two phases, on any grids; null: none. A value other than 0 is a part of
    /// the organ if both have it. One label may consist of two lungs, which are separated.
    const Volume* from = nullptr;
    const Volume* to = nullptr;
    /// Of labels of `from`. A label that `to` lacks, such as vessels or a tumour, is stiff or soft
    /// tissue within the part that surrounds it.
    std::span<const MorphModulus> moduli{};
    const Grid* grid = nullptr;  ///< whose voxels hold the nodes; null: that of `from`, or one
                                 ///< around the points
};

struct MorphReport {
    int points = 0;                  ///< known ones
    int parts = 0;                   ///< of the organ
    bool has_prior = false;          ///< whether Supine was used
    double point_residual_mm = 0;    ///< mean |φ(from) − to|
    double surface_residual_mm = 0;  ///< mean distance of the moved surface from its image
    double max_displacement_mm = 0;
    double least_volume = 1;  ///< lower bound of det ∂φ/∂X in all of space
    int softened = 0;         ///< rounds in which a spline was made softer, or flatter
    double affine_share = 0;  ///< 0…1: by which the field was drawn to its affine part
    double solve_ms = 0;
};

/// The inside of a closed surface as a label map, 1 on 0, with voxels along the world's axes.
/// @returns InvalidArgument for a surface that isn't closed; LimitExceeded for 400 million voxels
Result<Volume> labels_of_surface(const TriangleMesh& surface, double spacing_mm = 2) noexcept;

/// Thread safety: immutable.
class Morph {
  public:
    /// @returns InvalidArgument that names the field for unequal numbers of points, label maps
    ///          without a common label, a modulus without its label, or a motion whose affine part
    ///          is folded; LimitExceeded for more than 2000 points
    static Result<Morph> create(const MorphInput& input, const MorphSettings& settings,
                                const TaskArena& arena) noexcept;
    ~Morph();
    Morph(Morph&&) noexcept;
    Morph& operator=(Morph&&) noexcept;

    /// φ of a point [mm, LPS].
    Vec3d forward(Vec3d from_mm) const noexcept;
    /// φ⁻¹ of a point [mm, LPS]: |φ(φ⁻¹(p)) − p| is below 10⁻⁶ mm.
    Vec3d inverse(Vec3d to_mm) const noexcept;
    /// u at voxel centres. On the grid of the nodes the trilinear field is φ itself.
    Result<VectorField> forward_field(const Grid& grid, const TaskArena& arena) const noexcept;
    /// φ⁻¹(p) − p at voxel centres, as resampling filters expect.
    Result<VectorField> inverse_field(const Grid& grid, const TaskArena& arena) const noexcept;

    /// Grid of the nodes, which lie at voxel centres of the input's grid.
    const Grid& nodes() const noexcept;
    const MorphReport& report() const noexcept;

  private:
    struct Impl;
    explicit Morph(std::unique_ptr<Impl> impl) noexcept;
    std::unique_ptr<Impl> m_impl;
};

}  // namespace pliant
#pragma GCC visibility pop
