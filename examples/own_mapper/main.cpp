// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A mapper of one's own: from a deformation back to a volume.
//
// The new value at p is the scan's value at φ⁻¹(p), with φ(X) = X + u(X). This mapper solves
// X = p − u(X) by iteration, from u at the eight elements around X. It needs no other data than
// Deformation::displacement_mm. The library's mapper inverts the cells instead, and knows cuts and
// gaps; where neither is, the two agree.
//
//   own_mapper            prints how far the two volumes are apart
//   own_mapper --check    and exits with 1 if they differ

#include <pliant/chainmail.h>
#include <pliant/resample.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>
#include <string_view>
#include <vector>

namespace {

using namespace pliant;

constexpr int kSize = 40;

int fail(const std::string& message) {
    std::fprintf(stderr, "own_mapper: %s\n", message.c_str());
    return 1;
}

/// Smooth values, so that an error of the position is an error of the value.
Volume waves() {
    Volume scan;
    scan.grid.size = {kSize, kSize, kSize};
    std::vector<float> values;
    for (int z = 0; z < kSize; ++z)
        for (int y = 0; y < kSize; ++y)
            for (int x = 0; x < kSize; ++x)
                values.push_back(float(100 * std::sin(0.3 * x) * std::cos(0.2 * y) + 2 * z));
    scan.voxels = VoxelArray<float>(values);
    return scan;
}

/// u(X), trilinear [mm]. @param ijk  continuous voxel index
Vec3d displacement_mm(const Deformation& deformation, Vec3d ijk) {
    const Vec3d low{std::floor(ijk.x), std::floor(ijk.y), std::floor(ijk.z)}, t = ijk - low;
    Vec3d sum{0, 0, 0};
    for (int c = 0; c < 8; ++c) {
        const Vec3i corner{c & 1, c >> 1 & 1, c >> 2};
        const double weight =
            (corner.x ? t.x : 1 - t.x) * (corner.y ? t.y : 1 - t.y) * (corner.z ? t.z : 1 - t.z);
        sum = sum + weight * deformation.displacement_mm(Vec3i{int(low.x), int(low.y), int(low.z)} +
                                                         corner);
    }
    return sum;
}

Volume map(const MovingScan& scan) {
    Volume mapped = scan.volume();
    const Grid& grid = mapped.grid;
    auto& values = std::get<VoxelArray<float>>(mapped.voxels);
    for (std::size_t n = 0; n < values.size(); ++n) {
        const Vec3d ijk{double(n % kSize), double(n / kSize % kSize), double(n / kSize / kSize)};
        const Vec3d p = world_from_voxel(grid, ijk);
        Vec3d x = p;
        for (int i = 0; i < 100; ++i) {
            const Vec3d next = p - displacement_mm(scan.deformation(), voxel_from_world(grid, x));
            const double step = norm(next - x);
            x = next;
            if (step < 1e-7) break;
        }
        values[n] = sample_linear(scan.volume(), voxel_from_world(grid, x));
    }
    return mapped;
}

}  // namespace

int main(int argc, char** argv) {
    const TaskArena arena;
    const Volume scan = waves();
    // Limits of less than a third rule out folds, and let the iteration converge.
    ChainMailSettings settings;
    settings.custom_law = [](int) {
        return ElementLimits{.compress = {0.2, 0.2, 0.2},
                             .stretch = {0.2, 0.2, 0.2},
                             .shear = {0.1, 0.1, 0.1},
                             .max_movement_mm = 10};
    };
    auto tissue = ChainMail::create(scan, settings, arena);
    if (!tissue) return fail(tissue.error().message);
    const auto pushed =
        tissue->push({.point_mm = {20, 20, 20}, .push_mm = {1.5, 1, -0.5}, .sphere_radius_mm = 3});
    if (!pushed) return fail(pushed.error().message);

    const Volume own = map(*tissue);
    const auto theirs = deform_volume(*tissue);
    if (!theirs) return fail(theirs.error().message);
    double apart = 0, changed = 0;
    for (int n = 0; n < kSize * kSize * kSize; ++n) {
        const Vec3i p{n % kSize, n / kSize % kSize, n / kSize / kSize};
        apart = std::max(apart, double(std::abs(own.at(p) - theirs->volume.at(p))));
        changed = std::max(changed, double(std::abs(own.at(p) - scan.at(p))));
    }
    std::printf("values changed by up to %.1f; the mappers differ by %.4f at most\n", changed,
                apart);
    if (argc < 2 || std::string_view(argv[1]) != "--check") return 0;
    return apart < 0.01 && changed > 20 ? 0 : fail("expected the same volume from both mappers");
}
