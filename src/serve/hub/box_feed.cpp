// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "hub/box_feed.h"

#include <utility>

#include "volume/boxes.h"

namespace pliant::serve {

void BoxFeed::refresh() {
    m_frames.clear();
    m_left = m_budget;
    for (; !m_requests.empty(); m_requests.erase(m_requests.begin()))
        if (Client* client = connected(m_host, m_requests.front().client))
            answer(*client, m_requests.front());
}

void BoxFeed::request(const Client& client, const Message& message, std::uint16_t format) {
    m_requests.push_back({client.info.number, message.id, name_of(message.action), format});
}

void BoxFeed::answer(Client& client, const Request& request) {
    if (request.format == 0) {
        m_subscriptions.erase(request.client);
    } else {
        std::optional<Delivery> delivery = start_delivery();
        if (!delivery)
            return m_host.refuse(client, request.id, request.name, "limit",
                                 "expected memory for 12 bytes per voxel, found less");
        m_subscriptions.insert_or_assign(request.client,
                                         Subscription{request.format, std::move(*delivery)});
    }
    m_host.accept(client, request.id, request.name);
}

bool BoxFeed::take_seen(const Client& client, const Message& message) {
    const auto* seen = std::get_if<SeenMessage>(&message.action);
    const auto found = m_subscriptions.find(client.info.number);
    if (!seen || found == m_subscriptions.end() || seen->format != found->second.format)
        return false;
    found->second.delivery.seen(seen->step);
    return true;
}

void BoxFeed::mark(std::span<const Box3i> boxes) {
    for (auto& [number, subscription] : m_subscriptions)
        for (const Box3i& box : boxes) subscription.delivery.mark(box);
}

/// Splits a box into boxes of at most m_max_box nodes, in order.
void BoxFeed::add_parts(const Box3i& box, std::vector<Box3i>& boxes) const {
    if (box_count(box) <= m_max_box) return boxes.push_back(box);
    const Vec3i n = box.end - box.begin;
    const int axis = n.z > 1 ? 2 : n.y > 1 ? 1 : 0;
    Box3i low = box, high = box;
    low.end[axis] = high.begin[axis] = box.begin[axis] + n[axis] / 2;
    add_parts(low, boxes);
    add_parts(high, boxes);
}

void BoxFeed::add(Client& client, std::vector<Outgoing>& batch) {
    const auto found = m_subscriptions.find(client.info.number);
    if (found == m_subscriptions.end() || !is_ready() || m_left <= 0) return;
    const std::uint16_t format = found->second.format;
    Delivery& delivery = found->second.delivery;
    // Voxels have priority.
    if (client.delivery.is_due() || !delivery.is_due() || !delivery.may_send()) return;
    std::vector<Box3i> boxes;
    for (const Box3i& box : delivery.take(m_left, m_host.step(), m_host.now()))
        add_parts(box, boxes);
    m_frames.add(boxes, !delivery.is_due(), client.packs, format, batch,
                 [&](const Box3i& box, std::uint8_t flags) {
                     return encode(box, flags, format, client.packs);
                 });
    m_host.worked();
}

std::string BoxFeed::encode(const Box3i& box, std::uint8_t flags, std::uint16_t format, bool pack) {
    m_left -= box_count(box);
    return box_frame(halves_of(box, format), box,
                     {.flags = flags,
                      .count = format,
                      .step = m_host.step(),
                      .volume = m_host.scene().info().id},
                     pack);
}

bool BoxFeed::is_due(const Client& client) const {
    const auto found = m_subscriptions.find(client.info.number);
    return found != m_subscriptions.end() && is_ready() && found->second.delivery.is_due();
}

std::optional<Clock::time_point> BoxFeed::unseen_since(const Client& client) const {
    const auto found = m_subscriptions.find(client.info.number);
    if (found == m_subscriptions.end()) return {};
    return found->second.delivery.unseen_since();
}

}  // namespace pliant::serve
