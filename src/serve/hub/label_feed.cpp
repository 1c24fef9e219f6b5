// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "hub/label_feed.h"

#include <cmath>

#include "protocol/half.h"
#include "protocol/limits.h"

namespace pliant::serve {

void LabelFeed::show(std::shared_ptr<const LabelMap> map) {
    const auto bodies = m_host.scene().loaded()->bodies;
    if (map && bodies) {
        auto marked = std::make_shared<LabelMap>(*map);
        mark_bodies(*marked, *bodies);
        map = std::move(marked);
    }
    m_map = map ? std::move(map) : bodies;
    for (Client& client : m_host.clients())
        if (m_clients.contains(client.info.number)) tell(client);
}

/// Lists the labels; all their voxels follow.
void LabelFeed::tell(Client& client) {
    std::string text = m_map ? labels_text(m_host.scene().info().id, m_map->name, m_map->labels)
                             : labels_text(m_host.scene().info().id, "", {});
    Delivery delivery(m_host.scene().info().grid.size);
    if (m_map) delivery.mark_all();
    m_clients.insert_or_assign(client.info.number, std::move(delivery));
    m_host.say(client, std::move(text));
}

bool LabelFeed::take(Client& client, const Message& message) {
    if (const auto* wish = std::get_if<LabelsMessage>(&message.action)) {
        m_host.say(client, outcome_text(message.id, "labels", m_host.step(), {}));
        if (wish->on)
            tell(client);
        else
            m_clients.erase(client.info.number);
        return true;
    }
    const auto* seen = std::get_if<SeenMessage>(&message.action);
    const auto found = m_clients.find(client.info.number);
    if (!seen || seen->format != kFormatLabels || found == m_clients.end()) return false;
    found->second.seen(seen->step);
    return true;
}

bool LabelFeed::follow(std::span<const Box3i> boxes) {
    if (!m_map) return true;
    for (auto& [number, delivery] : m_clients)
        for (const Box3i& box : boxes) delivery.mark(box);
    return true;
}

void LabelFeed::refresh() {
    m_frames.clear();
    m_left = kMaxLabelVoxels;
    if (!m_map || m_clients.empty()) return;
    // Without memory for sources, labels wait; undeformed ones need none.
    m_has_sources = m_host.keep_sources();
}

void LabelFeed::add(Client& client, std::vector<Outgoing>& batch) {
    const auto found = m_clients.find(client.info.number);
    if (!m_map || found == m_clients.end()) return;
    Delivery& delivery = found->second;
    // Voxels have priority.
    if (client.delivery.is_due() || !delivery.is_due() || !delivery.may_send() || m_left <= 0)
        return;
    if (!m_has_sources || m_host.is_behind()) return;
    const auto boxes = delivery.take(m_left, m_host.step(), m_host.now());
    const bool ends = !delivery.is_due();
    for (std::size_t n = 0; n < boxes.size(); ++n) {
        const std::uint8_t flags = ends && n + 1 == boxes.size() ? kFrameLastOfStep : 0;
        batch.push_back({false, m_frames.get(boxes[n], flags, client.packs, kFormatLabels, [&] {
                             return encode(boxes[n], flags, client.packs);
                         })});
    }
    m_host.worked();
}

/// Number of the label that is shown at a voxel; negative in every other cube of a body at rest.
int LabelFeed::number_at(Vec3i voxel) const {
    const Scene& scene = m_host.scene();
    const Grid& grid = m_map->grid;
    const Vec3f back = scene.live().source_offset_mm(voxel);
    const Vec3d at = world_from_voxel(grid, {double(voxel.x), double(voxel.y), double(voxel.z)});
    if (back == Vec3f{0, 0, 0}) {
        const std::uint16_t number = m_map->numbers[voxel_index(grid, voxel)];
        // A gap has no offset either, but the value of air instead of the scan's.
        const bool is_gap =
            number != 0 && scene.deformed().at(voxel) != scene.loaded()->volume.at(voxel);
        return is_gap ? 0 : striped(number, at);
    }
    const Vec3d rest = at + Vec3d{back.x, back.y, back.z};
    const Vec3d source = voxel_from_world(grid, rest);
    const Vec3i nearest{int(std::lround(source.x)), int(std::lround(source.y)),
                        int(std::lround(source.z))};
    if (!contains(voxel_box(grid), nearest)) return 0;
    return striped(m_map->numbers[voxel_index(grid, nearest)], rest);
}

int LabelFeed::striped(std::uint16_t number, Vec3d rest_mm) const {
    if (number == 0 || !(m_map->stripe_mm > 0) || m_map->labels[number - 1u].body == 0)
        return number;
    const Vec3d from = rest_mm - m_map->grid.origin_mm;
    std::int64_t cubes = 0;
    for (int a = 0; a < 3; ++a) cubes += std::int64_t(std::floor(from[a] / m_map->stripe_mm));
    return (cubes & 1) != 0 ? -int(number) : int(number);
}

std::string LabelFeed::encode(const Box3i& box, std::uint8_t flags, bool pack) {
    const Vec3i n = box.end - box.begin;
    const std::size_t count = std::size_t(n.x) * std::size_t(n.y) * std::size_t(n.z);
    m_left -= std::int64_t(count);
    std::vector<std::uint16_t> halves;
    halves.reserve(count);
    for (int k = box.begin.z; k < box.end.z; ++k)
        for (int j = box.begin.y; j < box.end.y; ++j)
            for (int i = box.begin.x; i < box.end.x; ++i)
                halves.push_back(half_from_float(float(number_at({i, j, k}))));
    const FrameHeader header{.flags = flags,
                             .count = kFormatLabels,
                             .step = m_host.step(),
                             .volume = m_host.scene().info().id};
    return box_frame(halves, box, header, pack);
}

void LabelFeed::lost(Client& client) {
    const auto found = m_clients.find(client.info.number);
    if (found != m_clients.end()) found->second.come_back({});
}

bool LabelFeed::is_due(const Client& client) const {
    const auto found = m_clients.find(client.info.number);
    return m_map && m_has_sources && found != m_clients.end() && found->second.is_due();
}

std::optional<Clock::time_point> LabelFeed::unseen_since(const Client& client) const {
    const auto found = m_clients.find(client.info.number);
    if (found == m_clients.end()) return {};
    return found->second.unseen_since();
}

void LabelFeed::leave(Client& client) {
    m_clients.erase(client.info.number);
}

void LabelFeed::enter_scene() noexcept {
    m_clients.clear();
    m_map = m_host.scene().loaded()->bodies;
}

}  // namespace pliant::serve
