// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include <pliant/data/truth.h>
#include <pliant/resample.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "base/errors.h"
#include "base/hash.h"
#include "base/text.h"
#include "field/field.h"
#include "resample/find_source.h"
#include "truth/exact_map.h"
#include "truth/motions.h"
#include "volume/boxes.h"

namespace pliant {
namespace {

using truth::Breathing;
using truth::Draws;
using truth::ExactMap;
using truth::Motions;
using truth::Regions;

constexpr int kLeastVoxels = 8;     ///< along each axis of a scan
constexpr double kBound_mm = 1e-4;  ///< pairs that differ by more are not used
constexpr double kRounded = 1e-5;   ///< points that lie beyond the border by less [voxels]
constexpr double kClosed = 0.1;     ///< volume that is left of air in a closed lumen
constexpr std::uint64_t kOrder = 0, kLandmarks = 1, kFirstMotion = 2;  ///< streams of a case

/// World vector [mm, LPS] of a difference of voxel indices.
Vec3d world_vector(const Grid& grid, Vec3d d) {
    return world_from_lattice_vector(
        grid, {d.x * grid.spacing_mm.x, d.y * grid.spacing_mm.y, d.z * grid.spacing_mm.z});
}
Vec3f narrowed(Vec3d v) {
    return {float(v.x), float(v.y), float(v.z)};
}
/// @param slack  for points that were rounded [voxels]
bool is_inside(const Grid& grid, Vec3d v, double slack = 0) {
    for (int a = 0; a < 3; ++a)
        if (!(v[a] >= -slack && v[a] <= grid.size[a] - 1 + slack)) return false;
    return true;
}

/// The sum of a tissue's displacements and breathing.
class Composed : public MovingScan {
  public:
    Composed(const Volume& volume, Deformation deformation, const TaskArena& arena)
        : m_volume(volume), m_deformation(std::move(deformation)), m_arena(arena) {}
    const Volume& volume() const override { return m_volume; }
    const Deformation& deformation() const override { return m_deformation; }
    const TaskArena& arena() const override { return m_arena; }

    static Result<Composed> create(const Tissue& tissue, const Breathing& breathing,
                                   const std::vector<float>& rigid_mm, const TaskArena& arena) {
        const Grid& grid = tissue.volume().grid;
        auto deformation = Deformation::create(grid);
        if (!deformation.ok()) return deformation.error();
        const Deformation& moved = tissue.deformation();
        const Box3i box = hull(moved.moved_box(), voxel_box(grid));
        constexpr int kLayers = 8;
        std::vector<Vec3d> u_mm;
        for (int k = box.begin.z; k < box.end.z; k += kLayers) {
            Box3i slab = box;
            slab.begin.z = k;
            slab.end.z = std::min(k + kLayers, box.end.z);
            const Vec3i n = slab.end - slab.begin;
            u_mm.resize(dense_count(n));
            arena.for_each(std::int64_t(n.y) * n.z, 16, [&](std::int64_t begin, std::int64_t end) {
                for (; begin < end; ++begin) {
                    Vec3i e = slab.begin + Vec3i{0, int(begin % n.y), int(begin / n.y)};
                    Vec3d* to = u_mm.data() + std::size_t(begin) * std::size_t(n.x);
                    for (; e.x < slab.end.x; ++e.x, ++to) {
                        *to = moved.displacement_mm(e);
                        if (!contains(voxel_box(grid), e)) continue;
                        const float rigid = rigid_mm[voxel_index(grid, e)];
                        if (rigid > 0)
                            *to = *to +
                                  breathing.at(world_from_voxel(grid, real_of(e)), double(rigid));
                    }
                }
            });
            if (const Status s = deformation->write(slab, u_mm); !s.ok()) return s.error();
        }
        const Field& field = moved.field();
        const int size = field.brick_size();
        for (const auto& [coord, edits] : field.all_edits()) {
            const Vec3i first = size * coord;
            if (const Status s = deformation->edit({first, first + Vec3i{size, size, size}}, edits);
                !s.ok())
                return s.error();
        }
        return Composed(tissue.volume(), std::move(*deformation), arena);
    }

  private:
    const Volume& m_volume;
    Deformation m_deformation;
    const TaskArena& m_arena;
};

Result<std::vector<TruthKind>> kinds_from(const std::string& text) {
    std::vector<TruthKind> kinds;
    for (const std::string_view part : split(text, ',')) {
        const std::string_view name = trimmed(part);
        int found = -1;
        for (int kind = 0; kind < kTruthKinds; ++kind)
            if (name == name_of(TruthKind(kind))) found = kind;
        if (found < 0)
            return expected_error("kinds", "contact, slide, cut, interface or breathing",
                                  std::string(name));
        if (std::find(kinds.begin(), kinds.end(), TruthKind(found)) == kinds.end())
            kinds.push_back(TruthKind(found));
    }
    if (kinds.empty())
        return expected_error("kinds", "contact, slide, cut, interface or breathing", "none");
    return kinds;
}

/// @returns InvalidArgument for cuts in a tissue whose tools hold: a cut that is undone frees them
Status check_kinds(const std::vector<TruthKind>& kinds, const TissueTraits& traits) {
    for (const TruthKind kind : kinds)
        if ((!traits.cuts || traits.moves_by_itself) &&
            (kind == TruthKind::Cut || kind == TruthKind::Interface))
            return expected_error("kinds",
                                  "contact, slide or breathing with the model " +
                                      std::string(traits.model) + ", without cuts",
                                  std::string(name_of(kind)));
    return Ok{};
}

/// The thresholds of air and bone. Air of the elastic scan: values up to its largest void.
ChainMailSettings thresholds_of(const ScanTissueSettings& materials) {
    if (const auto* const chainmail = std::get_if<ChainMailSettings>(&materials)) return *chainmail;
    ElasticScanSettings elastic = *std::get_if<ElasticScanSettings>(&materials);
    if (elastic.moduli_kpa.empty()) suit_elastic({}, elastic);
    ChainMailSettings thresholds;
    thresholds.bone_threshold_hu = elastic.held_above_hu;
    thresholds.smallest_bone_mm3 = 0;
    thresholds.air_enabled = false;
    for (const auto& [value, kpa] : elastic.moduli_kpa) {
        if (kpa > 0) break;
        thresholds.air_enabled = true;
        thresholds.air_threshold_hu = std::nextafter(value, HUGE_VAL);
    }
    return thresholds;
}

/// Arrays of a case while they are filled.
struct Arrays {
    explicit Arrays(const Grid& grid)
        : fixed(voxel_count(grid)), moving(voxel_count(grid)), labels(voxel_count(grid)) {}
    VoxelArray<std::int16_t> fixed, moving, labels;
};

}  // namespace

struct TruthMap::Impl {
    ExactMap map;
};
TruthMap::TruthMap(std::unique_ptr<Impl> impl) noexcept : m_impl(std::move(impl)) {}
TruthMap::~TruthMap() = default;
TruthMap::TruthMap(TruthMap&&) noexcept = default;

std::optional<Vec3d> TruthMap::moving_from_fixed(Vec3d fixed_mm) const noexcept {
    const ExactMap& map = m_impl->map;
    const Vec3d x = voxel_from_world(map.grid(), fixed_mm);
    if (!is_inside(map.grid(), x, kRounded)) return {};
    const std::optional<Vec3d> y = map.image_of(x);
    if (!y || !is_inside(map.grid(), *y, kRounded)) return {};
    if (!map.is_plain(*y)) {
        Vec3d source{0, 0, 0};
        if (map.source_of(*y, x, source) != TruthMask::Exact || !(norm(source - x) < 1e-5))
            return {};
    }
    return world_from_voxel(map.grid(), *y);
}

std::optional<Vec3d> TruthMap::fixed_from_moving(Vec3d moving_mm) const noexcept {
    const ExactMap& map = m_impl->map;
    const Vec3d y = voxel_from_world(map.grid(), moving_mm);
    Vec3d x{0, 0, 0};
    if (!is_inside(map.grid(), y, kRounded) || map.source_of(y, y, x) != TruthMask::Exact ||
        !is_inside(map.grid(), x, kRounded))
        return {};
    return world_from_voxel(map.grid(), x);
}

struct TruthMaker::Impl {
    const Volume& scan;
    ScanTissueSettings materials;
    ChainMailSettings thresholds;  ///< of air and bone
    TruthSettings settings;
    const TaskArena& arena;
    std::vector<TruthKind> kinds;
    Regions regions;

    Result<TruthCase> make(std::uint64_t seed) const;
    Result<bool> carry_out(std::uint64_t seed, Motions& motions) const;
    Status complete(const MovingScan& moved, const Motions& motions, std::uint64_t seed,
                    TruthCase& made) const;
    void fill_fixed(const ExactMap& map, TruthCase& made, Arrays& arrays) const;
    void fill_moving(const ExactMap& map, const Deformed& deformed, TruthCase& made,
                     Arrays& arrays) const;
    void choose_landmarks(const ExactMap& map, const Arrays& arrays, std::uint64_t seed,
                          TruthCase& made) const;
    bool has_tissue_around(Vec3d x) const;
    template <class Work>
    void for_rows(const Work& work) const {
        const Vec3i n = scan.grid.size;
        arena.for_each(std::int64_t(n.y) * n.z, 32, [&](std::int64_t begin, std::int64_t end) {
            for (; begin < end; ++begin) work(Vec3i{0, int(begin % n.y), int(begin / n.y)});
        });
    }
};

TruthMaker::TruthMaker(std::unique_ptr<Impl> impl) noexcept : m_impl(std::move(impl)) {}
TruthMaker::~TruthMaker() = default;
TruthMaker::TruthMaker(TruthMaker&&) noexcept = default;
TruthMaker& TruthMaker::operator=(TruthMaker&&) noexcept = default;
const TruthSettings& TruthMaker::settings() const noexcept {
    return m_impl->settings;
}

Result<TruthMaker> TruthMaker::create(const Volume& scan, const ScanTissueSettings& materials,
                                      const TruthSettings& settings,
                                      const TaskArena& arena) noexcept {
    return attempt([&]() -> Result<TruthMaker> {
        if (const Status s = check_volume(scan, "scan"); !s.ok()) return s.error();
        for (int a = 0; a < 3; ++a)
            if (scan.grid.size[a] < kLeastVoxels)
                return expected_error("scan",
                                      std::to_string(kLeastVoxels) + " or more voxels on each axis",
                                      text_of_size(scan.grid.size));
        if (voxel_count(scan.grid) > std::numeric_limits<std::uint32_t>::max())
            return expected_error("scan", "at most 2^32 voxels", text_of_size(scan.grid.size));
        if (const Status s = check(settings, truth_rows()); !s.ok()) return s.error();
        auto kinds = kinds_from(settings.kinds);
        if (!kinds.ok()) return kinds.error();
        auto impl = std::make_unique<Impl>(Impl{
            scan, materials, thresholds_of(materials), settings, arena, std::move(*kinds), {}});
        if (auto* const chainmail = std::get_if<ChainMailSettings>(&impl->materials)) {
            chainmail->bounded = false;
            chainmail->history_max_steps = 200;
            chainmail->history_max_mb = 256;
        }
        // Errors of the materials appear now, not with the first case.
        if (const auto tissue = make_scan_tissue(scan, impl->materials, arena); !tissue.ok())
            return tissue.error();
        else if (const Status s = check_kinds(impl->kinds, (*tissue)->traits()); !s.ok())
            return s.error();
        const bool breathes = std::find(impl->kinds.begin(), impl->kinds.end(),
                                        TruthKind::Breathing) != impl->kinds.end();
        impl->regions =
            truth::find_regions(scan, impl->thresholds, settings.band_mm, breathes, arena);
        return TruthMaker(std::move(impl));
    });
}

Result<TruthCase> TruthMaker::make(std::uint64_t seed) const noexcept {
    return attempt([&] { return m_impl->make(seed); });
}

Result<bool> TruthMaker::Impl::carry_out(std::uint64_t seed, Motions& motions) const {
    Draws order(seed, kOrder);
    std::vector<TruthKind> open = kinds;  // kinds that may still be drawn
    for (int n = 0; n < settings.motions && !open.empty(); ++n) {
        Draws draws(seed, kFirstMotion + std::uint64_t(n));
        while (!open.empty()) {
            const auto at = open.begin() + std::ptrdiff_t(order.below(open.size()));
            const TruthKind kind = *at;
            const Result<bool> done = motions.carry_out(kind, draws);
            if (!done.ok()) return done;
            // Breathing happens once; other kinds fail where the scan has no place for them.
            if (!*done || kind == TruthKind::Breathing) open.erase(at);
            if (*done) break;
        }
    }
    return !motions.done().empty();
}

Result<TruthCase> TruthMaker::Impl::make(std::uint64_t seed) const {
    auto tissue = make_scan_tissue(scan, materials, arena);
    if (!tissue.ok()) return tissue.error();
    Motions motions(scan, regions, settings, thresholds.air_threshold_hu, **tissue);
    const Result<bool> done = carry_out(seed, motions);
    if (!done.ok()) return done.error();
    if (!*done)
        return Error{ErrorCode::NotFound,
                     "scan: expected a place for a motion of the kinds " + settings.kinds +
                         ", found none in " + std::to_string(regions.soft.size()) +
                         " soft-tissue and " + std::to_string(regions.walls.size()) +
                         " wall voxels"};
    TruthCase made;
    made.seed = seed;
    made.motions = motions.done();
    Status status = Ok{};
    if (motions.breathing().amplitude_mm > 0) {
        const auto composed =
            Composed::create(**tissue, motions.breathing(), regions.rigid_mm, arena);
        if (!composed.ok()) return composed.error();
        status = complete(*composed, motions, seed, made);
    } else {
        status = complete(**tissue, motions, seed, made);
    }
    if (!status.ok()) return status.error();
    return made;
}

Status TruthMaker::Impl::complete(const MovingScan& moved, const Motions& motions,
                                  std::uint64_t seed, TruthCase& made) const {
    auto deformed = deform_volume(moved, Mapping::Cells, true);
    if (!deformed.ok()) return deformed.error();
    auto map_impl =
        std::make_unique<TruthMap::Impl>(TruthMap::Impl{ExactMap(moved.deformation(), arena)});
    const ExactMap& map = map_impl->map;
    made.map = std::make_shared<TruthMap>(TruthMap(std::move(map_impl)));
    made.folded_cells = map.folded_cells();
    const Grid& grid = scan.grid;
    std::vector<std::int16_t> labels = regions.labels;
    for (const TruthLabel label : {TruthLabel::Interface, TruthLabel::Cut})
        truth::label_around(grid, motions.cut_voxels(label), settings.band_mm, label, labels);
    Arrays arrays(grid);
    std::copy(labels.begin(), labels.end(), arrays.labels.begin());
    made.forward = {grid, FieldKind::Modeling, std::vector<Vec3f>(voxel_count(grid), {0, 0, 0})};
    made.inverse = {grid, FieldKind::Resampling, std::vector<Vec3f>(voxel_count(grid), {0, 0, 0})};
    fill_fixed(map, made, arrays);
    fill_moving(map, *deformed, made, arrays);
    made.moving = std::move(deformed->volume);
    choose_landmarks(map, arrays, seed, made);
    for (std::size_t n = 0; n < labels.size(); ++n) {
        ++made.label_voxels[std::size_t(labels[n])];
        ++made.fixed_voxels[std::size_t(arrays.fixed[n])];
        ++made.moving_voxels[std::size_t(arrays.moving[n])];
    }
    const auto volume_of = [&](VoxelArray<std::int16_t>& values) {
        values.freeze();
        return Volume{grid, std::move(values), {}, 0};
    };
    made.labels = volume_of(arrays.labels);
    made.fixed_mask = volume_of(arrays.fixed);
    made.moving_mask = volume_of(arrays.moving);
    Hash64 hash;
    for (const Volume* volume : {&made.moving, &made.labels, &made.fixed_mask, &made.moving_mask})
        hash.add_word(hash_volume(*volume));
    for (const VectorField* field : {&made.forward, &made.inverse})
        hash.add(std::span<const Vec3f>(field->vectors_mm));
    for (const TruthLandmark& landmark : made.landmarks) {
        hash.add(std::span<const Vec3d>(&landmark.fixed_mm, 1));
        hash.add(std::span<const Vec3d>(&landmark.moving_mm, 1));
    }
    made.hash = hash.value();
    return Ok{};
}

void TruthMaker::Impl::fill_fixed(const ExactMap& map, TruthCase& made, Arrays& arrays) const {
    const Grid& grid = scan.grid;
    std::vector<double> longest(std::size_t(grid.size.z) * std::size_t(grid.size.y), 0);
    for_rows([&](Vec3i p) {
        double& row_longest =
            longest[std::size_t(p.y) + std::size_t(grid.size.y) * std::size_t(p.z)];
        for (; p.x < grid.size.x; ++p.x) {
            const std::size_t n = voxel_index(grid, p);
            const Vec3d x = real_of(p), y = map.image_of(p);
            const Vec3d u = world_vector(grid, y - x);
            made.forward.vectors_mm[n] = narrowed(u);
            row_longest = std::max(row_longest, norm(u));
            TruthMask mask = TruthMask::Exact;
            if (map.is_void(p)) {
                mask = TruthMask::Gap;
            } else if (!is_inside(grid, y)) {
                mask = TruthMask::Outside;
            } else if (!map.is_plain(y)) {
                Vec3d source{0, 0, 0};
                mask = map.source_of(y, x, source);
                if (mask == TruthMask::Exact && !(norm(source - x) < 1e-5))
                    mask = TruthMask::Ambiguous;
            }
            if (arrays.labels[n] == std::int16_t(TruthLabel::Air) && contains(map.elements(), p)) {
                Mat3d f;
                for (int a = 0; a < 3; ++a) {
                    Vec3i low = p, high = p;
                    --low[a], ++high[a];
                    f.columns[a] = 0.5 * (map.image_of(high) - map.image_of(low));
                }
                if (determinant(f) < kClosed && mask != TruthMask::Outside)
                    mask = TruthMask::ClosedLumen;
            }
            arrays.fixed[n] = std::int16_t(mask);
        }
    });
    made.max_displacement_mm = *std::max_element(longest.begin(), longest.end());
}

void TruthMaker::Impl::fill_moving(const ExactMap& map, const Deformed& deformed, TruthCase& made,
                                   Arrays& arrays) const {
    const Grid& grid = scan.grid;
    const Box3i& dirty = deformed.dirty_box;
    const Mat3d axes = inverse(grid.direction);
    std::vector<double> worst(std::size_t(grid.size.z) * std::size_t(grid.size.y), 0);
    for_rows([&](Vec3i p) {
        double& row_worst = worst[std::size_t(p.y) + std::size_t(grid.size.y) * std::size_t(p.z)];
        for (; p.x < grid.size.x; ++p.x) {
            const std::size_t n = voxel_index(grid, p);
            const Vec3d y = real_of(p);
            if (map.is_plain(y) && map.units_at(p) == Vec3<Fixed>{0, 0, 0}) {
                arrays.moving[n] = std::int16_t(TruthMask::Exact);
                continue;
            }
            Vec3d guess = y, x{0, 0, 0};
            if (contains(dirty, p)) {
                const Vec3f v =
                    deformed.inverse_mm[dense_index(p - dirty.begin, dirty.end - dirty.begin)];
                const Vec3d along = axes * Vec3d{v.x, v.y, v.z};
                for (int a = 0; a < 3; ++a) guess[a] += along[a] / grid.spacing_mm[a];
            }
            TruthMask mask = map.source_of(y, guess, x);
            if (mask == TruthMask::Exact && !is_inside(grid, x)) mask = TruthMask::Outside;
            if (mask == TruthMask::Exact) {
                const Vec3f v = narrowed(world_vector(grid, x - y));
                // Uses the rounded (float) vector that the file will hold.
                const Vec3d along = axes * Vec3d{v.x, v.y, v.z};
                Vec3d from = y;
                for (int a = 0; a < 3; ++a) from[a] += along[a] / grid.spacing_mm[a];
                const std::optional<Vec3d> back = map.image_of(from);
                const double error = back ? norm(world_vector(grid, *back - y)) : 1;
                if (error < kBound_mm) {
                    made.inverse.vectors_mm[n] = v;
                    row_worst = std::max(row_worst, error);
                } else {
                    mask = TruthMask::Ambiguous;
                }
            }
            arrays.moving[n] = std::int16_t(mask);
        }
    });
    made.inverse_error_mm = *std::max_element(worst.begin(), worst.end());
}

bool TruthMaker::Impl::has_tissue_around(Vec3d x) const {
    for (int c = 0; c < 8; ++c) {
        Vec3i p;
        for (int a = 0; a < 3; ++a)
            p[a] = std::min(int(std::floor(x[a])) + (c >> a & 1), scan.grid.size[a] - 1);
        if (regions.labels[voxel_index(scan.grid, p)] == std::int16_t(TruthLabel::Air))
            return false;
    }
    return true;
}

void TruthMaker::Impl::choose_landmarks(const ExactMap& map, const Arrays& arrays,
                                        std::uint64_t seed, TruthCase& made) const {
    const Grid& grid = scan.grid;
    constexpr TruthLabel kTypes[] = {TruthLabel::Interior, TruthLabel::Wall, TruthLabel::Interface,
                                     TruthLabel::Cut};
    std::array<std::vector<std::uint32_t>, kTruthLabels> moved;
    for (std::size_t n = 0; n < arrays.labels.size(); ++n) {
        const Vec3f u = made.forward.vectors_mm[n];
        if (double(u.x) * u.x + double(u.y) * u.y + double(u.z) * u.z >=
                kTruthMovedMm * kTruthMovedMm &&
            arrays.fixed[n] == std::int16_t(TruthMask::Exact))
            moved[std::size_t(arrays.labels[n])].push_back(std::uint32_t(n));
    }
    int types = 0;
    for (const TruthLabel type : kTypes) types += !moved[std::size_t(type)].empty();
    if (types == 0) return;
    Draws draws(seed, kLandmarks);
    int left = settings.landmarks;
    for (const TruthLabel type : kTypes) {
        const auto& list = moved[std::size_t(type)];
        if (list.empty()) continue;
        const int count = left / types;
        left -= count;
        --types;
        for (int n = 0, tries = 0; n < count && tries < 50 * count; ++tries) {
            const std::uint32_t voxel = list[std::size_t(draws.below(list.size()))];
            const auto nx = std::uint32_t(grid.size.x), ny = std::uint32_t(grid.size.y);
            Vec3d x = real_of({int(voxel % nx), int(voxel / nx % ny), int(voxel / nx / ny)});
            for (int a = 0; a < 3; ++a) x[a] += draws.real(-0.5, 0.5);
            if (!is_inside(grid, x) || !has_tissue_around(x)) continue;
            const TruthLandmark landmark{world_from_voxel(grid, x), {0, 0, 0}, type};
            const auto moving = made.map->moving_from_fixed(landmark.fixed_mm);
            if (!moving) continue;
            Vec3d source{0, 0, 0};
            if (map.source_of(voxel_from_world(grid, *moving), x, source) != TruthMask::Exact)
                continue;
            const double error = norm(world_vector(grid, source - x));
            if (!(error < kBound_mm)) continue;
            made.landmark_error_mm = std::max(made.landmark_error_mm, error);
            made.landmarks.push_back({landmark.fixed_mm, *moving, type});
            ++n;
        }
    }
}

}  // namespace pliant
