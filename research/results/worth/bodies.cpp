// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "bodies.h"

#include <pliant/scan_files.h>
#include <pliant/volume.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "value_of.h"

namespace pliant::results {
namespace {

constexpr HexLattice kBlock{{33, 33, 25}, {1, 1, 1}};
constexpr std::uint64_t kBlockSeed = 1000, kScanSeed = 5000;

Vec3d random_direction(Dice& dice, double highest_z) {
    const double z = dice.real(-1, highest_z), turn = dice.real(0, 2 * std::numbers::pi);
    const double across = std::sqrt(1 - z * z);
    return {across * std::cos(turn), across * std::sin(turn), z};
}

enum Tissue : int { Gas, Fat, Soft, Liver, Kidney, Lung, kTissueCount };

/// Young's moduli of the orders that are measured in living tissue; ν = 0.45, and 0.2 with air.
const std::vector<ElasticPair> kTissues = {{0.5, 0.2}, {3, 0.45},  {10, 0.45},
                                           {6, 0.45},  {15, 0.45}, {2, 0.2}};

int tissue_of(float value_hu, int label, bool has_lung) {
    constexpr int kKidneyRight = 2, kKidneyLeft = 3, kLiver = 5;  // of TotalSegmentator
    if (label == kLiver) return Liver;
    if (label == kKidneyRight || label == kKidneyLeft) return Kidney;
    if (value_hu < -300) return has_lung && value_hu > -950 ? Lung : Gas;
    return value_hu < -20 ? Fat : Soft;
}

Body region(const std::string& name, const Volume& scan, const Volume* labels, Vec3i first,
            Vec3i size, bool has_lung) {
    constexpr float kBoneHu = 200;
    const auto voxel = [&](Vec3d at) {
        Vec3i e;
        for (int a = 0; a < 3; ++a) e[a] = std::min(first[a] + int(at[a]), scan.grid.size[a] - 1);
        return e;
    };
    Body body = make_body(name, {size, scan.grid.spacing_mm}, kTissues, [&](Vec3d at) {
        const Vec3i e = voxel(at);
        return tissue_of(scan.at(e), labels ? int(std::lround(labels->at(e))) : 0, has_lung);
    });
    for (std::size_t n = 0; n < body.held.size(); ++n) {
        const Vec3i e{int(n) % size.x, int(n) / size.x % size.y, int(n) / size.x / size.y};
        bool is_outermost = false;
        for (int a = 0; a < 3; ++a) is_outermost |= e[a] == 0 || e[a] == size[a] - 1;
        body.held[n] = is_outermost || scan.at(first + e) > kBoneHu;
    }
    return body;
}

}  // namespace

std::vector<Body> blocks() {
    const auto one = [](Vec3d) { return 0; };
    std::vector<Body> bodies;
    for (const double nu : {0.0, 0.3, 0.45, 0.49}) {
        std::string name = "ν = " + std::string(nu == 0      ? "0"
                                                : nu == 0.3  ? "0.3"
                                                : nu == 0.45 ? "0.45"
                                                             : "0.49");
        bodies.push_back(make_body(std::move(name), kBlock, {{10, nu}}, one));
    }
    bodies.push_back(make_body("layers 20 : 2 : 10 kPa, ν = 0.45", kBlock,
                               {{20, 0.45}, {2, 0.45}, {10, 0.45}}, [](Vec3d at) {
                                   return at.z > 21 ? 0 : at.z > 14 ? 1 : 2;
                               }));
    bodies.push_back(make_body("ball of 50 kPa in 5 kPa, ν = 0.45", kBlock, {{5, 0.45}, {50, 0.45}},
                               [](Vec3d at) {
                                   return norm(at - Vec3d{20, 16, 14}) < 6 ? 1 : 0;
                               }));
    return bodies;
}

void hold_block(Body& body, bool with_sides) {
    const Vec3i size = body.lattice.size;
    for (std::size_t n = 0; n < body.held.size(); ++n) {
        const int i = int(n) % size.x, j = int(n) / size.x % size.y, k = int(n) / size.x / size.y;
        const bool is_side = i == 0 || j == 0 || i == size.x - 1 || j == size.y - 1;
        body.held[n] = k == 0 || (with_sides && is_side);
    }
}

Load random_block_load(int number) {
    Dice dice(kBlockSeed + std::uint64_t(number));
    const bool is_inside = number % 10 >= 7;
    Load load;
    load.radius = dice.real(2, 5);
    load.centre = {dice.real(10, 22), dice.real(10, 22), is_inside ? dice.real(10, 16) : 24};
    const Vec3d direction = random_direction(dice, is_inside ? 1 : 0.3);
    load.push = (dice.real(0.1, 0.8) * load.radius) * direction;
    return load;
}

std::vector<Body> scan_regions(const std::filesystem::path& scans) {
    const Volume abdomen = value_of(read_volume(scans / "abdomen_ct_3mm.nii.gz"));
    const Volume organs = value_of(read_volume(scans / "abdomen_ct_3mm-label.nii.gz"));
    const Volume thorax = value_of(read_volume(scans / "thorax_ct_256.nrrd"));
    const Volume head = value_of(read_volume(scans / "head_ct_tiny_64.nrrd"));
    std::vector<Body> bodies;
    bodies.push_back(
        region("abdomen, liver and kidney", abdomen, &organs, {60, 30, 82}, {36, 36, 30}, false));
    bodies.push_back(
        region("thorax, lung and mediastinum", thorax, nullptr, {96, 108, 50}, {36, 36, 36}, true));
    bodies.push_back(
        region("head, brain in the skull", head, nullptr, {14, 14, 40}, {36, 36, 40}, false));
    return bodies;
}

Load random_scan_load(const Body& body, int number) {
    Dice dice(kScanSeed + std::uint64_t(number));
    const Vec3i size = body.lattice.size;
    for (;;) {
        Load load;
        load.radius = dice.real(2, 4);
        for (int a = 0; a < 3; ++a) load.centre[a] = dice.real(8, size[a] - 9);
        load.push = (dice.real(0.1, 0.8) * load.radius) * random_direction(dice, 1);
        Load around = load;
        around.radius = load.radius + 3;
        const auto near = nodes_of(around, body.lattice);
        if (std::none_of(near.begin(), near.end(), [&](Vec3i node) {
                return body.held[std::size_t(node_index(body.lattice, node))];
            }))
            return load;
    }
}

}  // namespace pliant::results
