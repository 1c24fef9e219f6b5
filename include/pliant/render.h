// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Pictures of a volume: endoscopic views by first-hit ray casting, and sections.

#pragma once

#include <pliant/result.h>
#include <pliant/tasks.h>
#include <pliant/volume.h>

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#pragma GCC visibility push(default)
namespace pliant {

class RestField;

struct Rgb8 {
    std::uint8_t r, g, b;
    friend constexpr bool operator==(const Rgb8&, const Rgb8&) = default;
};

/// 8-bit sRGB picture, rows from the top.
struct Image {
    int width = 0;
    int height = 0;
    std::vector<Rgb8> pixels;
};

Status write_png(const std::filesystem::path& path, const Image& image);

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

/// Suggests a first view of a scan: deep inside a lumen, along its longest free path. Prefers
/// enclosed air over the air around the patient, and tubes over lungs.
/// @returns nullopt if no voxel is on the lumen's side of the threshold
std::optional<Endoscope> find_endoscope(const Volume& volume, double iso_hu, Polarity polarity,
                                        const TaskArena& arena);

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

/// Casts rays at one volume; a volume that check_volume refuses counts as air. The constructor
/// builds the min/max bricks for empty-space skipping; a change of the threshold needs no rebuild.
/// Keeps references: volume and arena must outlive it, at a constant address.
///
///   RayCaster caster(live.volume(), arena);          // a LiveDeformation
///   tissue.push(…);
///   if (const auto update = live->update()) caster.update(update->boxes);
///   show(caster.endoscope_view(endoscope, 512, 512));
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

}  // namespace pliant
#pragma GCC visibility pop
