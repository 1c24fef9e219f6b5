// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Random lattices: blobs of a few materials, some of them fixed, on anisotropic grids.

#pragma once

#include <pliant/chainmail.h>

#include <vector>

#include "support/random.h"

namespace pliant::test {

struct Instance {
    Volume volume;
    MaterialLaw law;
    Vec3d push_limit_mm;  ///< longest push along each axis that stays within the margin
};

inline constexpr int kInstanceMargin = 6;

/// Voxel values are labels 0, 1, …; all other elements (air beyond the scan) are soft.
inline Instance random_instance(Random& random, int smallest, int largest, bool with_fixed) {
    Instance instance;
    Grid& grid = instance.volume.grid;
    for (int a = 0; a < 3; ++a) {
        grid.size[a] = random.whole(smallest, largest);
        grid.spacing_mm[a] = random.real(0.7, 2.5);
    }
    grid.origin_mm = random.vector(100);
    const int label_count = random.whole(2, 4);
    struct Blob {
        Vec3d centre;
        int label;
    };
    std::vector<Blob> blobs;
    for (int n = 0; n < 3 * label_count; ++n)
        blobs.push_back({{random.real(0, grid.size.x), random.real(0, grid.size.y),
                          random.real(0, grid.size.z)},
                         n % label_count});
    std::vector<std::int16_t> labels(voxel_count(grid));
    for (int z = 0; z < grid.size.z; ++z)
        for (int y = 0; y < grid.size.y; ++y)
            for (int x = 0; x < grid.size.x; ++x) {
                const Vec3d p{double(x), double(y), double(z)};
                const Blob* nearest = &blobs[0];
                for (const Blob& blob : blobs)
                    if (norm(blob.centre - p) < norm(nearest->centre - p)) nearest = &blob;
                labels[voxel_index(grid, {x, y, z})] = std::int16_t(nearest->label);
            }
    if (with_fixed)
        for (int n = random.whole(0, 2); n > 0; --n)
            labels[std::size_t(random.whole(0, int(labels.size()) - 1))] = 9;
    instance.volume.voxels = labels;
    std::vector<ElementLimits> table;
    for (int n = 0; n < label_count; ++n) {
        ElementLimits limits{.max_movement_mm = 500};
        for (int b = 0; b < 3; ++b) {
            limits.compress[b] = random.ratio(0.002, 0.4);
            limits.stretch[b] = random.ratio(0.002, 0.4);
            limits.shear[b] = random.ratio(0.002, 0.4);
        }
        table.push_back(limits);
    }
    const ElementLimits soft{{.4, .4, .4}, {.4, .4, .4}, {.4, .4, .4}, 500, false};
    instance.law = [table, soft](int value) {
        if (value >= 0 && value < int(table.size())) return table[std::size_t(value)];
        ElementLimits limits = soft;
        limits.fixed = value == 9;
        return limits;
    };
    const double shortest = std::min({grid.spacing_mm.x, grid.spacing_mm.y, grid.spacing_mm.z});
    const double reach = 0.4 * (kInstanceMargin - 1) * shortest / 4;
    instance.push_limit_mm = {reach, reach, reach};
    return instance;
}

/// The same limits in every direction and sense, in fractions of a link, as in the thesis's law.
inline MaterialLaw symmetric(const MaterialLaw& law) {
    return [law](int value) {
        ElementLimits limits = law(value);
        const double limit = limits.compress.x;
        limits.compress = limits.stretch = limits.shear = {limit, limit, limit};
        return limits;
    };
}

/// Cuts a fraction of all links and carves a few elements: flags of ElementEdit by voxel.
inline std::vector<std::uint8_t> random_edits(Random& random, const Grid& grid) {
    std::vector<std::uint8_t> edits(voxel_count(grid), 0);
    const int cut_percent = random.whole(0, 30), void_percent = random.whole(0, 15);
    for (std::uint8_t& flags : edits) {
        for (int axis = 0; axis < 3; ++axis)
            if (random.whole(1, 100) <= cut_percent) flags = std::uint8_t(flags | 1 << axis);
        if (random.whole(1, 100) <= void_percent) flags |= 8;
    }
    return edits;
}

/// A box of elements inside the volume, or a few single elements.
inline std::vector<Vec3i> random_grab(Random& random, const Grid& grid) {
    std::vector<Vec3i> grabbed;
    const auto anywhere = [&] {
        return Vec3i{random.whole(0, grid.size.x - 1), random.whole(0, grid.size.y - 1),
                     random.whole(0, grid.size.z - 1)};
    };
    if (random.whole(0, 1)) {
        for (int n = random.whole(1, 4); n > 0; --n) grabbed.push_back(anywhere());
        return grabbed;
    }
    const Vec3i low = anywhere();
    for (int c = 0; c < 8; ++c) {
        const Vec3i e = low + Vec3i{c & 1, c >> 1 & 1, c >> 2};
        if (contains(voxel_box(grid), e)) grabbed.push_back(e);
    }
    return grabbed;
}

}  // namespace pliant::test
