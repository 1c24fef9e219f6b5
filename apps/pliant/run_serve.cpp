// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// pliant serve: runs the server until Ctrl+C.

#include <fcntl.h>
#include <pliant/core/files.h>
#include <pliant/core/output_file.h>
#include <pliant/serve.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <new>
#include <optional>

#include "options.h"
#include "progress.h"
#include "setting_options.h"

extern char** environ;

namespace pliant::app {
namespace fs = std::filesystem;
namespace {

int g_ends[2];
volatile sig_atomic_t g_is_serving = 0;

/// Memory reserve, freed when an allocation fails. The large allocation fails nevertheless, but the
/// small ones after it succeed: nlohmann::json's destructors end the process if they can't
/// allocate.
std::atomic<void*> g_reserve = nullptr;
constexpr std::size_t kReserveBytes = std::size_t(4) << 20;

void refill_reserve() {
    if (g_reserve) return;
    void* memory = std::malloc(kReserveBytes);
    if (memory) std::memset(memory, 1, kReserveBytes);  // makes it resident
    g_reserve = memory;
}

void give_reserve_back() {
    void* const memory = g_reserve.exchange(nullptr);
    if (!memory) throw std::bad_alloc();
    std::free(memory);
}

/// Stops the server cleanly; before it runs, ends the program.
void stop_serving(int number) {
    if (!g_is_serving) return end_process(128 + number);
    const int kept = errno;
    (void)!::write(g_ends[1], "", 1);
    errno = kept;
}

/// Opens the browser if there is a display; otherwise the user has the link. The link contains a
/// secret, and other users can read command lines. So the browser gets a file that only this user
/// can read, which redirects to the link.
class Browser {
  public:
    explicit Browser(const std::string& link) {
        if (!std::getenv("DISPLAY") && !std::getenv("WAYLAND_DISPLAY")) return;
        const char* const runtime = std::getenv("XDG_RUNTIME_DIR");
        std::error_code error;
        const fs::path folder = runtime ? fs::path(runtime) : fs::temp_directory_path(error);
        std::string own = (folder / "pliant-open-XXXXXX").string();
        if (error || !::mkdtemp(own.data())) return;
        m_folder = own;
        const fs::path file = m_folder / "open.html";
        OutputFile page(file);  // in a private folder of this user
        page.write("<!doctype html><meta http-equiv=\"refresh\" content=\"0;url=" + link +
                   "\"><a href=\"" + link + "\">Pliant</a>\n");
        if (!page.close()) return;  // the user has the link
        std::string name = "xdg-open", argument = file.string();
        char* const arguments[] = {name.data(), argument.data(), nullptr};
        posix_spawn_file_actions_t actions;
        posix_spawn_file_actions_init(&actions);
        for (const int descriptor : {0, 1, 2})
            posix_spawn_file_actions_addopen(&actions, descriptor, "/dev/null", O_RDWR, 0);
        if (posix_spawnp(&m_opener, name.c_str(), &actions, nullptr, arguments, environ) != 0)
            m_opener = 0;
        posix_spawn_file_actions_destroy(&actions);
    }
    ~Browser() {
        reap();
        std::error_code ignored;
        if (!m_folder.empty()) fs::remove_all(m_folder, ignored);
    }
    Browser(const Browser&) = delete;
    Browser& operator=(const Browser&) = delete;

    /// Reaps the process that opened the browser.
    void reap() {
        if (m_opener > 0 && ::waitpid(m_opener, nullptr, WNOHANG) != 0) m_opener = 0;
    }

  private:
    fs::path m_folder;
    pid_t m_opener = 0;
};

Result<Server> start(const ServeOptions& options, const TaskArena& arena) {
    ServerSettings settings{.file = options.file,
                            .series = options.scan.series,
                            .labels = options.labels,
                            .label_names = options.label_names,
                            .bodies = options.bodies,
                            .model = options.model,
                            .config = options.config,
                            .directions = options.directions,
                            .network = options.network,
                            .load_state = options.load_state,
                            .port = options.port,
                            .host = options.host,
                            .certificate = options.certificate,
                            .key = options.key,
                            .url = options.url,
                            .embed_in = options.embed_in,
                            .session = options.session,
                            .replay = options.replay,
                            .checkpoint_s = options.checkpoint_s,
                            .haptic_devices = options.haptics,
                            .max_spring_nodes = options.spring_nodes,
                            .network_hz = options.network_hz,
                            .frame = options.scan.frame,
                            .straighten = options.scan.straighten,
                            .spacing_mm = options.scan.spacing_mm,
                            .units = options.units};
    auto server = Server::start(settings, arena);
    const bool port_is_taken = !server.ok() && server.error().field == "port";
    if (!port_is_taken || options.port_given) return server;
    settings.port = 0;
    return Server::start(settings, arena);
}

}  // namespace

int run_serve(const ServeOptions& options) {
    if (::pipe2(g_ends, O_CLOEXEC) != 0) return bad_input("serve: expected a pipe, found none");
    struct sigaction action {};
    action.sa_handler = stop_serving;
    for (const int number : {SIGINT, SIGTERM, SIGHUP}) sigaction(number, &action, nullptr);

    const TaskArena arena(options.threads);
    std::optional<ProgressBar> bar(std::in_place, "opening");
    bar->show(0.1);
    auto server = start(options, arena);
    bar.reset();
    if (!server.ok()) {
        return bad_input(named_by_option(server.error()));
    }
    g_is_serving = 1;
    for (const std::string& note : server->notes()) std::printf("%s\n", note.c_str());
    std::printf("Open  %s\n", server->link().c_str());
    std::printf("View  %s  (view only)\n", server->view_link().c_str());
    std::printf("Ctrl+C ends the server.\n");
    std::fflush(stdout);
    std::optional<Browser> browser;
    if (!options.no_open) browser.emplace(server->link());
    refill_reserve();
    std::set_new_handler(give_reserve_back);
    constexpr int kRefill_ms = 500;
    pollfd end{g_ends[0], POLLIN, 0};
    while (::poll(&end, 1, kRefill_ms) <= 0) {
        refill_reserve();
        if (browser) browser->reap();
    }
    std::set_new_handler(nullptr);
    return kExitOk;
}

}  // namespace pliant::app
