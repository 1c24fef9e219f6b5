// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "base/stopwatch.h"
#include "chainmail/chainmail_impl.h"
#include "chainmail/operation.h"

namespace pliant {

ElementFacts ChainMail::Impl::facts() const {
    return {.is_void = [this](Vec3i e) { return lattice.material_at(e) == kVoidMaterial; },
            .is_tissue = [this](Vec3i e) { return lattice.material_map().is_tissue(e); },
            .never_moves =
                [this](Vec3i e) { return bool(lattice.materials()[lattice.material_at(e)].fixed); },
            .max_elements = settings.max_elements,
            .remedy = " or a larger [lattice] max_elements"};
}

Result<CutReport> ChainMail::Impl::cut(const CutSurface& surface) {
    const Stopwatch watch;
    const auto ribbon = ribbon_of(volume.grid, surface);
    if (!ribbon.ok()) return ribbon.error();
    Operation step(*this, {.step = "cut", .ends_drag = true});
    auto cuts = find_cuts(lattice, facts(), *ribbon, arena);
    if (!cuts.ok()) return cuts.error();
    if (!cuts->in_tissue) return CutReport{.cut_ms = watch.ms()};
    lattice.prepare_edits(cuts->bricks);
    lattice.exchange_edits(cuts->bricks);
    lattice.finish_edits(cuts->bricks);
    CutReport report{.cut_links = cuts->count, .cut_ms = watch.ms()};
    report.forgotten_steps = step.commit();
    return report;
}

Result<CutReport> ChainMail::cut(const CutSurface& surface) {
    return attempt([&] { return m_impl->cut(surface); });
}

}  // namespace pliant
