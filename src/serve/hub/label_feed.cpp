// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "hub/label_feed.h"

#include <cmath>

#include "protocol/half.h"
#include "volume/boxes.h"

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
        if (m_subscriptions.contains(client.info.number)) send_list(client);
}

/// Lists the labels; all their voxels follow.
void LabelFeed::send_list(Client& client) {
    std::string text = m_map ? labels_text(m_host.scene().info().id, m_map->name, m_map->labels)
                             : labels_text(m_host.scene().info().id, "", {});
    Subscription subscription{kFormatLabels, Delivery(m_host.scene().info().grid.size)};
    if (m_map) subscription.delivery.mark_all();
    m_subscriptions.insert_or_assign(client.info.number, std::move(subscription));
    m_host.send(client, std::move(text));
}

bool LabelFeed::take(Client& client, const Message& message) {
    if (const auto* wish = std::get_if<LabelsMessage>(&message.action)) {
        m_host.accept(client, message.id, "labels");
        if (wish->on)
            send_list(client);
        else
            m_subscriptions.erase(client.info.number);
        return true;
    }
    return take_seen(client, message);
}

bool LabelFeed::follow(std::span<const Box3i> boxes) {
    if (m_map) mark(boxes);
    return true;
}

void LabelFeed::refresh() {
    BoxFeed::refresh();
    if (!m_map || m_subscriptions.empty()) return;
    // Without memory for sources, labels wait; undeformed ones need none.
    m_has_sources = m_host.keep_sources();
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

std::vector<std::uint16_t> LabelFeed::halves_of(const Box3i& box, std::uint16_t) {
    std::vector<std::uint16_t> halves;
    halves.reserve(std::size_t(box_count(box)));
    for_each_in(box,
                [&](Vec3i voxel) { halves.push_back(half_from_float(float(number_at(voxel)))); });
    return halves;
}

void LabelFeed::enter_scene() noexcept {
    BoxFeed::enter_scene();
    m_map = m_host.scene().loaded()->bodies;
}

}  // namespace pliant::serve
