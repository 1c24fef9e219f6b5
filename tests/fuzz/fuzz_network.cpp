// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A file of an identified network: refused in one line, or a network that is equal after it is
// written and read again, and that a scan can be moved with.

#include <pliant/models/network_file.h>
#include <pliant/models/scene_files.h>
#include <pliant/tissues.h>

#include "fuzz/fuzz.h"

using namespace pliant;

namespace {

std::uint64_t rest_hash(const SpringParts& parts) {
    auto network = SpringNetwork::create(parts);
    fuzz::expect(network.ok(), "a network");
    const auto tissue = SpringTissue::create(
        std::move(*network), {.solver = SpringSolver::ImplicitEuler, .time_step = 0.01});
    fuzz::expect(tissue.ok(), "a tissue", tissue.ok() ? "" : tissue.error().message);
    return tissue->hash();
}

/// A scan of 8³ voxels around the origin.
const Volume& small_scan() {
    static const Volume made = [] {
        Volume scan;
        scan.grid = {.size = {8, 8, 8}, .spacing_mm = {2, 2, 2}, .origin_mm = {-7, -7, -7}};
        scan.voxels = std::vector<std::int16_t>(512, 40);
        return scan;
    }();
    return made;
}

}  // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const auto file = fuzz::write_anew("n.json", fuzz::text_of(data, size));
    const auto network = read_network(file);
    if (!network.ok()) {
        fuzz::expect_one_line(network.error().message);
        return 0;
    }
    const auto again = fuzz::folder() / "again.json";
    const Status written = write_network(again, *network);
    fuzz::expect(written.ok(), "a network that can be written",
                 written.ok() ? "" : written.error().message);
    const auto back = read_network(again);
    fuzz::expect(back.ok(), "a network that can be read again",
                 back.ok() ? "" : back.error().message);
    fuzz::expect(back->parts.links.size() == network->parts.links.size() &&
                     back->link_groups == network->link_groups &&
                     back->groups.size() == network->groups.size(),
                 "the same lists");
    fuzz::expect(rest_hash(back->parts) == rest_hash(network->parts), "the same positions");
    static const TaskArena arena(1);
    auto tissue = make_network(small_scan(), network->parts, {}, arena);
    if (!tissue.ok()) {
        fuzz::expect_one_line(tissue.error().message);
        return 0;
    }
    const auto pushed =
        (*tissue)->push(1, {.point_mm = {0, 0, 0}, .push_mm = {1, 0, 0}, .sphere_radius_mm = 3});
    fuzz::expect(pushed.ok(), "a push", pushed.ok() ? "" : pushed.error().message);
    (void)(*tissue)->sweep();
    for (const Vec3d u : {(*tissue)->deformation().displacement_mm({4, 4, 4})})
        fuzz::expect(is_finite(u), "finite displacements");
    return 0;
}
