// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A thousand random sequences of operations on small scans, with each model of tissue. Their
// hashes are recorded: every machine and number of threads has the same (docs/developers/
// robustness.md, Other machines). The scans and tools are made without functions of libm.
// Covers: base/byte_order.h, base/hash.h.

#include <gtest/gtest.h>
#include <pliant/mesh.h>
#include <pliant/models/drivable.h>
#include <pliant/models/pbd.h>
#include <pliant/models/vessel.h>
#include <pliant/resample.h>
#include <pliant/tissues.h>

#include <array>
#include <bit>
#include <cstdio>

#include "base/hash.h"
#include "support/made.h"
#include "support/random.h"
#include "support/temporary_folder.h"

namespace pliant::test {
namespace {

constexpr std::uint32_t kFirstTool = 1, kSecondTool = 2;
constexpr int kSequences = 1000, kPerHash = 100;

/// Hashes of a hundred sequences each, on x86-64.
constexpr std::array<std::uint64_t, kSequences / kPerHash> kRecorded = {
    0x0c9dd83b6d28449a, 0x3b916649dca488e1, 0x64c22ad29560795e, 0x88e3a2bfc09257ab,
    0x4f0580ff55abf0e4, 0xa4dc5e10a038c725, 0xe6314abc07c61926, 0x0efddf39715dbecf,
    0x0003c977fba19309, 0xac41db720467215e};

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

/// Random operations on one tissue.
class Sequence {
  public:
    explicit Sequence(std::uint64_t number) : m_random(number), m_scan(scan_of(m_random)) {}

    /// @param model  0 to 9
    void run(int model, Hash64& hash) {
        m_tissue = make(model);
        ASSERT_TRUE(m_tissue);
        for (int n = m_random.whole(3, 6); n > 0; --n) {
            do_something(hash);
            hash.add_word(m_tissue->hash());
        }
        const auto deformed = deform_volume(*m_tissue);
        ASSERT_TRUE(deformed.ok()) << deformed.error().message;
        hash.add_word(hash_volume(deformed->volume));
        hash.add_word(std::uint64_t(deformed->written_voxels));
    }

  private:
    std::unique_ptr<Tissue> make(int model) {
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

    static void add(Hash64& hash, double number) {
        hash.add_word(std::bit_cast<std::uint64_t>(number));
    }
    template <class Report>
    static void add(Hash64& hash, const Result<Report>& report) {
        hash.add_word(report.ok() ? 1 : 2 + std::uint64_t(report.error().code));
    }
    static void add(Hash64& hash, const Status& status) {
        hash.add_word(status.ok() ? 1 : 2 + std::uint64_t(status.error().code));
    }

    void do_something(Hash64& hash) {
        Tissue& tissue = *m_tissue;
        if (Drivable* const catheter = tissue.drivable()) return drive(*catheter, hash);
        const int choice = m_random.whole(0, 19);
        if (choice < 7) {
            const auto report = tissue.push(kFirstTool, some_push());
            add(hash, report);
            if (!report.ok()) return;
            hash.add_word(std::uint64_t(report->status) << 32 | std::uint64_t(report->limited_by));
            add(hash, report->step_fraction);
            hash.add_word(std::uint64_t(report->moved_elements));
            const Vec3d force = tissue.force_n(kFirstTool).value_or(Vec3d{});
            for (int a = 0; a < 3; ++a) add(hash, force[a]);
        } else if (choice < 9) {
            add(hash, tissue.grab(kSecondTool, some_push(), 5));
            for (int n = m_random.whole(1, 3); n > 0; --n)
                add(hash, tissue.drag_to(m_random.vector(2)));
            tissue.let_go();
        } else if (choice < 10) {
            const auto report = tissue.slide(kFirstTool, some_push(), {});
            add(hash, report);
            if (report.ok()) add(hash, report->way_fraction);
        } else if (choice < 13) {
            tissue.release(kFirstTool);
            add(hash, tissue.advance({.max_steps = m_random.whole(1, 4)}));
            add(hash, tissue.energy_mm2().value_or(0));
        } else if (choice < 14) {
            add(hash, tissue.cut({{anywhere(), anywhere()}, m_random.vector(6)}));
        } else if (choice < 15) {
            add(hash, tissue.carve({anywhere(), anywhere(), m_random.real(0.5, 1.5)}));
        } else if (choice < 17) {
            add(hash, tissue.undo());
        } else if (choice < 18) {
            add(hash, tissue.redo());
        } else if (choice < 19) {
            tissue.release(kFirstTool);
            const auto file = m_folder / "state.plst";
            add(hash, tissue.rest());
            add(hash, tissue.save_state(file));
            add(hash, tissue.load_state(file));
        } else {
            tissue.release(kFirstTool);
            add(hash, tissue.reset());
        }
    }

    void drive(Drivable& catheter, Hash64& hash) {
        add(hash, catheter.drive(kFirstTool, {.insert_mm_s = m_random.real(-20, 60),
                                              .rotate_deg_s = m_random.real(-90, 90),
                                              .bend_first_deg = m_random.real(-40, 40),
                                              .bend_second_deg = m_random.real(-40, 40)}));
        add(hash, m_tissue->advance({.max_steps = m_random.whole(5, 25)}));
        add(hash, catheter.measures().force_n);
    }

    Random m_random;
    Volume m_scan;
    TaskArena m_arena{2};
    std::unique_ptr<Tissue> m_tissue;
    TemporaryFolder m_folder;
};

TEST(Sequences, HaveTheRecordedHashes) {
#if defined(__x86_64__)
    if (!__builtin_cpu_supports("fma"))
        GTEST_SKIP() << "the C library's sin, exp and pow have other bits without FMA";
#endif
    Hash64 total;
    for (int first = 0; first < kSequences; first += kPerHash) {
        Hash64 hash;
        for (int n = first; n < first + kPerHash; ++n) {
            SCOPED_TRACE(n);
            Sequence(std::uint64_t(n)).run(n % 10, hash);
            if (HasFatalFailure()) return;
        }
        std::printf("sequences %3d to %3d: %016llx\n", first, first + kPerHash - 1,
                    static_cast<unsigned long long>(hash.value()));
        std::fflush(stdout);
        EXPECT_EQ(hash.value(), kRecorded[std::size_t(first / kPerHash)]);
        total.add_word(hash.value());
    }
    std::printf("all sequences:        %016llx\n", static_cast<unsigned long long>(total.value()));
}

}  // namespace
}  // namespace pliant::test
