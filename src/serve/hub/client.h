// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// State that the scene's owner keeps for each client: sent data and pending data. All of it is
// bounded: changes of the volume are one bit per block, the client's own commands bound the waiting
// texts, and of states and tools only the newest is kept.

#pragma once

#include <chrono>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "hub/traffic.h"
#include "protocol/commands.h"
#include "protocol/dirty_blocks.h"
#include "protocol/frames.h"
#include "protocol/messages.h"

namespace pliant::serve {

using Clock = std::chrono::steady_clock;
using ConnectionId = std::uint64_t;

inline double ms_between(Clock::time_point from, Clock::time_point to) {
    return std::chrono::duration<double, std::milli>(to - from).count();
}

/// One WebSocket message. Shared, because several clients often receive the same one.
struct Outgoing {
    bool is_text = false;
    std::shared_ptr<const std::string> bytes;
};

/// Interface of the scene's owner to the network. Called on the owner's thread.
class Outlet {
  public:
    virtual ~Outlet() = default;
    /// Writes all messages in order, then calls Hub::written. One batch at a time.
    virtual void send(ConnectionId connection, std::vector<Outgoing> batch) = 0;
    virtual void close(ConnectionId connection, int code, const std::string& message) = 0;
    /// A message of this connection was processed: another may be read.
    virtual void taken(ConnectionId connection) = 0;
};

/// Tracks changes that were sent to a client, and changes that it has acknowledged.
class Delivery {
  public:
    static constexpr std::size_t kMaxUnseenSteps = 3;

    explicit Delivery(Vec3i volume_size)
        : m_due(volume_size), m_next(volume_size), m_sent(volume_size), m_size(volume_size) {}

    void mark(const Box3i& box) { (m_is_part ? m_next : m_due).mark(box); }
    void mark(const DirtyBlocks& blocks) { (m_is_part ? m_next : m_due).mark(blocks); }
    void mark_all() { m_due.mark_all(); }
    Vec3i size() const { return m_size; }
    bool is_due() const { return !m_due.empty() || !m_next.empty(); }
    bool may_send() const { return m_unseen.size() < kMaxUnseenSteps; }
    /// Takes the boxes to send now. Ends the step if nothing is left.
    std::vector<Box3i> take(std::int64_t max_voxels, std::uint32_t step, Clock::time_point now);
    void seen(std::uint32_t step);
    /// The client reconnects. @param step  of its voxels. @returns whether delivery can continue
    /// from that step; otherwise everything is due
    bool come_back(std::optional<std::uint32_t> step);
    /// Time since which an acknowledgement is outstanding.
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
    /// Changes during the delivery of m_due. Kept apart so that every block gets its turn, even if
    /// changes arrive faster than they can be sent.
    DirtyBlocks m_next;
    bool m_is_part = false;
    DirtyBlocks m_sent;  ///< since the last end of a step
    std::deque<Unseen> m_unseen;
    std::optional<std::uint32_t> m_seen;  ///< newest step that the client has acknowledged
    Vec3i m_size;
};

/// A waiting command, and the ids of drags that it replaced.
struct Waiting {
    Message message;
    std::vector<std::uint32_t> merged;
};

/// The outcome of a command, which is answered at the end of the step.
struct Answer {
    std::vector<std::uint32_t> ids;
    std::string_view name;
    Outcome outcome;
};

struct Client {
    explicit Client(Vec3i volume_size) : delivery(volume_size) {}

    /// Memory ran out for this client: its connection will be closed. If it comes back, it gets
    /// everything anew.
    void lose() {
        is_lost = true;
        commands.clear();
        delivery.come_back({});
    }

    ClientInfo info;
    EyeCommand eye;  ///< last eye sent to the scene
    std::string resume;
    bool packs = false;         ///< client supports LZ4
    bool wants_coarse = false;  ///< a coarse scan before the voxels
    bool coarse_is_due = false;
    ConnectionId connection = 0;  ///< 0: away
    Clock::time_point since{};    ///< start of the absence, or of writing the batch
    bool writing = false;
    bool is_lost = false;  ///< see lose()
    Delivery delivery;
    Line line;        ///< of its voxels
    Traffic traffic;  ///< depth of forces that the line takes
    /// After another scan was opened: the client's commands are ignored until it has acknowledged
    /// this step, because they may still refer to the old scan; 0: none
    std::uint32_t scene_step = 0;
    std::deque<Outgoing> texts;  ///< waiting answers
    std::deque<Waiting> commands;
    std::vector<Answer> answers;
    double spent_ms = 0;                                 ///< recent time spent on its commands
    std::vector<std::uint32_t> checksums;                ///< ids of pending requests
    std::uint64_t state_version = 0, tools_version = 0;  ///< versions last sent
    ToolPose tool;
    Clock::time_point iso_at{};    ///< its last change of the threshold
    std::uint32_t iso_stroke = 0;  ///< see IsoCommand
};

}  // namespace pliant::serve
