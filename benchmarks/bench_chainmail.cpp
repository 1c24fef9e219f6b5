// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// ChainMail's solves. One item is a moved element. A moving contact is a complete push from rest:
// creation of bricks, solve, limits of the step, move; memory is warm, as in every push but the
// first. Each row has its reference in the same run, and floor_ns/item: the necessary memory
// traffic at the bandwidth of a plain copy in the same run.

#include <pliant/chainmail.h>
#include <pliant/research/orderings.h>

#include <array>
#include <cstdlib>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "contacts.h"
#include "interleaved.h"

namespace pliant::bench {
namespace {

ChainMail tissue_of(const Contact& contact, const ChainMailSettings& settings,
                    const TaskArena& arena) {
    return std::move(ChainMail::create(contact.volume(), settings, arena)).value();
}

/// Dijkstra's algorithm with a heap on the graph of the same lattice: each element once per
/// component, with precomputed neighbours and limits. It is cached for the next case, because a
/// large one takes seconds to build.
class Heap {
  public:
    static Heap& of(const Contact& contact) {
        static std::unique_ptr<Heap> kept;
        const std::pair<int, bool> wanted(contact.decade, contact.heterogeneous);
        if (!kept || kept->m_made_for != wanted) {
            kept.reset();
            kept.reset(new Heap(contact, wanted));
        }
        return *kept;
    }

    void reset() { m_tissue.reset(); }
    std::int64_t push(const TaskArena& arena) {
        return moved_by(m_tissue.push(m_grabbed, m_push_mm, arena));
    }
    /// Compares every seventh element.
    bool agrees_with(const ChainMail& tissue) const {
        constexpr int kEvery = 7;
        for (int n = 0; n < m_graph.element_count(); n += kEvery) {
            const Vec3i ijk{n % m_side, n / m_side % m_side, n / m_side / m_side};
            if (norm(tissue.displacement_mm(ijk) - m_tissue.displacement_mm(n)) != 0) return false;
        }
        return true;
    }

  private:
    Heap(const Contact& contact, std::pair<int, bool> made_for)
        : m_made_for(made_for),
          m_side(contact.side),
          m_graph(graph_of(contact)),
          m_tissue(m_graph, GraphQueue::Heap),
          m_push_mm(contact.diagonal_push().push_mm) {
        const int low = contact.side / 2;
        for (const int z : {low, low + 1})
            for (const int y : {low, low + 1})
                for (const int x : {low, low + 1})
                    m_grabbed.push_back(x + m_side * (y + m_side * z));
    }
    static ChainGraph graph_of(const Contact& contact) {
        ChainLattice lattice;
        lattice.size = contact.volume().grid.size;
        lattice.materials = limits_of(contact.heterogeneous);
        const auto& labels = std::get<VoxelArray<std::int16_t>>(contact.volume().voxels);
        lattice.material.assign(labels.begin(), labels.end());
        return std::move(graph_of_lattice(lattice, Neighbours::Faces)).value();
    }

    std::pair<int, bool> m_made_for;
    int m_side;
    ChainGraph m_graph;
    GraphChainMail m_tissue;
    std::vector<std::int32_t> m_grabbed;
    Vec3d m_push_mm;
};

/// The heap's graph of the 10 M lattice would take 12 GB: there the figure of the 1 M one is used.
constexpr int kLargestHeap = 3;

void moving_contact_against_heap(benchmark::State& state) {
    const Contact contact(state);
    const TaskArena arena(contact.threads);
    const bool smaller = contact.decade > kLargestHeap;
    Heap& heap =
        Heap::of(smaller ? Contact(kLargestHeap, contact.heterogeneous, contact.threads) : contact);
    ChainMail tissue =
        tissue_of(contact, settings_of(contact.heterogeneous, ChainMailSolver::Sweep), arena);
    const auto push = [&] { return moved_by(tissue.push(contact.diagonal_push())); };
    const std::int64_t items = push();
    std::int64_t heap_items = 0;
    Turns turns(state, "heap", arena.thread_count());
    for (auto _ : state) {
        if (turns.wants_reference()) {
            heap.reset();
            turns.add_reference(seconds_of([&] { heap_items = heap.push(arena); }));
        }
        tissue.reset();
        turns.add_subject(seconds_of(push));
    }
    if (!smaller && (heap_items != items || !heap.agrees_with(tissue))) {
        state.SkipWithError("the solvers disagree");
        return;
    }
    turns.count(double(items), smaller ? double(heap_items) : 0);
    // The check visits each link, which takes long; the larger cases have the same bricks.
    if (contact.decade < kLargestHeap)
        state.counters["bytes/resident_element"] = tissue.state().bytes_per_resident_element;
    add_floor(state, arena, kPushBytes);
}

/// @param other  settings of the reference
void run_against(benchmark::State& state, const std::string& name, ChainMailSettings subject,
                 ChainMailSettings other) {
    const Contact contact(state);
    const TaskArena arena(contact.threads);
    ChainMail tissue = tissue_of(contact, subject, arena);
    ChainMail reference = tissue_of(contact, other, arena);
    const auto push = [&](ChainMail& which) {
        return moved_by(which.push(contact.diagonal_push()));
    };
    const std::int64_t items = push(tissue);
    if (items != push(reference) || tissue.hash() != reference.hash()) {
        state.SkipWithError("the solvers disagree");
        return;
    }
    const Turns turns = run_interleaved(
        state, name, [&] { tissue.reset(), reference.reset(); }, [&] { push(tissue); },
        [&] { push(reference); }, arena.thread_count());
    turns.count(double(items));
    add_floor(state, arena, kPushBytes);
}

void moving_contact_against_plain_loops(benchmark::State& state) {
    const bool heterogeneous = Contact(state).heterogeneous;
    run_against(state, "the same sweep without vector instructions",
                settings_of(heterogeneous, ChainMailSolver::Sweep),
                settings_of(heterogeneous, ChainMailSolver::PlainSweep));
}

/// Cost of undo: the subject keeps steps, the reference doesn't.
void moving_contact_with_undo(benchmark::State& state) {
    const ChainMailSettings without =
        settings_of(Contact(state).heterogeneous, ChainMailSolver::Sweep);
    ChainMailSettings with = without;
    with.history_max_steps = ChainMailSettings{}.history_max_steps;
    run_against(state, "without undo", with, without);
}

/// The 50³ lattice on which other programs were measured: one element in the middle of a face is
/// pulled outwards. Argument: pull [elements]. The reference uses Gibson's lists.
void bounded_lattice(benchmark::State& state) {
    const TaskArena arena(1);
    const Volume volume = layered_volume(50, false);
    ChainMailSettings settings = settings_of(false, ChainMailSolver::Sweep);
    settings.bounded = true;
    ChainMail subject = std::move(ChainMail::create(volume, settings, arena)).value();
    ChainLattice block;
    block.size = volume.grid.size;
    block.materials = limits_of(false);
    auto lists = std::move(make_ordering(block, Ordering::GibsonConvex)).value();
    const std::array<std::int32_t, 1> pulled_by_index = {25 + 50 * (25 + 50 * 49)};
    const std::array<Vec3i, 1> pulled = {{{25, 25, 49}}};
    const Vec3d pull_mm{0, 0, double(state.range(0))};
    const auto push = [&](ChainMail& tissue) {
        return moved_by(tissue.push_elements(pulled, pull_mm));
    };
    const std::int64_t items = push(subject);
    const Turns turns = run_interleaved(
        state, "Gibson's lists", [&] { subject.reset(), lists->reset(); }, [&] { push(subject); },
        [&] { lists->push(pulled_by_index, pull_mm); }, arena.thread_count());
    turns.count(double(items));
    add_floor(state, arena, kPushBytes);
}

const bool registered =
    register_contacts("moving_contact_against_heap", moving_contact_against_heap,
                      {0, 1, 2, 3, 4}) &&
    register_contacts("moving_contact_against_plain_loops", moving_contact_against_plain_loops,
                      {0, 1, 2, 3, 4}) &&
    register_contacts("moving_contact_with_undo", moving_contact_with_undo, {0, 1, 2, 3, 4});

BENCHMARK(bounded_lattice)
    ->ArgName("pull")
    ->Arg(1)
    ->Arg(2)
    ->Arg(5)
    ->Arg(20)
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond)
    ->MinTime(0.2);

}  // namespace
}  // namespace pliant::bench
