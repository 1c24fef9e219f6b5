// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// All tissues have one format of state; a state of another tissue is refused.
// Covers: tissue/node_tissue.cpp, base/state_frame.cpp.

#include <gtest/gtest.h>
#include <pliant/tissues.h>

#include <filesystem>
#include <fstream>
#include <memory>
#include <vector>

#include "support/temporary_folder.h"

namespace pliant::test {
namespace {

Volume tissue_in_a_cube() {
    Volume scan;
    scan.grid.size = {24, 24, 24};
    scan.voxels = VoxelArray<std::int16_t>(std::vector<std::int16_t>(24 * 24 * 24, 40));
    return scan;
}

TEST(StateKinds, AStateIsLoadedByItsOwnTissueAlone) {
    const TaskArena arena(1);
    const TemporaryFolder folder;
    const Volume scan = tissue_in_a_cube();
    auto chainmail = make_chainmail(scan, {}, arena);
    auto springs = make_springs(scan, {.cell_mm = 6, .fixed_hu = 300}, arena);
    ASSERT_TRUE(chainmail.ok() && springs.ok());
    const std::vector<Tissue*> tissues{chainmail->get(), springs->get()};
    std::vector<std::filesystem::path> files{folder / "0.plst", folder / "1.plst"};
    for (std::size_t n = 0; n < 2; ++n) {
        const auto pushed = tissues[n]->push(
            1, {.point_mm = {12, 12, 12}, .push_mm = {2, 0, 0}, .sphere_radius_mm = 4});
        ASSERT_TRUE(pushed.ok()) << pushed.error().message;
        ASSERT_TRUE(tissues[n]->save_state(files[n]).ok());
        std::ifstream file(files[n], std::ios::binary);
        std::string begin(5, ' ');
        file.read(begin.data(), 5);
        EXPECT_EQ(begin.substr(1), "PLST");
    }
    for (std::size_t n = 0; n < 2; ++n) {
        const std::uint64_t hash = tissues[n]->hash();
        const Status other = tissues[n]->load_state(files[1 - n]);
        ASSERT_FALSE(other.ok());
        EXPECT_NE(other.error().message.find("expected a state of"), std::string::npos)
            << other.error().message;
        EXPECT_EQ(tissues[n]->hash(), hash);
        ASSERT_TRUE(tissues[n]->reset().ok());
        ASSERT_TRUE(tissues[n]->load_state(files[n]).ok());
        EXPECT_EQ(tissues[n]->hash(), hash);
    }
}

}  // namespace
}  // namespace pliant::test
