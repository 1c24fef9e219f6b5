// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Registration truth: pairs of scans whose deformation is known, and scores of registrations.
//
// A case is made of a scan and a seed. The scan is the fixed image; random motions of tools deform
// it, and the result is the moving image. The tissue is ChainMail, or the elastic scan, which is in
// equilibrium after each motion.
//
//        fixed image (the scan)              moving image (deformed)
//        o voxel centre X  ── forward u(X) ──▶  φ(X) = X + u(X)
//        X' = p + v(p)     ◀── inverse v(p) ──  p voxel centre o
//
// φ is the piecewise map of the cells: trilinear between the eight elements around a point, where
// the cell is whole (no corner void, no cut that has opened). The forward field holds u at the
// voxel centres of the fixed image, and the inverse field v at those of the moving image. Both are
// exact there; a field interpolated between them is not. TruthMap evaluates φ and its inverse at
// any point.
//
// A point has a counterpart only if the correspondence is one to one. TruthMask tells which voxels
// have none, and why; scores and landmarks don't use them.
//
// @code
//   auto maker = TruthMaker::create(scan, {}, {.motions = 2}, arena);
//   auto truth = maker->make(7);                         // seed 7: the same bits everywhere
//   auto score = score_field(*truth, truth->forward, arena);  // a registration's field instead
// @endcode

#pragma once

#include <pliant/core/record.h>
#include <pliant/core/tasks.h>
#include <pliant/core/vec.h>
#include <pliant/models/scan_tissue.h>
#include <pliant/result.h>
#include <pliant/volume.h>

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#pragma GCC visibility push(default)
namespace pliant {

/// Kinds of motions of a case.
enum class TruthKind {
    Contact,    ///< a sphere pushes or pulls a wall, or tissue around it
    Slide,      ///< a sphere slides along a wall without friction
    Cut,        ///< a cut, whose halves are moved apart
    Interface,  ///< a cut, whose sides slide along each other in opposite directions
    Breathing,  ///< smooth motion of all soft tissue, decreasing towards bone and the border
};
inline constexpr int kTruthKinds = 5;
/// "contact", "slide", "cut", "interface", "breathing".
std::string_view name_of(TruthKind kind) noexcept;

/// Amplitudes are the largest ones; a motion draws 30 to 100 % of it.
struct TruthSettings {
    std::string kinds = "contact,slide,cut,interface,breathing";  ///< that motions are drawn from
    int motions = 3;                                              ///< of a case
    double contact_mm = 10;                                       ///< length of a push
    double slide_mm = 15;                                         ///< length of a slide
    double cut_mm = 8;          ///< distance by which the halves are moved apart
    double interface_mm = 10;   ///< distance by which the sides slide along each other
    double breathing_mm = 10;   ///< largest displacement of breathing
    double tool_radius_mm = 5;  ///< of pushing and sliding spheres
    double cut_length_mm = 25;  ///< of a cut; it is half as deep
    double band_mm = 3;         ///< distance from a wall or a cut up to which a voxel is at it
    int landmarks = 100;        ///< of a case, evenly from all types that have moved
};
SettingRows<TruthSettings> truth_rows() noexcept;

/// Type of a voxel of the fixed image: values of TruthCase::labels.
enum class TruthLabel : std::int16_t {
    Air = 0,
    Interior = 1,   ///< soft tissue away from walls and cuts
    Bone = 2,       ///< tissue that never moves
    Wall = 3,       ///< soft tissue at air
    Interface = 4,  ///< soft tissue at a sliding interface
    Cut = 5,        ///< soft tissue at a cut
};
inline constexpr int kTruthLabels = 6;
/// "air", "interior", "bone", "wall", "interface", "cut".
std::string_view name_of(TruthLabel label) noexcept;

/// Whether a voxel has a counterpart in the other image: values of the masks.
enum class TruthMask : std::int16_t {
    Exact = 0,        ///< it has exactly one
    Outside = 1,      ///< it lies beyond the other image
    Gap = 2,          ///< no cell holds it: an opened cut
    Ambiguous = 3,    ///< several points come to lie there, or a cell there may be folded
    ClosedLumen = 4,  ///< fixed image: air that has lost nine tenths of its volume
};
/// "exact", "outside", "gap", "ambiguous", "closed_lumen".
std::string_view name_of(TruthMask mask) noexcept;

/// An exact pair of points [mm, LPS].
struct TruthLandmark {
    Vec3d fixed_mm, moving_mm;
    TruthLabel label = TruthLabel::Interior;
};

/// A motion that was carried out.
struct TruthMotion {
    TruthKind kind = TruthKind::Contact;
    Vec3d point_mm{0, 0, 0};   ///< position in the scan as deformed so far, LPS
    Vec3d motion_mm{0, 0, 0};  ///< of the tool, LPS; breathing: the largest displacement
    Vec3d normal{0, 0, 0};  ///< of the wall or the cut, into the tissue; zero where there is none
    double radius_mm = 0;   ///< of the tool
    double length_mm = 0, depth_mm = 0;  ///< of a cut
    double fraction = 0;                 ///< executed part of the motion, 0…1
    std::int64_t moved_elements = 0;     ///< of a push; 0 for others
};

/// φ and its inverse at any point. Exact up to 10⁻⁶ voxel.
/// Thread safety: immutable.
class TruthMap {
  public:
    ~TruthMap();
    TruthMap(TruthMap&&) noexcept;

    /// φ at a point of the fixed image [mm, LPS].
    /// @returns nothing where the cell is not whole, the point lies beyond the image, or the
    ///          correspondence is not one to one
    std::optional<Vec3d> moving_from_fixed(Vec3d fixed_mm) const noexcept;
    /// φ⁻¹ at a point of the moving image [mm, LPS]. @returns nothing likewise
    std::optional<Vec3d> fixed_from_moving(Vec3d moving_mm) const noexcept;

  private:
    friend class TruthMaker;
    struct Impl;
    explicit TruthMap(std::unique_ptr<Impl> impl) noexcept;
    std::unique_ptr<Impl> m_impl;
};

/// The data that scores need: all on the grid of the fixed image.
struct TruthData {
    VectorField forward;  ///< u [mm, LPS] at voxel centres of the fixed image
    Volume labels;        ///< TruthLabel, 16 bits
    Volume fixed_mask;    ///< TruthMask of the fixed image, 16 bits
    std::vector<TruthLandmark> landmarks;
};

struct TruthCase : TruthData {
    std::uint64_t seed = 0;
    Volume moving;
    VectorField
        inverse;  ///< v [mm, LPS] at voxel centres of the moving image; 0 without counterpart
    Volume moving_mask;  ///< TruthMask of the moving image, 16 bits
    std::vector<TruthMotion> motions;
    /// Largest |φ(p + v(p)) − p| [mm] of all voxels p of the moving image with a counterpart, with
    /// v as stored (float).
    double inverse_error_mm = 0;
    /// Largest |φ⁻¹(φ(X)) − X| [mm] of the landmarks.
    double landmark_error_mm = 0;
    std::array<std::int64_t, kTruthLabels> label_voxels{};        ///< by TruthLabel
    std::array<std::int64_t, 5> fixed_voxels{}, moving_voxels{};  ///< by TruthMask
    std::int64_t folded_cells = 0;  ///< cells that may be folded, most of them air
    double max_displacement_mm = 0;
    std::uint64_t hash = 0;  ///< of all arrays and landmarks: equal for any number of threads
    std::shared_ptr<const TruthMap> map;
};

/// Makes cases of one scan.
/// Thread safety: concurrent reads.
class TruthMaker {
  public:
    /// Keeps references: scan and arena must outlive it and its cases.
    /// @param materials  of the tissue; `bounded` and the history of ChainMail are set by the maker
    /// @returns InvalidArgument that names the setting, such as kinds with cuts in the elastic
    ///          scan, or a scan with fewer than 8 voxels along an axis; LimitExceeded
    static Result<TruthMaker> create(const Volume& scan, const ScanTissueSettings& materials,
                                     const TruthSettings& settings,
                                     const TaskArena& arena) noexcept;
    ~TruthMaker();
    TruthMaker(TruthMaker&&) noexcept;
    TruthMaker& operator=(TruthMaker&&) noexcept;

    /// Makes the case of a seed: the same bits for any number of threads.
    /// @returns NotFound if the scan has no place for a motion of any of the kinds; LimitExceeded
    Result<TruthCase> make(std::uint64_t seed) const noexcept;
    const TruthSettings& settings() const noexcept;

  private:
    struct Impl;
    explicit TruthMaker(std::unique_ptr<Impl> impl) noexcept;
    std::unique_ptr<Impl> m_impl;
};

/// Displacement from which a voxel counts as moved in scores [mm].
inline constexpr double kTruthMovedMm = 0.5;

/// Distances between found and true points [mm].
struct TruthErrors {
    std::int64_t count = 0;
    double mean_mm = 0, median_mm = 0, p95_mm = 0, max_mm = 0;
};

/// Kinds of positions, the rows of a score.
enum class TruthRow {
    Moved,     ///< all soft tissue that moved
    Interior,  ///< moved tissue by type
    Wall,
    Interface,
    Cut,
    Still,  ///< soft tissue that did not move
    Bone,
    Landmarks,  ///< all landmarks
};
inline constexpr int kTruthRows = 8;
/// "moved", "interior", "wall", "interface", "cut", "still", "bone", "landmarks".
std::string_view name_of(TruthRow row) noexcept;

struct TruthScore {
    std::array<TruthErrors, kTruthRows> rows{};  ///< by TruthRow
    /// Share of the soft-tissue voxels at which the found map is folded (det ≤ 0), and their
    /// number; none for points.
    std::optional<double> folded_share;
    std::int64_t folded_voxels = 0;
};

/// Scores a displacement field of the fixed image: fixed point → moving point [mm, LPS], as ITK's.
/// A field on another grid than the truth's is interpolated linearly, and zero beyond its grid.
/// @returns InvalidArgument for a field that check_field refuses; LimitExceeded
Result<TruthScore> score_field(const TruthData& truth, const VectorField& found,
                               const TaskArena& arena) noexcept;
/// Scores nothing but zero: the errors without a registration.
Result<TruthScore> score_nothing(const TruthData& truth, const TaskArena& arena) noexcept;
/// Scores the positions that a registration gives the landmarks, in their order [mm, LPS].
/// @returns InvalidArgument for another number, or a point that is not finite
Result<TruthScore> score_points(const TruthData& truth, std::span<const Vec3d> moving_mm) noexcept;
/// Statistics of distances, which are reordered. The percentile is the nearest rank.
TruthErrors errors_of(std::span<float> distances_mm) noexcept;

}  // namespace pliant
#pragma GCC visibility pop
