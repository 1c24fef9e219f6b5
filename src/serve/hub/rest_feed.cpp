// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The rest field for clients that request it: rest positions and raw tissue at every 4th voxel. One
// field serves all clients, and follows the volume. A client starts with a field at rest.

#include <pliant/resample.h>

#include <algorithm>
#include <array>
#include <utility>

#include "hub/box_feed.h"
#include "protocol/limits.h"

namespace pliant::serve {
namespace {

class RestFeed final : public BoxFeed {
  public:
    explicit RestFeed(FeedHost& host) : BoxFeed(host, kMaxRestNodes, kMaxRestNodes) {}

    bool take(Client& client, const Message& message) override;
    bool follow(std::span<const Box3i> boxes) override;
    void refresh() override;
    void change_tissue() noexcept override { m_is_stale = true; }
    void enter_scene() noexcept override;

  private:
    bool make();
    std::optional<Delivery> start_delivery() override;
    bool is_ready() const override { return m_field.has_value(); }
    std::vector<std::uint16_t> halves_of(const Box3i& nodes, std::uint16_t format) override;

    std::optional<RestField> m_field;  ///< present while a client requests it
    bool m_is_stale = false;           ///< must be rebuilt
};

std::array<Box3i, 1> all_nodes(const RestField& field) {
    return {{{{0, 0, 0}, field.counts()}}};
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

bool RestFeed::take(Client& client, const Message& message) {
    const auto* wish = std::get_if<RestMessage>(&message.action);
    if (!wish) return take_seen(client, message);
    request(client, message, wish->on ? kFormatRest : 0);
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
        mark(all_nodes(*m_field));
        return true;
    }
    m_is_stale = true;
    const auto changed = m_field->update(m_host.scene().live(), boxes);
    if (!changed.ok()) return false;
    mark(*changed);
    m_is_stale = false;
    return true;
}

void RestFeed::refresh() {
    if (!m_subscriptions.empty()) m_host.keep_sources();
    const bool has_sources = m_host.scene().live().keeps_sources();
    if (!has_sources) m_field.reset();
    if (!m_subscriptions.empty() && !m_field && has_sources && !m_host.is_behind() && make())
        mark(all_nodes(*m_field));
    BoxFeed::refresh();
}

std::optional<Delivery> RestFeed::start_delivery() {
    if (m_host.is_behind() || !m_host.keep_sources() || (!m_field && !make())) return {};
    Delivery delivery(m_field->counts());
    mark_moved(*m_field, delivery);
    return delivery;
}

std::vector<std::uint16_t> RestFeed::halves_of(const Box3i& nodes, std::uint16_t) {
    std::vector<std::uint16_t> halves(4 * std::size_t(node_count(nodes)));
    m_field->copy(nodes, halves);
    return halves;
}

void RestFeed::enter_scene() noexcept {
    m_field.reset();
    m_is_stale = false;
    BoxFeed::enter_scene();
}

}  // namespace

std::unique_ptr<Feed> make_rest_feed(FeedHost& host) {
    return std::make_unique<RestFeed>(host);
}

}  // namespace pliant::serve
