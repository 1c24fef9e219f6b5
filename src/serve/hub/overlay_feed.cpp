// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "hub/overlay_feed.h"

#include <algorithm>
#include <utility>

#include "protocol/half.h"
#include "protocol/limits.h"
#include "session/guarded.h"

namespace pliant::serve {

bool OverlayFeed::take(Client& client, const Message& message) {
    if (const auto* wish = std::get_if<OverlayMessage>(&message.action)) {
        m_wishes.push_back({client.info.number, message.id, wish->kind});
        return true;
    }
    const auto* seen = std::get_if<SeenMessage>(&message.action);
    const auto found = m_subscriptions.find(client.info.number);
    if (!seen || found == m_subscriptions.end() || seen->format != format_of(found->second.kind))
        return false;
    found->second.delivery.seen(seen->step);
    return true;
}

bool OverlayFeed::follow(std::span<const Box3i> boxes) {
    for (auto& [number, subscription] : m_subscriptions)
        for (const Box3i& box : boxes) subscription.delivery.mark(box);
    return true;
}

void OverlayFeed::refresh() {
    m_frames.clear();
    m_left = kMaxOverlayVoxels;
    m_step_ms = 0;
    if (!m_subscriptions.empty()) m_host.keep_sources();
    for (; !m_wishes.empty(); m_wishes.erase(m_wishes.begin())) {
        const Wish wish = m_wishes.front();
        Client* client = connected(m_host, wish.client);
        if (client && !guarded("owner", [&] { set(*client, wish); }))
            m_host.tell_later(client->connection, wish.id, "overlay");
    }
}

void OverlayFeed::set(Client& client, const Wish& wish) {
    if (wish.kind != OverlayKind::None && !m_host.keep_sources())
        return m_host.say(
            client, outcome_text(wish.id, "overlay", 0,
                                 {.error_code = "limit",
                                  .message = "overlay: expected memory for 12 bytes per voxel, "
                                             "found less"}));
    Subscription subscription{wish.kind, Delivery(m_host.scene().info().grid.size)};
    subscription.delivery.mark(m_host.deformed());
    std::string text = outcome_text(wish.id, "overlay", m_host.step(), {});
    if (wish.kind == OverlayKind::None)
        m_subscriptions.erase(client.info.number);
    else
        m_subscriptions.insert_or_assign(client.info.number, std::move(subscription));
    m_host.say(client, std::move(text));
}

void OverlayFeed::add(Client& client, std::vector<Outgoing>& batch) {
    const auto found = m_subscriptions.find(client.info.number);
    if (found == m_subscriptions.end()) return;
    const OverlayKind kind = found->second.kind;
    Delivery& delivery = found->second.delivery;
    // Voxels have priority.
    if (client.delivery.is_due() || !delivery.is_due() || !delivery.may_send() || m_left <= 0)
        return;
    const auto start = Clock::now();
    const auto boxes = delivery.take(m_left, m_host.step(), m_host.now());
    const bool ends = !delivery.is_due();
    for (std::size_t n = 0; n < boxes.size(); ++n) {
        const std::uint8_t flags = ends && n + 1 == boxes.size() ? kFrameLastOfStep : 0;
        batch.push_back({false, m_frames.get(boxes[n], flags, client.packs, format_of(kind), [&] {
                             return encode(boxes[n], flags, client.packs, kind);
                         })});
    }
    m_host.worked();
    m_step_ms += std::chrono::duration<double, std::milli>(Clock::now() - start).count();
    m_last_ms = m_step_ms;
}

std::string OverlayFeed::encode(const Box3i& box, std::uint8_t flags, bool pack, OverlayKind kind) {
    const Vec3i n = box.end - box.begin;
    const std::size_t count = std::size_t(n.x) * std::size_t(n.y) * std::size_t(n.z);
    m_left -= std::int64_t(count);
    std::vector<float> values(count);
    const Scene& scene = m_host.scene();
    if (kind == OverlayKind::Displacement)
        scene.live().displacement_mm(box, values);
    else
        scene.live().jacobian(box, values);
    std::vector<std::uint16_t> halves(count);
    std::transform(values.begin(), values.end(), halves.begin(), half_from_float);
    const FrameHeader header{
        .flags = flags, .count = format_of(kind), .step = m_host.step(), .volume = scene.info().id};
    return box_frame(halves, box, header, pack);
}

void OverlayFeed::lost(Client& client) {
    const auto found = m_subscriptions.find(client.info.number);
    if (found != m_subscriptions.end()) found->second.delivery.come_back({});
}

const OverlayFeed::Subscription* OverlayFeed::of(const Client& client) const {
    const auto found = m_subscriptions.find(client.info.number);
    return found == m_subscriptions.end() ? nullptr : &found->second;
}

bool OverlayFeed::is_due(const Client& client) const {
    const Subscription* subscription = of(client);
    return subscription && subscription->delivery.is_due();
}

std::optional<Clock::time_point> OverlayFeed::unseen_since(const Client& client) const {
    const Subscription* subscription = of(client);
    if (!subscription) return {};
    return subscription->delivery.unseen_since();
}

void OverlayFeed::leave(Client& client) {
    m_subscriptions.erase(client.info.number);
}

void OverlayFeed::enter_scene() noexcept {
    m_subscriptions.clear();
    m_wishes.clear();
    m_last_ms = 0;
}

}  // namespace pliant::serve
