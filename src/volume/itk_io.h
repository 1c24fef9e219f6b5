// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Everything that is left to ITK: to decode the voxels of files whose headers have been judged, and
// to write NRRD. Its warnings, and those of the libraries below it, go nowhere: what they have to
// say comes back as a Status.

#pragma once

#include "volume/image_header.h"
#include "volume/voxel_builder.h"

#include <filesystem>
#include <vector>

namespace pliant {

/// Decodes the voxels of a 3-D image of single numbers. @pre check_header(path, 1, header)
Status itk_read_voxels(const std::filesystem::path& path, const ImageHeader& header,
                       VoxelBuilder& voxels);
/// Decodes the vectors of a 3-D image of three numbers per voxel, as they are in the file.
/// @pre check_header(path, 3, header), floats
Status itk_read_vectors(const std::filesystem::path& path, const ImageHeader& header,
                        std::vector<Vec3f>& vectors);
/// Decodes one DICOM slice with its rescale slope and intercept applied, and adds it.
Status itk_read_slice(const std::filesystem::path& path, int columns, int rows,
                      VoxelBuilder& voxels);
/// What ITK takes the geometry of a file to be; for comparison.
Result<Grid> itk_read_grid(const std::filesystem::path& path, ImageFormat format);

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
