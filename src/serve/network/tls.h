// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// TLS in front of the server. Each connection of a browser is decrypted by a relay and reaches the
// server as plain bytes through a pair of local sockets, so that HTTP and WebSocket are compiled
// once. Both directions have back-pressure: a relay holds one piece of each.

#pragma once

#include "network/hidden_boost.h"

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <functional>
#include <list>
#include <memory>
#include <string>
#include <vector>

#include <pliant/result.h>

namespace pliant::serve {

class Tls {
  public:
    /// @param certificate  file: the certificate and those that sign it, PEM
    /// @param key  file: its private key, PEM, without a password
    /// @returns an error about certificate or key
    static Result<std::unique_ptr<Tls>> create(const std::string& certificate,
                                               const std::string& key);
    ~Tls();

    /// Names and addresses that the certificate is for, without those with a wildcard.
    const std::vector<std::string>& names() const;

    /// Greets a browser; once that has succeeded, hands over the plain end of its connection.
    void greet(boost::asio::ip::tcp::socket browser,
               std::function<void(boost::asio::ip::tcp::socket plain)> welcome);
    /// Ends all connections.
    void close();

    struct Impl;

  private:
    explicit Tls(std::unique_ptr<Impl> impl);
    std::unique_ptr<Impl> m_impl;
};

}  // namespace pliant::serve
