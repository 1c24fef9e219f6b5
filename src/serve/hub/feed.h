// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Data beside the voxels that clients ask for: overlays, the rest field, the vessel, ways through
// the lumen, a device's force. Each kind is a Feed, with its own state per client. In each step,
// the hub calls all feeds in the same order:
//
//   take      messages of clients
//   act       a feed's own commands to the scene
//   follow    the voxels that have changed
//   refresh   everything else, while the volume is up to date
//   add       messages that are due, per client; then sent or lost
//
// A feed may throw std::bad_alloc. The hub then refuses the message, or repeats the call in the
// next step.

#pragma once

#include <cstdint>
#include <list>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "hub/client.h"
#include "session/scene.h"
#include "session/session_log.h"

namespace pliant::serve {

/// The hub, as its feeds see it.
class FeedHost {
  public:
    virtual Scene& scene() = 0;
    virtual std::list<Client>& clients() = 0;
    /// Step of the volume.
    virtual std::uint32_t step() const = 0;
    virtual Clock::time_point now() const = 0;
    /// Whether the volume lags behind the tissue, for lack of memory.
    virtual bool is_behind() const = 0;
    /// Voxels that were ever deformed.
    virtual const DirtyBlocks& deformed() const = 0;
    /// Keeps the sources of deformed voxels for a while. @returns false for lack of memory
    virtual bool keep_sources() = 0;
    /// Sends a text to a client, if it is connected.
    virtual void say(Client& client, std::string text) = 0;
    /// Refuses a message in the next step, for lack of memory.
    virtual void tell_later(ConnectionId connection, std::uint32_t id,
                            std::string_view name) noexcept = 0;
    /// Carries out and records a command.
    virtual Outcome act(std::uint32_t client, const Action& action) = 0;
    /// Carries out a command, sweeps or the loading of a state of a session that is watched.
    virtual Outcome play(std::uint32_t client, const Action& action) = 0;
    virtual Status play_sweeps(int count) = 0;
    virtual Status play_state(const SessionState& state) = 0;
    /// Replaces the scene by another state of the same scan. @returns the old one
    virtual std::unique_ptr<Scene> exchange(std::unique_ptr<Scene> scene) = 0;
    /// Highest number of a client or a device's tool so far.
    virtual std::uint32_t& last_client() = 0;
    /// Notes that this step did work.
    virtual void worked() = 0;

  protected:
    ~FeedHost() = default;
};

class Feed {
  public:
    explicit Feed(FeedHost& host) : m_host(host) {}
    virtual ~Feed() = default;
    Feed(const Feed&) = delete;
    Feed& operator=(const Feed&) = delete;

    /// @returns whether the message belongs to this feed
    virtual bool take(Client& client, const Message& message) = 0;
    virtual void act() {}
    /// @param boxes  voxels that have changed; may be empty
    /// @returns false for lack of memory: call it again in the next step
    virtual bool follow(std::span<const Box3i> /*boxes*/) { return true; }
    virtual void refresh() {}

    virtual void add(Client& /*client*/, std::vector<Outgoing>& /*batch*/) {}
    /// The batch was passed to the network.
    virtual void sent(Client& /*client*/) noexcept {}
    /// The batch may not have been sent.
    virtual void lost(Client& /*client*/) {}
    /// Whether more is due than was added.
    virtual bool is_due(const Client& /*client*/) const { return false; }
    /// Time since which an acknowledgement is outstanding.
    virtual std::optional<Clock::time_point> unseen_since(const Client& /*client*/) const {
        return {};
    }

    /// The client's connection has ended.
    virtual void leave(Client& /*client*/) {}
    /// Another tissue of the same scan is at rest now.
    virtual void change_tissue() {}
    /// The scene is about to be replaced.
    virtual void leave_scene() {}
    /// The scene is another one. No client is subscribed.
    virtual void enter_scene() noexcept = 0;

  protected:
    FeedHost& m_host;
};

/// Client with a number; null if it is away.
inline Client* connected(FeedHost& host, std::uint32_t number) {
    for (Client& client : host.clients())
        if (client.info.number == number && client.connection) return &client;
    return nullptr;
}

/// Encoded boxes of one step: several clients often receive the same one.
class SharedFrames {
  public:
    /// @param make  encodes the box: std::string()
    template <class Make>
    std::shared_ptr<const std::string> get(const Box3i& box, std::uint8_t flags, bool packed,
                                           std::uint16_t format, const Make& make) {
        for (const Frame& frame : m_frames)
            if (frame.box == box && frame.flags == flags && frame.packed == packed &&
                frame.format == format)
                return frame.bytes;
        m_frames.push_back(
            {box, flags, packed, format, std::make_shared<const std::string>(make())});
        return m_frames.back().bytes;
    }
    void clear() { m_frames.clear(); }

  private:
    struct Frame {
        Box3i box;
        std::uint8_t flags;
        bool packed;
        std::uint16_t format;
        std::shared_ptr<const std::string> bytes;
    };
    std::vector<Frame> m_frames;
};

}  // namespace pliant::serve
