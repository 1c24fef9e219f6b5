// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include <pliant/scan_files.h>

#include "formats/dicom_series.h"

#include "base/errors.h"
#include "base/input_file.h"
#include "base/memory_budget.h"
#include "base/text.h"
#include "formats/dicom_pixels.h"
#include "formats/image_header.h"
#include "formats/voxel_builder.h"

#include <algorithm>
#include <map>
#include <numeric>
#include <utility>

namespace pliant {
namespace fs = std::filesystem;
namespace {

/// "1 file", "2 files"
std::string counted(std::size_t count, const char* noun) {
    return std::to_string(count) + " " + noun + (count == 1 ? "" : "s");
}

struct SeriesFiles {
    std::vector<DicomSlice> slices;
    std::optional<Error> fault;  ///< the first fault of its slices
};

/// Limits of the search in folders of folders.
constexpr int kMaxFolderDepth = 12;
constexpr std::size_t kMaxFilesSearched = 200'000;

/// Maximum length of an UID; longer ones are cut off in lists.
constexpr std::size_t kMaxUidBytes = 64;

/// Contents of a folder.
struct DicomFolder {
    std::map<std::string, SeriesFiles> series;
    std::vector<DicomSlice> strays;  ///< damaged before the series' UID
    std::size_t others = 0, linked_folders = 0;
    bool went_deeper = false;  ///< its folders were searched too

    bool is_empty() const { return series.empty() && strays.empty(); }
};

bool is_dicomdir(const fs::path& file) {
    return lower_case(file.filename().string()) == "dicomdir";
}

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

/// Looks into a folder, and below it if it has no slice.
Result<DicomFolder> read_headers(const fs::path& folder) {
    auto entries = list_folder(folder);
    if (!entries) return entries.error();
    DicomFolder found;
    found.others = entries->others;
    found.linked_folders = entries->linked_folders;
    const auto look_at = [&](const std::vector<fs::path>& files) -> Status {
        for (const fs::path& file : files) {
            auto slices = read_dicom_slices(file);
            if (!slices) return may_be_slice(slices.error());
            if (slices->empty()) ++found.others;
            for (DicomSlice& slice : *slices) add_slice(std::move(slice), found);
        }
        return Ok{};
    };
    if (Status status = look_at(entries->files); !status) return status.error();
    if (!found.is_empty() || entries->folders.empty()) return found;
    const auto deeper = files_below(folder, entries->folders, found);
    if (!deeper) return deeper.error();
    found.went_deeper = true;
    if (Status status = look_at(*deeper); !status) return status.error();
    return found;
}

Error no_images(const fs::path& folder, const DicomFolder& found) {
    std::string text = folder.string() + ": holds no DICOM images (" +
                       counted(found.others, "file") + " looked at";
    if (found.went_deeper) text += ", in folders below it too";
    if (found.linked_folders)
        text += "; " + counted(found.linked_folders, "link") + " to folders not followed";
    return {ErrorCode::NotFound, text + ")"};
}

/// First description in the files of the series.
std::string description_of(const SeriesFiles& series) {
    for (const DicomSlice& slice : series.slices)
        if (!slice.description.empty()) return slice.description;
    return {};
}

/// UIDs of the usable series, or of all if none is usable.
std::vector<std::string> usable_series(const DicomFolder& folder) {
    std::vector<std::string> usable, all;
    for (const auto& [uid, series] : folder.series) {
        all.push_back(uid);
        if (!series.fault) usable.push_back(uid);
    }
    return usable.empty() ? all : usable;
}

std::string list_of(const DicomFolder& folder) {
    std::string list;
    for (const auto& [uid, series] : folder.series) {
        list += (list.empty() ? "" : "; ") + printable(uid, kMaxUidBytes) + " (" +
                counted(series.slices.size(), "slice");
        if (const std::string text = description_of(series); !text.empty()) list += ", " + text;
        list += ")";
    }
    return list;
}

void note_left_out(const DicomFolder& folder, const std::string& chosen,
                   std::vector<std::string>& notes) {
    if (folder.went_deeper)
        notes.push_back("the folder has no slices itself; found in folders below it");
    if (folder.others)
        notes.push_back(counted(folder.others, "file") + " of the folder left out: no DICOM image");
    if (folder.linked_folders && folder.went_deeper)
        notes.push_back(counted(folder.linked_folders, "link") + " to folders not followed");
    for (const auto& [uid, series] : folder.series)
        if (uid != chosen && series.fault)
            notes.push_back("the series " + shown(uid) + " left out: " + series.fault->message);
    if (!folder.strays.empty())
        notes.push_back(counted(folder.strays.size(), "file") +
                        " of the folder left out: " + folder.strays.front().fault->message);
}

/// @returns an error that lists the series if the choice is ambiguous
Result<std::vector<DicomSlice>> choose_series(const fs::path& path, DicomFolder folder,
                                              const std::string& wanted,
                                              std::vector<std::string>& notes) {
    std::string uid = wanted;
    if (wanted.empty()) {
        const std::vector<std::string> usable = usable_series(folder);
        if (usable.size() > 1)
            return Error{ErrorCode::InvalidArgument,
                         path.string() + ": holds " + std::to_string(folder.series.size()) +
                             " series, choose one with --series: " + list_of(folder)};
        // It may be a slice of that series.
        if (!folder.strays.empty()) return *folder.strays.front().fault;
        uid = usable.front();
    }
    const auto found = folder.series.find(uid);
    if (found == folder.series.end()) {
        if (folder.series.empty()) return *folder.strays.front().fault;
        return Error{ErrorCode::NotFound, path.string() + ": has no series " + shown(uid) +
                                              ", expected --series with " + list_of(folder)};
    }
    if (found->second.fault) return *found->second.fault;
    note_left_out(folder, uid, notes);
    return std::move(found->second.slices);
}

Status check_memory(const fs::path& folder, const Grid& grid) {
    if (has_memory_for(2 * std::uint64_t(voxel_count(grid)))) return Ok{};
    return Error{ErrorCode::LimitExceeded, folder.string() + ": not enough memory to read it"};
}

/// Reads the pixels of a series.
Result<Volume> read_series(const fs::path& path, std::vector<DicomSlice> slices,
                           const ReadOptions& options, ReadNotes& notes,
                           const DecoderChoice& decoder) {
    auto volumes = split_volumes(std::move(slices));
    if (volumes.size() == 1 && options.frame && *options.frame != 0)
        return Error{ErrorCode::InvalidArgument,
                     "--frame: found " + std::to_string(*options.frame) + ", expected none for " +
                         path.string() + ", which holds one image"};
    if (Status status = check_frame(path, std::int64_t(volumes.size()), options.frame); !status)
        return status.error();
    slices = std::move(volumes[std::size_t(options.frame.value_or(0))]);
    if (slices.size() > 1 && slices.front().is_spaced_by_thickness)
        notes.notes.push_back("the frames' thickness of " +
                              short_text(slices.front().thickness_mm) +
                              " mm is taken as their distance");
    auto stack = stack_slices(path, slices, options.straighten, notes.notes);
    if (!stack) return stack.error();
    const Grid& grid = stack->grid;
    if (Status status = check_size(path, {grid.size.x, grid.size.y, grid.size.z}); !status)
        return status.error();
    if (Status status = check_memory(path, grid); !status) return status.error();
    notes.format = "DICOM";
    notes.modality = slices.front().modality;
    notes.rescale_type = slices.front().rescale_type;
    notes.is_rescaled = std::any_of(slices.begin(), slices.end(), [](const DicomSlice& s) {
        return s.slope != 1 || s.intercept != 0;
    });
    notes.window = slices[slices.size() / 2].window;
    notes.level = slices[slices.size() / 2].level;
    const DicomPixels& pixels = slices.front().pixels;
    notes.stored_type = (pixels.is_signed ? "int" : "uint") + std::to_string(pixels.bits_allocated);
    for (const DicomSlice& slice : slices)
        if (slice.has_modality_lut) {
            notes.notes.push_back("the Modality LUT Sequence is not applied");
            break;
        }
    VoxelBuilder voxels(voxel_count(grid));
    DicomPixelReader reader(slices, decoder);
    double done = 0;
    for (const DicomSlice& slice : slices) {
        if (Status status = go_on(path, options, done++ / double(slices.size())); !status)
            return status.error();
        if (Status status = reader.read(slice, voxels); !status) return status.error();
    }
    Volume volume{grid, voxels.finish(notes.notes), {}};
    if (!stack->irregular) return volume;
    return straightened(path, volume, *stack->irregular, options, notes.notes);
}

/// Numbers the different heights along the common normal. @returns one number for each slice
std::vector<std::size_t> positions_of(const std::vector<DicomSlice>& slices) {
    const Vec3d normal = cross(slices.front().row, slices.front().column);
    std::vector<double> heights;
    for (const DicomSlice& slice : slices) heights.push_back(dot(slice.position, normal));
    std::vector<std::size_t> order(slices.size()), positions(slices.size());
    std::iota(order.begin(), order.end(), std::size_t(0));
    std::stable_sort(order.begin(), order.end(),
                     [&](std::size_t a, std::size_t b) { return heights[a] < heights[b]; });
    for (std::size_t n = 1; n < order.size(); ++n)
        positions[order[n]] = positions[order[n - 1]] +
                              (heights[order[n]] - heights[order[n - 1]] >= kSameSliceMm ? 1 : 0);
    return positions;
}

bool have_same_axes(const std::vector<DicomSlice>& slices) {
    const DicomSlice& first = slices.front();
    return std::all_of(slices.begin(), slices.end(), [&](const DicomSlice& s) {
        return norm(s.row - first.row) <= kSameSliceAxes &&
               norm(s.column - first.column) <= kSameSliceAxes;
    });
}

/// Whether a number differs between slices at the same position.
bool counts_volumes(std::size_t number, const std::vector<DicomSlice>& slices,
                    const std::vector<std::size_t>& positions) {
    std::map<std::size_t, std::uint32_t> first;
    for (std::size_t n = 0; n < slices.size(); ++n) {
        const std::uint32_t own = slices[n].numbers[number];
        if (first.emplace(positions[n], own).first->second != own) return true;
    }
    return false;
}

}  // namespace

Result<std::vector<DicomSeries>> list_series(const fs::path& folder) {
    auto found = read_headers(folder);
    if (!found) return found.error();
    std::vector<DicomSeries> list;
    for (const std::string& uid : usable_series(*found)) {
        const SeriesFiles& series = found->series[uid];
        list.push_back({uid, description_of(series), int(series.slices.size())});
    }
    return list;
}

Result<std::int64_t> count_dicom_volumes(const fs::path& path, const std::string& series) {
    const auto type = type_of(path);
    if (!type) return type.error();
    const auto slices = [&]() -> Result<std::vector<DicomSlice>> {
        if (*type != fs::file_type::directory) return read_dicom_slices(path);
        auto found = read_headers(path);
        if (!found) return found.error();
        std::vector<std::string> ignored;
        if (found->is_empty()) return no_images(path, *found);
        return choose_series(path, std::move(*found), series, ignored);
    }();
    if (!slices) return slices.error();
    return std::int64_t(split_volumes(*slices).size());
}

Result<Volume> read_dicom_folder(const fs::path& folder, const ReadOptions& options,
                                 ReadNotes& notes, const DecoderChoice& decoder) {
    auto found = read_headers(folder);
    if (!found) return found.error();
    if (found->is_empty()) return no_images(folder, *found);
    auto slices = choose_series(folder, std::move(*found), options.series_uid, notes.notes);
    if (!slices) return slices.error();
    return read_series(folder, std::move(*slices), options, notes, decoder);
}

Result<Volume> read_dicom_file(const fs::path& path, const ReadOptions& options, ReadNotes& notes,
                               const DecoderChoice& decoder) {
    if (is_dicomdir(path)) {
        const fs::path folder = path.parent_path();
        return read_dicom_folder(folder.empty() ? fs::path(".") : folder, options, notes, decoder);
    }
    auto read = read_dicom_slices(path);
    if (!read) return read.error();
    std::vector<DicomSlice>& slices = *read;
    if (slices.empty())
        return Error{ErrorCode::Unsupported, path.string() + ": is DICOM without an image"};
    if (slices.front().fault) return *slices.front().fault;
    if (slices.size() == 1)
        return Error{
            ErrorCode::Unsupported,
            path.string() + ": is a single DICOM slice, expected the folder of its series"};
    if (!options.series_uid.empty() && options.series_uid != slices.front().series_uid)
        return Error{ErrorCode::NotFound, path.string() + ": has no series " +
                                              shown(options.series_uid) + ", expected --series " +
                                              shown(slices.front().series_uid)};
    return read_series(path, std::move(slices), options, notes, decoder);
}

// A file of several frames may hold a series of volumes, such as points in time. Its frames then
// have numbers, the Temporal Position Index and the Dimension Index Values. Numbers that are equal
// for all frames at the same position count positions or stacks; the others count volumes:
//
//     position    0 mm     2 mm     4 mm
//     numbers     1 1 1    1 2 1    1 3 1      the second number counts positions,
//                 2 1 1    2 2 1    2 3 1      the first one volumes

std::vector<std::vector<DicomSlice>> split_volumes(std::vector<DicomSlice> slices) {
    const auto whole = [&] {
        std::vector<std::vector<DicomSlice>> one;
        one.push_back(std::move(slices));
        return one;
    };
    if (slices.size() < 2) return whole();
    const std::size_t count = slices.front().numbers.size();
    for (const DicomSlice& slice : slices)
        if (slice.numbers.size() != count) return whole();
    if (count == 0 || !have_same_axes(slices)) return whole();
    const std::vector<std::size_t> positions = positions_of(slices);
    std::vector<std::size_t> kept;
    for (std::size_t number = 0; number < count; ++number)
        if (counts_volumes(number, slices, positions)) kept.push_back(number);
    std::map<std::vector<std::uint32_t>, std::vector<std::size_t>> volumes;
    for (std::size_t n = 0; n < slices.size(); ++n) {
        std::vector<std::uint32_t> key;
        for (const std::size_t number : kept) key.push_back(slices[n].numbers[number]);
        volumes[key].push_back(n);
    }
    for (const auto& [key, members] : volumes) {
        std::vector<std::size_t> own;
        for (const std::size_t n : members) own.push_back(positions[n]);
        std::sort(own.begin(), own.end());
        if (std::adjacent_find(own.begin(), own.end()) != own.end()) return whole();
    }
    std::vector<std::vector<DicomSlice>> split;
    for (const auto& [key, members] : volumes)
        for (auto& volume = split.emplace_back(); const std::size_t n : members)
            volume.push_back(std::move(slices[n]));
    return split;
}

}  // namespace pliant
