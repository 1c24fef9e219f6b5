// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include <pliant/resample.h>

#include "chainmail/check.h"
#include "core/errors.h"
#include "core/hash.h"
#include "resample/scatter.h"

namespace pliant {

Result<Deformed> deform_volume(const ChainMail& tissue, Mapping mapping,
                               bool with_inverse) noexcept {
    return deform_volume(ChainMailScan(tissue), mapping, with_inverse);
}

Result<Deformed> deform_volume(const MovingScan& scan, Mapping mapping,
                               bool with_inverse) noexcept {
    return attempt([&]() -> Result<Deformed> {
        if (const Status s = scan.update_lattice(); !s.ok()) return s.error();
        return deform_by_lattice(scan.volume(), scan.lattice(), mapping, with_inverse,
                                 scan.arena());
    });
}

Result<LatticeState> state_of(const MovingScan& scan) noexcept {
    static constexpr Vec3d kFar{1e6, 1e6, 1e6};
    static constexpr ElementLimits kNone{kFar, kFar, kFar, 1e6};
    const auto no_limits = [](Vec3i) { return kNone; };
    return attempt([&]() -> Result<LatticeState> {
        if (const Status s = scan.update_lattice(); !s.ok()) return s.error();
        return check_lattice(scan.lattice(), no_limits, scan.arena());
    });
}

std::uint64_t hash_volume(const Volume& volume) {
    Hash64 hash;
    for (int a = 0; a < 3; ++a) hash.add_word(std::uint32_t(volume.grid.size[a]));
    // The count goes in as for one span of all values.
    std::visit(
        [&]<class T>(const VoxelArray<T>& voxels) {
            voxels.for_each_piece([&](std::span<const T> piece) { hash.add_part(piece); });
            hash.add_word(voxels.size() * sizeof(T));
        },
        volume.voxels);
    return hash.value();
}

}  // namespace pliant
