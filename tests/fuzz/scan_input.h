// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Bytes as a scan's file: read or refused in one line, as a scan and as a field of vectors.

#pragma once

#include <pliant/scan_files.h>
#include <pliant/volume.h>

#include "fuzz/fuzz.h"

namespace pliant::fuzz {

inline void read_scan(const std::filesystem::path& path, const ReadOptions& options = {}) {
    const auto volume = read_volume(path, options);
    if (!volume.ok()) {
        expect_one_line(volume.error().message);
    } else {
        const std::size_t count = voxel_count(volume->grid);
        std::visit(
            [&](const auto& voxels) {
                expect(voxels.size() == count, "as many voxels as the grid says");
                // Reads all values: a mapped file must have the stated length.
                double sum = 0;
                for (std::size_t n = 0; n < voxels.size(); ++n) sum += double(voxels.data()[n]);
                expect(sum == sum, "finite values");
            },
            volume->voxels);
        for (int a = 0; a < 3; ++a) {
            expect(volume->grid.size[a] >= 1, "a voxel along each axis");
            expect(volume->grid.spacing_mm[a] > 0, "a spacing");
            expect(is_finite(volume->grid.direction.columns[a]), "finite directions");
        }
        expect(is_finite(volume->grid.origin_mm), "a finite origin");
    }
    const auto field = read_vector_field(path);
    if (!field.ok()) expect_one_line(field.error().message);
}

/// Also with the options that read more.
inline void read_scan_both_ways(const std::filesystem::path& path) {
    read_scan(path);
    ReadOptions options;
    options.frame = 0;
    options.straighten = true;
    read_scan(path, options);
}

}  // namespace pliant::fuzz
