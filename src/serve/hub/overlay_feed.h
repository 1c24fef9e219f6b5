// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Overlays: numbers of the deformation beside the voxels, displacement or volume ratio of the
// tissue at a voxel. They are sent like voxels, but after them, within a budget per step. A client
// starts with an overlay at rest, so it receives only voxels that were ever deformed.

#pragma once

#include <map>
#include <span>
#include <string>
#include <vector>

#include "hub/feed.h"

namespace pliant::serve {

class OverlayFeed final : public Feed {
  public:
    using Feed::Feed;

    bool take(Client& client, const Message& message) override;
    bool follow(std::span<const Box3i> boxes) override;
    void refresh() override;
    void add(Client& client, std::vector<Outgoing>& batch) override;
    void lost(Client& client) override;
    bool is_due(const Client& client) const override;
    std::optional<Clock::time_point> unseen_since(const Client& client) const override;
    void leave(Client& client) override;
    void enter_scene() noexcept override;

    /// Duration of the last overlays [ms].
    double last_ms() const { return m_last_ms; }

  private:
    struct Wish {
        std::uint32_t client, id;
        OverlayKind kind;
    };
    struct Subscription {
        OverlayKind kind;
        Delivery delivery;
    };
    void set(Client& client, const Wish& wish);
    const Subscription* of(const Client& client) const;
    std::string encode(const Box3i& box, std::uint8_t flags, bool pack, OverlayKind kind);

    std::map<std::uint32_t, Subscription> m_subscriptions;  ///< by client
    std::vector<Wish> m_wishes;                             ///< of this step
    SharedFrames m_frames;
    std::int64_t m_left = 0;  ///< budget of voxels in this step
    double m_step_ms = 0;     ///< of this step
    double m_last_ms = 0;
};

}  // namespace pliant::serve
