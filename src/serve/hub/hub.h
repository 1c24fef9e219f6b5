// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The owner of the scene: one thread that carries out the clients' commands and publishes the
// changes, at a fixed rate.
//
//   network ──events──► inbox ──► [ commands · relaxation · resampling · publishing ] ──► outlet
//
// Each step carries out waiting commands within a time budget, relaxes the tissue, updates the
// deformed volume, and encodes a new batch for each client that has received its last one. The
// volume doesn't change during the encoding. Slow clients get fewer, larger updates: queues stay
// bounded, and clients never wait for each other.
//
// If memory runs out for a command, it is refused. If it runs out for a client's message, answer or
// batch, the client is dropped, and may come back. The scene and its recording stay whole.

#pragma once

#include <array>
#include <atomic>
#include <list>
#include <memory>
#include <mutex>
#include <span>
#include <stop_token>
#include <string>

#include "hub/changed_blocks.h"
#include "hub/client.h"
#include "hub/device_feed.h"
#include "hub/inbox.h"
#include "hub/label_feed.h"
#include "hub/overlay_feed.h"
#include "hub/playback_feed.h"
#include "hub/publisher.h"
#include "hub/recorder.h"
#include "hub/roster.h"
#include "hub/sweep_pace.h"

namespace pliant::serve {

/// All feeds, in the order in which they are called.
struct Feeds {
    FeedHost& host;
    DeviceFeed device{host};
    OverlayFeed overlays{host};
    LabelFeed labels{host};
    PlaybackFeed playback{host};
    std::array<std::unique_ptr<Feed>, 5> others{make_rest_feed(host), make_vessel_feed(host),
                                                make_path_feed(host), make_mark_feed(host),
                                                make_camera_feed(host)};
    std::array<Feed*, 9> all{&device,         &overlays,       others[0].get(),
                             others[1].get(), others[2].get(), &labels,
                             others[3].get(), others[4].get(), &playback};

    auto begin() const { return all.begin(); }
    auto end() const { return all.end(); }
};

class Hub final : private FeedHost {
  public:
    /// @param log  may be null
    /// @param open_bytes  size limit of scans, for clients
    Hub(std::unique_ptr<Scene> scene, std::unique_ptr<SessionLog> log, int rate_hz,
        std::uint64_t open_bytes = 0);
    /// Enables checkpoints. Call it before run().
    /// @param seconds  of work between two checkpoints
    /// @param so_far   number of checkpoints in the session
    void keep_checkpoints(double seconds, int so_far) {
        m_recorder.keep_checkpoints(seconds, so_far);
    }
    /// Limits the spring nodes along an axis. Call it before run().
    void bound_springs(int nodes) { m_max_spring_nodes = nodes; }
    /// Sets the rate of updates that an automatic depth of forces leaves to each client; 0: the
    /// lines to the clients have no effect. Call it before run().
    void want_updates(int hz) { m_pace.want_updates(hz); }
    /// Plays a recorded session instead of a live scene. Call it before run().
    /// @pre the scene is the session's last one, at rest, and there is no log
    void watch(SessionFile session, const TaskArena& arena);
    /// Offers devices beside the built-in ones. Call it before run().
    void offer_devices(HapticDevices devices) { m_feeds.device.offer(std::move(devices)); }

    /// Adds an event of another thread, which is processed in the next step. Thread-safe.
    void post(Event event) { m_inbox.post(std::move(event)); }
    /// Grid of the present scan. Thread-safe.
    Grid grid() const {
        const std::lock_guard lock(m_grid_mutex);
        return m_grid;
    }

    /// Number of steps so far. Thread-safe.
    std::int64_t ticks() const { return m_ticks; }
    /// Runs until a stop is requested, then closes all connections.
    void run(const std::stop_token& stop, Outlet& outlet);

  private:
    // The step (hub.cpp).
    void wait_for_work(const std::stop_token& stop, Clock::time_point last);
    void make_step();
    void carry_out_commands();
    void carry_out(Client& client);
    void place_eyes();
    void relax();
    void resample();
    void update_volume(bool exactly);
    void mark_changes(std::span<const Box3i> boxes);
    void save_checkpoint();
    void send_answers();
    void refresh_state();
    void refresh_tools();
    void publish(Client& client);
    void release_sources();
    void measure_force();
    void end();
    SharedState shared_state();
    void change_tissue() noexcept;
    void note_lost_steps();

    // Events of other threads, and clients (hub_events.cpp).
    void take_events();
    void take(ConnectionId connection, Event::Opened& opened);
    void take(ConnectionId connection, Message& message);
    void take(ConnectionId connection, ParseFailure& failure);
    void take(ConnectionId connection, Event::Written&);
    void take(ConnectionId connection, Event::Closed&);
    void take(ConnectionId, Event::Saving& saving);
    void take(ConnectionId, Event::Opening& opening);
    void take(ConnectionId, Event::Restoring& restoring);
    void take(ConnectionId, Event::Labelling& labelling);
    template <class Process>
    void process(ConnectionId connection, const Process& work);
    void handle(Client& client, Message& message);
    void queue(Client& client, Message& message);
    void admit(ConnectionId connection, const HelloMessage& hello);
    void turn_away(ConnectionId connection, int code, const std::string& message);
    void begin_anew(Client& client);
    void drop(Client& client, int code, const std::string& message);
    void drop_late_clients();
    void park(Client& client);
    void release(Client& client);

    // FeedHost.
    Scene& scene() override { return *m_scene; }
    std::list<Client>& clients() override { return m_roster.clients(); }
    std::uint32_t step() const override { return m_step; }
    Clock::time_point now() const override { return m_now; }
    bool is_behind() const override { return m_is_behind; }
    bool is_near() const override { return m_is_near; }
    const DirtyBlocks& deformed() const override { return m_deformed; }
    bool keep_sources() override;
    void send(Client& client, std::string text) override;
    Outcome act(std::uint32_t client, const Action& action) override;
    Outcome play(std::uint32_t client, const Action& action) override;
    Status play_sweeps(const SessionSweeps& sweeps) override;
    Status play_state(const SessionState& state) override;
    std::unique_ptr<Scene> exchange(std::unique_ptr<Scene> scene) override;
    std::uint32_t& last_client() override { return m_roster.last_number(); }
    void worked() override { m_worked = true; }

    std::atomic<std::int64_t> m_ticks = 0;
    Inbox m_inbox;
    mutable std::mutex m_grid_mutex;
    Grid m_grid;  ///< of the present scan

    // Members below belong to the owner's thread.
    std::unique_ptr<Scene> m_scene;
    Recorder m_recorder;
    Roster m_roster;
    SweepPace m_pace;
    Feeds m_feeds{.host = *this};
    Publisher m_publisher{*this};
    Clock::duration m_period;
    std::uint64_t m_open_bytes;
    int m_max_spring_nodes = 32;
    Outlet* m_outlet = nullptr;
    DirtyBlocks m_deformed;            ///< voxels that were ever deformed
    DirtyBlocks m_exchanged;           ///< voxels of a scene that was exchanged
    ChangedBlocks m_changes;           ///< blocks with other values since the last update
    Clock::time_point m_sources_at{};  ///< last use of the sources of deformed voxels
    SharedState m_timing;              ///< timing of the last step with motion
    bool m_is_behind = false;          ///< the volume's update failed for lack of memory
    bool m_is_near = false;            ///< see is_near()
    std::int64_t m_near_elements = kNearElements;  ///< that approach() has time for
    int m_busy_ticks = 0;                          ///< ticks since the last force measurement

    // The present step.
    std::uint32_t m_step = 0;  ///< number of the volume's last change
    Clock::time_point m_now{};
    bool m_worked = false;
    bool m_moved = false;  ///< the volume may have changed
    double m_solve_ms = 0;
    std::int64_t m_moved_elements = 0;
};

}  // namespace pliant::serve
