// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The minimal move, one component of the displacement at a time.
//
// For a push along +a, solvers work with w = u_a; for one along −a, with w = −u_a. So each motion
// is a raise. Each link limits the lag of one end behind the other: w_j ≥ w_i − lag(i, j). Raise
// the grabbed elements by the length of the push; the least feasible w above is then a longest
// path,
//
//   w_j = max( w_j, max over neighbours i of (w_i − lag(i, j)) ),
//
// with a unique fixed point, independent of the order of updates. The raise of j is the length of
// the push minus the slack on the path to it, so a smaller push f·δ needs no new solve: each
// element is raised by max(0, raise − (1 − f)·δ).
//
// Both solvers leave w in Brick::raised[axis] for every brick with reached[axis], and the list of
// these bricks in SweepWork::touched.
//
// Where a push starts from rest and all materials around are symmetric, the components differ only
// in their amounts: one solve with the largest amount serves all, and component a is raised by
// max(0, raise − (largest amount − amount_a)). Such a *shared* raise is in Brick::raised[0].

#pragma once

#include <pliant/core/tasks.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "lattice/lattice.h"
#include "propagate/rounded_kernel.h"
#include "propagate/sweep_kernels.h"

namespace pliant {

/// One component of a push.
struct ComponentPush {
    int axis;      ///< 0, 1, 2: along i, j, k
    Fixed sign;    ///< +1 or −1
    Fixed amount;  ///< ≥ 0
};

inline std::array<ComponentPush, 3> components_of(Vec3<Fixed> shift) {
    std::array<ComponentPush, 3> components{};
    for (int a = 0; a < 3; ++a)
        components[std::size_t(a)] = {a, shift[a] < 0 ? -1 : 1,
                                      shift[a] < 0 ? -shift[a] : shift[a]};
    return components;
}

/// Contribution of one end to the lag along link axis b. Forward: largest lag of the upper end
/// behind the lower one; backward: of the lower end behind the upper one.
inline Fixed half_lag_forward(const HalfLimits& half, const ComponentPush& push, int b) {
    if (b != push.axis) return half.shear[b];
    return push.sign > 0 ? half.compress[b] : half.stretch[b];
}
inline Fixed half_lag_backward(const HalfLimits& half, const ComponentPush& push, int b) {
    if (b != push.axis) return half.shear[b];
    return push.sign > 0 ? half.stretch[b] : half.compress[b];
}

/// Largest lag of an element's neighbour on a side (0…5: −x, +x, −y, …) behind the element. Links
/// outside of their limits (see Lattice::may_exceed_limits) must not get worse.
Fixed link_lag(const Lattice& lattice, Vec3i element, int side, const ComponentPush& push);

/// Marks a brick as reached, with every element at its position before the push.
void begin_raise(const Lattice& lattice, Brick& brick, const ComponentPush& push);

/// Results of a solve, and its working memory, reused by the next push.
struct SweepWork {
    /// By side: the largest raise that a brick offers to its neighbour, 0: none, and the fields
    /// (bits) that offer one.
    struct Wakes {
        std::array<Fixed, 6> raise{};
        std::array<std::uint8_t, 6> fields{};
        bool refused = false;  ///< the brick can't take part in a shared solve
        double cancelled = 0;  ///< part of the push that its bone cancels

        void offer(int side, Fixed offered, unsigned of) {
            if (offered <= 0) return;
            const auto n = std::size_t(side);
            raise[n] = std::max(raise[n], offered);
            fields[n] = std::uint8_t(fields[n] | of);
        }
    };
    /// State of a brick in the work list. News: fields (bits) that rose in the neighbour, by side;
    /// own news: fields that rose in the brick itself.
    struct Node {
        Fixed pending = 0;  ///< largest raise offered to it; 0: not in the list
        bool is_touched = false;
        std::array<std::uint8_t, 6> news{};
        std::uint8_t own_news = 0;

        bool has_news() const { return own_news != 0 || news != std::array<std::uint8_t, 6>{}; }
        void add_all_news(unsigned fields) {
            own_news = std::uint8_t(fields);
            news.fill(std::uint8_t(fields));
        }
    };

    /// A brick whose raise continues into the next one along an axis (see uniform_passes.h).
    struct Carry {
        int from, to;
        bool up;       ///< to the higher coordinate
        bool reaches;  ///< false: `to` can't be raised by it, if it is of the same material
    };
    /// A brick with raised elements at the start of a pass, by position.
    struct Source {
        std::uint64_t line;
        int position, brick;
    };

    std::vector<int> touched;  ///< all bricks that the solve reached or made
    bool may_share = true;     ///< set before a solve: false keeps the components separate
    bool shared = false;       ///< one field serves all components, from a state of rest
    Fixed shared_amount = 0;   ///< raise of the grabbed elements in a shared solve
    /// Set before a solve: whether raises that bone will cancel needn't be found. The push is then
    /// shortened to its largest valid fraction (step.h).
    bool may_skip_cancelled = false;
    /// Part of the push that bone cancels, as far as the solve has seen it.
    double cancelled = 0;

    std::vector<Node> nodes;  ///< by brick index
    std::vector<int> active;  ///< bricks with pending > 0
    std::array<std::vector<int>, 2> round;
    std::vector<Wakes> wakes;

    std::vector<Source> sources;
    std::vector<Carry> carries;
    std::vector<std::size_t> line_begins;  ///< in carries, and the end of the last
    std::vector<int> made;                 ///< bricks created for the passes

    /// Adds a brick to the list of touched ones. @param index_bound  Lattice::brick_index_bound
    Node& touch(int index, int index_bound) {
        if (std::size_t(index) >= nodes.size()) nodes.resize(std::size_t(index_bound));
        Node& node = nodes[std::size_t(index)];
        if (!node.is_touched) touched.push_back(index);
        node.is_touched = true;
        return node;
    }
};

/// Brick-wise: each brick is swept to its own fixed point, then wakes the neighbours that its faces
/// raise. Bricks with the largest pending raise go first; bricks of one chessboard colour go in
/// parallel, since they share no face. Where one material at rest is all around, passes replace
/// this search (uniform_passes.h).
/// @pre every grabbed element has a brick
/// @returns false if more than max_bricks would be needed; then the raise is incomplete
[[nodiscard]] bool propagate_by_sweeps(Lattice& lattice, std::span<const ElementRef> grabbed,
                                       Vec3<Fixed> shift, const SweepKernels& kernels,
                                       const TaskArena& arena, int max_bricks, SweepWork& work);

/// Ordered propagation with a heap: the element with the largest raise is final, and is next. This
/// is Enhanced ChainMail [Schill1998] with an exact order: per component, by raise instead of by
/// violation; a shortest-path search [Dijkstra1959].
[[nodiscard]] bool propagate_by_heap(Lattice& lattice, std::span<const ElementRef> grabbed,
                                     const ComponentPush& push, int max_bricks);

/// The least raise under rounded limits (rounded_kernel.h), brick-wise.
/// @pre every grabbed element has a brick
[[nodiscard]] bool propagate_rounded(Lattice& lattice, std::span<const ElementRef> grabbed,
                                     Vec3<Fixed> shift, const RoundedKernels& kernels,
                                     const TaskArena& arena, int max_bricks, SweepWork& work);

}  // namespace pliant
