// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Displacement fields and grid transforms: NRRD with three numbers per voxel.

#include "core/errors.h"
#include "volume/data_check.h"
#include "volume/data_stream.h"
#include "volume/image_file.h"
#include "volume/itk_io.h"

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
    if (format_by_name(path) != ImageFormat::Nrrd)
        return unsupported(path, "expected a vector field in NRRD (.nrrd or .nhdr)");
    auto header = read_image_header(path, ImageFormat::Nrrd);
    if (!header) return header.error();
    if (Status status = check_header(path, 3, *header); !status) return status.error();
    if (header->component != Component::Float32 && header->component != Component::Float64)
        return unsupported(path, "type is " + std::string(name_of(header->component)) +
                                     ", expected vectors of float or double");
    if (header->turned_vectors)
        return unsupported(path, "has a measurement frame, expected vectors along its space");
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

/// Numbers of a field, three a voxel.
template <class Number>
Status read_numbers(const fs::path& path, const ImageHeader& header, std::span<Number> numbers) {
    if (header.data.plain) {
        DataStream stream(path, header);
        if (Status status = stream.read(std::as_writable_bytes(numbers)); !status) return status;
        return stream.finish();
    }
    if (header.data.encoding == DataEncoding::Deflated)
        if (Status status = check_stream(path, header); !status) return status;
    return itk_read_values(path, header, numbers.data());
}

}  // namespace

Result<VectorField> read_vector_field(const fs::path& path) {
    try {
        const auto header = read_field_header(path);
        if (!header) return header.error();
        VectorField field{header->grid, kind_of(*header), {}};
        field.vectors_mm.resize(voxel_count(field.grid));
        static_assert(sizeof(Vec3f) == 3 * sizeof(float));
        const std::size_t count = 3 * field.vectors_mm.size();
        const std::span narrow(reinterpret_cast<float*>(field.vectors_mm.data()), count);
        if (header->component == Component::Float32) {
            if (Status status = read_numbers(path, *header, narrow); !status) return status.error();
        } else {
            std::vector<double> wide(count);
            if (Status status = read_numbers(path, *header, std::span(wide)); !status)
                return status.error();
            std::transform(wide.begin(), wide.end(), narrow.begin(),
                           [](double v) { return float(v); });
        }
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
