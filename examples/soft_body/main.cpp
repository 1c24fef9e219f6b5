// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Tetrahedra that a sphere pushes, sixty times a second.
//
//        ○ sphere, 6 mm        frames 0 … 29: down by 6 mm
//      ┌─────────┐             frames 30 … 59: held
//      │  block  │ 36 mm       then it lets go, and the block comes back
//      └─────────┘
//      ▒▒▒▒▒▒▒▒▒▒▒ held: bone in the scan
//
//   soft_body            prints force and time of a frame, every tenth of a second
//   soft_body --check    and exits with 1 if the block doesn't push back, or doesn't come back

#include <pliant/tissues.h>

#include <algorithm>
#include <cstdio>
#include <string>
#include <string_view>
#include <vector>

namespace {

using namespace pliant;

constexpr double kFrame_s = 1.0 / 60;

int fail(const std::string& message) {
    std::fprintf(stderr, "soft_body: %s\n", message.c_str());
    return 1;
}

/// Air above bone.
Volume make_scan() {
    Volume scan;
    scan.grid = {.size = {48, 48, 64}};
    std::vector<std::int16_t> values;
    for (int n = 0; n < 48 * 48 * 64; ++n)
        values.push_back(std::int16_t(n / (48 * 48) < 9 ? 1000 : kAirHu));
    scan.voxels = VoxelArray<std::int16_t>(values);
    return scan;
}

/// A block of 36 × 36 × 36 mm, whose lowest nodes lie in the bone.
TetMesh make_block() {
    TetMesh mesh = five_tet_block({9, 9, 9}, 4);
    for (Vec3d& node : mesh.nodes_mm) node = node + Vec3d{6, 6, 8};
    return mesh;
}

}  // namespace

int main(int argc, char** argv) {
    const bool checks = argc > 1 && std::string_view(argv[1]) == "--check";
    const TaskArena arena;
    const Volume scan = make_scan();
    const TetMesh block = make_block();
    auto made = make_body(scan, block, {.young_modulus_pa = 20e3, .time_step_s = kFrame_s}, arena);
    if (!made) return fail(made.error().message);
    Tissue& body = **made;
    const std::uint64_t at_rest = body.hash();

    Vec3d sphere{24, 24, 46};
    double force_n = 0, slowest_ms = 0;
    int frame = 0;
    for (bool settled = false; !settled && frame < 1200; ++frame) {
        double ms = 0;
        if (frame < 60) {
            // A push takes a frame's time: the sphere moves, and the body answers.
            const Vec3d motion{0, 0, frame < 30 ? -0.2 : 0.0};
            const auto pushed =
                body.push(1, {.point_mm = sphere, .push_mm = motion, .sphere_radius_mm = 6});
            if (!pushed) return fail(pushed.error().message);
            sphere = sphere + pushed->step_fraction * motion;
            force_n = body.force_n(1).value_or(Vec3d{0, 0, 0}).z;
            ms = pushed->solve_ms;
        } else {
            if (frame == 60) body.release(1);
            const auto swept = body.sweep();
            if (!swept) return fail(swept.error().message);
            settled = swept->settled;
            ms = swept->ms;
        }
        slowest_ms = std::max(slowest_ms, ms);
        if (frame < 60 && frame % 6 == 5)
            std::printf("%.1f s: sphere at %.1f mm, %.3f N, %.1f ms\n", (frame + 1) * kFrame_s,
                        sphere.z, force_n, ms);
        if (checks && frame == 59 && !(force_n > 0.01 && sphere.z < 41))
            return fail("expected a force upwards on a sphere that went down");
    }
    std::printf("at rest after %.1f s; the slowest frame took %.1f ms\n", frame * kFrame_s,
                slowest_ms);
    if (checks && body.hash() != at_rest) return fail("expected the block back at rest");
    return 0;
}
