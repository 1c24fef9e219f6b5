// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Who may come in: what a request must say before anything is done for it.

#pragma once

#include <chrono>
#include <optional>
#include <string>
#include <string_view>

#include "serve/limits.h"

namespace pliant::serve {

/// A request's target, without and with its query.
std::string_view path_of(std::string_view target);
/// @returns the query's value as it stands; empty if there is none
std::string_view query_value(std::string_view target, std::string_view key);

/// With %20 and the like as they are meant, and + as a blank. @returns nothing where that is wrong
std::optional<std::string> decoded(std::string_view query_value);

/// Whether a Host names this machine and this port, however a browser may write that. A page of
/// another site whose name leads here (DNS rebinding) says its own name.
bool is_own_host(std::string_view host, int port);
/// Whether an Origin is a page of this server.
bool is_own_origin(std::string_view origin, int port);
/// In a time that says nothing about where they differ.
bool is_same_secret(std::string_view a, std::string_view b);

/// How much a connection may still say: refilled as time goes by.
class Allowance {
  public:
    explicit Allowance(std::chrono::steady_clock::time_point now) : m_at(now) {}
    /// @returns whether this message is within the limits
    bool take(std::size_t bytes, std::chrono::steady_clock::time_point now);

  private:
    double m_messages = kMessageBurst, m_bytes = kByteBurst;
    std::chrono::steady_clock::time_point m_at;
};

}  // namespace pliant::serve
