// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "hub/overlay_feed.h"

#include <algorithm>

#include "base/stopwatch.h"
#include "protocol/half.h"
#include "volume/boxes.h"

namespace pliant::serve {

bool OverlayFeed::take(Client& client, const Message& message) {
    const auto* wish = std::get_if<OverlayMessage>(&message.action);
    if (!wish) return take_seen(client, message);
    request(client, message, wish->kind == OverlayKind::None ? 0 : format_of(wish->kind));
    return true;
}

bool OverlayFeed::follow(std::span<const Box3i> boxes) {
    mark(boxes);
    return true;
}

void OverlayFeed::refresh() {
    m_step_ms = 0;
    if (!m_subscriptions.empty()) m_host.keep_sources();
    BoxFeed::refresh();
}

std::optional<Delivery> OverlayFeed::start_delivery() {
    if (!m_host.keep_sources()) return {};
    Delivery delivery(m_host.scene().info().grid.size);
    delivery.mark(m_host.deformed());
    return delivery;
}

void OverlayFeed::add(Client& client, std::vector<Outgoing>& batch) {
    const Stopwatch watch;
    const std::size_t before = batch.size();
    BoxFeed::add(client, batch);
    if (batch.size() == before) return;
    m_step_ms += watch.ms();
    m_last_ms = m_step_ms;
}

std::vector<std::uint16_t> OverlayFeed::halves_of(const Box3i& box, std::uint16_t format) {
    std::vector<float> values(std::size_t(box_count(box)));
    const LiveDeformation& live = m_host.scene().live();
    if (format == format_of(OverlayKind::Displacement))
        live.displacement_mm(box, values);
    else
        live.jacobian(box, values);
    std::vector<std::uint16_t> halves(values.size());
    std::transform(values.begin(), values.end(), halves.begin(), half_from_float);
    return halves;
}

void OverlayFeed::enter_scene() noexcept {
    BoxFeed::enter_scene();
    m_last_ms = 0;
}

}  // namespace pliant::serve
