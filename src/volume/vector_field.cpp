// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Displacement fields and grid transforms: NRRD with three numbers per voxel.

#include "volume/data_reader.h"
#include "volume/image_file.h"

#include <pliant/volume.h>

#include <cmath>
#include <new>

namespace pliant {
namespace fs = std::filesystem;
namespace {

Error unsupported(const fs::path& path, const std::string& message) {
    return {ErrorCode::Unsupported, path.string() + ": " + message};
}

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
    return header;
}

FieldKind kind_of(const ImageHeader& header) {
    for (const auto& [key, value] : header.key_values)
        if (key == "displacement field type" && value == "modeling") return FieldKind::Modeling;
    return FieldKind::Resampling;
}

}  // namespace

Result<VectorField> read_vector_field(const fs::path& path) {
    try {
        const auto header = read_field_header(path);
        if (!header) return header.error();
        VectorField field{header->grid, kind_of(*header), {}};
        field.vectors_mm.reserve(voxel_count(field.grid));
        Vec3f vector{};
        int filled = 0;
        bool finite = true;
        const auto add = [&](double number) {
            vector[filled] = float(number * header->vector_sign[filled]);
            finite = finite && std::isfinite(vector[filled]);
            if (++filled < 3) return;
            field.vectors_mm.push_back(vector);
            filled = 0;
        };
        const auto sink = [&](Component component, const void* values, std::size_t count) {
            for (std::size_t n = 0; n < count; ++n)
                add(component == Component::Float32 ? double(static_cast<const float*>(values)[n])
                                                    : static_cast<const double*>(values)[n]);
        };
        if (Status status = read_data(path, *header, sink); !status) return status.error();
        if (!finite)
            return Error{ErrorCode::Unreadable, path.string() +
                                                    ": has a vector that is no "
                                                    "number, expected finite ones"};
        return field;
    } catch (const std::bad_alloc&) {
        return Error{ErrorCode::LimitExceeded, path.string() + ": not enough memory to read it"};
    }
}

}  // namespace pliant
