// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Local models (haptics.h) for each tissue.
//
//   springs    the reaction of the held nodes and its derivative [Choi2004, Eq. 19]
//   ChainMail  the iso surface of the scan, stiffness from its grey values, and the slack of the
//              links, which limits how far the wall can be pushed
//   any other  forces only, for example of position-based constraints: the stiffness is estimated
//
// Call these functions on the thread that owns the tissue. Pass their models through
// checked_model().

#pragma once

#include <pliant/chainmail.h>
#include <pliant/haptics.h>
#include <pliant/record.h>
#include <pliant/render.h>
#include <pliant/springs.h>

#include <memory>
#include <optional>
#include <span>

#pragma GCC visibility push(default)
namespace pliant {

/// Estimate of a symmetric stiffness from the last positions and forces of a tool: each new pair
/// makes the minimal change [Powell1970].
class LearntStiffness {
  public:
    explicit LearntStiffness(double start_n_m, double largest_n_m);
    /// Restarts from a known stiffness; the last position and force are kept.
    void begin_with(const Mat3d& change_n_m);
    /// Adds a pair. @param force_n  of the tissue on the tool
    void add(Vec3d place_mm, Vec3d force_n);
    /// dF/dx for model_of_contact: symmetric, negative semi-definite.
    Mat3d change_n_m() const;

  private:
    double m_largest_n_m;
    Mat3d m_stiffness_n_m;
    bool m_has_place = false;
    Vec3d m_place_mm{0, 0, 0}, m_force_n{0, 0, 0};
};

/// Model of a tool that pushes the nodes which it holds beyond a surface, in the scene's units (mm,
/// g, s). It assumes that the other nodes follow to their equilibrium.
/// @param last  estimate for the same contact, or null. Near an instability ReactionLaw::Relaxed is
///              too stiff; the last solution's force corrects that
/// @returns an error of SpringTissue::reaction
Result<HapticModel> model_of_springs(SpringTissue& tissue, std::span<const std::int32_t> held,
                                     Vec3d surface_mm, Vec3d normal, Vec3d place_mm,
                                     LearntStiffness* last = nullptr);

struct ChainMailFeelSettings {
    double tool_radius_mm = 1.5;
    double iso_hu = -300;
    Polarity polarity = Polarity::Rising;
    double young_modulus_pa = 7500;  ///< of tissue of 40 HU; other values scale by the law's
                                     ///< softness
    double bone_n_m = 1e5;           ///< stiffness of tissue that can't give way any more
    double friction = 0.2;
    double reach_mm = 10;  ///< surfaces and limits farther away are ignored
};

/// Rows of these settings.
SettingRows<ChainMailFeelSettings> chainmail_feel_rows() noexcept;

/// Local models for the wall of a scan that ChainMail deforms. A round tool of radius a at depth d
/// beyond the surface is pushed back by
///
///   F = k d / (1 − d/L),  k = 2 a E/(1 − ν²),
///
/// the law of a flat punch [Boussinesq1885] for d far below L. L is the distance by which the wall
/// can be pushed before links are taut down to bone, or elements are at their movement limit.
class ChainMailFeel {
  public:
    /// Keeps references: volume and arena must outlive it. Trial pushes run on an internal
    /// ChainMail, so the displayed one isn't changed.
    /// @returns InvalidArgument that names the setting
    static Result<std::unique_ptr<ChainMailFeel>> create(const Volume& volume,
                                                         const ChainMailSettings& materials,
                                                         const ChainMailFeelSettings& settings,
                                                         const TaskArena& arena);
    /// As above for a scan that deforms. Walls are those of `shown`; L is that of the scan minus
    /// the displacement so far.
    static Result<std::unique_ptr<ChainMailFeel>> create(const Volume& scan, const Volume& shown,
                                                         const ChainMailSettings& materials,
                                                         const ChainMailFeelSettings& settings,
                                                         const TaskArena& arena);
    ~ChainMailFeel();

    /// Tells that the displayed volume has changed in these boxes of voxels only.
    void update(std::span<const Box3i> boxes);
    /// Switches to another iso surface.
    void set_wall(double iso_hu, Polarity polarity);

    /// Model around a tool. @param proxy_mm  the servo's last proxy
    HapticModel model(Vec3d tool_mm, Vec3d proxy_mm);

    /// Compliance of the surface at a position: stiffness at zero depth [N/m], and L [mm], infinite
    /// if it exceeds the reach.
    struct Give {
        double stiffness_n_m = 0;
        double limit_mm = 0;
    };
    Give give_at(Vec3d surface_mm, Vec3d normal);

  private:
    struct Impl;
    explicit ChainMailFeel(std::unique_ptr<Impl> impl);
    std::unique_ptr<Impl> m_impl;
};

}  // namespace pliant
#pragma GCC visibility pop
