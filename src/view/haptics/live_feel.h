// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Local models of a tissue that tools push and clients view at the same time.
//
// A wall that gives way would not be felt, because the tool never gets beyond it. The depth is
// therefore measured from the wall before the contact: the model's volume follows the shown volume
// while the tool is free, and is frozen during a contact.
//
//     shown  ───.   .───  the present wall around the tool      depth: from the tool to the
//                '-'                                            frozen wall
//     before ───────────  the frozen wall
//
// ChainMail has no forces: law and limit come from ChainMailFeel. Springs have a force on the tool;
// its stiffness is estimated from successive forces.

#pragma once

#include <pliant/view/haptics.h>

#include <memory>
#include <span>
#include <vector>

#include <pliant/tissue.h>
#include "haptics/walls.h"

#pragma GCC visibility push(default)  // for other components
namespace pliant {

class LiveFeel {
  public:
    /// Keeps references: scan, shown (the deformed scan, updated by its owner) and arena must
    /// outlive it. @param tool  number of the tool that pushes
    /// @returns an error of ChainMailFeel::create
    static Result<std::unique_ptr<LiveFeel>> create(const Volume& scan, const Volume& shown,
                                                    const ChainMailSettings& materials,
                                                    const ChainMailFeelSettings& settings,
                                                    std::uint32_t tool, const TaskArena& arena);

    /// Tells that the shown volume has changed in these boxes of voxels.
    void changed(std::span<const Box3i> boxes);
    void set_wall(double iso_hu, Polarity polarity);

    /// Moves the tool and its proxy. @returns whether the tool is beyond the wall
    bool follow(Vec3d tool_mm, Vec3d proxy_mm);
    bool touches() const { return m_touches; }
    /// Contact with the wall. @pre touches()
    const WallContact& contact() const { return m_contact; }

    /// Model at the tool's position in the last follow(). @param pushed_mm  position of the
    /// tissue's tool, which may have been stopped earlier
    HapticModel model(Tissue& tissue, Vec3d pushed_mm);

  private:
    LiveFeel(const Volume& shown, const ChainMailFeelSettings& settings, std::uint32_t tool);
    void take_over();

    const Volume& m_shown;
    Volume m_before;  ///< the shown volume, frozen during a contact
    ChainMailFeelSettings m_settings;
    std::uint32_t m_tool;
    std::unique_ptr<ChainMailFeel> m_feel;
    std::vector<Box3i> m_waiting;  ///< changed during the contact
    HapticModel m_model;           ///< from ChainMail's law
    WallContact m_contact;
    Vec3d m_position_mm{0, 0, 0};
    bool m_touches = false;
    LearntStiffness m_learnt;
};

}  // namespace pliant
#pragma GCC visibility pop
