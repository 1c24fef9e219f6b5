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
void add_paths_near(const fs::path& folder, std::vector<fs::path>& paths) {
    for (const char* way :
         {".", "bin", "../libexec/pliant", "../lib/pliant", "../../libexec/pliant"}) {
        const fs::path path = (folder / way / kDecoderName).lexically_normal();
        if (std::find(paths.begin(), paths.end(), path) == paths.end()) paths.push_back(path);
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

std::vector<fs::path> decoder_paths() {
    std::vector<fs::path> paths;
    std::error_code error;
    const fs::path program = fs::read_symlink("/proc/self/exe", error);
    if (!error && program.is_absolute()) add_paths_near(program.parent_path(), paths);
    if (const fs::path library = folder_of_library(); !library.empty())
        add_paths_near(library, paths);
    const fs::path installed = fs::path(PLIANT_DECODER_FOLDER) / kDecoderName;
    if (std::find(paths.begin(), paths.end(), installed) == paths.end()) paths.push_back(installed);
    return paths;
}

Result<fs::path> find_pixel_decoder(const std::vector<fs::path>& paths) {
    std::string list;
    for (const fs::path& path : paths) {
        if (is_own_program(path)) return path;
        list += (list.empty() ? "" : ", ") + path.parent_path().string();
    }
    return Error{ErrorCode::NotFound, "the program " + std::string(kDecoderName) +
                                          " that decodes them is missing (looked for in " + list +
                                          ")"};
}

}  // namespace pliant
