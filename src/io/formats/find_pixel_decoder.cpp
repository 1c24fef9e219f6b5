// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "formats/pixel_decoder.h"

#include <dlfcn.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <system_error>

namespace pliant {
namespace fs = std::filesystem;
namespace {

/// Adds the folder of a program or library, and an installation's locations relative to bin, lib,
/// lib/ARCHITECTURE or the folder of the Python module.
void add_places_near(const fs::path& folder, std::vector<fs::path>& positions) {
    for (const char* way :
         {".", "bin", "../libexec/pliant", "../lib/pliant", "../../libexec/pliant"}) {
        const fs::path place = (folder / way / kDecoderName).lexically_normal();
        if (std::find(positions.begin(), positions.end(), place) == positions.end())
            positions.push_back(place);
    }
}

/// Folder of the program or shared library that contains this function.
fs::path folder_of_library() {
    static const char here = 0;
    Dl_info info{};
    if (!::dladdr(&here, &info) || !info.dli_fname) return {};
    std::error_code error;
    const fs::path file = fs::canonical(info.dli_fname, error);
    return error ? fs::path() : file.parent_path();
}

/// Whether a program exists, is executable, and belongs to this user or root. Folders above may be
/// world-writable.
bool is_own_program(const fs::path& file) {
    struct stat info {};
    if (::stat(file.c_str(), &info) != 0 || !S_ISREG(info.st_mode)) return false;
    const bool trusted = info.st_uid == 0 || info.st_uid == ::geteuid();
    return trusted && !(info.st_mode & S_IWOTH) && ::access(file.c_str(), X_OK) == 0;
}

}  // namespace

std::vector<fs::path> decoder_places() {
    std::vector<fs::path> positions;
    std::error_code error;
    const fs::path program = fs::read_symlink("/proc/self/exe", error);
    if (!error && program.is_absolute()) add_places_near(program.parent_path(), positions);
    if (const fs::path library = folder_of_library(); !library.empty())
        add_places_near(library, positions);
    const fs::path installed = fs::path(PLIANT_DECODER_FOLDER) / kDecoderName;
    if (std::find(positions.begin(), positions.end(), installed) == positions.end())
        positions.push_back(installed);
    return positions;
}

Result<fs::path> find_pixel_decoder(const std::vector<fs::path>& positions) {
    std::string list;
    for (const fs::path& place : positions) {
        if (is_own_program(place)) return place;
        list += (list.empty() ? "" : ", ") + place.parent_path().string();
    }
    return Error{ErrorCode::NotFound, "the program " + std::string(kDecoderName) +
                                          " that decodes them is missing (looked for in " + list +
                                          ")"};
}

}  // namespace pliant
