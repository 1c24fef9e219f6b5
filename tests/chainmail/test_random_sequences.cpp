// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// All operations on a tissue, in random order, thousands of times, on two tissues at once: the
// sweep on two threads and the heap on one, with other bricks. After each operation both must be
// equal bit for bit, every link valid, no cell folded if the certificate excludes it, and an undo
// must restore the whole state.
// Covers: chainmail/carve.cpp, chainmail/operation.cpp.

#include <gtest/gtest.h>
#include <pliant/chainmail.h>

#include <cmath>
#include <deque>
#include <string>

#include "support/random.h"
#include "support/temporary_folder.h"

namespace pliant::test {
namespace {

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr int kOperations = 150;
#else
constexpr int kOperations = 1500;
#endif
constexpr int kHistorySteps = 40;
constexpr int kHistoryMb = 64;  // never reached: the memory of a step depends on the bricks

/// Tissue with a lumen, soft and hard regions, and a little bone. Along one axis there is a single
/// brick, which halves the cost of the checks after each operation.
Volume scan_of(Random& random) {
    Volume volume;
    volume.grid.size = {random.whole(9, 13), random.whole(8, 12), random.whole(7, 11)};
    volume.grid.size[random.whole(0, 2)] = random.whole(6, 8);
    for (int a = 0; a < 3; ++a) volume.grid.spacing_mm[a] = random.real(0.7, 2.2);
    volume.grid.direction = random.rotation(random.whole(0, 1) == 1);
    const Vec3i n = volume.grid.size;
    std::vector<std::int16_t> values;
    for (int z = 0; z < n.z; ++z)
        for (int y = 0; y < n.y; ++y)
            for (int x = 0; x < n.x; ++x) {
                const double r = std::hypot(y - 0.5 * n.y, z - 0.5 * n.z);
                const int tissue = int(200 * std::sin(0.7 * x + 0.4 * y) * std::cos(0.5 * z));
                values.push_back(std::int16_t(r < 2.2 ? -1000 : tissue + random.whole(-20, 20)));
            }
    values[std::size_t(random.whole(0, int(values.size()) - 1))] = 1200;
    volume.voxels = values;
    return volume;
}

/// Length of pushes. In a lattice without a border they also move air beyond the scan, by the cube
/// of push / offset, and the checks visit each element: so there they are short, and the tissue is
/// soft.
double longest_push_mm(bool bounded) {
    return bounded ? 3 : 1.5;
}

/// @param bounded  the lattice ends at the scan's border
ChainMailSettings settings_of(Random& random, bool bounded) {
    ChainMailSettings settings;
    settings.offset = random.ratio(bounded ? 0.03 : 0.3, 0.6);
    settings.bone_threshold_hu = random.real(150, 900);
    settings.max_movement_mm = random.real(1, bounded ? 8 : 4);
    settings.air_enabled = random.whole(0, 2) > 0;
    settings.air_threshold_hu = random.real(-700, -300);
    settings.limits = random.whole(0, 19) == 0 ? LinkLimits::Rounded : LinkLimits::Box;
    settings.yield = random.whole(0, 1) ? random.real(0.2, 0.9) : 0;
    settings.bounded = bounded;
    settings.history_max_steps = kHistorySteps;
    settings.history_max_mb = kHistoryMb;
    return settings;
}

class Sequence {
  public:
    Sequence(std::uint64_t seed, bool bounded)
        : m_random(seed),
          m_bounded(bounded),
          m_volume(scan_of(m_random)),
          m_sweep(create(ChainMailSolver::Sweep, 8, m_two)),
          m_heap(create(ChainMailSolver::Heap, 5, m_one)) {}

    void run(int operations) {
        for (m_count = 0; m_count < operations; ++m_count) {
            const std::uint64_t before = m_sweep.hash();
            const int steps = m_sweep.undo_steps();
            m_name.clear();
            do_something();
            remember(before, steps);
            check();
            if (testing::Test::HasFailure()) {
                ADD_FAILURE() << "after operation " << m_count << ", " << m_name;
                return;
            }
        }
        finish();
    }

  private:
    ChainMail create(ChainMailSolver solver, int brick_size, const TaskArena& arena) {
        ChainMailSettings settings = m_settings;
        settings.solver = solver;
        settings.brick_size = brick_size;
        return std::move(ChainMail::create(m_volume, settings, arena)).value();
    }

    /// Runs the operation on both; the reports' statuses must be equal.
    template <class Work>
    void both(const char* name, const Work& work) {
        m_name += std::string(m_name.empty() ? "" : ", ") + name;
        const bool first = work(m_sweep), second = work(m_heap);
        EXPECT_EQ(first, second);
    }

    Vec3d anywhere() {
        Vec3d ijk{};
        for (int a = 0; a < 3; ++a) ijk[a] = m_random.real(0, m_volume.grid.size[a] - 1);
        return world_from_voxel(m_volume.grid, ijk);
    }

    void do_something() {
        const int choice = m_random.whole(0, 99);
        if (choice < 32) return push();
        if (choice < 34) return slide();
        if (choice < 44) return drag();
        if (choice < 58) return relax();
        if (choice < 64) return cut();
        if (choice < 69) return carve();
        if (choice < 77) return change_materials();
        if (choice < 87) return undo();
        if (choice < 92) return redo();
        if (choice < 95) return save();
        if (choice < 98) return load();
        if (choice < 99) return group();
        both("reset", [](ChainMail& tissue) {
            tissue.reset();
            return true;
        });
    }

    void push() {
        Push push{.point_mm = anywhere(), .push_mm = m_random.vector(m_longest_mm)};
        if (m_random.whole(0, 1)) push.sphere_radius_mm = m_random.real(1, 4);
        std::int64_t moved[2] = {0, 0};
        both("push", [&](ChainMail& tissue) {
            const auto report = tissue.push(push);
            if (report.ok()) moved[&tissue == &m_heap] = report->moved_elements;
            return report.ok();
        });
        EXPECT_EQ(moved[0], moved[1]);
    }

    void slide() {
        const Push path{anywhere(), m_random.vector(m_longest_mm), m_random.real(1, 2.5)};
        both("slide", [&](ChainMail& tissue) { return slide_sphere(tissue, path).ok(); });
    }

    void drag() {
        const Push place{.point_mm = anywhere(), .sphere_radius_mm = m_random.real(0, 3)};
        const double reach = m_random.real(1, 6);
        both("grab", [&](ChainMail& tissue) { return tissue.grab(place, reach).ok(); });
        for (int n = m_random.whole(1, 4); n > 0; --n) {
            const Vec3d offset = m_random.vector(1.3 * m_longest_mm);
            both("drag", [&](ChainMail& tissue) { return tissue.drag_to(offset).ok(); });
        }
        // The next operation ends the drag, if this one doesn't.
        if (m_random.whole(0, 3))
            both("let go", [](ChainMail& tissue) {
                tissue.let_go();
                return true;
            });
    }

    void relax() {
        RelaxOptions options;
        options.max_sweeps = m_random.whole(1, 12);
        options.over_relaxation = m_random.real(1, 1.95);
        options.measure_energy = true;
        if (m_random.whole(0, 1))
            options.tools.push_back({anywhere(), anywhere(), m_random.real(0.5, 3)});
        both("relax", [&](ChainMail& tissue) {
            const auto report = tissue.relax(options);
            if (!report.ok()) return false;
            EXPECT_LE(report->energy_after_mm2, report->energy_before_mm2);
            return true;
        });
    }

    void cut() {
        const CutSurface surface{{anywhere(), anywhere()}, m_random.vector(8)};
        both("cut", [&](ChainMail& tissue) { return tissue.cut(surface).ok(); });
    }

    void carve() {
        const CarveTool tool{anywhere(), anywhere(), m_random.real(0.5, 1.5),
                             m_random.whole(0, 1) == 1};
        both("carve", [&](ChainMail& tissue) { return tissue.carve(tool).ok(); });
    }

    void change_materials() {
        const ChainMailSettings changed = settings_of(m_random, m_bounded);
        both("change materials", [&](ChainMail& tissue) {
            ChainMailSettings settings = changed;
            settings.brick_size = tissue.settings().brick_size;
            settings.solver = tissue.settings().solver;
            return tissue.set_materials(settings).ok();
        });
        m_largest_movement = std::max(m_largest_movement, changed.max_movement_mm);
    }

    void undo() {
        both("undo", [](ChainMail& tissue) { return tissue.undo().ok(); });
        // A drag under way first ends as a step of its own.
        m_is_undo = true;
    }
    void redo() {
        both("redo", [](ChainMail& tissue) { return tissue.redo().ok(); });
        m_is_redo = true;
    }

    void save() {
        both("save", [&](ChainMail& tissue) { return tissue.save_state(file_of(tissue)).ok(); });
        m_is_saved = true;
        m_saved_hash = m_sweep.hash();
    }
    void load() {
        if (!m_is_saved) return;
        both("load", [&](ChainMail& tissue) {
            const Status status = tissue.load_state(file_of(tissue));
            EXPECT_TRUE(status.ok()) << status.error().message;
            return status.ok();
        });
        EXPECT_EQ(m_sweep.hash(), m_saved_hash);
        EXPECT_EQ(m_sweep.undo_steps(), 0);
        m_past.clear();
        m_future.clear();
    }
    std::filesystem::path file_of(const ChainMail& tissue) const {
        return m_folder / (&tissue == &m_sweep ? "sweep.plst" : "heap.plst");
    }

    void group() {
        both("begin group", [](ChainMail& tissue) {
            tissue.begin_group("both");
            return true;
        });
        push();
        cut();
        both("end group", [](ChainMail& tissue) {
            tissue.end_group();
            return true;
        });
    }

    /// Keeps the hashes that undo and redo must restore.
    void remember(std::uint64_t before, int steps_before) {
        const bool is_undo = std::exchange(m_is_undo, false);
        const bool is_redo = std::exchange(m_is_redo, false);
        const bool was_held = std::exchange(m_was_held, m_sweep.is_grabbing());
        const std::uint64_t now = m_sweep.hash();
        if (was_held) {
            // The drag's step ended within this operation: continue from known states.
            m_past.clear();
            m_future.clear();
        } else if (is_undo && m_sweep.undo_steps() < steps_before) {
            if (!m_past.empty()) {
                EXPECT_EQ(now, m_past.back());
                m_past.pop_back();
            }
            m_future.push_back(before);
        } else if (is_redo && m_sweep.undo_steps() > steps_before) {
            if (!m_future.empty()) {
                EXPECT_EQ(now, m_future.back());
                m_future.pop_back();
            }
            m_past.push_back(before);
        } else if (m_sweep.undo_steps() > steps_before) {
            m_past.push_back(before);
            m_future.clear();
        } else if (m_sweep.undo_steps() == kHistorySteps) {
            // A step without changes looks like one that pushed another out.
            m_past.clear();
            m_future.clear();
        } else if (m_sweep.redo_steps() == 0) {
            m_future.clear();
        }
        while (int(m_past.size()) > m_sweep.undo_steps()) m_past.pop_front();
    }

    void check() {
        EXPECT_EQ(m_sweep.hash(), m_heap.hash());
        EXPECT_EQ(m_sweep.elastic_energy_mm2(), m_heap.elastic_energy_mm2());
        EXPECT_EQ(m_sweep.undo_steps(), m_heap.undo_steps());
        EXPECT_EQ(m_sweep.redo_steps(), m_heap.redo_steps());
        EXPECT_LE(m_sweep.undo_steps(), kHistorySteps);
        EXPECT_LE(m_sweep.history_bytes(), std::size_t(kHistoryMb) * 1'000'000);
        const LatticeState state = m_sweep.state();
        EXPECT_LE(state.max_violation_mm, 1e-9);
        EXPECT_LE(farthest_tissue_mm(), m_largest_movement + 1e-5);
        if (m_sweep.fold_certificate().certified) {
            EXPECT_EQ(state.folded_cells, 0);
        }
        m_certified += m_sweep.fold_certificate().certified;
        m_moved += state.moved_elements > 0;
    }

    /// Air may move farther.
    double farthest_tissue_mm() const {
        double farthest = 0;
        const Vec3i n = m_volume.grid.size;
        for (int z = 0; z < n.z; ++z)
            for (int y = 0; y < n.y; ++y)
                for (int x = 0; x < n.x; ++x)
                    if (m_volume.at({x, y, z}) > -300)
                        farthest = std::max(farthest, norm(m_sweep.displacement_mm({x, y, z})));
        return farthest;
    }

    void finish() {
        // The sequences cover all cases.
        EXPECT_GT(m_moved, kOperations / 4);
        // A short one may contain no materials that the certificate covers.
        if (kOperations >= 1000) {
            EXPECT_GT(m_certified, 0);
        }
        while (m_sweep.undo().ok()) {
        }
        m_sweep.reset();
        EXPECT_EQ(m_sweep.state().moved_elements, 0);
        EXPECT_EQ(m_sweep.state().resident_bricks, 0) << "bricks are left behind";
    }

    Random m_random;
    bool m_bounded;
    double m_longest_mm = longest_push_mm(m_bounded);
    Volume m_volume;
    ChainMailSettings m_settings = settings_of(m_random, m_bounded);
    TaskArena m_one{1}, m_two{2};
    ChainMail m_sweep, m_heap;
    TemporaryFolder m_folder;
    int m_count = 0, m_moved = 0, m_certified = 0;
    std::string m_name;
    double m_largest_movement = m_settings.max_movement_mm;
    std::deque<std::uint64_t> m_past, m_future;
    bool m_is_undo = false, m_is_redo = false, m_was_held = false;
    bool m_is_saved = false;
    std::uint64_t m_saved_hash = 0;
};

class RandomSequences : public testing::TestWithParam<int> {};

TEST_P(RandomSequences, KeepEveryStateValidAndEqualForAllSolvers) {
    const std::uint64_t seed = 20261121u + std::uint64_t(GetParam());
    SCOPED_TRACE("seed " + std::to_string(seed));
    Sequence(seed, GetParam() > 1).run(kOperations);
}

INSTANTIATE_TEST_SUITE_P(Seeds, RandomSequences, testing::Range(0, 7));

}  // namespace
}  // namespace pliant::test
