// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Displacement fields and grid transforms: NRRD, NIfTI or MetaImage with three numbers per voxel.

#include "base/errors.h"
#include "base/memory_budget.h"
#include "formats/data_check.h"
#include "formats/data_stream.h"
#include "formats/image_file.h"

#include <pliant/scan_files.h>
#include <pliant/volume.h>

#include <algorithm>
#include <cmath>
#include <new>
#include <span>
#include <vector>

namespace pliant {
namespace fs = std::filesystem;
namespace {

Result<ImageHeader> read_field_header(const fs::path& path) {
    if (Status status = check_file(path); !status) return status.error();
    const auto format = format_by_name(path);
    if (format != ImageFormat::Nrrd && format != ImageFormat::Nifti &&
        format != ImageFormat::MetaImage)
        return unsupported(path,
                           "expected a vector field in NRRD (.nrrd or .nhdr), NIfTI (.nii or "
                           ".nii.gz) or MetaImage (.mha or .mhd)");
    auto header = read_image_header(path, *format);
    if (!header) return header.error();
    if (Status status = check_header(path, 3, *header); !status) return status.error();
    if (header->stored != Component::Float32 && header->stored != Component::Float64)
        return unsupported(path, "type is " + std::string(name_of(header->stored)) +
                                     ", expected vectors of float or double");
    if (header->turned_vectors)
        return unsupported(path, "has a measurement frame, expected vectors along its space");
    if (Status status = check_data_files(path, header->data); !status) return status.error();
    if (Status status = check_data(path, *header); !status) return status.error();
    return header;
}

FieldKind kind_of(const ImageHeader& header) {
    for (const auto& [key, value] : header.key_values)
        if (key == "displacement field type" && value == "modeling") return FieldKind::Modeling;
    return FieldKind::Resampling;
}

}  // namespace

namespace {

/// Reads a field's numbers in the file's order, and stores each at its position.
/// @param[out] numbers  three adjacent numbers per voxel
template <class Number>
Status read_numbers(const fs::path& path, const ImageHeader& header, std::span<float> numbers) {
    constexpr std::size_t kPieceNumbers = 1 << 16;
    const auto run = std::size_t(header.data.voxels_before_component);
    DataStream stream(path, header);
    std::vector<Number> piece(std::min(kPieceNumbers, numbers.size()));
    for (std::size_t done = 0; done < numbers.size();) {
        const std::size_t count = std::min(piece.size(), numbers.size() - done);
        const std::span<Number> some(piece.data(), count);
        if (Status status = stream.read(std::as_writable_bytes(some)); !status) return status;
        if (run == 1) {
            std::transform(some.begin(), some.end(), &numbers[done],
                           [](Number number) { return float(number); });
            done += count;
            continue;
        }
        for (std::size_t n = 0; n < count; ++n, ++done) {
            // Blocks of three runs, one per component.
            const std::size_t block = done / (3 * run), in_block = done % (3 * run);
            const std::size_t c = in_block / run, v = in_block % run;
            numbers[3 * (block * run + v) + c] = float(some[n]);
        }
    }
    return stream.finish();
}

}  // namespace

Result<VectorField> read_vector_field(const fs::path& path) {
    try {
        const auto header = read_field_header(path);
        if (!header) return header.error();
        VectorField field{header->grid, kind_of(*header), {}};
        if (!has_memory_for(voxel_count(field.grid) * sizeof(Vec3f))) throw std::bad_alloc();
        field.vectors_mm.resize(voxel_count(field.grid));
        static_assert(sizeof(Vec3f) == 3 * sizeof(float));
        const std::size_t count = 3 * field.vectors_mm.size();
        const std::span numbers(reinterpret_cast<float*>(field.vectors_mm.data()), count);
        const Status status = header->stored == Component::Float32
                                  ? read_numbers<float>(path, *header, numbers)
                                  : read_numbers<double>(path, *header, numbers);
        if (!status) return status.error();
        bool finite = true;
        for (Vec3f& vector : field.vectors_mm)
            for (int a = 0; a < 3; ++a) {
                vector[a] *= float(header->vector_sign[a]);
                finite = finite && std::isfinite(vector[a]);
            }
        if (!finite)
            return Error{ErrorCode::Unreadable, path.string() +
                                                    ": has a vector that is no number, "
                                                    "expected finite ones"};
        return field;
    } catch (const std::bad_alloc&) {
        return Error{ErrorCode::LimitExceeded, path.string() + ": not enough memory to read it"};
    }
}

}  // namespace pliant
