// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// HTTP and WebSocket on one port.
//
// One thread serves all connections. It is independent of the scene: it authenticates requests,
// reads messages within their limits, passes on well-formed ones, and writes the owner's batches.
// Connections that break a rule are closed here, before the scene's owner sees their messages.

#pragma once

#include <pliant/core/tasks.h>
#include <pliant/result.h>

#include <memory>
#include <string>

#include "hub/client.h"
#include "hub/hub.h"
#include "network/door.h"
#include "network/tls.h"
#include "network/upload.h"

namespace pliant::serve {

struct TransferSettings {
    UploadSettings uploads;
    const TaskArena& arena;                          ///< arena of opened scenes
    std::shared_ptr<const MakeTissue> own_tissue{};  ///< tissue of opened scenes; null: the model
    std::string model{};                             ///< of opened scans, as SceneSource::model
    bool may_open = true;                            ///< false: a session is watched
};

/// Where the server listens, and the names under which browsers reach it.
struct Address {
    std::string host = "127.0.0.1";       ///< an address of this machine
    int port = 0;                         ///< 0: a free port
    std::unique_ptr<Tls> tls{};           ///< null: plain HTTP
    std::string url{};                    ///< of the page, if a proxy stands in front of the server
    std::vector<std::string> embed_in{};  ///< origins whose pages may show it in a frame
};

class Network final : public Outlet {
  public:
    /// Keeps references: hub and arena must outlive it.
    /// @returns an error about host, port or url
    static Result<std::unique_ptr<Network>> listen(Address address, Tokens tokens, Hub& hub,
                                                   TransferSettings transfers);
    ~Network() override;

    int port() const;
    /// The page, for browsers on the network if they can reach it; ends in a slash.
    const std::string& url() const;
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
