// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The lags of a brick's links, gathered from its materials for one visit of the sweep.
//
// A link along axis b lags by half(i) + half(j), where half is a material's compress, stretch or
// shear along b: shear for the two components across the link, compress or stretch for the one
// along it, by the direction of the push. So at most nine arrays serve all components. One kind
// suffices for materials whose three are equal, and one gather if the axes are equal too.
//
// There are two exceptions. A cut link never binds. A link outside of its limits may keep its
// present lag (Lattice::may_exceed_limits), which depends on the component.

#pragma once

#include <array>
#include <cstdint>
#include <memory>

#include "base/memory.h"
#include "lattice/lattice.h"
#include "propagate/propagation.h"
#include "propagate/sweep_kernels.h"

namespace pliant {

/// Arrays are computed on demand, and kept until the next brick.
class VisitLags {
  public:
    /// @param shared  the visit is for all components at once: all materials around are symmetric
    /// @param stretch_is_shear  they are equal in all materials
    void begin(const Lattice& lattice, const Brick& brick, const SweepKernels& kernels, bool shared,
               bool stretch_is_shear = false);

    /// Whether all links inside are equal along each axis.
    bool is_uniform() const;
    UniformLags uniform(const ComponentPush& push) const;
    InsideLags inside(const ComponentPush& push);

    /// Largest lag of an element of the side's face behind the one in the neighbour. The array is
    /// valid until the next call. @pre the neighbour is filled in
    const Fixed* behind_neighbour(int side, const ComponentPush& push);
    /// Largest lag of the neighbour's elements behind those of the face.
    const Fixed* behind_face(int side, const ComponentPush& push);
    /// Lower bound of behind_face: the face's own half. Needs no neighbour.
    const Fixed* behind_face_at_least(int side, const ComponentPush& push);

  private:
    enum Kind { kShear, kCompress, kStretch };

    void resize(int size);
    Kind kind_of(bool up, int axis, const ComponentPush& push, bool symmetric) const;
    const Fixed* column(Kind kind, int axis) const;
    const Brick& neighbour(int side) const;
    const Fixed* halves(Kind kind, int axis);
    const Fixed* links(Kind kind, int axis);
    const Fixed* with_excess_inside(const Fixed* lags, int axis, bool up,
                                    const ComponentPush& push);
    const Fixed* face(Kind kind, int side, bool with_neighbour);
    /// The common value of all lags of a face; −1 if they may differ.
    Fixed equal_lag(Kind kind, int side, bool with_neighbour) const;
    void add_own_halves(Kind kind, int side, Fixed* out);
    void add_their_halves(Kind kind, int side, Fixed* out);
    void cut_links_of_face(int side, bool with_neighbour, Fixed* out) const;
    const Fixed* with_excess(const Fixed* lags, int side, bool behind_face,
                             const ComponentPush& push);

    Fixed* elements(int n) { return m_elements.get() + std::size_t(n) * std::size_t(m_count); }
    Fixed* faces(int n) { return m_faces.get() + std::size_t(n) * std::size_t(m_face); }

    const Lattice* m_lattice = nullptr;
    const Brick* m_brick = nullptr;
    const SweepKernels* m_kernels = nullptr;
    bool m_shared = false, m_stretch_is_shear = false;
    int m_size = 0, m_count = 0, m_face = 0;  ///< brick: edge, elements, face elements
    /// Computed arrays, as bits: 3·kind + axis, 6·kind + side.
    std::uint32_t m_has_halves = 0, m_has_links = 0, m_has_face = 0, m_has_bound = 0;
    /// Arrays of the brick: nine of halves, nine of links, six of links with excess.
    AlignedMemory<Fixed> m_elements;
    /// Arrays of faces: 18 of lags, 18 of bounds, one with excess, one for work.
    AlignedMemory<Fixed> m_faces;
    std::array<Fixed, 36> m_equal_lags{};  ///< common value of an array's lags; −1: they differ
};

}  // namespace pliant
