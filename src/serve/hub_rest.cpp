// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The rest field for clients that request it: rest positions and raw tissue at every 4th voxel. One
// field serves all clients, follows the volume, and is sent like overlays: after the voxels, in
// boxes of nodes. A client starts with a field at rest.

#include <algorithm>
#include <utility>

#include "protocol/limits.h"
#include "serve/hub.h"

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

/// Resets the field for a new scan.
void Hub::forget_rest() noexcept {
    m_rest.reset();
    m_rest_is_stale = false;
    m_rest_wishes.clear();
    for (Client& client : m_clients) client.rest.reset();
}

/// Call it while the volume is up to date.
void Hub::begin_rest() {
    for (; !m_rest_wishes.empty(); m_rest_wishes.erase(m_rest_wishes.begin())) {
        const RestWish wish = m_rest_wishes.front();
        for (Client& client : m_clients)
            if (client.info.number == wish.client && client.connection &&
                !guarded("owner", [&] { set_rest(client, wish.id, wish.on); }))
                tell_later({client.connection, wish.id, "rest"});
    }
}

void Hub::set_rest(Client& client, std::uint32_t id, bool on) {
    m_overlay_at = m_now;
    if (on && (m_is_behind || !m_scene->keep_sources(true) || (!m_rest && !make_rest({}))))
        return say(client, outcome_text(id, "rest", 0,
                                        {.error_code = "limit",
                                         .message = "rest: expected memory for 12 bytes per voxel, "
                                                    "found less"}));
    std::optional<Delivery> delivery;
    if (on) mark_moved(*m_rest, delivery.emplace(m_rest->counts()));
    std::string text = outcome_text(id, "rest", m_step, {});
    client.rest = std::move(delivery);
    say(client, std::move(text));
}

/// Rebuilds the field. @param boxes  changed voxels, beside those ever deformed
/// @returns whether there was enough memory
bool Hub::make_rest(std::span<const Box3i> boxes) {
    DirtyBlocks all = m_deformed;
    for (const Box3i& box : boxes) all.mark(box);
    const std::vector<Box3i> deformed = all.take(INT64_MAX);
    RestField field(m_scene->info().grid);
    if (!field.update(m_scene->live(), deformed).ok()) return false;
    m_rest = std::move(field);
    m_rest_is_stale = false;
    return true;
}

/// @param boxes  changed voxels
/// @returns false for lack of memory; call it again then
bool Hub::update_rest(std::span<const Box3i> boxes) noexcept {
    if (!m_rest) return true;
    bool done = false;
    guarded("owner", [&] {
        if (m_rest_is_stale) {
            // It belongs to another tissue, or a failed update left it incomplete.
            done = make_rest(boxes);
            if (!done) return;
            for (Client& client : m_clients)
                if (client.rest) client.rest->mark({{0, 0, 0}, m_rest->counts()});
            return;
        }
        m_rest_is_stale = true;
        const auto changed = m_rest->update(m_scene->live(), boxes);
        if (!changed.ok()) return;
        for (Client& client : m_clients)
            if (client.rest)
                for (const Box3i& nodes : *changed) client.rest->mark(nodes);
        m_rest_is_stale = false;
        done = true;
    });
    return done;
}

void Hub::add_rest_boxes(Client& client, std::vector<Outgoing>& batch) {
    // Voxels have priority.
    if (!client.rest || !m_rest || client.delivery.is_due() || !client.rest->is_due() ||
        !client.rest->may_send() || m_rest_left <= 0)
        return;
    std::vector<Box3i> boxes;
    for (const Box3i& nodes : client.rest->take(m_rest_left, m_step, m_now))
        add_split(nodes, boxes);
    const bool ends = !client.rest->is_due();
    for (std::size_t n = 0; n < boxes.size(); ++n) {
        const std::uint8_t flags = ends && n + 1 == boxes.size() ? kFrameLastOfStep : 0;
        batch.push_back({false, shared_rest_box(boxes[n], flags, client.packs)});
    }
    m_worked = true;
}

std::shared_ptr<const std::string> Hub::shared_rest_box(const Box3i& nodes, std::uint8_t flags,
                                                        bool pack) {
    for (const SharedBox& shared : m_boxes)
        if (shared.box == nodes && shared.flags == flags && shared.packed == pack &&
            shared.format == kFormatRest)
            return shared.bytes;
    m_rest_left -= node_count(nodes);
    std::vector<std::uint16_t> halves(4 * std::size_t(node_count(nodes)));
    m_rest->copy(nodes, halves);
    const FrameHeader header{
        .flags = flags, .count = kFormatRest, .step = m_step, .volume = m_scene->info().id};
    m_boxes.push_back(
        {nodes, flags, pack, kFormatRest,
         std::make_shared<const std::string>(box_frame(halves, nodes, header, pack))});
    return m_boxes.back().bytes;
}

}  // namespace pliant::serve
