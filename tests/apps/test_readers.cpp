// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Every reader of the command line with every kind of file that is none, within a time limit; and
// small files that are nested too deep, or say something unprintable.
// Covers: pliant/main.cpp.

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>

#include <algorithm>
#include <cstring>

#include "support/program_in_folder.h"

namespace pliant::test {
namespace {

namespace fs = std::filesystem;

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr const char* kLimits = "ulimit -c 0 && timeout 60";
#else
constexpr const char* kLimits = "ulimit -v 8000000 && ulimit -c 0 && timeout 20";
#endif

class ReadersTest : public ProgramInFolder {
  protected:
    void SetUp() override { ASSERT_EQ(run("phantom cube --size 12 --out c.nrrd"), 0) << said(); }

    /// One line that a terminal doesn't obey, and status 2.
    void expect_refused(const std::string& arguments, const std::string& expected = {}) const {
        const int status = run(arguments, kLimits);
        const std::string line = said();
        EXPECT_EQ(status, 2) << arguments << ": " << line;
        EXPECT_EQ(std::count(line.begin(), line.end(), '\n'), 1) << arguments << ": " << line;
        EXPECT_LE(line.size(), 420u) << arguments;
        EXPECT_TRUE(
            std::none_of(line.begin(), line.end() - 1,
                         [](char c) { return static_cast<unsigned char>(c) < ' ' || c == '\x7f'; }))
            << arguments << ": " << line;
        EXPECT_NE(line.find(expected), std::string::npos) << arguments << ": " << line;
        EXPECT_FALSE(exists("o.nrrd") || exists("o.vtu") || exists("m")) << arguments;
    }
};

// FILE stands for the special file.
constexpr const char* kReaders[] = {
    "info FILE",
    "deform FILE --push 0,0,0:1,0,0 --out o.nrrd",
    "deform c.nrrd --push 0,0,0:1,0,0 --out o.nrrd --config FILE",
    "deform c.nrrd --push 0,0,0:1,0,0 --out o.nrrd --config l.toml --labels FILE",
    ("deform c.nrrd --push 0,0,0:1,0,0 --out o.nrrd --config l.toml --labels c.nrrd "
     "--directions FILE"),
    "deform c.nrrd --push 0,0,0:1,0,0 --out o.nrrd --load-state FILE",
    "render FILE --out o.png",
    "render c.nrrd --load-state FILE --out o.png",
    "render c.nrrd --path FILE --movie m/",
    "render c.nrrd --keyframes FILE --movie m/",
    "path FILE --from 0,0,0 --to 1,1,1 --out o.mrk.json",
    "mesh FILE --out o.vtu --seed 0,0,0 --window 0,1",
    "mesh FILE.vtp --out o.vtu",
    "mesh c.vtp --ends FILE --out o.vtu",
    "vessel FILE",
    "vessel s.toml --replay FILE",
    "fit FILE",
    "replay FILE",
    "serve FILE --no-open",
    "serve FILE.toml --no-open",
    "serve c.nrrd --no-open --session FILE",
    "haptics check --device replay:FILE --minutes 0.01",
    "haptics check --device FILE --minutes 0.01",
};

TEST_F(ReadersTest, RefuseAtOnceWhatIsNoFile) {
    write("l.toml", "[[label]]\nvalues = 1\nlaw = \"fixed\"\n");
    write("s.toml",
          "[vessel]\nphantom = \"bend\"\nlayers = 1\n[catheter]\nlength_mm = 100\n"
          "[entry]\nplace_mm = [0, 0, 5]\ndirection = [0, 0, 1]\n"
          "[[script]]\ninsert_mm_s = 400\nuntil_inserted_mm = 12\n");
    write("c.vtp", "");
    fs::create_directory(m_folder / "folder");
    fs::create_symlink("loop", m_folder / "loop");
    ASSERT_EQ(::mkfifo((m_folder / "pipe").c_str(), 0600), 0);
    fs::create_symlink("pipe", m_folder / "linked");
    const fs::path socket = m_folder / "socket";
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    std::strncpy(address.sun_path, socket.c_str(), sizeof address.sun_path - 1);
    const int made = ::socket(AF_UNIX, SOCK_STREAM, 0);
    ASSERT_EQ(::bind(made, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
    ::close(made);
    // Readers of meshes and scenes go by the ending.
    for (const char* ending : {".vtp", ".toml"}) {
        for (const char* name : {"folder", "loop", "pipe", "linked", "socket"})
            fs::create_symlink(name, m_folder / (std::string(name) + ending));
        fs::create_symlink("/dev/zero", m_folder / (std::string("zero") + ending));
    }
    fs::create_symlink("/dev/zero", m_folder / "zero");
    write("empty", "");
    const std::string long_name(300, 'x');
    for (const std::string& file :
         {std::string("folder"), std::string("loop"), std::string("pipe"), std::string("linked"),
          std::string("socket"), std::string("zero"), std::string("none"), long_name}) {
        for (const std::string reader : kReaders) {
            if (file == "none" && reader.find("--session") != std::string::npos) continue;
            std::string arguments = reader;
            arguments.replace(arguments.find("FILE"), 4, file);
            expect_refused(arguments);
        }
    }
    // Requires that these readers have seeds.
    for (const std::string reader : kReaders) {
        if (reader.find("FILE.") != std::string::npos || reader == "fit FILE" ||
            reader.find("--config FILE") != std::string::npos ||
            reader.find("--session FILE") != std::string::npos)
            continue;
        std::string arguments = reader;
        arguments.replace(arguments.find("FILE"), 4, "empty");
        expect_refused(arguments);
    }
}

TEST_F(ReadersTest, RefuseDeepNestingBeforeAParserSeesIt) {
    const auto repeated = [](const char* part, int count) {
        std::string text;
        for (int n = 0; n < count; ++n) text += part;
        return text;
    };
    const std::string deep[] = {
        repeated("a.", 100'000) + "a = 1\n",       "[" + repeated("a.", 100'000) + "a]\n",
        "a = " + repeated("[", 100'000),           "a = " + repeated("{a=", 100'000),
        "a = " + repeated("[{a=", 100'000) + "\n", repeated("\"a\".", 100'000) + "a = 1\n",
    };
    for (const std::string& text : deep) {
        write("d.toml", "[material]\n" + text);  // else it is taken for Divod's lines
        expect_refused("deform c.nrrd --push 0,0,0:1,0,0 --out o.nrrd --config d.toml",
                       "d.toml: line 2: expected ");
        write("d.toml", text);
        expect_refused("vessel d.toml", "d.toml: line 1: expected ");
        expect_refused("serve d.toml --no-open", "d.toml: line 1: expected ");
        expect_refused("fit d.toml", "d.toml: line 1: expected ");
    }
    const std::string brackets = repeated("[", 1'000'000);
    for (const std::string& text : {brackets, "{\"markups\": [{\"coordinateSystem\": " + brackets,
                                    "{\"markups\": [{\"controlPoints\": [{\"position\": " +
                                        brackets + repeated("]", 1'000'000) + "}]}]}"}) {
        write("d.json", text);
        expect_refused("render c.nrrd --path d.json --movie m/", "d.json: line 1: expected");
        expect_refused("render c.nrrd --keyframes d.json --movie m/", "d.json: line 1: expected");
    }
}

TEST_F(ReadersTest, ShowNothingThatATerminalObeys) {
    const std::string bad = "\x1b]0;owned\a\xff\xc2\x9b" + std::string(2000, 'x');
    const auto in_toml = "\\u001b]0;owned\\u0007" + std::string(2000, 'x');
    const struct {
        std::string text;
        const char* arguments;
    } cases[] = {
        {"[material]\nlaw = \"" + in_toml + "\"\n",
         "deform c.nrrd --push 0,0,0:1,0,0 --out o.nrrd --config f"},
        {"[material]\n\"" + in_toml + "\" = 1\n",
         "deform c.nrrd --push 0,0,0:1,0,0 --out o.nrrd --config f"},
        {"[\"" + in_toml + "\"]\nx = 1\n",
         "deform c.nrrd --push 0,0,0:1,0,0 --out o.nrrd --config f"},
        {"\"" + in_toml + "\" = 1\n[x]\n",
         "deform c.nrrd --push 0,0,0:1,0,0 --out o.nrrd --config f"},
        {"[[label]]\nvalues = 1\nlaw = \"" + in_toml + "\"\n",
         "deform c.nrrd --push 0,0,0:1,0,0 --out o.nrrd --config f"},
        {"[[label]]\n\"" + in_toml + "\" = 1\n",
         "deform c.nrrd --push 0,0,0:1,0,0 --out o.nrrd --config f"},
        {"offset = 1" + bad + "\n", "deform c.nrrd --push 0,0,0:1,0,0 --out o.nrrd --config f"},
        {bad + " = 1\n", "deform c.nrrd --push 0,0,0:1,0,0 --out o.nrrd --config f"},
        {"a = 1\n" + bad + "\n", "deform c.nrrd --push 0,0,0:1,0,0 --out o.nrrd --config f"},
        {"[vessel]\nphantom = \"" + in_toml + "\"\n[[script]]\nfor_s = 1\n", "vessel f"},
        {"[vessel]\n\"" + in_toml + "\" = 1\n[[script]]\nfor_s = 1\n", "vessel f"},
        {"[vessel]\nsurface = \"" + in_toml + "\"\n[[script]]\nfor_s = 1\n", "vessel f"},
        {"\"" + in_toml + "\" = 1\n", "vessel f"},
        {bad + " = 1\n", "vessel f"},
        {bad + " = 1\n", "fit f"},
        {"size = \"" + bad + "\"\n", "fit f"},
        {"load = \"" + bad + "\"\n", "fit f"},
        {bad, "fit f"},
        {"pliant vessel log 1\n" + bad + "\n", "vessel s.toml --replay f"},
        {"{\"markups\": [{\"coordinateSystem\": \"" + in_toml + "\"}]}",
         "render c.nrrd --path f --movie m/"},
        {"{\"markups\": [{\"coordinateUnits\": \"" + in_toml + "\"}]}",
         "render c.nrrd --path f --movie m/"},
        {"{\"markups\": [{\"controlPoints\": [{\"position\": \"" + in_toml + "\"}]}]}",
         "render c.nrrd --path f --movie m/"},
        {"{\"what\": \"pliant keyframes\", \"version\": 1, \"keyframes\": [{\"seconds\": \"" +
             in_toml + "\"}]}",
         "render c.nrrd --keyframes f --movie m/"},
        {bad, "replay f"},
        {bad, "haptics check --minutes 0.01 --device replay:f"},
    };
    write("s.toml", "[vessel]\nphantom = \"bend\"\nlayers = 1\n[[script]]\nfor_s = 0.01\n");
    for (const auto& c : cases) {
        write("f", c.text);
        expect_refused(c.arguments);
    }
    // Names of the user's own.
    expect_refused("info $'\\e]0;owned\\a.nrrd'");
    expect_refused("info " + std::string(3000, 'x'));
}

}  // namespace
}  // namespace pliant::test
