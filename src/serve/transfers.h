// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Files in and out over HTTP (docs/protocol.md, "Saving" and "Opening"): one of each at a time.
//
//   network's thread ── pieces ──► a thread for the disk ── a scene ──► hub
//                    ◄── pieces ──                        ◄── a copy ──
//
// The disk may be slow and scans take long to read, so neither is the network's thread's work nor
// the owner's. One piece is under way at a time: a client that doesn't read or send holds up nobody
// but itself, and is dropped when it is slower than kTransferBytesPerSecond.

#pragma once

#include <pliant/tasks.h>

#include "serve/hidden_boost.h"

#include <boost/asio/io_context.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <memory>
#include <string_view>

#include "serve/network.h"

namespace pliant::serve {

using BodyParser = boost::beast::http::request_parser<boost::beast::http::buffer_body>;

/// A request whose header was read, with all that belongs to it.
struct Guest {
    boost::beast::tcp_stream stream;
    boost::beast::flat_buffer buffer;
    std::unique_ptr<BodyParser> parser;
    int port;
};

class Transfers {
  public:
    /// Keeps references. Everything but the constructor and the destructor is called on the
    /// context's thread.
    Transfers(boost::asio::io_context& context, Hub& hub, const Tokens& tokens,
              TransferSettings settings);
    /// Waits for what is being read or written.
    ~Transfers();

    static bool takes(std::string_view path);
    void begin(Guest guest);

    struct Desk;

  private:
    std::unique_ptr<Desk> m_desk;
};

}  // namespace pliant::serve
