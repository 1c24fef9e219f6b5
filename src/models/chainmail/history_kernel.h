// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The inner loops of packing a change, in two versions: plain for any brick size, and with vector
// instructions for bricks of 8³. Both give the same bits. history_codec.h describes the
// computation.

#pragma once

#include <cstddef>
#include <cstdint>

#include "material/limit_units.h"

namespace pliant {

struct ChangeKernels {
    /// Predicts after − before along x, y and z, and folds signs, so that small residuals of both
    /// signs become small unsigned numbers. @param[out] values  brick_size³; undefined if all of
    /// them are zero
    /// @returns bitwise or of all of them
    std::uint32_t (*predict)(const Fixed* before, const Fixed* after, int brick_size,
                             std::uint32_t* values);
    /// Copies one byte of each value. @param plane  0…3, 0 for the lowest
    void (*copy_plane)(const std::uint32_t* values, int count, int plane, std::byte* out);
};

/// Plain loops, any size.
const ChangeKernels& plain_change_kernels();
/// Vector instructions, the best that this processor supports. @pre bricks are 8³
const ChangeKernels& vector_change_kernels();

}  // namespace pliant
