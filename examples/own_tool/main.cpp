// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A tool of one's own shape: a spatula, pushed into two kinds of tissue.
//
//          ┌──────────── 20 mm ────────────┐
//   ───────┴───────────────────────────────┴──────  y = 20 mm, the wall
//             4 mm deep, 6 mm wide (z)
//
// The shape contains the elements that the tool grabs; a sphere around it bounds the search. Each
// of the library's tissues understands it.
//
//   own_tool            prints how much each push moved
//   own_tool --check    and exits with 1 if elements beside the spatula were taken

#include <pliant/tissues.h>

#include <cmath>
#include <cstdio>
#include <string>
#include <string_view>
#include <vector>

namespace {

using namespace pliant;

constexpr int kSize = 48, kWall = 20;

int fail(const std::string& message) {
    std::fprintf(stderr, "own_tool: %s\n", message.c_str());
    return 1;
}

class Spatula final : public ToolShape {
  public:
    bool contains(Vec3d offset_mm) const noexcept override {
        return std::abs(offset_mm.x) <= 10 && std::abs(offset_mm.y) <= 2 &&
               std::abs(offset_mm.z) <= 3;
    }
};

Volume half_of_tissue() {
    Volume scan;
    scan.grid.size = {kSize, kSize, kSize};
    std::vector<std::int16_t> values;
    for (int n = 0; n < kSize * kSize * kSize; ++n)
        values.push_back(std::int16_t(n / kSize % kSize < kWall ? kAirHu : 40));
    scan.voxels = VoxelArray<std::int16_t>(values);
    return scan;
}

}  // namespace

int main(int argc, char** argv) {
    const bool checks = argc > 1 && std::string_view(argv[1]) == "--check";
    const TaskArena arena;
    const Volume scan = half_of_tissue();
    const Spatula spatula;
    const Push push{
        .point_mm = {24, 22, 24}, .push_mm = {0, 2, 0}, .sphere_radius_mm = 11, .shape = &spatula};

    auto chainmail = make_chainmail(scan, {}, arena);
    if (!chainmail) return fail(chainmail.error().message);
    const auto pushed = (*chainmail)->push(1, push);
    if (!pushed) return fail(pushed.error().message);
    std::printf("chainmail: %lld elements in the spatula, %lld moved\n",
                static_cast<long long>(pushed->grabbed_elements),
                static_cast<long long>(pushed->moved_elements));
    // 21 × 5 × 7 voxels lie in it, and all of them are tissue.
    if (checks && pushed->grabbed_elements != 21 * 5 * 7) return fail("expected 735 elements");
    const Deformation& field = (*chainmail)->deformation();
    const auto moved = [&](Vec3i element) { return field.displacement_mm(element).y; };
    std::printf("moved: %.2f mm at its end, %.2f mm 4 mm beyond it\n", moved({34, 22, 24}),
                moved({38, 22, 24}));
    if (checks && !(std::abs(moved({34, 22, 24}) - 2) < 1e-4 && moved({38, 22, 24}) < 1.9))
        return fail("expected the spatula alone to move by the whole push");

    // The same tool holds nodes of a spring lattice.
    auto springs = make_springs(scan, {.cell_mm = 4}, arena);
    if (!springs) return fail(springs.error().message);
    const auto sprung = (*springs)->push(1, push);
    if (!sprung) return fail(sprung.error().message);
    const auto whole = (*springs)->push(
        2, {.point_mm = push.point_mm, .push_mm = {0, 0, 0}, .sphere_radius_mm = 11});
    if (!whole) return fail(whole.error().message);
    std::printf("springs: %lld nodes in the spatula, %lld in the sphere around it\n",
                static_cast<long long>(sprung->grabbed_elements),
                static_cast<long long>(whole->grabbed_elements));
    if (checks &&
        !(sprung->grabbed_elements > 0 && sprung->grabbed_elements < whole->grabbed_elements))
        return fail("expected some of the sphere's nodes");
    return 0;
}
