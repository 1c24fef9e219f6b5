// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The field of a model without other data per element: displacements are written in place. 12 bytes
// an element.

#pragma once

#include <deque>
#include <memory>
#include <span>

#include "field/field.h"

#pragma GCC visibility push(default)  // for other components
namespace pliant {

class WritableField final : public Field {
  public:
    explicit WritableField(const Grid& grid, int brick_size = 8, bool bounded = false)
        : Field(grid, brick_size, bounded,
                {sizeof(FieldBrick), 3 * array_bytes<Fixed>(brick_size)}) {}

    /// The brick, created if needed. The caller must then write all of its displacements, and call
    /// `written` to update its state.
    int ensure_brick(Vec3i coord);
    FieldBrick& brick(int index) { return brick_to_write(index); }
    using Field::brick;
    /// Ends the writing of a brick's displacements. May be called from several threads.
    /// @param now  tick()'s value for this change
    void written(FieldBrick& brick, std::uint64_t now) const;
    using Field::continue_clock;
    using Field::drop_all_bricks;
    using Field::drop_all_edits;
    using Field::drop_made_since;
    using Field::drop_still_bricks;
    using Field::exchange_edits;
    using Field::finish_edits;
    using Field::place_at_rest;
    using Field::prepare_edits;
    using Field::set_edits;
    using Field::tick;

  private:
    FieldBrick& make_brick(std::byte* memory) override;

    std::deque<FieldBrick> m_made;  ///< all of Field's bricks, resident or dropped
};

/// A field as it is now: a copy of the moved bricks, and of all edits.
std::unique_ptr<const WritableField> copy_of(const Field& field);

}  // namespace pliant
#pragma GCC visibility pop
