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
//   add       messages that are due, per client; then sent
//
// A feed may throw std::bad_alloc. In take() and add() the hub then drops the client; the other
// calls are repeated in the next step.

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
    /// Whether the volume shows a state near the tissue's only; see Scene::approach().
    virtual bool is_near() const = 0;
    /// Voxels that were ever deformed.
    virtual const DirtyBlocks& deformed() const = 0;
    /// Keeps the sources of deformed voxels for a while. It may write the volume anew, so call it
    /// in refresh() only. @returns false for lack of memory
    virtual bool keep_sources() = 0;
    /// Sends a text to a client, if it is connected.
    virtual void send(Client& client, std::string text) = 0;
    /// Answers a message that was carried out.
    void accept(Client& client, std::uint32_t id, std::string_view name) {
        send(client, outcome_text(id, name, step(), {}));
    }
    /// Answers a message that wasn't.
    void refuse(Client& client, std::uint32_t id, std::string_view name, const char* code,
                const std::string& why) {
        send(client, outcome_text(id, name, 0,
                                  {.error_code = code, .message = std::string(name) + ": " + why}));
    }
    /// Carries out and records a command. Throws std::bad_alloc if memory runs out; then the scene
    /// is unchanged, except that its open step has ended.
    virtual Outcome act(std::uint32_t client, const Action& action) = 0;
    /// Carries out a command, sweeps or the loading of a state of a session that is watched.
    virtual Outcome play(std::uint32_t client, const Action& action) = 0;
    virtual Status play_sweeps(const SessionSweeps& sweeps) = 0;
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
    /// Whether more is due than was added.
    virtual bool is_due(const Client& /*client*/) const { return false; }
    /// Time since which an acknowledgement is outstanding.
    virtual std::optional<Clock::time_point> unseen_since(const Client& /*client*/) const {
        return {};
    }

    /// The client's connection has ended.
    virtual void leave(Client& /*client*/) {}
    /// Another tissue of the same scan is at rest now.
    virtual void change_tissue() noexcept {}
    /// The scene is about to be replaced.
    virtual void leave_scene() {}
    /// The scene is another one. No client is subscribed.
    virtual void enter_scene() noexcept = 0;

  protected:
    FeedHost& m_host;
};

// Feeds that only their own files know.
std::unique_ptr<Feed> make_rest_feed(FeedHost& host);
std::unique_ptr<Feed> make_vessel_feed(FeedHost& host);
std::unique_ptr<Feed> make_path_feed(FeedHost& host);
std::unique_ptr<Feed> make_mark_feed(FeedHost& host);
std::unique_ptr<Feed> make_camera_feed(FeedHost& host);

/// Client with a number; null if it is away.
inline Client* connected(FeedHost& host, std::uint32_t number) {
    for (Client& client : host.clients())
        if (client.info.number == number && client.connection) return &client;
    return nullptr;
}

/// Encoded boxes of one step: several clients often receive the same one.
class SharedFrames {
  public:
    /// Adds the frames of boxes to a batch.
    /// @param ends  whether nothing more is due
    /// @param make  encodes a box: std::string(const Box3i& box, std::uint8_t flags)
    template <class Make>
    void add(std::span<const Box3i> boxes, bool ends, bool packed, std::uint16_t format,
             std::vector<Outgoing>& batch, const Make& make) {
        for (const Box3i& box : boxes) {
            const std::uint8_t flags = ends && &box == &boxes.back() ? kFrameLastOfStep : 0;
            batch.push_back({false, get(box, flags, packed, format, make)});
        }
    }
    void clear() { m_frames.clear(); }

  private:
    template <class Make>
    std::shared_ptr<const std::string> get(const Box3i& box, std::uint8_t flags, bool packed,
                                           std::uint16_t format, const Make& make) {
        for (const Frame& frame : m_frames)
            if (frame.box == box && frame.flags == flags && frame.packed == packed &&
                frame.format == format)
                return frame.bytes;
        m_frames.push_back(
            {box, flags, packed, format, std::make_shared<const std::string>(make(box, flags))});
        return m_frames.back().bytes;
    }
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
