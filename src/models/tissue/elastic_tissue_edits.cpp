// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Cuts and carving. Tools hold the tissue that remains.

#include <algorithm>

#include "base/stopwatch.h"
#include "tissue/elastic_tissue.h"

namespace pliant {

constexpr std::int64_t kMostEdited = 50'000'000;  ///< elements that a blade may pass

ElementFacts ElasticTissue::facts() const {
    return {
        .is_void =
            [this](Vec3i e) {
                return !contains({{0, 0, 0}, m_scan.grid.size}, e) || m_field.field().is_void(e);
            },
        .is_tissue = [this](Vec3i e) { return m_map.is_tissue(e); },
        .never_moves = [this](Vec3i e) { return m_map.is_bone(e); },
        .max_elements = kMostEdited};
}

/// Exchanges the edits of some bricks, and follows them.
void ElasticTissue::edit(EditMap& bricks) {
    const int size = m_field.field().brick_size();
    Box3i box{m_scan.grid.size, {0, 0, 0}};
    for (const auto& [coord, edits] : bricks)
        for (int a = 0; a < 3; ++a) {
            box.begin[a] = std::max(0, std::min(box.begin[a], size * coord[a]));
            box.end[a] = std::min(m_scan.grid.size[a], std::max(box.end[a], size * (coord[a] + 1)));
        }
    if (is_empty(box)) return;
    m_step.reset();
    m_levels.forget_windows();
    m_field.edit(bricks);
    m_map.renew(box, m_arena);
    m_levels.renew(box);
    if (m_drag) m_drag->response.levels.clear();
    m_is_shown = false;
    m_sweeps = 0;
    m_settled = m_settled && m_levels.largest_mm() == 0;
}

Result<CutReport> ElasticTissue::do_cut(const CutSurface& surface) {
    const Stopwatch watch;
    if (const Status s = update_deformation(); !s.ok()) return s.error();
    const auto ribbon = ribbon_of(m_scan.grid, surface);
    if (!ribbon.ok()) return ribbon.error();
    auto cuts = find_cuts(m_field.field(), facts(), *ribbon, m_arena);
    if (!cuts.ok()) return cuts.error();
    CutReport report;
    if (cuts->in_tissue) {
        report.cut_links = cuts->count;
        edit(cuts->bricks);
    }
    report.cut_ms = watch.ms();
    return report;
}

Result<CarveReport> ElasticTissue::do_carve(const CarveTool& tool) {
    const Stopwatch watch;
    if (const Status s = update_deformation(); !s.ok()) return s.error();
    auto carved = find_carved(m_field.field(), facts(), tool);
    if (!carved.ok()) return carved.error();
    CarveReport report;
    if (carved->in_tissue) {
        report.carved_elements = carved->count;
        edit(carved->bricks);
        const auto is_carved = [&](const HeldNode& node) {
            return m_field.field().is_void(node.node);
        };
        for (auto& [number, held] : m_tools)
            if (std::erase_if(held.nodes, is_carved)) held.forces_un.clear();
        std::erase_if(m_tools, [](const auto& held) { return held.second.nodes.empty(); });
        if (m_drag && !m_tools.contains(m_drag->tool)) m_drag.reset();
        hold_all();
    }
    report.carve_ms = watch.ms();
    return report;
}

}  // namespace pliant
