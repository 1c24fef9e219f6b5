// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "haptics/live_feel.h"

#include <algorithm>
#include <array>
#include <utility>

namespace pliant {
namespace {

/// Copies a box between volumes of the same grid and type.
template <class T>
void copy_box(const Grid& grid, const VoxelArray<T>& from, VoxelArray<T>& to, const Box3i& box) {
    const std::ptrdiff_t length = box.end.x - box.begin.x;
    const T* const source = from.data();
    T* const target = to.data();
    for (int k = box.begin.z; k < box.end.z; ++k)
        for (int j = box.begin.y; j < box.end.y; ++j) {
            const std::size_t row = voxel_index(grid, {box.begin.x, j, k});
            // Equal pages are not written, so that they stay shared with all copies.
            if (!std::equal(source + row, source + row + length, target + row))
                std::copy_n(source + row, length, target + row);
        }
}

void copy_boxes(const Volume& from, Volume& to, std::span<const Box3i> boxes) {
    for (const Box3i& box : boxes)
        if (from.is_16_bit())
            copy_box(from.grid, *std::get_if<0>(&from.voxels), *std::get_if<0>(&to.voxels), box);
        else
            copy_box(from.grid, *std::get_if<1>(&from.voxels), *std::get_if<1>(&to.voxels), box);
}

}  // namespace

LiveFeel::LiveFeel(const Volume& shown, const ChainMailFeelSettings& settings, std::uint32_t tool)
    : m_shown(shown),
      m_before(shown),
      m_settings(settings),
      m_tool(tool),
      m_learnt(0, settings.bone_n_m) {}

Result<std::unique_ptr<LiveFeel>> LiveFeel::create(const Volume& scan, const Volume& shown,
                                                   const ChainMailSettings& materials,
                                                   const ChainMailFeelSettings& settings,
                                                   std::uint32_t tool, const TaskArena& arena) {
    auto live = std::unique_ptr<LiveFeel>(new LiveFeel(shown, settings, tool));
    auto feel = ChainMailFeel::create(scan, live->m_before, materials, settings, arena);
    if (!feel.ok()) return feel.error();
    live->m_feel = std::move(*feel);
    return live;
}

void LiveFeel::changed(std::span<const Box3i> boxes) {
    m_waiting.insert(m_waiting.end(), boxes.begin(), boxes.end());
    // A long contact collects equal boxes; remove duplicates.
    constexpr std::size_t kMany = 4096;
    if (m_waiting.size() < kMany) return;
    const auto order = [](const Box3i& a, const Box3i& b) {
        const auto key = [](const Box3i& x) {
            return std::array{x.begin.x, x.begin.y, x.begin.z, x.end.x, x.end.y, x.end.z};
        };
        return key(a) < key(b);
    };
    std::sort(m_waiting.begin(), m_waiting.end(), order);
    m_waiting.erase(std::unique(m_waiting.begin(), m_waiting.end()), m_waiting.end());
}

void LiveFeel::take_over() {
    if (m_waiting.empty()) return;
    copy_boxes(m_shown, m_before, m_waiting);
    m_feel->update(m_waiting);
    m_waiting.clear();
}

void LiveFeel::set_wall(double iso_hu, Polarity polarity) {
    m_feel->set_wall(iso_hu, polarity);
}

bool LiveFeel::follow(Vec3d tool_mm, Vec3d proxy_mm) {
    if (!m_touches) take_over();
    m_model = m_feel->model(tool_mm, proxy_mm);
    m_position_mm = tool_mm;
    const bool touched = m_touches;
    m_touches = false;
    if (m_model.plane_count == 0) return false;
    m_contact = Walls::contact(m_model, tool_mm, m_settings.tool_radius_mm);
    m_touches = m_contact.depth_mm > 0;
    if (m_touches && !touched)
        m_learnt = LearntStiffness(dot(m_contact.normal, m_model.stiffness_n_m * m_contact.normal),
                                   m_settings.bone_n_m);
    return m_touches;
}

HapticModel LiveFeel::model(Tissue& tissue, Vec3d pushed_mm) {
    const auto force = m_touches ? tissue.force_n(m_tool) : std::nullopt;
    // Outside of the springs' lattice, ChainMail's law applies.
    if (!force || !tissue.is_touched_by(m_tool)) return m_model;
    m_learnt.add(pushed_mm, *force);
    HapticModel model = m_model;
    const Mat3d change = m_learnt.change_n_m();
    model.force_n = *force;
    for (int c = 0; c < 3; ++c) model.stiffness_n_m.columns[c] = -change.columns[c];
    // The springs' tool was stopped: the rest of the way has the largest stiffness.
    constexpr double kStopped_mm = 0.05;
    const Vec3d rest_mm = pushed_mm - m_position_mm;
    if (norm(rest_mm) < kStopped_mm) return model;
    model.force_n = model.force_n + (1e-3 * m_settings.bone_n_m) * rest_mm;
    for (int c = 0; c < 3; ++c) model.stiffness_n_m.columns[c][c] += m_settings.bone_n_m;
    return model;
}

}  // namespace pliant
