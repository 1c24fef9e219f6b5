// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// NRRD out: staged, so that a file is there as a whole or not at all.

#include "volume/itk_io.h"
#include "volume/text.h"

#include <pliant/staged_files.h>
#include <pliant/volume.h>

namespace pliant {
namespace fs = std::filesystem;
namespace {

Status write_staged(const fs::path& path, const NrrdImage& image, Encoding encoding) {
    const std::string extension = lower_case(path.extension().string());
    if (extension != ".nrrd" && extension != ".nhdr")
        return Error{ErrorCode::Unwritable,
                     path.string() + ": expected a name that ends in .nrrd or .nhdr"};
    StagedFiles files;
    const auto staged = files.stage(path);
    if (!staged) return staged.error();
    if (Status status = itk_write_nrrd(*staged, image, encoding); !status)
        return Error{status.error().code, path.string() + ": can't be written"};
    return files.commit();
}

}  // namespace

Status write_volume(const fs::path& path, const Volume& volume, Encoding encoding) {
    const bool narrow = volume.is_16_bit();
    const void* values = narrow ? static_cast<const void*>(std::get<0>(volume.voxels).data())
                                : std::get<1>(volume.voxels).data();
    return write_staged(
        path,
        {volume.grid, narrow ? Component::Int16 : Component::Float32, 1, values, volume.key_values},
        encoding);
}

Status write_vector_field(const fs::path& path, const VectorField& field, Encoding encoding) {
    const KeyValues key_values = {
        {"displacement field type", field.kind == FieldKind::Modeling ? "modeling" : "resampling"}};
    return write_staged(
        path, {field.grid, Component::Float32, 3, field.vectors_mm.data(), key_values}, encoding);
}

}  // namespace pliant
