// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// What is felt of a tissue that the same tool pushes, and others may too, while it is shown.
//
// A wall that gives way would be felt no more, as the tool never gets beyond it. So what is felt is
// how far the tool has come beyond the wall as it was when the tool touched it: the shown volume is
// followed as long as nothing touches, and stands still while something does.
//
//     shown  ───.   .───  the wall now, around the tool         depth: from the tool to the
//                '-'                                            wall of before
//     before ───────────  what is felt of it
//
// ChainMail knows no forces: law and limit are those of ChainMailFeel. Springs do: their force on
// the tool, with the stiffness learnt from the last two.

#pragma once

#include <pliant/haptics_models.h>

#include <memory>
#include <span>
#include <vector>

#include "haptics/walls.h"
#include "scene/tissue.h"

#pragma GCC visibility push(default)  // for other components
namespace pliant {

class LiveFeel {
  public:
    /// Keeps references: scan, shown (the deformed scan, which is kept up to date) and arena must
    /// outlive it. @param tool  the number under which it pushes
    /// @returns the errors of ChainMailFeel::create
    static Result<std::unique_ptr<LiveFeel>> create(const Volume& scan, const Volume& shown,
                                                    const ChainMailSettings& materials,
                                                    const ChainMailFeelSettings& settings,
                                                    std::uint32_t tool, const TaskArena& arena);

    /// The shown volume has changed in these boxes of voxels.
    void changed(std::span<const Box3i> boxes);
    void set_wall(double iso_hu, Polarity polarity);

    /// Where the tool and its proxy are now. @returns whether it is beyond the wall
    bool follow(Vec3d tool_mm, Vec3d proxy_mm);
    bool touches() const { return m_touches; }
    /// Of the wall that the tool is beyond. @pre touches()
    const WallContact& contact() const { return m_contact; }

    /// Of the place that follow() was told last. @param pushed_mm  where the tissue's own tool is,
    /// which may have been stopped before the tool
    HapticModel model(Tissue& tissue, Vec3d pushed_mm);

  private:
    LiveFeel(const Volume& shown, const ChainMailFeelSettings& settings, std::uint32_t tool);
    void take_over();

    const Volume& m_shown;
    Volume m_before;  ///< the shown one, as it was when the tool didn't touch
    ChainMailFeelSettings m_settings;
    std::uint32_t m_tool;
    std::unique_ptr<ChainMailFeel> m_feel;
    std::vector<Box3i> m_waiting;  ///< that have changed since
    HapticModel m_model;           ///< by ChainMail's law
    WallContact m_contact;
    Vec3d m_place_mm{0, 0, 0};
    bool m_touches = false;
    LearntStiffness m_learnt;
};

}  // namespace pliant
#pragma GCC visibility pop
