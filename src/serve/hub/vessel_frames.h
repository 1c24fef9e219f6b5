// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Encodes a catheter for clients: the wall at rest once, then the wire and the nodes of the wall
// that have moved since the client's version. Motion is detected on the transmitted values, in
// steps of 1/4096 mm, so invisible vibrations cause no traffic.

#pragma once

#include <pliant/models/drivable.h>

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "protocol/frames.h"

namespace pliant::serve {

class VesselFrames {
  public:
    /// Follows the present state. The surface at rest never changes.
    void update(const Drivable& catheter);

    /// Increases with each change.
    std::uint64_t version() const { return m_version; }
    std::shared_ptr<const std::string> surface(const Drivable& catheter, std::uint32_t step,
                                               std::uint32_t volume);
    /// Encodes the catheter, and the nodes that have moved since a version.
    std::shared_ptr<const std::string> since(std::uint64_t version, std::uint32_t step,
                                             std::uint32_t volume);

  private:
    struct Node {
        std::array<std::uint16_t, 3> halves{0, 0, 0};
        std::uint64_t changed_at = 0;
    };
    double m_radius_mm = 0;
    std::vector<Node> m_nodes;
    std::vector<Vec3d> m_catheter_mm;
    std::uint64_t m_version = 0;
    std::shared_ptr<const std::string> m_surface;
    std::shared_ptr<const std::string> m_last;  ///< cached frame from m_last_from to m_last_version
    std::uint64_t m_last_from = 0, m_last_version = 0;
};

}  // namespace pliant::serve
