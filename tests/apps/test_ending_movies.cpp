// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// How the program ends while ffmpeg makes a movie. A script takes ffmpeg's place; it ignores
// SIGTERM and would never end by itself. It ends with the program, and no file remains.
// Covers: pliant/ending.cpp, pliant/movie.cpp.

#include <gtest/gtest.h>
#include <spawn.h>

#include "../../apps/pliant/ending.h"
#include "../../apps/pliant/movie.h"
#include "support/program_in_folder.h"
#include "support/running_program.h"

namespace pliant::test {
namespace {

namespace fs = std::filesystem;

/// A script named ffmpeg, first on PATH. It begins its output, and then works on.
class EndingMovies : public ProgramInFolder {
  protected:
    EndingMovies() : m_path(std::getenv("PATH")) {
        ::setenv("PATH", ((m_folder / "bin").string() + ":" + m_path).c_str(), 1);
        ::mkfifo((m_folder / "alive").c_str(), 0600);
        m_alive = ::open((m_folder / "alive").c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);
        be_ffmpeg("exec sleep infinity");
    }
    ~EndingMovies() override {
        ::setenv("PATH", m_path.c_str(), 1);
        ::close(m_alive);
    }

    /// @param works_on  last line of the script
    void be_ffmpeg(const std::string& works_on) const {
        const fs::path script = m_folder.write(
            "bin/ffmpeg", "#!/bin/sh\ntrap '' TERM\nexec 3>'" + (m_folder / "alive").string() +
                              "'\nfor last; do :; done\necho half >\"$last\"\n"
                              "echo begun >&3\n" +
                              works_on + "\n");
        fs::permissions(script, fs::perms::owner_all);
    }
    /// @returns bytes that the script wrote; 0: it has ended; −1: it lives and writes none
    ssize_t read_alive() const {
        char text[16];
        return ::read(m_alive, text, sizeof text);
    }
    void expect_all_ended() const {
        EXPECT_TRUE(comes_about([&] { return read_alive() == 0; })) << "ffmpeg lives";
        EXPECT_EQ(names(), m_before);
    }
    static Image frame() {
        Image image;
        image.width = image.height = 64;
        image.pixels.resize(64 * 64);
        return image;
    }

    std::set<std::string> m_before{"alive", "bin"};

  private:
    std::string m_path;
    int m_alive = -1;
};

TEST_F(EndingMovies, SignalsEndFfmpegWithTheProgram) {
    ASSERT_EQ(run("phantom cube --size 16 --out c.nrrd"), 0) << said();
    write("way.mrk.json",
          "{\"markups\":[{\"type\":\"Curve\",\"coordinateSystem\":\"LPS\",\"controlPoints\":["
          "{\"position\":[0,0,-9]},{\"position\":[0,0,9]}]}]}");
    m_before = names();
    for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
        RunningProgram program(m_folder.path(),
                               {"render", "c.nrrd", "--path", "way.mrk.json", "--speed", "4",
                                "--size", "320x240", "--view", "endoscope", "--movie", "x.mp4"});
        ASSERT_TRUE(comes_about([&] { return read_alive() > 0; })) << said();
        EXPECT_EQ(program.end(signal), 128 + signal) << said();
        expect_all_ended();
    }
}

TEST_F(EndingMovies, AMovieThatIsGivenUpKillsFfmpeg) {
    {
        app::Movie movie;
        ASSERT_TRUE(movie.open(m_folder / "x.mp4", 64, 64).ok());
        ASSERT_TRUE(comes_about([&] { return read_alive() > 0; }));
        EXPECT_TRUE(movie.add(frame()).ok());
    }
    expect_all_ended();
}

TEST_F(EndingMovies, AnFfmpegThatReadsNoFurtherIsAnError) {
    be_ffmpeg("exec <&- sleep infinity");
    const auto before = ::signal(SIGPIPE, SIG_IGN);  // as in the program
    {
        app::Movie movie;
        ASSERT_TRUE(movie.open(m_folder / "x.mp4", 64, 64).ok());
        ASSERT_TRUE(comes_about([&] { return read_alive() > 0; }));
        Status added = Ok{};
        for (int n = 0; n < 1000 && added.ok(); ++n) added = movie.add(frame());
        ASSERT_FALSE(added.ok());
        EXPECT_NE(added.error().message.find("x.mp4: ffmpeg could not make it"), std::string::npos)
            << added.error().message;
    }
    expect_all_ended();
    ::signal(SIGPIPE, before);
}

TEST_F(EndingMovies, ASignalBetweenStartAndRegistrationEndsTheChildToo) {
    const pid_t process = ::fork();
    if (process == 0) {
        app::guard_process();
        app::expect_child();
        std::string program = m_folder / "bin/ffmpeg", output = m_folder / "half";
        char* words[] = {program.data(), output.data(), nullptr};
        pid_t child = -1;
        ::posix_spawn(&child, program.c_str(), nullptr, nullptr, words, environ);
        comes_about([&] { return read_alive() > 0; });
        ::raise(SIGTERM);
        app::end_with_program(child);
        ::_exit(1);
    }
    int raw = 0;
    ::waitpid(process, &raw, 0);
    EXPECT_TRUE(WIFEXITED(raw) && WEXITSTATUS(raw) == 128 + SIGTERM) << raw;
    EXPECT_TRUE(comes_about([&] { return read_alive() == 0; })) << "the child lives";
}

}  // namespace
}  // namespace pliant::test
