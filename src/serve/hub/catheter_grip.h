// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Force feedback for the catheter of a served tissue. The hand's motion becomes commands like those
// of any client. While the first button is held, the hand is decoupled from the wire, to reach
// back.

#pragma once

#include <pliant/models/drivable.h>
#include <pliant/view/haptics.h>

#include <cstdint>
#include <optional>

#include "session/scene.h"

namespace pliant::serve {

class CatheterGrip {
  public:
    /// @param tool   number of the tool that drives
    /// @param scale  mm in the scene per mm of the device
    static Result<CatheterGrip> create(const Drivable& catheter, std::uint32_t tool, double scale);

    /// @param lets_go  a client stopped the device, or it is lost
    std::optional<Action> next(const HapticRecord& now, bool lets_go, const Scene& scene);
    /// Model of the force on the hand; none after the simulation has failed.
    std::optional<HapticModel> model(const HapticRecord& now, const Drivable& catheter) const;
    double ahead_mm(const HapticRecord& now, const Drivable& catheter) const;

  private:
    CatheterGrip(CatheterFeel feel, std::uint32_t tool) : m_feel(std::move(feel)), m_tool(tool) {}

    CatheterFeel m_feel;
    std::uint32_t m_tool;
    bool m_turns = false;  ///< the device measures rotation
    double m_time_s = 0;
};

}  // namespace pliant::serve
