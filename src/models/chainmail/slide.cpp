// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include <pliant/chainmail.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/errors.h"
#include "base/stopwatch.h"
#include "chainmail/grab.h"
#include "chainmail/operation.h"
#include "lattice/tool_touch.h"
#include "material/limit_units.h"

namespace pliant {
namespace {

constexpr double kClearance_mm = 1e-4;  ///< extra distance of the sphere, above rounding
constexpr const char* kNoRoom = "stopped: tissue closes around the sphere";
constexpr int kMaxTurns = 8;  ///< per step: moves can pull other tissue into the sphere

/// Length of a step: half a voxel, less for thinner spheres, so that they can't skip tissue.
double step_length_mm(Vec3d spacing_mm, double radius_mm) {
    const double h = std::min({spacing_mm.x, spacing_mm.y, spacing_mm.z});
    return std::min(0.5 * h, std::max(radius_mm, 0.1 * h));
}

/// The shortest common move along their mean direction that takes all points out of the sphere.
/// @param inside  points from the sphere's centre [mm]
/// @param ahead   the direction for points distributed evenly around the centre
Vec3d way_out(const std::vector<Vec3d>& inside, double radius_mm, Vec3d ahead) {
    constexpr double kEven = 0.02;  // fraction of the radius
    Vec3d sum{0, 0, 0};
    for (const Vec3d& r : inside) sum = sum + r;
    const bool even = norm(sum) < kEven * radius_mm * double(inside.size());
    const Vec3d direction = even ? ahead : normalized(sum);
    // |r + t·direction| = radius, solved for t ≥ 0.
    double farthest = 0;
    for (const Vec3d& r : inside) {
        const double along = dot(r, direction);
        const double beside = radius_mm * radius_mm - dot(r, r);
        farthest = std::max(farthest, std::sqrt(std::max(along * along + beside, 0.0)) - along);
    }
    return (farthest + kClearance_mm) * direction;
}

/// Directions to the corners, edges and faces of a cube.
std::vector<Vec3d> cube_directions() {
    std::vector<Vec3d> directions;
    for (int n = 0; n < 27; ++n)
        if (n != 13)
            directions.push_back(normalized(Vec3d{n % 3 - 1.0, n / 3 % 3 - 1.0, n / 9 - 1.0}));
    return directions;
}

class Slide {
  public:
    Slide(ChainMail& tissue, const Push& path, const TissueValues& values)
        : m_tissue(tissue),
          m_grid(tissue.volume().grid),
          m_path(path),
          m_values(values),
          m_scale(tissue.settings().scale) {
        m_path.push_mm = m_scale * path.push_mm;
        m_report.end_mm = path.point_mm;
    }

    Status check() const {
        const double length = norm(m_path.push_mm);
        if (!is_finite(m_path.push_mm) || !(length > 0) || length > kMaxMovementMm)
            return about("slide", ErrorCode::InvalidArgument,
                         "expected three numbers and a length above 0 and up to 500 mm "
                         "after scaling, found a length of " +
                             std::to_string(length) + " mm");
        if (!(m_path.sphere_radius_mm > 0))
            return about("slide", ErrorCode::InvalidArgument,
                         "expected a sphere with a radius above 0 mm, found " +
                             std::to_string(m_path.sphere_radius_mm));
        if (!std::isfinite(m_values.threshold_hu))
            return about("slide", ErrorCode::InvalidArgument, "threshold_hu: expected a number");
        for (const double share : {0.0, 1.0})
            if (const auto found =
                    m_tissue.elements_at({position(share), {0, 0, 0}, m_path.sphere_radius_mm});
                !found.ok())
                return renamed(found.error(), "slide");
        return Ok{};
    }

    Result<SlideReport> run() {
        const double step_mm = step_length_mm(m_grid.spacing_mm, m_path.sphere_radius_mm);
        m_steps = std::max(1, int(std::ceil(norm(m_path.push_mm) / step_mm)));
        m_began_free = !is_in_tissue(m_path.point_mm);
        int done = 0;
        while (done < m_steps) {
            if (const Status status = make_way(share_of(done + 1)); !status.ok())
                return status.error();
            if (m_report.limited_by != LimitedBy::None) break;
            if (is_in_tissue(position(share_of(done + 1)))) {
                m_report.limited_by = LimitedBy::Wall;
                m_report.message = kNoRoom;
                break;
            }
            ++done;
        }
        settle(done);
        return m_report;
    }

    bool began_free() const { return m_began_free; }

    /// Reports a slide that was undone because it left no position for the eye.
    void take_back(SlideReport& report) const {
        report.way_fraction = 0;
        report.limited_by = LimitedBy::Wall;
        report.message = kNoRoom;
        report.bone_mm.reset();
        report.end_mm = m_path.point_mm;
        report.ends_in_tissue = false;
        report.contacts = 0;
        report.inside_elements = elements_inside(report.end_mm);
    }

  private:
    double share_of(int step) const { return double(step) / m_steps; }
    Vec3d position(double share) const { return m_path.point_mm + share * m_path.push_mm; }

    bool is_in_tissue(Vec3d position_mm) const {
        return shows_tissue(lattice_of(m_tissue), m_tissue.volume(),
                            voxel_from_world(m_grid, position_mm), m_values);
    }

    /// Moves tissue out of the sphere at a fraction of its way.
    Status make_way(double share) {
        const Vec3d centre = voxel_from_world(m_grid, position(share));
        const Vec3d ahead = normalized(lattice_from_world_vector(m_grid, m_path.push_mm));
        for (int turn = 0; turn < kMaxTurns && m_report.limited_by == LimitedBy::None; ++turn) {
            const Touch touch = touch_sphere(lattice_of(m_tissue), m_tissue.volume(), centre,
                                             m_path.sphere_radius_mm, m_values);
            if (touch.is_empty()) return Ok{};
            const Vec3d move_mm = world_from_lattice_vector(
                m_grid, way_out(touch.inside_mm, m_path.sphere_radius_mm, ahead));
            auto done = m_tissue.push_elements(touch.elements, (1 / m_scale) * move_mm);
            if (!done.ok()) return done.error();
            m_report.contacts += done->status != PushStatus::Rejected;
            m_report.limited_by = done->limited_by;
            m_report.bone_mm = done->bone_mm;
            m_report.message = std::move(done->message);
        }
        return Ok{};
    }

    /// Finds a position for the eye: the sphere's present one, else one back along its way, else
    /// nearby.
    void settle(int done) {
        const double spacing_mm =
            std::max({m_grid.spacing_mm.x, m_grid.spacing_mm.y, m_grid.spacing_mm.z});
        int free = done;
        while (free > 0 && is_in_tissue(position(share_of(free)))) --free;
        m_report.way_fraction = share_of(free);
        m_report.end_mm = position(share_of(free));
        if (is_in_tissue(m_report.end_mm)) {
            m_report.way_fraction = share_of(done);
            const auto nearby =
                free_position_near(position(share_of(done)), m_path.sphere_radius_mm + spacing_mm);
            m_report.ends_in_tissue = !nearby;
            m_report.end_mm = nearby.value_or(position(share_of(done)));
        }
        m_report.inside_elements = elements_inside(m_report.end_mm);
    }

    std::int64_t elements_inside(Vec3d centre_mm) const {
        return std::int64_t(grab_sphere(lattice_of(m_tissue), voxel_from_world(m_grid, centre_mm),
                                        m_path.sphere_radius_mm, m_values)
                                .size());
    }

    std::optional<Vec3d> free_position_near(Vec3d position_mm, double reach_mm) const {
        constexpr int kShells = 12;
        const std::vector<Vec3d> directions = cube_directions();
        for (int shell = 1; shell <= kShells; ++shell)
            for (const Vec3d& direction : directions) {
                const Vec3d tried = position_mm + (reach_mm * shell / kShells) * direction;
                const Vec3d ijk = voxel_from_world(m_grid, tried);
                bool inside = true;
                for (int a = 0; a < 3; ++a)
                    inside = inside && ijk[a] >= 0 && ijk[a] <= m_grid.size[a] - 1;
                if (inside && !is_in_tissue(tried)) return tried;
            }
        return std::nullopt;
    }

    ChainMail& m_tissue;
    const Grid& m_grid;
    Push m_path;  ///< scaled
    TissueValues m_values;
    double m_scale;
    int m_steps = 1;
    bool m_began_free = true;
    SlideReport m_report;
};

/// The record of excused links, restored after a slide that is undone: each push shrinks it.
struct KeptAllowance {
    Lattice& lattice;
    Allowance& present;
    Allowance former;
    bool is_over = false;

    ~KeptAllowance() {
        if (!is_over) present.restore(lattice, std::move(former));
    }
};

}  // namespace

Result<SlideReport> slide_sphere(ChainMail& tissue, const Push& path,
                                 const TissueValues& tissue_values) {
    return attempt([&]() -> Result<SlideReport> {
        const Stopwatch watch;
        Slide slide(tissue, path, tissue_values);
        if (const Status status = slide.check(); !status.ok()) return status.error();
        auto& impl = ChainMailInside::of(tissue);
        KeptAllowance kept{impl.lattice, impl.allowance, impl.allowance};
        ChainMailInside::Impl::Operation step(
            impl, {.step = "slide", .ends_drag = true, .has_copies = true});
        Result<SlideReport> report = slide.run();
        if (!report.ok()) return report;
        const bool is_alone = impl.history.keeps_steps() && impl.history.depth() == 1;
        if (report->ends_in_tissue && slide.began_free() && is_alone) {
            step.roll_back();
            slide.take_back(*report);
        } else {
            report->forgotten_steps = step.commit();
            kept.is_over = true;
        }
        report->slide_ms = watch.ms();
        return report;
    });
}

Result<SlideReport> slide_sphere(ChainMail& tissue, const Push& path) {
    return slide_sphere(tissue, path, TissueValues{tissue.settings().air_threshold_hu});
}

}  // namespace pliant
