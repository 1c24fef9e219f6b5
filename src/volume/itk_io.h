// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// What ITK does: it decodes DICOM slices. Its warnings, and those of the libraries below it,
// go nowhere: what they have to say comes back as a Status.

#pragma once

#include "volume/voxel_builder.h"

#include <filesystem>

namespace pliant {

/// Decodes one DICOM slice with its rescale slope and intercept applied, and adds it.
Status itk_read_slice(const std::filesystem::path& path, int columns, int rows,
                      VoxelBuilder& voxels);

}  // namespace pliant
