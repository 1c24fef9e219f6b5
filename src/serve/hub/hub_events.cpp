// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Events of other threads: connections, messages, files. Of files, the owner only copies the
// changed state, or swaps a pointer; other threads read and write.

#include <new>
#include <utility>

#include "base/errors.h"
#include "hub/hub.h"
#include "protocol/limits.h"
#include "session/checkpoint.h"
#include "session/guarded.h"

namespace pliant::serve {

// An event that throws for lack of memory is processed again in the next step.

void Hub::take_events() {
    std::list<Event>& events = m_inbox.take();
    for (; !events.empty(); events.pop_front()) {
        const ConnectionId connection = events.front().connection;
        std::visit([&](auto& body) { take(connection, body); }, events.front().body);
    }
}

void Hub::take(ConnectionId connection, Event::Opened& opened) {
    m_roster.add_newcomer(connection, opened.may_control, m_now);
}

void Hub::take(ConnectionId connection, Event::Written&) {
    if (Client* client = m_roster.client_of(connection)) client->writing = false;
}

void Hub::take(ConnectionId connection, Event::Closed&) {
    m_roster.remove_newcomer(connection);
    if (Client* client = m_roster.client_of(connection)) park(*client);
}

void Hub::take(ConnectionId connection, Message& message) {
    process(connection, [&](Client* client) {
        const auto* hello = std::get_if<HelloMessage>(&message.action);
        if (client && !hello)
            handle(*client, message);
        else if (client)
            drop(*client, kCloseProtocol, "hello: sent twice");
        else if (hello)
            admit(connection, *hello);
        else
            turn_away(connection, kCloseProtocol, "expected hello first, found something else");
    });
}

void Hub::take(ConnectionId connection, ParseFailure& failure) {
    process(connection, [&](Client* client) {
        if (client)
            send(*client, outcome_text(failure.id, failure.name, 0,
                                       {.error_code = "out_of_range", .message = failure.message}));
        else
            turn_away(connection, kCloseProtocol, failure.message);
    });
}

/// Processes a message of a client, or of a newcomer. If memory runs out, the client is dropped; a
/// newcomer is turned away because it has waited too long.
template <class Process>
void Hub::process(ConnectionId connection, const Process& work) {
    m_outlet->taken(connection);
    Client* client = m_roster.client_of(connection);
    if (client ? client->is_lost : !m_roster.has_newcomer(connection)) return;
    if (guarded("owner", [&] { work(client); })) return;
    client = m_roster.client_of(connection);
    if (client) client->lose();
}

void Hub::turn_away(ConnectionId connection, int code, const std::string& message) {
    m_outlet->close(connection, code, message);
    m_roster.remove_newcomer(connection);
}

void Hub::admit(ConnectionId connection, const HelloMessage& hello) {
    if (hello.protocol != kProtocolVersion)
        return turn_away(connection, kCloseProtocol,
                         "hello: protocol: expected " + std::to_string(kProtocolVersion) +
                             ", found " + std::to_string(hello.protocol));
    Client* client = m_roster.returning(hello.resume);
    if (!m_roster.has_seat() && (!client || !client->connection))
        return turn_away(connection, kCloseFull, "expected up to 32 clients, found more");
    if (!client)
        client = &m_roster.add(m_scene->info().grid.size);
    else if (client->connection)
        drop(*client, kCloseReplaced, "the same client came in on another connection");
    m_roster.connect(*client, connection, hello);
    if (client->delivery.size() != m_scene->info().grid.size)  // it was lost as the scan was opened
        client->delivery = Delivery(m_scene->info().grid.size);
    const bool resumed = client->delivery.come_back(hello.step);
    client->coarse_is_due = !resumed;
    send(*client, welcome_text({.client = client->info,
                                .resume = client->resume,
                                .resumed = resumed,
                                .rate_hz = int(std::chrono::seconds(1) / m_period),
                                .open_bytes = m_open_bytes,
                                .spring_nodes = m_max_spring_nodes,
                                .haptic_devices = m_feeds.device.devices().names(),
                                .is_watched = m_feeds.playback.is_on()},
                               m_scene->info(), shared_state()));
}

void Hub::handle(Client& client, Message& message) {
    const auto* seen = std::get_if<SeenMessage>(&message.action);
    if (seen && seen->format == kFormatVoxels) {
        client.delivery.seen(seen->step);
        client.line.seen(seen->step, m_now);
        if (seen->step >= client.scene_step) client.scene_step = 0;
    } else if (const auto* tool = std::get_if<ToolMessage>(&message.action)) {
        ToolPose pose = client.tool;
        pose.client = client.info.number;
        pose.kind = tool->pose.kind;
        pose.position_mm = tool->pose.position_mm;
        pose.direction = tool->pose.direction;
        pose.up = tool->pose.up;
        pose.radius_mm = tool->pose.radius_mm;
        client.tool = pose;
    } else if (std::holds_alternative<PingMessage>(message.action)) {
        send(client, pong_text(message.id));
    } else if (std::holds_alternative<ChecksumMessage>(message.action)) {
        if (client.checksums.size() < kMaxWaiting)
            client.checksums.push_back(message.id);
        else
            send(client, outcome_text(message.id, "checksum", 0, {.error_code = "busy"}));
    } else if (is_command(message.action)) {
        queue(client, message);
    } else if (m_feeds.playback.is_on() && std::holds_alternative<HapticsMessage>(message.action)) {
        refuse(client, message.id, "haptics", "watched",
               "expected a live scene, found a session that is watched");
    } else {
        for (Feed* feed : m_feeds)
            if (feed->take(client, message)) return;
    }
}

void Hub::queue(Client& client, Message& message) {
    const auto refuse = [&](const char* code, const char* why) {
        this->refuse(client, message.id, name_of(message.action), code, why);
    };
    if (m_feeds.playback.is_on())
        return refuse("watched", "expected a live scene, found a session that is watched");
    if (client.info.view) return refuse("view_only", "expected the role control, found view");
    if (client.scene_step)
        return refuse("other_scan", "another scan was opened; expected to see it first");
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
        return refuse("busy", "expected up to 64 commands that wait, found more");
    client.commands.push_back({std::move(message), {}});
}

// Files.

/// Another scan may have been opened while the map was read.
void Hub::take(ConnectionId, Event::Labelling& labelling) {
    const bool fits = !labelling.map || labelling.map->grid == m_scene->info().grid;
    if (fits) m_feeds.labels.show(labelling.map);
    m_worked = true;
    labelling.done(fits);
}

void Hub::take(ConnectionId, Event::Saving& saving) {
    if (m_is_near) update_volume(true);
    saving.ready(attempt([&]() -> Result<FileWriter> {
        if (saving.kind == SaveKind::State) return save_state_later(*m_scene);
        if (saving.kind != SaveKind::Session) return save_later(saving.kind, *m_scene);
        auto part = m_recorder.part();
        if (!part.ok()) return part.error();
        return save_session_later(std::move(*part), *m_scene);
    }));
}

/// Begins once memory is available and all earlier commands are recorded.
void Hub::take(ConnectionId, Event::Restoring& restoring) {
    if (!m_recorder.has_room()) throw std::bad_alloc();
    const auto checksum = checksum_of(restoring.file);
    const Status loaded = checksum.ok() ? m_scene->load_state(restoring.file) : checksum.error();
    if (loaded.ok()) {
        m_recorder.note(SessionState{std::move(restoring.recorded), *checksum});
        change_tissue();
        note_lost_steps();
        m_moved = true;
    }
    m_worked = true;
    restoring.done(loaded);
}

/// Begins once memory is available and all earlier commands are recorded.
void Hub::take(ConnectionId, Event::Opening& opening) {
    if (!m_recorder.has_room()) throw std::bad_alloc();
    DirtyBlocks deformed(opening.scene.scene->info().grid.size);
    opening.scene.scene->set_volume_id(m_scene->info().id + 1);
    for (Feed* feed : m_feeds) feed->leave_scene();
    std::swap(m_scene, opening.scene.scene);
    {
        const std::lock_guard lock(m_grid_mutex);
        m_grid = m_scene->info().grid;
    }
    m_deformed = std::move(deformed);
    m_changes.forget();
    m_recorder.note(SessionOpen{std::move(opening.scene.recorded)});
    ++m_step;
    m_timing = {};
    m_pace.forget();
    m_recorder.forget_work();
    m_publisher.enter_scene();
    m_worked = true;
    for (Feed* feed : m_feeds) feed->enter_scene();
    for (Client& client : clients())
        if (!guarded("owner", [&] { begin_anew(client); })) client.lose();
    m_is_near = false;
    m_is_behind = !guarded("owner", [&] {
        const auto update = m_scene->update();
        if (!update) throw std::bad_alloc();
        for (const Box3i& box : update->boxes) m_deformed.mark(box);
    });
    guarded("owner", [&] { opening.done(std::move(opening.scene.scene)); });
}

/// Resets a client's state for a new scan.
void Hub::begin_anew(Client& client) {
    client.delivery = Delivery(m_scene->info().grid.size);
    client.line = {};
    client.traffic = {};
    client.delivery.mark_all();
    client.coarse_is_due = true;
    client.tool = {};
    client.eye = {};
    client.tools_version = 0;
    if (!client.connection) return;
    send(client, volume_text(m_scene->info()));
    for (const Waiting& waiting : std::exchange(client.commands, {})) {
        const auto refuse = [&](std::uint32_t id) {
            this->refuse(client, id, name_of(waiting.message.action), "other_scan",
                         "another scan was opened meanwhile");
        };
        for (const std::uint32_t id : waiting.merged) refuse(id);
        refuse(waiting.message.id);
    }
    client.scene_step = m_step;
}

// Clients.

void Hub::send(Client& client, std::string text) {
    if (!client.connection) return;
    client.texts.push_back({true, std::make_shared<const std::string>(std::move(text))});
    if (client.texts.size() > kMaxTexts)
        drop(client, kCloseStalled, "expected a client that reads its answers, found 1000 waiting");
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
    client.answers.clear();
    client.checksums.clear();
    client.tool = {};
    for (Feed* feed : m_feeds) guarded("owner", [&] { feed->leave(client); });
    release(client);
}

/// An absent client holds no tissue.
void Hub::release(Client& client) {
    if (m_feeds.playback.is_on()) return;
    if (m_scene->has_contact(client.info.number)) act(client.info.number, ReleaseCommand{});
    if (m_scene->has_eye(client.info.number)) act(client.info.number, EyeCommand{});
    client.eye = {};
}

void Hub::drop_late_clients() {
    while (const auto late = m_roster.late_newcomer(m_now))
        turn_away(*late, kCloseProtocol, "expected hello within 5 s, found none");
    for (Client& client : clients()) {
        if (!client.connection) {
            release(client);  // memory may have been lacking before
            continue;
        }
        auto unseen = client.delivery.unseen_since();
        for (const Feed* feed : m_feeds)
            if (!unseen) unseen = feed->unseen_since(client);
        if (client.is_lost)
            drop(client, kCloseStalled, "out of memory");
        else if (client.writing && m_now - client.since > kStallTime)
            drop(client, kCloseStalled, "expected a client that reads, found none for 15 s");
        else if (unseen && m_now - *unseen > kStallTime)
            drop(client, kCloseStalled, "expected seen within 15 s, found none");
    }
    m_roster.remove_absent(m_now);
}

}  // namespace pliant::serve
