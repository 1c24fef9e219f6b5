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

#pragma once

#include <array>
#include <atomic>
#include <condition_variable>
#include <functional>
#include <list>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <stop_token>
#include <string>
#include <variant>
#include <vector>

#include "hub/camera_feed.h"
#include "hub/changed_blocks.h"
#include "hub/client.h"
#include "hub/device_feed.h"
#include "hub/feed.h"
#include "hub/label_feed.h"
#include "hub/mark_feed.h"
#include "hub/overlay_feed.h"
#include "hub/path_feed.h"
#include "hub/playback_feed.h"
#include "hub/rest_feed.h"
#include "hub/vessel_feed.h"
#include "session/guarded.h"
#include "session/save.h"
#include "session/scene.h"
#include "session/session_log.h"

namespace pliant::serve {

/// A scene that replaces the present one.
struct NewScene {
    std::unique_ptr<Scene> scene;
    SessionHeader recorded;  ///< the scan's record in the session
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
    void keep_checkpoints(double seconds, int so_far);
    /// Limits the spring nodes along an axis. Call it before run().
    void bound_springs(int nodes) { m_max_spring_nodes = nodes; }
    /// Sets the rate of updates that an automatic depth of forces leaves to each client; 0: the
    /// lines to the clients have no effect. Call it before run().
    void want_updates(int hz) { m_network_hz = hz; }
    /// Plays a recorded session instead of a live scene. Call it before run().
    /// @pre the scene is the session's last one, at rest, and there is no log
    void watch(SessionFile session, const TaskArena& arena);
    /// Offers devices beside the built-in ones. Call it before run().
    void offer_devices(HapticDevices devices) { m_device.offer(std::move(devices)); }

    // Called on the network's thread; none of them blocks.
    void opened(ConnectionId connection, bool may_control);
    void received(ConnectionId connection, Message message);
    /// Reports a command with a field out of range.
    void refused(ConnectionId connection, ParseFailure failure);
    void written(ConnectionId connection);
    void closed(ConnectionId connection);
    /// Copies the present state for saving. Calls back on the owner's thread.
    void save(SaveKind kind, std::function<void(Result<FileWriter>)> ready);
    /// Replaces the scene. Calls back on the owner's thread with the old scene, because freeing it
    /// takes time that another thread should spend.
    void open(NewScene scene, std::function<void(std::unique_ptr<Scene> old)> done);

    /// Loads a saved state of the tissue. Calls back on the owner's thread; on failure nothing has
    /// changed.
    /// @param recorded  name of the file in the session
    void load_state(std::filesystem::path file, std::string recorded,
                    std::function<void(Status loaded)> done);

    /// Shows a label map to all clients; null: the scene's bodies. Calls back on the owner's
    /// thread.
    /// @param done  with whether it is on the scene's grid; else nothing changes
    void show_labels(std::shared_ptr<const LabelMap> map, std::function<void(bool)> done);
    /// Grid of the present scan. Thread-safe.
    Grid grid() const;

    /// Number of steps so far. Thread-safe.
    std::int64_t ticks() const { return m_ticks; }
    /// Runs until a stop is requested, then closes all connections.
    void run(const std::stop_token& stop, Outlet& outlet);

  private:
    struct Opened {
        bool may_control;
    };
    struct Written {};
    struct Closed {};
    struct Saving {
        SaveKind kind;
        std::function<void(Result<FileWriter>)> ready;
    };
    struct Opening {
        NewScene scene;
        std::function<void(std::unique_ptr<Scene> old)> done;
    };
    struct Restoring {
        std::filesystem::path file;
        std::string recorded;
        std::function<void(Status loaded)> done;
    };
    struct Labelling {
        std::shared_ptr<const LabelMap> map;
        std::function<void(bool)> done;
    };
    struct Event {
        ConnectionId connection;
        std::variant<Opened, Message, ParseFailure, Written, Closed, Saving, Opening, Restoring,
                     Labelling>
            what;
    };
    struct Newcomer {
        bool may_control;
        Clock::time_point since;
    };
    using Clients = std::list<Client>;
    struct Done {
        std::uint32_t client;
        std::vector<std::uint32_t> ids;
        std::string name;
        Outcome outcome;
    };
    /// A message that was refused for lack of memory; its sender isn't informed yet.
    struct Untold {
        ConnectionId connection;
        std::uint32_t id;
        std::string_view name;
    };

    void post(Event event);
    void wait_for_work(const std::stop_token& stop, Clock::time_point last);
    void make_step();
    void release(Client& client);

    void take_events();
    void take(ConnectionId connection, Opened& opened);
    void take(ConnectionId connection, Message& message);
    void take(ConnectionId connection, ParseFailure& failure);
    void take(ConnectionId connection, Written&);
    void take(ConnectionId connection, Closed&);
    void take(ConnectionId connection, Saving& saving);
    void take(ConnectionId connection, Opening& opening);
    void take(ConnectionId connection, Restoring& restoring);
    void take(ConnectionId connection, Labelling& labelling);
    void begin_anew(Client& client);
    void say_hello(ConnectionId connection, const HelloMessage& hello);
    void answer(Client& client, Message message);
    void queue(Client& client, Message message);

    void carry_out_commands();
    void carry_out(Client& client);
    void change_tissue();
    void feel(Client& client, const Action& action, const Outcome& outcome);
    void measure_force();
    void tell_eyes();
    void relax();
    void measure_updates(int sweeps, double each_ms, double passed_ms, double took_ms);
    void adapt_depth();
    int depth_for_lines(int depth);
    void resample();
    void mark_changes(std::span<const Box3i> boxes);
    void note(SessionRecord record) noexcept;
    void note_time();
    bool log_is_ready() noexcept;
    void write_log();
    void checkpoint();

    void tell_outcomes();
    void refresh_state();
    void refresh_tools();
    void publish(Client& client);
    void note_traffic(Client& client, std::size_t bytes, bool has_voxels);
    void add_coarse(const Client& client, std::vector<Outgoing>& batch);
    void add_boxes(Client& client, std::vector<Outgoing>& batch);
    const Checksums* current_checksums();

    // FeedHost.
    Scene& scene() override { return *m_scene; }
    std::list<Client>& clients() override { return m_clients; }
    std::uint32_t step() const override { return m_step; }
    Clock::time_point now() const override { return m_now; }
    bool is_behind() const override { return m_is_behind; }
    const DirtyBlocks& deformed() const override { return m_deformed; }
    bool keep_sources() override;
    void say(Client& client, std::string text) override;
    void tell_later(ConnectionId connection, std::uint32_t id,
                    std::string_view name) noexcept override;
    Outcome act(std::uint32_t client, const Action& action) override;
    Outcome play(std::uint32_t client, const Action& action) override;
    Status play_sweeps(int count) override;
    Status play_state(const SessionState& state) override;
    std::unique_ptr<Scene> exchange(std::unique_ptr<Scene> scene) override;
    std::uint32_t& last_client() override { return m_last_client; }
    void worked() override { m_worked = true; }

    void act_by_feeds();
    void refresh_feeds();
    void release_sources();

    void drop_who_is_late();
    void drop(Client& client, int code, const std::string& message);
    void park(Client& client);
    Client* client_of(ConnectionId connection);
    SharedState shared_state() const;

    std::atomic<std::int64_t> m_ticks = 0;
    mutable std::mutex m_mutex;  ///< of the inbox and the grid
    Grid m_grid;                 ///< of the present scan
    std::condition_variable_any m_wake;
    std::vector<Event> m_inbox;

    // Members below belong to the owner's thread.
    std::vector<Event> m_events;  ///< taken from the inbox
    std::size_t m_taken = 0;      ///< number of processed ones
    std::vector<Untold> m_untold;
    std::unique_ptr<Scene> m_scene;
    std::unique_ptr<SessionLog> m_log;
    bool m_is_recorded = true;              ///< whether the session's file has all records
    Clock::time_point m_flush_at{};         ///< time of the last write
    Clock::time_point m_noted_at{};         ///< time of the last SessionWait
    std::vector<SessionRecord> m_unlogged;  ///< records that wait for memory
    double m_checkpoint_ms = 0;             ///< work between two checkpoints
    double m_unsaved_ms = 0;                ///< work since the last checkpoint
    bool m_is_unsaved = false;              ///< whether there was work
    int m_checkpoints = 0;                  ///< number in the session
    Clock::duration m_period;
    std::uint64_t m_open_bytes;
    int m_max_spring_nodes = 32;
    int m_network_hz = 25;
    Outlet* m_outlet = nullptr;
    std::map<ConnectionId, Newcomer> m_newcomers;
    Clients m_clients;
    std::uint32_t m_last_client;
    std::uint32_t m_step = 0;
    Clock::time_point m_now{};
    bool m_moved = false;      ///< the volume may have changed in this step
    bool m_is_behind = false;  ///< the volume's update failed for lack of memory
    bool m_worked = false;
    int m_busy_ticks = 0;       ///< ticks since the last force measurement
    bool m_was_moving = false;  ///< a model with simulated time was in motion
    double m_owed_ms = 0;       ///< lag of the model's time
    Clock::time_point m_relaxed_at{};
    double m_window_ms = 0, m_window_sweeps_ms = 0, m_window_took_ms = 0;  ///< for update_hz
    std::vector<Done> m_outcomes;                                          ///< of this step
    double m_solve_ms = 0;                                                 ///< of this step
    std::int64_t m_moved_elements = 0;
    SharedState m_timing;  ///< timing of the last step with motion
    std::string m_state_text;
    std::uint64_t m_state_version = 0;
    std::vector<ToolPose> m_tools;
    std::string m_tools_frame;
    std::uint64_t m_tools_version = 0;
    SharedFrames m_frames;             ///< boxes of voxels, encoded in this step
    DirtyBlocks m_deformed;            ///< voxels that were ever deformed
    DirtyBlocks m_exchanged;           ///< voxels of a scene that was exchanged
    ChangedBlocks m_changes;           ///< blocks with other values since the last update
    Clock::time_point m_sources_at{};  ///< last use of the sources of deformed voxels
    DeviceFeed m_device{*this};
    OverlayFeed m_overlays{*this};
    RestFeed m_rest{*this};
    VesselFeed m_vessel{*this};
    PathFeed m_paths{*this};
    CameraFeed m_cameras{*this};
    PlaybackFeed m_playback{*this};
    LabelFeed m_labels{*this};
    MarkFeed m_marks{*this};
    std::array<Feed*, 9> m_feeds{&m_device, &m_overlays, &m_rest,    &m_vessel,  &m_paths,
                                 &m_labels, &m_marks,    &m_cameras, &m_playback};
    std::optional<Checksums> m_checksums;
    Clock::time_point m_checksums_at{};
};

}  // namespace pliant::serve
