// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// HTTP and WebSocket on one port of this machine.
//
// One thread serves all connections. It knows nothing of the scene: it checks who may come in,
// reads messages within their limits, hands over those that are well-formed, and writes what it is
// given. Whoever breaks a rule is dropped here, before the scene's owner hears of it.

#pragma once

#include <pliant/result.h>
#include <pliant/tasks.h>

#include <memory>
#include <string>

#include "serve/client.h"
#include "serve/hub.h"
#include "serve/upload.h"

namespace pliant::serve {

/// For those who may change the scene, and for those who may look.
struct Tokens {
    std::string control, view;
};

struct TransferSettings {
    UploadSettings uploads;
    const TaskArena& arena;  ///< of the scenes that are opened
};

class Network final : public Outlet {
  public:
    /// Listens on 127.0.0.1. Keeps references: hub and arena must outlive it.
    /// @param port  0: one that is free
    static Result<std::unique_ptr<Network>> listen(int port, Tokens tokens, Hub& hub,
                                                   TransferSettings transfers);
    ~Network() override;

    int port() const;
    /// Serves until stop().
    void run();
    /// From any thread: lets what was closed say goodbye, for half a second.
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
