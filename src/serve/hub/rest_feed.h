// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The rest field for clients that request it: rest positions and raw tissue at every 4th voxel. One
// field serves all clients, follows the volume, and is sent like overlays: after the voxels, in
// boxes of nodes. A client starts with a field at rest.

#pragma once

#include <pliant/resample.h>

#include <map>
#include <optional>
#include <span>
#include <vector>

#include "hub/feed.h"

namespace pliant::serve {

class RestFeed final : public Feed {
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
    void change_tissue() override { m_is_stale = true; }
    void enter_scene() noexcept override;

  private:
    struct Wish {
        std::uint32_t client, id;
        bool on;
    };
    void set(Client& client, const Wish& wish);
    bool make();
    std::string encode(const Box3i& nodes, std::uint8_t flags, bool pack);

    std::map<std::uint32_t, Delivery> m_deliveries;  ///< of nodes, by client
    std::vector<Wish> m_wishes;                      ///< of this step
    std::optional<RestField> m_field;                ///< present while a client requests it
    bool m_is_stale = false;                         ///< must be rebuilt
    SharedFrames m_frames;
    std::int64_t m_left = 0;  ///< budget of nodes in this step
};

}  // namespace pliant::serve
