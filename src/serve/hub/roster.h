// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Owns the list of clients: the connected ones, those that may come back, and connections that
// haven't said hello yet.

#pragma once

#include <cstdint>
#include <list>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "hub/client.h"

namespace pliant::serve {

class Roster {
  public:
    /// @param last_number  of a client, so far
    explicit Roster(std::uint32_t last_number) : m_last_number(last_number) {}

    /// All clients, absent ones included.
    std::list<Client>& clients() { return m_clients; }
    bool is_empty() const { return m_clients.empty() && m_newcomers.empty(); }
    /// Highest number of a client or a device's tool so far.
    std::uint32_t& last_number() { return m_last_number; }
    /// @returns null if none has this connection
    Client* client_of(ConnectionId connection);
    /// Descriptions of the connected clients, by number.
    std::vector<ClientInfo> connected() const;

    // Newcomers: connections before their hello.
    void add_newcomer(ConnectionId connection, bool may_control, Clock::time_point now) {
        m_newcomers[connection] = {may_control, now};
    }
    bool has_newcomer(ConnectionId connection) const { return m_newcomers.contains(connection); }
    void remove_newcomer(ConnectionId connection) { m_newcomers.erase(connection); }
    /// A newcomer that has waited too long.
    std::optional<ConnectionId> late_newcomer(Clock::time_point now) const;

    /// The client that comes back with its secret; null: none.
    Client* returning(const std::string& secret);
    /// Whether another client can be connected.
    bool has_seat() const;
    /// Adds a client with a number and a secret. If there are too many, the one with the longest
    /// absence is removed. @pre has_seat()
    Client& add(Vec3i volume_size);
    /// Connects a client. @pre has_newcomer(connection)
    void connect(Client& client, ConnectionId connection, const HelloMessage& hello);
    /// Removes clients that haven't come back.
    void remove_absent(Clock::time_point now);

  private:
    struct Newcomer {
        bool may_control;
        Clock::time_point since;
    };
    std::map<ConnectionId, Newcomer> m_newcomers;
    std::list<Client> m_clients;
    std::uint32_t m_last_number;
};

}  // namespace pliant::serve
