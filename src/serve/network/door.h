// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Access control: checks of a request before it is processed, and the secrets of a server's links.
// Those of a session are kept beside it, so that links outlive a restart.

#pragma once

#include <pliant/result.h>

#include <chrono>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "protocol/limits.h"

namespace pliant::serve {

/// The path of a request's target, without its query.
std::string_view path_of(std::string_view target);
/// @returns the raw query value; empty if there is none
std::string_view query_value(std::string_view target, std::string_view key);

/// Percent-decodes a query value; '+' is a space. @returns nullopt for malformed input
std::optional<std::string> decoded(std::string_view query_value);

/// Whether a text has only the characters of a host with or without a port, and at least one.
bool is_host(std::string_view text);

/// The origins ("https://host:port") under which browsers reach the server. Guards against DNS
/// rebinding: a page of another site sends its own name.
class OwnOrigins {
  public:
    /// This machine's loopback names. @param scheme  "http" or "https"
    OwnOrigins(std::string_view scheme, int port);

    /// @param host  a name, an IPv4 address, or an IPv6 address in brackets
    void add(std::string_view scheme, std::string_view host, int port);
    /// Adds the origin of a URL. @returns false if it isn't http(s)://host[:port][/path]
    bool add_url(std::string_view url);

    /// Whether a Host header has one of the names, in any spelling of a browser.
    bool has_host(std::string_view host) const;
    /// Whether an Origin header names a page of this server.
    bool has(std::string_view origin) const;
    /// Lets pages of an origin show this server's in a frame. Port '*': any.
    /// @returns false if it isn't http(s)://host[:port]
    bool add_frame(std::string_view origin);
    /// Sources of a content security policy that may show the page in a frame.
    std::string frames() const;
    /// WebSocket sources of a content security policy; some browsers don't count them to 'self'.
    std::string websockets() const;
    /// Whether the server itself speaks TLS.
    bool has_tls() const { return m_has_tls; }

  private:
    bool m_has_tls;
    std::vector<std::string> m_origins;  ///< in lower case, without a scheme's own port
    std::string m_frames;
};
/// Constant-time comparison.
bool is_same_secret(std::string_view a, std::string_view b);

/// Rate limiter of a connection; it refills with time.
class TokenBucket {
  public:
    explicit TokenBucket(std::chrono::steady_clock::time_point now) : m_at(now) {}
    /// @returns whether the message is within the limits
    bool take(std::size_t bytes, std::chrono::steady_clock::time_point now);

  private:
    double m_messages = kMessageBurst, m_bytes = kByteBurst;
    std::chrono::steady_clock::time_point m_at;
};

/// Secrets of the links with control and view permission.
struct Tokens {
    std::string control, view;
};

Tokens random_tokens();

/// Reads the secrets of a session from SESSION.links, or makes the file, for this user only. An
/// empty file is none.
/// @returns Unreadable for a file with other contents, of another user, or that others may read;
///          Unwritable
Result<Tokens> tokens_of_session(const std::filesystem::path& session);

}  // namespace pliant::serve
