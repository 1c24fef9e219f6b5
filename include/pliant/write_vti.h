// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Volumes for ParaView: VTK's XML image file. 3D Slicer doesn't support it; it opens NRRD.

#pragma once

#include <pliant/volume.h>

#pragma GCC visibility push(default)
namespace pliant {

/// Writes the voxels unchanged (int16 or float32), raw, appended to the header. The grid's
/// direction becomes VTK's Direction, which VTK reads since version 9. Atomic.
/// @param name  of the values, without XML metacharacters
/// @returns InvalidArgument for such a name or a volume that check_volume refuses, Unwritable
Status write_vti(const std::filesystem::path& path, const Volume& volume,
                 const std::string& name = "hu");

}  // namespace pliant
#pragma GCC visibility pop
