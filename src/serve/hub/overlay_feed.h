// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Overlays: numbers of the deformation beside the voxels, displacement or volume ratio of the
// tissue at a voxel. A client starts with an overlay at rest, so it receives only voxels that were
// ever deformed.

#pragma once

#include <span>
#include <vector>

#include "hub/box_feed.h"
#include "protocol/limits.h"

namespace pliant::serve {

class OverlayFeed final : public BoxFeed {
  public:
    explicit OverlayFeed(FeedHost& host) : BoxFeed(host, kMaxOverlayVoxels) {}

    bool take(Client& client, const Message& message) override;
    bool follow(std::span<const Box3i> boxes) override;
    void refresh() override;
    void add(Client& client, std::vector<Outgoing>& batch) override;
    void enter_scene() noexcept override;

    /// Duration of the last overlays [ms].
    double last_ms() const { return m_last_ms; }

  private:
    std::optional<Delivery> start_delivery() override;
    std::vector<std::uint16_t> halves_of(const Box3i& box, std::uint16_t format) override;

    double m_step_ms = 0;  ///< of this step
    double m_last_ms = 0;
};

}  // namespace pliant::serve
