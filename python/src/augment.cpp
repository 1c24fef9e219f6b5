// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Augmentation: a scan that is prepared for motions, and the warp that they make. The plans of
// motions are Python's (pliant/augment).

#include <pliant/chainmail.h>
#include <pliant/data/warp.h>
#include <pliant/tissues.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <tuple>
#include <type_traits>

#include "keywords.h"
#include "made_tissue.h"
#include "pickled.h"
#include "volumes.h"

namespace pliant::python {
namespace {

using Numbers = nb::ndarray<nb::ro, nb::c_contig, nb::device::cpu>;
using Points = nb::ndarray<const double, nb::ndim<2>, nb::c_contig, nb::device::cpu>;

/// The grid of with_doubled_slices.
Grid doubled_grid(const Grid& grid) {
    if (std::min({grid.size.x, grid.size.y, grid.size.z}) != 1) return grid;
    const Volume still{grid, VoxelArray<std::int16_t>(voxel_count(grid)), {}};
    return take(with_doubled_slices(still)).grid;
}

/// A warp of arrays on a grid. One slice has no cells: the warp of such a grid has two, which move
/// alike (with_doubled_slices).
struct PyWarp {
    Warp warp;
    Grid grid;

    bool is_doubled() const { return grid.size != warp.grid().size; }
};

/// Calls write(from, to) for a channel, with the slices that the warp has.
template <class T, class Write>
void with_slices_of(const PyWarp& self, std::span<const T> from, std::span<T> to,
                    const Write& write) {
    if (!self.is_doubled()) return write(from, to);
    const Grid& doubled = self.warp.grid();
    const Vec3i last = self.grid.size - Vec3i{1, 1, 1};
    std::vector<T> given(voxel_count(doubled)), made(given.size());
    const auto for_each_voxel = [](const Grid& grid, const auto& visit) {
        for (int k = 0; k < grid.size.z; ++k)
            for (int j = 0; j < grid.size.y; ++j)
                for (int i = 0; i < grid.size.x; ++i) visit(Vec3i{i, j, k});
    };
    for_each_voxel(doubled, [&](Vec3i p) {
        const Vec3i single{std::min(p.x, last.x), std::min(p.y, last.y), std::min(p.z, last.z)};
        given[voxel_index(doubled, p)] = from[voxel_index(self.grid, single)];
    });
    write(std::span<const T>(given), std::span<T>(made));
    for_each_voxel(self.grid,
                   [&](Vec3i p) { to[voxel_index(self.grid, p)] = made[voxel_index(doubled, p)]; });
}

/// A field on the grid of the arrays.
VectorField single_field(const PyWarp& self, VectorField field) {
    if (!self.is_doubled()) return field;
    VectorField single{self.grid, field.kind, std::vector<Vec3f>(voxel_count(self.grid))};
    with_slices_of<Vec3f>(self, single.vectors_mm, single.vectors_mm,
                          [&](std::span<const Vec3f>, std::span<Vec3f> to) {
                              std::copy(field.vectors_mm.begin(), field.vectors_mm.end(),
                                        to.begin());
                          });
    return single;
}

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
    /// smooths it.
    template <class Move>
    auto moved(const Move& move) {
        return run([&]() -> decltype(move()) {
            auto report = move();
            if (!report || report->limited_by == LimitedBy::None) return report;
            if (const auto swept = m_elastic->advance({.max_steps = 1}); !swept)
                return swept.error();
            return report;
        });
    }

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

LabelSampling sampling_of(const std::string& name) {
    if (name == "nearest") return LabelSampling::Nearest;
    if (name == "majority") return LabelSampling::Majority;
    raise({ErrorCode::InvalidArgument, "sampling: expected nearest or majority, found " + name,
           "sampling", "nearest or majority", name});
}

/// Calls work(T) with a value of the array's number type.
template <class Work>
void for_type(const Numbers& array, const Work& work) {
    const nb::dlpack::dtype type = array.dtype();
    const auto is = [&]<class T>(T) { return type == nb::dtype<T>(); };
    const auto call = [&]<class T>(T zero) {
        if (!is(zero)) return false;
        work(zero);
        return true;
    };
    const bool is_known = call(std::int8_t{}) || call(std::int16_t{}) || call(std::int32_t{}) ||
                          call(std::int64_t{}) || call(std::uint8_t{}) || call(std::uint16_t{}) ||
                          call(std::uint32_t{}) || call(std::uint64_t{}) || call(float{}) ||
                          call(double{});
    if (!is_known)
        raise({ErrorCode::InvalidArgument,
               "array: expected whole numbers, float32 or float64, found another type", "array"});
}

/// A new array of the same shape and type, of which each channel is written by write(from, to).
template <class Write>
nb::object each_channel(const PyWarp& self, const nb::object& given, const Write& write) {
    const Grid& grid = self.grid;
    const nb::module_ numpy = nb::module_::import_("numpy");
    const nb::object memory = numpy.attr("ascontiguousarray")(given);
    Numbers from;
    const auto fits = [&] {
        const std::size_t n = from.ndim();
        return n >= 3 && from.shape(n - 1) == std::size_t(grid.size.x) &&
               from.shape(n - 2) == std::size_t(grid.size.y) &&
               from.shape(n - 3) == std::size_t(grid.size.z);
    };
    if (!nb::try_cast<Numbers>(memory, from) || !fits()) {
        const std::string expected = "axes (…, " + std::to_string(grid.size.z) + ", " +
                                     std::to_string(grid.size.y) + ", " +
                                     std::to_string(grid.size.x) + ")";
        const std::string found = shown(memory.attr("shape"));
        raise({ErrorCode::InvalidArgument, "array: expected " + expected + ", found " + found,
               "array", expected, found});
    }
    nb::object made = numpy.attr("empty_like")(memory);
    const auto to = nb::cast<nb::ndarray<nb::c_contig, nb::device::cpu>>(made);
    const std::size_t voxels = voxel_count(grid);
    for_type(from, [&]<class T>(T) {
        const auto* const source = static_cast<const T*>(from.data());
        auto* const target = static_cast<T*>(to.data());
        const nb::gil_scoped_release without_lock;
        for (std::size_t first = 0; first < from.size(); first += voxels)
            with_slices_of<T>(self, std::span<const T>(source + first, voxels),
                              std::span<T>(target + first, voxels), write);
    });
    return made;
}

/// A background as a number of any type.
template <class T>
T number(double value) {
    using Limits = std::numeric_limits<T>;
    // The largest numbers of 64 bits round to one more.
    if (std::is_integral_v<T> && value >= double(Limits::max())) return Limits::max();
    if (std::is_integral_v<T> && value <= double(Limits::min())) return Limits::min();
    return T(value);
}

nb::object image(const PyWarp& self, const nb::object& array, double beyond, bool back) {
    const bool is_integer =
        nb::cast<std::string>(
            nb::module_::import_("numpy").attr("asarray")(array).attr("dtype").attr("kind")) != "f";
    if (is_integer && std::isnan(beyond)) raise_value("beyond", "a number", nb::float_(beyond));
    if (!back && !self.warp.has_inverse())
        raise({ErrorCode::InvalidArgument, "warp: expected one with an inverse", "warp"});
    return each_channel(self, array, [&]<class T>(std::span<const T> from, std::span<T> to) {
        if (back)
            self.warp.unwarp_image(from, to, number<T>(beyond));
        else
            self.warp.warp_image(from, to, number<T>(beyond));
    });
}

nb::object labels(const PyWarp& self, const nb::object& array, const std::string& sampling,
                  double beyond, bool back) {
    const LabelSampling how = sampling_of(sampling);
    if (!back && !self.warp.has_inverse())
        raise({ErrorCode::InvalidArgument, "warp: expected one with an inverse", "warp"});
    return each_channel(self, array, [&]<class T>(std::span<const T> from, std::span<T> to) {
        if (back)
            self.warp.unwarp_labels(from, to, how, number<T>(beyond));
        else
            self.warp.warp_labels(from, to, how, number<T>(beyond));
    });
}

nb::object points(const PyWarp& self, const nb::object& given, bool back) {
    const nb::object memory = array_in(given, "points_mm", "float64");
    Points from;
    if (!nb::try_cast<Points>(memory, from) || from.shape(1) != 3)
        raise({ErrorCode::InvalidArgument,
               "points_mm: expected axes (n, 3), found " + shown(memory.attr("shape")),
               "points_mm"});
    std::vector<Vec3d> moved(from.shape(0));
    bool is_found = true;
    for_each_row(moved.size(), [&](std::size_t n) {
        const double* const p = from.data() + 3 * n;
        const Vec3d at{p[0], p[1], p[2]};
        const auto to = back ? self.warp.inverse(at) : self.warp.forward(at);
        is_found &= to.has_value();
        moved[n] = to.value_or(at);
    });
    if (!is_found)
        raise(
            {ErrorCode::InvalidArgument, "points_mm: a point has no unique inverse", "points_mm"});
    return points_of(std::move(moved));
}

/// Elements along the edge of a block of a state.
constexpr int kStateBlock = 8;

Vec3i blocks_of(const Box3i& box) {
    const Vec3i n = box.end - box.begin;
    return {(n.x + kStateBlock - 1) / kStateBlock, (n.y + kStateBlock - 1) / kStateBlock,
            (n.z + kStateBlock - 1) / kStateBlock};
}

/// Calls visit(first of a row in the box's arrays, first in the block, length) for a block.
template <class Visit>
void for_rows_of_block(const Box3i& box, int number, const Visit& visit) {
    const Vec3i n = box.end - box.begin, blocks = blocks_of(box);
    const Vec3i first{kStateBlock * (number % blocks.x),
                      kStateBlock * (number / blocks.x % blocks.y),
                      kStateBlock * (number / (blocks.x * blocks.y))};
    const int length = std::min(kStateBlock, n.x - first.x);
    for (int z = 0; z < std::min(kStateBlock, n.z - first.z); ++z)
        for (int y = 0; y < std::min(kStateBlock, n.y - first.y); ++y)
            visit(std::size_t(first.x) +
                      std::size_t(n.x) *
                          (std::size_t(first.y + y) + std::size_t(n.y) * std::size_t(first.z + z)),
                  std::size_t(kStateBlock * (y + kStateBlock * z)), std::size_t(length));
}

/// (size, spacing, origin, direction, box, numbers of blocks of 8³ elements that move, their
/// displacements (n, 3, 8, 8, 8), has an inverse)
nb::tuple state_of(const PyWarp& self) {
    const WarpState& state = self.warp.state();
    const Grid& g = self.grid;
    const Box3i& box = state.box;
    constexpr std::size_t kElements = kStateBlock * kStateBlock * kStateBlock;
    auto* const numbers = new std::vector<std::int32_t>;
    auto* const kept = new std::vector<std::int32_t>;
    const auto owner = [](auto* memory) {
        return nb::capsule(
            memory, [](void* p) noexcept { delete static_cast<std::vector<std::int32_t>*>(p); });
    };
    const nb::capsule own_numbers = owner(numbers), own_kept = owner(kept);
    if (!state.units.empty()) {
        const nb::gil_scoped_release without_lock;
        const Vec3i blocks = blocks_of(box);
        const std::size_t count = state.units.size() / 3;
        for (int number = 0; number < blocks.x * blocks.y * blocks.z; ++number) {
            bool moves = false;
            for_rows_of_block(box, number, [&](std::size_t from, std::size_t, std::size_t length) {
                for (std::size_t a = 0; a < 3 && !moves; ++a)
                    for (std::size_t i = 0; i < length; ++i)
                        moves |= state.units[a * count + from + i] != 0;
            });
            if (!moves) continue;
            numbers->push_back(number);
            const std::size_t first = kept->size();
            kept->resize(first + 3 * kElements, 0);
            for_rows_of_block(
                box, number, [&](std::size_t from, std::size_t to, std::size_t length) {
                    for (std::size_t a = 0; a < 3; ++a)
                        std::copy_n(state.units.begin() + std::ptrdiff_t(a * count + from), length,
                                    kept->begin() + std::ptrdiff_t(first + a * kElements + to));
                });
        }
    }
    const auto list = nb::cast(nb::ndarray<nb::numpy, std::int32_t, nb::ndim<1>>(
        numbers->data(), {numbers->size()}, own_numbers));
    const auto units = nb::cast(nb::ndarray<nb::numpy, std::int32_t, nb::ndim<5>>(
        kept->data(), {numbers->size(), 3, kStateBlock, kStateBlock, kStateBlock}, own_kept));
    return nb::make_tuple(
        nb::make_tuple(g.size.x, g.size.y, g.size.z), g.spacing_mm, g.origin_mm, direction_of(g),
        nb::make_tuple(box.begin.x, box.begin.y, box.begin.z, box.end.x, box.end.y, box.end.z),
        list, units, self.warp.has_inverse());
}

[[noreturn]] void raise_about_state() {
    raise({ErrorCode::InvalidArgument, "warp: expected the state of another warp", "warp"});
}

PyWarp warp_of(const nb::tuple& state) {
    using List = nb::ndarray<const std::int32_t, nb::ndim<1>, nb::c_contig, nb::device::cpu>;
    using Units = nb::ndarray<const std::int32_t, nb::ndim<5>, nb::c_contig, nb::device::cpu>;
    if (nb::len(state) != 8) raise_about_state();
    std::vector<int> size, box;
    Vec3d spacing_mm, origin_mm;
    bool with_inverse = false;
    List list;
    Units units;
    if (!nb::try_cast(state[0], size) || !nb::try_cast(state[1], spacing_mm) ||
        !nb::try_cast(state[2], origin_mm) || !nb::try_cast(state[7], with_inverse) ||
        !nb::try_cast(state[4], box) || !nb::try_cast(state[5], list) ||
        !nb::try_cast(state[6], units) || size.size() != 3 || box.size() != 6 ||
        units.shape(0) != list.shape(0) || units.shape(1) != 3 ||
        units.size() != 3 * 512 * list.size())
        raise_about_state();
    WarpState made;
    const Grid grid = grid_from({size[0], size[1], size[2]}, spacing_mm, origin_mm,
                                numbers_of(nb::cast<nb::object>(state[3]), "direction"));
    if (!check_grid(grid).ok()) raise_about_state();
    made.grid = doubled_grid(grid);
    made.box = {{box[0], box[1], box[2]}, {box[3], box[4], box[5]}};
    constexpr double kMostElements = 1e11;  // whose blocks have numbers of 32 bits
    double elements = 1;
    for (int a = 0; a < 3; ++a) {
        const double length = double(made.box.end[a]) - double(made.box.begin[a]);
        if (!(length >= 0 && length <= 100000)) raise_about_state();
        elements *= length;
    }
    if (elements > kMostElements) raise_about_state();
    const Vec3i n = made.box.end - made.box.begin, blocks = blocks_of(made.box);
    const std::size_t count = std::size_t(n.x) * std::size_t(n.y) * std::size_t(n.z);
    made.units.assign(3 * count, 0);
    for (std::size_t m = 0; m < list.size(); ++m) {
        const int number = list.data()[m];
        if (number < 0 || number >= blocks.x * blocks.y * blocks.z) raise_about_state();
        const std::int32_t* const block = units.data() + 3 * 512 * m;
        for_rows_of_block(made.box, number,
                          [&](std::size_t to, std::size_t from, std::size_t length) {
                              for (std::size_t a = 0; a < 3; ++a)
                                  std::copy_n(block + 512 * a + from, length,
                                              made.units.begin() + std::ptrdiff_t(a * count + to));
                          });
    }
    const Arena arena(1);
    return {
        take(arena.run([&] { return Warp::create(std::move(made), arena.tasks(), with_inverse); })),
        grid};
}

void bind_warp(nb::module_& m) {
    nb::class_<PyWarp> c(
        m, "Warp",
        "One map for images, labels and points on a scan's grid, there and back.\n\n"
        "Arrays are (…, k, j, i): any number of channels before the grid's axes. Results are new "
        "arrays of the same shape and type. The interpreter's lock is free meanwhile.");
    c.def(
         "warp_image",
         [](const PyWarp& w, const nb::object& array, double beyond) {
             return image(w, array, beyond, false);
         },
         nb::arg("array"), nb::arg("beyond") = 0.0,
         nb::sig("def warp_image(self, array: numpy.typing.ArrayLike, beyond: float = 0.0) -> "
                 "numpy.typing.NDArray[typing.Any]"),
         "Moves an image: trilinear at the exact inverse.\n\n"
         "Args:\n    beyond: Value outside of the grid.")
        .def(
            "warp_labels",
            [](const PyWarp& w, const nb::object& array, const std::string& sampling,
               double beyond) { return labels(w, array, sampling, beyond, false); },
            nb::arg("array"), nb::arg("sampling") = "nearest", nb::arg("beyond") = 0.0,
            nb::sig("def warp_labels(self, array: numpy.typing.ArrayLike, sampling: str = "
                    "\"nearest\", beyond: float = 0.0) -> numpy.typing.NDArray[typing.Any]"),
            "Moves a label map by the same inverse.\n\n"
            "Args:\n    sampling: \"nearest\", or \"majority\": the label with the largest "
            "trilinear weight.")
        .def(
            "warp_points", [](const PyWarp& w, const nb::object& p) { return points(w, p, false); },
            nb::arg("points_mm"),
            nb::sig("def warp_points(self, points_mm: numpy.typing.ArrayLike) -> "
                    "numpy.typing.NDArray[numpy.float64]"),
            "Moves points (n, 3) [mm, LPS].")
        .def(
            "unwarp_image",
            [](const PyWarp& w, const nb::object& array, double beyond) {
                return image(w, array, beyond, true);
            },
            nb::arg("array"), nb::arg("beyond") = 0.0,
            nb::sig("def unwarp_image(self, array: numpy.typing.ArrayLike, beyond: float = 0.0) "
                    "-> numpy.typing.NDArray[typing.Any]"),
            "Takes a moved image, such as a prediction, back to the scan at rest.")
        .def(
            "unwarp_labels",
            [](const PyWarp& w, const nb::object& array, const std::string& sampling,
               double beyond) { return labels(w, array, sampling, beyond, true); },
            nb::arg("array"), nb::arg("sampling") = "nearest", nb::arg("beyond") = 0.0,
            nb::sig("def unwarp_labels(self, array: numpy.typing.ArrayLike, sampling: str = "
                    "\"nearest\", beyond: float = 0.0) -> numpy.typing.NDArray[typing.Any]"),
            "Takes a moved label map back.")
        .def(
            "unwarp_points",
            [](const PyWarp& w, const nb::object& p) { return points(w, p, true); },
            nb::arg("points_mm"),
            nb::sig("def unwarp_points(self, points_mm: numpy.typing.ArrayLike) -> "
                    "numpy.typing.NDArray[numpy.float64]"),
            "Takes moved points back.")
        .def(
            "forward_field",
            [](const PyWarp& w) { return single_field(w, take(w.warp.forward_field())); },
            "The displacement field, at rest voxel centres.")
        .def(
            "inverse_field",
            [](const PyWarp& w) {
                if (!w.warp.has_inverse())
                    raise(
                        {ErrorCode::InvalidArgument, "warp: expected one with an inverse", "warp"});
                return single_field(w, take(w.warp.inverse_field()));
            },
            "Its inverse, for resampling filters.")
        .def_prop_ro(
            "smallest_jacobian",
            [](const PyWarp& w) {
                const nb::gil_scoped_release without_lock;
                return w.warp.smallest_jacobian();
            },
            "Smallest determinant at the corners of all cells; above 0: nothing is folded.")
        .def_prop_ro(
            "moved_voxels", [](const PyWarp& w) { return w.warp.moved_elements(); },
            "Voxels away from their rest position, those beyond the grid included.")
        .def(
            "__init__",
            [](PyWarp* self, const nb::tuple& state) { new (self) PyWarp(warp_of(state)); },
            nb::arg("state"), nb::sig("def __init__(self, state: tuple[typing.Any, ...]) -> None"),
            "Of another warp's state.")
        .def_prop_ro("state", &state_of, nb::sig("def state(self, /) -> tuple[typing.Any, ...]"),
                     "Grid and displacements: numbers and arrays that give the same warp again.")
        .def(
            "__reduce__",
            [](nb::handle self) {
                return nb::make_tuple(self.attr("__class__"), nb::make_tuple(self.attr("state")));
            },
            nb::sig("def __reduce__(self) -> tuple[typing.Any, ...]"))
        .def(
            "__deepcopy__", [](nb::handle self, nb::handle) { return nb::borrow(self); },
            nb::arg("memo"), nb::sig("def __deepcopy__(self, memo: typing.Any) -> Warp"),
            "The same: a warp doesn't change.")
        .def("__repr__", [](const PyWarp& w) {
            return "Warp(" + std::to_string(w.warp.moved_elements()) + " voxels moved)";
        });
    bind_grid(c, [](const PyWarp& w) -> const Grid& { return w.grid; });
}

}  // namespace

void bind_augment(nb::module_& m) {
    bind_warp(m);
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
