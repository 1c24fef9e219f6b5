// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Choice of the reader for a path: its name gives the expected format, its first bytes confirm it.

#include "base/errors.h"
#include "base/input_file.h"
#include "base/memory_budget.h"
#include "base/text.h"
#include "formats/data_check.h"
#include "formats/data_stream.h"
#include "formats/dicom_series.h"
#include "formats/image_file.h"
#include "formats/image_header.h"
#include "formats/segment_layers.h"
#include "formats/straighten.h"
#include "formats/voxel_builder.h"

#include <pliant/scan_files.h>
#include <pliant/volume.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <new>
#include <span>
#include <type_traits>

namespace pliant {
namespace fs = std::filesystem;

std::optional<ImageFormat> format_by_name(const fs::path& path) {
    const std::string name = lower_case(path.filename().string());
    if (name.ends_with(".nrrd") || name.ends_with(".nhdr")) return ImageFormat::Nrrd;
    if (name.ends_with(".mha") || name.ends_with(".mhd")) return ImageFormat::MetaImage;
    for (const char* ending : {".nii", ".nii.gz", ".hdr", ".hdr.gz"})
        if (name.ends_with(ending)) return ImageFormat::Nifti;
    if (name.ends_with(".vti")) return ImageFormat::Vti;
    if (name.ends_with(".vtk")) return ImageFormat::Vtk;
    return std::nullopt;
}

Status check_file(const fs::path& path) {
    const auto type = type_of(path);
    if (!type) return type.error();
    if (*type == fs::file_type::not_found)
        return Error{ErrorCode::NotFound, path.string() + ": no such file or folder"};
    if (*type != fs::file_type::regular)
        return Error{ErrorCode::Unsupported, path.string() + ": is neither a file nor a folder"};
    const InputFile file(path);
    if (Status status = file.status(); !status) return status;
    if (file.size() == 0) return unreadable(path, "is empty, expected an image");
    return Ok{};
}

namespace {

Result<std::string> first_bytes(const fs::path& path) {
    std::array<char, 512> bytes{};
    InputFile file(path);
    const std::size_t count = file.read(bytes.data(), bytes.size());
    if (Status status = file.status(); !status) return status.error();
    return std::string(bytes.data(), count);
}

Status check_first_bytes(const fs::path& path, ImageFormat format) {
    const auto read = first_bytes(path);
    if (!read) return read.error();
    const std::string& start = *read;
    bool fits = false;
    std::string expected;
    switch (format) {
        case ImageFormat::Nrrd:
            fits = start.starts_with("NRRD000");
            expected = "'NRRD000…'";
            break;
        case ImageFormat::MetaImage:
            fits = start.find("NDims") != start.npos || start.find("ObjectType") != start.npos;
            expected = "a header with ObjectType and NDims";
            break;
        case ImageFormat::Nifti: {
            fits = true;  // its header's size decides, which may be compressed
            break;
        }
        case ImageFormat::Vti:
            fits = start.find("<VTKFile") != start.npos;
            expected = "'<?xml' or '<VTKFile'";
            break;
        case ImageFormat::Vtk:
            fits = start.starts_with("# vtk DataFile");
            expected = "'# vtk DataFile'";
            break;
    }
    if (fits) return Ok{};
    return Error{ErrorCode::Unreadable, path.string() + ": is no " + std::string(name_of(format)) +
                                            " file: starts with '" + shown(start.substr(0, 8)) +
                                            "', expected " + expected};
}

/// Error for a file with an unknown extension.
Error unknown_name(const fs::path& path) {
    const auto read = first_bytes(path);
    if (!read) return read.error();
    const std::string& start = *read;
    const char* rename = start.starts_with("NRRD000")                          ? ".nrrd"
                         : start.find("NDims") != start.npos                   ? ".mha"
                         : start.size() > 347 && !start.compare(344, 3, "n+1") ? ".nii"
                         : start.find("type=\"ImageData\"") != start.npos      ? ".vti"
                                                                               : nullptr;
    const std::string known =
        ".nrrd, .nhdr, .mha, .mhd, .nii, .nii.gz, .hdr (of a NIfTI pair), .vti, .vtk, a DICOM file "
        "of several frames or a folder of DICOM slices";
    if (rename)
        return {ErrorCode::Unsupported,
                path.string() + ": expected a name that ends in " + rename + ", for what it holds"};
    return {ErrorCode::Unsupported,
            path.string() + ": is no scan that can be read, expected " + known};
}

}  // namespace

Result<ImageHeader> read_image_header(const fs::path& path, ImageFormat format) {
    if (Status status = check_first_bytes(path, format); !status) return status.error();
    switch (format) {
        case ImageFormat::Nrrd:
            return read_nrrd_header(path);
        case ImageFormat::MetaImage:
            return read_meta_header(path);
        case ImageFormat::Nifti:
            return read_nifti_header(path);
        case ImageFormat::Vti:
            return read_vti_header(path);
        case ImageFormat::Vtk:
            return read_vtk_header(path);
    }
    return unknown_name(path);
}

namespace {

/// VTK's files go on behind the voxels.
bool ends_with_data(ImageFormat format) {
    return format != ImageFormat::Vti && format != ImageFormat::Vtk;
}

/// The header may be wrong, or another file's.
constexpr const char* kLongerNote =
    "the data are longer than the header says; the rest was ignored";

/// Smaller scans are read: a mapping would cost more than it saves.
constexpr std::size_t kMinMappedBytes = 1 << 20;

/// Computes slope · number + intercept in double precision, rounded to a float if the number was an
/// integer or a float [NIfTI2007]. Integers are converted to floats first, as in ITK.
template <class T>
void rescale(const DataLocation& data, const std::vector<double>& piece, std::size_t count,
             VoxelBuilder& voxels, std::vector<double>& scaled) {
    using Out = std::conditional_t<std::is_same_v<T, double>, double, float>;
    const T* in = reinterpret_cast<const T*>(piece.data());
    Out* out = reinterpret_cast<Out*>(scaled.data());
    for (std::size_t n = 0; n < count; ++n)
        out[n] = Out(double(Out(in[n])) * data.slope + data.intercept);
    voxels.add(sizeof(Out) == 8 ? Component::Float64 : Component::Float32, out, count);
}

/// Adds a piece of stored numbers, with slope and intercept applied.
void add_rescaled(const ImageHeader& header, const std::vector<double>& piece, std::size_t count,
                  VoxelBuilder& voxels, std::vector<double>& scaled) {
    with_type(header.stored,
              [&]<class T>(T) { rescale<T>(header.data, piece, count, voxels, scaled); });
}

/// Stream of the numbers of one image in a file with one or several.
class FrameStream {
  public:
    FrameStream(const fs::path& path, const ImageHeader& header, std::int64_t frame)
        : m_stream(path, header),
          m_size(size_of(header.stored)),
          m_frames(std::size_t(header.components)),
          m_frame(std::size_t(frame)),
          m_run(std::size_t(header.data.voxels_before_component)) {}

    /// @param out  a whole number of voxels
    Status read(std::span<std::byte> out) {
        if (m_frames == 1) return m_stream.read(out);
        return m_run == 1 ? read_adjacent(out) : read_runs(out);
    }
    Status finish() { return m_stream.finish(); }
    bool is_longer() const { return m_stream.is_longer(); }

  private:
    /// The images' numbers of a voxel are adjacent.
    Status read_adjacent(std::span<std::byte> out) {
        constexpr std::size_t kMaxBytes = 1 << 20;
        const std::size_t voxel = m_frames * m_size;
        if (voxel > kMaxBytes) {
            for (std::size_t at = 0; at < out.size(); at += m_size) {
                if (Status s = m_stream.skip(m_frame * m_size); !s) return s;
                if (Status s = m_stream.read(out.subspan(at, m_size)); !s) return s;
                if (Status s = m_stream.skip((m_frames - m_frame - 1) * m_size); !s) return s;
            }
            return Ok{};
        }
        m_all.resize(std::max<std::size_t>(1, kMaxBytes / voxel) * voxel);
        while (!out.empty()) {
            const auto all =
                std::span(m_all).first(std::min(m_all.size() / voxel, out.size() / m_size) * voxel);
            if (Status s = m_stream.read(all); !s) return s;
            for (std::size_t at = m_frame * m_size; at < all.size(); at += voxel) {
                std::memcpy(out.data(), &all[at], m_size);
                out = out.subspan(m_size);
            }
        }
        return Ok{};
    }
    /// Runs of one image's numbers follow each other: a run of each image, and so on.
    Status read_runs(std::span<std::byte> out) {
        while (!out.empty()) {
            if (m_left == 0) {
                const std::size_t skipped = m_started ? m_frames - 1 : m_frame;
                if (Status s = m_stream.skip(skipped * m_run * m_size); !s) return s;
                m_left = m_run * m_size;
                m_started = true;
            }
            const std::size_t count = std::min(m_left, out.size());
            if (Status s = m_stream.read(out.first(count)); !s) return s;
            m_left -= count;
            out = out.subspan(count);
        }
        return Ok{};
    }

    DataStream m_stream;
    std::size_t m_size, m_frames, m_frame, m_run;
    std::size_t m_left = 0;  ///< bytes of the present run
    bool m_started = false;
    std::vector<std::byte> m_all;
};

/// Reads voxels piece by piece, without a second copy in memory.
Result<Voxels> stream_voxels(const fs::path& path, const ImageHeader& header,
                             const ReadOptions& options, ReadNotes& notes) {
    constexpr std::size_t kStreamedBytes = 1 << 18;
    const std::size_t size = size_of(header.stored), count = voxel_count(header.grid);
    if (!has_memory_for(count * sizeof(std::int16_t))) throw std::bad_alloc();
    VoxelBuilder voxels(count);
    FrameStream stream(path, header, options.frame.value_or(0));
    std::vector<double> piece(kStreamedBytes / sizeof(double));  // aligned for all types
    std::vector<double> scaled;
    if (header.data.rescaled) scaled.resize(kStreamedBytes / (size < 8 ? 2 : 1) / size);
    for (std::size_t done = 0; done < count;) {
        if (Status status = go_on(path, options, double(done) / double(count)); !status)
            return status.error();
        const std::size_t next = std::min(count - done, kStreamedBytes / size);
        const auto bytes = std::as_writable_bytes(std::span(piece)).first(next * size);
        if (Status status = stream.read(bytes); !status) return status.error();
        if (header.data.rescaled)
            add_rescaled(header, piece, next, voxels, scaled);
        else
            voxels.add(header.stored, piece.data(), next);
        done += next;
    }
    if (Status status = stream.finish(); !status) return status.error();
    if (stream.is_longer() && ends_with_data(header.format)) notes.notes.push_back(kLongerNote);
    return voxels.finish(notes.notes);
}

/// Maps the file's bytes if they have a volume's memory layout.
template <class T>
std::optional<VoxelArray<T>> map_voxels(const fs::path& path, const ImageHeader& header,
                                        std::int64_t frame) {
    const DataLocation& data = header.data;
    const std::size_t count = voxel_count(header.grid);
    if (data.encoding != DataEncoding::Raw || data.files.size() != 1 || data.swapped ||
        data.rescaled || (header.components > 1 && data.voxels_before_component != count))
        return std::nullopt;
    const auto start = find_data_start(path, header, data.files[0]);
    if (!start || count * sizeof(T) < kMinMappedBytes) return std::nullopt;
    return VoxelArray<T>::mapped(data.files[0], *start + std::uint64_t(frame) * count * sizeof(T),
                                 count);
}

Result<Voxels> read_voxels(const fs::path& path, const ImageHeader& header,
                           const ReadOptions& options, ReadNotes& notes) {
    if (!options.may_map) return stream_voxels(path, header, options, notes);
    const std::int64_t frame = options.frame.value_or(0);
    if (header.stored == Component::Int16)
        if (auto mapped = map_voxels<std::int16_t>(path, header, frame))
            return Voxels(std::move(*mapped));
    if (header.stored == Component::Float32)
        if (auto mapped = map_voxels<float>(path, header, frame); mapped && stay_floats(*mapped)) {
            make_finite(*mapped, notes.notes);
            return Voxels(std::move(*mapped));
        }
    return stream_voxels(path, header, options, notes);
}

Result<Volume> read_image_file(const fs::path& path, const ReadOptions& options, ReadNotes& notes) {
    const auto format = format_by_name(path);
    if (!format) {
        const auto is_dicom = looks_like_dicom(path);
        if (!is_dicom) return is_dicom.error();
        return *is_dicom ? read_dicom_file(path, options, notes) : unknown_name(path);
    }
    if (options.spacing_mm)
        return Error{ErrorCode::InvalidArgument,
                     "--spacing: expected none for " + path.string() + ", which has its own"};
    auto header = read_image_header(path, *format);
    if (!header) return header.error();
    if (Status status = check_header(path, 1, *header, options.straighten); !status)
        return status.error();
    if (Status status = check_frame(path, header->components, options.frame); !status)
        return status.error();
    if (Status status = check_data_files(path, header->data); !status) return status.error();
    if (Status status = check_data(path, *header); !status) return status.error();
    notes.format = name_of(*format);
    notes.stored_type = name_of(header->stored);
    notes.notes = std::move(header->notes);
    const bool leans = !is_perpendicular(header->grid.direction);
    if (!leans) note_lean(header->grid, notes.notes);
    const auto beyond = bytes_beyond(path, *header);
    if (!beyond) return beyond.error();
    if (*beyond > 0 && ends_with_data(*format)) notes.notes.push_back(kLongerNote);
    auto voxels = read_voxels(path, *header, options, notes);
    if (!voxels) return voxels.error();
    Volume volume{header->grid, std::move(*voxels), std::move(header->key_values)};
    keep_layer(volume.key_values, options.frame.value_or(0));
    if (!leans) return volume;
    notes.notes.push_back("the axes are sheared by " +
                          short_text(std::round(100 * shear_degrees(volume.grid)) / 100) +
                          " degrees");
    return straightened(path, volume, stack_of(volume.grid), options, notes.notes);
}

}  // namespace

Result<std::int64_t> count_images(const fs::path& path, const std::string& series) {
    const auto format = format_by_name(path);
    if (!format) return count_dicom_volumes(path, series);
    auto header = read_image_header(path, *format);
    if (!header) return header.error();
    if (Status status = check_header(path, 1, *header, true); !status) return status.error();
    return header->components;
}

Result<Volume> read_volume(const fs::path& path, const ReadOptions& options, ReadNotes* notes) {
    ReadNotes unused;
    ReadNotes& said = notes ? *notes : unused;
    said = {};
    try {
        const auto type = type_of(path);
        if (!type) return type.error();
        if (*type == fs::file_type::directory) return read_dicom_folder(path, options, said);
        if (Status status = check_file(path); !status) return status.error();
        return read_image_file(path, options, said);
    } catch (const std::bad_alloc&) {
        return Error{ErrorCode::LimitExceeded, path.string() + ": not enough memory to read it"};
    }
}

}  // namespace pliant
