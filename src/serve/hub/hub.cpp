// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "hub/hub.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <new>
#include <thread>

#include "hub/depth_for_time.h"
#include "protocol/limits.h"
#include "session/checkpoint.h"
#include "session/replay.h"

namespace pliant::serve {
namespace {

constexpr std::size_t kMaxUnlogged = 16;  ///< records of one step
constexpr std::uint32_t kServer = 0;      ///< number of commands by no client
constexpr std::size_t kMaxUntold = 1024;  ///< refused messages

double ms_between(Clock::time_point from, Clock::time_point to) {
    return std::chrono::duration<double, std::milli>(to - from).count();
}

}  // namespace

Hub::Hub(std::unique_ptr<Scene> scene, std::unique_ptr<SessionLog> log, int rate_hz,
         std::uint64_t open_bytes)
    : m_grid(scene->info().grid),
      m_scene(std::move(scene)),
      m_log(std::move(log)),
      m_period(std::chrono::nanoseconds(1'000'000'000 / rate_hz)),
      m_open_bytes(open_bytes),
      m_last_client(m_scene->last_client()),
      m_deformed(m_scene->info().grid.size) {
    m_unlogged.reserve(kMaxUnlogged);
    m_untold.reserve(kMaxUntold);
    // Clients that held tissue at the end of a recorded session are gone.
    for (std::uint32_t client = 1; client <= m_last_client; ++client) {
        if (m_scene->has_contact(client)) act(client, ReleaseCommand{});
        if (m_scene->has_eye(client)) act(client, EyeCommand{});
    }
    const auto update = m_scene->update();
    m_is_behind = !update;
    if (update)
        for (const Box3i& box : update->boxes) m_deformed.mark(box);
    m_tools_frame = tools_frame({}, {.volume = m_scene->info().id});
}

void Hub::watch(SessionFile session, const TaskArena& arena) {
    m_playback.load(std::move(session), arena);
    // Numbers of clients are different from the session's.
    m_last_client = std::max(m_last_client, m_playback.last_client());
}

void Hub::keep_checkpoints(double seconds, int so_far) {
    m_checkpoint_ms = 1000 * seconds;
    m_checkpoints = so_far;
}

void Hub::post(Event event) {
    {
        const std::lock_guard lock(m_mutex);
        m_inbox.push_back(std::move(event));
    }
    m_wake.notify_one();
}
void Hub::opened(ConnectionId connection, bool may_control) {
    post({connection, Opened{may_control}});
}
void Hub::received(ConnectionId connection, Message message) {
    post({connection, std::move(message)});
}
void Hub::refused(ConnectionId connection, ParseFailure failure) {
    post({connection, std::move(failure)});
}
void Hub::written(ConnectionId connection) {
    post({connection, Written{}});
}
void Hub::closed(ConnectionId connection) {
    post({connection, Closed{}});
}

void Hub::run(const std::stop_token& stop, Outlet& outlet) {
    m_outlet = &outlet;
    Clock::time_point last{};
    while (!stop.stop_requested()) {
        wait_for_work(stop, last);
        m_now = Clock::now();
        m_worked = false;
        make_step();
        ++m_ticks;
        // Idle steps don't delay the next command.
        if (m_worked) last = m_now;
    }
    for (Client& client : m_clients)
        if (client.connection)
            guarded("owner",
                    [&] { outlet.close(client.connection, kCloseGoingAway, "the server ends"); });
    guarded("owner", [&] {
        if (m_log && !m_log->is_nameless() && !m_is_behind && log_is_ready())
            m_log->add(SessionMark{hash_volume(m_scene->deformed()), m_scene->tissue().hash()});
    });
    guarded("owner", [&] { write_log(); });
}

void Hub::wait_for_work(const std::stop_token& stop, Clock::time_point last) {
    constexpr auto kIdle = std::chrono::milliseconds(500);
    const bool busy =
        !m_clients.empty() || !m_newcomers.empty() || m_scene->wants_sweep() || m_device.is_busy();
    const auto now = Clock::now();
    const auto due = last + m_period;
    {
        std::unique_lock lock(m_mutex);
        m_wake.wait_until(lock, stop, busy ? std::max(due, m_now + m_period) : now + kIdle,
                          [&] { return !m_inbox.empty(); });
    }
    if (!stop.stop_requested()) std::this_thread::sleep_until(due);
}

void Hub::make_step() {
    m_moved = false;
    m_solve_ms = 0;
    m_moved_elements = 0;
    m_frames.clear();
    for (const auto part :
         {&Hub::take_events, &Hub::carry_out_commands, &Hub::act_by_feeds, &Hub::tell_eyes,
          &Hub::relax, &Hub::resample, &Hub::refresh_feeds, &Hub::checkpoint, &Hub::write_log,
          &Hub::tell_outcomes, &Hub::refresh_state, &Hub::refresh_tools, &Hub::drop_who_is_late})
        guarded("owner", [&] { (this->*part)(); });
    for (Client& client : m_clients)
        if (!guarded("owner", [&] { publish(client); })) {
            // Boxes taken from it may not have been sent.
            client.delivery.come_back({});
            for (Feed* feed : m_feeds) feed->lost(client);
        }
    guarded("owner", [&] { release_sources(); });
    guarded("owner", [&] { measure_force(); });
}

void Hub::act_by_feeds() {
    for (Feed* feed : m_feeds) guarded("owner", [&] { feed->act(); });
}

void Hub::refresh_feeds() {
    for (Feed* feed : m_feeds) guarded("owner", [&] { feed->refresh(); });
}

bool Hub::keep_sources() {
    if (!m_scene->keep_sources(true)) return false;
    m_sources_at = m_now;
    return true;
}

/// Stops the computation of sources a while after their last use.
void Hub::release_sources() {
    if (m_scene->live().keeps_sources() && m_now - m_sources_at > kSourcesTime)
        m_scene->keep_sources(false);
}

// Work.

/// The client with the least recent computing time goes first, so that quick commands don't wait
/// for another client's slow ones.
void Hub::carry_out_commands() {
    constexpr double kShareKept = 0.9;  // per step
    for (Client& client : m_clients) client.spent_ms *= kShareKept;
    while (!m_worked || Clock::now() - m_now <= kCommandTime) {
        Client* next = nullptr;
        for (Client& client : m_clients)
            if (!client.commands.empty() && (!next || client.spent_ms < next->spent_ms))
                next = &client;
        if (!next) return;
        const Clock::time_point begin = Clock::now();
        carry_out(*next);
        next->spent_ms += ms_between(begin, Clock::now());
    }
}

void Hub::carry_out(Client& client) {
    // The answer needs memory too. Without it the command waits for the next step.
    Waiting& front = client.commands.front();
    front.merged.reserve(front.merged.size() + 1);
    Done done{client.info.number, {}, std::string(name_of(front.message.action)), {}};
    m_outcomes.reserve(m_outcomes.size() + 1);
    Waiting waiting = std::move(front);
    client.commands.pop_front();
    const Action& action = waiting.message.action;
    done.outcome = act(client.info.number, action);
    feel(client, action, done.outcome);
    waiting.merged.push_back(waiting.message.id);
    done.ids = std::move(waiting.merged);
    m_outcomes.push_back(std::move(done));
}

/// Carries out a command and records it. If memory runs out, the scene is unchanged, except that
/// the open step may have ended, which is recorded.
Outcome Hub::act(std::uint32_t client, const Action& action) {
    const Outcome ran_out{.error_code = "limit", .message = "out of memory", .ran_out = true};
    if (m_log && m_log->is_full())
        return {.error_code = "limit",
                .message =
                    "expected a session that can be recorded, found the disk of the server "
                    "full"};
    if (!log_is_ready()) return ran_out;
    if (const auto* tissue = std::get_if<TissueCommand>(&action);
        tissue && tissue->choice.is_springs() && tissue->choice.nodes > m_max_spring_nodes)
        return {.error_code = "limit",
                .message = "tissue: nodes: expected 3…" + std::to_string(m_max_spring_nodes) +
                           " on this server, found " + std::to_string(tissue->choice.nodes)};
    SessionCommand record{.client = client, .action = {}, .refused = false};
    try {
        record.action = action;
    } catch (const std::bad_alloc&) {
        return ran_out;
    }
    Outcome outcome = play(client, action);
    record.refused = !outcome.ok();
    if (!outcome.ran_out)
        note(std::move(record));
    else if (outcome.ended_step)
        note(SessionBreak{client});
    if (m_scene->take_lost()) note(SessionLost{m_scene->steps()});
    return outcome;
}

/// Carries out a command.
Outcome Hub::play(std::uint32_t client, const Action& action) {
    Outcome outcome = m_scene->carry_out(client, action);
    m_worked = true;
    const bool moves_nothing =
        std::holds_alternative<IsoCommand>(action) || std::holds_alternative<EyeCommand>(action);
    m_moved = m_moved || !moves_nothing;
    if (std::holds_alternative<TissueCommand>(action)) change_tissue();
    m_solve_ms += outcome.solve_ms;
    m_moved_elements += outcome.moved_elements.value_or(0);
    return outcome;
}

/// Follows a change of the scene's tissue object.
void Hub::change_tissue() {
    for (Client& client : m_clients) client.eye = {};  // a new tissue has no eyes
    for (Feed* feed : m_feeds) feed->change_tissue();
}

Status Hub::play_state(const SessionState& state) {
    if (const Status s = load_recorded(*m_scene, state); !s.ok()) return s;
    change_tissue();
    m_worked = m_moved = true;
    return Ok{};
}

Status Hub::play_sweeps(int count) {
    for (int n = 0; n < count; ++n) {
        const Result<double> took_ms = m_scene->sweep();
        if (!took_ms.ok()) return took_ms.error();
        m_solve_ms += *took_ms;
    }
    m_worked = m_moved = true;
    return Ok{};
}

std::unique_ptr<Scene> Hub::exchange(std::unique_ptr<Scene> scene) {
    scene->set_volume_id(m_scene->info().id);
    m_exchanged = m_deformed;
    if (m_scene->live().keeps_sources()) (void)scene->keep_sources(true);
    std::swap(m_scene, scene);
    for (Feed* feed : m_feeds) feed->change_tissue();
    m_worked = m_moved = true;
    return scene;
}

void Hub::feel(Client& client, const Action& action, const Outcome& outcome) {
    ToolPose& tool = client.tool;
    const bool ends = std::holds_alternative<LetGoCommand>(action) ||
                      std::holds_alternative<ReleaseCommand>(action) ||
                      std::holds_alternative<ResetCommand>(action);
    if (ends) {
        tool.touches = tool.limited = false;
        tool.force_n = tool.energy_per_mm = {0, 0, 0};
        tool.fraction = 1;
        return;
    }
    if (outcome.grabbed_elements) tool.touches = *outcome.grabbed_elements > 0;
    if (!outcome.status) return;
    tool.limited = *outcome.status != PushStatus::Applied;
    tool.fraction = float(outcome.step_fraction);
    if (const auto& f = outcome.force_n) tool.force_n = {float(f->x), float(f->y), float(f->z)};
}

/// Measures while no picture is due, but at a minimum rate; tools show the force a tick later.
void Hub::measure_force() {
    constexpr int kMaxBusyTicks = 4;
    if (m_worked && ++m_busy_ticks < kMaxBusyTicks) return;
    const bool has_worked = m_busy_ticks > 0;
    m_busy_ticks = 0;
    // The force of a tool that holds tissue changes as long as that moves.
    for (Client& client : m_clients)
        if (has_worked && client.connection)
            if (const auto f = m_scene->tissue().force_n(client.info.number))
                client.tool.force_n = {float(f->x), float(f->y), float(f->z)};
    const auto felt = m_scene->measure_force();
    if (!felt) return;
    const Vec3d e = felt->energy_per_mm;
    for (Client& client : m_clients)
        if (client.info.number == felt->client)
            client.tool.energy_per_mm = {float(e.x), float(e.y), float(e.z)};
}

/// Makes endoscopes of clients in role control obstacles of the relaxation. The scene gets their
/// positions by commands, which a session records, only while it relaxes, and only where tissue at
/// rest would close over an endoscope.
void Hub::tell_eyes() {
    if (m_playback.is_on()) return;  // the session has them
    if (!m_scene->is_relaxing() || !m_scene->tissue().traits().closes_at_rest) return;
    for (Client& client : m_clients) {
        const ToolPose& tool = client.tool;
        EyeCommand eye;
        if (client.connection && !client.info.view && tool.kind == ToolKind::Endoscope)
            eye = {{tool.position_mm.x, tool.position_mm.y, tool.position_mm.z}, tool.radius_mm};
        if (eye.radius_mm == 0 || !m_scene->may_close_over(eye.position_mm, eye.radius_mm))
            eye = {};
        if (eye == client.eye) continue;
        if (act(client.info.number, eye).ok()) client.eye = eye;
    }
}

void Hub::relax() {
    if (m_playback.is_on()) return;
    // A model with simulated time runs in real time, if it can.
    const double each_ms = m_scene->sweep_time_ms();
    const double passed_ms = m_was_moving ? ms_between(m_relaxed_at, m_now) : each_ms;
    m_owed_ms = std::min(m_owed_ms + passed_ms, std::max(each_ms, kMaxOwedMs));
    m_relaxed_at = m_now;
    // It gets the time for that before commands and pictures: fewer pictures are better than
    // tissue in slow motion. A model without time uses the time left by the commands.
    const Clock::time_point begin = each_ms > 0 ? Clock::now() : m_now;
    const std::chrono::milliseconds most = each_ms > 0 ? kMotionTime : kRelaxTime;
    int sweeps = 0;
    double sweeps_took_ms = 0;
    while (m_scene->wants_sweep() && log_is_ready() &&
           (sweeps == 0 || Clock::now() - begin < most)) {
        if (m_owed_ms < each_ms) break;
        m_owed_ms -= each_ms;
        const Result<double> took_ms = m_scene->sweep();
        if (!took_ms.ok()) break;
        m_solve_ms += *took_ms;
        sweeps_took_ms += *took_ms;
        ++sweeps;
    }
    measure_updates(sweeps, each_ms, passed_ms, sweeps_took_ms);
    if (sweeps == 0) return;
    m_worked = m_moved = true;
    note(SessionSweeps{sweeps});
    if (m_scene->take_lost()) note(SessionLost{m_scene->steps()});
}

/// Measures the rate of node updates, over half a second of motion.
void Hub::measure_updates(int sweeps, double each_ms, double passed_ms, double took_ms) {
    constexpr double kWindowMs = 500;
    if (m_was_moving) {
        m_window_ms += passed_ms;
        m_window_sweeps_ms += sweeps * each_ms;
        m_window_took_ms += took_ms;
    }
    m_was_moving = each_ms > 0 && m_scene->wants_sweep();
    if (!m_was_moving) m_owed_ms = 0;
    if (m_window_ms < kWindowMs && m_was_moving) return;
    // Short motions are not representative.
    if (m_window_ms > kWindowMs / 5) {
        m_timing.pace = m_window_sweeps_ms / m_window_ms;
        m_timing.update_hz = std::round(m_scene->tissue().traits().update_hz * m_timing.pace);
        adapt_depth();
    }
    m_window_ms = m_window_sweeps_ms = m_window_took_ms = 0;
}

/// Lowers or raises the depth of forces by the last half second of motion, if the clients want it:
/// to the smaller one of those that the time and the slowest line allow. The commands are recorded,
/// so that a session can be done again.
void Hub::adapt_depth() {
    const TissueChoice& choice = m_scene->choice();
    const int depth = choice.springs.depth;
    m_timing.line_mb_s = 0;
    if (!choice.depth_by_time) {
        for (Client& client : m_clients) {
            (void)client.line.take(depth, m_now);
            client.traffic.release();
        }
        return;
    }
    if (m_window_sweeps_ms <= 0) return;
    const int timely = depth_for_time(depth, m_timing.pace, m_window_took_ms / m_window_sweeps_ms);
    const int layers = std::min(timely, depth_for_lines(depth));
    if (layers != depth) act(kServer, DepthCommand{.layers = layers, .by_time = true});
}

/// Depth that the lines to all clients take.
int Hub::depth_for_lines(int depth) {
    int layers = Traffic::kNoLimit;
    if (m_network_hz == 0) return layers;
    for (Client& client : m_clients) {
        if (!client.connection) continue;
        if (const auto sample = client.line.take(depth, m_now))
            client.traffic.take(*sample, m_network_hz);
        const int limit = std::max(client.traffic.limit(), kFewestLayers);
        if (limit >= layers) continue;
        layers = limit;
        // Two digits: a new value is sent to all clients.
        const double mb_s = client.traffic.bytes_per_s() / 1e6;
        const double digit = std::pow(10, std::floor(std::log10(mb_s)) - 1);
        m_timing.line_mb_s = std::round(mb_s / digit) * digit;
    }
    return std::max(layers, std::min(depth, kFewestLayers));
}

void Hub::resample() {
    if (!m_moved && !m_is_behind) return;
    m_checksums.reset();  // a closed cut changes the tissue, but no voxel
    // Voxels of a failed update may have been sent.
    if (m_is_behind) m_changes.forget();
    m_is_behind = true;
    const Result<LiveUpdate> update = m_scene->update();
    if (!update) return;
    std::vector<Box3i> boxes(update->boxes.begin(), update->boxes.end());
    for (const Box3i& box : boxes) m_deformed.mark(box);
    const auto exchanged = m_exchanged.take(std::numeric_limits<std::int64_t>::max());
    boxes.insert(boxes.end(), exchanged.begin(), exchanged.end());
    bool all_follow = true;
    for (Feed* feed : m_feeds) {
        bool follows = false;
        guarded("owner", [&] { follows = feed->follow(boxes); });
        all_follow = all_follow && follows;
    }
    m_is_behind = !all_follow;
    if (boxes.empty()) return;
    mark_changes(boxes);
    m_timing.solve_ms = m_solve_ms;
    m_timing.resample_ms = update->resample_ms;
    m_timing.tick_ms = ms_between(m_now, Clock::now());
    m_timing.moved_elements = m_moved_elements;
}

/// Marks the blocks of voxels for all clients that have other values; if there are none, a block as
/// it was, so that the clients follow each step.
void Hub::mark_changes(std::span<const Box3i> boxes) {
    const auto mark = [&](std::span<const Box3i> some) {
        for (Client& client : m_clients)
            for (const Box3i& box : some) client.delivery.mark(box);
    };
    ++m_step;
    try {
        const std::span<const Box3i> changed =
            m_changes.find(m_scene->deformed(), boxes, m_scene->tissue().arena());
        if (!changed.empty()) return mark(changed);
        const Vec3i first = boxes.front().begin;
        const Box3i voxel[] = {{first, first + Vec3i{1, 1, 1}}};
        mark(voxel);
    } catch (const std::bad_alloc&) {
        m_changes.forget();
        mark(boxes);
    }
}

void Hub::checkpoint() {
    m_unsaved_ms += m_solve_ms;
    m_is_unsaved = m_is_unsaved || m_worked;
    // Save while no work is waiting.
    const bool is_due = m_is_unsaved && m_unsaved_ms >= m_checkpoint_ms;
    if (!m_log || !m_is_recorded || m_log->is_nameless()) return;
    if (!is_due || m_worked || m_is_behind || !m_scene->is_quiet() || !log_is_ready()) return;
    m_is_unsaved = false;
    m_unsaved_ms = 0;
    Status saved = Ok{};
    for (Client& client : m_clients) client.eye = {};  // a resting scene has no eyes
    auto point = save_checkpoint(*m_scene, m_log->path(), m_checkpoints + 1, saved);
    if (!point.ok()) {
        m_scene->interrupt(0);
        note(SessionBreak{});
        return;
    }
    ++m_checkpoints;
    note(std::move(*point));
    if (!saved.ok())
        std::fprintf(stderr, "pliant: %s; the session goes on without this checkpoint\n",
                     saved.error().message.c_str());
}

/// Adds a record. Without memory it is added later: see log_is_ready().
void Hub::note(SessionRecord record) noexcept {
    if (!m_log) return;
    if (log_is_ready()) {
        try {
            note_time();
            return m_log->add(record);
        } catch (const std::bad_alloc&) {
        }
    }
    m_unlogged.push_back(std::move(record));  // reserved: no work while records wait
}

/// Records the time that has passed, for a later replay in the page.
void Hub::note_time() {
    if (m_noted_at == Clock::time_point{}) m_noted_at = m_now;
    const auto passed = std::chrono::duration_cast<std::chrono::milliseconds>(m_now - m_noted_at);
    if (passed < kSessionTick) return;
    m_log->add(SessionWait{int(std::min<std::int64_t>(passed.count(), kMaxWait_ms))});
    m_noted_at += passed;
}

/// Whether all changes of the scene are recorded, at least in memory. If not, no command may be
/// carried out.
bool Hub::log_is_ready() noexcept {
    if (m_log && m_log->is_full()) return false;
    while (!m_unlogged.empty()) {
        try {
            m_log->add(m_unlogged.front());
        } catch (const std::bad_alloc&) {
            return false;
        }
        m_unlogged.erase(m_unlogged.begin());
    }
    return true;
}

/// Writes the session. On failure its records stay in memory, clients are informed, and the write
/// is retried each second.
void Hub::write_log() {
    constexpr auto kPause = std::chrono::seconds(1);
    if (!m_log) return;
    (void)log_is_ready();
    const bool is_due = m_now - m_flush_at >= kPause;
    if (!m_is_recorded && !is_due) return;
    Status s = m_log->flush();
    if (s.ok() && is_due) s = m_log->check_place();
    if (is_due) m_flush_at = m_now;
    if (s.ok() == m_is_recorded) return;
    m_is_recorded = s.ok();
    if (s.ok())
        std::fprintf(stderr, "pliant: %s: the session is recorded again\n", m_log->path().c_str());
    else
        std::fprintf(stderr, "pliant: %s; the session is not recorded meanwhile\n",
                     s.error().message.c_str());
}

}  // namespace pliant::serve
