// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include <pliant/core/text.h>
#include <pliant/scan_files.h>
#include <pliant/volume.h>

#include <array>
#include <charconv>
#include <cstdio>
#include <filesystem>

#include "options.h"
#include "progress.h"
#include "shell_word.h"

namespace pliant::app {
namespace {

/// Parses nine numbers, separated by commas or blanks: the columns of the matrix.
std::optional<Mat3d> parse_direction(const std::string& text) {
    std::array<double, 9> n{};
    const char* at = text.data();
    const char* const end = at + text.size();
    const auto skip_blanks = [&] {
        while (at != end && (*at == ' ' || *at == '\t')) ++at;
    };
    for (std::size_t i = 0; i < n.size(); ++i) {
        skip_blanks();
        if (i > 0 && at != end && *at == ',') ++at;
        skip_blanks();
        if (at != end && *at == '+') ++at;
        const auto [next, error] = std::from_chars(at, end, n[i]);
        const bool ended = next == end || *next == ',' || *next == ' ' || *next == '\t';
        if (error != std::errc{} || !std::isfinite(n[i]) || !ended) return std::nullopt;
        at = next;
    }
    skip_blanks();
    if (at != end) return std::nullopt;
    return Mat3d{{{n[0], n[1], n[2]}, {n[3], n[4], n[5]}, {n[6], n[7], n[8]}}};
}

std::string value_of(const KeyValues& pairs, const std::string& key) {
    for (const auto& [name, value] : pairs)
        if (name == key) return value;
    return {};
}

/// Prints a summary, and for each landmark the command that pushes there.
void tell(const std::string& path, const Volume& volume) {
    const Grid& g = volume.grid;
    std::string text = path + ": " + std::to_string(g.size.x) + "x" + std::to_string(g.size.y) +
                       "x" + std::to_string(g.size.z) + " voxels of " +
                       fixed_text(g.spacing_mm.x, 3) + " x " + fixed_text(g.spacing_mm.y, 3) +
                       " x " + fixed_text(g.spacing_mm.z, 3) + " mm\n";
    const KeyValues& pairs = volume.key_values;
    const std::string threshold = value_of(pairs, "bone_threshold_hu");
    const std::string iso = value_of(pairs, "iso_hu");
    if (!threshold.empty())
        text +=
            "Its values count as bone; to push it, add --config stiff.toml with\n"
            "  [material]\n  bone_threshold_hu = " +
            threshold + "\n";
    if (!iso.empty())
        text += "Its lumen is filled with contrast; to look inside: pliant render --iso " + iso +
                " --polarity " + value_of(pairs, "polarity") + "\n";
    for (const auto& [name, value] : pairs) {
        if (!name.starts_with("landmark ")) continue;
        const std::size_t eye = value.find(" eye "), look = value.find(" look ");
        text += "Push " + name.substr(9) + ":\n  pliant deform " + shell_word(path) + " --push \"" +
                value.substr(5, eye - 5) +
                "\" --tool sphere:4 --eye=" + value.substr(eye + 5, look - eye - 5) +
                " --look=" + value.substr(look + 6) + (iso.empty() ? "" : " --iso " + iso) +
                (threshold.empty() ? "" : " --config stiff.toml") +
                " --out pushed.nrrd --png pushed.png\n";
    }
    std::fputs(text.c_str(), stdout);
}

}  // namespace

int run_phantom(const PhantomOptions& options) {
    PhantomSettings settings;
    settings.name = options.name;
    settings.size = options.size;
    settings.spacing_mm = options.spacing_mm;
    if (options.direction) {
        const auto direction = parse_direction(*options.direction);
        if (!direction)
            return bad_input("--direction: found '" + *options.direction +
                             "', expected nine numbers, the i, j and k axes in LPS");
        settings.direction = *direction;
    }
    const TaskArena arena(options.threads);
    ProgressBar bar("making " + options.name);
    const auto phantom =
        make_phantom(settings, arena, [&](double fraction) { bar.show(0.95 * fraction); });
    if (!phantom.ok()) return bad_input(phantom.error().message);
    const Encoding encoding = options.raw ? Encoding::Raw : Encoding::Gzip;
    const Status written = write_volume(options.out, phantom->volume, encoding);
    if (!written.ok()) return bad_input(written.error().message);
    bar.show(1);
    std::error_code ignored;
    const auto whole = std::filesystem::absolute(options.out, ignored);
    tell(ignored ? options.out : whole.string(), phantom->volume);
    return kExitOk;
}

}  // namespace pliant::app
