// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Writes NRRD or VTI, staged, so that a file appears atomically.

#include "core/text.h"
#include "formats/nrrd_writer.h"

#include <pliant/files.h>
#include <pliant/volume.h>

#include <algorithm>
#include <functional>
#include <new>
#include <span>
#include <vector>

namespace pliant {
namespace fs = std::filesystem;
namespace {

/// @param add_numbers  passes all numbers to the writer; false on failure
Status write_staged(const fs::path& path, const NrrdLayout& layout, Encoding encoding,
                    const std::function<bool(NrrdWriter&)>& add_numbers) {
    const std::string extension = lower_case(path.extension().string());
    if (extension != ".nrrd" && extension != ".nhdr")
        return Error{ErrorCode::Unwritable,
                     path.string() + ": expected a name that ends in .nrrd or .nhdr"};
    try {
        StagedFiles files;
        const auto staged = files.stage(path);
        if (!staged) return staged.error();
        NrrdWriter writer(*staged, layout, encoding);
        if (!add_numbers(writer))
            return Error{ErrorCode::Unreadable,
                         path.string() +
                             ": can't be written: the file that the scan is mapped "
                             "from was cut short"};
        if (Status status = writer.finish(); !status)
            return Error{status.error().code,
                         path.string() + status.error().message.substr(staged->string().size())};
        return files.commit();
    } catch (const std::bad_alloc&) {
        return Error{ErrorCode::LimitExceeded, path.string() + ": not enough memory to write it"};
    }
}

}  // namespace

Status write_volume(const fs::path& path, const Volume& volume, Encoding encoding) {
    if (lower_case(path.extension().string()) == ".vti") return write_vti(path, volume);
    if (Status s = check_volume(volume, path.string()); !s) return s;
    const Component component = volume.is_16_bit() ? Component::Int16 : Component::Float32;
    return write_staged(
        path, {volume.grid, component, 1, volume.key_values}, encoding, [&](NrrdWriter& writer) {
            const auto add = [&](auto piece) { writer.add(std::as_bytes(piece)); };
            return std::visit([&](const auto& voxels) { return voxels.for_each_piece(add); },
                              volume.voxels);
        });
}

Status write_vector_field(const fs::path& path, const Grid& grid, FieldKind kind,
                          const FieldSlices& fill_slice, Encoding encoding) {
    if (Status s = check_grid(grid, path.string()); !s) return s;
    const KeyValues key_values = {
        {"displacement field type", kind == FieldKind::Modeling ? "modeling" : "resampling"}};
    return write_staged(
        path, {grid, Component::Float32, 3, key_values}, encoding, [&](NrrdWriter& writer) {
            std::vector<Vec3f> slice(std::size_t(grid.size.x) * std::size_t(grid.size.y));
            for (int k = 0; k < grid.size.z; ++k) {
                std::fill(slice.begin(), slice.end(), Vec3f{0, 0, 0});
                fill_slice(k, slice);
                writer.add(std::as_bytes(std::span(slice)));
            }
            return true;
        });
}

Status write_vector_field(const fs::path& path, const VectorField& field, Encoding encoding) {
    if (Status s = check_field(field, path.string()); !s) return s;
    const std::size_t count = std::size_t(field.grid.size.x) * std::size_t(field.grid.size.y);
    const auto copy_slice = [&](int k, std::span<Vec3f> vectors_mm) {
        std::copy_n(field.vectors_mm.data() + std::size_t(k) * count, count, vectors_mm.data());
    };
    return write_vector_field(path, field.grid, field.kind, copy_slice, encoding);
}

}  // namespace pliant
