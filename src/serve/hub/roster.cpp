// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "hub/roster.h"

#include <algorithm>
#include <random>
#include <utility>

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

Client* Roster::client_of(ConnectionId connection) {
    for (Client& client : m_clients)
        if (client.connection == connection) return &client;
    return nullptr;
}

std::vector<ClientInfo> Roster::connected() const {
    std::vector<ClientInfo> infos;
    for (const Client& client : m_clients)
        if (client.connection) infos.push_back(client.info);
    std::sort(infos.begin(), infos.end(),
              [](const ClientInfo& a, const ClientInfo& b) { return a.number < b.number; });
    return infos;
}

std::optional<ConnectionId> Roster::late_newcomer(Clock::time_point now) const {
    for (const auto& [connection, newcomer] : m_newcomers)
        if (now - newcomer.since >= kHelloTime) return connection;
    return {};
}

Client* Roster::returning(const std::string& secret) {
    for (Client& client : m_clients)
        if (!secret.empty() && client.resume == secret) return &client;
    return nullptr;
}

bool Roster::has_seat() const {
    return std::count_if(m_clients.begin(), m_clients.end(),
                         [](const Client& client) { return client.connection != 0; }) < kMaxClients;
}

Client& Roster::add(Vec3i volume_size) {
    std::list<Client> added;
    Client& client = added.emplace_back(volume_size);
    client.resume = random_text();
    client.info.number = ++m_last_number;
    if (m_clients.size() >= kMaxSeats)
        m_clients.erase(std::min_element(m_clients.begin(), m_clients.end(),
                                         [](const Client& a, const Client& b) {
                                             return std::pair(a.connection != 0, a.since) <
                                                    std::pair(b.connection != 0, b.since);
                                         }));
    m_clients.splice(m_clients.end(), added);
    return client;
}

void Roster::connect(Client& client, ConnectionId connection, const HelloMessage& hello) {
    const auto newcomer = m_newcomers.find(connection);
    if (client.info.name.empty() || !hello.name.empty()) client.info.name = shortened(hello.name);
    client.info.view = hello.view || !newcomer->second.may_control;
    client.packs = hello.lz4;
    client.wants_coarse = hello.coarse;
    client.writing = client.is_lost = false;
    client.line = {};
    client.traffic = {};
    client.state_version = client.tools_version = client.scene_step = 0;
    client.connection = connection;
    m_newcomers.erase(newcomer);
}

void Roster::remove_absent(Clock::time_point now) {
    m_clients.remove_if(
        [&](const Client& client) { return !client.connection && now - client.since > kAwayTime; });
}

}  // namespace pliant::serve
