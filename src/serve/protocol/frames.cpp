// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "protocol/frames.h"

#include <lz4.h>

#include <cstring>

#include "base/byte_order.h"
#include "protocol/half.h"

namespace pliant::serve {
namespace {

template <class T>
void put(std::string& bytes, std::size_t at, T value) {
    value = little_endian(value);
    std::memcpy(bytes.data() + at, &value, sizeof value);
}
void put_vector(std::string& bytes, std::size_t at, Vec3f v) {
    for (int a = 0; a < 3; ++a) put(bytes, at + 4 * std::size_t(a), v[a]);
}

void put_header(std::string& bytes, const FrameHeader& h) {
    std::memcpy(bytes.data(), "PLNT", 4);
    put(bytes, 4, std::uint8_t(h.type));
    put(bytes, 5, h.flags);
    put(bytes, 6, h.count);
    put(bytes, 8, h.step);
    put(bytes, 12, h.volume);
    for (int a = 0; a < 3; ++a) {
        put(bytes, 16 + 2 * std::size_t(a), std::uint16_t(h.box.begin[a]));
        put(bytes, 22 + 2 * std::size_t(a), std::uint16_t(h.box.end[a] - h.box.begin[a]));
    }
    put(bytes, 28, h.payload_bytes);
}

}  // namespace

void put_frame_header(std::string& frame, FrameHeader header) {
    header.payload_bytes = std::uint32_t(frame.size() - kFrameHeaderBytes);
    put_header(frame, header);
}

std::string box_frame(const Volume& volume, const Box3i& box, FrameHeader header, bool pack) {
    const Vec3i n = box.end - box.begin;
    std::vector<std::uint16_t> halves(std::size_t(n.x) * std::size_t(n.y) * std::size_t(n.z));
    halves_of_box(volume, box, halves);
    header.count = kFormatVoxels;
    return box_frame(halves, box, header, pack);
}

std::string box_frame(std::span<const std::uint16_t> halves, const Box3i& box, FrameHeader header,
                      bool pack) {
    std::vector<std::uint16_t> swapped;
    if constexpr (kIsBigEndian) {
        for (const std::uint16_t half : halves) swapped.push_back(little_endian(half));
        halves = swapped;
    }
    header.type = FrameType::Box;
    header.box = box;
    header.payload_bytes = std::uint32_t(halves.size() * sizeof halves[0]);
    const auto size = int(header.payload_bytes);
    std::string frame;
    if (pack) {
        frame.resize(kFrameHeaderBytes + std::size_t(size / 5 * 4));
        const int packed =
            LZ4_compress_default(reinterpret_cast<const char*>(halves.data()),
                                 frame.data() + kFrameHeaderBytes, size, size / 5 * 4);
        if (packed > 0) {
            frame.resize(kFrameHeaderBytes + std::size_t(packed));
            header.flags |= kFramePacked;
        }
    }
    if (!(header.flags & kFramePacked)) {
        frame.resize(kFrameHeaderBytes + std::size_t(size));
        std::memcpy(frame.data() + kFrameHeaderBytes, halves.data(), std::size_t(size));
    }
    put_header(frame, header);
    return frame;
}

std::string tools_frame(std::span<const ToolPose> tools, FrameHeader header) {
    std::string frame(kFrameHeaderBytes + tools.size() * kToolBytes, '\0');
    header.type = FrameType::Tools;
    header.flags = 0;
    header.count = std::uint16_t(tools.size());
    header.box = {};
    header.payload_bytes = std::uint32_t(tools.size() * kToolBytes);
    put_header(frame, header);
    std::size_t at = kFrameHeaderBytes;
    for (const ToolPose& tool : tools) {
        put(frame, at, tool.client);
        put(frame, at + 4, std::uint8_t(tool.kind));
        put(frame, at + 5, std::uint8_t((tool.touches ? 1 : 0) | (tool.limited ? 2 : 0)));
        put_vector(frame, at + 8, tool.position_mm);
        put_vector(frame, at + 20, tool.direction);
        put_vector(frame, at + 32, tool.up);
        put(frame, at + 44, tool.radius_mm);
        put_vector(frame, at + 48, tool.force_n);
        put_vector(frame, at + 60, tool.energy_per_mm);
        put(frame, at + 72, tool.fraction);
        at += kToolBytes;
    }
    return frame;
}

}  // namespace pliant::serve
