// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// File transfers over HTTP (docs/developers/protocol.md, "Saving" and "Opening"): one in each
// direction at a time.
//
//   network's thread ── pieces ──► a thread for the disk ── a scene ──► hub
//                    ◄── pieces ──                        ◄── a copy ──
//
// Disks may be slow and scans large, so a disk thread does this work, not the network's or the
// owner's thread. One piece is in flight at a time (backpressure): a slow client delays only
// itself, and is dropped below kTransferBytesPerSecond.

#pragma once

#include <pliant/core/tasks.h>

#include "network/hidden_boost.h"

#include <boost/asio/io_context.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <memory>
#include <string_view>

#include "network/door.h"
#include "network/network.h"

namespace pliant::serve {

using BodyParser = boost::beast::http::request_parser<boost::beast::http::buffer_body>;

/// A request with a parsed header, and its connection.
struct Guest {
    boost::beast::tcp_stream stream;
    boost::beast::flat_buffer buffer;
    std::unique_ptr<BodyParser> parser;
    const OwnOrigins& own;  ///< outlives it
};

class Transfers {
  public:
    /// Keeps references. All functions except constructor and destructor run on the context's
    /// thread.
    Transfers(boost::asio::io_context& context, Hub& hub, const Tokens& tokens,
              TransferSettings settings);
    /// Waits for current reads and writes.
    ~Transfers();

    static bool takes(std::string_view path);
    void begin(Guest guest);

    struct Desk;

  private:
    std::unique_ptr<Desk> m_desk;
};

}  // namespace pliant::serve
