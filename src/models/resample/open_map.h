// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Voxels of a scan that are to be written, and voxels that differ from it since the last update.
//
// Updates alternate between two turns, and voxels written in one turn are open in the next. So
// voxels that stay changeable during a drag are opened once.

#pragma once

#include <pliant/volume.h>

#include <cstdlib>
#include <memory>
#include <span>
#include <vector>

#include "resample/brick_bits.h"

namespace pliant {

/// State of a voxel of the scan, as bits: the turn in which it is to be written, and whether
/// several cells may hold it.
enum class Open : std::uint8_t { Never = 0, Several = 4 };

/// Meaning of the states in one of the two turns.
class Turn {
  public:
    Open yes() const { return m_yes; }                   ///< to be written
    Open no() const { return other().m_yes; }            ///< written
    Open taken() const { return with_several(no()); }    ///< written, another may hold it too
    Open shared() const { return with_several(m_yes); }  ///< to be written, several may hold it
    bool is_open(Open open) const { return (std::uint8_t(open) & std::uint8_t(m_yes)) != 0; }
    Turn other() const { return Turn(Open(3 - std::uint8_t(m_yes))); }
    Turn() : Turn(Open(1)) {}

  private:
    explicit Turn(Open yes) : m_yes(yes) {}
    static Open with_several(Open open) {
        return Open(std::uint8_t(open) | std::uint8_t(Open::Several));
    }

    Open m_yes;
};

class OpenMap {
  public:
    /// State of a brick's voxels before anything is written.
    enum class State : std::uint8_t {
        AsScan,   ///< all closed
        Changed,  ///< those of bits() may differ from the scan; all closed
        Open,     ///< likewise, and exactly these are open
    };

    /// All voxels are closed and as in the scan. @throws std::bad_alloc
    explicit OpenMap(const Grid& scan);
    /// Must be called first. @param size  of bricks, always the same
    void set_brick_size(int size);

    Open* voxels() { return m_open.get(); }
    Turn turn() const { return m_turn; }
    /// Ends the turn, when all open voxels are written.
    void end_turn() { m_turn = m_turn.other(); }

    /// State of the scan's brick with a number (dense_index).
    State& state(std::size_t brick) { return m_states[brick]; }
    BitWord* bits(std::size_t brick) { return m_bits.get() + brick * m_words_per_brick; }

    /// Closes bricks that are open and not dirty. @param dirty  per brick of the scan
    void close_all_but(std::span<const std::uint8_t> dirty);
    /// Closes all voxels of some bricks; they then count as equal to the scan.
    /// @param bricks  per brick of the scan; all bricks of which a voxel was ever opened
    void close_all(std::span<const std::uint8_t> bricks);
    /// Calls work(box of voxels) for some bricks. @param bricks  per brick of the scan
    template <class Work>
    void for_boxes(std::span<const std::uint8_t> bricks, const Work& work) const {
        for (std::size_t brick = 0; m_size && brick < bricks.size(); ++brick)
            if (bricks[brick]) work(box_of(brick));
    }
    /// Must be called for each opened brick, until it is closed again.
    void note_open(std::size_t brick) { m_open_bricks.push_back(brick); }

  private:
    struct Free {
        void operator()(void* memory) const { std::free(memory); }
    };

    Box3i box_of(std::size_t brick) const;
    void close(const Box3i& box);

    Vec3i m_voxel_count, m_brick_count{};
    int m_size = 0;
    Turn m_turn;
    /// Untouched memory stays unused: only pages with open voxels become resident.
    std::unique_ptr<Open[], Free> m_open;
    std::unique_ptr<BitWord[], Free> m_bits;
    std::size_t m_words_per_brick = 0;
    std::vector<State> m_states;
    std::vector<std::size_t> m_open_bricks;
};

}  // namespace pliant
