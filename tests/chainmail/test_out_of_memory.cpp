// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Every operation with failing allocations: the n-th of its allocations and all after it fail, for
// n = 0, 1, 2, … until it succeeds. A failure must leave the tissue unchanged and be reported;
// finally the tissue must equal a twin without failures.
// Covers: chainmail/*_face.cpp, chainmail/operation.cpp.

#include <gtest/gtest.h>
#include <pliant/chainmail.h>

#include <cmath>
#include <functional>
#include <memory>
#include <optional>
#include <ostream>
#include <string>
#include <vector>

#include "chainmail/tissues.h"
#include "support/count_allocations.h"
#include "support/temporary_folder.h"

namespace pliant::test {
namespace {

constexpr std::uint64_t kSeed = 20261124;
/// All n below a limit, followed by a random choice of the others.
constexpr std::int64_t kAllOf = 25;

Volume scan() {
    Volume volume = volume_of({15, 12, 11}, [](Vec3i e) {
        const double r = std::hypot(e.y - 5.5, e.z - 5.0);
        if (e == Vec3i{12, 10, 9}) return 1200;
        return r < 2.0 ? -1000 : int(120 * std::sin(0.7 * e.x + 0.4 * e.y) * std::cos(0.5 * e.z));
    });
    volume.grid.spacing_mm = {1.1, 0.9, 1.3};
    return volume;
}

ChainMailSettings plain_settings() {
    ChainMailSettings settings;
    settings.offset = 0.1;
    settings.max_movement_mm = 8;
    settings.bounded = true;
    settings.history_max_steps = 10;
    return settings;
}

/// State that a failed operation must not change. The second half is slow to compute.
struct Snapshot {
    std::uint64_t hash = 0;
    int undo_steps = 0, redo_steps = 0;
    std::size_t history_bytes = 0;
    std::string undo_name, redo_name;
    bool is_grabbing = false;

    double max_violation_mm = 0, offset = 0, energy_mm2 = 0;
    std::int64_t excused_links = 0, cut_links = 0, carved_elements = 0;
    std::vector<Vec3d> imprints_mm;
    friend bool operator==(const Snapshot&, const Snapshot&) = default;
    friend std::ostream& operator<<(std::ostream& out, const Snapshot& s) {
        return out << std::hex << s.hash << std::dec << ", undo " << s.undo_steps << " ("
                   << s.undo_name << "), redo " << s.redo_steps << " (" << s.redo_name << "), "
                   << s.history_bytes << " bytes, grabbing " << s.is_grabbing << ", violation "
                   << s.max_violation_mm << ", offset " << s.offset << ", energy " << s.energy_mm2
                   << ", excused " << s.excused_links << ", cut " << s.cut_links << ", carved "
                   << s.carved_elements << ", imprints " << s.imprints_mm.size();
    }
};

Snapshot first_half_of(const ChainMail& tissue) {
    Snapshot s;
    s.hash = tissue.hash();
    s.undo_steps = tissue.undo_steps();
    s.redo_steps = tissue.redo_steps();
    s.history_bytes = tissue.history_bytes();
    s.undo_name = tissue.next_undo_name();
    s.redo_name = tissue.next_redo_name();
    s.is_grabbing = tissue.is_grabbing();
    return s;
}

Snapshot snapshot_of(const ChainMail& tissue) {
    Snapshot s = first_half_of(tissue);
    s.offset = tissue.settings().offset;
    s.energy_mm2 = tissue.elastic_energy_mm2();
    const LatticeState state = tissue.state();
    s.max_violation_mm = state.max_violation_mm;
    s.excused_links = state.excused_links;
    s.cut_links = state.cut_links;
    s.carved_elements = state.carved_elements;
    for_each_element(tissue.volume().grid, [&](Vec3i e) {
        if (const Vec3d p = tissue.imprint_mm(e); p != Vec3d{0, 0, 0}) s.imprints_mm.push_back(p);
    });
    return s;
}

/// Result of an operation; nothing: success.
using Outcome = std::optional<ErrorCode>;

template <class T>
Outcome outcome(const Result<T>& result) {
    if (result.ok()) return std::nullopt;
    return result.error().code;
}

struct Operation {
    std::string name;
    std::function<Outcome(ChainMail&)> run;
    bool can_fail = true;
};

struct Preparation {
    std::string name;
    ChainMailSettings settings;
    std::function<void(ChainMail&)> run;
};

Push push_of(Vec3d point_mm, Vec3d push_mm, double radius_mm = 0) {
    return {.point_mm = point_mm, .push_mm = push_mm, .sphere_radius_mm = radius_mm};
}

void push_some(ChainMail& tissue) {
    ASSERT_TRUE(tissue.push(push_of({4, 3, 3}, {1.5, 0.6, -0.4})).ok());
    ASSERT_TRUE(tissue.push(push_of({9, 7, 9}, {-0.7, -1.2, 0.9}, 2)).ok());
}

ChainMailSettings with(const std::function<void(ChainMailSettings&)>& change) {
    ChainMailSettings settings = plain_settings();
    change(settings);
    return settings;
}

std::vector<Preparation> preparations() {
    const auto yields = with([](auto& s) { s.yield = 0.3; });
    const auto stiff = with([](auto& s) { s.offset = 0.04; });
    const auto nothing = [](ChainMail&) {};
    const auto cut_and_carve = [](ChainMail& tissue) {
        push_some(tissue);
        ASSERT_TRUE(tissue.cut({{{2, 2, 6}, {9, 6, 7}}, {1, 5, 0.3}}).ok());
        ASSERT_TRUE(tissue.carve({{10, 3, 4}, {11, 5, 5}, 1.4, false}).ok());
    };
    const auto drag = [](ChainMail& tissue) {
        ASSERT_TRUE(tissue.push(push_of({9, 7, 9}, {-0.7, -1.2, 0.9}, 2)).ok());
        ASSERT_TRUE(tissue.grab(push_of({4, 3, 3}, {}, 1.5), 3).ok());
        ASSERT_TRUE(tissue.drag_to({0.8, 0.3, -0.2}).ok());
    };
    const auto group = [](ChainMail& tissue) {
        push_some(tissue);
        tissue.begin_group("a group with a long name");
        ASSERT_TRUE(tissue.push(push_of({6, 9, 4}, {0.5, -0.8, 0.6})).ok());
    };
    const auto changed = [stiff](ChainMail& tissue) {
        push_some(tissue);
        ASSERT_TRUE(tissue.set_materials(stiff).ok());
    };
    const auto relaxing = [](ChainMail& tissue) {
        push_some(tissue);
        ASSERT_TRUE(tissue.relax({.max_sweeps = 1}).ok());
    };
    const auto undone = [](ChainMail& tissue) {
        push_some(tissue);
        push_some(tissue);
        ASSERT_TRUE(tissue.undo().ok());
        ASSERT_TRUE(tissue.undo().ok());
    };
    return {
        {"at rest", plain_settings(), nothing},
        {"at rest, unbounded", with([](auto& s) { s.bounded = false, s.offset = 0.4; }), nothing},
        {"at rest, unbounded, yielding",
         with([](auto& s) { s.bounded = false, s.yield = 0.3, s.brick_size = 5; }), undone},
        {"at rest, without history",
         with([](auto& s) { s.bounded = false, s.history_max_steps = 0; }), nothing},
        {"unbounded", with([](auto& s) { s.bounded = false, s.offset = 0.4; }), push_some},
        {"undone", plain_settings(), undone},
        {"yielding", yields, undone},
        {"cut and carved", yields, cut_and_carve},
        {"dragging", plain_settings(), drag},
        {"dragging, yielding", yields, drag},
        {"in a group", plain_settings(), group},
        {"in a group, yielding", yields, group},
        {"without history", with([](auto& s) { s.history_max_steps = 0; }), push_some},
        {"without history, yielding", with([](auto& s) { s.history_max_steps = 0, s.yield = 0.3; }),
         cut_and_carve},
        {"other materials", plain_settings(), changed},
        {"relaxing", plain_settings(), relaxing},
        {"rounded", with([](auto& s) { s.limits = LinkLimits::Rounded; }), push_some},
        {"heap", with([](auto& s) { s.solver = ChainMailSolver::Heap, s.brick_size = 5; }),
         push_some},
    };
}

/// Arguments are created beforehand: only the library's own allocations fail.
std::vector<Operation> operations(const std::filesystem::path& folder, const std::string& state) {
    const std::vector<Vec3i> elements = {{3, 3, 2}, {4, 3, 2}, {10, 8, 8}};
    ChainMailSettings soft = plain_settings();
    soft.offset = 0.02;
    const CutSurface surface{{{1, 5, 3}, {12, 4, 4}}, {0.5, 1, 6}};
    const CarveTool tool{{4, 7, 5}, {6, 8, 7}, 1.7, true};
    RelaxOptions three, with_tool;
    three.max_sweeps = 3;
    with_tool.max_sweeps = 2;
    with_tool.over_relaxation = 1.5;
    with_tool.measure_energy = true;
    with_tool.tools.push_back({{3, 4, 5}, {9, 5, 5}, 1.2});
    const std::filesystem::path loaded = folder / (state + ".plst"), saved = folder / "saved.plst";
    const std::string name = "a group with a long name";
    const std::function<Vec3d(Vec3d)> breath = [](Vec3d p) {
        return Vec3d{0.4 * std::sin(p.y), 0.05 * p.x, -0.3};
    };
    return {
        {"push",
         [](auto& t) {
             return outcome(t.push(push_of({7, 3, 4}, {0.8, -0.9, 1.1})));
         }},
        {"push with a sphere",
         [](auto& t) {
             return outcome(t.push(push_of({5, 8, 6}, {-0.6, 0.4, 0.8}, 1.8)));
         }},
        {"push_elements",
         [=](auto& t) {
             return outcome(t.push_elements(elements, {1.2, 0.3, -0.5}));
         }},
        {"elements_at",
         [](auto& t) {
             return outcome(t.elements_at(push_of({5, 8, 6}, {}, 1.8)));
         }},
        {"grab",
         [](auto& t) {
             return outcome(t.grab(push_of({7, 3, 4}, {}, 1.5), 2));
         }},
        {"grab_elements", [=](auto& t) { return outcome(t.grab_elements(elements, 2)); }},
        {"cut", [=](auto& t) { return outcome(t.cut(surface)); }},
        {"carve", [=](auto& t) { return outcome(t.carve(tool)); }},
        {"relax", [=](auto& t) { return outcome(t.relax(three)); }},
        {"relax with a tool", [=](auto& t) { return outcome(t.relax(with_tool)); }},
        {"slide",
         [](auto& t) {
             return outcome(slide_sphere(t, push_of({5, 4.5, 6}, {1, 2.5, 1}, 1.6)));
         }},
        {"follow",
         [=](auto& t) {
             return outcome(t.follow({{1, 1, 1}, {14, 11, 10}}, breath));
         }},
        {"undo", [](auto& t) { return outcome(t.undo()); }},
        {"redo", [](auto& t) { return outcome(t.redo()); }},
        {"set_materials", [=](auto& t) { return outcome(t.set_materials(soft)); }},
        {"load_state", [=](auto& t) { return outcome(t.load_state(loaded)); }},
        {"save_state", [=](auto& t) { return outcome(t.save_state(saved)); }},
        {"drag_to",
         [](auto& t) {
             return outcome(t.drag_to({1.7, -0.4, 0.6}));
         }},
        {"drag_to beyond the reach",
         [](auto& t) {
             return outcome(t.drag_to({-3, 2.5, 1}));
         }},
        {"let_go", [](auto& t) { return t.let_go(), Outcome{}; }, false},
        {"begin_group", [=](auto& t) { return t.begin_group(name), Outcome{}; }, false},
    };
}

class OutOfMemory : public ::testing::TestWithParam<int> {
  protected:
    OutOfMemory() : m_arena(GetParam()), m_volume(scan()) {}

    ChainMail prepared(const Preparation& preparation) {
        ChainMail tissue = tissue_of(m_volume, m_arena, preparation.settings);
        preparation.run(tissue);
        return tissue;
    }
    /// Evidence that two tissues are equal inside too: their next results are equal.
    static std::vector<std::uint64_t> future_of(ChainMail& tissue) {
        std::vector<std::uint64_t> hashes;
        const auto add = [&](bool ok) { hashes.push_back(tissue.hash() ^ std::uint64_t(ok)); };
        if (tissue.is_grabbing())
            for (const Vec3d offset_mm : {Vec3d{1, 0.2, 0.1}, Vec3d{1.4, -0.5, 0.2}})
                add(tissue.drag_to(offset_mm).ok());
        for (int n = 0; n < 2; ++n) add(tissue.relax({.max_sweeps = 1}).ok());
        add(tissue.push(push_of({7, 3, 4}, {0.8, -0.9, 1.1})).ok());
        for (int n = 0; n < 5; ++n) add(tissue.undo().ok());
        for (int n = 0; n < 2; ++n) add(tissue.redo().ok());
        return hashes;
    }

    struct Run {
        Outcome outcome;
        bool has_failed = false;  ///< the n-th allocation and all after it
        bool is_undone = false;   ///< it reports lack of memory, and no other error
    };
    Run run_with_failure(ChainMail& tissue, const Operation& operation, std::int64_t n,
                         const Outcome& expected) {
        Run run;
        const FailingAllocation failing(n);
        run.outcome = operation.run(tissue);
        run.has_failed = failing.has_failed();
        run.is_undone =
            run.has_failed && run.outcome == ErrorCode::LimitExceeded && run.outcome != expected;
        return run;
    }

    /// The operation on a tissue without failures.
    struct Twin {
        Outcome outcome;
        Snapshot after;
        std::vector<std::uint64_t> future;
        std::int64_t allocations = 0;
    };
    Twin twin_of(const Preparation& preparation, const Operation& operation) {
        ChainMail tissue = prepared(preparation);
        Twin twin;
        const std::int64_t before = allocation_count();
        twin.outcome = operation.run(tissue);
        twin.allocations = allocation_count() - before;
        twin.after = snapshot_of(tissue);
        twin.future = future_of(tissue);
        return twin;
    }
    static void expect_done(ChainMail& tissue, const Run& run, const Twin& twin) {
        EXPECT_EQ(run.outcome, twin.outcome);
        Snapshot now = snapshot_of(tissue);
        // Steps that could not be packed for lack of memory are packed now.
        if (run.has_failed) now.history_bytes = twin.after.history_bytes;
        EXPECT_EQ(now, twin.after);
        EXPECT_EQ(future_of(tissue), twin.future);
    }

    /// Fails the allocations of an operation one after the other, on one tissue.
    /// @returns number of failures of the operation
    int fail_each(const Preparation& preparation, const Operation& operation, const Twin& twin) {
        ChainMail tissue = prepared(preparation);
        const Snapshot before = snapshot_of(tissue);
        const Snapshot first_half = first_half_of(tissue);
        int failures = 0;
        for (std::int64_t n = 0;; n += n < kAllOf ? 1 : m_random.whole(1, 1 + int(n / 3))) {
            SCOPED_TRACE("allocation " + std::to_string(n));
            const Run run = run_with_failure(tissue, operation, n, twin.outcome);
            if (run.is_undone) {
                EXPECT_EQ(first_half_of(tissue), first_half);
                if (failures++ % 8 == 0) {
                    EXPECT_EQ(snapshot_of(tissue), before);
                }
            } else {
                expect_done(tissue, run, twin);
                if (run.has_failed) tissue = prepared(preparation);
                n += m_random.whole(0, 6);
            }
            if (!run.has_failed || ::testing::Test::HasFailure()) return failures;
        }
    }
    /// Fails one allocation on a tissue that has no memory from earlier attempts.
    void fail_first(const Preparation& preparation, const Operation& operation, const Twin& twin) {
        if (twin.allocations == 0) return;
        ChainMail tissue = prepared(preparation);
        const Snapshot before = snapshot_of(tissue);
        const auto n = std::int64_t(m_random.next() % std::uint64_t(twin.allocations));
        SCOPED_TRACE("allocation " + std::to_string(n) + ", at once");
        Run run = run_with_failure(tissue, operation, n, twin.outcome);
        if (run.is_undone) {
            EXPECT_EQ(snapshot_of(tissue), before);
            run = {operation.run(tissue)};
        }
        expect_done(tissue, run, twin);
    }

    TaskArena m_arena;
    Volume m_volume;
    TemporaryFolder m_folder;
    Random m_random{kSeed};
};

TEST_P(OutOfMemory, FailsEachOperationAsAWholeAndLeavesTheTissueAsItWas) {
    std::vector<int> failures(operations(m_folder.path(), "").size(), 0);
    std::size_t turn = 0;
    for (const Preparation& preparation : preparations()) {
        ChainMail saved = tissue_of(m_volume, m_arena, preparation.settings);
        push_some(saved);
        ASSERT_TRUE(saved.save_state(m_folder / (preparation.name + ".plst")).ok());
        const std::vector<Operation> all = operations(m_folder.path(), preparation.name);
        ++turn;
        for (std::size_t n = 0; n < all.size(); ++n) {
            if ((turn + n) % 2 == std::size_t(GetParam()) % 2)
                continue;  // half of them per thread count, the others after the next preparation
            SCOPED_TRACE(all[n].name + ", " + preparation.name + ", seed " + std::to_string(kSeed));
            const Twin twin = twin_of(preparation, all[n]);
            failures[n] += fail_each(preparation, all[n], twin);
            for (int k = 0; k < 2; ++k) fail_first(preparation, all[n], twin);
            if (HasFailure()) return;
        }
    }
    const std::vector<Operation> all = operations(m_folder.path(), "");
    for (std::size_t n = 0; n < all.size(); ++n) {
        EXPECT_EQ(failures[n] > 0, all[n].can_fail) << all[n].name;
        RecordProperty(all[n].name, failures[n]);
    }
}

TEST_P(OutOfMemory, ResetsTheTissueAndForgetsTheWayBackIfItMust) {
    for (const Preparation& preparation : preparations()) {
        SCOPED_TRACE(preparation.name);
        for (std::int64_t n = 0;; n += m_random.whole(1, 4)) {
            ChainMail tissue = prepared(preparation), twin = prepared(preparation);
            const std::uint64_t before = tissue.hash();
            twin.reset();
            bool has_failed = false;
            {
                const FailingAllocation failing(n);
                tissue.reset();
                has_failed = failing.has_failed();
            }
            EXPECT_EQ(tissue.hash(), twin.hash());
            EXPECT_FALSE(tissue.is_grabbing());
            EXPECT_EQ(tissue.moved_box(), Box3i{});
            if (preparation.name.starts_with("in a group")) tissue.end_group(), twin.end_group();
            if (tissue.undo_steps() > 0) {
                EXPECT_EQ(tissue.undo_steps(), twin.undo_steps());
                const bool is_step = tissue.next_undo_name() == "reset";
                ASSERT_TRUE(tissue.undo().ok());
                EXPECT_EQ(tissue.hash() == before, is_step || before == twin.hash());
            }
            EXPECT_TRUE(tissue.push(push_of({7, 3, 4}, {0.8, -0.9, 1.1})).ok());
            if (!has_failed || HasFailure()) break;
        }
    }
}

TEST_P(OutOfMemory, EndsAGroupAndKeepsItsStepUncompressed) {
    Preparation preparation{"", with([](auto& s) { s.yield = 0.3; }), push_some};
    for (std::int64_t n = 0;; ++n) {
        SCOPED_TRACE("allocation " + std::to_string(n));
        ChainMail tissue = prepared(preparation);
        const std::uint64_t before = tissue.hash();
        tissue.begin_group("group");
        push_some(tissue);
        ASSERT_TRUE(tissue.carve({{10, 3, 4}, {11, 5, 5}, 1.4, false}).ok());
        const std::uint64_t after = tissue.hash();
        bool has_failed = false;
        {
            const FailingAllocation failing(n);
            EXPECT_EQ(tissue.end_group(), 0);
            has_failed = failing.has_failed();
        }
        EXPECT_EQ(tissue.next_undo_name(), "group");
        // A following step is on top of it.
        ASSERT_TRUE(tissue.push(push_of({7, 3, 4}, {0.8, -0.9, 1.1})).ok());
        ASSERT_TRUE(tissue.undo().ok());
        EXPECT_EQ(tissue.hash(), after);
        ASSERT_TRUE(tissue.undo().ok());
        EXPECT_EQ(tissue.hash(), before);
        ASSERT_TRUE(tissue.redo().ok());
        EXPECT_EQ(tissue.hash(), after);
        if (!has_failed || HasFailure()) break;
    }
}

TEST_P(OutOfMemory, MakesATissueOrNone) {
    int failures = 0, tries = 0;
    for (std::int64_t n = 0;; n += n < kAllOf ? 1 : 9, ++tries) {
        const ChainMailSettings settings = plain_settings();
        std::optional<Result<ChainMail>> made;
        bool has_failed = false;
        {
            const FailingAllocation failing(n);
            made = ChainMail::create(m_volume, settings, m_arena);
            has_failed = failing.has_failed();
        }
        if (!has_failed) break;
        failures += !made->ok() && made->error().code == ErrorCode::LimitExceeded;
        EXPECT_EQ(failures, tries + 1);
    }
    EXPECT_GT(failures, 10);
}

INSTANTIATE_TEST_SUITE_P(Threads, OutOfMemory, ::testing::Values(1, 2));

}  // namespace
}  // namespace pliant::test
