// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Writer of VTK's XML files: an XML header that describes the arrays, then all numbers in base64.
// Each array has its length in bytes (64 bits) in front and is encoded separately; the offsets in
// the header count characters after the underscore. In files of polygons SPACE tells 3D Slicer that
// positions are LPS.

#pragma once

#include <pliant/core/vec.h>
#include <pliant/result.h>

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>

namespace pliant::mesh {

class VtkDocument {
  public:
    /// @param type  PolyData or UnstructuredGrid
    explicit VtkDocument(const std::string& type);

    void add(const std::string& line) { m_header += line + "\n"; }
    template <class T>
    void add_array(const char* type, const std::string& name, int components,
                   std::span<const T> values) {
        add_bytes(type, name, components, std::as_bytes(values));
    }
    void add_vectors(const std::string& name, std::span<const Vec3d> values) {
        static_assert(sizeof(Vec3d) == 3 * sizeof(double));
        add_array("Float64", name, 3, values);
    }
    /// Closes the set and writes the file atomically.
    Status write(const std::filesystem::path& target) const;

  private:
    void add_bytes(const char* type, const std::string& name, int components,
                   std::span<const std::byte> bytes);
    std::string m_type, m_header, m_data;
};

/// @returns InvalidArgument that names the file and the field
Status check_length(const std::filesystem::path& path, const std::string& name, std::size_t found,
                    std::size_t expected, const char* of);

/// Writes text or bytes to a file atomically.
Status write_file(const std::filesystem::path& target, std::string_view bytes);

}  // namespace pliant::mesh
