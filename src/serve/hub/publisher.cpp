// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "hub/publisher.h"

#include <algorithm>
#include <utility>

#include "protocol/half.h"
#include "protocol/limits.h"
#include "volume/boxes.h"

namespace pliant::serve {
namespace {

Outgoing text_message(std::string text) {
    return {true, std::make_shared<const std::string>(std::move(text))};
}

}  // namespace

void Publisher::enter_scene() {
    m_checksums.reset();
    m_tools.clear();
    m_tools_version = 0;  // forces a new frame for the new scan
}

void Publisher::set_state(const SharedState& state) {
    std::string text = state_text(state);
    if (text == m_state_text) return;
    m_state_text = std::move(text);
    ++m_state_version;
}

void Publisher::set_tools(std::vector<ToolPose> tools) {
    std::sort(tools.begin(), tools.end(),
              [](const ToolPose& a, const ToolPose& b) { return a.client < b.client; });
    if (tools == m_tools && m_tools_version > 0) return;
    m_tools_frame = tools_frame(tools, {.step = m_host.step(), .volume = m_host.scene().info().id});
    m_tools = std::move(tools);
    ++m_tools_version;
}

void Publisher::publish(Client& client, std::span<Feed* const> feeds, Recorder& recorder,
                        Outlet& outlet) {
    if (client.delivery.is_due()) client.line.due(!client.writing && client.delivery.may_send());
    if (client.writing) return;
    std::vector<Outgoing> batch;
    add_texts(client, batch);
    add_coarse(client, batch);
    const bool has_voxels = add_voxels(client, batch);
    bool more_is_due = client.delivery.is_due();
    for (Feed* feed : feeds) {
        feed->add(client, batch);
        more_is_due = more_is_due || feed->is_due(client);
    }
    const Checksums* sums =
        client.checksums.empty() || more_is_due ? nullptr : current_checksums(recorder);
    if (sums)
        for (const std::uint32_t id : client.checksums)
            batch.push_back(text_message(checksum_text(id, *sums)));
    if (batch.empty()) return;
    std::size_t bytes = 0;
    for (const Outgoing& message : batch) bytes += message.bytes->size();
    outlet.send(client.connection, std::move(batch));
    client.line.sent(bytes, has_voxels, m_host.now());
    if (has_voxels && !client.delivery.is_due())
        client.line.ended_update(m_host.step(), m_host.scene().choice().springs.depth);
    client.writing = true;
    client.since = m_host.now();
    client.texts.clear();
    client.coarse_is_due = false;
    client.state_version = m_state_version;
    client.tools_version = m_tools_version;
    if (sums) client.checksums.clear();
    for (Feed* feed : feeds) feed->sent(client);
}

void Publisher::add_texts(const Client& client, std::vector<Outgoing>& batch) {
    batch.assign(client.texts.begin(), client.texts.end());
    if (client.state_version != m_state_version) batch.push_back(text_message(m_state_text));
    if (client.tools_version != m_tools_version)
        batch.push_back({false, std::make_shared<const std::string>(m_tools_frame)});
}

void Publisher::add_coarse(const Client& client, std::vector<Outgoing>& batch) {
    const Volume& volume = m_host.scene().deformed();
    if (!client.coarse_is_due || !client.wants_coarse) return;
    if (voxel_count(volume.grid) < kCoarseFromVoxels) return;
    Vec3i nodes;
    for (int a = 0; a < 3; ++a) nodes[a] = (volume.grid.size[a] + kCoarseStep - 1) / kCoarseStep;
    const int layers = std::max(int(DirtyBlocks::kMaxBoxVoxels / (nodes.x * nodes.y)), 1);
    std::vector<Box3i> boxes;
    for (int begin = 0; begin < nodes.z; begin += layers)
        boxes.push_back({{0, 0, begin}, {nodes.x, nodes.y, std::min(begin + layers, nodes.z)}});
    m_frames.add(boxes, true, client.packs, kFormatCoarse, batch,
                 [&](const Box3i& box, std::uint8_t flags) {
                     std::vector<std::uint16_t> halves(std::size_t(box_count(box)));
                     halves_of_every(volume, kCoarseStep, box, halves);
                     return box_frame(halves, box,
                                      {.flags = flags,
                                       .count = kFormatCoarse,
                                       .step = m_host.step(),
                                       .volume = m_host.scene().info().id},
                                      client.packs);
                 });
}

/// @returns whether there are voxels in the batch
bool Publisher::add_voxels(Client& client, std::vector<Outgoing>& batch) {
    if (!client.delivery.is_due() || !client.delivery.may_send()) return false;
    const auto boxes = client.delivery.take(kMaxBatchVoxels, m_host.step(), m_host.now());
    m_frames.add(boxes, !client.delivery.is_due(), client.packs, kFormatVoxels, batch,
                 [&](const Box3i& box, std::uint8_t flags) {
                     const Scene& scene = m_host.scene();
                     return box_frame(
                         scene.deformed(), box,
                         {.flags = flags, .step = m_host.step(), .volume = scene.info().id},
                         client.packs);
                 });
    m_host.worked();
    return !boxes.empty();
}

/// Needs a pass over all voxels, so its rate is limited for all clients together.
const Checksums* Publisher::current_checksums(Recorder& recorder) {
    if (m_checksums) return &*m_checksums;
    if (m_host.now() - m_checksums_at < kChecksumPause) return nullptr;
    if (m_host.is_behind() || m_host.is_near() || !recorder.has_room()) return nullptr;
    const Scene& scene = m_host.scene();
    m_checksums = Checksums{m_host.step(), checksum_of_halves(scene.deformed()),
                            hash_volume(scene.deformed()), scene.tissue().hash()};
    m_checksums_at = m_host.now();
    recorder.note(SessionMark{m_checksums->volume, m_checksums->tissue});
    return &*m_checksums;
}

}  // namespace pliant::serve
