// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "gym/endoscope_sight.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "render/camera.h"
#include "resample/material_points.h"

namespace pliant {
namespace {

constexpr std::int64_t kRows = 16;  // of pixels, for each task
constexpr double kNowhere = std::numeric_limits<double>::infinity();

/// The wall is drawn where resampled values cross the threshold, up to about half a voxel beside
/// the tissue that was there. Tissue that is less than this behind the wall is not hidden.
constexpr double kBesideVoxels = 1;
constexpr double kBehindVoxels = 1;  // depth of a label behind the wall

bool is_there(Vec3d p) {
    return std::isfinite(p.x);
}

/// Calls visit(x, y) for the pixels of some rows in blocks of 4 × 2, the order that rays like best.
template <class Visit>
void for_each_in_blocks(int width, int begin, int end, const Visit& visit) {
    for (int top = begin; top < end; top += 2)
        for (int left = 0; left < width; left += 4)
            for (int y = top; y < std::min(top + 2, end); ++y)
                for (int x = left; x < std::min(left + 4, width); ++x) visit(x, y);
}

std::unique_ptr<MaterialPoints> points_of(const Scope& scope) {
    if (!scope.tissue()) return nullptr;
    return std::make_unique<MaterialPoints>(scope.tissue()->deformation().field());
}

}  // namespace

void Sight::look(const Scope& scope, bool follows, const SightTarget& target) {
    const EndoscopeArenaSettings& s = m_scan.settings;
    const std::size_t count = std::size_t(s.width) * std::size_t(s.height);
    if (s.has_flow) {
        if (follows && m_points_mm.size() == count) {
            trace_flow(scope, target);
        } else {
            std::fill(target.flow.begin(), target.flow.end(), 0.0F);
            std::fill(target.visibility.begin(), target.visibility.end(), FlowVisibility::None);
            std::fill(target.scene_flow_mm.begin(), target.scene_flow_mm.end(), Vec3f{0, 0, 0});
        }
        m_points_mm.resize(count);
        m_rest_voxels.resize(count);
    }
    Endoscope camera = scope.camera();
    if (!s.has_colour && s.field_stop == FieldStop::Full) camera.style = Style::Plain;
    EndoscopeFrame frame{.colour = target.colour,
                         .depth_mm = target.depth_mm,
                         .normals = target.normals,
                         .is_smooth = s.is_smooth};
    if (s.has_flow) frame.points_mm = m_points_mm;
    if (s.has_flow && s.labels && frame.normals.empty()) {
        m_normals.resize(count);
        frame.normals = m_normals;
    }
    scope.rays().endoscope_frame(camera, s.width, s.height, frame);
    if (s.has_flow) find_rest(scope, target, frame.normals);
}

void Sight::find_rest(const Scope& scope, const SightTarget& target,
                      std::span<const Vec3f> normals) {
    const Grid& grid = m_scan.volume.grid;
    const Vec3d h = grid.spacing_mm;
    const double behind_mm = kBehindVoxels * std::max({h.x, h.y, h.z});
    const Volume* const labels = m_scan.settings.labels.get();
    const render::Camera camera(scope.camera(), 1, 1);
    m_scan.threads.for_each(
        m_scan.settings.height, kRows, [&](std::int64_t begin, std::int64_t end) {
            const auto tissue = points_of(scope);
            const auto rest_of = [&](Vec3d point_mm) -> std::optional<Vec3d> {
                const Vec3d now = voxel_from_world(grid, point_mm);
                return tissue ? tissue->rest(now) : now;
            };
            const std::size_t first = std::size_t(begin) * std::size_t(m_scan.settings.width);
            const std::size_t last = std::size_t(end) * std::size_t(m_scan.settings.width);
            for (std::size_t n = first; n < last; ++n) {
                std::optional<Vec3d> rest;
                if (is_there(m_points_mm[n])) rest = rest_of(m_points_mm[n]);
                m_rest_voxels[n] = rest.value_or(Vec3d{kNowhere, kNowhere, kNowhere});
                if (!labels) continue;
                target.labels[n] = 0;
                if (!rest) continue;
                const Vec3f out = normals[n];
                const Vec3d normal = double(out.x) * camera.right() - double(out.y) * camera.up() +
                                     double(out.z) * camera.forward();
                const auto inside = rest_of(m_points_mm[n] - behind_mm * normal);
                const Vec3d at = inside.value_or(*rest);
                Vec3i voxel;
                for (int a = 0; a < 3; ++a)
                    voxel[a] = std::clamp(int(std::lround(at[a])), 0, grid.size[a] - 1);
                target.labels[n] = std::int16_t(labels->at(voxel));
            }
        });
}

void Sight::trace_flow(const Scope& scope, const SightTarget& target) const {
    const EndoscopeArenaSettings& s = m_scan.settings;
    const Grid& grid = m_scan.volume.grid;
    const Vec3d h = grid.spacing_mm;
    const double beside_mm = kBesideVoxels * std::max({h.x, h.y, h.z});
    const Endoscope view = scope.camera();
    const render::Camera camera(view, s.width, s.height);
    m_scan.threads.for_each(s.height, kRows, [&](std::int64_t begin, std::int64_t end) {
        const auto tissue = points_of(scope);
        std::vector<Vec3d> directions;
        std::vector<std::size_t> asked;
        for_each_in_blocks(s.width, int(begin), int(end), [&](int x, int y) {
            const std::size_t n = std::size_t(y) * std::size_t(s.width) + std::size_t(x);
            float* const flow = &target.flow[2 * n];
            flow[0] = flow[1] = 0;
            target.visibility[n] = FlowVisibility::None;
            target.scene_flow_mm[n] = {0, 0, 0};
            if (!is_there(m_rest_voxels[n])) return;
            const Vec3d q =
                world_from_voxel(grid, tissue ? tissue->now(m_rest_voxels[n]) : m_rest_voxels[n]);
            const Vec3d moved = q - m_points_mm[n];
            target.scene_flow_mm[n] = {float(moved.x), float(moved.y), float(moved.z)};
            target.visibility[n] = FlowVisibility::Outside;
            const Vec3d from_eye = q - view.eye_mm;
            const auto at = camera.project(from_eye);
            if (!at) return;
            flow[0] = float(at->x - (x + 0.5));
            flow[1] = float(at->y - (y + 0.5));
            const bool is_inside =
                at->x >= 0 && at->x <= s.width && at->y >= 0 && at->y <= s.height;
            if (!is_inside) return;
            asked.push_back(n);
            directions.push_back(from_eye);
        });
        std::vector<double> shares(directions.size());
        scope.rays().first_hits(view.eye_mm, directions, s.iso_hu, s.polarity, shares);
        for (std::size_t n = 0; n < asked.size(); ++n) {
            const double behind_mm = (1 - shares[n]) * norm(directions[n]);
            target.visibility[asked[n]] =
                behind_mm > beside_mm ? FlowVisibility::Hidden : FlowVisibility::Seen;
        }
    });
}

}  // namespace pliant
