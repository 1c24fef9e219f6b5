// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "hub/rest_feed.h"

#include <algorithm>
#include <utility>

#include "protocol/limits.h"
#include "session/guarded.h"

namespace pliant::serve {
namespace {

/// Splits a box into boxes of at most kMaxRestNodes nodes, in order.
void add_split(const Box3i& nodes, std::vector<Box3i>& boxes) {
    if (node_count(nodes) <= kMaxRestNodes) return boxes.push_back(nodes);
    const Vec3i n = nodes.end - nodes.begin;
    const int axis = n.z > 1 ? 2 : n.y > 1 ? 1 : 0;
    Box3i low = nodes, high = nodes;
    low.end[axis] = high.begin[axis] = nodes.begin[axis] + n[axis] / 2;
    add_split(low, boxes);
    add_split(high, boxes);
}

/// Marks the parts of rows that are not at rest.
void mark_moved(const RestField& field, Delivery& delivery) {
    if (field.at_rest()) return;
    const Vec3i n = field.counts();
    const auto* row = field.halves().data();
    for (int k = 0; k < n.z; ++k)
        for (int j = 0; j < n.y; ++j, row += 4 * std::ptrdiff_t(n.x)) {
            const auto* end = row + 4 * std::ptrdiff_t(n.x);
            const auto* first = std::find_if(row, end, [](std::uint16_t half) { return half; });
            if (first != end) delivery.mark({{int(first - row) / 4, j, k}, {n.x, j + 1, k + 1}});
        }
}

}  // namespace

bool RestFeed::take(Client& client, const Message& message) {
    if (const auto* wish = std::get_if<RestMessage>(&message.action)) {
        m_wishes.push_back({client.info.number, message.id, wish->on});
        return true;
    }
    const auto* seen = std::get_if<SeenMessage>(&message.action);
    const auto found = m_deliveries.find(client.info.number);
    if (!seen || found == m_deliveries.end() || seen->format != kFormatRest) return false;
    found->second.seen(seen->step);
    return true;
}

/// Builds the field from all voxels that were ever deformed.
/// @returns whether there was enough memory
bool RestFeed::make() {
    DirtyBlocks all = m_host.deformed();
    const std::vector<Box3i> deformed = all.take(INT64_MAX);
    RestField field(m_host.scene().info().grid);
    if (!field.update(m_host.scene().live(), deformed).ok()) return false;
    m_field = std::move(field);
    m_is_stale = false;
    return true;
}

bool RestFeed::follow(std::span<const Box3i> boxes) {
    // Without a client the sources are given up a while later.
    if (m_field && !m_host.scene().live().keeps_sources()) m_field.reset();
    if (!m_field) return true;
    if (m_is_stale) {
        // It belongs to another tissue, or a failed update left it incomplete.
        if (!make()) return false;
        for (auto& [number, delivery] : m_deliveries) delivery.mark({{0, 0, 0}, m_field->counts()});
        return true;
    }
    m_is_stale = true;
    const auto changed = m_field->update(m_host.scene().live(), boxes);
    if (!changed.ok()) return false;
    for (auto& [number, delivery] : m_deliveries)
        for (const Box3i& nodes : *changed) delivery.mark(nodes);
    m_is_stale = false;
    return true;
}

void RestFeed::refresh() {
    m_frames.clear();
    m_left = kMaxRestNodes;
    if (!m_deliveries.empty()) m_host.keep_sources();
    const bool has_sources = m_host.scene().live().keeps_sources();
    if (!has_sources) m_field.reset();
    if (!m_deliveries.empty() && !m_field && has_sources && !m_host.is_behind() && make())
        for (auto& [number, delivery] : m_deliveries) delivery.mark({{0, 0, 0}, m_field->counts()});
    for (; !m_wishes.empty(); m_wishes.erase(m_wishes.begin())) {
        const Wish wish = m_wishes.front();
        Client* client = connected(m_host, wish.client);
        if (client && !guarded("owner", [&] { set(*client, wish); }))
            m_host.tell_later(client->connection, wish.id, "rest");
    }
}

void RestFeed::set(Client& client, const Wish& wish) {
    if (wish.on && (m_host.is_behind() || !m_host.keep_sources() || (!m_field && !make())))
        return m_host.say(client,
                          outcome_text(wish.id, "rest", 0,
                                       {.error_code = "limit",
                                        .message = "rest: expected memory for 12 bytes per voxel, "
                                                   "found less"}));
    std::string text = outcome_text(wish.id, "rest", m_host.step(), {});
    if (wish.on) {
        Delivery delivery(m_field->counts());
        mark_moved(*m_field, delivery);
        m_deliveries.insert_or_assign(client.info.number, std::move(delivery));
    } else {
        m_deliveries.erase(client.info.number);
    }
    m_host.say(client, std::move(text));
}

void RestFeed::add(Client& client, std::vector<Outgoing>& batch) {
    const auto found = m_deliveries.find(client.info.number);
    if (found == m_deliveries.end() || !m_field) return;
    Delivery& delivery = found->second;
    // Voxels have priority.
    if (client.delivery.is_due() || !delivery.is_due() || !delivery.may_send() || m_left <= 0)
        return;
    std::vector<Box3i> boxes;
    for (const Box3i& nodes : delivery.take(m_left, m_host.step(), m_host.now()))
        add_split(nodes, boxes);
    const bool ends = !delivery.is_due();
    for (std::size_t n = 0; n < boxes.size(); ++n) {
        const std::uint8_t flags = ends && n + 1 == boxes.size() ? kFrameLastOfStep : 0;
        batch.push_back({false, m_frames.get(boxes[n], flags, client.packs, kFormatRest, [&] {
                             return encode(boxes[n], flags, client.packs);
                         })});
    }
    m_host.worked();
}

std::string RestFeed::encode(const Box3i& nodes, std::uint8_t flags, bool pack) {
    m_left -= node_count(nodes);
    std::vector<std::uint16_t> halves(4 * std::size_t(node_count(nodes)));
    m_field->copy(nodes, halves);
    const FrameHeader header{.flags = flags,
                             .count = kFormatRest,
                             .step = m_host.step(),
                             .volume = m_host.scene().info().id};
    return box_frame(halves, nodes, header, pack);
}

void RestFeed::lost(Client& client) {
    const auto found = m_deliveries.find(client.info.number);
    if (found != m_deliveries.end()) found->second.come_back({});
}

bool RestFeed::is_due(const Client& client) const {
    const auto found = m_deliveries.find(client.info.number);
    return found != m_deliveries.end() && found->second.is_due();
}

std::optional<Clock::time_point> RestFeed::unseen_since(const Client& client) const {
    const auto found = m_deliveries.find(client.info.number);
    if (found == m_deliveries.end()) return {};
    return found->second.unseen_since();
}

void RestFeed::leave(Client& client) {
    m_deliveries.erase(client.info.number);
}

void RestFeed::enter_scene() noexcept {
    m_field.reset();
    m_is_stale = false;
    m_wishes.clear();
    m_deliveries.clear();
}

}  // namespace pliant::serve
