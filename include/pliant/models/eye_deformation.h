// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Virtual endoscopy in one call per frame [Draeger2005, 4.4]: the eye moves, tissue makes way, the
// volume follows.
//
// @code
//   auto endoscopy = EyeDeformation::create(scan, {}, arena);
//   while (running) {
//       auto moved = (*endoscopy)->deform(eye, wanted_eye());
//       if (!moved) break;      // moved.error(): one line; nothing has changed
//       eye = moved->eye_mm;    // never in tissue
//       for (const Box3i& box : moved->boxes) show((*endoscopy)->volume(), box);
//   }
// @endcode

#pragma once

#include <pliant/chainmail.h>
#include <pliant/result.h>
#include <pliant/tool.h>
#include <pliant/volume.h>

#include <memory>
#include <span>

#pragma GCC visibility push(default)
namespace pliant {

struct EyeSettings {
    double radius_mm = 2;   ///< sphere around the eye that stays free, above 0
    TissueValues values{};  ///< values of the scan that are tissue
    ChainMailSettings materials{};
};

struct EyeMove {
    Vec3d eye_mm{0, 0, 0};  ///< valid position of the eye, LPS; the wanted one if it could go there
    bool touched = false;   ///< whether tissue moved
    bool is_stopped = false;  ///< whether bone, a movement limit or a closed lumen stopped it
    std::span<const Box3i> boxes{};  ///< voxels that may have changed; valid until the next call
    double solve_ms = 0, resample_ms = 0;
};

/// Thread safety: one thread.
class EyeDeformation {
  public:
    /// Keeps references: scan and arena must outlive it.
    /// @returns InvalidArgument that names the setting
    static Result<std::unique_ptr<EyeDeformation>> create(const Volume& scan,
                                                          const EyeSettings& settings,
                                                          const TaskArena& arena) noexcept;
    ~EyeDeformation();
    EyeDeformation(const EyeDeformation&) = delete;
    EyeDeformation& operator=(const EyeDeformation&) = delete;

    /// Moves the eye in a straight line, finds the wall between the two positions, pushes it away,
    /// and brings the volume up to date. Throws nothing.
    /// @param last_eye_mm  position that the last call returned, or one in the lumen, LPS
    /// @returns InvalidArgument for a path that is not finite, longer than 500 mm or outside of the
    ///          scan; LimitExceeded if memory runs out. Then the tissue has not changed
    Result<EyeMove> deform(Vec3d last_eye_mm, Vec3d eye_mm) noexcept;

    /// The deformed scan.
    const Volume& volume() const;
    /// The tissue, for history, relaxation, cuts; deform() shows their effect with its next call.
    ChainMail& tissue();

  private:
    struct Impl;
    explicit EyeDeformation(std::unique_ptr<Impl> impl);
    std::unique_ptr<Impl> m_impl;
};

}  // namespace pliant
#pragma GCC visibility pop
