// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Relaxation and imprints together with all other changes of a tissue: history, drags, cuts,
// changed materials, saved states.
// Covers: chainmail/chainmail_face.cpp.

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include "chainmail/chainmail_impl.h"
#include "chainmail/state_file.h"
#include "chainmail/tissues.h"
#include "lattice/lattice.h"
#include "support/temporary_folder.h"

namespace pliant::test {
namespace {

constexpr std::uint64_t kRelaxStepsSeed = 20260417;

/// The random law, with permanent strain beyond a fraction of its limits.
ChainMailSettings yielding_settings(Random& random, const Instance& instance) {
    ChainMailSettings settings;
    settings.custom_law = [law = instance.law, yield = random.real(0.1, 0.6)](int value) {
        ElementLimits limits = law(value);
        limits.yield = value % 3 == 0 ? 0 : yield;
        return limits;
    };
    settings.brick_size = random.whole(2, 9);
    return settings;
}

/// State that undo must restore.
struct Snapshot {
    std::uint64_t hash;
    std::vector<Vec3d> imprints_mm;
    friend bool operator==(const Snapshot&, const Snapshot&) = default;
    bool any_imprint() const {
        return std::any_of(imprints_mm.begin(), imprints_mm.end(), [](Vec3d p) {
            return p != Vec3d{0, 0, 0};
        });
    }
};

Snapshot snapshot_of(const ChainMail& tissue) {
    Snapshot snapshot{tissue.hash(), {}};
    const Box3i box = voxel_box(tissue.volume().grid);
    for (int z = -3; z < box.end.z + 3; ++z)
        for (int y = -3; y < box.end.y + 3; ++y)
            for (int x = -3; x < box.end.x + 3; ++x)
                snapshot.imprints_mm.push_back(tissue.imprint_mm({x, y, z}));
    return snapshot;
}

void random_step(Random& random, ChainMail& tissue, double reach) {
    const Grid& grid = tissue.volume().grid;
    switch (random.whole(0, 9)) {
        case 0:
            return random_cut(random, tissue);
        case 1:
            return random_carve(random, tissue);
        case 2:
            tissue.reset();
            break;
        case 3:
            ASSERT_TRUE(tissue.grab_elements(random_grab(random, grid), reach).ok());
            ASSERT_TRUE(tissue.drag_to(random.vector(reach)).ok());
            ASSERT_TRUE(tissue.relax({.max_sweeps = 2}).ok());
            ASSERT_TRUE(tissue.drag_to(random.vector(reach)).ok());
            tissue.let_go();
            break;
        case 4:
        case 5:
        case 6:
            ASSERT_TRUE(tissue.relax({.max_sweeps = random.whole(1, 40)}).ok());
            break;
        default:
            return random_push(random, tissue, reach);
    }
}

void run_history(std::uint64_t seed, int& imprints) {
    Random random(seed);
    const TaskArena arena(random.whole(1, 2));
    const Instance instance = random_instance(random, 5, 10, true);
    ChainMail tissue = tissue_of(instance.volume, arena, yielding_settings(random, instance));
    const double reach = 3 * instance.push_limit_mm.x;
    std::vector<Snapshot> known = {snapshot_of(tissue)};  // after each step that can be undone
    for (int n = 0; n < 40; ++n) {
        const auto at = std::size_t(tissue.undo_steps());
        if (random.whole(0, 4) == 0 && at > 0) {
            ASSERT_TRUE(tissue.undo().ok());
            ASSERT_TRUE(snapshot_of(tissue) == known[at - 1]) << "step " << n;
            continue;
        }
        if (random.whole(0, 4) == 0 && tissue.redo_steps() > 0) {
            ASSERT_TRUE(tissue.redo().ok());
            ASSERT_TRUE(snapshot_of(tissue) == known[at + 1]) << "step " << n;
            continue;
        }
        random_step(random, tissue, reach);
        const Snapshot now = snapshot_of(tissue);
        if (now == known[at]) continue;
        ASSERT_EQ(std::size_t(tissue.undo_steps()), at + 1) << "step " << n;
        known.resize(at + 1);
        known.push_back(now);
        imprints += now.any_imprint();
        ASSERT_LT(tissue.state().max_violation_mm, 1e-9);
    }
    for (auto at = std::size_t(tissue.undo_steps()); at > 0; --at) {
        ASSERT_TRUE(tissue.undo().ok());
        ASSERT_TRUE(snapshot_of(tissue) == known[at - 1]) << at;
    }
    EXPECT_EQ(tissue.state().resident_bricks, 0);
    EXPECT_FALSE(snapshot_of(tissue).any_imprint());
    while (tissue.redo_steps() > 0) ASSERT_TRUE(tissue.redo().ok());
    EXPECT_TRUE(snapshot_of(tissue) == known.back());
}

TEST(RelaxSteps, UndoAndRedoBringDisplacementsAndImprintsBack) {
    int imprints = 0;
    for (std::uint64_t n = 0; n < 12 && !::testing::Test::HasFailure(); ++n) {
        SCOPED_TRACE("seed " + std::to_string(kRelaxStepsSeed + n));
        run_history(kRelaxStepsSeed + n, imprints);
    }
    EXPECT_GT(imprints, 20);
}

TEST(RelaxSteps, SliceThatMovesSomethingIsAStepWithItsName) {
    const TaskArena arena(2);
    const Volume volume = block({20, 20, 20}, 0);
    ChainMail tissue = tissue_of(volume, arena);
    ASSERT_TRUE(tissue.relax({.max_sweeps = 3}).ok());
    EXPECT_EQ(tissue.undo_steps(), 0);
    ASSERT_TRUE(tissue.push({.point_mm = {9.5, 9.5, 9.5}, .push_mm = {2, 0, 0}}).ok());
    EXPECT_EQ(tissue.next_undo_name(), "push");
    const std::uint64_t pushed = tissue.hash();
    ASSERT_TRUE(tissue.relax({.max_sweeps = 0}).ok());
    EXPECT_EQ(tissue.undo_steps(), 1);
    ASSERT_TRUE(tissue.relax({.max_sweeps = 3}).ok());
    EXPECT_EQ(tissue.undo_steps(), 2);
    EXPECT_EQ(tissue.next_undo_name(), "relax");
    // Completely to rest, where bricks are dropped, too.
    const auto settled = tissue.relax({});
    ASSERT_TRUE(settled.ok() && settled->settled);
    EXPECT_EQ(tissue.state().resident_bricks, 0);
    ASSERT_TRUE(tissue.undo().ok() && tissue.undo().ok());
    EXPECT_EQ(tissue.hash(), pushed);
}

void run_drag(std::uint64_t seed, int& moved_by_relaxation) {
    Random random(seed);
    const TaskArena arena(1 + int(seed % 2));
    const Instance instance = random_instance(random, 5, 12, true);
    ChainMailSettings settings = yielding_settings(random, instance);
    settings.brick_size = 8;
    ChainMail dragged = tissue_of(instance.volume, arena, settings);
    ChainMail pushed = tissue_of(instance.volume, arena, settings);
    const auto both_push = [&](const std::vector<Vec3i>& elements, Vec3d push_mm) {
        ASSERT_TRUE(dragged.push_elements(elements, push_mm).ok());
        ASSERT_TRUE(pushed.push_elements(elements, push_mm).ok());
    };
    constexpr double kReach_mm = 2;
    const std::vector<Vec3i> first = random_grab(random, instance.volume.grid);
    both_push(first, random.vector(kReach_mm));
    const std::vector<Vec3i> grabbed = random_grab(random, instance.volume.grid);
    const int steps = dragged.undo_steps();
    const std::uint64_t hash = dragged.hash();
    ASSERT_TRUE(dragged.grab_elements(grabbed, random.real(0.5, 4)).ok());
    const Vec3<Fixed> start = lattice_of(dragged).displacement_at(grabbed[0]);
    for (int frame = 0; frame < 10; ++frame) {
        Vec3d offset = random.vector(kReach_mm);
        for (int a = 0; a < 3; ++a) offset[a] = std::round(offset[a] * 1024) / 1024;
        const Vec3<Fixed> now = lattice_of(dragged).displacement_at(grabbed[0]) - start;
        const Vec3d now_mm{mm_from_units(now.x), mm_from_units(now.y), mm_from_units(now.z)};
        const auto drag = dragged.drag_to(offset);
        const auto push = pushed.push_elements(grabbed, offset - now_mm);
        ASSERT_TRUE(drag.ok() && push.ok());
        ASSERT_EQ(dragged.hash(), pushed.hash()) << "frame " << frame;
        ASSERT_EQ(drag->step_fraction, push->step_fraction) << "frame " << frame;
        if (random.whole(0, 1)) continue;
        const std::uint64_t before = pushed.hash();
        const int sweeps = random.whole(1, 20);
        ASSERT_TRUE(dragged.relax({.max_sweeps = sweeps}).ok());
        ASSERT_TRUE(pushed.relax({.max_sweeps = sweeps, .held = grabbed}).ok());
        ASSERT_TRUE(dragged.is_grabbing());
        ASSERT_EQ(dragged.hash(), pushed.hash()) << "frame " << frame << ", relaxed";
        moved_by_relaxation += pushed.hash() != before;
    }
    ASSERT_TRUE(snapshot_of(dragged) == snapshot_of(pushed));
    dragged.let_go();
    ASSERT_LE(dragged.undo_steps(), steps + 1) << "the drag with its relaxations is one step";
    if (dragged.undo_steps() > steps) {
        ASSERT_TRUE(dragged.undo().ok());
        ASSERT_EQ(dragged.hash(), hash);
        ASSERT_TRUE(dragged.redo().ok());
    }
    ASSERT_EQ(dragged.state().moved_elements, pushed.state().moved_elements);
    ASSERT_TRUE(dragged.relax({.max_sweeps = 5}).ok() && pushed.relax({.max_sweeps = 5}).ok());
    ASSERT_EQ(dragged.hash(), pushed.hash());
}

TEST(RelaxSteps, DragThatRelaxesBetweenItsStepsEqualsPushesThatDo) {
    int moved_by_relaxation = 0;
    for (std::uint64_t n = 0; n < 40 && !::testing::Test::HasFailure(); ++n) {
        SCOPED_TRACE("seed " + std::to_string(kRelaxStepsSeed + n));
        run_drag(kRelaxStepsSeed + n, moved_by_relaxation);
    }
    EXPECT_GT(moved_by_relaxation, 100);
}

class RelaxStateTest : public ::testing::Test {
  protected:
    RelaxStateTest() { settings.yield = 0.25; }
    ChainMail pushed_tissue() {
        ChainMail tissue = tissue_of(volume, arena, settings);
        EXPECT_TRUE(tissue.push({.point_mm = {9.5, 9.5, 9.5}, .push_mm = {2, -1, 0.5}}).ok());
        EXPECT_TRUE(tissue.relax({.max_sweeps = 3}).ok());
        return tissue;
    }

    TaskArena arena{2};
    Volume volume = block({20, 20, 20}, 0);
    ChainMailSettings settings;
    TemporaryFolder folder;
    std::filesystem::path file = folder / "state.plst";
};

TEST_F(RelaxStateTest, SavedStateHasTheImprintsAndRelaxesAsItWouldHave) {
    ChainMail saved = pushed_tissue();
    ASSERT_TRUE(saved.save_state(file).ok());
    ChainMail loaded = tissue_of(volume, arena);
    const Status status = loaded.load_state(file);
    ASSERT_TRUE(status.ok()) << status.error().message;
    EXPECT_EQ(loaded.settings().yield, 0.25);
    EXPECT_TRUE(snapshot_of(loaded).any_imprint());
    EXPECT_TRUE(snapshot_of(loaded) == snapshot_of(saved));
    ASSERT_TRUE(loaded.relax({}).ok() && saved.relax({}).ok());
    EXPECT_TRUE(snapshot_of(loaded) == snapshot_of(saved));
    EXPECT_EQ(loaded.elastic_energy_mm2(), saved.elastic_energy_mm2());
    EXPECT_GT(norm(loaded.displacement_mm({9, 9, 9})), 1);
}

TEST_F(RelaxStateTest, ImprintsThatNoPushLeavesAreRefused) {
    ChainMail tissue = pushed_tissue();
    const Snapshot before = snapshot_of(tissue);
    const auto load_with = [&](Vec3i element, Fixed p) {
        EXPECT_TRUE(tissue.save_state(file).ok());
        std::ifstream in(file, std::ios::binary);
        const std::string text{std::istreambuf_iterator<char>(in), {}};
        auto reader = StateReader::open("x", std::as_bytes(std::span(text)));
        EXPECT_TRUE(reader.ok());
        const auto header = reader->read_header();
        EXPECT_TRUE(header.ok());
        const Lattice& lattice = lattice_of(tissue);
        const auto n = std::size_t(lattice.elements_per_brick());
        std::array<std::vector<Fixed>, 3> imprint;
        imprint.fill(std::vector<Fixed>(n, 0));
        imprint[1][std::size_t(lattice.index_in_brick(element))] = p;
        PlasticRest imprints;
        imprints.set(lattice, lattice.brick_of(element), imprint);
        const Bytes forged = encode_state(*header, lattice, imprints);
        std::ofstream(file, std::ios::binary)
            .write(reinterpret_cast<const char*>(forged.data()), std::streamsize(forged.size()));
        const Status status = tissue.load_state(file);
        return status.ok() ? std::string() : status.error().message;
    };
    EXPECT_NE(load_with({9, 9, 9}, 1 << 20).find("an imprint is outside"), std::string::npos);
    // The first element of a brick: the link leads to another one, which has no imprint.
    EXPECT_NE(load_with({8, 8, 8}, -(1 << 20)).find("an imprint is outside"), std::string::npos);
    EXPECT_NE(load_with({9, 9, 9}, INT32_MIN).find("damaged"), std::string::npos);
    EXPECT_TRUE(snapshot_of(tissue) == before) << "what is refused changes nothing";
    EXPECT_EQ(load_with({9, 9, 9}, 100), "");
}

TEST_F(RelaxStateTest, CutsAndMaterialsBetweenSlicesCountFromTheNextOne) {
    const auto relaxed_after = [&](const auto& change, bool through_file) {
        ChainMail tissue = pushed_tissue();
        change(tissue);
        if (through_file) {
            EXPECT_TRUE(tissue.save_state(file).ok());
            EXPECT_TRUE(tissue.load_state(file).ok());
        }
        EXPECT_TRUE(tissue.relax({.max_sweeps = 7}).ok());
        EXPECT_EQ(tissue.state().max_violation_mm, 0);
        return tissue.hash();
    };
    const auto nothing = [](ChainMail&) {};
    const auto cut = [](ChainMail& tissue) {
        EXPECT_TRUE(tissue.cut({{{0, 9.7, 5}, {19, 9.7, 5}}, {0, 0, 9}}).ok());
    };
    const auto uncut = [&](ChainMail& tissue) {
        cut(tissue);
        EXPECT_TRUE(tissue.relax({.max_sweeps = 1}).ok());
        EXPECT_TRUE(tissue.undo().ok() && tissue.undo().ok());
    };
    const auto harder = [&](ChainMail& tissue) {
        ChainMailSettings other = settings;
        other.offset = 0.1;
        EXPECT_TRUE(tissue.set_materials(other).ok());
    };
    EXPECT_EQ(relaxed_after(cut, false), relaxed_after(cut, true));
    EXPECT_EQ(relaxed_after(uncut, false), relaxed_after(nothing, true));
    EXPECT_EQ(relaxed_after(harder, false), relaxed_after(harder, true));
    EXPECT_NE(relaxed_after(harder, false), relaxed_after(nothing, false));
}

TEST_F(RelaxStateTest, RelaxationBringsExcusedLinksBack) {
    settings.yield = 0;
    ChainMail tissue = pushed_tissue();
    ChainMailSettings harder = settings;
    harder.offset = 0.02;
    ASSERT_TRUE(tissue.set_materials(harder).ok());
    std::int64_t excused = tissue.state().excused_links;
    ASSERT_GT(excused, 100);
    for (int n = 0; n < 30; ++n) {
        ASSERT_TRUE(tissue.relax({.max_sweeps = 1}).ok());
        const LatticeState state = tissue.state();
        ASSERT_EQ(state.max_violation_mm, 0) << n;
        ASSERT_LE(state.excused_links, excused) << n;
        excused = state.excused_links;
    }
    ASSERT_TRUE(tissue.relax({}).ok());
    EXPECT_EQ(tissue.state().excused_links, 0);
    EXPECT_FALSE(lattice_of(tissue).may_exceed_limits());
}

TEST_F(RelaxStateTest, ResetAndCarvingTakeImprintsAway) {
    ChainMail tissue = pushed_tissue();
    const Snapshot before = snapshot_of(tissue);
    const Vec3d place = Vec3d{9, 9, 9} + tissue.displacement_mm({9, 9, 9});
    ASSERT_TRUE(tissue.carve({place, place, 0.1}).ok());
    EXPECT_EQ(tissue.imprint_mm({9, 9, 9}), (Vec3d{0, 0, 0}));
    EXPECT_TRUE(snapshot_of(tissue).any_imprint());
    tissue.reset();
    EXPECT_FALSE(snapshot_of(tissue).any_imprint());
    ASSERT_TRUE(tissue.relax({}).ok());
    EXPECT_EQ(tissue.moved_box(), Box3i{});
    ASSERT_TRUE(tissue.undo().ok() && tissue.undo().ok());
    EXPECT_TRUE(snapshot_of(tissue) == before);
}

TEST_F(RelaxStateTest, OneLabelYieldsAndTheRestDoesNot) {
    Volume labels = block({20, 20, 20}, 0);
    auto& values = std::get<0>(labels.voxels);
    for (int z = 0; z < 20; ++z)
        for (int y = 0; y < 20; ++y)
            for (int x = 0; x < 20; ++x)
                values[voxel_index(labels.grid, {x, y, z})] = x >= 10 ? 1 : 0;
    settings.labels = std::make_shared<const Volume>(labels);
    for (const bool by_value : {true, false}) {
        LabelMaterial clay{.values = {1}, .yield = 0.25};
        if (!by_value) {
            clay.law = LabelLaw::Constant;
            clay.compress = clay.stretch = clay.shear = {0.2, 0.2, 0.2};
        }
        settings.label_materials = {clay};
        settings.yield = 0;
        ChainMail tissue = tissue_of(volume, arena, settings);
        ASSERT_TRUE(tissue.push_elements({{{14, 10, 10}}}, {0.5, 0, 0}).ok());
        EXPECT_GT(tissue.imprint_mm({14, 10, 10}).x, 0.3) << by_value;
        ASSERT_TRUE(tissue.push_elements({{{4, 10, 10}}}, {0.5, 0, 0}).ok());
        EXPECT_EQ(tissue.imprint_mm({4, 10, 10}).x, 0) << by_value;
    }
    settings.label_materials[0].yield = 1.5;
    const auto wrong = ChainMail::create(volume, settings, arena);
    ASSERT_FALSE(wrong.ok());
    EXPECT_EQ(wrong.error().message, "[[label]] 1 yield: expected 0 to 1, found 1.5");
}

}  // namespace
}  // namespace pliant::test
