// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Local models (haptics.h) of each tissue.
//
//   springs    the reaction of the held nodes and its derivative [Choi2004, Eq. 19]
//   ChainMail  the iso surface of the scan, stiffness from its grey values, and the slack of the
//              links, which says where the wall stops to yield
//   any other  forces alone, as of position-based constraints: the stiffness is learnt from them
//
// All are for the thread that owns the tissue. What they make goes through checked_model().

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

/// A symmetric stiffness that fits the last places and forces of a tool: each new pair changes it
/// as little as possible [Powell1970].
class LearntStiffness {
  public:
    explicit LearntStiffness(double start_n_m, double largest_n_m);
    /// Begins again with a stiffness that is known, beside the last place and force.
    void begin_with(const Mat3d& change_n_m);
    /// What was found at a place. @param force_n  of the tissue on the tool
    void add(Vec3d place_mm, Vec3d force_n);
    /// dF/dx, as model_of_contact wants it: symmetric, never positive.
    Mat3d change_n_m() const;

  private:
    double m_largest_n_m;
    Mat3d m_stiffness_n_m;
    bool m_has_place = false;
    Vec3d m_place_mm{0, 0, 0}, m_force_n{0, 0, 0};
};

/// Of a tool that pushes nodes which it holds in front of it, beyond a surface, in the scene's
/// units (mm, g, s). The other nodes are taken to follow to their equilibrium.
/// @param last  of the same contact, or null. Where the shape is about to give way,
///              ReactionLaw::Relaxed is too stiff; the last solution's force corrects that
/// @returns the errors of SpringTissue::reaction
Result<HapticModel> model_of_springs(SpringTissue& tissue, std::span<const std::int32_t> held,
                                     Vec3d surface_mm, Vec3d normal, Vec3d place_mm,
                                     LearntStiffness* last = nullptr);

struct ChainMailFeelSettings {
    double tool_radius_mm = 1.5;
    double iso_hu = -300;
    Polarity polarity = Polarity::Rising;
    double young_modulus_pa = 7500;  ///< of tissue of 40 HU; others by the law's softness
    double bone_n_m = 1e5;           ///< what nothing gives way any more feels like
    double friction = 0.2;
    double reach_mm = 10;  ///< surfaces and limits farther away don't matter
};

/// Rows of these settings.
SettingRows<ChainMailFeelSettings> chainmail_feel_rows() noexcept;

/// How the wall of a scan feels that ChainMail deforms. A round tool of radius a, d beyond the
/// surface, is pushed back by
///
///   F = k d / (1 − d/L),  k = 2 a E/(1 − ν²),
///
/// which is a flat punch's law [Boussinesq1885] until d comes near L: how far the wall can be
/// pushed there before links are taut down to bone, or elements at their movement limit.
class ChainMailFeel {
  public:
    /// Keeps references: volume and arena must outlive it. It has a ChainMail of its own to try
    /// pushes with; the one that is seen isn't touched.
    /// @returns InvalidArgument that names the setting
    static Result<std::unique_ptr<ChainMailFeel>> create(const Volume& volume,
                                                         const ChainMailSettings& materials,
                                                         const ChainMailFeelSettings& settings,
                                                         const TaskArena& arena);
    /// The same of a scan that is deformed meanwhile: walls are those of `shown`, how far they can
    /// be pushed is what the scan says, less how far they have been.
    static Result<std::unique_ptr<ChainMailFeel>> create(const Volume& scan, const Volume& shown,
                                                         const ChainMailSettings& materials,
                                                         const ChainMailFeelSettings& settings,
                                                         const TaskArena& arena);
    ~ChainMailFeel();

    /// What is shown has changed in these boxes of voxels, and nowhere else.
    void update(std::span<const Box3i> boxes);
    /// Another surface from now on.
    void set_wall(double iso_hu, Polarity polarity);

    /// Around a tool, whose proxy is where the servo last had it.
    HapticModel model(Vec3d tool_mm, Vec3d proxy_mm);

    /// Of the surface at a place: stiffness at no depth [N/m], and L [mm], infinite where the reach
    /// isn't enough to see it.
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
