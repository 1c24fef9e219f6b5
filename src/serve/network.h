// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// HTTP and WebSocket on one local port.
//
// One thread serves all connections. It is independent of the scene: it authenticates requests,
// reads messages within their limits, passes on well-formed ones, and writes the owner's batches.
// Connections that break a rule are closed here, before the scene's owner sees their messages.

#pragma once

#include <pliant/result.h>
#include <pliant/tasks.h>

#include <memory>
#include <string>

#include "serve/client.h"
#include "serve/hub.h"
#include "serve/upload.h"

namespace pliant::serve {

/// Secrets of the links with control and view permission.
struct Tokens {
    std::string control, view;
};

struct TransferSettings {
    UploadSettings uploads;
    const TaskArena& arena;                          ///< arena of opened scenes
    std::shared_ptr<const MakeTissue> own_tissue{};  ///< tissue of opened scenes; null: ChainMail
};

class Network final : public Outlet {
  public:
    /// Listens on 127.0.0.1. Keeps references: hub and arena must outlive it.
    /// @param port  0: a free port
    static Result<std::unique_ptr<Network>> listen(int port, Tokens tokens, Hub& hub,
                                                   TransferSettings transfers);
    ~Network() override;

    int port() const;
    /// Serves until stop().
    void run();
    /// Thread-safe. Closing handshakes get half a second.
    void stop();

    void send(ConnectionId connection, std::vector<Outgoing> batch) override;
    void close(ConnectionId connection, int code, const std::string& message) override;
    void taken(ConnectionId connection) override;

    struct Impl;

  private:
    explicit Network(std::unique_ptr<Impl> impl);
    std::unique_ptr<Impl> m_impl;
};

}  // namespace pliant::serve
