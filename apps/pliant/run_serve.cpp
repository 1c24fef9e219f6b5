// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// pliant serve: the server, until somebody presses Ctrl+C.

#include <pliant/serve.h>
#include <pthread.h>
#include <signal.h>
#include <spawn.h>

#include <cstdio>
#include <cstdlib>
#include <optional>

#include "options.h"
#include "progress.h"

extern char** environ;

namespace pliant::app {
namespace {

/// Opens the browser where there is a display; if that fails, there is still the link.
void open_browser(const std::string& link) {
    if (!std::getenv("DISPLAY") && !std::getenv("WAYLAND_DISPLAY")) return;
    std::string name = "xdg-open", argument = link;
    char* const arguments[] = {name.data(), argument.data(), nullptr};
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    for (const int descriptor : {0, 1, 2})
        posix_spawn_file_actions_addopen(&actions, descriptor, "/dev/null", 2 /* O_RDWR */, 0);
    posix_spawnattr_t attributes;
    posix_spawnattr_init(&attributes);
    sigset_t none;
    sigemptyset(&none);
    posix_spawnattr_setsigmask(&attributes, &none);
    posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGMASK);
    pid_t child = 0;
    (void)posix_spawnp(&child, name.c_str(), &actions, &attributes, arguments, environ);
    posix_spawnattr_destroy(&attributes);
    posix_spawn_file_actions_destroy(&actions);
}

Result<Server> start(const ServeOptions& options, const TaskArena& arena) {
    ServerSettings settings{.file = options.file,
                            .series = options.series,
                            .port = options.port,
                            .session = options.session};
    auto server = Server::start(settings, arena);
    const bool port_is_taken = !server.ok() && server.error().message.starts_with("port:");
    if (!port_is_taken || options.port_given) return server;
    settings.port = 0;
    return Server::start(settings, arena);
}

}  // namespace

int run_serve(const ServeOptions& options) {
    // All threads inherit this; the signals are waited for below.
    sigset_t ends;
    sigemptyset(&ends);
    sigaddset(&ends, SIGINT);
    sigaddset(&ends, SIGTERM);
    sigaddset(&ends, SIGHUP);
    pthread_sigmask(SIG_BLOCK, &ends, nullptr);
    signal(SIGCHLD, SIG_IGN);  // the browser's opener

    const TaskArena arena(options.threads);
    std::optional<ProgressBar> bar(std::in_place, "opening");
    bar->show(0.1);
    auto server = start(options, arena);
    bar.reset();
    if (!server.ok()) {
        const bool is_port = server.error().message.starts_with("port:");
        return bad_input((is_port ? "--" : "") + server.error().message);
    }
    for (const std::string& note : server->notes()) std::printf("%s\n", note.c_str());
    std::printf("Open  %s\n", server->link().c_str());
    std::printf("View  %s  (for those who may only look)\n", server->view_link().c_str());
    std::printf("Ctrl+C ends the server.\n");
    std::fflush(stdout);
    if (!options.no_open) open_browser(server->link());
    int signal_number = 0;
    sigwait(&ends, &signal_number);
    return kExitOk;
}

}  // namespace pliant::app
