// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Pictures of a volume: endoscopic views by first-hit ray casting, and sections.

#pragma once

#include <pliant/core/tasks.h>
#include <pliant/result.h>
#include <pliant/view/image.h>
#include <pliant/volume.h>

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#pragma GCC visibility push(default)
namespace pliant {

class RestField;

/// Direction in which values cross the threshold at the wall.
enum class Polarity {
    Rising,   ///< air-filled lumen: the wall is brighter than the lumen
    Falling,  ///< contrast-filled vessel: the wall is darker
};

/// Lighting and colours of the endoscope's picture.
enum class Style {
    Plain,  ///< one colour, a light at the lens: pure shape, for measurements and research
    Real,   ///< lamps beside the lens, automatic exposure, tissue colours, wet surface
};

/// Kind of lumen, for its colours in the style Real.
enum class Lining { Airway, Colon, Sinus, Vessel };

/// Shape of the picture in the style Real; black outside.
enum class FieldStop { Round, Octagon, Full };

/// The endoscope: a pin-hole camera with barrel distortion and a light at the lens.
struct Endoscope {
    Vec3d eye_mm{0, 0, 0};          ///< LPS
    Vec3d look{0, 1, 0};            ///< LPS, any length > 0
    Vec3d up{0, 0, 1};              ///< LPS; zero or parallel to look: superior or anterior is used
    double field_of_view_deg = 80;  ///< across the picture's height, before distortion
    double barrel_distortion = 0.15;  ///< 0: none; r_ray = r·(1 + k·r²), r = 1 at the edge
    double iso_hu = -500;             ///< threshold of the surface
    Polarity polarity = Polarity::Rising;
    double fog_distance_mm = 120;  ///< light falls to 1/e over this; 0: no fog
    Rgb8 surface{222, 150, 134};   ///< colour of the tissue in full light
    Rgb8 fog{8, 6, 8};             ///< colour at infinite distance, and of rays without a hit
    Style style = Style::Plain;
    // Style Real only. It ignores fog and surface.
    Lining lining = Lining::Airway;
    FieldStop field_stop = FieldStop::Round;
    /// Rest field of a deformed volume: anchors blood vessels to the tissue, shows raw faces. Must
    /// outlive the calls; null: no deformation.
    const RestField* rest = nullptr;
};

/// Unit directions of the rays through the middles of a picture's pixels [LPS], rows from the top:
/// those of endoscope_view(), for first_hits().
std::vector<Vec3d> view_directions(const Endoscope& endoscope, int width, int height);

/// Suggests a first view of a scan: deep inside a lumen, along its longest free path. Prefers
/// enclosed air over the air around the patient, and tubes over lungs.
/// @returns nullopt if no voxel is on the lumen's side of the threshold
std::optional<Endoscope> find_endoscope(const Volume& volume, double iso_hu, Polarity polarity,
                                        const TaskArena& arena);

/// A view of the whole scan from outside, from the front, for scans without a lumen.
Endoscope view_of_whole(const Volume& volume);

/// Finds the longest free path from an eye [mm, LPS] to a wall: a good viewing direction.
/// @returns a unit vector, or nullopt if no wall is visible
std::optional<Vec3d> find_look(const Volume& volume, Vec3d eye_mm, double iso_hu, Polarity polarity,
                               const TaskArena& arena);

/// Aims a view at a point on the tissue that a push starts from: some 15…45 mm away (closer in a
/// narrow lumen), with a free line of sight and room around the eye, against the push or beside it.
/// If there is no such position, it falls back to a lumen elsewhere or a position outside that
/// faces the point.
/// @param push_mm  any length; zero: every side is allowed
Endoscope aim_endoscope(const Volume& volume, Vec3d target_mm, Vec3d push_mm, double iso_hu,
                        Polarity polarity, const TaskArena& arena);

enum class Orientation { Axial, Coronal, Sagittal };

/// A section through a point, perpendicular to a world axis, in the radiological convention
/// (patient's right on the left of the picture; anterior or head up).
struct Section {
    Orientation orientation = Orientation::Axial;
    Vec3d point_mm{0, 0, 0};  ///< LPS, position of the crosshair
    double window_hu = 1500;
    double level_hu = -200;
    double width_mm = 0;  ///< width of the picture; 0: the whole volume
    bool crosshair = true;
};

/// Opacity transfer function of a blended view: zero below the window, then rising to the window's
/// upper end.
struct TransferFunction {
    double window_hu = 500;
    double level_hu = 150;
    double opacity_per_mm = 0.25;  ///< extinction at the window's upper end [1/mm]
    Rgb8 dim{150, 60, 40};         ///< colour at the window's lower end
    Rgb8 bright{255, 250, 240};    ///< colour at the window's upper end
};

/// First intersection of a ray with the surface.
struct RayHit {
    double distance_mm;  ///< from the ray's origin
    Vec3d point_mm;      ///< LPS
    Vec3d normal;        ///< unit, towards the side of the camera
};

/// Pictures of an endoscope with their measurements. A span is empty (not wanted), or has one
/// element for each pixel, rows from the top. A pixel's measurements are those of the ray through
/// its middle. Pixels without a wall, or outside of the field stop, have 0.
struct EndoscopeFrame {
    std::span<Rgb8> colour{};      ///< as endoscope_view
    std::span<float> depth_mm{};   ///< along the optical axis, as in a pin-hole camera's depth map
    std::span<Vec3f> normals{};    ///< unit, towards the camera, in its axes: right, down, ahead
    std::span<Vec3d> points_mm{};  ///< position on the wall [LPS]; infinite without a wall
    /// Four rays for each pixel at an edge, as in endoscope_view; else one for each pixel.
    bool is_smooth = true;
};

/// Pixel coordinates, from the top left corner: the middle of the first pixel is at (0.5, 0.5).
struct PicturePoint {
    double x, y;
};

/// Projects a point on the picture of an endoscope: the inverse of the rays of its pixels. It may
/// lie outside of the picture.
/// @returns nullopt for points beside or behind the eye
std::optional<PicturePoint> project(const Endoscope& endoscope, int width, int height,
                                    Vec3d point_mm);

/// Casts rays at one volume; a volume that check_volume refuses counts as air. The constructor
/// builds the min/max bricks for empty-space skipping; a change of the threshold needs no rebuild.
/// Keeps references: volume and arena must outlive it, at a constant address.
///
/// @code
///   RayCaster caster(live.volume(), arena);  // a LiveDeformation
///   tissue.push({.point_mm = point, .push_mm = {5, 0, 0}});
///   if (const auto update = live.update()) caster.update(update->boxes);
///   show(caster.endoscope_view(endoscope, 512, 512));
/// @endcode
/// Thread safety: concurrent reads.
class RayCaster {
  public:
    RayCaster(const Volume& volume, const TaskArena& arena);
    ~RayCaster();
    RayCaster(RayCaster&&) noexcept;

    /// Updates the bricks after a change of the volume in these boxes of voxels only. The state
    /// then equals that of a new caster.
    /// @pre no concurrent casts; boxes lie inside the grid
    void update(std::span<const Box3i> boxes);

    /// First crossing of iso_hu along origin + t·direction, t > 0, exact for the trilinear
    /// interpolant. Rising: from below iso to ≥ iso; falling: the reverse. An origin inside of the
    /// tissue sees the next wall after the ray has left the tissue. There is no surface beyond the
    /// outermost voxel centres.
    /// @param direction  world, length > 0
    std::optional<RayHit> first_hit(Vec3d origin_mm, Vec3d direction, double iso_hu,
                                    Polarity polarity) const;

    /// Casts many rays from one eye, vectorised. The crossings equal those of first_hit up to
    /// rounding, and are bit-identical on every machine and for any number of threads. Fastest if
    /// consecutive rays are close together, for example those of 4 × 2 pixels.
    /// @param directions  world, any length; zero vectors hit nothing
    /// @param[out] distances  one per ray, in multiples of its direction's length (unit vectors:
    ///                        mm); infinite without a hit
    void first_hits(Vec3d eye_mm, std::span<const Vec3d> directions, double iso_hu,
                    Polarity polarity, std::span<double> distances) const;

    Image endoscope_view(const Endoscope& endoscope, int width, int height) const;
    /// The picture with depth, normals and positions of the wall, in one pass.
    /// @pre spans as EndoscopeFrame describes
    void endoscope_frame(const Endoscope& endoscope, int width, int height,
                         const EndoscopeFrame& frame) const;

    /// Surface point under a point of the endoscope's picture [pixels, from the top left corner].
    std::optional<RayHit> pick(const Endoscope& endoscope, int width, int height, double x,
                               double y) const;

    /// Point of the surface nearest to a point, for either polarity, to 0.02 mm or a hundredth of
    /// the distance. Tests whether a sphere of radius within_mm touches the surface.
    /// @returns distance and position; the normal as in first_hit
    std::optional<RayHit> nearest_surface(Vec3d point_mm, double within_mm, double iso_hu,
                                          Polarity polarity = Polarity::Rising) const;

    /// Volume rendering with emission and absorption: alpha blending along each ray, with shading
    /// at steep gradients. The endoscope supplies camera and background (its fog colour); its
    /// threshold and surface are ignored.
    Image blended_view(const Endoscope& endoscope, const TransferFunction& transfer, int width,
                       int height) const;

  private:
    struct Impl;
    std::unique_ptr<Impl> m_impl;
};

Image section_view(const Volume& volume, const Section& section, int width, int height,
                   const TaskArena& arena);

struct FourUp {
    Endoscope endoscope;
    Section section;      ///< point, window and level of all three; orientation is ignored
    std::string caption;  ///< drawn in the corner; may be empty
};

/// Endoscope (top left), axial (top right), coronal (bottom left), sagittal (bottom right), with
/// orientation letters, crosshair and captions.
Image four_up_view(const Volume& volume, const FourUp& settings, int width, int height,
                   const TaskArena& arena);

/// Two pictures of equal height next to each other.
Image side_by_side(const Image& left, const Image& right);

// Simulates the picture of an X-ray image intensifier. The absorption along each ray from the
// source to the detector is
//
//   I / I₀ = exp(−∫ μ ds),   μ = μ_water · max(0, 1 + HU/1000)
//
// for one energy, without scatter or beam hardening. Dense material is dark. The grey value depends
// on p = contrast · ∫ μ ds, nearly linearly around the exposure p₀, with soft shoulders:
//
//   grey = 1 / (1 + 0.55/0.45 · exp(4 (p − p₀) / 4))
//
// This is the sigmoid of DICOM PS3.3, C.11.2.1.3.1, with a window of 4, on a logarithmic detector
// signal. p₀ is 45 % grey. By default it is the median over a grid of 7 × 7 rays through the
// central third of the picture; rays that miss the scan do not count.
//
// A scan is often cut out of a body. Beyond the outermost voxels, up to the two planes across
// `look` that touch the scan, the outermost values continue and fade out:
//
//   μ(x) = μ(nearest voxel centre in the scan) · (1 − e²/b²)²   for e < b, else 0
//
// with e the distance from the scan and b the border, both in mm. This avoids a visible outline of
// the scan's box. Air around a body stays air.

/// The defaults suit measurements: no noise, no collimator. `pliant render` and the page turn both
/// on.
struct Fluoroscopy {
    Vec3d centre_mm{0, 0, 0};    ///< middle of the picture [LPS]
    Vec3d look{0, 1, 0};         ///< from the source to the detector, length > 0
    Vec3d up{0, 0, 1};           ///< zero or parallel to look: superior or anterior is used
    double source_mm = 1000;     ///< from the source to the centre, > 0
    double width_mm = 200;       ///< width of the picture at the centre, > 0
    double water_per_mm = 0.02;  ///< μ of water, about 60 keV [1/mm]
    double contrast = 1;         ///< factor of the line integral, > 0
    std::optional<double> exposure_water_mm{};  ///< water length at 45 % grey; nullopt: metered
    /// Distance over which the outermost voxels fade out, ≥ 0. 0: nothing beyond the outermost
    /// voxel centres. nullopt: a third of the cube root of the scan's volume.
    std::optional<double> border_mm{};
    FieldStop field_stop = FieldStop::Full;  ///< the collimator
    /// Quantum noise, ≥ 0. At 1 the line integral has a standard deviation of 0.05 at the exposure,
    /// and of 0.05 exp((p − p₀)/2) elsewhere, 0.2 at most, before the contrast.
    double noise = 0;
    std::uint32_t seed = 0;  ///< seed of the noise: a picture's number
};

/// Computes ∫ max(0, 1 + HU/1000) ds along the ray of each pixel's middle [mm of water], rows from
/// the top, with the border, without noise or collimator.
std::vector<float> water_lengths_mm(const Volume& volume, const Fluoroscopy& settings, int width,
                                    int height, const TaskArena& arena);

Image fluoroscopy_view(const Volume& volume, const Fluoroscopy& settings, int width, int height,
                       const TaskArena& arena);

// A path along the middle of a lumen between two points. It needs no segmentation, only the
// threshold of the pictures (docs/method/lumen_path.md).

struct LumenPathSettings {
    double iso_hu = -500;
    Polarity polarity = Polarity::Rising;
    /// An end in the tissue, for example a click on a wall, is moved into a lumen within this
    /// distance [mm].
    double reach_mm = 0;
    double spacing_mm = 2;  ///< maximal distance between the path's points
    /// Limit of visited voxels; 13 bytes each.
    std::int64_t max_voxels = 48'000'000;
    std::function<bool()> give_up{};  ///< polled now and then; may be empty
};

struct LumenPath {
    std::vector<Vec3d> points_mm;   ///< LPS, from start to end
    std::vector<double> radius_mm;  ///< distance of each point to the wall
    double length_mm = 0;
};

/// Finds the shortest path that keeps some distance from the walls, then centres it in the lumen.
/// The path stays in the lumen, and is equal for any number of threads. The search visits only
/// voxels up to about the distance of the other end.
/// @pre the volume doesn't change meanwhile
/// @returns InvalidArgument if an end is outside of the volume or in the tissue (the message has
///          the distance to the lumen), NotFound if the ends aren't connected, LimitExceeded if
///          max_voxels are not enough or give_up returned true. Messages begin with "from" or "to"
Result<LumenPath> find_lumen_path(const Volume& volume, Vec3d from_mm, Vec3d to_mm,
                                  const LumenPathSettings& settings, const TaskArena& arena);

}  // namespace pliant
#pragma GCC visibility pop
