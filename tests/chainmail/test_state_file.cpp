// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Saved states: complete or refused.

#include "chainmail/state_file.h"

#include <gtest/gtest.h>

#include <map>
#include <tuple>

#include "base/hash.h"
#include "chainmail/chainmail_impl.h"
#include "chainmail/instances.h"
#include "material/settings.h"
#include "support/temporary_folder.h"

namespace pliant::test {
namespace {

constexpr std::uint64_t kStateFileSeed = 20260303;

Volume noisy_block(Vec3i size, std::uint64_t seed) {
    Random random(seed);
    Volume volume;
    volume.grid.size = size;
    volume.grid.spacing_mm = {0.7, 0.8, 1.5};
    volume.grid.origin_mm = {-10, 20, 1.0 / 3};
    volume.grid.direction = random.rotation(false);
    std::vector<std::int16_t> voxels(voxel_count(volume.grid));
    for (auto& value : voxels) value = std::int16_t(random.whole(-900, 280));
    volume.voxels = voxels;
    return volume;
}

class StateFileTest : public ::testing::Test {
  protected:
    ChainMail tissue_of(const Volume& scan, const ChainMailSettings& settings = {}) {
        return std::move(ChainMail::create(scan, settings, arena)).value();
    }
    Vec3d middle() const { return world_from_voxel(volume.grid, {9.5, 8.5, 7.5}); }
    /// Pushed, cut and carved.
    ChainMail worked_tissue(const ChainMailSettings& settings = {}) {
        ChainMail tissue = tissue_of(volume, settings);
        EXPECT_TRUE(tissue.push({.point_mm = middle(), .push_mm = {2, -1, 0.5}}).ok());
        EXPECT_TRUE(tissue.cut({{middle(), middle() + Vec3d{8, 0, 0}}, {0, 5, 5}}).ok());
        EXPECT_TRUE(tissue.carve({middle(), middle() + Vec3d{3, 3, 0}, 1.5}).ok());
        return tissue;
    }
    std::string error_of(ChainMail& tissue) {
        const Status status = tissue.load_state(file);
        return status.ok() ? "" : status.error().message;
    }

    TaskArena arena{2};
    Volume volume = noisy_block({20, 18, 16}, kStateFileSeed);
    TemporaryFolder folder;
    std::filesystem::path file = folder / "state.plst";
};

TEST_F(StateFileTest, StateComesBackBitForBitWithItsSettings) {
    ChainMailSettings settings;
    settings.offset = 0.17;
    settings.brick_size = 5;
    settings.scale = 1.0 / 3;
    settings.air_enabled = false;  // the push reaches beyond the scan
    ChainMail saved = worked_tissue(settings);
    ASSERT_TRUE(saved.save_state(file).ok());
    ChainMail loaded = tissue_of(volume);
    ASSERT_TRUE(loaded.push({.point_mm = middle(), .push_mm = {0, 0, 1}}).ok());
    const Status status = loaded.load_state(file);
    ASSERT_TRUE(status.ok()) << status.error().message;
    EXPECT_EQ(loaded.hash(), saved.hash());
    EXPECT_EQ(loaded.state().moved_elements, saved.state().moved_elements);
    EXPECT_EQ(loaded.state().cut_links, saved.state().cut_links);
    EXPECT_EQ(loaded.state().carved_elements, saved.state().carved_elements);
    EXPECT_GT(loaded.state().moved_elements, 100);
    EXPECT_GT(loaded.state().carved_elements, 10);
    EXPECT_GT(loaded.state().cut_links, 10);
    EXPECT_EQ(loaded.settings().offset, 0.17);
    EXPECT_EQ(loaded.settings().scale, 1.0 / 3);
    EXPECT_EQ(loaded.undo_steps(), 0);
    const Push next{.point_mm = middle() + Vec3d{-2, 0, 0}, .push_mm = {-3, 1, 1}};
    ASSERT_TRUE(loaded.push(next).ok() && saved.push(next).ok());
    EXPECT_EQ(loaded.hash(), saved.hash()) << "what comes after differs";
}

TEST_F(StateFileTest, CarvedBricksOfMoreThanOneRecordComeBack) {
    const Volume large = noisy_block({40, 40, 40}, kStateFileSeed);
    ChainMail saved = tissue_of(large, {.brick_size = 5});
    const Vec3d from = world_from_voxel(large.grid, {2, 3, 4});
    for (const Vec3d to : {Vec3d{37, 35, 33}, Vec3d{36, 4, 37}, Vec3d{3, 36, 30}})
        ASSERT_TRUE(saved.carve({from, world_from_voxel(large.grid, to), 1.5}).ok());
    ASSERT_GT(ChainMailInside::of(saved).lattice.all_edits().size(), 20u);
    ASSERT_TRUE(saved.save_state(file).ok());
    ChainMail loaded = tissue_of(large);
    ASSERT_EQ(error_of(loaded), "");
    EXPECT_EQ(ChainMailInside::of(loaded).lattice.all_edits(),
              ChainMailInside::of(saved).lattice.all_edits());
}

TEST_F(StateFileTest, BricksTooFarAwayAreDamageOnEachSide) {
    const auto law = [](int) { return ElementLimits{}; };
    constexpr int kFarthest = (1 << 24) / 8;
    for (int side = 0; side < 6; ++side)
        for (const int beyond : {0, 1}) {
            Lattice far(volume, {law}, 8, false), read(volume, {law}, 8, false);
            Vec3i coord{0, 0, 0};
            coord[side / 2] = (side % 2 ? -1 : 1) * (kFarthest + beyond);
            const int index = far.ensure_brick(coord);
            far.brick(index).u[0][0] = 1000;
            far.update_bounds(index);
            const Bytes bytes = encode_state({}, far, {});
            auto reader = StateReader::open("far", bytes);
            ASSERT_TRUE(reader.ok() && reader->read_header().ok());
            PlasticRest imprints;
            EXPECT_EQ(reader->read_lattice(read, imprints, 1000).ok(), beyond == 0) << side;
        }
}

TEST_F(StateFileTest, EachSettingOfTheFileComesBack) {
    ChainMailSettings s;
    s.offset = 0.1234567890123;
    s.range = {-1.0 / 3, 2e-7};
    s.range_percent = ValueSpan{1, 99.5};
    s.factor = {1, 0.7, 1.0 / 9};
    s.bone_threshold_hu = 301.5;
    s.max_movement_mm = 1e-3;
    s.yield = 0.3;
    s.scale = 2.5e-7;
    s.brick_size = 13;
    s.bounded = true;
    s.max_elements = 123'456'789'012;
    s.history_max_steps = 17;
    s.history_max_mb = 18;
    s.air_threshold_hu = -1e20;
    const auto read = parse_settings("x", settings_text(s));
    ASSERT_TRUE(read.ok()) << read.error().message;
    EXPECT_EQ(read->offset, s.offset);
    EXPECT_EQ(read->range, s.range);
    EXPECT_EQ(read->range_percent, s.range_percent);
    EXPECT_EQ(read->factor, s.factor);
    EXPECT_EQ(read->bone_threshold_hu, s.bone_threshold_hu);
    EXPECT_EQ(read->max_movement_mm, s.max_movement_mm);
    EXPECT_EQ(read->yield, s.yield);
    EXPECT_EQ(read->scale, s.scale);
    EXPECT_EQ(read->brick_size, s.brick_size);
    EXPECT_EQ(read->bounded, s.bounded);
    EXPECT_EQ(read->max_elements, s.max_elements);
    EXPECT_EQ(read->history_max_steps, s.history_max_steps);
    EXPECT_EQ(read->history_max_mb, s.history_max_mb);
    EXPECT_EQ(read->air_threshold_hu, s.air_threshold_hu);
    EXPECT_EQ(settings_text(*read), settings_text(s));
}

TEST_F(StateFileTest, AStateWithTheFormerElasticMaterialIsRefused) {
    for (const char* text : {"[material]\nelastic = [10, 0.45]\n",
                             "[material]\nelastic = [10, 0.45]  # read by the other parser\n"}) {
        const auto read = parse_settings("x.plst", text);
        ASSERT_FALSE(read.ok());
        EXPECT_EQ(read.error().message,
                  "x.plst: [material] elastic: expected [elastic] moduli_kpa and --model elastic, "
                  "which replace it, found a setting that ChainMail no longer has");
    }
}

TEST_F(StateFileTest, CustomLawStaysTheUsersOwn) {
    const auto law = [](int) {
        return ElementLimits{{.3, .3, .3}, {.3, .3, .3}, {.3, .3, .3}, 30, false};
    };
    ChainMailSettings settings;
    settings.custom_law = law;
    ChainMail saved = worked_tissue(settings);
    ASSERT_TRUE(saved.save_state(file).ok());
    ChainMail plain = tissue_of(volume);
    EXPECT_NE(error_of(plain).find("law of its own"), std::string::npos);
    ChainMail same = tissue_of(volume, settings);
    EXPECT_EQ(error_of(same), "");
    EXPECT_EQ(same.hash(), saved.hash());
    // A tighter custom law: the displacements exceed its limits.
    settings.custom_law = [](int) {
        return ElementLimits{{.01, .01, .01}, {.01, .01, .01}, {.01, .01, .01}, 30, false};
    };
    ChainMail tighter = tissue_of(volume, settings);
    EXPECT_NE(error_of(tighter).find("a link is outside of its limits"), std::string::npos);
    settings.custom_law = [&](int value) {
        ElementLimits limits = law(value);
        limits.max_movement_mm = 1;
        return limits;
    };
    ChainMail shorter = tissue_of(volume, settings);
    EXPECT_NE(error_of(shorter).find("farther from its rest position"), std::string::npos);
    settings.custom_law = [&](int value) {
        ElementLimits limits = law(value);
        limits.fixed = true;
        return limits;
    };
    ChainMail fixed = tissue_of(volume, settings);
    EXPECT_NE(error_of(fixed).find("a fixed element has moved"), std::string::npos);
    EXPECT_EQ(fixed.state().moved_elements, 0);
}

TEST_F(StateFileTest, OtherScansAreRefusedByWhatDiffers) {
    ChainMail saved = worked_tissue();
    ASSERT_TRUE(saved.save_state(file).ok());
    const auto expect_refused = [&](const Volume& other, const std::string& why) {
        ChainMail tissue = tissue_of(other);
        const std::string message = error_of(tissue);
        EXPECT_NE(message.find("found one of another: " + why), std::string::npos) << message;
        EXPECT_NE(message.find("state.plst"), std::string::npos);
        EXPECT_EQ(message.find('\n'), std::string::npos);
        EXPECT_EQ(tissue.state().moved_elements, 0);
    };
    expect_refused(noisy_block({20, 18, 17}, kStateFileSeed),
                   "of 20 × 18 × 16 voxels instead of 20 × 18 × 17");
    Volume other = volume;
    other.grid.spacing_mm.z = 1.6;
    expect_refused(other, "with a spacing of 0.7, 0.8, 1.5 mm instead of 0.7, 0.8, 1.6");
    other = volume;
    other.grid.origin_mm.x += 1e-9;
    expect_refused(other, "with its origin at");
    other = volume;
    other.grid.direction.columns[1] = -other.grid.direction.columns[1];
    expect_refused(other, "with other directions");
    other = volume;
    (*std::get_if<0>(&other.voxels))[777] ^= 1;
    expect_refused(other, "with other voxel values");
}

TEST_F(StateFileTest, EveryTruncationIsRefusedAndChangesNothing) {
    ChainMail saved = worked_tissue();
    ASSERT_TRUE(saved.save_state(file).ok());
    const std::string whole = bytes_of(file);
    ChainMail tissue = tissue_of(volume);
    ASSERT_TRUE(tissue.push({.point_mm = middle(), .push_mm = {0, 0, 1}}).ok());
    const std::uint64_t before = tissue.hash();
    Random random(kStateFileSeed);
    for (int n = 0; n < 300; ++n) {
        const int length = n < 60 ? n : random.whole(60, int(whole.size()) - 1);
        folder.write("state.plst", whole.substr(0, std::size_t(length)));
        ASSERT_NE(error_of(tissue), "") << "seed " << kStateFileSeed << ", length " << length;
    }
    folder.write("state.plst", whole + "x");
    EXPECT_NE(error_of(tissue), "");
    EXPECT_EQ(tissue.hash(), before);
    EXPECT_EQ(tissue.undo_steps(), 1);
}

TEST_F(StateFileTest, EveryFlippedBitIsRefused) {
    ChainMail saved = worked_tissue();
    ASSERT_TRUE(saved.save_state(file).ok());
    const std::string whole = bytes_of(file);
    ChainMail tissue = tissue_of(volume);
    Random random(kStateFileSeed);
    for (int n = 0; n < 500; ++n) {
        std::string damaged = whole;
        const int at = n < 200 ? n : random.whole(0, int(whole.size()) - 1);
        damaged[std::size_t(at)] = char(damaged[std::size_t(at)] ^ 1 << random.whole(0, 7));
        folder.write("state.plst", damaged);
        ASSERT_NE(error_of(tissue), "") << "seed " << kStateFileSeed << ", byte " << at;
    }
    EXPECT_EQ(tissue.state().moved_elements, 0);
}

TEST_F(StateFileTest, DamageBehindARightChecksumDoesNotCrash) {
    ChainMailSettings settings;
    settings.yield = 0.3;
    ChainMail saved = worked_tissue(settings);
    ASSERT_TRUE(saved.save_state(file).ok());
    const std::string whole = bytes_of(file);
    ChainMail tissue = tissue_of(volume);
    Random random(kStateFileSeed);
    for (int n = 0; n < 400; ++n) {
        // Behind magic, version, flags, length and fingerprint: data that can be forged with a
        // tool.
        std::string forged = whole;
        for (int k = random.whole(1, 3); k > 0; --k)
            forged[std::size_t(random.whole(168, int(whole.size()) - 9))] =
                char(random.whole(0, 1) ? random.whole(0, 255) : 0xff);
        Hash64 hash;
        for (std::size_t at = 0; at + 8 < forged.size(); at += 8) {
            std::uint64_t word = 0;
            for (std::size_t k = 0; k < 8 && at + k < forged.size() - 8; ++k)
                word |= std::uint64_t(static_cast<unsigned char>(forged[at + k])) << 8 * k;
            hash.add_word(word);
        }
        for (std::size_t k = 0; k < 8; ++k)
            forged[forged.size() - 8 + k] = char(hash.value() >> 8 * k & 0xff);
        folder.write("state.plst", forged);
        const std::string message = error_of(tissue);
        if (message.empty()) {
            // Accepted data must nevertheless be a valid lattice.
            ASSERT_LT(tissue.state().max_violation_mm, 1e-9)
                << "seed " << kStateFileSeed << ", case " << n;
        } else {
            ASSERT_EQ(message.find('\n'), std::string::npos) << message;
        }
    }
}

TEST_F(StateFileTest, NewerVersionsAndOtherFilesAreNamed) {
    ChainMail saved = worked_tissue();
    ASSERT_TRUE(saved.save_state(file).ok());
    ChainMail tissue = tissue_of(volume);
    std::string newer = bytes_of(file);
    newer[8] = 2;
    folder.write("state.plst", newer);
    EXPECT_NE(error_of(tissue).find("expected a state of version 1, found version 2"),
              std::string::npos);
    folder.write("state.plst", "NRRD0004\n");
    EXPECT_NE(error_of(tissue).find("another kind of file"), std::string::npos);
    EXPECT_EQ(tissue.load_state(folder / "nothing.plst").error().code, ErrorCode::NotFound);
    EXPECT_FALSE(tissue.load_state(folder.path()).ok());
}

TEST_F(StateFileTest, SavingToNowhereLeavesNoFile) {
    ChainMail saved = worked_tissue();
    EXPECT_EQ(saved.save_state(folder / "missing/state.plst").error().code, ErrorCode::Unwritable);
    EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

TEST_F(StateFileTest, OpenGroupStopsLoading) {
    ChainMail saved = worked_tissue();
    ASSERT_TRUE(saved.save_state(file).ok());
    saved.begin_group("drag");
    EXPECT_NE(error_of(saved).find("open group"), std::string::npos);
    saved.end_group();
    EXPECT_EQ(error_of(saved), "");
}

TEST(ImprintFault, EachSideOfAnElementIsLookedAt) {
    const TaskArena arena(1);
    const Volume scan = block({16, 16, 16});
    const auto law = [](int) {
        return ElementLimits{{.3, .3, .3}, {.3, .3, .3}, {.3, .3, .3}, 30, false};
    };
    const Vec3i element{7, 7, 7};  // with neighbours in its brick and in others
    for (int linked = -1; linked < 6; ++linked) {
        SCOPED_TRACE(linked);
        Lattice lattice(scan, {law}, 8, false);
        // All of its links are cut, but for one.
        std::map<std::tuple<int, int, int>, BrickEdits> edits;
        for (int side = 0; side < 6; ++side) {
            if (side == linked) continue;
            Vec3i low = element;
            if (side % 2 == 0) --low[side / 2];
            const Vec3i coord = lattice.brick_of(low);
            BrickEdits& of_brick = edits[{coord.x, coord.y, coord.z}];
            of_brick.resize(512);
            of_brick[std::size_t(lattice.index_in_brick(low, coord))] |=
                std::uint8_t(kCutX << side / 2);
        }
        for (auto& [at, of_brick] : edits)
            lattice.set_edits({std::get<0>(at), std::get<1>(at), std::get<2>(at)},
                              std::move(of_brick));
        for (const double share : {0.99, 1.01}) {
            Imprint imprint;
            for (auto& component : imprint) component.assign(512, 0);
            const Vec3i coord = lattice.brick_of(element);
            for (auto& component : imprint)
                component[std::size_t(lattice.index_in_brick(element, coord))] =
                    units_from_mm(share * 0.3);
            PlasticRest rest;
            rest.set(lattice, coord, std::move(imprint));
            const bool fails = share > 1 && linked >= 0;
            EXPECT_EQ(find_imprint_fault(lattice, rest),
                      fails ? "an imprint is outside of a link's limits" : "");
        }
    }
}

}  // namespace
}  // namespace pliant::test
