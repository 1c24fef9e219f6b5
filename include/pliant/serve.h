// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A server for browsers: one scene that several people see, push and cut at once.
//
//   const TaskArena arena;
//   auto server = Server::start({.file = "/data/scan.nrrd"}, arena);
//   std::puts(server->link().c_str());
//   server->wait();
//
// docs/protocol.md says what clients and server tell each other.

#pragma once

#include <pliant/result.h>
#include <pliant/tasks.h>
#include <pliant/volume.h>

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#pragma GCC visibility push(default)
namespace pliant {

struct ServerSettings {
    std::string file{};    ///< scan, or folder of DICOM slices; empty: the airway phantom
    std::string series{};  ///< DICOM series, where a folder has several
    Vec3i phantom_size{128, 128, 128};
    int port = 0;  ///< 0: one that is free
    /// File of the session: recorded there; goes on where it ended. Empty: not recorded.
    std::filesystem::path session{};
    int rate_hz = 60;  ///< steps of the scene per second at most, 1…1000
    /// With a session: its state is saved beside it after so many seconds of work, so that opening
    /// it again takes about as long, and not as long as all of it. ≥ 0
    double checkpoint_s = 30;
    /// Of a scan that is opened through the page. With a session it is kept in a folder beside it.
    std::uint64_t max_upload_bytes = std::uint64_t(8) << 30;
    /// Devices with force feedback that the page offers beside those that are simulated, as
    /// open_haptic_device (haptics_servo.h) wants them.
    std::vector<std::string> haptic_devices{};
    /// Control nodes along an axis that a client may ask for with the springs model, 3…64. The time
    /// of a push grows with the third power, and all clients wait for it.
    int max_spring_nodes = 32;
};

class Server {
  public:
    /// Loads the scan, replays the session if there is one, and starts to listen on 127.0.0.1.
    /// Keeps a reference: the arena must outlive it.
    /// @returns what is wrong with the scan, the session or the port
    static Result<Server> start(const ServerSettings& settings, const TaskArena& arena) noexcept;
    /// Stops.
    ~Server();
    Server(Server&&) noexcept;
    Server& operator=(Server&&) noexcept;

    int port() const;
    std::string link() const;       ///< for those who may change the scene
    std::string view_link() const;  ///< for those who may look
    /// One line each: what was loaded, what of a session was cut off.
    const std::vector<std::string>& notes() const;
    /// Steps that the scene's owner has made, also those in which nothing was to be done: rate_hz
    /// each second while clients are connected and there is time.
    std::int64_t ticks() const;
    /// Returns once stop() was called.
    void wait();
    /// From any thread.
    void stop();

  private:
    struct Impl;
    explicit Server(std::unique_ptr<Impl> impl);
    static Result<Server> begin(const ServerSettings& settings, const TaskArena& arena);
    std::unique_ptr<Impl> m_impl;
};

struct ReplayReport {
    std::int64_t commands = 0;
    std::int64_t marks = 0;  ///< places where the state was recorded, all of them met
    std::uint64_t cut_off_bytes = 0;
    int from_checkpoint = 0;        ///< 0: from the start
    std::uint64_t volume_hash = 0;  ///< hash_volume of the deformed volume
    std::uint64_t tissue_hash = 0;  ///< ChainMail::hash
};

/// Does a recorded session again, without a server.
/// @param from_checkpoint  as Server::start would: from the last state but one that was saved, if
///                         it is whole; otherwise all of it, compared at each mark
/// @returns NotFound; Unreadable where the file is damaged, or the result is another than recorded
Result<ReplayReport> replay_session(const std::filesystem::path& path, const TaskArena& arena,
                                    const Progress& progress = {}, bool from_checkpoint = false);

}  // namespace pliant
#pragma GCC visibility pop
