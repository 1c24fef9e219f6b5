// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Pliant in a program of one's own: makes a phantom, pushes its first landmark, and writes both.
//
//   consumer FOLDER            writes airway.nrrd and pushed.nrrd there
//   consumer FOLDER --check    and exits with 1 if the second is not what it must be

#include <pliant/scan_files.h>
#include <pliant/volume.h>

#include <cstddef>
#include <cstdio>
#include <string>
#include <string_view>

#include "push.h"

namespace {

int fail(const std::string& message) {
    std::fprintf(stderr, "consumer: %s\n", message.c_str());
    return 1;
}

/// Voxels whose value differs; −1 if the grids do.
long long count_changed(const pliant::Volume& a, const pliant::Volume& b) {
    if (!(a.grid == b.grid)) return -1;
    long long changed = 0;
    const pliant::Vec3i size = a.grid.size;
    for (int z = 0; z < size.z; ++z)
        for (int y = 0; y < size.y; ++y)
            for (int x = 0; x < size.x; ++x) changed += a.at({x, y, z}) != b.at({x, y, z});
    return changed;
}

}  // namespace

int main(int argc, char** argv) {
    if (argc < 2) return fail("expected a folder to write to");
    const std::string folder = argv[1];
    const std::string airway = folder + "/airway.nrrd", pushed = folder + "/pushed.nrrd";

    const pliant::TaskArena arena;
    const auto phantom = pliant::make_phantom({.name = "airway", .size = {48, 48, 48}}, arena);
    if (!phantom) return fail(phantom.error().message);
    const auto written = pliant::write_volume(airway, phantom->volume);
    if (!written) return fail(written.error().message);

    const pliant::PhantomLandmark& carina = phantom->landmarks.front();
    const auto done = push_wall(airway.c_str(), pushed.c_str(),
                                {.point_mm = carina.push_point_mm, .push_mm = carina.push_mm});
    if (!done) return fail(done.error().message);

    if (argc < 3 || std::string_view(argv[2]) != "--check") return 0;
    const auto deformed = pliant::read_volume(pushed);
    if (!deformed) return fail(deformed.error().message);
    const long long changed = count_changed(phantom->volume, *deformed);
    const auto all = static_cast<long long>(pliant::voxel_count(phantom->volume.grid));
    std::printf("%lld of %lld voxels changed\n", changed, all);
    if (changed < 8 || changed > all / 2) return fail("expected some voxels to change, not most");
    return 0;
}
