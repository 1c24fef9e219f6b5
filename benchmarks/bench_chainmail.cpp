// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// ChainMail's solves. One item is a moved element. A moving contact is all of a push from rest:
// bricks made, the solve, the step's limits, the move; memory is warm, as in any push but the
// first. Each row has its reference in the same run, and floor_ns/item: the bytes that must be
// moved at the bandwidth that a plain copy reaches in the same turns.

#include <pliant/chainmail.h>
#include <pliant/chainmail_orderings.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <utility>
#include <vector>

#include "interleaved.h"

namespace pliant::bench {
namespace {

/// Four materials in wavy layers, limits from 0.02 to 0.4 of a link, or one of 0.2.
Volume layered_volume(int side, bool heterogeneous) {
    Volume volume;
    volume.grid.size = {side, side, side};
    std::vector<std::int16_t> labels(voxel_count(volume.grid), 0);
    if (heterogeneous)
        for (int z = 0; z < side; ++z)
            for (int y = 0; y < side; ++y)
                for (int x = 0; x < side; ++x)
                    labels[voxel_index(volume.grid, {x, y, z})] =
                        std::int16_t((int(x + 5 * std::sin(0.2 * y)) / 7 +
                                      int(y + 4 * std::sin(0.3 * z)) / 9 + z / 11) &
                                     3);
    volume.voxels = std::move(labels);
    return volume;
}

MaterialLaw law_of(bool heterogeneous) {
    return [heterogeneous](int value) {
        constexpr double kLimits[] = {0.02, 0.05, 0.15, 0.4};
        const double limit = heterogeneous && value >= 0 ? kLimits[value & 3] : 0.2;
        return ElementLimits{
            {limit, limit, limit}, {limit, limit, limit}, {limit, limit, limit}, 1000, false};
    };
}

ChainMailSettings settings_of(bool heterogeneous, ChainMailSolver solver) {
    ChainMailSettings settings;
    settings.custom_law = law_of(heterogeneous);
    settings.solver = solver;
    settings.history_max_steps = 0;  // what undo costs has rows of its own
    return settings;
}

/// Copies memory that no cache holds. @returns seconds per byte read or written
double seconds_per_byte(const TaskArena& arena) {
    constexpr std::int64_t kBytes = std::int64_t(96) << 20, kPiece = 1 << 20;
    static std::vector<char> from(std::size_t(kBytes), 1), to(std::size_t(kBytes), 2);
    const double seconds = seconds_of([&] {
        arena.for_each(kBytes, kPiece, [&](std::int64_t begin, std::int64_t end) {
            std::memcpy(to.data() + begin, from.data() + begin, std::size_t(end - begin));
        });
    });
    return seconds / double(2 * kBytes);
}

std::int64_t moved_by(Result<PushReport>&& report) {
    if (!report.ok()) std::abort();
    return report->moved_elements;
}

/// Bytes per moved element that a push from rest can't do without: the value read, the material
/// and the place written.
constexpr double kPushBytes = 2 + 2 + 12;
/// And a frame of a drag along all axes: the field read, places read and written.
constexpr double kFrameBytes = 4 + 12 + 12;

/// A lattice and the length of a push along its diagonal that moves about so many elements.
struct Contact {
    int side;
    double push_mm;
};
constexpr std::array<Contact, 5> kHomogeneous = {
    {{40, 3.0}, {60, 6.6}, {104, 14.3}, {200, 31.0}, {410, 67.0}}};
constexpr std::array<Contact, 5> kHeterogeneous = {
    {{40, 0.45}, {60, 1.0}, {104, 2.3}, {220, 5.2}, {440, 11.3}}};

/// One tissue for the subject and one for the reference, back at rest before each push.
struct Contest {
    Contact contact;
    TaskArena arena;
    Volume volume;
    ChainMail subject, reference;

    Contest(int decade, bool heterogeneous, int threads, ChainMailSolver other)
        : contact((heterogeneous ? kHeterogeneous : kHomogeneous)[std::size_t(decade)]),
          arena(threads),
          volume(layered_volume(contact.side, heterogeneous)),
          subject(make(heterogeneous, ChainMailSolver::Sweep)),
          reference(make(heterogeneous, other)) {}

    ChainMail make(bool heterogeneous, ChainMailSolver solver) const {
        return std::move(ChainMail::create(volume, settings_of(heterogeneous, solver), arena))
            .value();
    }
    Push diagonal_push() const {
        const double middle = contact.side / 2 + 0.5, along = contact.push_mm / std::sqrt(3.0);
        return {.point_mm = {middle, middle, middle}, .push_mm = {along, along, along}};
    }
    std::int64_t push(ChainMail& tissue) const { return moved_by(tissue.push(diagonal_push())); }
    void rest() {
        subject.reset();
        reference.reset();
    }
};

void add_floor(benchmark::State& state, const TaskArena& arena, double bytes_per_item) {
    std::vector<double> turns;
    for (int n = 0; n < 5; ++n) turns.push_back(seconds_per_byte(arena));
    const double floor = median(turns) * bytes_per_item * 1e9;
    state.counters["floor_ns/item"] = floor;
    state.counters["times_floor"] = state.counters["ns/item"] / floor;
}

void run_contact(benchmark::State& state, ChainMailSolver reference) {
    Contest contest(int(state.range(0)), state.range(1) != 0, int(state.range(2)), reference);
    const std::int64_t items = contest.push(contest.subject);
    if (items != contest.push(contest.reference) ||
        contest.subject.hash() != contest.reference.hash()) {
        state.SkipWithError("the solvers disagree");
        return;
    }
    run_interleaved(
        state, double(items), [&] { contest.rest(); }, [&] { contest.push(contest.subject); },
        [&] { contest.push(contest.reference); });
    add_floor(state, contest.arena, kPushBytes);
}

/// Arguments: 0…4 for about 1 k to 10 M moved elements, heterogeneous, threads.
void moving_contact_against_heap(benchmark::State& state) {
    run_contact(state, ChainMailSolver::Heap);
}
void moving_contact_against_plain_loops(benchmark::State& state) {
    run_contact(state, ChainMailSolver::PlainSweep);
}

/// What undo adds: the subject keeps steps, the reference doesn't. Arguments as above.
void moving_contact_with_undo(benchmark::State& state) {
    const bool heterogeneous = state.range(1) != 0;
    Contest contest(int(state.range(0)), heterogeneous, int(state.range(2)),
                    ChainMailSolver::Sweep);
    ChainMailSettings settings = settings_of(heterogeneous, ChainMailSolver::Sweep);
    settings.history_max_steps = ChainMailSettings{}.history_max_steps;
    contest.subject = std::move(ChainMail::create(contest.volume, settings, contest.arena)).value();
    const std::int64_t items = contest.push(contest.subject);
    run_interleaved(
        state, double(items), [&] { contest.rest(); }, [&] { contest.push(contest.subject); },
        [&] { contest.push(contest.reference); });
}

/// The 50³ lattice on which other programs were measured: one element in the middle of a face is
/// pulled outwards. Arguments: pull [elements]. The reference are Gibson's lists.
void bounded_lattice(benchmark::State& state) {
    const TaskArena arena(1);
    const Volume volume = layered_volume(50, false);
    ChainMailSettings settings = settings_of(false, ChainMailSolver::Sweep);
    settings.bounded = true;
    ChainMail subject = std::move(ChainMail::create(volume, settings, arena)).value();
    ChainLattice block;
    block.size = volume.grid.size;
    block.materials = {{{.2, .2, .2}, {.2, .2, .2}, {.2, .2, .2}, 500, false}};
    auto lists = std::move(make_ordering(block, Ordering::GibsonConvex)).value();
    const std::array<std::int32_t, 1> pulled_by_index = {25 + 50 * (25 + 50 * 49)};
    const std::array<Vec3i, 1> pulled = {{{25, 25, 49}}};
    const Vec3d pull_mm{0, 0, double(state.range(0))};
    const auto push = [&](ChainMail& tissue) {
        return moved_by(tissue.push_elements(pulled, pull_mm));
    };
    const std::int64_t items = push(subject);
    run_interleaved(
        state, double(items), [&] { subject.reset(), lists->reset(); }, [&] { push(subject); },
        [&] { lists->push(pulled_by_index, pull_mm); });
    add_floor(state, arena, kPushBytes);
}

/// One frame of a drag that goes all the way out; the reference pushes the same elements by the
/// same step. pick_ms is the time of the grab, which belongs to no frame. Arguments as for the
/// moving contact.
void drag_frame(benchmark::State& state) {
    Contest contest(int(state.range(0)), state.range(1) != 0, int(state.range(2)),
                    ChainMailSolver::Sweep);
    const Push push = contest.diagonal_push();
    const double reach_mm = push.push_mm.x;
    std::vector<double> picks;
    GrabReport grab;
    for (int n = 0; n < 5; ++n) {
        contest.subject.reset();
        auto report = contest.subject.grab(push, reach_mm);
        if (!report.ok()) std::abort();
        grab = *report;
        picks.push_back(grab.pick_ms);
    }
    std::vector<double> frames, pushes;
    std::int64_t items = 0;
    for (auto _ : state) {
        contest.rest();
        if (!contest.subject.grab(push, reach_mm).ok()) std::abort();
        pushes.push_back(seconds_of([&] { contest.push(contest.reference); }));
        frames.push_back(
            seconds_of([&] { items = moved_by(contest.subject.drag_to(push.push_mm)); }));
        state.SetIterationTime(frames.back());
    }
    const double frame = median(frames), pushed = median(pushes);
    state.counters["items"] = double(items);
    state.counters["ns/item"] = frame / double(items) * 1e9;
    state.counters["reference_ns/item"] = pushed / double(items) * 1e9;
    state.counters["times_faster"] = pushed / frame;
    state.counters["pick_ms"] = median(picks);
    state.counters["pick_ns/reach_element"] =
        median(picks) * 1e6 / double(std::max<std::int64_t>(1, grab.reach_elements));
    add_floor(state, contest.arena, kFrameBytes);
}

/// Tissue of many values with airways, so that most bricks near the pick differ by direction.
Volume tissue_with_air(int side) {
    Volume volume;
    volume.grid.size = {side, side, side};
    std::vector<std::int16_t> values(voxel_count(volume.grid));
    for (int z = 0; z < side; ++z)
        for (int y = 0; y < side; ++y)
            for (int x = 0; x < side; ++x) {
                const double tube = std::hypot(std::remainder(x + 6 * std::sin(0.07 * z), 40.0),
                                               std::remainder(y + 5 * std::sin(0.05 * x), 44.0));
                values[voxel_index(volume.grid, {x, y, z})] =
                    std::int16_t(tube < 6 ? -950 : 20 + (x * 7 + y * 13 + z * 5) % 120);
            }
    volume.voxels = std::move(values);
    return volume;
}

/// A pick in tissue with air; one item is an element of the reach. First: in tissue that nothing
/// was done to before, so that bricks and materials are made as well. Deformed: after a drag to the
/// side. The reference is two pushes by the whole reach, all components forth and all back, which
/// is what the fields say.
void pick_through_air(benchmark::State& state) {
    const TaskArena arena(int(state.range(2)));
    const Volume volume = tissue_with_air(int(state.range(0)));
    const bool first = state.range(1) == 0, deformed = state.range(1) == 2;
    const double middle = volume.grid.size.x / 2 + 0.5, reach_mm = volume.grid.size.x / 13.0;
    ChainMailSettings settings;
    settings.history_max_steps = 0;
    settings.offset = 0.12;
    const auto make = [&] { return std::move(ChainMail::create(volume, settings, arena)).value(); };
    ChainMail subject = make(), reference = make();
    const Push place{.point_mm = {middle, middle, middle}};
    const auto pick = [&] { return subject.grab(place, reach_mm).value(); };
    GrabReport grab = pick();
    std::vector<double> picks, pushes;
    for (auto _ : state) {
        if (first) subject = make();
        subject.reset();
        if (deformed) {
            pick();
            moved_by(subject.drag_to({reach_mm / 3, -reach_mm / 4, 0}));
            subject.let_go();
        }
        picks.push_back(seconds_of([&] { grab = pick(); }));
        double both = 0;
        if (first) reference = make();
        for (const double way : {reach_mm, -reach_mm}) {
            reference.reset();
            both += seconds_of([&] {
                moved_by(reference.push({.point_mm = place.point_mm, .push_mm = {way, way, way}}));
            });
        }
        pushes.push_back(both);
        state.SetIterationTime(picks.back());
    }
    const auto items = double(grab.reach_elements);
    state.counters["items"] = items;
    state.counters["ns/item"] = median(picks) / items * 1e9;
    state.counters["reference_ns/item"] = median(pushes) / items * 1e9;
    state.counters["times_faster"] = median(pushes) / median(picks);
    state.counters["pick_ms"] = median(picks) * 1e3;
}

/// A push that moves about as many elements as the thesis's example (392). The reference is the
/// heap.
void thesis_push(benchmark::State& state) {
    const TaskArena arena(1);
    const Volume volume = layered_volume(64, false);
    ChainMailSettings settings;
    settings.history_max_steps = 0;
    ChainMail subject = std::move(ChainMail::create(volume, settings, arena)).value();
    settings.solver = ChainMailSolver::Heap;
    ChainMail heap = std::move(ChainMail::create(volume, settings, arena)).value();
    const Push push{.point_mm = {32.5, 32.5, 32.5}, .push_mm = {0.85, 0.5, 0.25}};
    const std::int64_t items = moved_by(subject.push(push));
    run_interleaved(
        state, double(items), [&] { subject.reset(), heap.reset(); },
        [&] { moved_by(subject.push(push)); }, [&] { moved_by(heap.push(push)); });
    state.counters["push_ms"] = state.counters["ns/item"] * double(items) * 1e-6;
}

void contact_arguments(benchmark::internal::Benchmark* benchmark,
                       std::vector<std::int64_t> decades) {
    benchmark->ArgNames({"decade", "heterogeneous", "threads"})
        ->ArgsProduct({std::move(decades), {0, 1}, {1, 2}})
        ->UseManualTime()
        ->Unit(benchmark::kMillisecond)
        ->MinTime(0.1);
}

BENCHMARK(moving_contact_against_heap)->Apply([](auto* b) { contact_arguments(b, {0, 1, 2, 3}); });
BENCHMARK(moving_contact_against_plain_loops)->Apply([](auto* b) {
    contact_arguments(b, {0, 1, 2, 3, 4});
});
BENCHMARK(moving_contact_with_undo)->Apply([](auto* b) { contact_arguments(b, {0, 1, 2, 3}); });
BENCHMARK(drag_frame)->Apply([](auto* b) { contact_arguments(b, {0, 1, 2, 3, 4}); });
BENCHMARK(pick_through_air)
    ->ArgNames({"side", "first/again/deformed", "threads"})
    ->ArgsProduct({{96, 220}, {0, 1, 2}, {1, 2}})
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond)
    ->MinTime(0.1);
BENCHMARK(bounded_lattice)
    ->ArgName("pull")
    ->Arg(1)
    ->Arg(2)
    ->Arg(5)
    ->Arg(20)
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond)
    ->MinTime(0.2);
BENCHMARK(thesis_push)->UseManualTime()->Unit(benchmark::kMillisecond)->MinTime(0.1);

}  // namespace
}  // namespace pliant::bench
