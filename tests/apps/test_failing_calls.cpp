// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Each call to the system of a command fails once (failing_calls.c): the command succeeds with the
// same outputs, or ends with one line and all files as they were. The next run is not disturbed.
// Covers: base/input_file.cpp, base/staging_journal.cpp, network/door.cpp.

#include <fcntl.h>
#include <gtest/gtest.h>
#include <pliant/mesh_files.h>
#include <pliant/models/pbd.h>
#include <pliant/scan_files.h>
#include <pliant/volume.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "support/program_in_folder.h"
#include "support/running_program.h"
#include "support/scan_files.h"

namespace pliant::test {
namespace {

namespace fs = std::filesystem;
/// Bytes by name; of a folder "/".
using Files = std::map<std::string, std::string>;

struct Kind {
    const char* name;
    int error;
};
constexpr Kind kReads[] = {{"open", EACCES}, {"read", EIO}, {"readdir", EIO}, {"stat", EIO}};
constexpr Kind kAll[] = {{"open", EMFILE}, {"read", EIO},     {"readdir", EIO},
                         {"stat", EIO},    {"rename", EIO},   {"link", EPERM},
                         {"fsync", EIO},   {"write", ENOSPC}, {"thread", EAGAIN}};

bool is_leftover(const fs::path& path) {
    return path.filename().string().starts_with(".pliant-out-");
}

class FailingCalls : public ProgramInFolder {
  protected:
    void SetUp() override {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
        GTEST_SKIP() << "the sanitizer's library has to be the first one that is loaded";
#endif
        ASSERT_EQ(run("phantom airway --size 24 --out a.nrrd --raw"), 0) << said();
    }

    /// All files in the folder; leftovers are left out.
    Files files() const {
        Files found;
        for (auto at = fs::recursive_directory_iterator(m_folder.path());
             at != fs::recursive_directory_iterator(); ++at) {
            if (is_leftover(at->path())) {
                at.disable_recursion_pending();
                continue;
            }
            const std::string name = at->path().lexically_relative(m_folder.path()).string();
            if (name == ".out" || name == ".err" || name == ".count") continue;
            found[name] = at->is_directory() ? "/" : bytes_of(at->path());
        }
        return found;
    }
    bool has_leftovers() const {
        for (const auto& entry : fs::recursive_directory_iterator(m_folder.path()))
            if (is_leftover(entry.path())) return true;
        return false;
    }
    void restore(const Files& before) const {
        for (const auto& [name, bytes] : files())
            if (!before.contains(name)) fs::remove_all(m_folder / name);
        for (const auto& [name, bytes] : before)
            if (bytes != "/" && bytes_of(m_folder / name) != bytes) write(name.c_str(), bytes);
    }

    /// Runs a command whose calls from … to fail.
    int run_failing(const std::string& words, const Kind& kind, long from, long to) const {
        return run(words,
                   "timeout 60 env LD_PRELOAD='" PLIANT_FAILING_CALLS "' PLIANT_FAIL_CALL=" +
                       std::string(kind.name) + " PLIANT_FAIL_ERRNO=" + std::to_string(kind.error) +
                       " PLIANT_FAIL_FROM=" + std::to_string(from) +
                       " PLIANT_FAIL_TO=" + std::to_string(to) + " PLIANT_FAIL_COUNT=.count");
    }
    long count_calls(const std::string& words, const Kind& kind) const {
        EXPECT_EQ(run_failing(words, kind, 0, 0), 0) << words << ": " << said();
        const std::string count = bytes_of(m_folder / ".count");
        return count.empty() ? 0 : std::stol(count);
    }

    /// @param outputs  files that the command replaces
    void check(const std::string& words, const std::vector<std::string>& outputs,
               std::span<const Kind> kinds) {
        for (const std::string& output : outputs) write(output.c_str(), "old\n");
        const Files before = files();
        ASSERT_EQ(run(words), 0) << words << ": " << said();
        const Files after = files();
        for (const std::string& output : outputs) ASSERT_NE(after.at(output), "old\n") << output;
        for (const Kind& kind : kinds) {
            restore(before);
            const long count = count_calls(words, kind);
            EXPECT_EQ(names_that_differ(files(), after), "")
                << words << ": the outputs depend on the run";
            for (long n = 1; n <= count; ++n) {
                SCOPED_TRACE(words + ": " + kind.name + " " + std::to_string(n));
                restore(before);
                check_one(words, run_failing(words, kind, n, n), before, after);
            }
        }
        restore(before);
    }

    /// After a run with a failed call.
    void check_one(const std::string& words, int status, const Files& before, const Files& after) {
        ++m_points;
        const Files found = files();
        if (status == 0) {
            EXPECT_EQ(names_that_differ(found, after), "") << "silently: " << said();
        } else {
            const std::string line = said();
            EXPECT_EQ(status, 2) << line;
            EXPECT_TRUE(line.starts_with("pliant: ")) << line;
            EXPECT_EQ(std::count(line.begin(), line.end(), '\n'), 1) << line;
            EXPECT_EQ(line.find("basic_filebuf"), std::string::npos) << line;
            EXPECT_EQ(names_that_differ(found, before), "") << line;
        }
        if (!has_leftovers()) return;
        if (words.starts_with("truth make")) {  // a new folder only, but others write there
            EXPECT_EQ(run("phantom cube --size 8 --out tr/z.nrrd"), 0) << said();
        } else {
            EXPECT_EQ(run(words), 0) << said();
            EXPECT_EQ(names_that_differ(files(), after), "") << "after the next run";
        }
        // A folder of outputs that is there now is no longer made beside the leftover.
        EXPECT_EQ(run("phantom cube --size 8 --out z.nrrd"), 0) << said();
        EXPECT_FALSE(has_leftovers());
    }
    /// Folders without files don't count.
    static std::string names_that_differ(const Files& found, const Files& expected) {
        std::string names;
        for (const auto& [name, bytes] : expected)
            if (bytes == "/")
                continue;
            else if (!found.contains(name))
                names += name + " is missing; ";
            else if (found.at(name) != bytes)
                names += name + " differs; ";
        for (const auto& [name, bytes] : found)
            if (bytes != "/" && !expected.contains(name)) names += name + " is new; ";
        return names;
    }

    void write_slices() const {
        fs::create_directory(m_folder / "d");
        for (int n = 0; n < 4; ++n) {
            DicomFile slice;
            slice.position = {0, 0, double(n)};
            write(("d/" + std::to_string(n) + ".dcm").c_str(), slice.bytes());
        }
    }

    void write_organ() const {
        ASSERT_TRUE(write_vtu(m_folder / "organ.vtu", five_tet_block({2, 2, 2}, 10), {}).ok());
    }

    int m_points = 0;
};

constexpr const char* kFit =
    "fit --mesh organ.vtu --young 9000 --method closed-form --hold -1,-1,-1:21,21,1 "
    "--load 9,9,19:21,21,21:0,0,-0.4 --threads 1 --network-out n.json --out f.vtu";

constexpr const char* kPush = " --push='-5,0,0:2,0,0' --tool sphere:4 --threads 2 ";

TEST_F(FailingCalls, OfReadingAreNeverTheEndOfAFile) {
    write_slices();
    check("convert d o.nrrd", {"o.nrrd"}, kReads);
    write("c.toml", "[air]\nenabled = false\n");
    check("deform a.nrrd --config c.toml --out o.nrrd" + std::string(kPush), {"o.nrrd"},
          std::span(kReads).subspan(1, 2));
    EXPECT_GT(m_points, 50);
}

TEST_F(FailingCalls, OfEachKindLeaveTheOutputsOfDeform) {
    write("c.toml", "[air]\nenabled = false\n");
    for (const char* folder : {"x", "y"}) fs::create_directory(m_folder / folder);
    const std::string deform = "deform a.nrrd --config c.toml" + std::string(kPush);
    check(deform +
              "--out o.nrrd --displacement d.nrrd --transform t.nrrd --jacobian j.nrrd "
              "--strain s.nrrd --save-state p.plst --png v.png",
          {"o.nrrd", "d.nrrd", "t.nrrd", "j.nrrd", "s.nrrd", "p.plst", "v.png"}, kAll);
    check(deform + "--out x/o.nhdr --displacement y/d.nrrd --transform t.nrrd",
          {"x/o.nhdr", "x/o.raw.gz", "y/d.nrrd", "t.nrrd"}, kAll);
}

TEST_F(FailingCalls, OfEachKindLeaveTheOutputsOfOtherCommands) {
    check("convert a.nrrd o.nhdr", {"o.nhdr", "o.raw.gz"}, kAll);
    write("s.toml",
          "[vessel]\nphantom = \"bend\"\nlayers = 1\n[catheter]\nlength_mm = 100\n"
          "[entry]\nplace_mm = [0, 0, 5]\ndirection = [0, 0, 1]\n"
          "[[script]]\ninsert_mm_s = 400\nuntil_inserted_mm = 2\n");
    check("vessel s.toml --csv m.csv --frames f --every 5 --record h.log", {"m.csv", "h.log"},
          kAll);
    check("truth make a.nrrd --cases 1 --motions 1 --landmarks 10 --out tr", {}, kAll);
    write_organ();
    check(kFit, {"n.json", "f.vtu"}, kAll);
    write("way.mrk.json",
          "{\"markups\":[{\"type\":\"Curve\",\"coordinateSystem\":\"LPS\",\"controlPoints\":["
          "{\"position\":[0,0,-9]},{\"position\":[0,0,9]}]}]}");
    check(
        "render a.nrrd --path way.mrk.json --movie m/ --view endoscope --size 16x16 --speed 200 "
        "--threads 1",
        {}, kAll);
}

TEST_F(FailingCalls, OfEachKindAreReportedByEachReader) {
    write_slices();
    const std::string out = " --out o.nrrd" + std::string(kPush);
    ASSERT_EQ(run("deform a.nrrd --save-state p.plst" + out), 0) << said();
    check("deform a.nrrd --load-state p.plst" + out, {"o.nrrd"}, kReads);
    write_organ();
    ASSERT_EQ(run(kFit), 0) << said();
    check("deform a.nrrd --model springs --network n.json --steps 2" + out, {"o.nrrd"}, kReads);
    ASSERT_EQ(run("truth make a.nrrd --cases 1 --motions 1 --landmarks 10 --out tr"), 0) << said();
    check("truth score tr --field 'f=tr/{case}/forward.nrrd' --csv s.csv", {"s.csv"}, kReads);
    for (const char* name : {"b.vti", "b.nii", "b.nii.gz", "b.mhd", "b.nhdr"}) {
        ASSERT_EQ(run("convert a.nrrd " + std::string(name)), 0) << said();
        check("convert " + std::string(name) + " o.nrrd", {"o.nrrd"}, kReads);
    }
    write("t.nrrd", NrrdFile{.encoding = "ascii",
                             .data = "1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 "
                                     "17 18 19 20 21 22 23 24"}
                        .bytes());
    check("convert t.nrrd o.nrrd", {"o.nrrd"}, kReads);
    for (int n = 0; n < 2; ++n)
        write(("l" + std::to_string(n) + ".raw").c_str(), packed(std::vector<std::int16_t>(12, 7)));
    write("l.mhd", MetaFile{.data_file = "LIST\nl0.raw\nl1.raw", .data = {}}.bytes());
    check("convert l.mhd o.nrrd", {"o.nrrd"}, kReads);
}

// A rename fails, and the renames that would restore the old files fail too.
TEST_F(FailingCalls, OfEachRenameFromOneOnLoseNoOldFile) {
    for (const char* name : {"o.nhdr", "o.raw.gz"}) write(name, "old\n");
    const Files before = files();
    const std::string words = "convert a.nrrd o.nhdr";
    const Kind rename{"rename", EIO};
    const long count = count_calls(words, rename);
    const Files after = files();
    ASSERT_GE(count, 3);
    for (long n = 1; n <= count; ++n)
        for (const long to : {n + 1, n + 2, 1000000L}) {
            SCOPED_TRACE(std::to_string(n) + " to " + std::to_string(to));
            restore(before);
            EXPECT_EQ(run_failing(words, rename, n, to), 2);
            const std::string line = said();
            // Old, or put in order by the next run in the folder.
            if (has_leftovers()) {
                EXPECT_NE(line.find("next run"), std::string::npos) << line;
                EXPECT_EQ(run("phantom cube --size 8 --out other.nrrd"), 0);
                fs::remove(m_folder / "other.nrrd");
            }
            const Files found = files();
            EXPECT_TRUE(found == before || found == after)
                << names_that_differ(found, before) << line;
            EXPECT_FALSE(has_leftovers());
        }
}

/// Starts a server of which a call fails, and ends it when it has printed its link.
/// @returns its exit status; −1: it hangs, or a signal ended it
int serve(const fs::path& folder, const Kind& kind, long n) {
    fs::remove(folder / ".out");  // an earlier server's
    const pid_t server = ::fork();
    if (server == 0) {
        for (const auto& [name, number] : {std::pair(".out", 1), std::pair(".err", 2)})
            ::dup2(::open((folder / name).c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600), number);
        ::setenv("LD_PRELOAD", PLIANT_FAILING_CALLS, 1);
        ::setenv("PLIANT_FAIL_CALL", kind.name, 1);
        ::setenv("PLIANT_FAIL_ERRNO", std::to_string(kind.error).c_str(), 1);
        ::setenv("PLIANT_FAIL_FROM", std::to_string(n).c_str(), 1);
        ::setenv("PLIANT_FAIL_COUNT", ".count", 1);
        if (::chdir(folder.c_str()) == 0)
            ::execl(PLIANT_PROGRAM, PLIANT_PROGRAM, "serve", "a.nrrd", "--model", "chainmail",
                    "--session", "s.pls", "--no-open", "--port", "0", "--threads", "2", nullptr);
        ::_exit(127);
    }
    int raw = 0;
    bool is_told = false;
    const bool has_ended = comes_about([&] {
        if (::waitpid(server, &raw, WNOHANG) == server) return true;
        if (!is_told && bytes_of(folder / ".out").find("Open  ") != std::string::npos)
            is_told = ::kill(server, SIGTERM) == 0;
        return false;
    });
    if (!has_ended) {
        ::kill(server, SIGKILL);
        ::waitpid(server, &raw, 0);
    }
    return has_ended && WIFEXITED(raw) ? WEXITSTATUS(raw) : -1;
}

TEST_F(FailingCalls, OfEachKindEndAServerInOneLineOrNotAtAll) {
    const std::string scan = bytes_of(m_folder / "a.nrrd");
    const auto clear = [&] {
        for (const std::string& name : names())
            if (name != "a.nrrd") fs::remove_all(m_folder / name);
    };
    for (const Kind& kind : kAll) {
        clear();
        ASSERT_EQ(serve(m_folder.path(), kind, 0), 0) << said();
        const long count = std::stol(bytes_of(m_folder / ".count"));
        for (long n = 1; n <= count; ++n) {
            SCOPED_TRACE(std::string(kind.name) + " " + std::to_string(n));
            clear();
            const int status = serve(m_folder.path(), kind, n);
            const std::string line = said();
            EXPECT_TRUE(status == 0 || (status == 2 && line.starts_with("pliant: "))) << line;
            EXPECT_EQ(bytes_of(m_folder / "a.nrrd"), scan);
            if (!exists("s.pls") && !exists("s.pls.links")) continue;
            EXPECT_EQ(serve(m_folder.path(), kind, 0), 0) << "after it: " << said() << line;
        }
    }
}

// The files of an earlier start that failed or was killed, and files of others.
TEST_F(FailingCalls, EmptyFilesOfASessionAreNoneAndLinksAreOnesOwn) {
    const Kind none{"none", 0};
    const auto starts = [&] { return serve(m_folder.path(), none, 0) == 0; };
    for (const char* name : {"s.pls", "s.pls.links"}) write(name, "");
    fs::permissions(m_folder / "s.pls.links", fs::perms(0600));
    EXPECT_TRUE(starts()) << said();
    const std::string links = bytes_of(m_folder / "s.pls.links");
    EXPECT_EQ(links.size(), 66u);
    EXPECT_TRUE(starts()) << said();
    EXPECT_EQ(bytes_of(m_folder / "s.pls.links"), links) << "they outlive a restart";
    const auto refused = [&](const std::string& why) {
        EXPECT_EQ(serve(m_folder.path(), none, 0), 2) << why;
        EXPECT_NE(said().find("s.pls.links: " + why), std::string::npos) << said();
        EXPECT_NE(said().find("without the file there are new links"), std::string::npos) << said();
    };
    for (const auto open : {fs::perms(0644), fs::perms(0620), fs::perms(0606)}) {
        fs::permissions(m_folder / "s.pls.links", open);
        refused("can be read or written by other users");
    }
    fs::permissions(m_folder / "s.pls.links", fs::perms(0600));
    const std::string digits(32, '0');
    for (const std::string& text : {digits + "\n" + digits + "\n", links + "x", links.substr(0, 65),
                                    digits + "\n", std::string("\n"), links.substr(33) + "\n"}) {
        write("s.pls.links", text);
        refused("expected two different lines of 32 hexadecimal digits");
    }
    if (::geteuid() == 0) {
        write("s.pls.links", links);
        ASSERT_EQ(::chown((m_folder / "s.pls.links").c_str(), 65534, 65534), 0);
        refused("belongs to another user");
    }
    fs::remove(m_folder / "s.pls.links");
    fs::create_symlink("elsewhere", m_folder / "s.pls.links");
    refused("is a link to another file");
    EXPECT_FALSE(exists("elsewhere"));
    fs::remove(m_folder / "s.pls.links");
    ASSERT_EQ(::mkfifo((m_folder / "s.pls.links").c_str(), 0600), 0);
    refused("is no regular file");
}

// Nothing waits for a writer: each name of an input may be a pipe.
TEST_F(FailingCalls, PipesAreNeverWaitedFor) {
    ASSERT_EQ(::mkfifo((m_folder / "pipe").c_str(), 0600), 0);
    write("c.pem", "x");
    fs::create_directory(m_folder / "d");
    ASSERT_EQ(::mkfifo((m_folder / "d/pipe").c_str(), 0600), 0);
    for (const char* ending : {".nrrd", ".vtu", ".plst", ".toml", ".mrk.json", ".pls"})
        fs::create_symlink("pipe", m_folder / ("p" + std::string(ending)));
    for (const char* words : {"info pipe",
                              "info p.nrrd",
                              "info d",
                              "mesh p.vtu",
                              "mesh pipe",
                              "vessel p.toml",
                              "body p.toml",
                              "replay p.pls",
                              "fit p.toml",
                              "deform a.nrrd --config p.toml --push 0,0,0:1,0,0 --out o.nrrd",
                              "deform a.nrrd --labels p.nrrd --push 0,0,0:1,0,0 --out o.nrrd",
                              "deform a.nrrd --load-state p.plst --push 0,0,0:1,0,0 --out o.nrrd",
                              "render a.nrrd --path p.mrk.json --movie m/",
                              "haptics check --device ./pipe",
                              "haptics check --device replay:pipe",
                              "haptics check --device spacemouse:./pipe",
                              "serve a.nrrd --no-open --session p.pls",
                              "serve a.nrrd --no-open --certificate pipe --key c.pem",
                              "serve a.nrrd --no-open --certificate c.pem --key pipe",
                              "serve p.nrrd --no-open",
                              "serve a.nrrd --no-open --load-state p.plst"}) {
        EXPECT_EQ(run(words, "timeout 30"), 2) << words;
        EXPECT_TRUE(said().starts_with("pliant: ")) << words << ": " << said();
    }
}

// Files that can't be read, without a library: one of /proc whose reading fails.
TEST_F(FailingCalls, SettingsThatCantBeReadAreRefused) {
    for (const char* words :
         {"deform a.nrrd --config /proc/self/mem --push 0,0,0:1,0,0 --out o.nrrd",
          "truth make a.nrrd --config /proc/self/mem --cases 1 --out tr", "fit /proc/self/mem",
          "serve a.nrrd --no-open --config /proc/self/mem", "vessel /proc/self/mem",
          "replay /proc/self/mem"}) {
        EXPECT_EQ(run(words, "timeout 30"), 2) << words;
        EXPECT_NE(said().find("/proc/self/mem: can't be read (Input/output error)"),
                  std::string::npos)
            << words << ": " << said();
    }
    EXPECT_FALSE(exists("o.nrrd") || exists("tr"));
}

TEST_F(FailingCalls, SlicesWithoutPositionsTakeASpacingInEveryCommand) {
    DicomFile slice;
    slice.with_position = false;
    slice.rows = slice.columns = 12;
    slice.pixels.assign(144, 1000);
    for (int n = 0; n < 12; ++n) {
        slice.instance_number = std::to_string(n + 1);
        slice.instance = "5.5." + slice.instance_number;
        m_folder.write("d/" + slice.instance_number, slice.bytes());
    }
    for (const std::string words :
         {"info d", "convert d o.nrrd", "deform d --push 6,6,12:0,0,1 --out o.nrrd",
          "render d --view axial --size 32x32 --out o.png",
          "mesh d --seed=6,6,12 --window=-5,5 --out o.vtu",
          "path d --from 6,6,6 --to 6,6,16 --iso 9 "
          "--polarity falling --out o.mrk.json"}) {
        EXPECT_EQ(run(words, "timeout 30"), 2) << words;
        EXPECT_NE(said().find("or --spacing X,Y,Z"), std::string::npos) << words << said();
        // A path has points at a spacing of its own.
        const std::string option = words.starts_with("path") ? " --voxel-spacing" : " --spacing";
        run(words + option + " 1,1,2", "timeout 30");
        EXPECT_EQ(said().find("Image Position"), std::string::npos) << words << ": " << said();
        EXPECT_EQ(run(words + option + " 1,1,0", "timeout 30"), 2) << words;
    }
    EXPECT_TRUE(exists("o.nrrd") && exists("o.png"));
    ASSERT_EQ(run("info d --spacing 1,1,2"), 0);
    EXPECT_NE(out().find("render d --spacing 1,1,2 "), std::string::npos) << out();
}

// A slice that can't be read is never left out, wherever it is and whichever series is chosen.
TEST_F(FailingCalls, FilesOfAFolderThatCantBeReadAreRefused) {
    write_slices();
    ASSERT_EQ(run("convert d o.nrrd"), 0) << said();
    const std::string whole = bytes_of(m_folder / "o.nrrd");
    const auto refused = [&](const std::string& name, const std::string& why) {
        for (const char* words : {"info d", "convert d o.nrrd", "convert d o.nrrd --series 1.2.3",
                                  "serve d --no-open", "deform d --push 0,0,0:1,0,0 --out o.nrrd",
                                  "render d --out o.png", "convert d o.nrrd --straighten"}) {
            EXPECT_EQ(run(words, "timeout 30"), 2) << words;
            EXPECT_NE(said().find("d/" + name + ": " + why +
                                  "; it may be a slice: make it readable, or move it out of the "
                                  "folder\n"),
                      std::string::npos)
                << words << ": " << said();
        }
        EXPECT_EQ(bytes_of(m_folder / "o.nrrd"), whole);
    };
    for (const char* name : {"0.dcm", "2.dcm", "3.dcm"}) {
        fs::rename(m_folder / "d" / name, m_folder / "kept");
        fs::create_symlink("nowhere", m_folder / "d" / name);
        refused(name, "is a link to a file that isn't there");
        fs::remove(m_folder / "d" / name);
        fs::create_symlink(name, m_folder / "d" / name);
        refused(name, "can't be read (Too many levels of symbolic links)");
        fs::remove(m_folder / "d" / name);
        fs::create_symlink("/proc/self/mem", m_folder / "d" / name);
        refused(name, "can't be read (Input/output error)");
        fs::remove(m_folder / "d" / name);
        fs::rename(m_folder / "kept", m_folder / "d" / name);
    }
    fs::create_directory(m_folder / "links");
    fs::create_directory_symlink("../d", m_folder / "links/d");
    EXPECT_EQ(run("info links"), 2);
    EXPECT_EQ(said(),
              "pliant: links: holds no DICOM images (0 files looked at; 1 link to folders not "
              "followed)\n");
}

}  // namespace
}  // namespace pliant::test
