// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A server for browsers: several people view, push and cut one scene.
//
// @code
//   const TaskArena arena;
//   auto server = Server::start({.file = "/data/scan.nrrd"}, arena);
//   std::puts(server->link().c_str());
//   server->wait();
// @endcode
//
// docs/developers/protocol.md defines the messages.

#pragma once

#include <pliant/core/record.h>
#include <pliant/core/tasks.h>
#include <pliant/own_tissue.h>
#include <pliant/result.h>
#include <pliant/volume.h>

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#pragma GCC visibility push(default)
namespace pliant {

struct ServerSettings {
    std::string file{};    ///< scan, or folder of DICOM slices; empty: the airway phantom
    std::string series{};  ///< DICOM series, for a folder with several
    std::string labels{};  ///< label map that is shown over the scan; empty: none
    /// Table of the labels' names; empty: the label map's own, or one beside it. A session refers
    /// to this file if bodies are made.
    std::string label_names{};
    /// Labels of which bodies are made, that slide on each other and on their surroundings; empty:
    /// of all organs (organ_file_of_labels). None: no bodies.
    std::optional<std::vector<int>> bodies{};
    /// Tissue at first, which clients may change: chainmail, elastic or springs. Empty: the scene's
    /// own, or chainmail. "auto": the scene's own, that of load_state, chainmail if config has its
    /// tables, or elastic if it makes 25 pictures a second on this machine; notes() has the reason,
    /// and a session records the choice. Applies to scans that clients open as well.
    std::string model{};
    /// Settings of ChainMail and the elastic scan, TOML. Its [[label]] tables take the label map,
    /// which then must be on the scan's grid, and the directions. A session refers to these files.
    std::string config{}, directions{};
    /// Mass-spring network that moves the scan, or the organ, instead of its own model
    /// (network_file.h). A session refers to this file.
    std::string network{};
    /// Saved state of the tissue that the scene begins with (.plst); empty: at rest. A session
    /// refers to this file.
    std::string load_state{};
    Vec3i phantom_size{128, 128, 128};
    int port = 0;  ///< 0: a free port
    /// Address of this machine to listen on, such as 0.0.0.0 for all of them. Others than the
    /// loopback's need a certificate, since links are secrets.
    std::string host = "127.0.0.1";
    /// PEM files: the certificate with those that sign it, and its private key. Empty: plain HTTP.
    std::string certificate{}, key{};
    /// URL of the page if a proxy stands in front of the server: https://name[:port][/path].
    /// Requests for this name are answered too, and the links begin with it.
    std::string url{};
    /// Origins whose pages may show this one in a frame: http(s)://name[:port], port * for any, as
    /// for a notebook: http://localhost:*. None: no page may.
    std::vector<std::string> embed_in{};
    /// File of the session: it is continued and recorded there. Its links stay the same. Empty: no
    /// recording.
    std::filesystem::path session{};
    /// File of a session that is watched: clients can't change the scene, but its time. Then file
    /// and session are empty.
    std::filesystem::path replay{};
    int rate_hz = 60;  ///< maximum steps of the scene per second, 1…1000
    /// Interval of checkpoints in seconds of work. They are saved beside the session and bound the
    /// time to reopen it. ≥ 0
    double checkpoint_s = 30;
    /// Size limit of a scan uploaded through the page. With a session it is kept in a folder beside
    /// it.
    std::uint64_t max_upload_bytes = std::uint64_t(8) << 30;
    /// Force-feedback devices that the page offers beside simulated ones, in the syntax of
    /// open_haptic_device (haptics.h).
    std::vector<std::string> haptic_devices{};
    /// Limit of a client's control nodes along an axis in the springs model, 3…64. The time of a
    /// push grows with the third power, and all clients wait for it.
    int max_spring_nodes = 32;
    /// Updates of the volume per second that an automatic depth of the springs' forces leaves to
    /// each client: a slow line lowers it. 0…1000; 0: lines have no effect.
    int network_hz = 25;
    /// Tissue of one's own, served instead of ChainMail: called for each scan that is opened, on
    /// any thread. Clients may switch to the other models and back ("own"). They drive its catheter
    /// if it has one (drivable.h).
    MakeTissue own_tissue{};
    /// Reading of the scan (ReadOptions, volume.h).
    std::optional<std::int64_t> frame{};
    bool straighten = false;
    std::optional<Vec3d> spacing_mm{};
    /// Of the meshes' files: "mm", "cm" or "m"; empty: mm, or the scene's own.
    std::string units{};
};
SettingRows<ServerSettings> server_rows() noexcept;

/// Thread safety: one thread, but stop() may be called on any.
class Server {
  public:
    /// Loads the scan, replays the session if there is one, and listens. Keeps a reference: the
    /// arena must outlive it.
    /// @returns an error about the scan, the session, host, port, certificate, key or url
    static Result<Server> start(const ServerSettings& settings, const TaskArena& arena) noexcept;
    /// Stops the server.
    ~Server();
    Server(Server&&) noexcept;
    Server& operator=(Server&&) noexcept;

    int port() const;
    std::string link() const;       ///< grants permission to change the scene
    std::string view_link() const;  ///< grants permission to view
    /// One line each about the loaded scan and a session's dropped remainder.
    const std::vector<std::string>& notes() const;
    /// Number of ticks so far, idle ones included: up to rate_hz per second while clients are
    /// connected.
    std::int64_t ticks() const;
    /// Waits for stop().
    void wait();
    /// Stops the server. Thread-safe.
    void stop();

  private:
    struct Impl;
    explicit Server(std::unique_ptr<Impl> impl);
    static Result<Server> begin(const ServerSettings& settings, const TaskArena& arena);
    std::unique_ptr<Impl> m_impl;
};

}  // namespace pliant
#pragma GCC visibility pop
