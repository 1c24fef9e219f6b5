// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "support/random_operations.h"

#include "base/vector_targets.h"
//
#include <hwy/targets.h>
#include <pliant/core/tasks.h>
#include <pliant/mesh.h>
#include <pliant/render.h>
#include <pliant/resample.h>
#include <pliant/tissues.h>

#include <bit>
#include <cmath>
#include <cstdlib>
#include <memory>
#include <optional>
#include <span>
#include <variant>

#include "base/hash.h"
#include "support/random.h"

namespace pliant::test {
namespace {

constexpr int kChainMail = 75,
              kElastic = 97;  // of 100 sequences; the others are bodies, the slowest
constexpr std::uint32_t kTools = 2;
constexpr int kPictureWidth = 13, kPictureHeight = 7;  // not a multiple of a vector

void add_number(Hash64& hash, double number) {
    hash.add_word(std::bit_cast<std::uint64_t>(number));
}
void add_vector(Hash64& hash, Vec3d v) {
    for (int a = 0; a < 3; ++a) add_number(hash, v[a]);
}

/// A rotation by 3-4-5 triangles, of which no function of the C library has a part.
Mat3d rational_rotation(Random& random) {
    Mat3d rotation = kIdentity3;
    for (int a = 0; a < 3; ++a) {
        if (random.whole(0, 1)) continue;
        Mat3d turn = kIdentity3;
        const double c = random.whole(0, 1) ? 0.8 : -0.6, s = c > 0 ? 0.6 : 0.8;
        turn.columns[std::size_t(a + 1) % 3][(a + 1) % 3] = c;
        turn.columns[std::size_t(a + 1) % 3][(a + 2) % 3] = s;
        turn.columns[std::size_t(a + 2) % 3][(a + 1) % 3] = -s;
        turn.columns[std::size_t(a + 2) % 3][(a + 2) % 3] = c;
        rotation = rotation * turn;
    }
    return rotation;
}

/// Tissue around a lumen, with some bone.
Volume scan_of(Random& random, int smallest, int largest) {
    Volume scan;
    for (int a = 0; a < 3; ++a) {
        scan.grid.size[a] = random.whole(smallest, largest);
        scan.grid.spacing_mm[a] = random.real(0.7, 2);
    }
    scan.grid.origin_mm = random.vector(100);
    scan.grid.direction = rational_rotation(random);
    const Vec3i n = scan.grid.size;
    const int lumen = random.whole(0, 5), across = random.whole(40, 90);
    std::vector<std::int16_t> values;
    values.reserve(voxel_count(scan.grid));
    for (int z = 0; z < n.z; ++z)
        for (int y = 0; y < n.y; ++y)
            for (int x = 0; x < n.x; ++x) {
                const int dy = 2 * y - n.y, dz = 2 * z - n.z;
                const bool is_air = dy * dy + dz * dz < lumen * lumen;
                const int tissue = (x * across + y * 37) % 260 - 60 + random.whole(-20, 20);
                values.push_back(std::int16_t(is_air ? -1000 : tissue));
            }
    for (int bones = random.whole(0, 2); bones > 0; --bones)
        values[std::size_t(random.whole(0, int(values.size()) - 1))] = 1200;
    scan.voxels = values;
    return scan;
}

std::unique_ptr<Tissue> made_or_none(Result<std::unique_ptr<Tissue>> made) {
    return made.ok() ? std::move(*made) : nullptr;
}

std::unique_ptr<Tissue> chainmail_of(Random& random, const Volume& scan, const TaskArena& arena) {
    ChainMailSettings settings;
    settings.offset = random.real(0.05, 0.6);
    settings.bone_threshold_hu = random.real(250, 900);
    settings.smallest_bone_mm3 = random.whole(0, 1) ? 0 : 100;
    settings.max_movement_mm = random.real(1, 8);
    settings.air_enabled = random.whole(0, 2) > 0;
    settings.limits = random.whole(0, 3) == 0 ? LinkLimits::Rounded : LinkLimits::Box;
    settings.yield = random.whole(0, 2) ? 0 : random.real(0.2, 0.9);
    settings.bounded = true;
    return made_or_none(make_chainmail(scan, settings, arena));
}

std::unique_ptr<Tissue> elastic_of(Random& random, const Volume& scan, const TaskArena& arena) {
    ElasticScanSettings settings;
    settings.poisson_ratio = random.real(0.1, 0.49);
    settings.friction = random.whole(0, 1) ? 0 : random.real(0, 0.5);
    settings.window_cells = 2 * random.whole(4, 8);
    return made_or_none(make_elastic(scan, settings, arena));
}

std::unique_ptr<Tissue> body_of(Random& random, const Volume& scan, const TaskArena& arena) {
    const Grid& grid = scan.grid;
    const int cells = 2;
    TetMesh mesh = five_tet_block({cells, cells, cells}, 1);
    for (Vec3d& node : mesh.nodes_mm) {  // in the scan, but for a voxel along its border
        Vec3d ijk{};
        for (int a = 0; a < 3; ++a) ijk[a] = 1 + node[a] * (grid.size[a] - 3) / cells;
        node = world_from_voxel(grid, ijk);
    }
    BodySettings settings;
    settings.poisson_ratio = random.real(0.2, 0.48);
    settings.sub_steps = random.whole(1, 2);
    settings.reach_mm = 3;
    return made_or_none(make_body(scan, mesh, settings, arena));
}

/// A sequence in progress.
class Sequence {
  public:
    Sequence(std::uint64_t seed, const TaskArena& arena)
        : m_random(seed),
          m_kind(m_random.whole(0, 99)),
          m_scan(m_kind < kChainMail ? scan_of(m_random, 5, 11) : scan_of(m_random, 5, 8)),
          m_tissue(m_kind < kChainMail ? chainmail_of(m_random, m_scan, arena)
                   : m_kind < kElastic ? elastic_of(m_random, m_scan, arena)
                                       : body_of(m_random, m_scan, arena)),
          m_arena(arena) {}

    std::vector<OperationHash> run() {
        if (!m_tissue) return {};
        auto live = LiveDeformation::create(*m_tissue);
        for (int left = m_random.whole(3, 7); left > 0; --left) {
            m_hash = {};
            const std::string_view name = do_something();
            m_hash.add_word(m_tissue->hash());
            add_shown(*live);
            m_done.push_back({name, m_hash.value()});
        }
        m_hash = {};
        look(live->volume());
        m_done.push_back({"look", m_hash.value()});
        return std::move(m_done);
    }

  private:
    Vec3d anywhere() {
        Vec3d ijk{};
        for (int a = 0; a < 3; ++a) ijk[a] = m_random.real(0, m_scan.grid.size[a] - 1);
        return world_from_voxel(m_scan.grid, ijk);
    }
    Push tool(double longest_mm) {
        Push push{.point_mm = anywhere(), .push_mm = m_random.vector(longest_mm)};
        if (m_random.whole(0, 1)) push.sphere_radius_mm = m_random.real(0.5, 3);
        return push;
    }
    std::uint32_t hand() { return std::uint32_t(m_random.whole(1, kTools)); }

    std::string_view do_something() {
        const TissueTraits traits = m_tissue->traits();
        switch (m_random.whole(0, 11)) {
            case 0:
                return drag();
            case 1:
                return traits.slides ? slide() : push();
            case 2:
                return traits.cuts ? cut() : push();
            case 3:
                return traits.carves ? carve() : push();
            case 4:
                return undo();
            case 5:
                return release();
            case 6:
            case 7:
            case 8:
                return sweep();
            default:
                return push();
        }
    }

    std::string_view push() {
        m_tissue->begin_group("push");
        const auto report = m_tissue->push(hand(), tool(3));
        m_hash.add_word(report.ok());
        if (report.ok()) add_report(*report);
        m_tissue->end_group();
        return "push";
    }
    std::string_view drag() {
        m_tissue->begin_group("drag");
        const auto grab = m_tissue->grab(hand(), tool(0), 4);
        m_hash.add_word(grab.ok() ? std::uint64_t(grab->grabbed_elements) : 0);
        Vec3d offset_mm{0, 0, 0};
        for (int steps = m_random.whole(1, 4); steps > 0; --steps) {
            offset_mm = offset_mm + m_random.vector(1.5);
            const auto report = m_tissue->drag_to(offset_mm);
            m_hash.add_word(report.ok());
            if (report.ok()) add_report(*report);
        }
        m_tissue->let_go();
        m_tissue->end_group();
        return "drag";
    }
    std::string_view slide() {
        Push way = tool(3);
        way.sphere_radius_mm = m_random.real(0.5, 2);
        m_tissue->begin_group("slide");
        const auto report = m_tissue->slide(hand(), way, {});
        m_hash.add_word(report.ok());
        if (report.ok()) {
            add_number(m_hash, report->way_fraction);
            add_vector(m_hash, report->end_mm);
            m_hash.add_word(std::uint64_t(report->contacts));
        }
        m_tissue->end_group();
        return "slide";
    }
    std::string_view cut() {
        const CutSurface surface{{anywhere(), anywhere()}, m_random.vector(6)};
        m_tissue->begin_group("cut");
        const auto report = m_tissue->cut(surface);
        m_hash.add_word(report.ok() ? std::uint64_t(report->cut_links) : ~std::uint64_t(0));
        m_tissue->end_group();
        return "cut";
    }
    std::string_view carve() {
        const Vec3d from = anywhere();
        m_tissue->begin_group("carve");
        const auto report = m_tissue->carve({from, from + m_random.vector(2), 1.2});
        m_hash.add_word(report.ok() ? std::uint64_t(report->carved_elements) : ~std::uint64_t(0));
        m_tissue->end_group();
        return "carve";
    }
    std::string_view undo() {
        m_hash.add_word(m_tissue->undo().ok());
        if (m_random.whole(0, 1)) return "undo";
        m_hash.add_word(m_tissue->redo().ok());
        return "redo";
    }
    std::string_view release() {
        m_tissue->release(hand());
        return "release";
    }
    std::string_view sweep() {
        m_tissue->begin_group("sweep");
        for (int sweeps = m_random.whole(1, 2); sweeps > 0; --sweeps) {
            const auto swept = m_tissue->sweep();
            m_hash.add_word(swept.ok() ? swept->settled : 2);
        }
        for (std::uint32_t hand = 1; hand <= kTools; ++hand)
            if (const auto force = m_tissue->force_n(hand)) add_vector(m_hash, *force);
        m_tissue->end_group();
        return "sweep";
    }

    void add_report(const PushReport& report) {
        m_hash.add_word(std::uint64_t(report.status));
        m_hash.add_word(std::uint64_t(report.limited_by));
        add_number(m_hash, report.step_fraction);
        m_hash.add_word(std::uint64_t(report.grabbed_elements));
        m_hash.add_word(std::uint64_t(report.moved_elements));
    }

    void add_shown(LiveDeformation& live) {
        const auto update = live.update();
        m_hash.add_word(update.ok());
        add_voxels(live.volume());
    }
    void add_voxels(const Volume& volume) {
        std::visit([&](const auto& array) { m_hash.add(std::span(array.data(), array.size())); },
                   volume.voxels);
    }

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
        const auto moved = deform_volume(*m_tissue);
        m_hash.add_word(moved.ok());
        if (moved.ok()) add_voxels(moved->volume);
    }

    Random m_random;
    int m_kind;
    Volume m_scan;
    std::unique_ptr<Tissue> m_tissue;
    const TaskArena& m_arena;
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
