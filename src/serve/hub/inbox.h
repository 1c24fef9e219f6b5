// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Events from other threads for the scene's owner, in the order in which they were posted.

#pragma once

#include <algorithm>
#include <condition_variable>
#include <filesystem>
#include <functional>
#include <list>
#include <memory>
#include <mutex>
#include <stop_token>
#include <string>
#include <utility>
#include <variant>

#include "hub/client.h"
#include "session/label_map.h"
#include "session/save.h"
#include "session/scene.h"
#include "session/session_log.h"

namespace pliant::serve {

/// A scene that replaces the present one.
struct NewScene {
    std::unique_ptr<Scene> scene;
    SessionHeader recorded;  ///< the scan's record in the session
};

/// Functions in an event are called on the owner's thread.
struct Event {
    struct Opened {
        bool may_control;
    };
    struct Written {};
    struct Closed {};
    /// Copy the present state for saving.
    struct Saving {
        SaveKind kind;
        std::function<void(Result<FileWriter>)> ready;
    };
    /// Replace the scene. The old one is returned, because freeing it takes time.
    struct Opening {
        NewScene scene;
        std::function<void(std::unique_ptr<Scene> old)> done;
    };
    /// Load a saved state of the tissue. On failure nothing has changed.
    struct Restoring {
        std::filesystem::path file;
        std::string recorded;  ///< name of the file in the session
        std::function<void(Status loaded)> done;
    };
    /// Show a label map to all clients.
    struct Labelling {
        std::shared_ptr<const LabelMap> map;  ///< null: the scene's bodies
        std::function<void(bool)> done;       ///< with whether it is on the scene's grid
    };

    ConnectionId connection;  ///< 0: none
    std::variant<Opened, Message, ParseFailure, Written, Closed, Saving, Opening, Restoring,
                 Labelling>
        body;
};

class Inbox {
  public:
    /// Thread-safe.
    void post(Event event) {
        std::list<Event> posted;
        posted.push_back(std::move(event));
        {
            const std::lock_guard lock(m_mutex);
            m_posted.splice(m_posted.end(), posted);
            if (is_command(m_posted.back())) m_command.request_stop();
        }
        m_wake.notify_one();
    }
    /// Waits for an event, a stop, or the time.
    void wait_until(Clock::time_point end, const std::stop_token& stop) {
        std::unique_lock lock(m_mutex);
        m_wake.wait_until(lock, stop, end, [&] { return !m_posted.empty(); });
    }
    /// Returns the events so far. The owner removes each one once it is processed; others stay for
    /// the next step.
    std::list<Event>& take() {
        const std::lock_guard lock(m_mutex);
        m_taken.splice(m_taken.end(), m_posted);
        return m_taken;
    }

    /// Ends a long piece of work when a command comes, or because one has come since take().
    std::stop_source stop_at_command() {
        std::stop_source command;
        const std::lock_guard lock(m_mutex);
        if (std::any_of(m_posted.begin(), m_posted.end(), is_command)) command.request_stop();
        return m_command = command;
    }

  private:
    static bool is_command(const Event& event) {
        const auto* message = std::get_if<Message>(&event.body);
        return message && serve::is_command(message->action);
    }

    std::mutex m_mutex;  ///< guards m_posted and m_command
    std::stop_source m_command;
    std::condition_variable_any m_wake;
    std::list<Event> m_posted;
    std::list<Event> m_taken;  ///< belongs to the owner's thread
};

}  // namespace pliant::serve
