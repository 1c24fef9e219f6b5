// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Volumes for ParaView: VTK's XML file of an image. 3D Slicer doesn't list it; it opens NRRD.

#pragma once

#include <pliant/volume.h>

#pragma GCC visibility push(default)
namespace pliant {

/// Voxels as they are (int16 or float32), raw, appended to the header; the grid's direction as its
/// Direction, which VTK reads since version 9. Appears whole or not at all.
/// @param name  of the values, without characters that mean something in XML
/// @returns InvalidArgument for such a name or a volume that check_volume refuses, Unwritable
Status write_vti(const std::filesystem::path& path, const Volume& volume,
                 const std::string& name = "hu");

}  // namespace pliant
#pragma GCC visibility pop
