// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Writes frames to a movie: through a pipe to ffmpeg, or as numbered PNG files in a folder.

#pragma once

#include <pliant/core/files.h>
#include <pliant/render.h>

#include <sys/types.h>

#include <filesystem>

namespace pliant::app {

inline constexpr int kFramesPerSecond = 25;

class Movie {
  public:
    Movie() = default;
    Movie(const Movie&) = delete;
    Movie& operator=(const Movie&) = delete;
    /// Ends ffmpeg, by force after half a second, and removes the file, unless finish() was called.
    ~Movie();

    /// @param target  an existing folder or a name ending in /: frames as 00000.png, …; otherwise a
    ///                file of a type known to ffmpeg
    Status open(const std::filesystem::path& target, int width, int height);
    /// @pre the size is that of open()
    Status add(const Image& frame);
    Status finish();

  private:
    Status start_ffmpeg(const std::filesystem::path& file, int width, int height);
    Status wait();
    int reap();  ///< waits for ffmpeg; @returns its status, as waitpid does

    std::filesystem::path m_target;
    std::filesystem::path m_folder;  ///< temporary folder of the frames
    bool m_is_folder = false;
    int m_count = 0;
    int m_pipe = -1;
    pid_t m_ffmpeg = -1;
    StagedFiles m_staged;
};

}  // namespace pliant::app
