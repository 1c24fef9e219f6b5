// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "hub/read_frames.h"

#include <lz4.h>

#include <cstring>

#include "base/byte_order.h"

namespace pliant::serve {
namespace {

template <class T>
T get(std::string_view bytes, std::size_t at) {
    T value{};
    std::memcpy(&value, bytes.data() + at, sizeof value);
    return little_endian(value);
}
Vec3f get_vector(std::string_view bytes, std::size_t at) {
    return {get<float>(bytes, at), get<float>(bytes, at + 4), get<float>(bytes, at + 8)};
}

/// Half floats per voxel or node of a box.
constexpr std::uint64_t halves_each(std::uint16_t format) {
    return format == kFormatRest ? 4 : 1;
}

}  // namespace

std::optional<FrameHeader> read_frame_header(std::string_view frame) {
    if (frame.size() < kFrameHeaderBytes || !frame.starts_with("PLNT")) return {};
    FrameHeader h;
    const auto type = get<std::uint8_t>(frame, 4);
    if (type < 1 || type > 4) return {};
    h.type = FrameType(type);
    h.flags = get<std::uint8_t>(frame, 5);
    h.count = get<std::uint16_t>(frame, 6);
    h.step = get<std::uint32_t>(frame, 8);
    h.volume = get<std::uint32_t>(frame, 12);
    for (int a = 0; a < 3; ++a) {
        h.box.begin[a] = get<std::uint16_t>(frame, 16 + 2 * std::size_t(a));
        h.box.end[a] = h.box.begin[a] + get<std::uint16_t>(frame, 22 + 2 * std::size_t(a));
    }
    h.payload_bytes = get<std::uint32_t>(frame, 28);
    return h;
}

std::optional<std::vector<std::uint16_t>> read_box(std::string_view frame) {
    const auto h = read_frame_header(frame);
    if (!h || h->type != FrameType::Box || h->count < kFormatVoxels || h->count > kFormatCoarse)
        return {};
    const Vec3i n = h->box.end - h->box.begin;
    const std::uint64_t count =
        std::uint64_t(n.x) * std::uint64_t(n.y) * std::uint64_t(n.z) * halves_each(h->count);
    if (count == 0 || count * 2 != h->payload_bytes || count > std::uint64_t(1) << 24) return {};
    std::vector<std::uint16_t> halves(count);
    frame.remove_prefix(kFrameHeaderBytes);
    if (h->flags & kFramePacked) {
        const int size = LZ4_decompress_safe(frame.data(), reinterpret_cast<char*>(halves.data()),
                                             int(frame.size()), int(h->payload_bytes));
        if (size != int(h->payload_bytes)) return {};
    } else {
        if (frame.size() != h->payload_bytes) return {};
        std::memcpy(halves.data(), frame.data(), frame.size());
    }
    for (std::uint16_t& half : halves) half = little_endian(half);
    return halves;
}

std::optional<std::vector<ToolPose>> read_tools(std::string_view frame) {
    const auto h = read_frame_header(frame);
    if (!h || h->type != FrameType::Tools || h->payload_bytes != h->count * kToolBytes ||
        frame.size() != kFrameHeaderBytes + h->payload_bytes)
        return {};
    std::vector<ToolPose> tools;
    for (std::size_t at = kFrameHeaderBytes; at < frame.size(); at += kToolBytes) {
        const auto kind = get<std::uint8_t>(frame, at + 4);
        if (kind > 2) return {};
        const auto flags = get<std::uint8_t>(frame, at + 5);
        tools.push_back({.client = get<std::uint32_t>(frame, at),
                         .kind = ToolKind(kind),
                         .touches = (flags & 1) != 0,
                         .limited = (flags & 2) != 0,
                         .position_mm = get_vector(frame, at + 8),
                         .direction = get_vector(frame, at + 20),
                         .up = get_vector(frame, at + 32),
                         .radius_mm = get<float>(frame, at + 44),
                         .force_n = get_vector(frame, at + 48),
                         .energy_per_mm = get_vector(frame, at + 60),
                         .fraction = get<float>(frame, at + 72)});
    }
    return tools;
}

}  // namespace pliant::serve
