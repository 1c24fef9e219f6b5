// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "formats/dicom_folder.h"

#include "base/errors.h"
#include "base/input_file.h"
#include "base/text.h"

#include <utility>

namespace pliant {
namespace fs = std::filesystem;
namespace {

/// Limits of the search in folders of folders.
constexpr int kMaxFolderDepth = 12;
constexpr std::size_t kMaxFilesSearched = 200'000;

void add_slice(DicomSlice slice, DicomFolder& found) {
    if (slice.series_uid.empty()) return found.strays.push_back(std::move(slice));
    SeriesFiles& series = found.series[slice.series_uid];
    if (!series.fault) series.fault = slice.fault;
    series.slices.push_back(std::move(slice));
}

/// Files and folders of a folder, by name.
struct FolderEntries {
    std::vector<fs::path> files, folders;
    std::size_t others = 0, linked_folders = 0;
};

/// A file that can't be opened or read may be a slice, so a scan without it may be wrong.
Error may_be_slice(Error error) {
    error.message += "; it may be a slice: make it readable, or move it out of the folder";
    return error;
}

Result<FolderEntries> list_folder(const fs::path& folder) {
    const auto names = names_in(folder);
    if (!names) return names.error();
    FolderEntries entries;
    for (const std::string& name : *names) {
        const fs::path path = folder / name;
        const auto type = type_of(path);
        if (is_dicomdir(path) && !(type && *type == fs::file_type::directory)) continue;
        if (!type) return may_be_slice(type.error());
        if (*type == fs::file_type::not_found)
            return may_be_slice(unreadable(path, "is a link to a file that isn't there"));
        std::error_code error;
        if (*type == fs::file_type::regular)
            entries.files.push_back(path);
        else if (*type != fs::file_type::directory)
            ++entries.others;
        else if (fs::is_symlink(path, error))  // it may lead out of the folder, or back into it
            ++entries.linked_folders;
        else
            entries.folders.push_back(path);
    }
    return entries;
}

/// Files below some folders, folder by folder.
/// @returns LimitExceeded if there are too many
Result<std::vector<fs::path>> files_below(const fs::path& folder,
                                          const std::vector<fs::path>& folders,
                                          DicomFolder& found) {
    std::vector<fs::path> files;
    std::vector<std::pair<fs::path, int>> open;
    for (auto at = folders.rbegin(); at != folders.rend(); ++at) open.emplace_back(*at, 1);
    for (std::size_t visited = 0; !open.empty(); ++visited) {
        const auto [path, depth] = open.back();
        open.pop_back();
        auto entries = list_folder(path);
        if (!entries) return entries.error();
        found.others += entries->others;
        found.linked_folders += entries->linked_folders;
        files.insert(files.end(), entries->files.begin(), entries->files.end());
        if (files.size() + visited > kMaxFilesSearched)
            return Error{ErrorCode::LimitExceeded,
                         folder.string() + ": holds more than " +
                             std::to_string(kMaxFilesSearched) +
                             " files in folders, expected the folder of a series"};
        if (depth == kMaxFolderDepth) continue;
        for (auto at = entries->folders.rbegin(); at != entries->folders.rend(); ++at)
            open.emplace_back(*at, depth + 1);
    }
    return files;
}

Error no_images(const fs::path& folder, const DicomFolder& found) {
    std::string text = folder.string() + ": holds no DICOM images (" +
                       counted(found.others, "file", "files") + " looked at";
    if (found.went_deeper) text += ", in folders below it too";
    if (found.linked_folders)
        text += "; " + counted(found.linked_folders, "link", "links") + " to folders not followed";
    return {ErrorCode::NotFound, text + ")"};
}

}  // namespace

bool is_dicomdir(const fs::path& file) {
    return lower_case(file.filename().string()) == "dicomdir";
}

fs::path folder_of_dicomdir(const fs::path& file) {
    const fs::path folder = file.parent_path();
    return folder.empty() ? fs::path(".") : folder;
}

std::string counted(std::size_t count, const char* one, const char* several) {
    return std::to_string(count) + " " + (count == 1 ? one : several);
}

Result<DicomFolder> read_dicom_headers(const fs::path& folder, bool may_lack_geometry) {
    auto entries = list_folder(folder);
    if (!entries) return entries.error();
    DicomFolder found;
    found.others = entries->others;
    found.linked_folders = entries->linked_folders;
    const auto look_at = [&](const std::vector<fs::path>& files) -> Status {
        for (const fs::path& file : files) {
            auto slices = read_dicom_slices(file, may_lack_geometry);
            if (!slices) return may_be_slice(slices.error());
            if (slices->empty()) ++found.others;
            for (DicomSlice& slice : *slices) add_slice(std::move(slice), found);
        }
        return Ok{};
    };
    if (Status status = look_at(entries->files); !status) return status.error();
    if (!found.is_empty()) return found;
    if (entries->folders.empty()) return no_images(folder, found);
    const auto deeper = files_below(folder, entries->folders, found);
    if (!deeper) return deeper.error();
    found.went_deeper = true;
    if (Status status = look_at(*deeper); !status) return status.error();
    if (found.is_empty()) return no_images(folder, found);
    return found;
}

}  // namespace pliant
