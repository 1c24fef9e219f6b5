// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The binary messages of docs/developers/protocol.md: 32 bytes of header, then voxels or tools.

#pragma once

#include <pliant/volume.h>

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace pliant::serve {

enum class FrameType : std::uint8_t { Box = 1, Tools = 2, Surface = 3, Vessel = 4 };
inline constexpr std::uint8_t kFramePacked = 1;      ///< with LZ4
inline constexpr std::uint8_t kFrameLastOfStep = 2;  ///< the client is then up to date
inline constexpr std::size_t kFrameHeaderBytes = 32;
inline constexpr std::size_t kToolBytes = 80;

/// Contents of a box; all are half floats.
inline constexpr std::uint16_t kFormatVoxels = 1;  ///< [HU]
enum class OverlayKind : std::uint8_t { None = 0, Displacement = 1, Jacobian = 2 };
/// Nodes of a rest field, four half floats each; the box is in nodes (pliant/resample.h).
inline constexpr std::uint16_t kFormatRest = 4;
/// Labels: 0 without one, else the number in the list of the message `labels`, from 1.
inline constexpr std::uint16_t kFormatLabels = 5;
/// Every kCoarseStep-th voxel along each axis, from the first on [HU]; the box is in these.
inline constexpr std::uint16_t kFormatCoarse = 6;
inline constexpr int kCoarseStep = 4;
/// @pre kind is not None
constexpr std::uint16_t format_of(OverlayKind kind) {
    return std::uint16_t(kFormatVoxels + std::uint16_t(kind));
}

struct FrameHeader {
    FrameType type = FrameType::Box;
    std::uint8_t flags = 0;
    std::uint16_t count = 1;  ///< tools: their number; box: its format
    std::uint32_t step = 0;
    std::uint32_t volume = 0;
    Box3i box{};
    std::uint32_t payload_bytes = 0;  ///< uncompressed size
};

enum class ToolKind : std::uint8_t { None = 0, Endoscope = 1, Sphere = 2 };

/// Pose of a client's tool, and the reaction of the tissue.
struct ToolPose {
    std::uint32_t client = 0;
    ToolKind kind = ToolKind::None;
    bool touches = false;
    bool limited = false;  ///< whether its last motion was limited
    Vec3f position_mm{0, 0, 0};
    Vec3f direction{0, 0, 1};
    Vec3f up{0, 1, 0};
    float radius_mm = 0;
    Vec3f force_n{0, 0, 0};        ///< on the tool; 0 if the tissue has no forces
    Vec3f energy_per_mm{0, 0, 0};  ///< instead: energy per path [mm² · weight/mm]
    float fraction = 1;            ///< done fraction of the last motion

    friend bool operator==(const ToolPose&, const ToolPose&) = default;
};

/// Encodes a box.
/// @param halves  of the box, i fastest: one per voxel, four per node of a rest field
/// @param header  type, box and payload_bytes are filled in; count is the format
/// @param pack    compresses with LZ4 if that saves 20 %
std::string box_frame(std::span<const std::uint16_t> halves, const Box3i& box, FrameHeader header,
                      bool pack);
/// Encodes a box of the volume's voxels.
std::string box_frame(const Volume& volume, const Box3i& box, FrameHeader header, bool pack);
std::string tools_frame(std::span<const ToolPose> tools, FrameHeader header);

/// Writes the header in front of an existing payload. @pre frame.size() >= kFrameHeaderBytes
void put_frame_header(std::string& frame, FrameHeader header);

}  // namespace pliant::serve
