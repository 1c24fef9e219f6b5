// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Cases 14 and 15: the published hash of boxes, and the collision set of two vessels
// [Teschner2003] against the test of every node with every tetrahedron.

#include <pliant/mesh.h>
#include <pliant/models/pbd.h>
#include <pliant/research/overlap.h>

#include <algorithm>
#include <cstdint>
#include <set>

#include "published.h"
#include "two_vessels.h"
#include "value_of.h"

namespace pliant::results {
namespace {

/// [VesselPbd2016, Eq. 12], with the primes of its reference 21.
std::int32_t published_hash(Vec3i box, std::uint64_t boxes) {
    const std::uint64_t mixed = (std::uint64_t(box.x) * 73856093) ^
                                (std::uint64_t(box.y) * 19349663) ^
                                (std::uint64_t(box.z) * 83492791);
    return std::int32_t(mixed % boxes);
}

}  // namespace

Cases hash_cases() {
    const TetMesh block = five_tet_block({10, 10, 10}, 1);
    const PbdBoxes boxes = value_of(PbdBoxes::create(block, {.side = 1}));
    std::set<std::int32_t> hashes, indices;
    std::vector<int> boxes_of(1000, 0);
    for (int k = 0; k < 10; ++k)
        for (int j = 0; j < 10; ++j)
            for (int i = 0; i < 10; ++i) {
                const std::int32_t hash = published_hash({i, j, k}, 1000);
                hashes.insert(hash);
                indices.insert(boxes.linear_index({i, j, k}));
                ++boxes_of[std::size_t(hash)];
            }
    double fired = 0;
    for (const int n : boxes_of) fired += double(n) * n / 1000;
    return {within(14, "published hash of 10³ boxes: distinct", 618, double(hashes.size()), 0),
            within(14, "the same: boxes that fire for a tip, on the average", 2.03, fired, 0.005),
            within(14, "linear index of 10³ boxes: distinct", 1000, double(indices.size()), 0)};
}

Cases overlap_cases() {
    Cases cases;
    for (std::uint64_t seed = 1; seed <= 2; ++seed) {
        Numbers random(seed);
        TetMesh mesh;
        add_vessel(mesh, random, 23, 1, 56, {0, 0, 0}, {});
        add_vessel(mesh, random, 26, 2, 41, random.vector(3), rotation_by(random.vector(2)));
        mesh.cells.resize(20514);  // of 20520; 5898 nodes
        OverlapSearch search(mesh);
        for (const double moved : {0.0, 0.3}) {  // a second search in the same table
            std::vector<Vec3d> positions = mesh.nodes_mm;
            for (Vec3d& p : positions) p = p + random.vector(moved);
            const auto found = search.find(positions);
            const auto expected = all_pairs(mesh, positions);
            const bool equal =
                std::equal(found.begin(), found.end(), expected.begin(), expected.end());
            // Number of pairs both found and expected; zero would be no test.
            cases.push_back(within(15,
                                   "two vessels of 20514 tetrahedra and 5898 nodes, seed " +
                                       std::to_string(seed) + (moved > 0 ? ", moved" : "") +
                                       ": nodes in tetrahedra, the same as all pairs give",
                                   expected.empty() ? -1 : double(expected.size()),
                                   equal ? double(found.size()) : -2, 0));
        }
    }
    return cases;
}

}  // namespace pliant::results
