// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "support/random_operations.h"

#include "base/vector_targets.h"
//
#include <hwy/targets.h>
#include <pliant/core/tasks.h>
#include <pliant/mesh.h>
#include <pliant/models/drivable.h>
#include <pliant/models/pbd.h>
#include <pliant/models/vessel.h>
#include <pliant/render.h>
#include <pliant/resample.h>
#include <pliant/tissues.h>

#include <array>
#include <bit>
#include <memory>
#include <optional>
#include <span>
#include <variant>

#include "base/hash.h"
#include "support/made.h"
#include "support/random.h"
#include "support/temporary_folder.h"

namespace pliant::test {
namespace {

constexpr std::uint32_t kFirstTool = 1, kSecondTool = 2;
constexpr std::uint64_t kModels = 10;
constexpr int kPictureWidth = 13, kPictureHeight = 7;  // not a multiple of a vector

/// A rotation by the rational quaternion of four small numbers.
Mat3d rotation_of(Random& random) {
    std::array<double, 4> q;
    double square = 0;
    for (double& part : q) {
        part = random.whole(-3, 3);
        square += part * part;
    }
    if (square == 0) return kIdentity3;
    const auto [w, x, y, z] = q;
    Mat3d turn;
    turn.columns[0] = {w * w + x * x - y * y - z * z, 2 * (x * y + w * z), 2 * (x * z - w * y)};
    turn.columns[1] = {2 * (x * y - w * z), w * w - x * x + y * y - z * z, 2 * (y * z + w * x)};
    turn.columns[2] = {2 * (x * z + w * y), 2 * (y * z - w * x), w * w - x * x - y * y + z * z};
    for (Vec3d& column : turn.columns) column = (1 / square) * column;
    return turn;
}

/// Tissue around a canal of air, with some bone.
Volume scan_of(Random& random) {
    Volume scan;
    scan.grid.size = {random.whole(9, 14), random.whole(9, 13), random.whole(8, 12)};
    for (int a = 0; a < 3; ++a) {
        scan.grid.spacing_mm[a] = random.real(0.8, 2);
        scan.grid.origin_mm[a] = random.real(-50, 50);
    }
    scan.grid.direction = rotation_of(random);
    const Vec3i n = scan.grid.size;
    const bool is_float = random.whole(0, 3) == 0;
    std::vector<std::int16_t> shorts;
    std::vector<float> floats;
    for (int z = 0; z < n.z; ++z)
        for (int y = 0; y < n.y; ++y)
            for (int x = 0; x < n.x; ++x) {
                const double across = y - 0.5 * n.y, up = z - 0.5 * n.z;
                int value = 20 * ((3 * x + 5 * y + 7 * z) % 11) + random.whole(-20, 20);
                if (across * across + up * up < 3) value = -1000;
                if (x < 2 && y < 2) value = 1200;
                shorts.push_back(std::int16_t(value));
                floats.push_back(float(value) + 0.25F);
            }
    if (is_float)
        scan.voxels = std::move(floats);
    else
        scan.voxels = std::move(shorts);
    return scan;
}

/// A sequence in progress.
class Sequence {
  public:
    Sequence(std::uint64_t seed, const TaskArena& arena)
        : m_random(seed),
          m_scan(scan_of(m_random)),
          m_arena(arena),
          m_tissue(made_of(int(seed % kModels))) {}

    std::vector<OperationHash> run() {
        auto live = made(LiveDeformation::create(*m_tissue));
        for (int left = m_random.whole(3, 6); left > 0; --left) {
            m_hash = {};
            const std::string_view name = do_something();
            m_hash.add_word(m_tissue->hash());
            add(live.update());
            m_hash.add_word(hash_volume(live.volume()));
            m_done.push_back({name, m_hash.value()});
        }
        m_hash = {};
        look(live.volume());
        m_done.push_back({"look", m_hash.value()});
        return std::move(m_done);
    }

  private:
    std::unique_ptr<Tissue> made_of(int model) {
        switch (model) {
            case 0:
            case 1:
            case 2:
            case 3:
                return made(make_chainmail(m_scan, chainmail(), m_arena));
            case 4:
            case 5:
                return made(make_elastic(m_scan,
                                         {.poisson_ratio = m_random.real(0, 0.48),
                                          .held_sides = std::vector<std::string>{"-x"},
                                          .friction = m_random.real(0, 0.3)},
                                         m_arena));
            case 6:
                // cbrt of a cell's volume is exact: the C libraries' differ (robustness.md).
                m_scan.grid.spacing_mm = {1, 1, 1};
                return made(make_springs(m_scan,
                                         {.cell_mm = 2,
                                          .poisson_ratio = m_random.real(0.25, 0.4),
                                          .fixed_hu = 2000,
                                          .depth = m_random.whole(3, 8)},
                                         m_arena));
            case 7:
                return made(make_body(m_scan, box(),
                                      {.young_modulus_pa = 2e3,
                                       .poisson_ratio = m_random.real(0.2, 0.47),
                                       .ogden_alpha = m_random.whole(0, 1) ? 2.0 : 4.0,
                                       .sub_steps = 4,
                                       .reach_mm = 4},
                                      m_arena));
            case 8:
                return made(make_network(m_scan, network(), {.reach_mm = 4}, m_arena));
            default:
                return vessel();
        }
    }

    ChainMailSettings chainmail() {
        ChainMailSettings settings;
        settings.offset = m_random.real(0.05, 0.6);
        settings.bone_threshold_hu = m_random.real(200, 900);
        settings.max_movement_mm = m_random.real(2, 8);
        settings.air_enabled = m_random.whole(0, 2) > 0;
        settings.limits = m_random.whole(0, 3) == 0 ? LinkLimits::Rounded : LinkLimits::Box;
        settings.yield = m_random.whole(0, 1) ? m_random.real(0.2, 0.9) : 0;
        settings.bounded = m_random.whole(0, 3) > 0;
        return settings;
    }

    /// Tetrahedra in the middle of the scan.
    TetMesh box() {
        TetMesh mesh = five_tet_block({2, 2, 2}, 1);
        const Vec3i n = m_scan.grid.size;
        for (Vec3d& node : mesh.nodes_mm) {
            Vec3d ijk{};
            for (int a = 0; a < 3; ++a) ijk[a] = (n[a] - 1) * (0.2 + 0.3 * node[a]);
            node = world_from_voxel(m_scan.grid, ijk);
        }
        return mesh;
    }

    SpringParts network() {
        const TetMesh mesh = box();
        auto parts = made(springs_of_elastic_tetrahedra(
            mesh.nodes_mm, mesh.cells,
            {.stiffness = m_random.real(2000, 6000), .density = 1e-3, .bulk = 6000}));
        for (std::size_t n = 0; n < parts.nodes.size(); ++n) {
            parts.nodes[n].fixed = n < 9;
            parts.nodes[n].damping = 20 * parts.nodes[n].mass;
        }
        return parts;
    }

    std::unique_ptr<Tissue> vessel() {
        const Vec3i n = m_scan.grid.size;
        const auto point = [&](double i) {
            return world_from_voxel(m_scan.grid, {i * (n.x - 1), 0.5 * n.y, 0.5 * n.z});
        };
        std::vector<CentrePoint> way;
        for (int k = 0; k <= 4; ++k) way.push_back({point(0.25 * k), 2.5});
        CatheterSettings settings;
        settings.catheter.length_mm = 40;
        settings.catheter.tip_mm = 8;
        settings.entry = {point(0.2), normalized(point(1) - point(0)), 3};
        return made(pliant::make_vessel(
            m_scan, made(swept_tube(way, {.thickness_mm = 1, .layers = 2, .sectors = 8})), settings,
            m_arena));
    }

    Vec3d anywhere() {
        Vec3d ijk{};
        for (int a = 0; a < 3; ++a) ijk[a] = m_random.real(0.1, 0.9) * (m_scan.grid.size[a] - 1);
        return world_from_voxel(m_scan.grid, ijk);
    }
    Push some_push() {
        Push push{.point_mm = anywhere(), .push_mm = m_random.vector(2)};
        if (m_random.whole(0, 1)) push.sphere_radius_mm = m_random.real(1, 3.5);
        return push;
    }

    void add(double number) { m_hash.add_word(std::bit_cast<std::uint64_t>(number)); }
    void add(Vec3d v) {
        for (int a = 0; a < 3; ++a) add(v[a]);
    }
    template <class Report>
    void add(const Result<Report>& report) {
        m_hash.add_word(report.ok() ? 1 : 2 + std::uint64_t(report.error().code));
    }
    void add(const Status& status) {
        m_hash.add_word(status.ok() ? 1 : 2 + std::uint64_t(status.error().code));
    }

    std::string_view do_something() {
        if (Drivable* const catheter = m_tissue->drivable()) return drive(*catheter);
        const int choice = m_random.whole(0, 19);
        if (choice < 7) return push();
        if (choice < 9) return drag();
        if (choice < 10) return slide();
        if (choice < 13) return relax();
        if (choice < 14) {
            add(m_tissue->cut({{anywhere(), anywhere()}, m_random.vector(6)}));
            return "cut";
        }
        if (choice < 15) {
            add(m_tissue->carve({anywhere(), anywhere(), m_random.real(0.5, 1.5)}));
            return "carve";
        }
        if (choice < 17) {
            add(m_tissue->undo());
            return "undo";
        }
        if (choice < 18) {
            add(m_tissue->redo());
            return "redo";
        }
        m_tissue->release(kFirstTool);
        if (choice < 19) {
            const auto file = m_folder / "state.plst";
            add(m_tissue->rest());
            add(m_tissue->save_state(file));
            add(m_tissue->load_state(file));
            return "save";
        }
        add(m_tissue->reset());
        return "reset";
    }

    std::string_view push() {
        const auto report = m_tissue->push(kFirstTool, some_push());
        add(report);
        if (!report.ok()) return "push";
        m_hash.add_word(std::uint64_t(report->status) << 32 | std::uint64_t(report->limited_by));
        add(report->step_fraction);
        m_hash.add_word(std::uint64_t(report->grabbed_elements));
        m_hash.add_word(std::uint64_t(report->moved_elements));
        add(m_tissue->force_n(kFirstTool).value_or(Vec3d{0, 0, 0}));
        return "push";
    }
    std::string_view drag() {
        add(m_tissue->grab(kSecondTool, some_push(), 5));
        for (int n = m_random.whole(1, 3); n > 0; --n) add(m_tissue->drag_to(m_random.vector(2)));
        m_tissue->let_go();
        return "drag";
    }
    std::string_view slide() {
        const auto report = m_tissue->slide(kFirstTool, some_push(), {});
        add(report);
        if (report.ok()) add(report->way_fraction);
        return "slide";
    }
    std::string_view relax() {
        m_tissue->release(kFirstTool);
        add(m_tissue->advance({.max_steps = m_random.whole(1, 4)}));
        add(m_tissue->energy_mm2().value_or(0));
        return "relax";
    }
    std::string_view drive(Drivable& catheter) {
        add(catheter.drive(kFirstTool, {.insert_mm_s = m_random.real(-20, 60),
                                        .rotate_deg_s = m_random.real(-90, 90),
                                        .bend_first_deg = m_random.real(-40, 40),
                                        .bend_second_deg = m_random.real(-40, 40)}));
        add(m_tissue->advance({.max_steps = m_random.whole(5, 25)}));
        add(catheter.measures().force_n);
        return "drive";
    }

    /// Casts rays at the deformed scan, and makes it once more at once.
    void look(const Volume& shown) {
        const RayCaster caster(shown, m_arena);
        Endoscope endoscope{.eye_mm = anywhere(), .look = m_random.vector(1)};
        endoscope.look.x += 2;  // never zero
        endoscope.iso_hu = m_random.whole(0, 1) ? -500 : 40;
        std::vector<Vec3d> directions;
        for (int n = 0; n < 37; ++n) directions.push_back(m_random.vector(1));
        std::vector<double> distances(directions.size());
        caster.first_hits(endoscope.eye_mm, directions, endoscope.iso_hu, Polarity::Rising,
                          distances);
        m_hash.add(std::span<const double>(distances));
        if (m_random.whole(0, 1)) endoscope.style = Style::Real;
        const Image image = caster.endoscope_view(endoscope, kPictureWidth, kPictureHeight);
        m_hash.add(std::span(image.pixels.data(), image.pixels.size()));
        const auto deformed = made(deform_volume(*m_tissue));
        m_hash.add_word(hash_volume(deformed.volume));
        m_hash.add_word(std::uint64_t(deformed.written_voxels));
    }

    Random m_random;
    Volume m_scan;
    const TaskArena& m_arena;
    std::unique_ptr<Tissue> m_tissue;
    TemporaryFolder m_folder;
    Hash64 m_hash;
    std::vector<OperationHash> m_done;
};

}  // namespace

std::vector<OperationHash> run_random_operations(std::uint64_t seed) {
    static const TaskArena arena(HostJobs{.run = [](std::int64_t count, const auto& job) {
        for (std::int64_t n = 0; n < count; ++n) job(n);
    }});
    return Sequence(seed, arena).run();
}

std::vector<std::int64_t> own_targets() {
    std::vector<std::int64_t> targets;
    for (std::int64_t rest = hwy::SupportedTargets() & HWY_TARGETS; rest != 0; rest &= rest - 1)
        targets.push_back(rest & -rest);
    if (targets.empty()) targets.push_back(HWY_STATIC_TARGET);
    return targets;
}

OnTarget::OnTarget(std::int64_t target) {
    hwy::SetSupportedTargetsForTest(target);
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
}
OnTarget::~OnTarget() {
    hwy::SetSupportedTargetsForTest(0);
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
}

std::string name_of_target(std::int64_t target) {
    return hwy::TargetName(target);
}

}  // namespace pliant::test
