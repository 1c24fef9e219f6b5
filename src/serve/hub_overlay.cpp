// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Overlays: numbers of the deformation beside the voxels, displacement or volume ratio of the
// tissue at a voxel. They are sent like voxels, but after them, within a budget per step. A client
// starts with an overlay at rest, so it receives only voxels that were ever deformed.

#include <algorithm>
#include <utility>

#include "protocol/half.h"
#include "protocol/limits.h"
#include "serve/hub.h"

namespace pliant::serve {

/// Resets overlays for a new scan.
void Hub::forget_overlays() {
    m_deformed = DirtyBlocks(m_scene->info().grid.size);
    for (Client& client : m_clients) client.overlay = OverlayKind::None;
}

/// Call it while the volume is up to date.
void Hub::begin_overlays() {
    for (; !m_overlay_wishes.empty(); m_overlay_wishes.erase(m_overlay_wishes.begin())) {
        const OverlayWish wish = m_overlay_wishes.front();
        for (Client& client : m_clients)
            if (client.info.number == wish.client && client.connection &&
                !guarded("owner", [&] { set_overlay(client, wish.id, wish.kind); }))
                tell_later({client.connection, wish.id, "overlay"});
    }
}

void Hub::set_overlay(Client& client, std::uint32_t id, OverlayKind kind) {
    if (kind != OverlayKind::None && !m_scene->keep_sources(true))
        return say(client,
                   outcome_text(id, "overlay", 0,
                                {.error_code = "limit",
                                 .message = "overlay: expected memory for 12 bytes per voxel, "
                                            "found less"}));
    Delivery delivery(m_scene->info().grid.size);
    std::string text = outcome_text(id, "overlay", m_step, {});
    m_overlay_at = m_now;
    client.overlay = kind;
    client.overlay_delivery = std::move(delivery);
    if (kind != OverlayKind::None) client.overlay_delivery.mark(m_deformed);
    say(client, std::move(text));
}

void Hub::mark_overlays(std::span<const Box3i> boxes) {
    for (const Box3i& box : boxes) m_deformed.mark(box);
    for (Client& client : m_clients)
        if (client.overlay != OverlayKind::None)
            for (const Box3i& box : boxes) client.overlay_delivery.mark(box);
}

void Hub::add_overlay_boxes(Client& client, std::vector<Outgoing>& batch) {
    // Voxels have priority.
    Delivery& delivery = client.overlay_delivery;
    if (client.overlay == OverlayKind::None || client.delivery.is_due() || !delivery.is_due() ||
        !delivery.may_send() || m_overlay_left <= 0)
        return;
    const auto start = Clock::now();
    const auto boxes = delivery.take(m_overlay_left, m_step, m_now);
    const bool ends = !delivery.is_due();
    for (std::size_t n = 0; n < boxes.size(); ++n) {
        const std::uint8_t flags = ends && n + 1 == boxes.size() ? kFrameLastOfStep : 0;
        batch.push_back({false, shared_box(boxes[n], flags, client.packs, client.overlay)});
    }
    m_worked = true;
    m_overlay_ms += std::chrono::duration<double, std::milli>(Clock::now() - start).count();
    m_timing.overlay_ms = m_overlay_ms;
}

std::string Hub::make_overlay_box(const Box3i& box, std::uint8_t flags, bool pack,
                                  OverlayKind kind) {
    const Vec3i n = box.end - box.begin;
    const std::size_t count = std::size_t(n.x) * std::size_t(n.y) * std::size_t(n.z);
    m_overlay_left -= std::int64_t(count);
    std::vector<float> values(count);
    if (kind == OverlayKind::Displacement)
        m_scene->live().displacement_mm(box, values);
    else
        m_scene->live().jacobian(box, values);
    std::vector<std::uint16_t> halves(count);
    std::transform(values.begin(), values.end(), halves.begin(), half_from_float);
    const FrameHeader header{
        .flags = flags, .count = format_of(kind), .step = m_step, .volume = m_scene->info().id};
    return box_frame(halves, box, header, pack);
}

/// Stops the computation of overlays a while after the last request.
void Hub::rest_overlays() {
    if (!m_scene->live().keeps_sources()) return;
    for (const Client& client : m_clients)
        if (client.overlay != OverlayKind::None || client.rest) m_overlay_at = m_now;
    if (m_now - m_overlay_at <= kOverlayTime) return;
    m_rest.reset();
    m_scene->keep_sources(false);
}

}  // namespace pliant::serve
