// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A vessel for its clients: the ghost surface at rest once, then the catheter and the nodes that
// have moved since a client was told last. Moved is what differs as it is sent, in steps of 1/4096
// mm, so a wall that trembles by less than anybody could see is not sent again and again.

#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "serve/frames.h"
#include "serve/vessel_tissue.h"

namespace pliant::serve {

class VesselFrames {
  public:
    /// What is there now. The surface at rest is always the same one.
    void update(const VesselTissue& vessel);

    /// Grows with each change.
    std::uint64_t version() const { return m_version; }
    std::shared_ptr<const std::string> surface(std::uint32_t step, std::uint32_t volume);
    /// The catheter, and the nodes that have moved since that version.
    std::shared_ptr<const std::string> since(std::uint64_t version, std::uint32_t step,
                                             std::uint32_t volume);

  private:
    struct Node {
        std::array<std::uint16_t, 3> halves{0, 0, 0};
        std::uint64_t changed_at = 0;
    };
    const MadeVessel* m_vessel = nullptr;
    std::vector<Node> m_nodes;
    std::vector<Vec3d> m_catheter_mm;
    std::uint64_t m_version = 0;
    std::shared_ptr<const std::string> m_surface;
    std::shared_ptr<const std::string> m_last;  ///< since m_last_from, up to m_last_version
    std::uint64_t m_last_from = 0, m_last_version = 0;
};

}  // namespace pliant::serve
