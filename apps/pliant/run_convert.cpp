// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A scan in another format.

#include <pliant/core/files.h>
#include <pliant/scan_files.h>
#include <pliant/volume.h>

#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>

#include "options.h"
#include "output_names.h"
#include "progress.h"

namespace pliant::app {
namespace {

void tell(const ConvertOptions& o, const Volume& volume, const ReadNotes& notes) {
    const Vec3i size = volume.grid.size;
    const char* type = volume.is_16_bit() ? "int16" : "float32";
    if (o.json) {
        const nlohmann::ordered_json report = {{"file", o.out},
                                               {"size", {size.x, size.y, size.z}},
                                               {"voxel_type", type},
                                               {"notes", notes.notes}};
        std::printf("%s\n",
                    report.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace).c_str());
        return;
    }
    std::printf("%s: %d x %d x %d voxels of %s, from %s\n", printable(o.out, 300).c_str(), size.x,
                size.y, size.z, type, notes.format.c_str());
    for (const std::string& note : notes.notes)
        std::printf("note: %s\n", printable(note, 300).c_str());
}

}  // namespace

int run_convert(const ConvertOptions& o) {
    if (const Status s = check_volume_name("OUT", o.out); !s) return bad_input(s.error());
    std::optional<ProgressBar> bar(std::in_place, "convert");
    ReadNotes notes;
    const auto volume = read_volume(o.file, o.scan.options(), &notes);
    if (!volume) {
        bar.reset();
        return bad_input(volume.error());
    }
    bar->show(0.5);
    const Status written = write_volume(o.out, *volume, o.raw ? Encoding::Raw : Encoding::Gzip);
    bar.reset();
    if (!written) return bad_input(written.error());
    tell(o, *volume, notes);
    return kExitOk;
}

}  // namespace pliant::app
