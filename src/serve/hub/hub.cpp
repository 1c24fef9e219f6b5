// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The step: its parts stand in the order in which make_step() calls them.

#include "hub/hub.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <new>
#include <thread>

#include "base/stopwatch.h"
#include "protocol/limits.h"
#include "session/guarded.h"
#include "session/near_elements.h"
#include "session/replay.h"

namespace pliant::serve {
namespace {

constexpr std::uint32_t kServer = 0;  ///< number of commands by no client

/// Shows the outcome of a command at its tool.
void update_tool(ToolPose& tool, const Action& action, const Outcome& outcome) {
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

}  // namespace

Hub::Hub(std::unique_ptr<Scene> scene, std::unique_ptr<SessionLog> log, int rate_hz,
         std::uint64_t open_bytes)
    : m_grid(scene->info().grid),
      m_scene(std::move(scene)),
      m_recorder(std::move(log)),
      m_roster(m_scene->last_client()),
      m_period(std::chrono::nanoseconds(1'000'000'000 / rate_hz)),
      m_open_bytes(open_bytes),
      m_deformed(m_scene->info().grid.size) {
    // Clients that held tissue at the end of a recorded session are gone.
    for (std::uint32_t client = 1; client <= last_client(); ++client) {
        if (m_scene->has_contact(client)) act(client, ReleaseCommand{});
        if (m_scene->has_eye(client)) act(client, EyeCommand{});
    }
    const auto update = m_scene->update();
    m_is_behind = !update;
    if (update)
        for (const Box3i& box : update->boxes) m_deformed.mark(box);
}

void Hub::watch(SessionFile session, const TaskArena& arena) {
    m_feeds.playback.load(std::move(session), arena);
    // Numbers of clients are different from the session's.
    last_client() = std::max(last_client(), m_feeds.playback.last_client());
}

void Hub::run(const std::stop_token& stop, Outlet& outlet) {
    m_outlet = &outlet;
    Clock::time_point last{};
    while (!stop.stop_requested()) {
        wait_for_work(stop, last);
        m_now = Clock::now();
        make_step();
        ++m_ticks;
        // Idle steps don't delay the next command.
        if (m_worked) last = m_now;
    }
    end();
}

void Hub::end() {
    for (Client& client : clients())
        if (client.connection)
            guarded("owner", [&] {
                m_outlet->close(client.connection, kCloseGoingAway, "the server ends");
            });
    guarded("owner", [&] {
        if (m_is_near) update_volume(true);
        if (m_recorder.has_file() && !m_is_behind && m_recorder.has_room())
            m_recorder.note(
                SessionMark{hash_volume(m_scene->deformed()), m_scene->tissue().hash()});
    });
    m_recorder.write();
}

void Hub::wait_for_work(const std::stop_token& stop, Clock::time_point last) {
    constexpr auto kIdle = std::chrono::milliseconds(500);
    const bool busy =
        !m_roster.is_empty() || m_is_near || m_scene->wants_sweep() || m_feeds.device.is_busy();
    const auto due = last + m_period;
    m_inbox.wait_until(busy ? std::max(due, m_now + m_period) : Clock::now() + kIdle, stop);
    if (!stop.stop_requested()) std::this_thread::sleep_until(due);
}

void Hub::make_step() {
    m_worked = m_moved = false;
    m_solve_ms = 0;
    m_moved_elements = 0;
    m_recorder.start_step(m_now);
    m_publisher.start_step();
    const auto each = [&](auto... parts) { (guarded("owner", [&] { (this->*parts)(); }), ...); };
    each(&Hub::take_events, &Hub::carry_out_commands);
    for (Feed* feed : m_feeds) guarded("owner", [&] { feed->act(); });
    each(&Hub::place_eyes, &Hub::relax, &Hub::resample);
    for (Feed* feed : m_feeds) guarded("owner", [&] { feed->refresh(); });
    each(&Hub::save_checkpoint);
    m_recorder.write();
    each(&Hub::send_answers, &Hub::refresh_state, &Hub::refresh_tools, &Hub::drop_late_clients);
    for (Client& client : clients()) publish(client);
    each(&Hub::release_sources, &Hub::measure_force);
}

// Commands.

/// The client with the least recent computing time goes first, so that quick commands don't wait
/// for another client's slow ones.
void Hub::carry_out_commands() {
    constexpr double kShareKept = 0.9;  // per step
    for (Client& client : clients()) client.spent_ms *= kShareKept;
    while (!m_worked || Clock::now() - m_now <= kCommandTime) {
        Client* next = nullptr;
        for (Client& client : clients())
            if (!client.commands.empty() && (!next || client.spent_ms < next->spent_ms))
                next = &client;
        if (!next) return;
        const Stopwatch watch;
        if (!guarded("owner", [&] { carry_out(*next); })) next->lose();
        next->spent_ms += watch.ms();
    }
}

void Hub::carry_out(Client& client) {
    const Waiting waiting = std::move(client.commands.front());
    client.commands.pop_front();
    const Action& action = waiting.message.action;
    Answer answer{waiting.merged, name_of(action), {}};
    answer.ids.push_back(waiting.message.id);
    if (!guarded("owner", [&] { answer.outcome = act(client.info.number, action); }))
        answer.outcome = {.error_code = "limit",
                          .message = std::string(answer.name) + ": out of memory"};
    update_tool(client.tool, action, answer.outcome);
    client.answers.push_back(std::move(answer));
}

Outcome Hub::act(std::uint32_t client, const Action& action) {
    if (m_recorder.is_full())
        return {.error_code = "limit",
                .message =
                    "expected a session that can be recorded, found the disk of the server "
                    "full"};
    if (const auto* tissue = std::get_if<TissueCommand>(&action);
        tissue && tissue->choice.is_springs() && tissue->choice.nodes > m_max_spring_nodes)
        return {.error_code = "limit",
                .message = "tissue: nodes: expected 3…" + std::to_string(m_max_spring_nodes) +
                           " on this server, found " + std::to_string(tissue->choice.nodes)};
    SessionCommand record{.client = client, .action = action, .refused = false};
    if (!m_recorder.has_room()) throw std::bad_alloc();
    Outcome outcome;
    try {
        outcome = play(client, action);
    } catch (const std::bad_alloc&) {
        m_recorder.note(SessionBreak{client});
        note_lost_steps();
        throw;
    }
    record.refused = !outcome.ok();
    m_recorder.note(std::move(record));
    note_lost_steps();
    return outcome;
}

Outcome Hub::play(std::uint32_t client, const Action& action) {
    m_worked = true;
    const bool moves_nothing =
        std::holds_alternative<IsoCommand>(action) || std::holds_alternative<EyeCommand>(action);
    m_moved = m_moved || !moves_nothing;
    Outcome outcome = m_scene->carry_out(client, action);
    if (std::holds_alternative<TissueCommand>(action)) change_tissue();
    m_solve_ms += outcome.solve_ms;
    m_moved_elements += outcome.moved_elements.value_or(0);
    return outcome;
}

void Hub::note_lost_steps() {
    if (m_scene->take_lost()) m_recorder.note(SessionLost{m_scene->steps()});
}

/// Follows a change of the scene's tissue object.
void Hub::change_tissue() noexcept {
    for (Client& client : clients()) client.eye = {};  // a new tissue has no eyes
    for (Feed* feed : m_feeds) feed->change_tissue();
}

Status Hub::play_state(const SessionState& state) {
    if (const Status s = load_recorded(*m_scene, state); !s.ok()) return s;
    change_tissue();
    m_worked = m_moved = true;
    return Ok{};
}

Status Hub::play_sweeps(const SessionSweeps& sweeps) {
    const Result<double> took_ms = sweep_recorded(*m_scene, sweeps);
    if (!took_ms.ok()) return took_ms.error();
    m_solve_ms += *took_ms;
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

// Motion.

/// Makes endoscopes of clients in role control obstacles of the relaxation. The scene gets their
/// positions by commands, which a session records, only while it relaxes, and only where tissue at
/// rest would close over an endoscope.
void Hub::place_eyes() {
    if (m_feeds.playback.is_on()) return;  // the session has them
    if (!m_scene->is_relaxing() || !m_scene->tissue().traits().closes_at_rest) return;
    for (Client& client : clients()) {
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
    if (m_feeds.playback.is_on()) return;
    std::stop_source command = m_inbox.stop_at_command();
    const auto waits = [](const Client& client) { return !client.commands.empty(); };
    if (std::any_of(clients().begin(), clients().end(), waits)) command.request_stop();
    const SweepPace::Sweeps sweeps = m_pace.relax(*m_scene, m_recorder, m_now, command.get_token());
    for (const SessionSweeps& made : sweeps.made) {
        if (made.count == 0 && !made.parts) continue;
        m_worked = m_moved = true;
        m_recorder.note(made);
    }
    m_solve_ms += sweeps.solve_ms;
    if (m_worked) note_lost_steps();
    if (!sweeps.ends_window) return;
    // Recorded like the command of a client, so that a session can be done again.
    const auto layers = m_pace.allowed_depth(*m_scene, clients(), m_now);
    if (layers && *layers != m_scene->choice().springs.depth)
        act(kServer, DepthCommand{.layers = *layers, .by_time = true});
}

void Hub::resample() {
    if (!m_moved && !m_is_behind && !m_is_near) return;
    const auto wants_checksum = [](const Client& client) { return !client.checksums.empty(); };
    update_volume(std::any_of(clients().begin(), clients().end(), wants_checksum));
}

/// @param exactly  else as near to the tissue's state as there is time for
void Hub::update_volume(bool exactly) {
    m_publisher.tissue_changed();  // a closed cut changes the tissue, but no voxel
    // Voxels of a failed update may have been sent.
    if (m_is_behind) m_changes.forget();
    m_is_behind = true;
    const Result<LiveUpdate> update =
        exactly ? m_scene->update() : m_scene->approach(m_near_elements);
    if (!update) return;
    m_is_near = !update->is_complete;
    m_near_elements = near_elements(m_near_elements, *update);
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
    m_worked = true;
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
        for (Client& client : clients())
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

/// Saves a checkpoint while no work is waiting.
void Hub::save_checkpoint() {
    m_recorder.count_work(m_solve_ms, m_worked);
    if (m_worked || m_is_behind || m_is_near || !m_recorder.wants_checkpoint() ||
        !m_scene->is_quiet())
        return;
    if (!m_recorder.has_room()) return;
    for (Client& client : clients()) client.eye = {};  // a resting scene has no eyes
    m_recorder.save_checkpoint(*m_scene);
}

// Publishing.

void Hub::send_answers() {
    for (Client& client : clients()) {
        const std::vector<Answer> answers = std::exchange(client.answers, {});
        const bool is_sent = guarded("owner", [&] {
            for (const Answer& answer : answers)
                for (const std::uint32_t id : answer.ids)
                    send(client,
                         outcome_text(id, std::string(answer.name), m_step, answer.outcome));
        });
        if (!is_sent) client.lose();
    }
}

SharedState Hub::shared_state() {
    SharedState state = m_timing;
    m_scene->describe(state);
    m_pace.describe(state);
    state.overlay_ms = m_feeds.overlays.last_ms();
    state.step = m_step;
    state.recorded = m_feeds.playback.is_on() || m_recorder.is_recorded();
    state.clients = m_roster.connected();
    return state;
}

void Hub::refresh_state() {
    m_publisher.set_state(shared_state());
}

void Hub::refresh_tools() {
    std::vector<ToolPose> tools;
    for (const Client& client : clients())
        if (client.connection && client.tool.kind != ToolKind::None) tools.push_back(client.tool);
    if (const auto tool = m_feeds.device.tool()) tools.push_back(*tool);
    for (const auto& [number, tool] : m_feeds.playback.tools()) tools.push_back(tool);
    m_publisher.set_tools(std::move(tools));
}

void Hub::publish(Client& client) {
    if (!client.connection || client.is_lost) return;
    if (!guarded("owner", [&] { m_publisher.publish(client, m_feeds.all, m_recorder, *m_outlet); }))
        client.lose();
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

/// Measures while no picture is due, but at a minimum rate; tools show the force a tick later.
void Hub::measure_force() {
    constexpr int kMaxBusyTicks = 4;
    if (m_worked && ++m_busy_ticks < kMaxBusyTicks) return;
    const bool has_worked = m_busy_ticks > 0;
    m_busy_ticks = 0;
    // The force of a tool that holds tissue changes as long as that moves.
    for (Client& client : clients())
        if (has_worked && client.connection)
            if (const auto f = m_scene->tissue().force_n(client.info.number))
                client.tool.force_n = {float(f->x), float(f->y), float(f->z)};
    const auto felt = m_scene->measure_force();
    if (!felt) return;
    const Vec3d e = felt->energy_per_mm;
    for (Client& client : clients())
        if (client.info.number == felt->client)
            client.tool.energy_per_mm = {float(e.x), float(e.y), float(e.z)};
}

}  // namespace pliant::serve
