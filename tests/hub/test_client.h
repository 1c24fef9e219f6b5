// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A WebSocket client for tests: it shares no code with the server, and can send invalid messages.

#pragma once

#include <pliant/serve.h>

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "protocol/frames.h"
#include "support/connection.h"
#include "support/json.h"

namespace pliant::test {

/// A connection that was made, or the test fails.
class RawConnection : public Connection {
  public:
    explicit RawConnection(int port);

    /// @returns the first line of the answer
    std::string upgrade(const std::string& token, const std::string& host = "",
                        const std::string& origin = "");
};

struct WsMessage {
    int opcode = 0;  ///< 1 text, 2 binary, 8 close, −1 the connection is gone
    std::string bytes;
};

/// A client that keeps its own copy of the voxels.
class TestClient : public RawConnection {
  public:
    TestClient(int port, const std::string& link);

    void say(const Json& message);
    void send_frame(int opcode, std::string_view payload);
    /// The next message; pings are answered.
    WsMessage read();
    /// Takes in messages until a text for which this holds. @returns null after some seconds, or
    /// at the end of the connection (then `close_code` says why)
    Json until(const std::function<bool(const Json&)>& holds);
    Json until(const std::string& type);
    /// Waits for the answer to the command with this id: done or error.
    Json answer(std::uint32_t id);
    Json command(Json message);
    /// hello, then the whole snapshot.
    Json enter(const Json& hello = Json::object());
    /// Until all boxes of a step have come.
    bool until_up_to_date();
    /// Asks for "displacement" or "jacobian", or "none". @returns the answer
    Json ask_overlay(const std::string& kind);
    /// Asks for the rest field, or no more of it. @returns the answer
    Json ask_rest(bool on);
    Vec3i rest_counts() const;
    /// Asks for a checksum, and compares the copy with it. @returns the answer
    Json checked_checksum();
    /// Reads until the connection is closed.
    int wait_for_close();

    bool sends_seen = true;
    int close_code = 0;
    std::string close_reason;
    std::uint32_t step = 0;  ///< newest whole step
    std::int64_t box_bytes = 0;
    int boxes = 0;
    Vec3i size{0, 0, 0};
    std::vector<std::uint16_t> voxels;
    std::vector<std::uint16_t> coarse;  ///< of all its boxes
    int overlay_format = 0;             ///< 0: none
    std::vector<std::uint16_t> overlay;
    int overlay_boxes = 0, whole_overlays = 0;
    std::uint32_t overlay_step = 0;  ///< newest whole one
    bool sends_overlay_seen = true;
    std::vector<std::uint16_t> rest;  ///< four for each node, once it was asked for
    int rest_boxes = 0, whole_rests = 0;
    std::uint32_t rest_step = 0;
    bool sends_rest_seen = true;
    std::string tools;                 ///< the newest frame
    std::string surface;               ///< of a vessel, at rest
    std::vector<std::string> vessels;  ///< later frames, in order
    Json state, welcome, marks;

  private:
    bool take_in(const WsMessage& message, Json& text);
    void take_in_frame(const std::string& bytes);
    void take_in_box(const Box3i& box, const std::vector<std::uint16_t>& halves,
                     std::vector<std::uint16_t>& copy) const;
    void take_in_rest(const serve::FrameHeader& header, const std::vector<std::uint16_t>& halves);
    std::uint32_t m_last_id = 0;
    bool m_is_whole = false;
};

/// MurmurHash3_x86_32, straight from its definition.
std::uint32_t murmur3(const std::vector<std::uint16_t>& halves);

}  // namespace pliant::test
