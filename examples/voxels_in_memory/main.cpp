// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// ChainMail on voxels that a program has in memory: no file is read or written.
//
//        y
//        │  tissue, 40 HU
//   20 ──┼────────────────────   a push of 3 mm into the wall, at the middle of this plane
//        │  air, −1000 HU
//        └─────────────────── x
//
//   voxels_in_memory            prints how far the wall went in
//   voxels_in_memory --check    and exits with 1 if that is not as far as it was pushed

#include <pliant/chainmail.h>
#include <pliant/resample.h>

#include <cstdint>
#include <cstdio>
#include <string>
#include <string_view>
#include <vector>

namespace {

constexpr int kSize = 40, kWall = 20;
constexpr std::int16_t kTissueHu = 40;

int fail(const std::string& message) {
    std::fprintf(stderr, "voxels_in_memory: %s\n", message.c_str());
    return 1;
}

pliant::Volume half_of_tissue() {
    pliant::Volume scan;
    scan.grid.size = {kSize, kSize, kSize};
    std::vector<std::int16_t> values(voxel_count(scan.grid), pliant::kAirHu);
    for (int z = 0; z < kSize; ++z)
        for (int y = kWall; y < kSize; ++y)
            for (int x = 0; x < kSize; ++x) values[voxel_index(scan.grid, {x, y, z})] = kTissueHu;
    scan.voxels = pliant::VoxelArray<std::int16_t>(values);
    return scan;
}

/// First voxel of tissue along y, in the middle of x and z.
int wall_of(const pliant::Volume& scan) {
    int y = 0;
    while (y < kSize && scan.at({kSize / 2, y, kSize / 2}) < 0) ++y;
    return y;
}

}  // namespace

int main(int argc, char** argv) {
    const pliant::Volume scan = half_of_tissue();
    const pliant::TaskArena arena;
    auto tissue = pliant::ChainMail::create(scan, {}, arena);
    if (!tissue) return fail(tissue.error().message);

    const double middle = kSize / 2;
    const auto report = tissue->push(
        {.point_mm = {middle, kWall + 0.5, middle}, .push_mm = {0, 3, 0}, .sphere_radius_mm = 4});
    if (!report) return fail(report.error().message);
    const auto deformed = pliant::deform_volume(*tissue);
    if (!deformed) return fail(deformed.error().message);

    const int moved = wall_of(deformed->volume) - wall_of(scan);
    std::printf("the wall went in by %d voxels; %lld elements moved\n", moved,
                static_cast<long long>(report->moved_elements));
    if (argc < 2 || std::string_view(argv[1]) != "--check") return 0;
    return moved == 3 ? 0 : fail("expected 3 voxels");
}
