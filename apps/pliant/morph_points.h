// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Tables of points of `pliant morph`: CSV whose first line names the columns. The columns
// from_x_mm, from_y_mm, from_z_mm, and to_x_mm, … are found by their names.

#pragma once

#include <pliant/core/vec.h>
#include <pliant/result.h>

#include <array>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

namespace pliant::app {

/// Columns that an empty field may have.
struct PointTable {
    std::vector<std::string> names;              ///< of the columns
    std::vector<std::vector<std::string>> rows;  ///< texts of the fields
    std::vector<Vec3d> from_mm, to_mm;           ///< to_mm: empty unless wanted
};

/// @param with_to  whether to_x_mm, … are needed
/// @returns Unreadable that names the file, the line, the column, and the expected value
Result<PointTable> read_point_table(const std::filesystem::path& path, bool with_to);

/// The table with to_x_mm, to_y_mm, to_z_mm behind its other columns; those that it has are
/// replaced where they stand.
std::string predicted_text(const PointTable& table, std::span<const Vec3d> to_mm);

}  // namespace pliant::app
