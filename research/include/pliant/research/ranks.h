// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Processes that solve one problem together: the ranks of an MPI communicator, which a program
// passes to the library by this interface. The library itself calls no MPI.
//
//   rank 0 ── exchange ── rank 1 ── exchange ── rank 2      neighbours
//      └──────── gather ────┴──────── gather ─────┘         all
//
// All ranks make the same calls in the same order.

#pragma once

#include <pliant/core/tasks.h>
#include <pliant/core/vec.h>
#include <pliant/models/fem.h>
#include <pliant/result.h>

#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#pragma GCC visibility push(default)
namespace pliant {

/// An exception of these functions ends the call of the library that made it.
class Ranks {
  public:
    virtual ~Ranks() = default;
    virtual int rank() const = 0;   ///< 0…count() − 1
    virtual int count() const = 0;  ///< 1 or more
    /// Sends numbers to rank − 1 (below) and rank + 1 (above), and receives theirs. The spans of a
    /// missing neighbour are empty; sizes of sent and received spans agree.
    virtual void exchange(std::span<const double> to_below, std::span<const double> to_above,
                          std::span<double> from_below, std::span<double> from_above) = 0;
    /// Gives all ranks the pieces of all ranks, in their order.
    /// @param counts  numbers in each rank's piece
    /// @param[out] all  sum of counts
    virtual void gather(std::span<const double> mine, std::span<const std::size_t> counts,
                        std::span<double> all) = 0;
};

/// An ElasticSolver of a lattice whose work is shared by ranks, each with a slab of its planes. All
/// make the same calls with equal arguments, and all get the whole solution, bit-identical to that
/// of ElasticSolver. Each rank keeps all moduli, and while a solver is created and at the end of a
/// solve vectors of all nodes; the working vectors are those of the slab.
/// Thread safety: one thread for each rank.
class RankedSolver {
  public:
    /// The arena and the ranks must outlive the solver. @returns an error of ElasticSolver::create
    static Result<RankedSolver> create(ElasticLattice solid, const std::vector<Support>& supports,
                                       const ElasticSettings& settings, const TaskArena& arena,
                                       Ranks& ranks);
    ~RankedSolver();
    RankedSolver(RankedSolver&&) noexcept;
    RankedSolver& operator=(RankedSolver&&) noexcept;

    Result<ElasticSolution> solve(const ElasticLoads& loads) const;
    std::vector<Vec3d> forces_n(std::span<const Vec3d> displacement_mm) const;

  private:
    struct Impl;
    explicit RankedSolver(std::unique_ptr<Impl> impl);
    std::unique_ptr<Impl> m_impl;
};

}  // namespace pliant
#pragma GCC visibility pop
