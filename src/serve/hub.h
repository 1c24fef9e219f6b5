// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The owner of the scene: one thread that takes what clients want, does it, and tells them what
// changed, at a fixed rate.
//
//   network ──events──► inbox ──► [ commands · relaxation · resampling · publishing ] ──► outlet
//
// In each step it carries out what has come in, as far as time goes; lets the tissue relax; brings
// the deformed volume up to date; and gives each client that has taken its last batch a new one,
// encoded here, while the volume stands still. Who is slow gets fewer, with what has changed
// meanwhile: nothing queues up, and nobody waits for anybody else.

#pragma once

#include <atomic>
#include <condition_variable>
#include <functional>
#include <list>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <stop_token>
#include <string>
#include <variant>
#include <vector>

#include <pliant/rest_field.h>

#include "serve/client.h"
#include "serve/device_opening.h"
#include "serve/guarded.h"
#include "serve/haptic_session.h"
#include "serve/path_search.h"
#include "serve/save.h"
#include "serve/scene.h"
#include "serve/session_log.h"
#include "serve/vessel_frames.h"

namespace pliant::serve {

/// A scene that is to take the place of the present one.
struct NewScene {
    std::unique_ptr<Scene> scene;
    SessionHeader recorded;  ///< as the session shall name its scan
};

class Hub {
  public:
    /// @param log  may be null
    /// @param open_bytes  told to clients: how large a scan may be that they open
    Hub(std::unique_ptr<Scene> scene, std::unique_ptr<SessionLog> log, int rate_hz,
        std::uint64_t open_bytes = 0);
    /// Before run().
    /// @param seconds  of work from one to the next
    /// @param so_far   that the session has
    void keep_checkpoints(double seconds, int so_far);
    /// Before run(), too. @param nodes  along an axis, that a client may ask for
    void bound_springs(int nodes) { m_max_spring_nodes = nodes; }
    /// Before run(), too: devices beside those in the tree.
    void offer_devices(HapticDevices devices) { m_haptic_devices = std::move(devices); }

    // From the network's thread; none of them waits.
    void opened(ConnectionId connection, bool may_control);
    void received(ConnectionId connection, Message message);
    /// A field of a command is out of its range.
    void refused(ConnectionId connection, ParseFailure failure);
    void written(ConnectionId connection);
    void closed(ConnectionId connection);
    /// Takes what is to be saved as it is now. Calls back on the owner's thread.
    void save(SaveKind kind, std::function<void(Result<FileWriter>)> ready);
    /// Calls back on the owner's thread with the scene that was there before: it takes its time to
    /// free, which somebody else shall spend.
    void open(NewScene scene, std::function<void(std::unique_ptr<Scene> old)> done);

    /// Steps so far; from any thread.
    std::int64_t ticks() const { return m_ticks; }
    /// Runs until it is to stop; then all connections are closed.
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
    struct Event {
        ConnectionId connection;
        std::variant<Opened, Message, ParseFailure, Written, Closed, Saving, Opening> what;
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
    struct OverlayWish {
        std::uint32_t client;
        std::uint32_t id;
        OverlayKind kind;
    };
    struct RestWish {
        std::uint32_t client;
        std::uint32_t id;
        bool on;
    };
    struct SharedBox {
        Box3i box;
        std::uint8_t flags;
        bool packed;
        std::uint16_t format;
        std::shared_ptr<const std::string> bytes;
    };

    /// A message that was refused because memory ran out, and whose sender doesn't know yet.
    struct Untold {
        ConnectionId connection;
        std::uint32_t id;
        std::string_view name;
    };

    void post(Event event);
    void wait_for_work(const std::stop_token& stop, Clock::time_point last);
    void step();
    void tell_later(const Untold& untold) noexcept;
    void release(Client& client);

    void take_events();
    void take(ConnectionId connection, Opened& opened);
    void take(ConnectionId connection, Message& message);
    void take(ConnectionId connection, ParseFailure& failure);
    void take(ConnectionId connection, Written&);
    void take(ConnectionId connection, Closed&);
    void take(ConnectionId connection, Saving& saving);
    void take(ConnectionId connection, Opening& opening);
    void begin_anew(Client& client);
    void say_hello(ConnectionId connection, const HelloMessage& hello);
    void answer(Client& client, Message message);
    void queue(Client& client, Message message);
    void say(Client& client, std::string text);

    void carry_out_commands();
    void carry_out(Client& client);
    Outcome act(std::uint32_t client, const Action& action);
    void feel(Client& client, const Action& action, const Outcome& outcome);
    void measure_force();
    void tell_eyes();
    void relax();
    void measure_updates(int sweeps, double each_ms, double passed_ms);
    void resample();
    void note(SessionRecord record) noexcept;
    bool log_is_ready() noexcept;
    void write_log();
    void checkpoint();

    void tell_outcomes();
    void refresh_state();
    void refresh_tools();
    void publish(Client& client);
    void add_boxes(Client& client, std::vector<Outgoing>& batch);
    std::shared_ptr<const std::string> shared_box(const Box3i& box, std::uint8_t flags, bool pack,
                                                  OverlayKind kind = OverlayKind::None);
    std::string make_box(const Box3i& box, std::uint8_t flags, bool pack, OverlayKind kind);
    const Checksums* current_checksums();

    void forget_overlays();
    void begin_overlays();
    void set_overlay(Client& client, std::uint32_t id, OverlayKind kind);
    void mark_overlays(std::span<const Box3i> boxes);
    void add_overlay_boxes(Client& client, std::vector<Outgoing>& batch);
    std::string make_overlay_box(const Box3i& box, std::uint8_t flags, bool pack, OverlayKind kind);
    void rest_overlays();
    void forget_rest() noexcept;
    void begin_rest();
    void set_rest(Client& client, std::uint32_t id, bool on);
    bool make_rest(std::span<const Box3i> boxes);
    bool update_rest(std::span<const Box3i> boxes) noexcept;
    void add_rest_boxes(Client& client, std::vector<Outgoing>& batch);
    std::shared_ptr<const std::string> shared_rest_box(const Box3i& nodes, std::uint8_t flags,
                                                       bool pack);
    void look_for(Client& client, std::uint32_t id, const PathMessage& path);
    void tell_paths();
    void give_up_paths(std::uint32_t client);
    void forget_vessel();
    void want_vessel(Client& client, std::uint32_t id, bool on);
    void refresh_vessel();
    void add_vessel(Client& client, std::vector<Outgoing>& batch);

    void take_haptics(Client& client, std::uint32_t id, const HapticsMessage& haptics);
    void take_pose(const Client& client, const HapticPoseMessage& pose);
    void start_haptics(Client& client, std::uint32_t id, const HapticsMessage& haptics);
    void end_haptics(const std::string& why);
    void open_device();
    void take_device();
    void give_up_device(std::uint32_t client, const Outcome& why);
    void push_by_device();
    void feel_device();
    void refresh_haptics();

    void drop_who_is_late();
    void drop(Client& client, int code, const std::string& message);
    void park(Client& client);
    Client* client_of(ConnectionId connection);
    SharedState shared_state() const;

    std::atomic<std::int64_t> m_ticks = 0;
    std::mutex m_mutex;  ///< of the inbox
    std::condition_variable_any m_wake;
    std::vector<Event> m_inbox;

    // The rest belongs to the owner's thread.
    std::vector<Event> m_events;  ///< that were taken from the inbox
    std::size_t m_taken = 0;      ///< how many of them are dealt with
    std::vector<Untold> m_untold;
    std::unique_ptr<Scene> m_scene;
    std::unique_ptr<SessionLog> m_log;
    bool m_is_recorded = true;              ///< whether the session's file has all records
    Clock::time_point m_flush_at{};         ///< when it was last written to
    std::vector<SessionRecord> m_unlogged;  ///< records for which there was no memory yet
    double m_checkpoint_ms = 0;             ///< of work from one to the next
    double m_unsaved_ms = 0;                ///< of work since the last one
    bool m_is_unsaved = false;              ///< whether there was any
    int m_checkpoints = 0;                  ///< of the session
    Clock::duration m_period;
    std::uint64_t m_open_bytes;
    int m_max_spring_nodes = 32;
    Outlet* m_outlet = nullptr;
    std::map<ConnectionId, Newcomer> m_newcomers;
    Clients m_clients;
    std::uint32_t m_last_client;
    std::uint32_t m_step = 0;
    Clock::time_point m_now{};
    bool m_moved = false;      ///< in this step, so that the volume may have changed
    bool m_is_behind = false;  ///< the volume: there was no memory to update it
    bool m_worked = false;
    int m_busy_ticks = 0;       ///< since a force was measured last
    bool m_was_moving = false;  ///< by itself, of a model that knows time
    double m_owed_ms = 0;       ///< that the model is behind
    Clock::time_point m_relaxed_at{};
    double m_window_ms = 0, m_window_sweeps_ms = 0;  ///< for update_hz
    std::vector<Done> m_outcomes;                    ///< of this step
    double m_solve_ms = 0;                           ///< of this step
    std::int64_t m_moved_elements = 0;
    SharedState m_timing;  ///< its timing is of the last step in which something moved
    std::string m_state_text;
    std::uint64_t m_state_version = 0;
    std::vector<ToolPose> m_tools;
    std::string m_tools_frame;
    std::uint64_t m_tools_version = 0;
    std::vector<std::unique_ptr<PathSearch>> m_paths;  ///< that are looked for
    HapticDevices m_haptic_devices;
    std::unique_ptr<HapticSession> m_haptics;  ///< null: there is none
    std::optional<DeviceQuestion> m_wish;      ///< that waits for the one before to be closed
    std::unique_ptr<DeviceOpening> m_opening;  ///< a device that is opened or closed now
    std::string m_haptics_why;                 ///< it has ended
    std::string m_haptics_text;
    std::uint64_t m_haptics_version = 0;
    VesselFrames m_vessel;
    std::vector<SharedBox> m_boxes;             ///< that were encoded in this step
    std::vector<OverlayWish> m_overlay_wishes;  ///< of this step
    DirtyBlocks m_deformed;                     ///< voxels that have not always been at rest
    std::int64_t m_overlay_left = 0;            ///< voxels that overlays may take in this step
    double m_overlay_ms = 0;                    ///< of this step
    Clock::time_point m_overlay_at{};           ///< when one was last wanted
    std::vector<RestWish> m_rest_wishes;        ///< of this step
    std::optional<RestField> m_rest;            ///< while a client wants it
    bool m_rest_is_stale = false;               ///< it has to be made anew
    std::int64_t m_rest_left = 0;               ///< nodes that may be sent in this step
    std::optional<Checksums> m_checksums;
    Clock::time_point m_checksums_at{};
};

}  // namespace pliant::serve
