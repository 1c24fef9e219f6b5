// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Pictures of a volume: the endoscope's view by first-hit ray casting, and sections.

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

/// Which crossing of the threshold is the wall.
enum class Polarity {
    Rising,   ///< air-filled lumen: the wall is brighter than where the camera is
    Falling,  ///< contrast-filled vessel: the wall is darker
};

/// How the endoscope's picture is lit and coloured.
enum class Style {
    Plain,  ///< one colour, a light in the lens: shape alone, for measuring and research
    Real,   ///< lamps beside the lens, automatic exposure, colours of the tissue, wet
};

/// Which lumen it is: its colours in the style Real.
enum class Lining { Airway, Colon, Sinus, Vessel };

/// Shape of the picture in the style Real; beyond it is black.
enum class FieldStop { Round, Octagon, Full };

/// The endoscope: a pin-hole camera with barrel distortion and a light at the lens.
struct Endoscope {
    Vec3d eye_mm{0, 0, 0};  ///< LPS
    Vec3d look{0, 1, 0};    ///< LPS, any length > 0
    Vec3d up{0, 0, 1};      ///< LPS; zero or parallel to look: superior or anterior is taken
    double field_of_view_deg = 80;    ///< across the picture's height, before distortion
    double barrel_distortion = 0.15;  ///< 0: none; r_ray = r·(1 + k·r²), r = 1 at the edge
    double iso_hu = -500;             ///< threshold of the surface
    Polarity polarity = Polarity::Rising;
    double fog_distance_mm = 120;  ///< light falls to 1/e over this; 0: no fog
    Rgb8 surface{222, 150, 134};   ///< colour of the tissue in full light
    Rgb8 fog{8, 6, 8};             ///< colour far away, and where no ray hits
    Style style = Style::Plain;
    // Of the style Real, which knows neither fog nor a colour of the surface.
    Lining lining = Lining::Airway;
    FieldStop field_stop = FieldStop::Round;
    /// Of a volume that is deformed: anchors blood vessels to the tissue, shows raw faces. Must
    /// outlive the calls; none: as if nothing had moved.
    const RestField* rest = nullptr;
};

/// A view for a scan that nobody has looked at yet: deep inside a lumen, along its longest free
/// way. Prefers air that is closed in over the air around the patient, and tubes over lungs.
/// @returns nothing if no place is on the lumen's side of the threshold
std::optional<Endoscope> find_endoscope(const Volume& volume, double iso_hu, Polarity polarity,
                                        const TaskArena& arena);

/// The longest free way from an eye [mm, LPS] that ends at a wall: a good direction to look in.
/// @returns a unit vector, or nothing if no wall is in view
std::optional<Vec3d> find_look(const Volume& volume, Vec3d eye_mm, double iso_hu, Polarity polarity,
                               const TaskArena& arena);

/// A view of a place on the tissue that is about to be pushed: some 15…45 mm away (closer where the
/// lumen is narrow), with nothing in between and room around the eye, against the push or beside
/// it. Where there is no such place, a lumen elsewhere or a place outside that looks that way.
/// @param push_mm  any length; zero: from any side
Endoscope aim_endoscope(const Volume& volume, Vec3d target_mm, Vec3d push_mm, double iso_hu,
                        Polarity polarity, const TaskArena& arena);

enum class Orientation { Axial, Coronal, Sagittal };

/// A section through a point, perpendicular to a world axis, in the radiological convention
/// (patient's right on the left of the picture; anterior or head up).
struct Section {
    Orientation orientation = Orientation::Axial;
    Vec3d point_mm{0, 0, 0};  ///< LPS; the crosshair is drawn here
    double window_hu = 1500;
    double level_hu = -200;
    double width_mm = 0;  ///< what the picture's width shows; 0: the whole volume
    bool crosshair = true;
};

/// What a value is worth in a blended view: nothing below the window, then more and more opaque up
/// to its upper end.
struct TransferFunction {
    double window_hu = 500;
    double level_hu = 150;
    double opacity_per_mm = 0.25;  ///< extinction at the window's upper end [1/mm]
    Rgb8 dim{150, 60, 40};         ///< colour at the window's lower end
    Rgb8 bright{255, 250, 240};    ///< and at its upper end
};

/// Where a ray first meets the surface.
struct RayHit {
    double distance_mm;  ///< from the ray's origin
    Vec3d point_mm;      ///< LPS
    Vec3d normal;        ///< unit, towards the side of the camera
};

/// Casts rays at one volume; one that check_volume refuses is air throughout. Building it makes the
/// min/max bricks that skip empty space; changing the threshold costs nothing. Keeps references:
/// volume and arena must outlive it, and stay where they are.
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

    /// The volume has changed in these boxes of voxels, and nowhere else. Afterwards all is as if
    /// the caster had been built anew.
    /// @pre nobody casts meanwhile; boxes lie inside the grid
    void update(std::span<const Box3i> boxes);

    /// First crossing of iso_hu along origin + t·direction, t > 0, exact for the trilinear
    /// interpolant. Rising: from below iso to ≥ iso; falling: the reverse. An origin inside the
    /// tissue sees the next wall, after the ray has left the tissue. Beyond the outermost voxel
    /// centres there is nothing to hit.
    /// @param direction  world, any length > 0
    std::optional<RayHit> first_hit(Vec3d origin_mm, Vec3d direction, double iso_hu,
                                    Polarity polarity) const;

    /// Many rays from one eye, in vectors: the same crossings as first_hit finds, up to rounding,
    /// and the same bits on every machine and for any number of threads. It is fastest where rays
    /// that follow each other lie close together, such as those of 4 × 2 pixels.
    /// @param directions  world, of any length; those without one hit nothing
    /// @param[out] distances  as many, in lengths of each direction (unit vectors: mm); infinite
    ///                        where there is no hit
    void first_hits(Vec3d eye_mm, std::span<const Vec3d> directions, double iso_hu,
                    Polarity polarity, std::span<double> distances) const;

    Image endoscope_view(const Endoscope& endoscope, int width, int height) const;

    /// What is under a point of the endoscope's picture [pixels, from the top left corner].
    std::optional<RayHit> pick(const Endoscope& endoscope, int width, int height, double x,
                               double y) const;

    /// The place on the surface that is nearest to a point, of either polarity, to 0.02 mm or a
    /// hundredth of the distance. A sphere of radius within_mm touches the surface if there is one.
    /// @returns distance and place; the normal as first_hit has it
    std::optional<RayHit> nearest_surface(Vec3d point_mm, double within_mm, double iso_hu,
                                          Polarity polarity = Polarity::Rising) const;

    /// The volume as a medium that shines and dims: alpha blending along each ray, with shading
    /// where the values change steeply. The endoscope gives camera and background (its fog's
    /// colour); its threshold and surface count for nothing.
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
    Section section;      ///< point, window and level for all three; orientation is not used
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
