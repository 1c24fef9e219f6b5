// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The state of a lattice in a file: the content of a frame (core/state_frame.h).
//
//   144         fingerprint of the scan
//     8  u64    hash of label materials, labels and directions
//     4  u32    length of the settings, and then these: TOML, as in a settings file
//     …         displacements: bricks that moved, packed in pieces as in the history
//     …         edits: likewise
//     …         imprints: likewise
//
// A piece is: u32 bricks (0: no more pieces), i32 × 3 coordinates of each, u32 length before and
// after packing, packed bytes. Bricks are in ascending order of their coordinates (z, y, x).

#pragma once

#include <pliant/volume.h>

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/state_frame.h"
#include "chainmail/history_codec.h"
#include "lattice/lattice.h"
#include "relax/plastic.h"

namespace pliant {

/// Identification of a scan.
struct ScanFingerprint {
    Grid grid;
    bool is_16_bit = true;
    std::uint64_t voxel_hash = 0;
    friend bool operator==(const ScanFingerprint&, const ScanFingerprint&) = default;
};
ScanFingerprint fingerprint_of(const Volume& volume);

/// All of a state but displacements, edits and imprints.
struct StateHeader {
    ScanFingerprint scan;
    bool custom_law = false;  ///< the settings' named law isn't the one in use
    /// Materials have changed: links, movements and bone may be outside of the present limits.
    bool materials_changed = false;
    std::uint64_t label_hash = 0;  ///< of label materials, labels and directions; 0: none
    std::string settings;          ///< TOML, all but these members
};

Bytes encode_state(const StateHeader& header, const Lattice& lattice, const PlasticRest& imprints);

class StateReader {
  public:
    /// Checks the frame. @param name  of the file, for messages
    static Result<StateReader> open(std::string name, std::span<const std::byte> file);

    /// The rest remains to be read.
    Result<StateHeader> read_header();
    /// Reads displacements, edits and imprints into a lattice at rest without imprints.
    Status read_lattice(Lattice& lattice, PlasticRest& imprints, std::int64_t max_elements);

  private:
    struct Piece {
        std::vector<Vec3i> coords;
        Bytes raw;
    };

    explicit StateReader(StateParser frame) : m_frame(std::move(frame)) {}
    bool take_fingerprint(ScanFingerprint& scan);
    /// @param raw_limit  largest length of one brick before packing
    /// @returns nothing at the end of the pieces
    Result<std::optional<Piece>> read_piece(std::size_t raw_limit);
    bool follows(Vec3i coord, const Lattice& lattice);
    /// Calls write(coord, change) for each brick, with the three components in sequence.
    template <class Write>
    Status read_changes(const Lattice& lattice, std::int64_t max_bricks, const Write& write);
    Status read_moves(Lattice& lattice, std::int64_t max_bricks);
    Status read_imprints(const Lattice& lattice, PlasticRest& imprints, std::int64_t max_bricks);
    Status read_edits(Lattice& lattice, std::int64_t max_bricks);

    StateParser m_frame;
    std::optional<Vec3i> m_last;  ///< coordinates of the previous brick
};

/// Fault of a lattice: a link outside of its limits, a displaced fixed element, an element beyond
/// its movement limit, a void one that moved. @returns an empty text if there is none
std::string find_fault(const Lattice& lattice, const TaskArena& arena);

/// Fault of imprints: elements can return to them, so links and fixed elements are checked.
/// Movement limits restrict elements, not imprints, and are not checked.
std::string find_imprint_fault(const Lattice& lattice, const PlasticRest& imprints);

}  // namespace pliant
