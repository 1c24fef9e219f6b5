// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A scan of 512 × 512 × 1024 voxels (537 MB), opened and pushed once by the program from the
// command line: seconds, and peak memory as a multiple of the scan's file. Mapped page cache counts
// as memory. One item is a voxel of the scan. The reference reads the bytes of the scan's file, and
// writes a copy if the program writes.
//
// All files are in the folder bench-large-scan, which is removed at the end: 8 GB for the case with
// both fields, 2.5 GB for the others.

#include <fcntl.h>
#include <pliant/core/text.h>
#include <pliant/volume.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <memory>
#include <string>
#include <system_error>
#include <vector>

#include "interleaved.h"

extern char** environ;

namespace pliant::bench {
namespace {

namespace fs = std::filesystem;

constexpr double kVoxels = 512.0 * 512 * 1024;
constexpr int kRuns = 3;

std::string argument_of(Vec3d v) {
    return text_of(v.x) + "," + text_of(v.y) + "," + text_of(v.z);
}

/// Folder of the scan and all files derived from it.
class Folder {
  public:
    static Folder& get() {
        static Folder folder;
        return folder;
    }
    ~Folder() {
        std::error_code ignored;
        fs::remove_all(m_path, ignored);
    }
    fs::path operator/(const char* name) const { return m_path / name; }
    /// @returns reason why the scan can't be made here; empty if it exists
    const std::string& trouble() const { return m_trouble; }

    /// Runs the program in this folder, started by /usr/bin/time, because the peak memory of a
    /// process includes that of its parent before exec.
    /// @param[out] peak_bytes  may be null
    /// @returns false on failure
    bool run(const std::vector<std::string>& arguments, double* peak_bytes = nullptr) const {
        std::vector<std::string> words = {
            "/usr/bin/time", "-o",          m_path / "peak.txt", "-f", "%M", "env", "-C",
            m_path,          PLIANT_PROGRAM};
        words.insert(words.end(), arguments.begin(), arguments.end());
        std::vector<char*> pointers;
        for (std::string& word : words) pointers.push_back(word.data());
        pointers.push_back(nullptr);
        posix_spawn_file_actions_t actions;
        posix_spawn_file_actions_init(&actions);
        posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
        pid_t child = 0;
        const bool started =
            posix_spawn(&child, words[0].c_str(), &actions, nullptr, pointers.data(), environ) == 0;
        posix_spawn_file_actions_destroy(&actions);
        int status = 0;
        if (!started || ::waitpid(child, &status, 0) != child || status != 0) return false;
        double kibibytes = 0;
        std::ifstream(m_path / "peak.txt") >> kibibytes;
        if (peak_bytes) *peak_bytes = kibibytes * 1024;
        return true;
    }

  private:
    Folder() : m_path(fs::absolute("bench-large-scan")) {
        constexpr double kNeeded = 2.5e9;
        std::error_code failed;
        fs::remove_all(m_path, failed);
        if (!fs::create_directory(m_path, failed) ||
            double(fs::space(m_path, failed).available) < kNeeded) {
            m_trouble = "expected 2.5 GB of room in " + m_path.string();
            return;
        }
        std::ofstream(m_path / "soft.toml")
            << "[material]\nbone_threshold_hu = 3000\n";  // contrast agent is no bone
        if (!run({"phantom", "vessel", "--size", "512x512x1024", "--spacing", "0.7,0.7,0.6",
                  "--raw", "--out", "scan.nrrd"}))
            m_trouble = "the scan could not be made (is /usr/bin/time there?)";
    }

    fs::path m_path;
    std::string m_trouble;
};

/// Reads a file, and writes a copy if `to` isn't empty. @returns bytes; 0 on failure
double read_file(const fs::path& from, const fs::path& to) {
    std::vector<char> piece(std::size_t(1) << 20);
    std::ifstream in(from, std::ios::binary);
    std::ofstream out;
    if (!to.empty()) out.open(to, std::ios::binary);
    double bytes = 0;
    while (in.read(piece.data(), std::streamsize(piece.size())), in.gcount() > 0) {
        if (!to.empty()) out.write(piece.data(), in.gcount());
        bytes += double(in.gcount());
    }
    return to.empty() || out.flush() ? bytes : 0;
}

struct LargeScanCase {
    const char* name;
    const char* scan;  ///< input file
    bool pushed;
    std::vector<std::string> options;  ///< of the push
};

/// The program's arguments for the phantom's suggested push.
std::vector<std::string> pushed(const std::string& scan, const std::string& out) {
    // Landmarks are independent of the grid.
    const auto phantom = make_phantom({.name = "vessel", .size = {32, 32, 32}}, TaskArena(1));
    const PhantomLandmark& place = phantom->landmarks.at(0);
    return {"deform",
            scan,
            "--push=" + argument_of(place.push_point_mm) + ":" + argument_of(place.push_mm),
            "--tool",
            "sphere:4",
            "--config",
            "soft.toml",
            "--out",
            out};
}

void large_scan(benchmark::State& state, const LargeScanCase& what) {
    const Folder& folder = Folder::get();
    if (!folder.trouble().empty()) return state.SkipWithError(folder.trouble().c_str());
    if (what.scan == std::string("packed.nrrd") && !fs::exists(folder / "packed.nrrd") &&
        !folder.run(pushed("scan.nrrd", "packed.nrrd")))
        return state.SkipWithError("the packed scan could not be made");
    std::vector<std::string> arguments = {"info", what.scan};
    if (what.pushed) arguments = pushed(what.scan, "out.nrrd");
    arguments.insert(arguments.end(), what.options.begin(), what.options.end());
    const fs::path scan = folder / what.scan, copy = folder / "copy";
    Turns turns(state, "the file read, and copied where a scan is written");
    double most_bytes = 0;
    for (auto _ : state) {
        turns.add_reference(seconds_of([&] { read_file(scan, what.pushed ? copy : fs::path()); }));
        fs::remove(copy);
        bool done = false;
        double peak_bytes = 0;
        turns.add_subject(seconds_of([&] { done = folder.run(arguments, &peak_bytes); }));
        for (const char* made : {"out.nrrd", "u.nrrd", "t.nrrd"}) fs::remove(folder / made);
        if (!done) return state.SkipWithError("the program failed");
        most_bytes = std::max(most_bytes, peak_bytes);
    }
    turns.count(kVoxels);
    // Relative to the raw voxels, compressed or not.
    state.counters["peak_memory/scan"] = most_bytes / (2 * kVoxels);
    state.counters["peak_memory_mb"] = most_bytes / 1e6;
}

const bool registered = [] {
    for (const LargeScanCase& what : std::vector<LargeScanCase>{
             {"open", "scan.nrrd", false, {}},
             {"push", "scan.nrrd", true, {"--raw"}},
             {"push_write_gzip", "scan.nrrd", true, {}},
             {"push_write_fields",
              "scan.nrrd",
              true,
              {"--raw", "--displacement", "u.nrrd", "--transform", "t.nrrd"}},
             {"open_gzip", "packed.nrrd", false, {}},
             {"push_gzip", "packed.nrrd", true, {"--raw"}}})
        benchmark::RegisterBenchmark((std::string("large_scan/") + what.name).c_str(),
                                     [what](benchmark::State& state) { large_scan(state, what); })
            ->Iterations(kRuns)
            ->UseManualTime()
            ->Unit(benchmark::kMillisecond);
    return true;
}();

}  // namespace
}  // namespace pliant::bench
