// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The catheter of a served vessel in the hand of a device: what the hand does to it, as commands
// like any client's, and what it feels of it. While the first button is held, the hand has let go
// of the wire, to reach back for more of it.

#pragma once

#include <pliant/haptics_catheter.h>
#include <pliant/haptics_servo.h>

#include <cstdint>
#include <optional>

#include "serve/scene.h"

namespace pliant::serve {

class CatheterGrip {
  public:
    /// @param tool  the number under which it drives
    /// @param scale  mm in the scene for each of the device's
    static Result<CatheterGrip> create(const VesselTissue& vessel, std::uint32_t tool,
                                       double scale);

    /// @param lets_go  somebody stopped it, or the device is lost
    std::optional<Action> next(const HapticRecord& now, bool lets_go, const Scene& scene);
    /// None where the simulation has come to its end.
    std::optional<HapticModel> model(const HapticRecord& now, const VesselTissue& vessel) const;
    double ahead_mm(const HapticRecord& now, const VesselTissue& vessel) const;

  private:
    CatheterGrip(CatheterFeel feel, std::uint32_t tool) : m_feel(std::move(feel)), m_tool(tool) {}

    CatheterFeel m_feel;
    std::uint32_t m_tool;
    bool m_turns = false;  ///< the device knows how it is turned
    double m_time_s = 0;
};

/// The rail's direction: where the guide leads.
Vec3d forward_of(const VesselTissue& vessel);

}  // namespace pliant::serve
