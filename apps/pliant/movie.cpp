// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "movie.h"

#include <pliant/view/png.h>

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <string>
#include <thread>
#include <vector>

#include "ending.h"

extern char** environ;

namespace pliant::app {
namespace {

Error unwritable(const std::filesystem::path& target, const std::string& what) {
    return {ErrorCode::Unwritable, target.string() + ": " + what};
}

/// Waits until a child has ended. It stays unreaped, so that its process id isn't reused.
/// @param flags  WNOHANG: polls
/// @returns whether it has ended
bool has_ended(pid_t child, int flags) {
    siginfo_t info{};
    int result = -1;
    do result = waitid(P_PID, id_t(child), &info, WEXITED | WNOWAIT | flags);
    while (result != 0 && errno == EINTR);
    return result != 0 || info.si_pid == child;
}

/// Kills a child after half a second.
void kill_later(pid_t child) {
    constexpr std::chrono::milliseconds kPatience(500), kPause(5);
    const auto last = std::chrono::steady_clock::now() + kPatience;
    while (!has_ended(child, WNOHANG)) {
        if (std::chrono::steady_clock::now() > last) {
            kill(child, SIGKILL);
            return;
        }
        std::this_thread::sleep_for(kPause);
    }
}

}  // namespace

Movie::~Movie() {
    if (m_pipe >= 0) close(m_pipe);
    m_pipe = -1;
    if (m_ffmpeg <= 0) return;
    kill(m_ffmpeg, SIGTERM);
    kill_later(m_ffmpeg);
    reap();
}

Status Movie::open(const std::filesystem::path& target, int width, int height) {
    m_target = target;
    std::error_code code;
    const auto type = std::filesystem::status(target, code).type();
    if (type == std::filesystem::file_type::none) return unwritable(target, code.message());
    m_is_folder = !target.has_filename() || type == std::filesystem::file_type::directory;
    const auto staged = m_is_folder ? m_staged.stage_folder(target) : m_staged.stage(target);
    if (!staged) return staged.error();
    m_folder = *staged;
    return m_is_folder ? Status(Ok{}) : start_ffmpeg(*staged, width, height);
}

Status Movie::start_ffmpeg(const std::filesystem::path& file, int width, int height) {
    std::vector<std::string> words = {
        "ffmpeg", "-y", "-loglevel", "error", "-f", "rawvideo", "-pixel_format", "rgb24",
        "-video_size", std::to_string(width) + "x" + std::to_string(height), "-framerate",
        std::to_string(kFramesPerSecond), "-i", "-",
        // Most players need 4:2:0 subsampling, so width and height must be even.
        "-vf", "pad=ceil(iw/2)*2:ceil(ih/2)*2", "-pix_fmt", "yuv420p", file.string()};
    std::vector<char*> arguments;
    for (std::string& word : words) arguments.push_back(word.data());
    arguments.push_back(nullptr);
    int ends[2];
    if (pipe2(ends, O_CLOEXEC) != 0) return unwritable(m_target, "no pipe to ffmpeg");
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_adddup2(&actions, ends[0], STDIN_FILENO);
    // The program reports errors itself, in one line.
    posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, "/dev/null", O_WRONLY, 0);
    // Restores the default action of the signals that this program ignores.
    sigset_t ignored;
    sigemptyset(&ignored);
    for (const int number : {SIGPIPE, SIGXFSZ}) sigaddset(&ignored, number);
    posix_spawnattr_t attributes;
    posix_spawnattr_init(&attributes);
    posix_spawnattr_setsigdefault(&attributes, &ignored);
    posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGDEF);
    expect_child();
    const int failed =
        posix_spawnp(&m_ffmpeg, "ffmpeg", &actions, &attributes, arguments.data(), environ);
    posix_spawnattr_destroy(&attributes);
    posix_spawn_file_actions_destroy(&actions);
    close(ends[0]);
    m_pipe = ends[1];
    if (failed != 0) m_ffmpeg = -1;
    end_with_program(m_ffmpeg);
    if (failed != 0)
        return unwritable(m_target,
                          "ffmpeg is not there to make it; expected it installed, or a folder "
                          "(a name that ends in /) for the frames");
    return Ok{};
}

Status Movie::add(const Image& frame) {
    if (m_is_folder) {
        char name[32];
        std::snprintf(name, sizeof name, "%05d.png", m_count++);
        return write_png(m_folder / name, frame);
    }
    const char* at = reinterpret_cast<const char*>(frame.pixels.data());
    static_assert(sizeof(Rgb8) == 3);
    for (std::size_t left = frame.pixels.size() * sizeof(Rgb8); left > 0;) {
        const ssize_t written = write(m_pipe, at, left);
        if (written < 0 && errno == EINTR) continue;
        if (written <= 0) {
            kill_later(m_ffmpeg);  // it reads no more, even if it is still running
            if (const Status ended = wait(); !ended) return ended;
            return unwritable(m_target, "ffmpeg ended before the last frame");
        }
        at += written;
        left -= std::size_t(written);
    }
    ++m_count;
    return Ok{};
}

int Movie::reap() {
    has_ended(m_ffmpeg, 0);
    end_with_program(-1);
    int state = 0;
    waitpid(m_ffmpeg, &state, 0);
    m_ffmpeg = -1;
    return state;
}

Status Movie::wait() {
    close(m_pipe);
    m_pipe = -1;
    const int state = reap();
    if (WIFEXITED(state) && WEXITSTATUS(state) == 0) return Ok{};
    return unwritable(m_target, "ffmpeg could not make it; expected a name such as movie.mp4");
}

Status Movie::finish() {
    if (!m_is_folder)
        if (const Status ended = wait(); !ended) return ended;
    return m_staged.commit();
}

}  // namespace pliant::app
