// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include <pliant/resample.h>

#include <algorithm>

#include "chainmail/lattice.h"
#include "core/hash.h"
#include "resample/scatter.h"

namespace pliant {

Deformed deform_volume(const ChainMail& tissue, Mapping mapping, bool with_inverse) {
    return deform_by_lattice(tissue.volume(), tissue.lattice(), mapping, with_inverse,
                             tissue.arena());
}

VectorField displacement_field(const ChainMail& tissue) {
    const Grid& grid = tissue.volume().grid;
    const Lattice& lattice = tissue.lattice();
    VectorField field{grid, FieldKind::Modeling, std::vector<Vec3f>(voxel_count(grid), {0, 0, 0})};
    for (const int index : lattice.resident_bricks()) {
        const Brick& brick = lattice.brick(index);
        for (int n = 0; n < lattice.elements_per_brick(); ++n) {
            const Vec3i e = lattice.element_of(brick.coord, n);
            if (!contains(voxel_box(grid), e)) continue;
            const auto i = std::size_t(n);
            const Vec3d u = world_from_lattice_vector(
                grid, {mm_from_units(brick.u[0][i]), mm_from_units(brick.u[1][i]),
                       mm_from_units(brick.u[2][i])});
            field.vectors_mm[voxel_index(grid, e)] = {float(u.x), float(u.y), float(u.z)};
        }
    }
    return field;
}

VectorField inverse_field(const Deformed& deformed) {
    const Grid& grid = deformed.volume.grid;
    VectorField field{grid, FieldKind::Resampling,
                      std::vector<Vec3f>(voxel_count(grid), {0, 0, 0})};
    const Box3i& box = deformed.dirty_box;
    auto from = deformed.inverse_mm.begin();
    for (int z = box.begin.z; z < box.end.z; ++z)
        for (int y = box.begin.y; y < box.end.y; ++y) {
            const std::ptrdiff_t row = box.end.x - box.begin.x;
            std::copy_n(
                from, row,
                field.vectors_mm.begin() + std::ptrdiff_t(voxel_index(grid, {box.begin.x, y, z})));
            from += row;
        }
    return field;
}

std::uint64_t hash_volume(const Volume& volume) {
    Hash64 hash;
    for (int a = 0; a < 3; ++a) hash.add_word(std::uint32_t(volume.grid.size[a]));
    std::visit([&]<class T>(const std::vector<T>& voxels) { hash.add(std::span<const T>(voxels)); },
               volume.voxels);
    return hash.value();
}

}  // namespace pliant
