// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Cameras: a client follows the camera of another.

#pragma once

#include <map>

#include "hub/feed.h"

namespace pliant::serve {

class CameraFeed final : public Feed {
  public:
    using Feed::Feed;

    bool take(Client& client, const Message& message) override;
    void refresh() override;
    void leave(Client& client) override;
    void enter_scene() noexcept override { m_cameras.clear(); }

  private:
    struct Camera {
        CameraMessage newest;
        bool is_new = false;  ///< not sent yet
    };
    /// A client's wish to follow another.
    struct Follower {
        std::uint32_t leader = 0;
        bool is_told = false;  ///< whether it has the leader's camera
    };

    void set_leader(Client& client, std::uint32_t id, std::uint32_t leader);

    std::map<std::uint32_t, Camera> m_cameras;      ///< by client
    std::map<std::uint32_t, Follower> m_followers;  ///< by client
};

}  // namespace pliant::serve
