// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A scene of an organ alone: its mesh from a file, a scan that is made of it, and a body of
// tetrahedra that carries the scan.

#pragma once

#include <pliant/tissue.h>
#include <pliant/volume.h>

#include <cstdint>
#include <filesystem>
#include <memory>

namespace pliant::serve {

struct Organ {
    Volume scan;
    std::shared_ptr<const MakeTissue> tissue;
    std::uint64_t hash = 0;  ///< of the mesh
};

/// Whether a file is a mesh, by its extension; .vtk also by its content, since scans have it too.
bool is_mesh(const std::filesystem::path& file);

/// Reads tetrahedra, or fills a closed surface with them. The organ lies on its back: the hindmost
/// twentieth of its depth is held.
/// @returns an error that names the file
Result<Organ> load_organ(const std::filesystem::path& file, const TaskArena& arena);

}  // namespace pliant::serve
