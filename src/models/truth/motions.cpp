// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "truth/motions.h"

#include <algorithm>
#include <cmath>

#include "base/errors.h"
#include "field/field.h"

namespace pliant::truth {
namespace {

constexpr int kTries = 40;           ///< positions tried for one motion
constexpr int kMaxSweeps = 1000;     ///< towards equilibrium
constexpr double kLeast_mm = 0.2;    ///< a shorter motion is drawn again
constexpr double kLeastOfCut = 0.5;  ///< share of its motion; a cut that opens less is undone

bool is_memory(const Error& error) {
    return error.code == ErrorCode::LimitExceeded;
}

}  // namespace

Vec3d Breathing::at(Vec3d point_mm, double rigid_mm) const {
    const double s = std::clamp(rigid_mm / reach_mm(), 0.0, 1.0);
    const double weight = s * s * (3 - 2 * s);
    const double angle = dot(wave, point_mm) + phase;
    return (weight * amplitude_mm) *
           ((0.75 + 0.15 * std::cos(angle)) * along + (0.3 * std::sin(angle)) * beside);
}

Vec3i Motions::voxel_of(const std::vector<std::uint32_t>& list, Draws& draws) const {
    const std::uint32_t n = list[std::size_t(draws.below(list.size()))];
    const auto nx = std::uint32_t(m_scan.grid.size.x), ny = std::uint32_t(m_scan.grid.size.y);
    return {int(n % nx), int(n / nx % ny), int(n / nx / ny)};
}

Vec3d Motions::position_of(Vec3i v) const {
    return world_from_voxel(m_scan.grid, {double(v.x), double(v.y), double(v.z)}) +
           m_tissue.deformation().displacement_mm(v);
}

Status Motions::settle(int max_sweeps) {
    if (m_tissue.traits().moves_by_itself)
        if (const auto done = m_tissue.advance({.max_steps = max_sweeps}); !done.ok())
            return done.error();
    return m_tissue.update_deformation();
}

double Motions::radius(Draws& draws) const {
    const Vec3d h = m_scan.grid.spacing_mm;
    return std::max(m_settings.tool_radius_mm * draws.real(0.4, 1), std::max({h.x, h.y, h.z}));
}

Result<bool> Motions::carry_out(TruthKind kind, Draws& draws) {
    if (kind == TruthKind::Breathing) return breathe(draws);
    for (int tries = 0; tries < kTries; ++tries) {
        Result<bool> done = kind == TruthKind::Contact ? contact(draws)
                            : kind == TruthKind::Slide ? slide(draws)
                                                       : cut(draws, kind);
        if (!done.ok()) {
            if (is_memory(done.error())) return done;
            continue;  // the drawn position doesn't suit, such as one at the border
        }
        if (*done) return true;
    }
    return false;
}

Result<bool> Motions::contact(Draws& draws) {
    const bool is_at_wall = draws.unit() < 0.6;
    const auto& list = is_at_wall ? m_regions.walls : m_regions.soft;
    if (list.empty()) return false;
    const Vec3i voxel = voxel_of(list, draws);
    TruthMotion motion{.kind = TruthKind::Contact, .point_mm = position_of(voxel)};
    motion.radius_mm = radius(draws);
    Vec3d direction = draws.direction();
    if (is_at_wall) {
        motion.normal = inward_normal(m_scan.grid, m_regions.labels, voxel);
        if (motion.normal == Vec3d{0, 0, 0}) return false;
        direction = normalized(motion.normal + 0.5 * direction);
    }
    motion.motion_mm = amount(m_settings.contact_mm, draws) * direction;
    const Result<PushReport> report =
        m_tissue.push(++m_tool, {.point_mm = motion.point_mm,
                                 .push_mm = motion.motion_mm,
                                 .sphere_radius_mm = motion.radius_mm});
    if (!report.ok()) return report.error();
    motion.fraction = report->step_fraction;
    motion.moved_elements = report->moved_elements;
    if (report->status == PushStatus::Rejected || report->moved_elements == 0) {
        m_tissue.release(m_tool);
        if (const Status s = settle(1); !s.ok()) return s.error();
        return false;
    }
    if (const Status s = settle(kMaxSweeps); !s.ok()) return s.error();
    m_done.push_back(motion);
    return motion.fraction * norm(motion.motion_mm) >= kLeast_mm;
}

Result<bool> Motions::slide(Draws& draws) {
    if (m_regions.walls.empty()) return false;
    const Vec3i voxel = voxel_of(m_regions.walls, draws);
    TruthMotion motion{.kind = TruthKind::Slide};
    motion.normal = inward_normal(m_scan.grid, m_regions.labels, voxel);
    if (motion.normal == Vec3d{0, 0, 0}) return false;
    motion.radius_mm = radius(draws);
    // It begins in the wall by up to a third of the radius, and presses on.
    motion.point_mm = position_of(voxel) - (motion.radius_mm * draws.real(0.7, 1)) * motion.normal;
    motion.motion_mm = amount(m_settings.slide_mm, draws) *
                       normalized(draws.across(motion.normal) + draws.real(0, 0.3) * motion.normal);
    const Result<SlideReport> report = m_tissue.slide(++m_tool,
                                                      {.point_mm = motion.point_mm,
                                                       .push_mm = motion.motion_mm,
                                                       .sphere_radius_mm = motion.radius_mm},
                                                      {.threshold_hu = m_air_threshold_hu});
    if (!report.ok()) return report.error();
    motion.fraction = report->way_fraction;
    if (report->contacts == 0 || report->way_fraction == 0) {
        m_tissue.release(m_tool);
        if (const Status s = settle(1); !s.ok()) return s.error();
        return false;
    }
    if (const Status s = settle(kMaxSweeps); !s.ok()) return s.error();
    m_done.push_back(motion);
    return motion.fraction * norm(motion.motion_mm) >= kLeast_mm;
}

Result<bool> Motions::cut(Draws& draws, TruthKind kind) {
    if (m_regions.soft.empty()) return false;
    const Vec3i voxel = voxel_of(m_regions.soft, draws);
    TruthMotion motion{.kind = kind, .point_mm = position_of(voxel)};
    motion.normal = draws.direction();
    const Vec3d along = draws.across(motion.normal);
    motion.length_mm = amount(m_settings.cut_length_mm, draws);
    motion.depth_mm = 0.5 * motion.length_mm;
    const int steps = m_tissue.undo_steps();
    m_tissue.begin_group("cut");
    const Result<bool> is_open = open_cut(draws, along, motion);
    (void)m_tissue.end_group();
    if (!is_open.ok()) return is_open;
    if (!*is_open) {
        while (m_tissue.undo_steps() > steps)
            if (const Status s = m_tissue.undo(); !s.ok()) return s.error();
        if (const Status s = m_tissue.update_deformation(); !s.ok()) return s.error();
        return false;
    }
    note_cuts(kind == TruthKind::Cut ? TruthLabel::Cut : TruthLabel::Interface);
    m_done.push_back(motion);
    return true;
}

Result<bool> Motions::open_cut(Draws& draws, Vec3d along, TruthMotion& motion) {
    const Vec3d deep = cross(motion.normal, along);
    const Vec3d start = motion.point_mm - (0.5 * motion.depth_mm) * deep;
    const Vec3d half = (0.5 * motion.length_mm) * along;
    const Result<CutReport> cut =
        m_tissue.cut({.line_mm = {start - half, start + half}, .depth_mm = motion.depth_mm * deep});
    if (!cut.ok()) return cut.error();
    if (cut->cut_links == 0) return false;
    const Vec3d h = m_scan.grid.spacing_mm;
    motion.radius_mm = std::max(0.25 * motion.length_mm, std::max({h.x, h.y, h.z}));
    motion.motion_mm = motion.kind == TruthKind::Cut
                           ? amount(m_settings.cut_mm, draws) * motion.normal
                           : amount(m_settings.interface_mm, draws) * along;
    // Each side takes half of it. The spheres end before the cut.
    const double away_mm = motion.radius_mm + norm(h);
    for (const double side : {1.0, -1.0}) {
        const Result<PushReport> report =
            m_tissue.push(++m_tool, {.point_mm = motion.point_mm + (side * away_mm) * motion.normal,
                                     .push_mm = (0.5 * side) * motion.motion_mm,
                                     .sphere_radius_mm = motion.radius_mm});
        if (!report.ok()) {
            if (is_memory(report.error())) return report.error();
            continue;
        }
        motion.fraction += 0.5 * report->step_fraction;
        motion.moved_elements += report->moved_elements;
    }
    if (motion.fraction < kLeastOfCut) return false;
    if (const Status s = settle(kMaxSweeps); !s.ok()) return s.error();
    return true;
}

bool Motions::breathe(Draws& draws) {
    if (m_regions.rigid_mm.empty() || m_breathing.amplitude_mm > 0) return false;
    Vec3d size;
    double shortest = 0;
    for (int a = 0; a < 3; ++a) {
        size[a] = m_scan.grid.spacing_mm[a] * m_scan.grid.size[a];
        shortest = a == 0 ? size[a] : std::min(shortest, size[a]);
    }
    Breathing b;
    // A small scan has no room for a large amplitude.
    b.amplitude_mm = std::min(amount(m_settings.breathing_mm, draws), shortest / 8);
    // Mostly along the body, as the diaphragm moves.
    b.along = normalized(Vec3d{0, 0, draws.unit() < 0.5 ? 1.0 : -1.0} + 0.4 * draws.direction());
    b.beside = draws.across(b.along);
    b.wave = (6.283185307179586 / (draws.real(0.8, 1.6) * std::max({size.x, size.y, size.z}))) *
             draws.direction();
    b.phase = draws.real(0, 6.283185307179586);
    m_breathing = b;
    TruthMotion motion{.kind = TruthKind::Breathing, .motion_mm = b.amplitude_mm * b.along};
    motion.fraction = 1;
    m_done.push_back(motion);
    return true;
}

void Motions::note_cuts(TruthLabel label) {
    const Field& field = m_tissue.deformation().field();
    const Grid& grid = m_scan.grid;
    for (const auto& [coord, edits] : field.all_edits())
        for (std::size_t n = 0; n < edits.size(); ++n) {
            if (!edits[n]) continue;
            const Vec3i e = field.element_of(coord, int(n));
            for (int axis = 0; axis < 3; ++axis) {
                if (!(edits[n] >> axis & 1)) continue;
                Vec3i next = e;
                ++next[axis];
                for (const Vec3i end : {e, next}) {
                    if (!contains(voxel_box(grid), end)) continue;
                    const std::size_t at = voxel_index(grid, end);
                    if (m_cut_labels[at] == 0) m_cut_labels[at] = std::uint8_t(label);
                }
            }
        }
}

std::vector<std::uint32_t> Motions::cut_voxels(TruthLabel label) const {
    std::vector<std::uint32_t> voxels;
    for (std::size_t n = 0; n < m_cut_labels.size(); ++n)
        if (m_cut_labels[n] == std::uint8_t(label)) voxels.push_back(std::uint32_t(n));
    return voxels;
}

}  // namespace pliant::truth
