// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Owns the messages that all clients receive at the end of a step: the state, the tools, frames of
// voxels, checksums. A client gets one batch of everything that is due, once it has received the
// last one.

#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "hub/client.h"
#include "hub/feed.h"
#include "hub/recorder.h"

namespace pliant::serve {

class Publisher {
  public:
    explicit Publisher(FeedHost& host) : m_host(host) {}

    void start_step() { m_frames.clear(); }
    /// The tissue has changed: checksums are others.
    void tissue_changed() { m_checksums.reset(); }
    /// Another scene begins.
    void enter_scene();
    void set_state(const SharedState& state);
    void set_tools(std::vector<ToolPose> tools);
    /// Sends a connected client everything that is due.
    void publish(Client& client, std::span<Feed* const> feeds, Recorder& recorder, Outlet& outlet);

  private:
    void add_texts(const Client& client, std::vector<Outgoing>& batch);
    void add_coarse(const Client& client, std::vector<Outgoing>& batch);
    bool add_voxels(Client& client, std::vector<Outgoing>& batch);
    const Checksums* current_checksums(Recorder& recorder);

    FeedHost& m_host;
    std::string m_state_text;
    std::uint64_t m_state_version = 0;
    std::vector<ToolPose> m_tools;
    std::string m_tools_frame;
    std::uint64_t m_tools_version = 0;
    SharedFrames m_frames;  ///< of voxels, encoded in this step
    std::optional<Checksums> m_checksums;
    Clock::time_point m_checksums_at{};
};

}  // namespace pliant::serve
