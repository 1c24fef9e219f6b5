// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Bodies with cuts. A cut is its ribbon, and the positions of all nodes when it was made: with the
// body at rest, these determine the mesh [Molino2004, Sifakis2007] (cut_mesh.h), and a body that
// differs from the whole one by this:
//
//   masses        of a node's copies: in proportion to the volume of their material
//   solids        each copy of a tetrahedron has its modulus times its share of the material
//   volumes       likewise, by the compliance; distances by the tetrahedra around their edge
//   held nodes    only the copy with the node's own material remains held
//   attachments   pull the copy that has the attached material
//
// So the sums of masses and stiffnesses are those of the whole body, and nothing moves at once.

#pragma once

#include <pliant/models/body_contact.h>
#include <pliant/models/cut_mesh.h>
#include <pliant/models/mesh_tissue.h>
#include <pliant/models/pbd.h>

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "resample/embedded_scan.h"

#pragma GCC visibility push(default)  // for other components
namespace pliant {

struct BodyCut {
    CutSurface surface;
    std::vector<Vec3d> positions_mm;  ///< [node] of the body with the earlier cuts
};
/// Appends a cut to the list of a state.
void add_numbers(const BodyCut& cut, std::vector<double>& numbers);
/// Reads such a list. @returns InvalidArgument for other numbers
Result<std::vector<BodyCut>> cuts_of(std::span<const double> numbers);

/// Whether a node has material of its own in a tetrahedron, rather than being virtual. [node]
std::vector<std::uint8_t> real_nodes(const CutMesh& mesh);

/// The parts of a body with cuts.
/// @param whole   the body's, without bends
/// @param cells   its tetrahedra
/// @param solids  [tetrahedron]: its solid, of one density
PbdParts cut_parts(const PbdParts& whole, std::span<const std::array<std::int32_t, 4>> cells,
                   std::span<const std::int32_t> solids, const CutMesh& mesh);

/// Tetrahedra whose surface tools and other solids touch: of the copies of one the copy with the
/// largest share, so that the two sides of a cut don't overlap.
struct TouchedSolids {
    TetMesh mesh;  ///< with all nodes
    std::vector<std::int32_t>
        solids;  ///< [tetrahedron]; separated parts of a solid have new numbers
};
TouchedSolids touched_solids(const TetMesh& whole, std::span<const std::int32_t> solids,
                             const CutMesh& mesh);

/// A body with some cuts: everything that depends on them.
struct BodyShape {
    /// @param solids  [tetrahedron]
    void set_touched(std::vector<std::array<std::int32_t, 4>> tetrahedra,
                     std::span<const std::int32_t> solids);

    std::vector<double> cuts{};     ///< as in a state; empty: the whole body
    std::optional<CutMesh> mesh{};  ///< none: the whole body
    PbdBody body;
    BodyContact contact;
    bool has_pieces = false;                              ///< two or more are in contact
    RestMesh rest{};                                      ///< with copies, in the body's precision
    std::vector<std::array<std::int32_t, 4>> touched{};   ///< those of TouchedSolids
    std::vector<std::uint8_t> is_real{};                  ///< [node], with cuts
    std::shared_ptr<const EmbeddedScan::Cuts> carried{};  ///< null: the whole body
};

}  // namespace pliant
#pragma GCC visibility pop
