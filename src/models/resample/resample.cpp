// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include <pliant/resample.h>

#include "base/errors.h"
#include "base/hash.h"
#include "resample/scatter.h"

namespace pliant {

Result<Deformed> deform_volume(const MovingScan& scan, Mapping mapping,
                               bool with_inverse) noexcept {
    return attempt([&]() -> Result<Deformed> {
        if (const Status s = scan.update_deformation(); !s.ok()) return s.error();
        return deform_by_field(scan.volume(), scan.deformation().field(), mapping, with_inverse,
                               scan.arena());
    });
}

std::uint64_t hash_volume(const Volume& volume) {
    Hash64 hash;
    for (int a = 0; a < 3; ++a) hash.add_word(std::uint32_t(volume.grid.size[a]));
    // The count is hashed as for one span of all values.
    std::visit(
        [&]<class T>(const VoxelArray<T>& voxels) {
            voxels.for_each_piece([&](std::span<const T> piece) { hash.add_part(piece); });
            hash.add_word(voxels.size() * sizeof(T));
        },
        volume.voxels);
    return hash.value();
}

}  // namespace pliant
