// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include <pliant/chainmail_slide.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <string>
#include <string_view>
#include <vector>

#include "chainmail/fixed_point.h"

namespace pliant {
namespace {

constexpr double kStep = 0.5;           ///< of the way, as a fraction of the smallest spacing
constexpr double kClearance_mm = 1e-4;  ///< left to the sphere: more than rounding takes back
constexpr int kMostTurns = 8;           ///< per step: moves can draw others into the sphere

/// From the sphere's centre to where the elements are now.
std::vector<Vec3d> offsets_of(const ChainMail& tissue, const std::vector<Vec3i>& elements,
                              Vec3d centre_mm) {
    std::vector<Vec3d> offsets;
    for (const Vec3i e : elements)
        offsets.push_back(
            world_from_voxel(tissue.volume().grid, {double(e.x), double(e.y), double(e.z)}) +
            tissue.displacement_mm(e) - centre_mm);
    return offsets;
}

/// The shortest common move along their mean direction that takes all places out of the sphere.
/// @param ahead  the direction of those that lie evenly around the centre
Vec3d way_out(const std::vector<Vec3d>& offsets, double radius_mm, Vec3d ahead) {
    constexpr double kEven_mm = 1e-9;
    Vec3d sum{0, 0, 0};
    for (const Vec3d& r : offsets) sum = sum + r;
    const bool even = norm(sum) < kEven_mm * double(offsets.size());
    const Vec3d direction = even ? ahead : normalized(sum);
    // |r + t·direction| = radius, solved for t ≥ 0.
    double farthest = 0;
    for (const Vec3d& r : offsets) {
        const double along = dot(r, direction);
        const double beside = radius_mm * radius_mm - dot(r, r);
        farthest = std::max(farthest, std::sqrt(std::max(along * along + beside, 0.0)) - along);
    }
    return (farthest + kClearance_mm) * direction;
}

/// What a push would find wrong with a place.
Error named_slide(Error error) {
    constexpr std::string_view kPush = "push:";
    if (error.message.starts_with(kPush)) error.message.replace(0, kPush.size(), "slide:");
    return error;
}

class Slide {
  public:
    Slide(ChainMail& tissue, const Push& path)
        : m_tissue(tissue), m_path(path), m_scale(tissue.settings().scale) {
        m_path.push_mm = m_scale * path.push_mm;
    }

    Status check() const {
        const double length = norm(m_path.push_mm);
        if (!is_finite(m_path.push_mm) || !(length > 0) || length > kMaxMovementMm)
            return Error{ErrorCode::InvalidArgument,
                         "slide: expected three numbers and a length above 0 and up to 500 mm "
                         "after scaling, found a length of " +
                             std::to_string(length) + " mm"};
        if (!(m_path.sphere_radius_mm > 0))
            return Error{ErrorCode::InvalidArgument,
                         "slide: expected a sphere with a radius above 0 mm, found " +
                             std::to_string(m_path.sphere_radius_mm)};
        for (const double share : {0.0, 1.0})
            if (const auto inside = inside_at(share); !inside.ok())
                return named_slide(inside.error());
        return Ok{};
    }

    Result<SlideReport> run() {
        const Vec3d h = m_tissue.volume().grid.spacing_mm;
        const double step_mm = kStep * std::min({h.x, h.y, h.z});
        const int steps = std::max(1, int(std::ceil(norm(m_path.push_mm) / step_mm)));
        for (int n = 1; n <= steps; ++n) {
            if (const Status status = make_way(double(n) / steps); !status.ok())
                return status.error();
            if (m_report.limited_by != LimitedBy::None) break;
            m_report.way_fraction = double(n) / steps;
        }
        return m_report;
    }

  private:
    Result<std::vector<Vec3i>> inside_at(double share) const {
        return m_tissue.elements_at({.point_mm = m_path.point_mm + share * m_path.push_mm,
                                     .sphere_radius_mm = m_path.sphere_radius_mm});
    }

    /// Moves tissue out of the sphere where it is after a share of its way.
    Status make_way(double share) {
        const Vec3d centre_mm = m_path.point_mm + share * m_path.push_mm;
        const Vec3d ahead = normalized(m_path.push_mm);
        for (int turn = 0;; ++turn) {
            const auto inside = inside_at(share);
            if (!inside.ok()) return inside.error();
            m_report.inside_elements = std::int64_t(inside->size());
            if (inside->empty() || turn == kMostTurns || m_report.limited_by != LimitedBy::None)
                return Ok{};
            const Vec3d move_mm =
                way_out(offsets_of(m_tissue, *inside, centre_mm), m_path.sphere_radius_mm, ahead);
            const auto done = m_tissue.push_elements(*inside, (1 / m_scale) * move_mm);
            if (!done.ok()) return done.error();
            m_report.contacts += done->status != PushStatus::Rejected;
            m_report.limited_by = done->limited_by;
        }
    }

    ChainMail& m_tissue;
    Push m_path;  ///< scaled
    double m_scale;
    SlideReport m_report;
};

}  // namespace

Result<SlideReport> slide_sphere(ChainMail& tissue, const Push& path) {
    const auto start = std::chrono::steady_clock::now();
    Slide slide(tissue, path);
    if (const Status status = slide.check(); !status.ok()) return status.error();
    tissue.let_go();
    tissue.begin_group("slide");
    Result<SlideReport> report = slide.run();
    const int forgotten = tissue.end_group();
    if (!report.ok()) return report;
    report->forgotten_steps = forgotten;
    report->slide_ms =
        std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
    return report;
}

}  // namespace pliant
