// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A material law of one's own: from the values of a scan to the limits of ChainMail.
//
//   value < 0      fat: links lose up to 40 % of their length
//   0 … 100        muscle: up to 10 %
//   above          implant: never moves
//
// A plate is pushed by 3 mm into fat, and into muscle. The element at a distance d in front of it
// moves by 3 mm − d · limit: fat takes up the push within 7.5 mm, muscle within 30 mm. A longer
// push ends when all fat in front of the implant is compressed.
//
//   own_law            prints how far elements moved
//   own_law --check    and exits with 1 where the distances are not those of the law

#include <pliant/chainmail.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>
#include <string_view>
#include <vector>

namespace {

using namespace pliant;

constexpr int kSize = 41, kMiddle = 20;

int fail(const std::string& message) {
    std::fprintf(stderr, "own_law: %s\n", message.c_str());
    return 1;
}

ElementLimits law(int value_hu) {
    if (value_hu > 100) return {.fixed = true};
    const double limit = value_hu < 0 ? 0.4 : 0.1;
    return {.compress = {limit, limit, limit},
            .stretch = {limit, limit, limit},
            .shear = {limit, limit, limit},
            .max_movement_mm = 20};
}

/// Fat on the left, muscle on the right, an implant at the left end.
Volume make_scan() {
    Volume scan;
    scan.grid.size = {kSize, kSize, kSize};
    std::vector<std::int16_t> values;
    for (int n = 0; n < kSize * kSize * kSize; ++n) {
        const int x = n % kSize;
        values.push_back(std::int16_t(x < 2 ? 3000 : x < kMiddle ? -90 : 50));
    }
    scan.voxels = VoxelArray<std::int16_t>(values);
    return scan;
}

/// All elements of a plane across x.
std::vector<Vec3i> plate(int x) {
    std::vector<Vec3i> elements;
    for (int n = 0; n < kSize * kSize; ++n) elements.push_back({x, n % kSize, n / kSize});
    return elements;
}

}  // namespace

int main(int argc, char** argv) {
    const bool checks = argc > 1 && std::string_view(argv[1]) == "--check";
    const TaskArena arena;
    const Volume scan = make_scan();
    ChainMailSettings settings;
    settings.custom_law = law;
    auto tissue = ChainMail::create(scan, settings, arena);
    if (!tissue) return fail(tissue.error().message);

    struct Case {
        const char* name;
        int plate, direction;
        double limit;
    };
    for (const Case& c : {Case{"fat", 18, -1, 0.4}, Case{"muscle", 22, 1, 0.1}}) {
        const auto pushed = tissue->push_elements(plate(c.plate), {3.0 * c.direction, 0, 0});
        if (!pushed) return fail(pushed.error().message);
        std::printf("%s:", c.name);
        for (const int d : {0, 5, 10}) {
            const Vec3i element{c.plate + c.direction * d, kMiddle, kMiddle};
            const double moved_mm = std::abs(tissue->deformation().displacement_mm(element).x);
            const double expected_mm = std::max(0.0, 3 - d * c.limit);
            std::printf("  %.2f mm at %d mm", moved_mm, d);
            if (checks && std::abs(moved_mm - expected_mm) > 1e-4)
                return fail("expected " + std::to_string(expected_mm) + " mm");
        }
        std::puts("");
        tissue->reset();
    }

    // Sixteen links of 1 mm between plate and implant lose 0.4 mm, and the last one, half of it.
    const auto far = tissue->push_elements(plate(18), {-8, 0, 0});
    if (!far) return fail(far.error().message);
    std::printf("against the implant: %.3f of 8 mm\n", far->step_fraction);
    if (checks && (far->limited_by != LimitedBy::Bone ||
                   std::abs(8 * far->step_fraction - (16 * 0.4 + 0.2)) > 1e-4))
        return fail("expected the implant to end the push");
    return 0;
}
