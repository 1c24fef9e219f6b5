// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "documents/commands.h"

#include <pliant/render.h>
#include <pliant/scan_files.h>
#include <pliant/volume.h>
#include <png.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <optional>
#include <sstream>

#include "support/temporary_folder.h"

namespace pliant::test {
namespace {

namespace fs = std::filesystem;

// A difference that can be seen: part of the range of values, in a number of voxels, or in a
// share of the pixels.
constexpr double kVisibleStep = 0.05;
constexpr std::size_t kVisibleVoxels = 100;
constexpr double kVisibleShareOfPixels = 5e-3;

bool is_command(const std::string& line) {
    const std::size_t first = line.find_first_not_of(' ');
    return first != line.npos && line.compare(first, 7, "pliant ") == 0;
}

/// Arguments of each call, one a line, with a form feed after the last. The program is found by its
/// name, as a reader has it.
void write_program(const fs::path& folder) {
    const fs::path program = folder / ".bin/pliant";
    fs::create_directories(program.parent_path());
    std::ofstream(program) << "#!/bin/sh\nprintf '%s\\n' \"$@\" >>'" << folder.string()
                           << "/.calls'\nprintf '\\f\\n' >>'" << folder.string()
                           << "/.calls'\nexec '" PLIANT_PROGRAM "' \"$@\"\n";
    fs::permissions(program, fs::perms::owner_all);
}

std::vector<std::vector<std::string>> calls_in(const fs::path& folder) {
    std::vector<std::vector<std::string>> calls(1);
    std::ifstream file(folder / ".calls");
    for (std::string line; std::getline(file, line);)
        if (line == "\f")
            calls.emplace_back();
        else
            calls.back().push_back(line);
    calls.pop_back();
    return calls;
}

std::string option_of(const std::vector<std::string>& call, std::string_view name) {
    const auto at = std::find(call.begin(), call.end(), name);
    return at == call.end() || at + 1 == call.end() ? std::string() : *(at + 1);
}

std::vector<double> values_of(const Volume& volume) {
    return std::visit(
        [](const auto& voxels) { return std::vector<double>(voxels.begin(), voxels.end()); },
        volume.voxels);
}

/// Number of differences above a step in two lists of one length.
template <class Number>
std::size_t count_differences(const std::vector<Number>& a, const std::vector<Number>& b,
                              double step) {
    std::size_t count = 0;
    for (std::size_t i = 0; i < a.size(); ++i) count += std::abs(double(a[i]) - b[i]) > step;
    return count;
}

bool show_difference(const std::vector<double>& a, const std::vector<double>& b) {
    if (a.size() != b.size()) return true;
    const auto [low, high] = std::minmax_element(a.begin(), a.end());
    return count_differences(a, b, kVisibleStep * (*high - *low)) >= kVisibleVoxels;
}

/// Whether the left and the right half of a picture show a difference.
bool halves_differ(const fs::path& path) {
    png_image png{};
    png.version = PNG_IMAGE_VERSION;
    if (!png_image_begin_read_from_file(&png, path.c_str())) return false;
    png.format = PNG_FORMAT_GRAY;
    std::vector<std::uint8_t> pixels(PNG_IMAGE_SIZE(png)), left, right;
    if (!png_image_finish_read(&png, nullptr, pixels.data(), 0, nullptr)) return false;
    // Squares at both ends of a row; a line is between them.
    const std::size_t width = png.width, side = png.height;
    for (std::size_t y = 0; y < side; ++y) {
        const auto row = pixels.begin() + std::ptrdiff_t(y * width);
        left.insert(left.end(), row, row + std::ptrdiff_t(side));
        right.insert(right.end(), row + std::ptrdiff_t(width - side), row + std::ptrdiff_t(width));
    }
    return double(count_differences(left, right, kVisibleStep * 255)) >
           kVisibleShareOfPixels * double(left.size());
}

std::optional<std::vector<double>> values_in(const fs::path& path) {
    const auto volume = read_volume(path);
    if (!volume) return {};
    return values_of(*volume);
}

/// Faults of all `pliant deform`.
std::vector<std::string> unseen_deformations(const fs::path& folder) {
    std::vector<std::string> faults;
    std::vector<std::pair<std::string, std::vector<double>>> earlier;
    for (const auto& call : calls_in(folder)) {
        if (call.size() < 2 || call[0] != "deform") continue;
        const std::string out = option_of(call, "--out"), png = option_of(call, "--png");
        const auto before = values_in(folder / call[1]), after = values_in(folder / out);
        if (!before || !after)
            faults.push_back(out + ": expected the volume of `pliant deform FILE … --out VOLUME`");
        else if (!show_difference(*before, *after))
            faults.push_back(out + ": expected a visible change, found the voxels of " + call[1]);
        else
            earlier.emplace_back(out, *after);
        if (!png.empty() && !halves_differ(folder / png))
            faults.push_back(png + ": expected a visible change, found it before as after");
    }
    for (std::size_t i = 0; i < earlier.size(); ++i)
        for (std::size_t j = 0; j < i; ++j)
            if (!show_difference(earlier[i].second, earlier[j].second))
                faults.push_back(earlier[i].first +
                                 ": expected a change of its own, found that of " +
                                 earlier[j].first);
    return faults;
}

}  // namespace

CommandBlocks command_blocks(std::string_view document) {
    CommandBlocks found;
    const std::string kReason = "<!-- not run: ", kEnd = " -->";
    std::istringstream lines{std::string(document)};
    std::string line, before, language;
    bool inside = false;
    for (int number = 1; std::getline(lines, line); ++number) {
        const auto fault = [&](const char* text) {
            found.faults.push_back(std::to_string(number) + ": " + text);
        };
        const std::size_t first = line.find_first_not_of(' ');
        const bool is_fence = first != line.npos && line.compare(first, 3, "```") == 0;
        const bool is_block = language == "sh" || language == "bash";
        if (is_fence && inside) {
            inside = false;
            language.clear();
        } else if (is_fence) {
            inside = true;
            language = line.substr(first + 3);
            std::string reason;
            if (before.size() >= kReason.size() + kEnd.size() && before.starts_with(kReason) &&
                before.ends_with(kEnd))
                reason =
                    before.substr(kReason.size(), before.size() - kReason.size() - kEnd.size());
            if (language == "sh" || language == "bash")
                found.blocks.push_back({number, {}, reason});
            if (language == "bash" && reason.empty())
                fault("expected <!-- not run: REASON --> before ```bash");
            if (language == "sh" && !reason.empty())
                fault("expected ```bash after <!-- not run: … -->, found ```sh");
        } else if (inside && is_block) {
            found.blocks.back().text += line + "\n";
        } else if (is_command(line) && (inside || first >= 4)) {
            fault("expected this command between ```sh and ```");
        }
        before = line;
    }
    return found;
}

std::vector<std::string> faults_of_run(const fs::path& folder,
                                       const std::vector<CommandBlock>& blocks) {
    write_program(folder);
    fs::create_directory_symlink(fs::path(PLIANT_SOURCE_DIR) / "scenes", folder / "scenes");
    std::ofstream script(folder / ".script");
    script << "set -eu\ntrap 'echo \"$line\" >.line' EXIT\n";
    for (const CommandBlock& block : blocks)
        if (block.exemption.empty()) script << "line=" << block.line << "\n" << block.text;
    script.close();
    const std::string command = "cd '" + folder.string() + "' && PATH='" + folder.string() +
                                "/.bin':\"$PATH\" sh .script >.out 2>.err";
    if (std::system(command.c_str()) != 0) {
        std::string line = bytes_of(folder / ".line");
        line.resize(line.find_last_not_of('\n') + 1);
        return {line + ": a command fails: " + bytes_of(folder / ".err")};
    }
    return unseen_deformations(folder);
}

}  // namespace pliant::test
