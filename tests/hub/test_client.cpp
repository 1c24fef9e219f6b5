// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "hub/test_client.h"

#include <gtest/gtest.h>

#include <cerrno>
#include <chrono>
#include <cstring>

#include "hub/read_frames.h"

namespace pliant::test {
RawConnection::RawConnection(int port) : Connection(port) {
    if (!is_open()) ADD_FAILURE() << "no connection: " << std::strerror(errno);
}

std::string RawConnection::upgrade(const std::string& token, const std::string& host,
                                   const std::string& origin) {
    send("GET /ws?token=" + token + " HTTP/1.1\r\nHost: " + (host.empty() ? this->host() : host) +
         "\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
         "Sec-WebSocket-Key: AAECAwQFBgcICQoLDA0ODw==\r\nSec-WebSocket-Version: 13\r\n" +
         (origin.empty() ? "" : "Origin: " + origin + "\r\n") + "\r\n");
    const std::string response = read_response();
    return response.substr(0, response.find("\r\n"));
}

TestClient::TestClient(int port, const std::string& link) : RawConnection(port) {
    const std::string line = upgrade(token_of(link));
    EXPECT_NE(line.find(" 101 "), std::string::npos) << line;
}

void TestClient::say(const Json& message) {
    send_frame(1, message.dump());
}

void TestClient::send_frame(int opcode, std::string_view payload) {
    std::string frame(1, char(0x80 | opcode));
    const std::size_t length = payload.size();
    if (length < 126) {
        frame += char(0x80 | length);
    } else if (length < 65536) {
        frame += {char(0x80 | 126), char(length >> 8), char(length)};
    } else {
        frame += char(0x80 | 127);
        for (int shift = 56; shift >= 0; shift -= 8) frame += char(std::uint64_t(length) >> shift);
    }
    const char mask[4] = {'\x12', '\x34', '\x56', '\x78'};
    frame.append(mask, 4);
    for (std::size_t n = 0; n < length; ++n) frame += char(payload[n] ^ mask[n % 4]);
    send(frame);
}

WsMessage TestClient::read() {
    const WsMessage gone{-1, ""};
    // A server with nothing to say still pings.
    const auto end = std::chrono::steady_clock::now() + std::chrono::milliseconds(kPatienceMs);
    while (std::chrono::steady_clock::now() < end) {
        if (!fill(2)) return gone;
        const int opcode = m_buffer[0] & 15;
        std::size_t length = std::uint8_t(m_buffer[1]) & 127U, header = 2;
        if (length >= 126) {
            const std::size_t bytes = length == 126 ? 2 : 8;
            if (!fill(2 + bytes)) return gone;
            length = 0;
            for (std::size_t n = 0; n < bytes; ++n)
                length = length << 8 | std::uint8_t(m_buffer[2 + n]);
            header += bytes;
        }
        if (!fill(header + length)) return gone;
        std::string payload = m_buffer.substr(header, length);
        m_buffer.erase(0, header + length);
        if (opcode == 9) {
            send_frame(10, payload);
            continue;
        }
        if (opcode == 10) continue;
        return {opcode, std::move(payload)};
    }
    return gone;
}

void TestClient::take_in_frame(const std::string& bytes) {
    const auto header = serve::read_frame_header(bytes);
    ASSERT_TRUE(header);
    if (header->type == serve::FrameType::Tools) {
        tools = bytes;
        return;
    }
    if (header->type == serve::FrameType::Surface) surface = bytes;
    if (header->type == serve::FrameType::Vessel) vessels.push_back(bytes);
    if (header->type != serve::FrameType::Box) return;
    const auto halves = serve::read_box(bytes);
    ASSERT_TRUE(halves);
    const Box3i box = header->box;
    if (header->count == serve::kFormatRest) {
        EXPECT_LE(bytes.size(), (1U << 20) + 32);
        return take_in_rest(*header, *halves);
    }
    for (int a = 0; a < 3; ++a) ASSERT_LE(box.end[a], size[a]);
    if (header->count == serve::kFormatCoarse) {
        EXPECT_EQ(boxes, 0) << "a coarse scan comes first";
        coarse.insert(coarse.end(), halves->begin(), halves->end());
        return;
    }
    if (header->count != 1) {
        // One of an overlay that was given up may still come.
        ++overlay_boxes;
        EXPECT_LE(bytes.size(), (1U << 20) + 32);
        if (header->count != overlay_format) return;
        take_in_box(box, *halves, overlay);
        if (!(header->flags & serve::kFrameLastOfStep)) return;
        ++whole_overlays;
        overlay_step = header->step;
        if (sends_overlay_seen)
            say({{"do", "seen"}, {"step", overlay_step}, {"format", overlay_format}});
        return;
    }
    take_in_box(box, *halves, voxels);
    box_bytes += std::int64_t(bytes.size());
    ++boxes;
    EXPECT_LE(bytes.size(), (1U << 20) + 32);
    if (!(header->flags & serve::kFrameLastOfStep)) return;
    step = header->step;
    m_is_whole = true;
    if (sends_seen) say({{"do", "seen"}, {"step", step}});
}

void TestClient::take_in_box(const Box3i& box, const std::vector<std::uint16_t>& halves,
                             std::vector<std::uint16_t>& copy) const {
    std::size_t n = 0;
    for (int k = box.begin.z; k < box.end.z; ++k)
        for (int j = box.begin.y; j < box.end.y; ++j)
            for (int i = box.begin.x; i < box.end.x; ++i)
                copy[std::size_t(i) + std::size_t(size.x) *
                                          (std::size_t(j) + std::size_t(size.y) * std::size_t(k))] =
                    halves[n++];
}

bool TestClient::take_in(const WsMessage& message, Json& text) {
    text = nullptr;
    if (message.opcode == 8) {
        if (message.bytes.size() >= 2)
            close_code = std::uint8_t(message.bytes[0]) << 8 | std::uint8_t(message.bytes[1]);
        close_reason = message.bytes.size() > 2 ? message.bytes.substr(2) : "";
        return false;
    }
    if (message.opcode < 0) return false;
    if (message.opcode == 2) {
        take_in_frame(message.bytes);
        return true;
    }
    text = Json::parse(message.bytes, nullptr, false);
    EXPECT_TRUE(text.is_object()) << message.bytes.substr(0, 200);
    if (text["t"] == "state") state = text;
    if (text["t"] == "replay_marks") marks = text["marks"];
    return true;
}

Json TestClient::until(const std::function<bool(const Json&)>& holds) {
    const auto end = std::chrono::steady_clock::now() + std::chrono::milliseconds(kPatienceMs);
    Json text;
    while (std::chrono::steady_clock::now() < end && take_in(read(), text))
        if (!text.is_null() && holds(text)) return text;
    return {};
}

Json TestClient::until(const std::string& type) {
    return until([&](const Json& text) { return text["t"] == type; });
}

Json TestClient::answer(std::uint32_t id) {
    return until([&](const Json& text) {
        return (text["t"] == "done" || text["t"] == "error") && text["id"] == id;
    });
}

Json TestClient::command(Json message) {
    message["id"] = ++m_last_id;
    say(message);
    return answer(m_last_id);
}

Json TestClient::enter(const Json& hello) {
    Json message = {{"do", "hello"}, {"protocol", 2}};
    message.update(hello);
    say(message);
    welcome = until("welcome");
    if (welcome.is_null()) return welcome;
    const Json& volume = welcome["volume"];
    size = {volume["size"][0], volume["size"][1], volume["size"][2]};
    state = welcome["state"];
    if (welcome["resumed"] == false) {
        voxels.assign(std::size_t(size.x) * std::size_t(size.y) * std::size_t(size.z), 0xffff);
        EXPECT_TRUE(until_up_to_date());
    }
    return welcome;
}

bool TestClient::until_up_to_date() {
    m_is_whole = false;
    Json text;
    while (!m_is_whole)
        if (!take_in(read(), text)) return false;
    return true;
}

Json TestClient::ask_overlay(const std::string& kind) {
    const Json done = command({{"do", "overlay"}, {"kind", kind}});
    overlay_format = kind == "displacement" ? 2 : kind == "jacobian" ? 3 : 0;
    constexpr std::uint16_t kOne = 0x3c00;
    overlay.assign(voxels.size(), kind == "jacobian" ? kOne : std::uint16_t(0));
    return done;
}

Json TestClient::ask_rest(bool on) {
    const Json done = command({{"do", "rest"}, {"on", on}});
    const Vec3i n = rest_counts();
    rest.assign(on ? std::size_t(4 * n.x * n.y * n.z) : 0, 0);
    return done;
}

Vec3i TestClient::rest_counts() const {
    return {(size.x + 2) / 4 + 1, (size.y + 2) / 4 + 1, (size.z + 2) / 4 + 1};
}

void TestClient::take_in_rest(const serve::FrameHeader& header,
                              const std::vector<std::uint16_t>& halves) {
    ++rest_boxes;
    if (rest.empty()) return;  // one that was given up
    const Vec3i n = rest_counts();
    const Box3i box = header.box;
    for (int a = 0; a < 3; ++a) ASSERT_LE(box.end[a], n[a]);
    std::size_t from = 0;
    for (int k = box.begin.z; k < box.end.z; ++k)
        for (int j = box.begin.y; j < box.end.y; ++j)
            for (int i = box.begin.x; i < box.end.x; ++i)
                for (int c = 0; c < 4; ++c)
                    rest[std::size_t(4 * (i + n.x * (j + n.y * k)) + c)] = halves[from++];
    if (!(header.flags & serve::kFrameLastOfStep)) return;
    ++whole_rests;
    rest_step = header.step;
    if (sends_rest_seen) say({{"do", "seen"}, {"step", rest_step}, {"format", 4}});
}

Json TestClient::checked_checksum() {
    say({{"do", "checksum"}, {"id", 77}});
    const Json sums = until("checksum");
    if (sums.is_null()) {
        ADD_FAILURE() << "no checksum: " << close_reason;
        return sums;
    }
    char own[9];
    std::snprintf(own, sizeof own, "%08x", murmur3(voxels));
    EXPECT_EQ(sums["voxels"], own);
    EXPECT_GE(sums["step"].get<std::uint32_t>(), step);
    return sums;
}

int TestClient::wait_for_close() {
    Json text;
    while (take_in(read(), text)) {
    }
    return close_code;
}

std::uint32_t murmur3(const std::vector<std::uint16_t>& halves) {
    std::vector<unsigned char> bytes;
    for (const std::uint16_t half : halves) {
        bytes.push_back(half & 0xff);
        bytes.push_back(half >> 8);
    }
    const std::size_t size = bytes.size();
    const auto turn = [](std::uint32_t v, int by) { return v << by | v >> (32 - by); };
    std::uint32_t h = 0;
    std::size_t n = 0;
    for (; n + 4 <= size; n += 4) {
        std::uint32_t k =
            bytes[n] | bytes[n + 1] << 8 | bytes[n + 2] << 16 | std::uint32_t(bytes[n + 3]) << 24;
        k *= 0xcc9e2d51U;
        k = turn(k, 15);
        k *= 0x1b873593U;
        h ^= k;
        h = turn(h, 13);
        h = h * 5 + 0xe6546b64U;
    }
    if (n < size) {
        std::uint32_t k = bytes[n] | std::uint32_t(bytes[n + 1]) << 8;
        k *= 0xcc9e2d51U;
        k = turn(k, 15);
        k *= 0x1b873593U;
        h ^= k;
    }
    h ^= std::uint32_t(size);
    h ^= h >> 16;
    h *= 0x85ebca6bU;
    h ^= h >> 13;
    h *= 0xc2b2ae35U;
    return h ^ (h >> 16);
}

}  // namespace pliant::test
