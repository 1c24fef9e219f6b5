// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// What the owner of the scene knows of a client: what it has been sent, and what is due. Everything
// here is bounded: changes of the volume are one bit per block, texts wait in numbers that the
// client's own commands bound, and of states and tools there is only the newest.

#pragma once

#include <chrono>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "serve/commands.h"
#include "serve/dirty_blocks.h"
#include "serve/frames.h"
#include "serve/messages.h"

namespace pliant::serve {

using Clock = std::chrono::steady_clock;
using ConnectionId = std::uint64_t;

/// One WebSocket message; shared, as several clients are often sent the same.
struct Outgoing {
    bool is_text = false;
    std::shared_ptr<const std::string> bytes;
};

/// What the scene's owner wants of the network. Calls come from the owner's thread.
class Outlet {
  public:
    virtual ~Outlet() = default;
    /// All are written, in order; then Hub::written is called. One batch at a time.
    virtual void send(ConnectionId connection, std::vector<Outgoing> batch) = 0;
    virtual void close(ConnectionId connection, int code, const std::string& message) = 0;
    /// A message of this connection was taken: more may be read.
    virtual void taken(ConnectionId connection) = 0;
};

/// Which changes a client has been sent, and which of them it has seen.
class Delivery {
  public:
    static constexpr std::size_t kMaxUnseenSteps = 3;

    explicit Delivery(Vec3i volume_size)
        : m_due(volume_size), m_next(volume_size), m_sent(volume_size), m_size(volume_size) {}

    void mark(const Box3i& box) { (m_is_part ? m_next : m_due).mark(box); }
    void mark(const DirtyBlocks& blocks) { (m_is_part ? m_next : m_due).mark(blocks); }
    void mark_all() { m_due.mark_all(); }
    bool is_due() const { return !m_due.empty() || !m_next.empty(); }
    bool may_send() const { return m_unseen.size() < kMaxUnseenSteps; }
    /// What is to be sent now. If nothing is due any more, it ends the step.
    std::vector<Box3i> take(std::int64_t max_voxels, std::uint32_t step, Clock::time_point now);
    void seen(std::uint32_t step);
    /// The client comes back. @param step  whose voxels it holds. @returns whether that is a step
    /// from which it can go on; else everything is due
    bool come_back(std::optional<std::uint32_t> step);
    /// Since when the client owes an answer.
    std::optional<Clock::time_point> unseen_since() const {
        if (m_unseen.empty()) return {};
        return m_unseen.front().since;
    }

  private:
    struct Unseen {
        std::uint32_t step;
        DirtyBlocks blocks;
        Clock::time_point since;
    };
    DirtyBlocks m_due;
    /// What changed while a part of m_due had been sent: everybody's turn comes, even where more
    /// changes than can be sent.
    DirtyBlocks m_next;
    bool m_is_part = false;
    DirtyBlocks m_sent;  ///< since the last end of a step
    std::deque<Unseen> m_unseen;
    std::optional<std::uint32_t> m_seen;  ///< newest step that the client has seen
    Vec3i m_size;
};

/// A command that waits, and drags before it whose place it took.
struct Waiting {
    Message message;
    std::vector<std::uint32_t> merged;
};

struct Client {
    explicit Client(Vec3i volume_size) : delivery(volume_size), overlay_delivery(volume_size) {}

    ClientInfo info;
    EyeCommand eye;  ///< as the scene was told last
    std::string resume;
    bool packs = false;           ///< can read LZ4
    ConnectionId connection = 0;  ///< 0: away
    Clock::time_point since{};    ///< it is away, or its batch is being written
    bool writing = false;
    Delivery delivery;
    /// Since another scan was opened: the step that it must have seen before its commands count, as
    /// they may still mean the scan before; 0: none
    std::uint32_t scene_step = 0;
    OverlayKind overlay = OverlayKind::None;
    Delivery overlay_delivery;     ///< while there is an overlay
    std::optional<Delivery> rest;  ///< of the rest field's nodes; empty: the client wants none
    std::deque<Outgoing> texts;    ///< answers that wait
    std::deque<Waiting> commands;
    double spent_ms = 0;                                 ///< on its commands lately
    std::vector<std::uint32_t> checksums;                ///< ids of those that were asked for
    std::uint64_t state_version = 0, tools_version = 0;  ///< that it was sent
    std::uint64_t haptics_version = 0;
    bool wants_vessel = false, has_surface = false;
    std::uint64_t vessel_version = 0;  ///< that it was sent
    ToolPose tool;
    Clock::time_point iso_at{};    ///< its last change of the threshold
    std::uint32_t iso_stroke = 0;  ///< see IsoCommand
};

}  // namespace pliant::serve
