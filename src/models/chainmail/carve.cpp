// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Carving: elements whose present position lies inside of the tool become void.
//
// A void element has no links and no position, so its displacement becomes zero: bricks without
// other elements can be dropped, and bounds stay tight. Undo restores it with its flags.

#include "base/stopwatch.h"
#include "chainmail/chainmail_impl.h"
#include "chainmail/operation.h"

namespace pliant {
namespace {

/// Imprints that change: those of void elements are removed.
ImprintMap imprints_without(const PlasticRest& rest, const EditMap& carved) {
    ImprintMap imprints;
    for (const auto& [coord, edits] : carved) {
        const PlasticBrick* brick = rest.find(coord);
        if (!brick) continue;
        Imprint left = brick->imprint;
        for (auto& component : left)
            for (std::size_t n = 0; n < component.size(); ++n)
                if (edits[n] & kVoid) component[n] = 0;
        if (left != brick->imprint) imprints[coord].imprint = std::move(left);
    }
    return imprints;
}

/// Moves the void elements of a brick to their rest position. @pre the observer was told
void put_void_to_rest(Lattice& lattice, int index, const BrickEdits& edits) noexcept {
    Brick& brick = lattice.brick(index);
    for (std::size_t n = 0; n < edits.size(); ++n)
        if (edits[n] & kVoid)
            for (Fixed* u : brick.u) u[n] = 0;
    lattice.update_bounds(index);
}

}  // namespace

Result<CarveReport> ChainMail::Impl::carve(const CarveTool& tool) {
    const Stopwatch watch;
    Operation step(*this, {.step = "carve", .ends_drag = true});
    auto carved = find_carved(lattice, facts(), tool);
    if (!carved.ok()) return carved.error();
    if (!carved->in_tissue) return CarveReport{.carve_ms = watch.ms()};
    EditMap& bricks = carved->bricks;
    ImprintMap imprints = imprints_without(plastic_rest, bricks);
    for (const auto& [coord, edits] : bricks)
        if (const int index = lattice.find_brick(coord); index >= 0)
            lattice.before_move(lattice.brick(index));
    plastic_rest.prepare(lattice, imprints);
    try {
        lattice.prepare_edits(bricks);
    } catch (...) {
        plastic_rest.finish(imprints);
        throw;
    }
    // No allocations from here on.
    lattice.tick();
    for (const auto& [coord, edits] : bricks)
        if (const int index = lattice.find_brick(coord); index >= 0)
            put_void_to_rest(lattice, index, edits);
    lattice.exchange_edits(bricks);
    lattice.finish_edits(bricks);
    plastic_rest.exchange(lattice, imprints);
    plastic_rest.finish(imprints);
    lattice.drop_still_bricks();
    CarveReport report;
    report.carved_elements = carved->count;
    report.carve_ms = watch.ms();
    report.forgotten_steps = step.commit();
    return report;
}

Result<CarveReport> ChainMail::carve(const CarveTool& tool) {
    return attempt([&] { return m_impl->carve(tool); });
}

}  // namespace pliant
