// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include <pliant/scan_files.h>

#include "formats/dicom_series.h"

#include "base/errors.h"
#include "base/input_file.h"
#include "base/memory_budget.h"
#include "base/text.h"
#include "formats/dicom_folder.h"
#include "formats/dicom_pixels.h"
#include "formats/image_header.h"
#include "formats/voxel_builder.h"

#include <algorithm>
#include <utility>

namespace pliant {
namespace fs = std::filesystem;
namespace {

Status check_memory(const fs::path& folder, const Grid& grid) {
    if (has_memory_for(2 * std::uint64_t(voxel_count(grid)))) return Ok{};
    return Error{ErrorCode::LimitExceeded, folder.string() + ": not enough memory to read it"};
}

/// Refuses a choice between volumes of different shapes, with the size of each.
Status check_alike(const fs::path& path, const std::vector<std::vector<DicomSlice>>& volumes) {
    constexpr std::size_t kMaxNamed = 12;
    const DicomSlice& first = volumes.front().front();
    const auto other = std::find_if(volumes.begin(), volumes.end(), [&](const auto& volume) {
        return difference_of(first, volume.front());
    });
    if (other == volumes.end()) return Ok{};
    std::string sizes;
    for (std::size_t n = 0; n < std::min(volumes.size(), kMaxNamed); ++n) {
        const DicomSlice& slice = volumes[n].front();
        sizes += (n ? "; " : "") + std::to_string(n) + ": " + std::to_string(slice.columns) +
                 " × " + std::to_string(slice.rows) + " × " + std::to_string(volumes[n].size());
    }
    return Error{ErrorCode::InvalidArgument,
                 path.string() + ": " + first.name() + " and " + other->front().name() +
                     " differ in " + difference_of(first, other->front()) +
                     ", choose a volume with --frame 0…" + std::to_string(volumes.size() - 1) +
                     " (" + sizes + (volumes.size() > kMaxNamed ? "; …" : "") + " voxels)"};
}

/// Reads the pixels of a series.
Result<Volume> read_series(const fs::path& path, std::vector<DicomSlice> slices,
                           const ReadOptions& options, ReadNotes& notes,
                           const DecoderChoice& decoder) {
    const bool lacks_geometry = std::any_of(
        slices.begin(), slices.end(), [](const DicomSlice& slice) { return slice.lacks_geometry; });
    if (options.spacing_mm && !lacks_geometry)
        return Error{ErrorCode::InvalidArgument,
                     "--spacing: expected none for " + path.string() + ", which has its own"};
    if (lacks_geometry)
        if (Status s = place_in_order(path, slices, *options.spacing_mm, notes.notes); !s)
            return s.error();
    auto volumes = split_volumes(std::move(slices), notes.notes);
    if (volumes.size() == 1 && options.frame && *options.frame != 0)
        return Error{ErrorCode::InvalidArgument,
                     "--frame: found " + std::to_string(*options.frame) + ", expected none for " +
                         path.string() + ", which holds one image"};
    if (!options.frame)
        if (Status status = check_alike(path, volumes); !status) return status.error();
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
    notes.stored_type = (pixels.is_float()  ? "float"
                         : pixels.is_signed ? "int"
                                            : "uint") +
                        std::to_string(pixels.bits_allocated);
    for (const DicomSlice& slice : slices)
        if (slice.has_modality_lut) {
            notes.notes.push_back("the Modality LUT Sequence is not applied");
            break;
        }
    if (slices.front().is_parametric_map)
        notes.notes.push_back("the Real World Value Mapping Sequence is not applied");
    VoxelBuilder voxels(voxel_count(grid));
    DicomPixelReader reader(slices, decoder);
    const bool has_padding = std::any_of(slices.begin(), slices.end(), [](const DicomSlice& s) {
        return s.pixels.padding.has_value();
    });
    if (stack->irregular && has_padding) reader.collect_padding(&stack->irregular->padding);
    double done = 0;
    for (const DicomSlice& slice : slices) {
        if (Status status = go_on(path, options, done++ / double(slices.size())); !status)
            return status.error();
        if (Status status = reader.read(slice, voxels); !status) return status.error();
    }
    for (const std::string& note : reader.notes()) notes.notes.push_back(note);
    Volume volume{grid, voxels.finish(notes.notes), {}};
    if (!stack->irregular) return volume;
    return straightened(path, volume, *stack->irregular, options, notes.notes);
}

}  // namespace

Result<std::int64_t> count_dicom_volumes(const fs::path& path, const std::string& series) {
    const auto type = type_of(path);
    if (!type) return type.error();
    std::vector<std::string> ignored;
    const auto slices = [&]() -> Result<std::vector<DicomSlice>> {
        if (*type != fs::file_type::directory) return read_dicom_slices(path);
        auto found = read_dicom_headers(path);
        if (!found) return found.error();
        return choose_series(path, std::move(*found), series, ignored);
    }();
    if (!slices) return slices.error();
    if (!slices->empty() && slices->front().is_segmentation) return count_dicom_segments(path);
    return std::int64_t(split_volumes(*slices, ignored).size());
}

Result<Volume> read_dicom_folder(const fs::path& folder, const ReadOptions& options,
                                 ReadNotes& notes, const DecoderChoice& decoder) {
    auto found = read_dicom_headers(folder, options.spacing_mm.has_value());
    if (!found) return found.error();
    auto slices = choose_series(folder, std::move(*found), options.series_uid, notes.notes);
    if (!slices) return slices.error();
    return read_series(folder, std::move(*slices), options, notes, decoder);
}

Result<Volume> read_dicom_file(const fs::path& path, const ReadOptions& options, ReadNotes& notes,
                               const DecoderChoice& decoder) {
    if (is_dicomdir(path))
        return read_dicom_folder(folder_of_dicomdir(path), options, notes, decoder);
    auto read = read_dicom_slices(path, options.spacing_mm.has_value());
    if (!read) return read.error();
    std::vector<DicomSlice>& slices = *read;
    if (slices.empty())
        return Error{ErrorCode::Unsupported, path.string() + ": is DICOM without an image"};
    if (slices.front().is_segmentation) return read_dicom_segments(path, options, notes, decoder);
    if (slices.front().fault) return *slices.front().fault;
    if (slices.size() == 1)
        return Error{
            ErrorCode::Unsupported,
            path.string() + ": is a single DICOM slice, expected the folder of its series"};
    DicomFolder alone;
    alone.series[slices.front().series_uid].slices = std::move(slices);
    auto chosen = choose_series(path, std::move(alone), options.series_uid, notes.notes);
    if (!chosen) return chosen.error();
    return read_series(path, std::move(*chosen), options, notes, decoder);
}

}  // namespace pliant
