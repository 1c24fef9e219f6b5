// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Each allocation fails once, without lasting effects.
// Covers: resample/control_lattice.cpp, resample/fields.cpp, resample/live_deformation.cpp.

#include <gtest/gtest.h>
#include <pliant/chainmail.h>
#include <pliant/resample.h>

#include <optional>

#include "resample/lattices.h"
#include "support/each_allocation.h"
#include "support/random.h"
#include "volume/boxes.h"

namespace pliant::test {
namespace {

/// A lattice with displacements set by hand.
class Handmade : public MovingScan {
  public:
    explicit Handmade(const TaskArena& arena) : m_arena(arena) {
        Random random(7);
        m_volume = make_volume({40, 30, 26}, {1, 0.8, 1.2},
                               [&](Vec3d) { return std::int16_t(random.whole(-900, 900)); });
        m_lattice.emplace(m_volume, std::vector<MaterialLaw>{draeger_law({})}, 8, false);
        m_deformation.emplace(*m_lattice);
    }
    const Volume& volume() const override { return m_volume; }
    const Deformation& deformation() const override { return *m_deformation; }
    const TaskArena& arena() const override { return m_arena; }
    Lattice& lattice() { return *m_lattice; }

  private:
    const TaskArena& m_arena;
    Volume m_volume;
    std::optional<Lattice> m_lattice;
    std::optional<Deformation> m_deformation;
};

/// Folded, torn and moved cells: all paths through the resampler.
void deform(Lattice& lattice, double x_mm) {
    displace(lattice, {{6, 6, 6}, {22, 20, 18}}, [&](Vec3d p) {
        return Vec3d{x_mm * std::sin(0.9 * p.y), 1.5 * std::cos(0.8 * p.x), 0.7 * std::sin(p.z)};
    });
    edit(lattice, {12, 10, 10}, kVoid);
    edit(lattice, {15, 12, 9}, kCutX | kCutY);
}

/// A displayed tissue, and a second picture that gets the updated boxes only.
struct Shown {
    explicit Shown(const TaskArena& arena)
        : scan(arena), live(LiveDeformation::create(scan).value()), picture(scan.volume()) {}
    Status update() {
        const Result<LiveUpdate> update = live.update();
        if (!update) return update.error();
        for (const Box3i& box : update->boxes)
            for_each_in(box, [&](Vec3i p) {
                const std::size_t at = voxel_index(picture.grid, p);
                std::get<VoxelArray<std::int16_t>>(picture.voxels)[at] =
                    std::get<VoxelArray<std::int16_t>>(live.volume().voxels)[at];
            });
        return Ok{};
    }

    Handmade scan;
    LiveDeformation live;
    Volume picture;
};

TEST(OutOfMemory, AnUpdateThatSucceedsAfterFailedOnesShowsAllOfTheDeformation) {
    const TaskArena arena(1);
    for (const bool keeps_sources : {false, true}) {
        const auto make = [&] {
            auto shown = std::make_unique<Shown>(arena);
            deform(shown->scan.lattice(), 2);
            EXPECT_TRUE(shown->update().ok());
            if (keeps_sources) {
                EXPECT_TRUE(shown->live.keep_sources(true));
            }
            // Some elements return to rest, others move for the first time.
            displace(shown->scan.lattice(), {{6, 6, 6}, {14, 20, 18}}, [](Vec3d) {
                return Vec3d{0, 0, 0};
            });
            displace(shown->scan.lattice(), {{24, 8, 8}, {36, 26, 24}}, [](Vec3d p) {
                return Vec3d{1.4 * std::sin(p.z), 0.6, 2 * std::cos(p.x)};
            });
            return shown;
        };
        const auto sources = [&](const Shown& shown) {
            std::vector<float> values;
            if (!keeps_sources) return values;
            values.resize(voxel_count(shown.picture.grid));
            shown.live.displacement_mm(voxel_box(shown.picture.grid), values);
            return values;
        };
        // The voxels equal the twin's once the update has succeeded, and only then.
        const auto lattice = [](const Shown& shown) {
            return hash_volume(deform_volume(shown.scan).value().volume);
        };
        const Failures failures = fail_each_allocation(
            make, [](Shown& shown) { return shown.update(); }, lattice);
        EXPECT_GT(failures.failed, 20);
        auto twin = make();
        ASSERT_TRUE(twin->update().ok());
        for (const std::int64_t n : chosen(failures.allocations, {})) {
            auto shown = make();
            for (int again = 0; again < 2; ++again) {
                const FailingAllocation failing(n);
                (void)shown->update();
            }
            // Tissue that was deformed at a failed update may be at rest at the next successful
            // one.
            if (n % 2)
                displace(shown->scan.lattice(), {{24, 8, 8}, {36, 26, 24}}, [](Vec3d) {
                    return Vec3d{0, 0, 0};
                });
            ASSERT_TRUE(shown->update().ok());
            const Volume once = deform_volume(shown->scan).value().volume;
            ASSERT_EQ(shown->live.volume().voxels, once.voxels) << "allocation " << n;
            ASSERT_EQ(shown->picture.voxels, once.voxels) << "allocation " << n;
            if (n % 2) continue;
            ASSERT_EQ(shown->picture.voxels, twin->picture.voxels) << "allocation " << n;
            ASSERT_EQ(sources(*shown), sources(*twin)) << "allocation " << n;
        }
    }
}

// Also in the short run: the allocation that fails is of the update that fills them.
TEST(LiveDeformation, SaysThatSourcesCantBeKept) {
    const TaskArena arena(1);
    Shown shown(arena);
    deform(shown.scan.lattice(), 2);
    bool keeps = true;
    {
        const FailingAllocation failing(0);
        keeps = shown.live.keep_sources(true);
    }
    EXPECT_FALSE(keeps);
    EXPECT_FALSE(shown.live.keeps_sources());
    EXPECT_TRUE(shown.live.keep_sources(true));
    EXPECT_TRUE(shown.live.keeps_sources());
    EXPECT_FALSE(shown.live.keep_sources(false));
    EXPECT_FALSE(shown.live.keeps_sources());
}

TEST(OutOfMemory, SourcesThatCantBeKeptLeaveThePicture) {
    const TaskArena arena(1);
    Shown shown(arena);
    deform(shown.scan.lattice(), 2);
    ASSERT_TRUE(shown.update().ok());
    const Volume once = deform_volume(shown.scan).value().volume;
    int failed = 0;
    for (std::int64_t n = 0;; ++n) {
        bool keeps = false;
        {
            const FailingAllocation failing(n);
            keeps = shown.live.keep_sources(true);
        }
        ASSERT_EQ(shown.live.keeps_sources(), keeps);
        if (keeps) break;
        ++failed;
        ASSERT_TRUE(shown.update().ok());
        ASSERT_EQ(shown.live.volume().voxels, once.voxels) << "allocation " << n;
        ASSERT_EQ(shown.picture.voxels, once.voxels) << "allocation " << n;
    }
    EXPECT_GT(failed, 0);
    EXPECT_EQ(shown.live.volume().voxels, once.voxels);
}

TEST(OutOfMemory, AnotherTissueMayTakeThePlaceOfTheFirst) {
    const TaskArena arena(1);
    Shown shown(arena);
    deform(shown.scan.lattice(), 2);
    ASSERT_TRUE(shown.update().ok());
    shown.live.start_over(shown.scan);
    EXPECT_EQ(shown.live.volume().voxels, shown.scan.volume().voxels);
    shown.scan.lattice().drop_all_bricks();
    displace(shown.scan.lattice(), {{24, 8, 8}, {36, 26, 24}}, [](Vec3d) {
        return Vec3d{0.3, 0.6, 0};
    });
    ASSERT_TRUE(shown.update().ok());
    EXPECT_EQ(shown.picture.voxels, deform_volume(shown.scan).value().volume.voxels);
}

TEST(OutOfMemory, WhatIsMadeFromATissueIsMadeOrRefused) {
    const TaskArena arena(1);
    const auto make = [&] {
        auto scan = std::make_unique<Handmade>(arena);
        deform(scan->lattice(), 2);
        return scan;
    };
    // The tissue is const throughout; the results are compared.
    std::optional<std::uint64_t> made;
    const auto same = [&](std::uint64_t hash) {
        EXPECT_EQ(made.value_or(hash), hash);
        made = hash;
    };
    const auto state = [](const Handmade&) { return 0; };
    for (const Mapping mapping : {Mapping::Cells, Mapping::CellsScalar, Mapping::Tetrahedra}) {
        made.reset();
        fail_each_allocation(
            make,
            [&](Handmade& scan) {
                auto deformed = deform_volume(scan, mapping, true);
                if (deformed.ok()) same(hash_volume(deformed->volume));
                return deformed;
            },
            state);
    }
    const auto each = [&](const auto& function) {
        const EachAllocation few{.all_up_to = 80, .of_the_rest = 20};
        fail_each_allocation(make, function, state, few);
    };
    each([](Handmade& scan) { return jacobian_field(scan); });
    each([](Handmade& scan) { return strain_field(scan); });
    each([](Handmade& scan) { return displacement_slices(scan); });
    each([](Handmade& scan) { return state_of(scan); });
    each([](Handmade& scan) { return LiveDeformation::create(scan); });
    const Deformed deformed = deform_volume(*make(), Mapping::Cells, true).value();
    each([&](Handmade&) { return inverse_field(deformed); });
}

TEST(OutOfMemory, AControlLatticeIsMadeOrRefused) {
    const TaskArena arena(1);
    const Volume volume =
        make_volume({40, 40, 34}, {1, 1, 1}, [](Vec3d) { return std::int16_t(0); });
    const ControlGrid grid{{2, 2, 1}, {8, 8, 8}, {5, 5, 4}};
    fail_each_allocation([&] { return &volume; },
                         [&](const Volume&) { return ControlLattice::create(volume, grid, arena); },
                         [](const Volume&) { return 0; });
}

TEST(OutOfMemory, AControlLatticeKeepsItsPlace) {
    const TaskArena arena(1);
    Random random(3);
    const Volume volume = make_volume({40, 40, 34}, {1, 1, 1},
                                      [&](Vec3d) { return std::int16_t(random.whole(-900, 900)); });
    const ControlGrid grid{{2, 2, 1}, {8, 8, 8}, {5, 5, 4}};
    std::vector<Vec3d> first(100), second(100);
    for (std::size_t n = 0; n < 100; ++n) {
        // The second one needs additional bricks.
        if (n < 25) first[n] = random.vector(2);
        if (n % 5 == 1) second[n] = random.vector(3);
    }
    const auto make = [&] {
        auto lattice = std::move(ControlLattice::create(volume, grid, arena)).value();
        EXPECT_TRUE(lattice->place(first).ok());
        return lattice;
    };
    const auto state = [](const ControlLattice& lattice) {
        return hash_volume(deform_volume(lattice).value().volume);
    };
    const Failures failures =
        fail_each_allocation(make, [&](ControlLattice& lattice) { return lattice.place(second); },
                             state, {.fresh = true});
    EXPECT_GT(failures.failed, 2);
}

}  // namespace
}  // namespace pliant::test
