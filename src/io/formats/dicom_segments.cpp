// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// DICOM segmentations and label maps as volumes of labels. A file has frames only where a segment
// is, so its slices may have gaps, which are empty:
//
//     height   0    1    2         5    6         segment 1 at 0…2, segment 2 at 5…6
//     slices   ▆    ▆    ▆    ░    ░    ▆    ▆    ░: without a frame, 0

#include "base/errors.h"
#include "base/memory_budget.h"
#include "base/text.h"
#include "formats/dicom_input.h"
#include "formats/dicom_pixels.h"
#include "formats/dicom_series.h"
#include "formats/image_header.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <utility>

namespace pliant {
namespace fs = std::filesystem;
namespace {

/// Maximum deviation of a frame from its slice, as a fraction of the slices' distance.
constexpr double kMaxFrameOffset = 0.1;

/// Grid of all slices, and the slice of each frame.
struct SegmentGrid {
    Grid grid;
    std::vector<std::int32_t> slices;
};

Result<SegmentGrid> grid_of(const fs::path& path, const std::vector<DicomSlice>& frames) {
    const DicomSlice& first = frames.front();
    for (const DicomSlice& frame : frames)
        if (const char* difference = difference_of(first, frame))
            return unsupported(path, "its frames " + std::to_string(first.frame) + " and " +
                                         std::to_string(frame.frame) + " differ in " + difference +
                                         ", expected one grid");
    SegmentGrid result;
    Grid& grid = result.grid;
    grid.direction = {{first.row, first.column, cross(first.row, first.column)}};
    if (!is_perpendicular(grid.direction))
        return unsupported(path, "Image Orientation (Patient) is (" + text_of(first.row) + "), (" +
                                     text_of(first.column) +
                                     "), expected perpendicular unit vectors");
    for (Vec3d& axis : grid.direction.columns) axis = normalized(axis);
    std::vector<double> heights;
    for (const DicomSlice& frame : frames)
        heights.push_back(dot(grid.direction.columns[2], frame.position - first.position));
    std::vector<double> sorted = heights;
    std::sort(sorted.begin(), sorted.end());
    double step = std::numeric_limits<double>::infinity();
    for (std::size_t n = 1; n < sorted.size(); ++n)
        if (const double gap = sorted[n] - sorted[n - 1]; gap >= kSameSliceMm)
            step = std::min(step, gap);
    const double height = sorted.back() - sorted.front();
    const double steps = std::isfinite(step) ? std::round(height / step) : 0;
    if (Status s =
            check_size(path, {first.columns, first.rows, std::int64_t(std::min(steps, 1e9)) + 1});
        !s)
        return s.error();
    if (steps > 0)
        step = height / steps;
    else
        step = first.thickness_mm >= kMinSpacingMm ? first.thickness_mm : 1;
    for (std::size_t n = 0; n < frames.size(); ++n) {
        const double slice = (heights[n] - sorted.front()) / step;
        const Vec3d aside =
            frames[n].position - first.position - heights[n] * grid.direction.columns[2];
        if (std::abs(slice - std::round(slice)) > kMaxFrameOffset ||
            norm(aside) > kMaxFrameOffset * std::min(first.spacing_mm.x, first.spacing_mm.y))
            return unsupported(path, "frame " + std::to_string(frames[n].frame) +
                                         " is beside the grid of the others, expected equally "
                                         "spaced slices");
        result.slices.push_back(std::int32_t(std::lround(slice)));
    }
    grid.size = {first.columns, first.rows, std::int32_t(steps) + 1};
    grid.spacing_mm = {first.spacing_mm.x, first.spacing_mm.y, step};
    grid.origin_mm = first.position + sorted.front() * grid.direction.columns[2];
    if (Status status = check_grid(path, grid); !status) return status.error();
    if (!has_memory_for(2 * std::uint64_t(voxel_count(grid))))
        return Error{ErrorCode::LimitExceeded, path.string() + ": not enough memory to read it"};
    return result;
}

std::string name_of(const DicomSegmentation& file, int number) {
    for (const DicomSegment& segment : file.segments)
        if (segment.number == number && !segment.label.empty())
            return std::to_string(number) + " (" + segment.label + ")";
    return std::to_string(number);
}

/// Segments and labels as 3D Slicer names them.
KeyValues names_of(const DicomSegmentation& file) {
    KeyValues pairs;
    for (std::size_t n = 0; n < file.segments.size(); ++n) {
        const std::string prefix = "Segment" + std::to_string(n) + "_";
        pairs.emplace_back(prefix + "LabelValue", std::to_string(file.segments[n].number));
        pairs.emplace_back(prefix + "Name", file.segments[n].label);
    }
    return pairs;
}

/// Numbers of the segments that have frames.
std::vector<int> numbers_of(const DicomSegmentation& file) {
    const std::set<int> numbers(file.frame_segments.begin(), file.frame_segments.end());
    return {numbers.begin(), numbers.end()};
}

/// Reads the bits of frames. @param only  number of the segment to read; 0: all
Result<VoxelArray<std::int16_t>> read_bits(const fs::path& path, const DicomSegmentation& file,
                                           const SegmentGrid& place, int only,
                                           const ReadOptions& options) {
    VoxelArray<std::int16_t> voxels(voxel_count(place.grid));
    const std::size_t pixels = std::size_t(place.grid.size.x) * std::size_t(place.grid.size.y);
    DicomInput input(path);
    if (const std::uint64_t start = file.frames.front().pixels.deflated_from)
        if (Status status = input.inflate_from(start); !status) return status.error();
    std::map<std::pair<int, int>, std::size_t> overlaps;
    std::vector<std::uint8_t> bytes;
    for (std::size_t n = 0; n < file.frames.size(); ++n) {
        if (Status status = go_on(path, options, double(n) / double(file.frames.size())); !status)
            return status.error();
        const int segment = file.frame_segments[n];
        if (only && segment != only) continue;
        const DicomPixels& frame = file.frames[n].pixels;
        bytes.resize(std::size_t(frame.parts.front().bytes));
        input.seek(frame.parts.front().start);
        if (input.read(bytes.data(), bytes.size()) != bytes.size())
            return input.fault("changed while it was read");
        std::int16_t* const out = voxels.data() + std::size_t(place.slices[n]) * pixels;
        for (std::size_t p = 0; p < pixels; ++p) {
            const std::size_t bit = std::size_t(frame.first_bit) + p;
            if (!(bytes[bit / 8] >> bit % 8 & 1)) continue;
            if (out[p] && out[p] != segment) ++overlaps[{out[p], segment}];
            out[p] = std::int16_t(segment);
        }
    }
    if (!overlaps.empty()) {
        const auto& [pair, count] = *overlaps.begin();
        return Error{ErrorCode::InvalidArgument,
                     path.string() + ": its segments " + name_of(file, pair.first) + " and " +
                         name_of(file, pair.second) + " overlap in " + std::to_string(count) +
                         " voxels, choose one of " + std::to_string(numbers_of(file).size()) +
                         " by pliant convert with --frame 0…" +
                         std::to_string(numbers_of(file).size() - 1)};
    }
    voxels.freeze();
    return voxels;
}

/// Reads the frames of a label map, and zeros between them.
Result<Voxels> read_labels(const fs::path& path, const DicomSegmentation& file,
                           const SegmentGrid& place, const ReadOptions& options, ReadNotes& notes,
                           const DecoderChoice& decoder) {
    std::map<std::int32_t, const DicomSlice*> frames;
    for (std::size_t n = 0; n < file.frames.size(); ++n)
        if (!frames.emplace(place.slices[n], &file.frames[n]).second)
            return unsupported(
                path, "two frames are at the same position: " + frames[place.slices[n]]->name() +
                          " and " + file.frames[n].name() + ", expected one");
    const std::size_t pixels = std::size_t(place.grid.size.x) * std::size_t(place.grid.size.y);
    const std::vector<std::int16_t> none(pixels);
    VoxelBuilder voxels(voxel_count(place.grid));
    DicomPixelReader reader(file.frames, decoder);
    for (std::int32_t k = 0; k < place.grid.size.z; ++k) {
        if (Status status = go_on(path, options, double(k) / place.grid.size.z); !status)
            return status.error();
        const auto frame = frames.find(k);
        if (frame == frames.end())
            voxels.add(Component::Int16, none.data(), pixels);
        else if (Status status = reader.read(*frame->second, voxels); !status)
            return status.error();
    }
    return voxels.finish(notes.notes);
}

}  // namespace

Result<std::int64_t> count_dicom_segments(const fs::path& path) {
    const auto file = read_dicom_segmentation(path);
    if (!file) return file.error();
    return file->is_label_map ? 1 : std::int64_t(numbers_of(*file).size());
}

Result<Volume> read_dicom_segments(const fs::path& path, const ReadOptions& options,
                                   ReadNotes& notes, const DecoderChoice& decoder) {
    const auto file = read_dicom_segmentation(path);
    if (!file) return file.error();
    const std::vector<int> numbers = numbers_of(*file);
    if (!numbers.empty() && numbers.back() > std::numeric_limits<std::int16_t>::max())
        return unsupported(path, "has a segment " + std::to_string(numbers.back()) +
                                     ", expected numbers up to 32767");
    if (options.frame)
        if (Status status = check_frame(
                path, std::int64_t(std::max<std::size_t>(1, numbers.size())), options.frame);
            !status)
            return status.error();
    const auto place = grid_of(path, file->frames);
    if (!place) return place.error();
    notes.format = "DICOM";
    notes.modality = "SEG";
    notes.stored_type = "uint" + std::to_string(file->frames.front().pixels.bits_allocated);
    if (file->is_label_map) {
        auto labels = read_labels(path, *file, *place, options, notes, decoder);
        if (!labels) return labels.error();
        return Volume{place->grid, std::move(*labels), names_of(*file)};
    }
    const int only = options.frame ? numbers[std::size_t(*options.frame)] : 0;
    auto voxels = read_bits(path, *file, *place, only, options);
    if (!voxels) return voxels.error();
    return Volume{place->grid, std::move(*voxels), names_of(*file)};
}

}  // namespace pliant
