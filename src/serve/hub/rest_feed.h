// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The rest field for clients that request it: rest positions and raw tissue at every 4th voxel. One
// field serves all clients, and follows the volume. A client starts with a field at rest.

#pragma once

#include <pliant/resample.h>

#include <optional>
#include <span>
#include <vector>

#include "hub/box_feed.h"
#include "protocol/limits.h"

namespace pliant::serve {

class RestFeed final : public BoxFeed {
  public:
    explicit RestFeed(FeedHost& host) : BoxFeed(host, kMaxRestNodes, kMaxRestNodes) {}

    bool take(Client& client, const Message& message) override;
    bool follow(std::span<const Box3i> boxes) override;
    void refresh() override;
    void change_tissue() noexcept override { m_is_stale = true; }
    void enter_scene() noexcept override;

  private:
    bool make();
    std::optional<Delivery> start_delivery() override;
    bool is_ready() const override { return m_field.has_value(); }
    std::vector<std::uint16_t> halves_of(const Box3i& nodes, std::uint16_t format) override;

    std::optional<RestField> m_field;  ///< present while a client requests it
    bool m_is_stale = false;           ///< must be rebuilt
};

}  // namespace pliant::serve
