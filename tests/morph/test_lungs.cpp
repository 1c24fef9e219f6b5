// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Measured lungs: the inner 70 % of the landmarks, from the outer 30 % and from the masks. The
// limits are those of docs/howto/morph.md.
// Covers: morph/morph.cpp.

#include <gtest/gtest.h>
#include <pliant/data/morph.h>
#include <pliant/scan_files.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <numeric>
#include <sstream>
#include <string>
#include <vector>

namespace pliant::test {
namespace {

namespace fs = std::filesystem;

const fs::path kLungs = fs::path(PLIANT_SHARED_DATA) / "lungs";

struct Case {
    std::vector<Vec3d> known_from, known_to, asked_from, asked_to;
};

/// Landmarks of a file, whose x and y are against LPS as in the masks' headers.
Case read_case(const std::string& name) {
    std::ifstream file(kLungs / (name + "_landmarks.csv"));
    std::string line;
    std::getline(file, line);
    std::vector<Vec3d> a, b;
    while (std::getline(file, line)) {
        std::replace(line.begin(), line.end(), ',', ' ');
        std::istringstream in(line);
        Vec3d p, q;
        in >> p.x >> p.y >> p.z >> q.x >> q.y >> q.z;
        a.push_back({-p.x, -p.y, p.z});
        b.push_back({-q.x, -q.y, q.z});
    }
    Vec3d mean{0, 0, 0}, variance{0, 0, 0};
    for (const Vec3d& p : a) mean = mean + (1 / double(a.size())) * p;
    for (const Vec3d& p : a)
        for (int c = 0; c < 3; ++c) variance[c] += (p[c] - mean[c]) * (p[c] - mean[c]);
    const auto far = [&](std::size_t n) {
        double sum = 0;
        for (int c = 0; c < 3; ++c) sum += (a[n][c] - mean[c]) * (a[n][c] - mean[c]) / variance[c];
        return sum;
    };
    std::vector<std::size_t> order(a.size());
    std::iota(order.begin(), order.end(), std::size_t(0));
    std::stable_sort(order.begin(), order.end(),
                     [&](std::size_t i, std::size_t j) { return far(i) > far(j); });
    Case c;
    const auto known = std::size_t(std::lround(0.3 * double(a.size())));
    for (std::size_t n = 0; n < order.size(); ++n) {
        (n < known ? c.known_from : c.asked_from).push_back(a[order[n]]);
        (n < known ? c.known_to : c.asked_to).push_back(b[order[n]]);
    }
    return c;
}

/// Mean errors over five cases [mm].
struct Errors {
    double still = 0, moved = 0, least_volume = 1;
};

Errors errors_of(const std::string& kind, bool with_points, bool with_masks) {
    const TaskArena arena(2);
    Errors errors;
    for (int n = 1; n <= 5; ++n) {
        const std::string name = kind + "_case0" + std::to_string(n);
        const Case c = read_case(name);
        MorphInput input;
        if (with_points) input = {.from_mm = c.known_from, .to_mm = c.known_to};
        Volume from, to;
        if (with_masks) {
            from = read_volume(kLungs / (name + "_exhale_mask.nii.gz")).value();
            to = read_volume(kLungs / (name + "_inhale_mask.nii.gz")).value();
            input.from = &from;
            input.to = &to;
        }
        const auto morph = Morph::create(input, {}, arena);
        EXPECT_TRUE(morph.ok());
        if (!morph.ok()) return errors;
        EXPECT_EQ(morph->report().has_prior, with_masks) << name;
        errors.least_volume = std::min(errors.least_volume, morph->report().least_volume);
        const double share = 1 / double(5 * c.asked_from.size());
        for (std::size_t m = 0; m < c.asked_from.size(); ++m) {
            errors.still += share * norm(c.asked_from[m] - c.asked_to[m]);
            errors.moved += share * norm(morph->forward(c.asked_from[m]) - c.asked_to[m]);
        }
    }
    return errors;
}

class Lungs : public testing::Test {
  protected:
    void SetUp() override {
        if (!fs::exists(kLungs)) GTEST_SKIP() << kLungs << " is missing";
    }
};

TEST_F(Lungs, Points_predict_the_inside_like_the_spline) {
    EXPECT_LT(errors_of("4dct", true, false).moved, 1.03 * 1.63);
    const Errors copd = errors_of("copd", true, false);
    EXPECT_LT(copd.moved, 1.03 * 4.19);
    EXPECT_GE(copd.least_volume, 0.05);
}

TEST_F(Lungs, Points_and_masks_predict_it_better) {
    const Errors copd = errors_of("copd", true, true);
    EXPECT_LT(copd.moved, 4.0);
    EXPECT_GE(copd.least_volume, 0.05);
}

TEST_F(Lungs, Masks_alone_predict_about_half_of_the_motion) {
    const Errors copd = errors_of("copd", false, true);
    EXPECT_LT(copd.moved, 0.55 * copd.still);
    EXPECT_GE(copd.least_volume, 0.05);
}

}  // namespace
}  // namespace pliant::test
