// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Events from clients: connections, messages, and timeouts.

#include <algorithm>
#include <random>
#include <utility>

#include "hub/hub.h"
#include "protocol/limits.h"

namespace pliant::serve {
namespace {

std::string random_text() {
    std::random_device device;
    std::string text;
    for (int n = 0; n < 4; ++n) text += hex_text(device(), 8);
    return text;
}

/// Truncates a name at a character boundary (UTF-8).
std::string shortened(std::string name) {
    constexpr std::size_t kLongest = 80;
    if (name.size() <= kLongest) return name;
    std::size_t end = kLongest;
    while (end > 0 && (std::uint8_t(name[end]) & 0xc0) == 0x80) --end;
    return name.substr(0, end);
}

}  // namespace

/// Takes events. Those without memory wait for the next step; messages are refused instead.
void Hub::take_events() {
    if (m_taken == m_events.size()) {
        m_events.clear();
        m_taken = 0;
        const std::lock_guard lock(m_mutex);
        m_events.swap(m_inbox);
    }
    for (; m_taken < m_events.size(); ++m_taken) {
        Event& event = m_events[m_taken];
        const auto* message = std::get_if<Message>(&event.what);
        if (!message) {
            std::visit([&](auto& what) { take(event.connection, what); }, event.what);
            continue;
        }
        const std::uint32_t id = message->id;
        const std::string_view name = name_of(message->action);
        if (!guarded("owner", [&] { take(event.connection, std::get<Message>(event.what)); }))
            tell_later(event.connection, id, name);
    }
}

/// Notes that a message was refused for lack of memory.
void Hub::tell_later(ConnectionId connection, std::uint32_t id, std::string_view name) noexcept {
    if (m_untold.size() < m_untold.capacity()) m_untold.push_back({connection, id, name});
}

Client* Hub::client_of(ConnectionId connection) {
    for (Client& client : m_clients)
        if (client.connection == connection) return &client;
    return nullptr;
}

void Hub::take(ConnectionId connection, Opened& opened) {
    m_newcomers[connection] = {opened.may_control, m_now};
}

void Hub::take(ConnectionId connection, Message& message) {
    m_outlet->taken(connection);
    Client* client = client_of(connection);
    const auto* hello = std::get_if<HelloMessage>(&message.action);
    if (client && !hello)
        answer(*client, std::move(message));
    else if (client)
        drop(*client, kCloseProtocol, "hello: sent twice");
    else if (m_newcomers.contains(connection) && hello)
        say_hello(connection, *hello);
    else if (m_newcomers.erase(connection))
        m_outlet->close(connection, kCloseProtocol, "expected hello first, found something else");
}

void Hub::take(ConnectionId connection, ParseFailure& failure) {
    m_outlet->taken(connection);
    Client* client = client_of(connection);
    if (client) {
        say(*client, outcome_text(failure.id, failure.name, 0,
                                  {.error_code = "out_of_range", .message = failure.message}));
    } else if (m_newcomers.erase(connection)) {
        m_outlet->close(connection, kCloseProtocol, failure.message);
    }
}

void Hub::take(ConnectionId connection, Written&) {
    if (Client* client = client_of(connection)) client->writing = false;
}

void Hub::take(ConnectionId connection, Closed&) {
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
            // Absent clients are evicted, those with the longest absence first.
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
    client.line = {};
    client.traffic = {};
    client.info.view = hello.view || !may_control;
    if (is_new || !hello.name.empty()) client.info.name = shortened(hello.name);
    client.packs = hello.lz4;
    client.wants_coarse = hello.coarse;
    client.state_version = client.tools_version = client.scene_step = 0;
    const bool resumed = client.delivery.come_back(hello.step);
    client.coarse_is_due = !resumed;
    say(client, welcome_text({.client = client.info,
                              .resume = client.resume,
                              .resumed = resumed,
                              .rate_hz = int(std::chrono::seconds(1) / m_period),
                              .open_bytes = m_open_bytes,
                              .spring_nodes = m_max_spring_nodes,
                              .haptic_devices = m_device.devices().names(),
                              .is_watched = m_playback.is_on()},
                             m_scene->info(), shared_state()));
}

void Hub::say(Client& client, std::string text) {
    if (!client.connection) return;
    client.texts.push_back({true, std::make_shared<const std::string>(std::move(text))});
    if (client.texts.size() > kMaxTexts)
        drop(client, kCloseStalled, "expected a client that reads its answers, found 1000 waiting");
}

void Hub::answer(Client& client, Message message) {
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
        say(client, pong_text(message.id));
    } else if (std::holds_alternative<ChecksumMessage>(message.action)) {
        if (client.checksums.size() < kMaxWaiting)
            client.checksums.push_back(message.id);
        else
            say(client, outcome_text(message.id, "checksum", 0, {.error_code = "busy"}));
    } else if (is_command(message.action)) {
        queue(client, std::move(message));
    } else if (m_playback.is_on() && std::holds_alternative<HapticsMessage>(message.action)) {
        say(client, outcome_text(message.id, "haptics", 0,
                                 {.error_code = "watched",
                                  .message = "haptics: expected a live scene, found a session "
                                             "that is watched"}));
    } else {
        for (Feed* feed : m_feeds)
            if (feed->take(client, message)) return;
    }
}

void Hub::queue(Client& client, Message message) {
    const std::string name(name_of(message.action));
    const auto refuse = [&](const char* code, const std::string& why) {
        say(client, outcome_text(message.id, name, 0, {.error_code = code, .message = why}));
    };
    if (m_playback.is_on())
        return refuse("watched", name + ": expected a live scene, found a session that is watched");
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
    for (Feed* feed : m_feeds) feed->leave(client);
    release(client);
}

/// An absent client holds no tissue.
void Hub::release(Client& client) {
    if (m_playback.is_on()) return;
    if (m_scene->has_contact(client.info.number)) act(client.info.number, ReleaseCommand{});
    if (m_scene->has_eye(client.info.number)) act(client.info.number, EyeCommand{});
    client.eye = {};
}

void Hub::drop_who_is_late() {
    std::erase_if(m_newcomers, [&](const auto& newcomer) {
        if (m_now - newcomer.second.since < kHelloTime) return false;
        m_outlet->close(newcomer.first, kCloseProtocol, "expected hello within 5 s, found none");
        return true;
    });
    for (Client& client : m_clients) {
        if (!client.connection) {
            release(client);  // memory may have been lacking before
            continue;
        }
        auto unseen = client.delivery.unseen_since();
        for (const Feed* feed : m_feeds)
            if (!unseen) unseen = feed->unseen_since(client);
        if (client.writing && m_now - client.since > kStallTime)
            drop(client, kCloseStalled, "expected a client that reads, found none for 15 s");
        else if (unseen && m_now - *unseen > kStallTime)
            drop(client, kCloseStalled, "expected seen within 15 s, found none");
    }
    m_clients.remove_if([&](const Client& client) {
        return !client.connection && m_now - client.since > kAwayTime;
    });
}

}  // namespace pliant::serve
