// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "hub/vessel_frames.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "base/byte_order.h"
#include "protocol/half.h"

namespace pliant::serve {
namespace {

/// Unmoved nodes between two moved ones that are sent with them: a run costs as much as one node.
constexpr std::size_t kGap = 2;

/// Quantises to invisible steps, so that rounding and vibrations cause no traffic; avoids −0.
std::uint16_t half_or_zero(float mm) {
    constexpr float kParts = 4096;
    const std::uint16_t half = half_from_float(std::round(mm * kParts) / kParts);
    return half == 0x8000 ? 0 : half;
}

template <class T>
void put_raw(std::string& bytes, T value) {
    value = little_endian(value);
    bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}
void put_raw_position(std::string& bytes, Vec3d p) {
    for (int a = 0; a < 3; ++a) put_raw(bytes, float(p[a]));
}

}  // namespace

void VesselFrames::update(const Drivable& catheter) {
    const CatheterView& view = catheter.view();
    m_radius_mm = catheter.radius_mm();
    m_nodes.resize(std::min(view.moved_mm.size(), catheter.wall().nodes_mm.size()));
    const std::uint64_t next = m_version + 1;
    bool changed = m_version == 0 || view.catheter_mm != m_catheter_mm;
    for (std::size_t n = 0; n < m_nodes.size(); ++n) {
        std::array<std::uint16_t, 3> halves;
        for (int a = 0; a < 3; ++a) halves[std::size_t(a)] = half_or_zero(view.moved_mm[n][a]);
        if (halves == m_nodes[n].halves) continue;
        m_nodes[n] = {halves, next};
        changed = true;
    }
    if (!changed) return;
    m_catheter_mm = view.catheter_mm;
    m_version = next;
}

std::shared_ptr<const std::string> VesselFrames::surface(const Drivable& catheter,
                                                         std::uint32_t step, std::uint32_t volume) {
    if (m_surface) return m_surface;
    const TriangleMesh& wall = catheter.wall();
    std::string frame(kFrameHeaderBytes, '\0');
    put_raw(frame, std::uint32_t(wall.nodes_mm.size()));
    put_raw(frame, std::uint32_t(wall.cells.size()));
    for (const Vec3d p : wall.nodes_mm) put_raw_position(frame, p);
    for (const auto& cell : wall.cells)
        for (const std::int32_t n : cell) put_raw(frame, std::uint32_t(n));
    put_frame_header(frame,
                     {.type = FrameType::Surface, .count = 0, .step = step, .volume = volume});
    return m_surface = std::make_shared<const std::string>(std::move(frame));
}

std::shared_ptr<const std::string> VesselFrames::since(std::uint64_t version, std::uint32_t step,
                                                       std::uint32_t volume) {
    if (m_last && m_last_from == version && m_last_version == m_version) return m_last;
    struct Run {
        std::uint32_t first, count;
    };
    std::vector<Run> runs;
    for (std::size_t n = 0; n < m_nodes.size(); ++n) {
        if (m_nodes[n].changed_at <= version) continue;
        if (!runs.empty() && n <= runs.back().first + runs.back().count + kGap)
            runs.back().count = std::uint32_t(n) - runs.back().first + 1;
        else
            runs.push_back({std::uint32_t(n), 1});
    }
    std::string frame(kFrameHeaderBytes, '\0');
    put_raw(frame, float(m_radius_mm));
    put_raw(frame, std::uint32_t(m_catheter_mm.size()));
    put_raw(frame, std::uint32_t(runs.size()));
    for (const Vec3d p : m_catheter_mm) put_raw_position(frame, p);
    for (const Run& run : runs) {
        put_raw(frame, run.first);
        put_raw(frame, run.count);
    }
    for (const Run& run : runs)
        for (const Node& node : std::span(m_nodes).subspan(run.first, run.count))
            for (const std::uint16_t half : node.halves) put_raw(frame, half);
    put_frame_header(frame,
                     {.type = FrameType::Vessel, .count = 0, .step = step, .volume = volume});
    m_last_from = version;
    m_last_version = m_version;
    return m_last = std::make_shared<const std::string>(std::move(frame));
}

}  // namespace pliant::serve
