// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Converts elements and voxels to the input of the cell kernel, a vector at a time: every target
// gives the same bits.

#pragma once

#include "resample/strip_nodes.h"

namespace pliant {

/// Displacements of a strip's nodes relative to a base: (u − base)·scale + shift.
/// @param from  one component in the bricks along x, and in their neighbours along y, along z, and
///              along both
/// @param[out] to  in the order of StripNodes::index
void convert_displacements(std::span<const Fixed* const> from, std::span<const NodeRow> rows,
                           int brick_size, Fixed base, float scale, float shift, float* to);

/// Sets one bit per moved element, in words of `elements_per_word` bits. Reads the other components
/// only if the first one has a zero in the word. @param u  null: zero
void find_moved(const std::array<const Fixed*, 3>& u, int words, int elements_per_word,
                BitWord* bits);

/// Original values at a strip's nodes. @param from  at the first one, in a scan of this size
/// @param row_size, row_count  nodes along x, rows along y
void convert_values(const std::int16_t* from, Vec3i scan_size, std::span<const NodeRow> rows,
                    int row_size, int row_count, float* to);
void convert_values(const float* from, Vec3i scan_size, std::span<const NodeRow> rows, int row_size,
                    int row_count, float* to);

}  // namespace pliant
