// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Cameras: a client follows the camera of another.

#include <map>

#include "hub/feed.h"
#include "protocol/limits.h"

namespace pliant::serve {
namespace {

class CameraFeed final : public Feed {
  public:
    using Feed::Feed;

    bool take(Client& client, const Message& message) override {
        if (const auto* camera = std::get_if<CameraMessage>(&message.action)) {
            m_cameras[client.info.number] = {*camera, true};
            return true;
        }
        if (const auto* wish = std::get_if<FollowMessage>(&message.action)) {
            set_leader(client, message.id, wish->client);
            return true;
        }
        return false;
    }
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

void CameraFeed::set_leader(Client& client, std::uint32_t id, std::uint32_t leader) {
    const std::uint32_t own = client.info.number;
    if (leader != 0 && (leader == own || !connected(m_host, leader)))
        return m_host.refuse(
            client, id, "follow", "out_of_range",
            "client: expected another one that is connected, found " + std::to_string(leader));
    if (leader == 0)
        m_followers.erase(own);
    else
        m_followers[own] = {leader, false};
    m_host.accept(client, id, "follow");
}

void CameraFeed::refresh() {
    for (auto& [number, follower] : m_followers) {
        const auto camera = m_cameras.find(follower.leader);
        if (camera == m_cameras.end() || (follower.is_told && !camera->second.is_new)) continue;
        Client* const client = connected(m_host, number);
        if (!client || client->texts.size() >= kMaxWaitingCameras) continue;  // the next one does
        m_host.send(*client, camera_text(follower.leader, camera->second.newest));
        follower.is_told = true;
    }
    for (auto& [number, camera] : m_cameras) camera.is_new = false;
}

void CameraFeed::leave(Client& client) {
    const std::uint32_t gone = client.info.number;
    m_cameras.erase(gone);
    m_followers.erase(gone);
    std::erase_if(m_followers, [&](const auto& entry) {
        if (entry.second.leader != gone) return false;
        if (Client* const follower = connected(m_host, entry.first))
            m_host.send(*follower, camera_text(gone, {}));
        return true;
    });
}

}  // namespace

std::unique_ptr<Feed> make_camera_feed(FeedHost& host) {
    return std::make_unique<CameraFeed>(host);
}

}  // namespace pliant::serve
