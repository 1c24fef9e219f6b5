// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A body of voxels that are the elements of a ChainMail and the nodes of finite elements and of
// the elastic scan, a tool that prescribes the displacement of some of them, and their answers.

#pragma once

#include <pliant/chainmail.h>
#include <pliant/models/fem.h>

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace pliant::results {

/// SplitMix64 [Steele2014].
class Dice {
  public:
    explicit Dice(std::uint64_t seed) : m_state(seed) {}
    std::uint64_t next();
    double real(double low, double high);

  private:
    std::uint64_t m_state;
};

struct Body {
    std::string name;
    HexLattice lattice;
    std::vector<ElasticPair> materials;
    std::vector<std::uint8_t> of_node, of_cell;  ///< indices of materials
    std::vector<bool> held;                      ///< by node
};

/// Body of one shape whose material depends on the position.
Body make_body(std::string name, const HexLattice& lattice, std::vector<ElasticPair> materials,
               const std::function<int(Vec3d voxel)>& material_at);

struct Load {
    Vec3d centre;  ///< of the tool's sphere [voxels]
    double radius = 0;
    Vec3d push;  ///< [voxels]
};

/// Nodes in the sphere.
std::vector<Vec3i> nodes_of(const Load& load, const HexLattice& lattice);

using Displacements = std::vector<Vec3d>;  ///< by node [mm]

struct Answer {
    Displacements displacement_mm;
    double prepare_ms = 0, solve_ms = 0;
    double fraction = 1;  ///< of the push
    int iterations = 0;   ///< of conjugate gradients, or sweeps
};

/// Trilinear elements, conjugate gradients with multigrid.
Answer finite_elements(const Body& body, const Load& load, double tolerance,
                       const TaskArena& arena);

struct Chain {
    double offset = 0;  ///< slack of all links, as a fraction of their length
    int sweeps = 0;     ///< of relaxation
};

/// Settings and scan of a body.
class ChainBody {
  public:
    ChainBody(const Body& body, const TaskArena& arena);
    Answer push(const Load& load, const Chain& chain) const;

  private:
    const Body& m_body;
    const TaskArena& m_arena;
    Volume m_volume;
};

enum class ScanState {
    Frame,   ///< after the push: two iterations from rest
    Settled  ///< after sweeps until equilibrium
};
/// The elastic scan (tissues.h). Its Poisson's ratio is the largest one of the materials.
Answer elastic_scan(const Body& body, const Load& load, ScanState state, const TaskArena& arena);

}  // namespace pliant::results
