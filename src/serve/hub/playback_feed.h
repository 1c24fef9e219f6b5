// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A recorded session that is watched: its records change the scene at their times, at any speed.
// Forward, the records up to the wanted time are carried out, a while in each step. Backward, a
// scene at rest is brought to that time on another thread, and takes the place of the present one.

#pragma once

#include <map>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "hub/background.h"
#include "hub/feed.h"
#include "session/session_log.h"
#include "session/timeline.h"

namespace pliant::serve {

class PlaybackFeed final : public Feed {
  public:
    explicit PlaybackFeed(FeedHost& host) : Feed(host) {}

    /// Begins at the start of the session's last scene. Keeps a reference to the arena, which
    /// scenes are loaded with. Call it before the hub runs.
    /// @pre the host's scene is that scene at rest
    void load(SessionFile file, const TaskArena& arena);
    bool is_on() const { return m_arena != nullptr; }
    /// Highest number of a client in the session.
    std::uint32_t last_client() const;
    /// Tools of the session's clients, as far as its commands tell.
    const std::map<std::uint32_t, ToolPose>& tools() const { return m_tools; }

    bool take(Client& client, const Message& message) override;
    void act() override;
    void refresh() override;
    void leave(Client& client) override { m_told.erase(client.info.number); }
    void enter_scene() noexcept override {}

  private:
    /// A scene that is brought to an earlier time.
    struct Rewinding {
        std::size_t to = 0;  ///< records that are carried out
        Background<std::unique_ptr<Scene>> scene;
    };

    std::span<const SessionRecord> records() const;
    std::size_t records_until(double at_ms) const;
    void jump(double at_ms);
    void rewind(std::size_t to);
    void finish_rewinding();
    void play_one(const SessionRecord& record);
    void show_tool(const SessionCommand& command);
    void fail(const std::string& message);
    std::string news_text() const;

    SessionFile m_file;
    const TaskArena* m_arena = nullptr;
    std::vector<double> m_times;
    std::string m_marks;     ///< message with the marks of the time line
    std::size_t m_next = 0;  ///< records that are carried out
    double m_at_ms = 0;      ///< wanted time
    double m_speed = 1;
    bool m_is_playing = false;
    bool m_is_jumping = false;  ///< on the way to the wanted time
    std::string m_failure;
    Clock::time_point m_acted_at{}, m_told_at{};
    std::unique_ptr<Rewinding> m_rewinding;
    std::jthread m_cleaner;  ///< frees an old scene
    std::map<std::uint32_t, ToolPose> m_tools;
    Vec3d m_grabbed_mm{0, 0, 0};                   ///< begin of the newest drag
    std::map<std::uint32_t, double> m_tool_times;  ///< last command of each [ms]
    std::string m_news;                            ///< newest message
    std::map<std::uint32_t, std::string> m_told;   ///< news that a client has
};

}  // namespace pliant::serve
