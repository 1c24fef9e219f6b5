// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The minimal move, one component of the displacement at a time.
//
// For a push along +a work with w = u_a, for one along −a with w = −u_a, so that moving is always
// raising. Each link says how far one end may lag behind the other: w_j ≥ w_i − lag(i, j). Raise
// the grabbed elements by the length of the push; the least feasible w above is then a longest
// path,
//
//   w_j = max( w_j, max over neighbours i of (w_i − lag(i, j)) ),
//
// with a unique fixed point, whatever the order of the updates. The amount that j is raised is the
// amount of the push minus the slack on the way there, so the smaller push f·δ needs no new solve:
// each element is raised by max(0, raise − (1 − f)·δ).
//
// Both solvers leave w in Brick::raised[axis] for every brick with reached[axis], and the list of
// those bricks in SweepWork::touched.
//
// Where a push starts from rest and every material around is symmetric, the components differ only
// in how much they are pushed: one solve with the largest amount serves all, and component a is
// raised by max(0, raise − (largest amount − amount_a)). Such a *shared* raise is in
// Brick::raised[0].

#pragma once

#include <pliant/tasks.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "chainmail/lattice.h"
#include "chainmail/sweep_kernels.h"

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

/// What a value contributes to the lag along link axis b: forward, how far the upper end may lag
/// behind the lower one; backward, the other way round.
inline Fixed half_lag_forward(const HalfLimits& half, const ComponentPush& push, int b) {
    if (b != push.axis) return half.shear[b];
    return push.sign > 0 ? half.compress[b] : half.stretch[b];
}
inline Fixed half_lag_backward(const HalfLimits& half, const ComponentPush& push, int b) {
    if (b != push.axis) return half.shear[b];
    return push.sign > 0 ? half.stretch[b] : half.compress[b];
}

/// How far the neighbour of an element on a side (0…5: −x, +x, −y, …) may lag behind the element.
/// Links that are outside of their limits already (see Lattice::may_exceed_limits) may not get
/// worse.
Fixed link_lag(const Lattice& lattice, Vec3i element, int side, const ComponentPush& push);

/// Marks a brick as reached, with every element where it was before the push.
void begin_raise(const Lattice& lattice, Brick& brick, const ComponentPush& push);

/// What a solve leaves behind, and the memory it works in, kept from push to push.
struct SweepWork {
    /// By side: the largest raise that a brick offers to its neighbour, 0: none, and for which of
    /// the fields that are solved for (bits).
    struct Wakes {
        std::array<Fixed, 6> raise{};
        std::array<std::uint8_t, 6> fields{};
        bool refused = false;  ///< the brick can't take part in a shared solve

        void offer(int side, Fixed offered, unsigned of) {
            if (offered <= 0) return;
            const auto n = std::size_t(side);
            raise[n] = std::max(raise[n], offered);
            fields[n] = std::uint8_t(fields[n] | of);
        }
    };
    /// A brick's place in the work list. News: fields (bits) that have risen, by side, and those
    /// whose elements in the brick itself have.
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

    /// A brick whose raise goes on into the next one along an axis (see uniform_passes.h).
    struct Carry {
        int from, to;
        bool up;       ///< to the higher coordinate
        bool reaches;  ///< false: `to` can't be raised by it, if it is of the same material
    };
    /// A brick with raised elements at the start of a pass, by where it is.
    struct Source {
        std::uint64_t line;
        int position, brick;
    };

    std::vector<int> touched;  ///< all bricks that the solve reached or made
    bool may_share = true;     ///< set before a solve: false keeps the components apart
    bool shared = false;       ///< one field serves all components, from a state of rest
    Fixed shared_amount = 0;   ///< what the grabbed elements are raised by in a shared solve

    std::vector<Node> nodes;  ///< by brick index
    std::vector<int> active;  ///< bricks with pending > 0
    std::array<std::vector<int>, 2> round;
    std::vector<Wakes> wakes;

    std::vector<Source> sources;
    std::vector<Carry> carries;
    std::vector<std::size_t> line_begins;  ///< in carries, and the end of the last
    std::vector<int> made;                 ///< bricks that came into being for the passes

    /// Puts a brick on the list of touched ones. @param index_bound  Lattice::brick_index_bound
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
/// parallel, since they share no face. Where one material at rest is all around, passes take the
/// place of this search (uniform_passes.h).
/// @pre every grabbed element has a brick
/// @returns false if more than max_bricks would be needed; then the raise is incomplete
[[nodiscard]] bool propagate_by_sweeps(Lattice& lattice, std::span<const ElementRef> grabbed,
                                       Vec3<Fixed> shift, const SweepKernels& kernels,
                                       const TaskArena& arena, int max_bricks, SweepWork& work);

/// Ordered propagation with a heap: the element with the largest raise is final, and goes next
/// (Enhanced ChainMail [Schill1998] with the order that makes it exact: per component, by raise
/// instead of by violation; a shortest-path search [Dijkstra1959]).
[[nodiscard]] bool propagate_by_heap(Lattice& lattice, std::span<const ElementRef> grabbed,
                                     const ComponentPush& push, int max_bricks);

/// The least raise under rounded limits (rounded.h).
[[nodiscard]] bool propagate_rounded(Lattice& lattice, std::span<const ElementRef> grabbed,
                                     const ComponentPush& push, const TaskArena& arena,
                                     int max_bricks);

}  // namespace pliant
