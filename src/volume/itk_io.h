// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// What ITK does: it decodes the pixels of DICOM files, in all their encodings, and writes NRRD. Its
// warnings, and those of the libraries below it, go nowhere: what they have to say comes back as a
// Status.

#pragma once

#include "volume/image_header.h"
#include "volume/voxel_builder.h"

#include <filesystem>

namespace pliant {

/// Decodes one DICOM slice with its rescale slope and intercept applied, and adds it.
Status itk_read_slice(const std::filesystem::path& path, int columns, int rows,
                      VoxelBuilder& voxels);
struct NrrdImage {
    const Grid& grid;
    Component component;
    int components;  ///< numbers per voxel: 1, or 3 for vectors
    const void* values;
    const KeyValues& key_values;
};

/// Writes NRRD in LPS, under exactly this name (.nhdr: the data beside it).
Status itk_write_nrrd(const std::filesystem::path& path, const NrrdImage& image, Encoding encoding);

}  // namespace pliant
