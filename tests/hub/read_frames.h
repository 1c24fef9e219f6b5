// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The binary messages of docs/developers/protocol.md as a client reads them.

#pragma once

#include <optional>
#include <string_view>
#include <vector>

#include "protocol/frames.h"

namespace pliant::serve {

/// Decodes a header. @returns nullopt for an invalid frame
std::optional<FrameHeader> read_frame_header(std::string_view frame);
/// Decodes the payload of a box. @returns nullopt if it is empty or its length contradicts the
/// header
std::optional<std::vector<std::uint16_t>> read_box(std::string_view frame);
std::optional<std::vector<ToolPose>> read_tools(std::string_view frame);

}  // namespace pliant::serve
