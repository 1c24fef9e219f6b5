// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "serve/hub.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <random>
#include <thread>

#include "scene/spring_tissue.h"
#include "serve/checkpoint.h"
#include "serve/limits.h"

namespace pliant::serve {
namespace {

std::string random_text() {
    std::random_device device;
    std::string text;
    for (int n = 0; n < 4; ++n) text += hex_text(device(), 8);
    return text;
}

double ms_between(Clock::time_point from, Clock::time_point to) {
    return std::chrono::duration<double, std::milli>(to - from).count();
}

/// What cuts a name to so many bytes leaves no half of a character.
std::string shortened(std::string name) {
    constexpr std::size_t kLongest = 80;
    if (name.size() <= kLongest) return name;
    std::size_t end = kLongest;
    while (end > 0 && (std::uint8_t(name[end]) & 0xc0) == 0x80) --end;
    return name.substr(0, end);
}

}  // namespace

Hub::Hub(std::unique_ptr<Scene> scene, std::unique_ptr<SessionLog> log, int rate_hz,
         std::uint64_t open_bytes)
    : m_scene(std::move(scene)),
      m_log(std::move(log)),
      m_period(std::chrono::nanoseconds(1'000'000'000 / rate_hz)),
      m_open_bytes(open_bytes),
      m_last_client(m_scene->last_client()) {
    // Those who had hold of tissue when a recorded session ended are gone.
    for (std::uint32_t client = 1; client <= m_last_client; ++client)
        if (m_scene->has_contact(client)) act(client, ReleaseCommand{});
    forget_overlays();
    mark_overlays(m_scene->update().boxes);
    m_tools_frame = tools_frame({}, {.volume = m_scene->info().id});
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
        step();
        ++m_ticks;
        // Steps in which nothing was done don't hold up the next command.
        if (m_worked) last = m_now;
    }
    for (Client& client : m_clients)
        if (client.connection) outlet.close(client.connection, kCloseGoingAway, "the server ends");
    if (m_log && !m_log->is_nameless())
        m_log->add(SessionMark{hash_volume(m_scene->deformed()), m_scene->tissue().hash()});
    write_log();
}

void Hub::wait_for_work(const std::stop_token& stop, Clock::time_point last) {
    constexpr auto kIdle = std::chrono::milliseconds(500);
    const bool busy = !m_clients.empty() || !m_newcomers.empty() || m_scene->wants_sweep() ||
                      m_haptics || m_opening;
    const auto now = Clock::now();
    const auto due = last + m_period;
    {
        std::unique_lock lock(m_mutex);
        m_wake.wait_until(lock, stop, busy ? std::max(due, m_now + m_period) : now + kIdle,
                          [&] { return !m_inbox.empty(); });
    }
    if (!stop.stop_requested()) std::this_thread::sleep_until(due);
}

void Hub::step() {
    m_moved = false;
    m_solve_ms = 0;
    m_moved_elements = 0;
    m_boxes.clear();
    take_events();
    carry_out_commands();
    push_by_device();
    relax();
    resample();
    feel_device();
    begin_overlays();
    checkpoint();
    write_log();
    tell_outcomes();
    tell_paths();
    refresh_state();
    refresh_tools();
    refresh_haptics();
    refresh_vessel();
    drop_who_is_late();
    m_overlay_left = kMaxOverlayVoxels;
    m_overlay_ms = 0;
    for (Client& client : m_clients) publish(client);
    rest_overlays();
    measure_force();
}

// Events.

void Hub::take_events() {
    std::vector<Event> events;
    {
        const std::lock_guard lock(m_mutex);
        events.swap(m_inbox);
    }
    for (Event& event : events)
        std::visit([&](auto& what) { take(event.connection, std::move(what)); }, event.what);
}

Client* Hub::client_of(ConnectionId connection) {
    for (Client& client : m_clients)
        if (client.connection == connection) return &client;
    return nullptr;
}

void Hub::take(ConnectionId connection, Opened opened) {
    m_newcomers[connection] = {opened.may_control, m_now};
}

void Hub::take(ConnectionId connection, Message message) {
    m_outlet->taken(connection);
    Client* client = client_of(connection);
    const auto* hello = std::get_if<HelloMessage>(&message.action);
    if (client && !hello)
        answer(*client, std::move(message));
    else if (client)
        drop(*client, kCloseProtocol, "hello: expected once, found again");
    else if (m_newcomers.contains(connection) && hello)
        say_hello(connection, *hello);
    else if (m_newcomers.erase(connection))
        m_outlet->close(connection, kCloseProtocol, "expected hello first, found something else");
}

void Hub::take(ConnectionId connection, ParseFailure failure) {
    m_outlet->taken(connection);
    Client* client = client_of(connection);
    if (client) {
        say(*client, outcome_text(failure.id, failure.name, 0,
                                  {.error_code = "out_of_range", .message = failure.message}));
    } else if (m_newcomers.erase(connection)) {
        m_outlet->close(connection, kCloseProtocol, failure.message);
    }
}

void Hub::take(ConnectionId connection, Written) {
    if (Client* client = client_of(connection)) client->writing = false;
}

void Hub::take(ConnectionId connection, Closed) {
    m_newcomers.erase(connection);
    if (Client* client = client_of(connection)) park(*client);
}

void Hub::say_hello(ConnectionId connection, const HelloMessage& hello) {
    const bool may_control = m_newcomers.extract(connection).mapped().may_control;
    if (hello.protocol != kProtocolVersion)
        return m_outlet->close(connection, kCloseProtocol,
                               "hello: protocol: expected " + std::to_string(kProtocolVersion) +
                                   ", found " + std::to_string(hello.protocol));
    auto found = std::find_if(m_clients.begin(), m_clients.end(), [&](const Client& client) {
        return !hello.resume.empty() && client.resume == hello.resume;
    });
    const bool is_new = found == m_clients.end();
    const auto connected = std::count_if(m_clients.begin(), m_clients.end(),
                                         [](const Client& c) { return c.connection != 0; });
    if (connected >= kMaxClients && (is_new || found->connection == 0))
        return m_outlet->close(connection, kCloseFull, "expected up to 32 clients, found more");
    if (is_new) {
        if (m_clients.size() >= kMaxPlaces) {
            // Those that are away make room, who has been away longest first.
            const auto away = std::min_element(m_clients.begin(), m_clients.end(),
                                               [](const Client& a, const Client& b) {
                                                   return std::pair(a.connection != 0, a.since) <
                                                          std::pair(b.connection != 0, b.since);
                                               });
            m_clients.erase(away);
        }
        found = m_clients.emplace(m_clients.end(), m_scene->info().grid.size);
        found->info.number = ++m_last_client;
        found->resume = random_text();
    } else if (found->connection) {
        drop(*found, kCloseReplaced, "the same client came in on another connection");
    }
    Client& client = *found;
    client.connection = connection;
    client.writing = false;
    client.info.view = hello.view || !may_control;
    if (is_new || !hello.name.empty()) client.info.name = shortened(hello.name);
    client.packs = hello.lz4;
    client.state_version = client.tools_version = client.haptics_version = client.scene_step = 0;
    const bool resumed = client.delivery.come_back(hello.step);
    say(client, welcome_text({.client = client.info,
                              .resume = client.resume,
                              .resumed = resumed,
                              .rate_hz = int(std::chrono::seconds(1) / m_period),
                              .open_bytes = m_open_bytes,
                              .haptic_devices = m_haptic_devices.names()},
                             m_scene->info(), shared_state()));
}

void Hub::say(Client& client, std::string text) {
    if (!client.connection) return;
    client.texts.push_back(std::move(text));
    if (client.texts.size() > kMaxTexts)
        drop(client, kCloseStalled, "expected a client that reads its answers, found 1000 waiting");
}

void Hub::answer(Client& client, Message message) {
    if (const auto* seen = std::get_if<SeenMessage>(&message.action)) {
        if (seen->format == kFormatVoxels) {
            client.delivery.seen(seen->step);
            if (seen->step >= client.scene_step) client.scene_step = 0;
        } else if (client.overlay != OverlayKind::None &&
                   seen->format == format_of(client.overlay)) {
            client.overlay_delivery.seen(seen->step);
        }
    } else if (const auto* tool = std::get_if<ToolMessage>(&message.action)) {
        ToolPose pose = client.tool;
        pose.client = client.info.number;
        pose.kind = tool->pose.kind;
        pose.position_mm = tool->pose.position_mm;
        pose.direction = tool->pose.direction;
        pose.up = tool->pose.up;
        pose.radius_mm = tool->pose.radius_mm;
        client.tool = pose;
    } else if (const auto* overlay = std::get_if<OverlayMessage>(&message.action)) {
        m_overlay_wishes.push_back({client.info.number, message.id, overlay->kind});
    } else if (const auto* vessel = std::get_if<VesselMessage>(&message.action)) {
        want_vessel(client, message.id, vessel->on);
    } else if (std::holds_alternative<PingMessage>(message.action)) {
        say(client, pong_text(message.id));
    } else if (std::holds_alternative<ChecksumMessage>(message.action)) {
        if (client.checksums.size() < kMaxWaiting)
            client.checksums.push_back(message.id);
        else
            say(client, outcome_text(message.id, "checksum", 0, {.error_code = "busy"}));
    } else if (const auto* path = std::get_if<PathMessage>(&message.action)) {
        look_for(client, message.id, *path);
    } else if (const auto* haptics = std::get_if<HapticsMessage>(&message.action)) {
        take_haptics(client, message.id, *haptics);
    } else if (const auto* place = std::get_if<HapticPoseMessage>(&message.action)) {
        take_pose(client, *place);
    } else {
        queue(client, std::move(message));
    }
}

void Hub::queue(Client& client, Message message) {
    const std::string name(name_of(message.action));
    const auto refuse = [&](const char* code, const std::string& why) {
        say(client, outcome_text(message.id, name, 0, {.error_code = code, .message = why}));
    };
    if (client.info.view)
        return refuse("view_only", name + ": expected the role control, found view");
    if (client.scene_step)
        return refuse("other_scan", name + ": another scan was opened; expected to see it first");
    if (auto* iso = std::get_if<IsoCommand>(&message.action)) {
        if (m_now - client.iso_at > std::chrono::seconds(1)) ++client.iso_stroke;
        client.iso_at = m_now;
        iso->stroke = client.iso_stroke;
    }
    const bool is_drag = std::holds_alternative<DragCommand>(message.action);
    if (is_drag && !client.commands.empty()) {
        Waiting& last = client.commands.back();
        if (std::holds_alternative<DragCommand>(last.message.action) &&
            last.merged.size() < kMaxWaiting) {
            last.merged.push_back(last.message.id);
            last.message = std::move(message);
            return;
        }
    }
    if (client.commands.size() >= kMaxWaiting)
        return refuse("busy", name + ": expected up to 64 commands that wait, found more");
    client.commands.push_back({std::move(message), {}});
}

void Hub::drop(Client& client, int code, const std::string& message) {
    if (!client.connection) return;
    m_outlet->close(client.connection, code, message);
    park(client);
}

void Hub::park(Client& client) {
    client.connection = 0;
    client.writing = false;
    client.since = m_now;
    client.texts.clear();
    client.commands.clear();
    client.checksums.clear();
    client.tool = {};
    client.overlay = OverlayKind::None;
    client.wants_vessel = false;
    give_up_paths(client.info.number);
    if (m_haptics && m_haptics->client() == client.info.number)
        end_haptics("the browser that held the device is gone");
    give_up_device(client.info.number, {});
    if (m_scene->has_contact(client.info.number)) act(client.info.number, ReleaseCommand{});
}

void Hub::drop_who_is_late() {
    std::erase_if(m_newcomers, [&](const auto& newcomer) {
        if (m_now - newcomer.second.since < kHelloTime) return false;
        m_outlet->close(newcomer.first, kCloseProtocol, "expected hello within 5 s, found none");
        return true;
    });
    for (Client& client : m_clients) {
        if (!client.connection) continue;
        auto unseen = client.delivery.unseen_since();
        if (!unseen && client.overlay != OverlayKind::None)
            unseen = client.overlay_delivery.unseen_since();
        if (client.writing && m_now - client.since > kStallTime)
            drop(client, kCloseStalled, "expected a client that reads, found none for 15 s");
        else if (unseen && m_now - *unseen > kStallTime)
            drop(client, kCloseStalled, "expected seen within 15 s, found none");
    }
    m_clients.remove_if([&](const Client& client) {
        return !client.connection && m_now - client.since > kAwayTime;
    });
}

// Work.

void Hub::carry_out_commands() {
    // In turn, so that nobody's commands wait for all of somebody else's.
    if (!m_clients.empty()) m_clients.splice(m_clients.end(), m_clients, m_clients.begin());
    for (bool any = true; any;) {
        any = false;
        for (Client& client : m_clients) {
            if (client.commands.empty()) continue;
            if (m_worked && Clock::now() - m_now > kCommandTime) return;
            carry_out(client);
            any = true;
        }
    }
}

void Hub::carry_out(Client& client) {
    Waiting waiting = std::move(client.commands.front());
    client.commands.pop_front();
    const Action& action = waiting.message.action;
    Outcome outcome = act(client.info.number, action);
    feel(client, action, outcome);
    waiting.merged.push_back(waiting.message.id);
    m_outcomes.push_back({client.info.number, std::move(waiting.merged),
                          std::string(name_of(action)), std::move(outcome)});
}

Outcome Hub::act(std::uint32_t client, const Action& action) {
    Outcome outcome = m_scene->carry_out(client, action);
    if (m_log) m_log->add(SessionCommand{client, action, !outcome.ok()});
    m_worked = true;
    m_moved = m_moved || !std::holds_alternative<IsoCommand>(action);
    m_solve_ms += outcome.solve_ms;
    m_moved_elements += outcome.moved_elements.value_or(0);
    return outcome;
}

void Hub::feel(Client& client, const Action& action, const Outcome& outcome) {
    ToolPose& tool = client.tool;
    const bool ends = std::holds_alternative<LetGoCommand>(action) ||
                      std::holds_alternative<ReleaseCommand>(action) ||
                      std::holds_alternative<ResetCommand>(action);
    if (ends) {
        tool.touches = tool.limited = false;
        tool.force = {0, 0, 0};
        tool.fraction = 1;
        return;
    }
    if (outcome.grabbed_elements) tool.touches = *outcome.grabbed_elements > 0;
    if (!outcome.status) return;
    tool.limited = *outcome.status != PushStatus::Applied;
    tool.fraction = float(outcome.step_fraction);
    if (outcome.force)
        tool.force = {float(outcome.force->x), float(outcome.force->y), float(outcome.force->z)};
}

/// When nobody waits for a picture, but not too rarely; tools show it a tick later.
void Hub::measure_force() {
    constexpr int kMostBusyTicks = 4;
    if (m_worked && ++m_busy_ticks < kMostBusyTicks) return;
    m_busy_ticks = 0;
    const auto felt = m_scene->measure_force();
    if (!felt) return;
    const Vec3d f = felt->force;
    for (Client& client : m_clients)
        if (client.info.number == felt->client)
            client.tool.force = {float(f.x), float(f.y), float(f.z)};
}

void Hub::relax() {
    // A model that knows time goes as fast as the clock on the wall, if it can.
    const double each_ms = m_scene->sweep_time_ms();
    const double passed_ms = m_was_moving ? ms_between(m_relaxed_at, m_now) : each_ms;
    m_owed_ms = std::min(m_owed_ms + passed_ms, std::max(each_ms, kMostOwedMs));
    m_relaxed_at = m_now;
    // It gets what it needs for that, commands and pictures or not: fewer pictures rather than
    // tissue in slow motion. One that knows no time takes what commands have left.
    const Clock::time_point begin = each_ms > 0 ? Clock::now() : m_now;
    const std::chrono::milliseconds most = each_ms > 0 ? kMotionTime : kRelaxTime;
    int sweeps = 0;
    while (m_scene->wants_sweep() && (sweeps == 0 || Clock::now() - begin < most)) {
        if (m_owed_ms < each_ms) break;
        m_owed_ms -= each_ms;
        m_solve_ms += m_scene->sweep();
        ++sweeps;
    }
    measure_updates(sweeps, each_ms, passed_ms);
    if (sweeps == 0) return;
    m_worked = m_moved = true;
    if (m_log) m_log->add(SessionSweeps{sweeps});
}

/// The rate of node updates, over half a second of motion at a time.
void Hub::measure_updates(int sweeps, double each_ms, double passed_ms) {
    constexpr double kWindowMs = 500, kUpdatesPerSecond = SpringScanTissue::kRate_hz;
    if (m_was_moving) {
        m_window_ms += passed_ms;
        m_window_sweeps_ms += sweeps * each_ms;
    }
    m_was_moving = each_ms > 0 && m_scene->wants_sweep();
    if (!m_was_moving) m_owed_ms = 0;
    if (m_window_ms < kWindowMs && m_was_moving) return;
    // Short motions tell little.
    if (m_window_ms > kWindowMs / 5) {
        m_timing.pace = m_window_sweeps_ms / m_window_ms;
        m_timing.update_hz = std::round(kUpdatesPerSecond * m_timing.pace);
    }
    m_window_ms = m_window_sweeps_ms = 0;
}

void Hub::resample() {
    if (!m_moved) return;
    m_checksums.reset();  // a cut that nothing opens changes the tissue, and no voxel
    const LiveUpdate update = m_scene->update();
    if (update.boxes.empty()) return;
    ++m_step;
    for (Client& client : m_clients)
        for (const Box3i& box : update.boxes) client.delivery.mark(box);
    mark_overlays(update.boxes);
    if (m_haptics) m_haptics->changed(update.boxes);
    m_timing.solve_ms = m_solve_ms;
    m_timing.resample_ms = update.resample_ms;
    m_timing.tick_ms = ms_between(m_now, Clock::now());
    m_timing.moved_elements = m_moved_elements;
}

void Hub::checkpoint() {
    m_unsaved_ms += m_solve_ms;
    m_is_unsaved = m_is_unsaved || m_worked;
    // At a moment when nobody waits for anything.
    const bool is_due = m_is_unsaved && m_unsaved_ms >= m_checkpoint_ms;
    if (!m_log || m_log_failed || m_log->is_nameless()) return;
    if (!is_due || m_worked || !m_scene->is_quiet()) return;
    m_is_unsaved = false;
    m_unsaved_ms = 0;
    Status saved = Ok{};
    m_log->add(save_checkpoint(*m_scene, m_log->path(), ++m_checkpoints, saved));
    if (!saved.ok())
        std::fprintf(stderr, "pliant: %s; the session goes on without this checkpoint\n",
                     saved.error().message.c_str());
}

void Hub::write_log() {
    if (!m_log || m_log_failed) return;
    if (const Status s = m_log->flush(); !s.ok()) {
        m_log_failed = true;
        std::fprintf(stderr, "pliant: %s; the session is not recorded any more\n",
                     s.error().message.c_str());
    }
}

}  // namespace pliant::serve
