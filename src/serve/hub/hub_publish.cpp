// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Publishing at the end of each step.

#include <algorithm>

#include "hub/hub.h"
#include "protocol/half.h"
#include "protocol/limits.h"

namespace pliant::serve {
namespace {

Outgoing text_message(std::string text) {
    return {true, std::make_shared<const std::string>(std::move(text))};
}

}  // namespace

void Hub::tell_outcomes() {
    for (; !m_untold.empty(); m_untold.erase(m_untold.begin())) {
        const Untold& untold = m_untold.front();
        if (Client* client = client_of(untold.connection))
            say(*client, outcome_text(untold.id, std::string(untold.name), 0,
                                      {.error_code = "limit",
                                       .message = std::string(untold.name) + ": out of memory"}));
    }
    for (; !m_outcomes.empty(); m_outcomes.erase(m_outcomes.begin())) {
        Done& done = m_outcomes.front();
        if (done.outcome.ran_out)
            done.outcome.message =
                done.name + (done.outcome.error_code == "limit" ? ": out of memory"
                                                                : ": the program has a fault");
        for (; !done.ids.empty(); done.ids.erase(done.ids.begin()))
            for (Client& client : m_clients)
                if (client.info.number == done.client && client.connection)
                    say(client, outcome_text(done.ids.front(), done.name, m_step, done.outcome));
    }
}

SharedState Hub::shared_state() const {
    SharedState state = m_timing;
    m_scene->describe(state);
    state.overlay_ms = m_overlays.last_ms();
    state.step = m_step;
    state.recorded = m_playback.is_on() || (m_log && m_is_recorded);
    for (const Client& client : m_clients)
        if (client.connection) state.clients.push_back(client.info);
    std::sort(state.clients.begin(), state.clients.end(),
              [](const ClientInfo& a, const ClientInfo& b) { return a.number < b.number; });
    return state;
}

void Hub::refresh_state() {
    std::string text = state_text(shared_state());
    if (text == m_state_text) return;
    m_state_text = std::move(text);
    ++m_state_version;
}

void Hub::refresh_tools() {
    std::vector<ToolPose> tools;
    for (const Client& client : m_clients)
        if (client.connection && client.tool.kind != ToolKind::None) tools.push_back(client.tool);
    if (const auto tool = m_device.tool()) tools.push_back(*tool);
    for (const auto& [number, tool] : m_playback.tools()) tools.push_back(tool);
    std::sort(tools.begin(), tools.end(),
              [](const ToolPose& a, const ToolPose& b) { return a.client < b.client; });
    if (tools == m_tools && m_tools_version > 0) return;
    m_tools_frame = tools_frame(tools, {.step = m_step, .volume = m_scene->info().id});
    m_tools = std::move(tools);
    ++m_tools_version;
}

void Hub::publish(Client& client) {
    if (!client.connection) return;
    if (client.delivery.is_due()) client.line.due(!client.writing && client.delivery.may_send());
    if (client.writing) return;
    std::vector<Outgoing> batch(client.texts.begin(), client.texts.end());
    if (client.state_version != m_state_version) batch.push_back(text_message(m_state_text));
    if (client.tools_version != m_tools_version)
        batch.push_back({false, std::make_shared<const std::string>(m_tools_frame)});
    add_coarse(client, batch);
    const std::size_t texts = batch.size();
    add_boxes(client, batch);
    const bool has_voxels = batch.size() > texts;
    bool more_is_due = false;
    for (Feed* feed : m_feeds) {
        feed->add(client, batch);
        more_is_due = more_is_due || feed->is_due(client);
    }
    bool sends_checksums = false;
    if (!client.checksums.empty() && !client.delivery.is_due() && !more_is_due) {
        if (const Checksums* sums = current_checksums()) {
            for (const std::uint32_t id : client.checksums)
                batch.push_back(text_message(checksum_text(id, *sums)));
            sends_checksums = true;
        }
    }
    if (batch.empty()) return;
    std::size_t bytes = 0;
    for (const Outgoing& message : batch) bytes += message.bytes->size();
    m_outlet->send(client.connection, std::move(batch));
    note_traffic(client, bytes, has_voxels);
    // The rest can't fail.
    client.writing = true;
    client.since = m_now;
    client.texts.clear();
    client.coarse_is_due = false;
    client.state_version = m_state_version;
    client.tools_version = m_tools_version;
    if (sends_checksums) client.checksums.clear();
    for (Feed* feed : m_feeds) feed->sent(client);
}

/// Tells the measurement of a client's line about a batch.
void Hub::note_traffic(Client& client, std::size_t bytes, bool has_voxels) {
    client.line.sent(bytes, has_voxels, m_now);
    if (has_voxels && !client.delivery.is_due())
        client.line.ended_update(m_step, m_scene->choice().springs.depth);
}

void Hub::add_coarse(const Client& client, std::vector<Outgoing>& batch) {
    const Volume& volume = m_scene->deformed();
    if (!client.coarse_is_due || !client.wants_coarse) return;
    if (voxel_count(volume.grid) < kCoarseFromVoxels) return;
    Vec3i nodes;
    for (int a = 0; a < 3; ++a) nodes[a] = (volume.grid.size[a] + kCoarseStep - 1) / kCoarseStep;
    const int layers = std::max(int(DirtyBlocks::kMaxBoxVoxels / (nodes.x * nodes.y)), 1);
    for (int begin = 0; begin < nodes.z; begin += layers) {
        const Box3i box{{0, 0, begin}, {nodes.x, nodes.y, std::min(begin + layers, nodes.z)}};
        const std::uint8_t flags = box.end.z == nodes.z ? kFrameLastOfStep : 0;
        batch.push_back({false, m_frames.get(box, flags, client.packs, kFormatCoarse, [&] {
                             std::vector<std::uint16_t> halves(
                                 std::size_t(nodes.x) * std::size_t(nodes.y) *
                                 std::size_t(box.end.z - box.begin.z));
                             halves_of_every(volume, kCoarseStep, box, halves);
                             return box_frame(halves, box,
                                              {.flags = flags,
                                               .count = kFormatCoarse,
                                               .step = m_step,
                                               .volume = m_scene->info().id},
                                              client.packs);
                         })});
    }
}

void Hub::add_boxes(Client& client, std::vector<Outgoing>& batch) {
    if (!client.delivery.is_due() || !client.delivery.may_send()) return;
    const auto boxes = client.delivery.take(kMaxBatchVoxels, m_step, m_now);
    const bool ends = !client.delivery.is_due();
    for (std::size_t n = 0; n < boxes.size(); ++n) {
        const std::uint8_t flags = ends && n + 1 == boxes.size() ? kFrameLastOfStep : 0;
        batch.push_back({false, m_frames.get(boxes[n], flags, client.packs, kFormatVoxels, [&] {
                             return box_frame(
                                 m_scene->deformed(), boxes[n],
                                 {.flags = flags, .step = m_step, .volume = m_scene->info().id},
                                 client.packs);
                         })});
    }
    m_worked = true;
}

const Checksums* Hub::current_checksums() {
    // Needs a pass over all voxels, so its rate is limited for all clients together.
    if (m_checksums) return &*m_checksums;
    if (m_now - m_checksums_at < kChecksumPause) return nullptr;
    if (m_is_behind || !log_is_ready()) return nullptr;
    m_checksums = Checksums{m_step, checksum_of_halves(m_scene->deformed()),
                            hash_volume(m_scene->deformed()), m_scene->tissue().hash()};
    m_checksums_at = m_now;
    note(SessionMark{m_checksums->volume, m_checksums->tissue});
    return &*m_checksums;
}

}  // namespace pliant::serve
