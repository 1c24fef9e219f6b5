// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Augmentation: a scan that is prepared for motions. The plans of motions are Python's
// (pliant/augment).

#include <pliant/chainmail.h>
#include <pliant/tissues.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

#include "keywords.h"
#include "made_tissue.h"
#include "pickled.h"
#include "volumes.h"
#include "warps.h"

namespace pliant::python {
namespace {

/// A ball that grows: its surface moves outwards, its surroundings by less.
struct Swelling {
    Vec3d centre;
    double growth, radius;
    static constexpr double kReach = 2.5;  ///< of the radius

    Vec3d at(Vec3d x) const {
        const Vec3d away = x - centre;
        const double r = norm(away);
        if (r >= kReach * radius) return {0, 0, 0};
        if (r <= radius) return growth / radius * away;
        return growth / r * (kReach * radius - r) / ((kReach - 1) * radius) * away;
    }
    Box3i box(const Grid& grid) const {
        const Vec3d middle = voxel_from_world(grid, centre);
        Box3i box;
        for (int a = 0; a < 3; ++a) {
            const double reach = kReach * radius / grid.spacing_mm[a];
            const double most = grid.size[a];
            box.begin[a] = int(std::clamp(std::floor(middle[a] - reach), 0.0, most));
            box.end[a] = int(std::clamp(std::ceil(middle[a] + reach) + 1, 0.0, most));
        }
        return box;
    }
};

/// A breath: the diaphragm's level moves, levels above and below it by less (a squared
/// cosine). Its motion along y grows from the spine to the belly.
struct Breath {
    Vec3d diaphragm, by;
    double above, below, depth;

    Vec3d at(Vec3d x) const {
        const double z = x.z - diaphragm.z;
        const double t = z > 0 ? z / above : -z / below;
        if (t >= 1) return {0, 0, 0};
        const double wave = std::cos(0.5 * M_PI * t);
        const double belly = std::clamp((diaphragm.y - x.y) / depth, 0.0, 1.0);
        return wave * wave * Vec3d{by.x, belly * by.y, by.z};
    }
};

/// A plane wave.
struct Wave {
    Vec3d by, vector;  ///< amplitude [mm], 2π times the direction over the length [rad/mm]
    double phase;

    Vec3d at(Vec3d x) const { return std::sin(dot(vector, x) + phase) * by; }
};

Box3i hull_of(const Box3i& a, const Box3i& b) {
    if (is_empty(a)) return b;
    if (is_empty(b)) return a;
    Box3i both;
    for (int n = 0; n < 3; ++n) {
        both.begin[n] = std::min(a.begin[n], b.begin[n]);
        both.end[n] = std::max(a.end[n], b.end[n]);
    }
    return both;
}

using SwellingNumbers = std::tuple<Vec3d, double, double>;
using BreathNumbers = std::tuple<Vec3d, Vec3d, double, double, double>;
using WaveNumbers = std::tuple<Vec3d, Vec3d, double>;

/// City-block distances from bone, in blocks of voxels: how far tissue can move follows from them.
class BoneDistance {
  public:
    BoneDistance(const Volume& volume, double bone_hu) : m_grid(volume.grid) {
        for (int a = 0; a < 3; ++a) m_size[a] = (m_grid.size[a] + kBlock - 1) / kBlock;
        m_mm.assign(std::size_t(m_size.x) * std::size_t(m_size.y) * std::size_t(m_size.z), kFar);
        std::visit([&](const auto& voxels) { find_bone(voxels.data(), bone_hu); }, volume.voxels);
        for (int a = 0; a < 3; ++a) spread(a);
    }
    double at(Vec3d point_mm) const {
        if (!is_finite(point_mm)) raise_value("point_mm", "finite numbers", nb::cast(point_mm));
        const Vec3d ijk = voxel_from_world(m_grid, point_mm);
        Vec3i block;
        for (int a = 0; a < 3; ++a)
            block[a] = int(std::clamp(ijk[a] / kBlock, 0.0, double(m_size[a] - 1)));
        return m_mm[index(block)];
    }

  private:
    static constexpr int kBlock = 4;
    static constexpr float kFar = 1e6f;

    std::size_t index(Vec3i b) const {
        return std::size_t(b.x) + std::size_t(m_size.x) *
                                      (std::size_t(b.y) + std::size_t(m_size.y) * std::size_t(b.z));
    }
    template <class T>
    void find_bone(const T* voxels, double bone_hu) {
        const Vec3i n = m_grid.size;
        const auto limit = float(bone_hu);
        for (int k = 0; k < n.z; ++k)
            for (int j = 0; j < n.y; ++j, voxels += n.x) {
                float* to = m_mm.data() + index({0, j / kBlock, k / kBlock});
                for (int i = 0; i < n.x; i += kBlock, ++to) {
                    T most = voxels[i];
                    const int end = std::min(i + kBlock, n.x);
                    for (int m = i + 1; m < end; ++m) most = std::max(most, voxels[m]);
                    if (float(most) > limit) *to = 0;
                }
            }
    }
    void spread(int axis) {
        const float step = float(kBlock * m_grid.spacing_mm[axis]);
        Vec3i b;
        const auto pass = [&](int begin, int end, int way) {
            for (b[axis] = begin; b[axis] != end; b[axis] += way) {
                Vec3i before = b;
                before[axis] -= way;
                float& to = m_mm[index(b)];
                to = std::min(to, m_mm[index(before)] + step);
            }
        };
        const int u = (axis + 1) % 3, v = (axis + 2) % 3;
        for (b[u] = 0; b[u] < m_size[u]; ++b[u])
            for (b[v] = 0; b[v] < m_size[v]; ++b[v]) {
                pass(1, m_size[axis], 1);
                pass(m_size[axis] - 2, -1, -1);
            }
    }

    const Grid m_grid;
    Vec3i m_size{0, 0, 0};
    std::vector<float> m_mm;
};

/// Settings whose voids have a small modulus, so that their cells are kept from folding as well.
ElasticScanSettings without_voids(ElasticScanSettings settings) {
    constexpr double kOfLargest = 1.0 / 150;  // above the modulus from which cells are tissue
    double largest = 0;
    for (const auto& entry : settings.moduli_kpa)
        if (entry.value <= settings.held_above_hu) largest = std::max(largest, entry.kpa);
    for (auto& entry : settings.moduli_kpa) entry.kpa = std::max(entry.kpa, kOfLargest * largest);
    return settings;
}

/// A scan with part of a deformation.
class PartlyMoved final : public MovingScan {
  public:
    PartlyMoved(const MovingScan& whole, double part)
        : m_whole(whole), m_deformation(take(Deformation::create(whole.volume().grid))) {
        const Deformation& moved = whole.deformation();
        take(m_deformation.displace(moved.moved_box(),
                                    [&](Vec3i ijk) { return part * moved.displacement_mm(ijk); }));
    }
    const Volume& volume() const override { return m_whole.volume(); }
    const Deformation& deformation() const override { return m_deformation; }
    const TaskArena& arena() const override { return m_whole.arena(); }

  private:
    const MovingScan& m_whole;
    Deformation m_deformation;
};

/// The members are destroyed in reverse order: each refers to those above it.
class PreparedScan : public Exclusive {
    template <class Work>
    auto run(const Work& work) const {
        return take(m_arena->run(work));
    }
    /// Moves the elastic scan. A tool that ends early has put its tissue back, unsmoothed: a sweep
    /// smooths it. One that has moved nothing lets go.
    template <class Move>
    auto moved(const Move& move) {
        return run([&]() -> decltype(move()) {
            auto report = move();
            if (!report || report->limited_by == LimitedBy::None) return report;
            if (done_part(*report) == 0) m_elastic->release(m_tool);
            if (const auto swept = m_elastic->advance({.max_steps = 1}); !swept)
                return swept.error();
            return report;
        });
    }
    static double done_part(const PushReport& report) { return report.step_fraction; }
    static double done_part(const SlideReport& report) { return report.way_fraction; }

  public:
    PreparedScan(nb::object scan, int threads, const std::string& model, const nb::kwargs& given)
        : m_scan(std::move(scan)),
          m_model(model),
          m_given(given),
          m_arena(std::make_unique<Arena>(threads)) {
        const Volume& volume = object_in<PyVolume>(m_scan, "scan", "a Volume").volume;
        ScanTissueSettings settings = scan_tissue_from(model, given, volume);
        if (const auto* const elastic = std::get_if<ElasticScanSettings>(&settings)) {
            m_bone_hu = elastic->held_above_hu;
            m_elastic = run(
                [&] { return make_elastic(volume, without_voids(*elastic), m_arena->tasks()); });
            return;
        }
        auto& chainmail = *std::get_if<ChainMailSettings>(&settings);
        m_bone_hu = chainmail.bone_threshold_hu;
        chainmail.history_max_steps = 0;
        const Vec3i n = volume.grid.size;
        if (std::min({n.x, n.y, n.z}) == 1) {
            m_doubled.emplace(take(with_doubled_slices(volume)));
            m_doubled->background = volume.background;
        }
        const Volume& moving = m_doubled ? *m_doubled : volume;
        m_chainmail.emplace(
            run([&] { return ChainMail::create(moving, chainmail, m_arena->tasks()); }));
    }

    nb::object scan() const { return m_scan; }
    const std::string& model() const { return m_model; }
    nb::dict settings() const { return m_given; }
    int threads() const { return m_arena->threads(); }
    double bone_distance_mm(Vec3d point_mm) {
        if (!m_bone) {
            const nb::gil_scoped_release without_lock;
            m_bone.emplace(moving().volume(), m_bone_hu);
        }
        return m_bone->at(point_mm);
    }
    /// 0 without limits: what folds is taken back.
    double fold_number() const { return m_chainmail ? m_chainmail->fold_certificate().all : 0; }
    PushReport push(Vec3d point_mm, Vec3d push_mm, double radius_mm) {
        const Push push{point_mm, push_mm, radius_mm};
        if (m_chainmail) return run([&] { return m_chainmail->push(push); });
        return moved([&] { return m_elastic->push(++m_tool, push); });
    }
    SlideReport slide(Vec3d point_mm, Vec3d way_mm, double radius_mm) {
        const Push way{point_mm, way_mm, radius_mm};
        if (m_chainmail) return run([&] { return slide_sphere(*m_chainmail, way); });
        return moved([&] { return m_elastic->slide(++m_tool, way, {}); });
    }
    FollowReport follow(const std::vector<SwellingNumbers>& swellings,
                        const std::vector<BreathNumbers>& breaths,
                        const std::vector<WaveNumbers>& wave_numbers) {
        if (m_elastic)
            raise({ErrorCode::Unsupported,
                   "motions: expected pushes, pulls and slides with the model elastic, found a "
                   "swelling, a breath or a wave",
                   "motions"});
        std::vector<Swelling> balls;
        for (const auto& [centre, growth, radius] : swellings) {
            if (!(radius > 0))
                raise({ErrorCode::InvalidArgument, "radius_mm: expected more than 0", "radius_mm"});
            if (!is_finite(centre)) raise_value("centre_mm", "finite numbers", nb::cast(centre));
            balls.push_back({centre, growth, radius});
        }
        std::vector<Breath> breathing;
        for (const auto& [diaphragm, by, above, below, depth] : breaths) {
            if (!(above > 0 && below > 0 && depth > 0))
                raise({ErrorCode::InvalidArgument,
                       "breath: expected above_mm, below_mm and depth_mm above 0", "breath"});
            breathing.push_back({diaphragm, by, above, below, depth});
        }
        std::vector<Wave> waves;
        for (const auto& [by, vector, phase] : wave_numbers) waves.push_back({by, vector, phase});
        const Grid& grid = m_chainmail->volume().grid;
        Box3i box;
        for (const Swelling& ball : balls) box = hull_of(box, ball.box(grid));
        if (!breathing.empty() || !waves.empty()) box = voxel_box(grid);
        if (is_empty(box)) return {.fraction = 1};
        return take(m_arena->run_reading([&] {
            int calls = 0;
            return m_chainmail->follow(box, [&](Vec3d x) {
                // Ctrl-C: the field of a call that is given up isn't finite, and nothing changes.
                constexpr int kLookEvery = 1 << 16;
                constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
                if (++calls % kLookEvery == 0 && m_arena->tasks().gives_up())
                    return Vec3d{kNone, kNone, kNone};
                Vec3d u{0, 0, 0};
                for (const Swelling& ball : balls) u = u + ball.at(x);
                for (const Breath& breath : breathing) u = u + breath.at(x);
                for (const Wave& wave : waves) u = u + wave.at(x);
                return u;
            });
        }));
    }
    /// @returns the warp, the deformed scan, and the part of all displacements that is left; the
    ///          tissue is at rest again
    std::tuple<PyWarp, PyVolume, double> finish() {
        PyVolume deformed;
        double part = 1;
        auto warp = run([&] {
            return m_elastic ? settled(deformed.volume, part)
                             : Warp::create(*m_chainmail, &deformed.volume);
        });
        reset();
        const Grid& grid = nb::cast<const PyVolume&>(m_scan).volume.grid;
        if (m_doubled) {
            const float background = deformed.volume.background;
            deformed.volume = take(with_single_slices(deformed.volume, grid));
            deformed.volume.background = background;
        }
        return {PyWarp{std::move(warp), grid}, std::move(deformed), part};
    }
    void reset() {
        if (m_chainmail) return m_chainmail->reset();
        take(m_elastic->reset());
        m_tool = 0;
    }

  private:
    const MovingScan& moving() const {
        if (m_elastic) return *m_elastic;
        return *m_chainmail;
    }
    /// The elastic scan after some sweeps. Where it is folded, all displacements are reduced.
    Result<Warp> settled(Volume& deformed, double& part) {
        constexpr int kSweeps = 5;
        constexpr double kReduced = 0.9;
        const auto advanced = m_elastic->advance({.max_steps = kSweeps});
        if (!advanced) return advanced.error();
        auto warp = Warp::create(*m_elastic, &deformed);
        while (warp && !(warp->smallest_jacobian() > 0)) {
            part *= kReduced;
            warp = Warp::create(PartlyMoved(*m_elastic, part), &deformed);
        }
        return warp;
    }

    nb::object m_scan;
    std::string m_model;
    nb::dict m_given;
    std::unique_ptr<Arena> m_arena;
    std::optional<Volume> m_doubled;  ///< the scan, if it has one slice
    std::optional<ChainMail> m_chainmail;
    std::unique_ptr<Tissue> m_elastic;
    std::uint32_t m_tool = 0;  ///< of the elastic scan's last motion
    double m_bone_hu = 0;
    std::optional<BoneDistance> m_bone;
};

}  // namespace

void bind_prepared_scan(nb::module_& m) {
    nb::class_<FollowReport>(m, "FollowReport", "Result of a motion that follows a field.")
        .def(Pickled<&FollowReport::fraction, &FollowReport::held_elements,
                     &FollowReport::moved_elements, &FollowReport::solve_ms,
                     &FollowReport::forgotten_steps>())
        .def_ro("fraction", &FollowReport::fraction, "Part of the field that was made, 0…1.")
        .def_ro("held_elements", &FollowReport::held_elements, "Voxels that bone holds back.")
        .def_ro("moved_elements", &FollowReport::moved_elements)
        .def_ro("solve_ms", &FollowReport::solve_ms);
    const Keywords keywords = scan_tissue_keywords();
    nb::class_<PreparedScan>(m, "PreparedScan",
                             "A scan that is prepared for motions, one set after the other. One "
                             "thread at a time.")
        .def(
            "__init__",
            [](nb::pointer_and_handle<PreparedScan> self, const nb::object& scan, int threads,
               const std::string& model, const nb::kwargs& settings) {
                if (!nb::isinstance<PyVolume>(scan))
                    raise({ErrorCode::InvalidArgument,
                           "scan: expected a Volume, found " + shown(nb::borrow(scan.type())),
                           "scan"});
                new (self.p) PreparedScan(scan, threads, model, settings);
            },
            nb::arg("scan"), nb::arg("threads") = 1, nb::arg("model") = "chainmail",
            nb::arg("settings"),
            typed("def __init__(self, scan: Volume, threads: int = 1, model: str = \"chainmail\", "
                  "*, **settings) -> None",
                  keywords),
            described("Args:\n"
                      "    model: \"chainmail\" or \"elastic\"; each has settings of its own "
                      "below.\n"
                      "    **settings",
                      keywords))
        .def_prop_ro("model", &PreparedScan::model, "Of the tissue.")
        .def_prop_ro("scan", &PreparedScan::scan, nb::sig("def scan(self, /) -> Volume"))
        .def_prop_ro("settings", &PreparedScan::settings,
                     nb::sig("def settings(self, /) -> dict[str, typing.Any]"),
                     "The settings that were given.")
        .def_prop_ro("fold_number", &PreparedScan::fold_number,
                     "Below 1: no motion can fold this scan. 0 of the elastic scan, whose "
                     "displacements are reduced until nothing is folded.")
        .def("bone_distance_mm", &PreparedScan::bone_distance_mm, nb::arg("point_mm"),
             "About the distance from bone along the grid's axes, which bounds motions there.")
        .def("follow", &PreparedScan::follow, nb::arg("swellings"), nb::arg("breaths"),
             nb::arg("waves") = std::vector<WaveNumbers>{},
             "Swellings (centre, growth, radius), breaths (diaphragm, motion, above, below, depth) "
             "and waves (amplitude, wave vector [rad/mm], phase) of a scan at rest, as one motion.")
        .def("push", &PreparedScan::push, nb::arg("point_mm"), nb::arg("push_mm"),
             nb::arg("sphere_radius_mm"))
        .def("slide", &PreparedScan::slide, nb::arg("point_mm"), nb::arg("way_mm"),
             nb::arg("sphere_radius_mm"))
        .def(
            "finish", &PreparedScan::finish,
            "The warp of all motions, the deformed scan, and the part of all displacements that is "
            "left: 1, unless the elastic scan is folded. The tissue is at rest again.")
        .def("reset", &PreparedScan::reset, "Takes all motions back.")
        .def(
            "__reduce__",
            [](nb::handle self) {
                const auto& scan = nb::cast<const PreparedScan&>(self);
                return exchange("reduced_prepared")(scan.scan(), scan.threads(), scan.model(),
                                                    scan.settings());
            },
            nb::sig("def __reduce__(self) -> tuple[typing.Any, ...]"), "At rest.");
}

}  // namespace pliant::python
