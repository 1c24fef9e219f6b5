// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Every solver against the brute-force oracle with cut links, carved elements, a bounded lattice,
// or links outside of their limits from the start; and the vector kernels against their plain
// twins.

#include <gtest/gtest.h>
#include <hwy/targets.h>

#include <array>
#include <cstdlib>

#include "chainmail/chainmail_impl.h"
#include "chainmail/instances.h"
#include "chainmail/oracle.h"
#include "lattice/lattice.h"
#include "propagate/sweep_kernels.h"

namespace pliant::test {
namespace {

constexpr std::uint64_t kSweepSeed = 20260301;

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr std::uint64_t kInstances = 16;
#else
constexpr std::uint64_t kInstances = 60;
#endif

/// A random lattice, as a tissue for each solver and as the oracle.
class Scene {
  public:
    explicit Scene(std::uint64_t seed)
        : random(seed), instance(random_instance(random, 4, 9, false)) {
        if (random.whole(0, 1)) instance.law = symmetric(instance.law);
        if (random.whole(0, 3) == 0)  // one material
            instance.law = [law = instance.law](int) { return law(0); };
        m_settings.custom_law = instance.law;
        m_settings.bounded = random.whole(0, 1) != 0;
        const std::array<int, 5> sizes{8, 8, 8, random.whole(2, 9), 16};
        m_settings.brick_size = sizes[std::size_t(random.whole(0, 4))];
        oracle.emplace(instance.volume, instance.law, kInstanceMargin);
        for (const ChainMailSolver solver :
             {ChainMailSolver::Sweep, ChainMailSolver::PlainSweep, ChainMailSolver::Heap}) {
            m_settings.solver = solver;
            tissues.push_back(
                std::move(ChainMail::create(instance.volume, m_settings, m_arena)).value());
        }
        if (m_settings.bounded)
            oracle->for_each([&](Vec3i e) {
                if (!contains(voxel_box(instance.volume.grid), e)) oracle->carve(e);
            });
    }

    /// The tissues' lattices, for changes that bypass the solvers.
    static Lattice& open(ChainMail& tissue) { return lattice_of(tissue); }

    void edit() {
        const Grid& grid = instance.volume.grid;
        const std::vector<std::uint8_t> edits = random_edits(random, grid);
        for (std::size_t n = 0; n < edits.size(); ++n) {
            const Vec3i e = voxel_at(n);
            for (int axis = 0; axis < 3; ++axis)
                if (edits[n] >> axis & 1) oracle->cut(e, axis);
            if (edits[n] & kVoid) oracle->carve(e);
        }
        for (ChainMail& tissue : tissues) {
            Lattice& lattice = open(tissue);
            const Vec3i last = lattice.brick_of(grid.size - Vec3i{1, 1, 1});
            for (int z = 0; z <= last.z; ++z)
                for (int y = 0; y <= last.y; ++y)
                    for (int x = 0; x <= last.x; ++x) {
                        BrickEdits flags(std::size_t(lattice.elements_per_brick()), 0);
                        for (std::size_t n = 0; n < edits.size(); ++n)
                            if (lattice.brick_of(voxel_at(n)) == Vec3i{x, y, z})
                                flags[std::size_t(lattice.index_in_brick(voxel_at(n)))] = edits[n];
                        lattice.set_edits({x, y, z}, flags);
                    }
        }
    }

    /// Moves single elements at random, so that links are outside of their limits.
    void derange() {
        oracle->set_may_exceed_limits(true);
        for (int n = random.whole(1, 20); n > 0; --n) {
            const Vec3i e =
                voxel_at(std::size_t(random.whole(0, int(voxel_count(instance.volume.grid)) - 1)));
            for (int axis = 0; axis < 3; ++axis) {
                const auto u = Fixed(random.whole(-2000000, 2000000));
                oracle->place(e, axis, u);
                for (ChainMail& tissue : tissues) {
                    Lattice& lattice = open(tissue);
                    lattice.set_may_exceed_limits(true);
                    const ElementRef element = lattice.ensure_element(e);
                    lattice.brick(element.brick).u[std::size_t(axis)][element.index] = u;
                    lattice.update_bounds(element.brick);
                }
            }
        }
    }

    void push_and_compare() {
        std::vector<Vec3i> grabbed = random_grab(random, instance.volume.grid);
        std::erase_if(grabbed, [&](Vec3i e) { return lattice_of(tissues[0]).is_void(e); });
        if (grabbed.empty()) return;
        Vec3d push_mm = random.vector(instance.push_limit_mm.x);
        if (random.whole(0, 2) == 0) push_mm[random.whole(0, 2)] = 0;
        const Vec3<Fixed> before = lattice_of(tissues[0]).displacement_at(grabbed[0]);
        for (ChainMail& tissue : tissues) {
            const auto report = tissue.push_elements(grabbed, push_mm);
            ASSERT_TRUE(report.ok());
            ASSERT_EQ(report->step_fraction, 1);
        }
        const Vec3<Fixed> done = lattice_of(tissues[0]).displacement_at(grabbed[0]) - before;
        oracle->push(grabbed, Vec3<std::int64_t>{done.x, done.y, done.z});
        fits = oracle->margin_at_rest();
        if (!fits) return;
        for (const ChainMail& tissue : tissues) {
            std::int64_t wrong = 0;
            oracle->for_each([&](Vec3i e) {
                const Vec3<Fixed> u = lattice_of(tissue).displacement_at(e);
                for (int a = 0; a < 3; ++a) wrong += u[a] != oracle->displacement(e, a);
            });
            ASSERT_EQ(wrong, 0) << "solver " << int(tissue.settings().solver);
        }
    }

    bool fits = true;  ///< the oracle's margin was large enough so far
    Random random;
    Instance instance;
    std::vector<ChainMail> tissues;
    std::optional<Oracle<std::int64_t>> oracle;

  private:
    Vec3i voxel_at(std::size_t n) const {
        const Vec3i size = instance.volume.grid.size;
        return {int(n) % size.x, int(n) / size.x % size.y, int(n) / (size.x * size.y)};
    }
    TaskArena m_arena{2};
    ChainMailSettings m_settings;
};

template <class Prepare>
void run_scenes(const Prepare& prepare) {
    int fitting = 0;
    for (std::uint64_t n = 0; n < kInstances && !::testing::Test::HasFatalFailure(); ++n) {
        SCOPED_TRACE("seed " + std::to_string(kSweepSeed + n));
        Scene scene(kSweepSeed + n);
        prepare(scene);
        for (int step = 0; step < 3 && scene.fits && !::testing::Test::HasFatalFailure(); ++step)
            scene.push_and_compare();
        fitting += scene.fits;
    }
    EXPECT_GT(fitting, int(kInstances) / 2) << "most instances outgrew their margin";
}

TEST(Sweep, AllSolversEqualTheOracleOnSymmetricUniformAndBoundedLattices) {
    run_scenes([](Scene&) {});
}

TEST(Sweep, AllSolversEqualTheOracleWhereLinksAreCutAndElementsCarved) {
    run_scenes([](Scene& scene) { scene.edit(); });
}

TEST(Sweep, AllSolversEqualTheOracleWhereLinksAreOutsideOfTheirLimits) {
    run_scenes([](Scene& scene) {
        if (scene.random.whole(0, 1)) scene.edit();
        scene.derange();
    });
}

/// Random inputs for all kernels, of bricks of 8³.
struct KernelInputs {
    static constexpr int kCount = 512;
    alignas(64) std::array<Fixed, kCount> w, other, u;
    alignas(64) std::array<std::array<Fixed, kCount>, 6> lags;
    alignas(64) std::array<MaterialId, kCount> ids;
    std::vector<Fixed> column;

    explicit KernelInputs(Random& random) {
        const int largest_lag = random.whole(1, 3) == 1 ? 1 << 29 : random.whole(1, 400);
        for (auto* values : {&w, &other, &u})
            for (Fixed& value : *values) value = random.whole(-1000, 1000);
        for (auto& array : lags)
            for (Fixed& lag : array) lag = random.whole(0, largest_lag);
        for (int n = 0; n < 1000; ++n) column.push_back(random.whole(0, 1 << 29));
        for (MaterialId& id : ids) id = MaterialId(random.whole(0, 999));
    }
};

/// All results of a set of kernels, one number after the other.
std::vector<Fixed> results_of(const SweepKernels& kernels, const KernelInputs& in) {
    std::vector<Fixed> out;
    const auto add = [&](const auto& values) {
        out.insert(out.end(), values.begin(), values.end());
    };
    KernelInputs work = in;
    kernels.gather(in.column.data(), in.ids.data(), 512, work.w.data());
    add(work.w);
    work = in;
    for (int side = 0; side < 6; ++side) {
        work = in;
        kernels.copy_face(in.u.data(), 8, side, work.w.data());
        kernels.add_face(in.column.data(), in.ids.data(), 8, side, work.other.data());
        out.insert(out.end(), work.w.begin(), work.w.begin() + 64);
        out.insert(out.end(), work.other.begin(), work.other.begin() + 64);
    }
    work = in;
    for (int axis = 0; axis < 3; ++axis) {
        kernels.add_halves(in.lags[0].data(), 8, axis, work.w.data());
        const int last = 512 - (axis == 0 ? 1 : axis == 1 ? 8 : 64);
        out.insert(out.end(), work.w.begin(), work.w.begin() + last);
    }
    work = in;
    kernels.arrange_x(work.lags[0].data(), 8);
    kernels.arrange_x(work.lags[3].data(), 8);
    const auto& lags = work.lags;
    kernels.relax(work.w.data(), 8,
                  {{lags[0].data(), lags[1].data(), lags[2].data()},
                   {lags[3].data(), lags[4].data(), lags[5].data()}},
                  0xFF);
    add(work.w);
    work = in;
    kernels.relax_uniform(work.w.data(), 8, {{30, 7, 101}, {12, 500, 3}}, 0xFF);
    add(work.w);
    for (int side = 0; side < 6; ++side) {
        work = in;
        const std::uint32_t dirty =
            kernels.take(work.w.data(), 8, side, in.other.data(), in.lags[0].data());
        out.push_back(Fixed(dirty));
        add(work.w);
        for (const FaceBehind& behind :
             {FaceBehind{in.other.data(), in.u.data(), -1}, FaceBehind{nullptr, in.u.data(), 1},
              FaceBehind{in.other.data(), nullptr, 1}, FaceBehind{nullptr, nullptr, 1},
              FaceBehind{in.other.data(), nullptr, 1, -40}, FaceBehind{nullptr, nullptr, 1, -40}})
            out.push_back(kernels.offer(in.w.data(), 8, side, in.lags[1].data(), behind));
    }
    KernelInputs raised = in;  // nothing is below 0 among raises from rest
    for (auto* values : {&raised.w, &raised.other})
        for (Fixed& value : *values) value = std::abs(value);
    for (const Fixed lag : {in.lags[0][0], 150, kUnlinked})
        for (int side = 0; side < 6; ++side)
            for (const bool is_first : {false, true}) {
                work = raised;
                if (is_first) work.w.fill(-7);
                kernels.carry(work.w.data(), 8, side, raised.other.data(), lag, is_first);
                add(work.w);
            }
    for (int a = 0; a < 3; ++a) {
        work = in;
        std::array<MovingComponent, 3> motion{{{work.u.data(), nullptr, 0, 1},
                                               {work.w.data(), nullptr, 0, 1},
                                               {work.other.data(), nullptr, 0, 1}}};
        auto* in_place = motion[std::size_t(a)].u;
        for (int b = 0; b <= a; ++b) {
            motion[std::size_t(b)].raised = in_place;
            motion[std::size_t(b)].left = 80 * (b + 1);
            motion[std::size_t(b)].sign = b == 1 ? 1 : -1;
        }
        for (int b = a + 1; b < 3; ++b) std::fill_n(motion[std::size_t(b)].u, 512, 0);
        const MoveResult moved = kernels.move(motion, 512, true);
        out.push_back(moved.moved);
        for (const auto* values : {&work.u, &work.w, &work.other}) add(*values);
        add(moved.u_min);
        add(moved.u_max);
    }
    for (const bool from_rest : {false, true}) {
        work = in;
        if (from_rest) work.w = {};
        const MoveResult moved = kernels.move({MovingComponent{work.u.data(), in.w.data(), 40, 1},
                                               {work.other.data(), in.w.data(), 90, -1},
                                               {work.w.data(), nullptr, 0, 1}},
                                              512, from_rest);
        out.push_back(moved.moved);
        for (const auto* values : {&work.u, &work.other, &work.w}) add(*values);
        add(moved.u_min);
        add(moved.u_max);
    }
    out.push_back(kernels.largest(in.w.data(), 512));
    return out;
}

TEST(Sweep, VectorKernelsGiveTheBitsOfThePlainOnesOnEveryInstructionSet) {
    const std::int64_t best = hwy::SupportedTargets();
    int targets = 0;
    for (std::int64_t rest = best; rest != 0; rest &= rest - 1) {
        const std::int64_t target = rest & -rest;
        hwy::SetSupportedTargetsForTest(target);
        hwy::GetChosenTarget().Update(hwy::SupportedTargets());
        const SweepKernels& kernels = vector_sweep_kernels();
        ++targets;
        for (std::uint64_t n = 0; n < 200; ++n) {
            Random random(kSweepSeed + n);
            const KernelInputs inputs(random);
            ASSERT_EQ(results_of(kernels, inputs), results_of(plain_sweep_kernels(), inputs))
                << hwy::TargetName(target) << ", seed " << kSweepSeed + n;
        }
    }
    hwy::SetSupportedTargetsForTest(0);
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
    EXPECT_GT(targets, 0);
}

TEST(Sweep, PushOfASharedSolveThatMeetsMovedTissueIsThatOfTheHeap) {
    // From rest among symmetric materials all components share one solve, until it reaches tissue
    // that an earlier push moved.
    Random random(kSweepSeed);
    Volume volume;
    volume.grid.size = {70, 40, 40};
    std::vector<std::int16_t> values(voxel_count(volume.grid));
    for (auto& value : values) value = std::int16_t(random.whole(-200, 900));
    volume.voxels = values;
    const TaskArena arena(2);
    std::vector<std::uint64_t> hashes;
    for (const ChainMailSolver solver :
         {ChainMailSolver::Sweep, ChainMailSolver::PlainSweep, ChainMailSolver::Heap}) {
        ChainMailSettings settings;
        settings.solver = solver;
        settings.bone_threshold_hu = 2000;
        ChainMail tissue = std::move(ChainMail::create(volume, settings, arena)).value();
        for (const double x : {12.5, 55.5, 33.5})
            ASSERT_TRUE(
                tissue.push({.point_mm = {x, 20.5, 20.5}, .push_mm = {2.5, -1.5, 0.5}}).ok());
        hashes.push_back(tissue.hash());
        EXPECT_LT(tissue.state().max_violation_mm, 1e-6);
    }
    EXPECT_EQ(hashes[0], hashes[2]);
    EXPECT_EQ(hashes[1], hashes[2]);
}

}  // namespace
}  // namespace pliant::test
