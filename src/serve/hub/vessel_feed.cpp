// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A catheter and the wall around it for clients that request them. Like tools, only the newest
// state is sent. Its numbers are part of the state message.

#include <map>

#include "hub/feed.h"
#include "hub/vessel_frames.h"

namespace pliant::serve {
namespace {

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

bool VesselFeed::take(Client& client, const Message& message) {
    const auto* wish = std::get_if<VesselMessage>(&message.action);
    if (!wish) return false;
    if (wish->on)
        m_sent[client.info.number] = {};
    else
        m_sent.erase(client.info.number);
    m_host.accept(client, message.id, "vessel");
    return true;
}

bool VesselFeed::follow(std::span<const Box3i>) {
    m_has_moved = true;
    return true;
}

void VesselFeed::refresh() {
    const Scene& scene = m_host.scene();
    const Drivable* const catheter = scene.tissue().drivable();
    if (catheter && scene.choice().model != m_model) {  // perhaps with another wall
        m_model = scene.choice().model;
        for (auto& [client, sent] : m_sent) sent = {};
        m_frames = {};
    }
    if (catheter && (m_has_moved || m_frames.version() == 0)) m_frames.update(*catheter);
    m_has_moved = false;
}

void VesselFeed::add(Client& client, std::vector<Outgoing>& batch) {
    const auto found = m_sent.find(client.info.number);
    const Drivable* const catheter = m_host.scene().tissue().drivable();
    if (found == m_sent.end() || !catheter) return;
    const std::uint32_t volume = m_host.scene().info().id;
    const Sent& sent = found->second;
    if (!sent.surface) batch.push_back({false, m_frames.surface(*catheter, m_host.step(), volume)});
    if (sent.version == m_frames.version()) return;
    batch.push_back({false, m_frames.since(sent.version, m_host.step(), volume)});
}

void VesselFeed::sent(Client& client) noexcept {
    const auto found = m_sent.find(client.info.number);
    if (found != m_sent.end() && m_host.scene().tissue().drivable())
        found->second = {true, m_frames.version()};
}

void VesselFeed::leave(Client& client) {
    m_sent.erase(client.info.number);
}

void VesselFeed::enter_scene() noexcept {
    m_sent.clear();
    m_frames = {};
    m_model.clear();
}

}  // namespace

std::unique_ptr<Feed> make_vessel_feed(FeedHost& host) {
    return std::make_unique<VesselFeed>(host);
}

}  // namespace pliant::serve
