// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A catheter and the wall around it for clients that request them. Like tools, only the newest
// state is sent. Its numbers are part of the state message.

#pragma once

#include <map>
#include <string>
#include <vector>

#include "hub/feed.h"
#include "hub/vessel_frames.h"

namespace pliant::serve {

class VesselFeed final : public Feed {
  public:
    using Feed::Feed;

    bool take(Client& client, const Message& message) override;
    bool follow(std::span<const Box3i> boxes) override;
    void refresh() override;
    void add(Client& client, std::vector<Outgoing>& batch) override;
    void sent(Client& client) noexcept override;
    void leave(Client& client) override;
    void enter_scene() noexcept override;

  private:
    struct Sent {
        bool surface = false;
        std::uint64_t version = 0;
    };
    std::map<std::uint32_t, Sent> m_sent;  ///< by client
    std::string m_model;                   ///< model of the frames' tissue
    VesselFrames m_frames;
    bool m_has_moved = false;
};

}  // namespace pliant::serve
