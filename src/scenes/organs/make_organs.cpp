// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Meshes from files and labels. Meshes that are made have cells of one size, so that organs share
// the number of tetrahedra by their volumes.

#include <pliant/core/files.h>
#include <pliant/mesh_files.h>
#include <pliant/models/organs.h>
#include <pliant/models/vessel.h>
#include <pliant/scan_files.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "base/errors.h"
#include "base/hash.h"
#include "mesh/box_tree.h"
#include "organs/label_names.h"
#include "resample/filled_scan.h"

namespace pliant {
namespace {

// A scan of organs alone: soft tissue in air, so that their surface is at −500 HU, with some 100
// voxels along the longest side. The inside has a faint pattern that moves with the tissue.

constexpr double kTissueHu = 60, kPatternHu = 25;
constexpr double kNextHu = -20;  ///< from one organ to the next, so that sections tell them apart
constexpr double kMarginShare = 0.15;   ///< of the longest side
constexpr double kVoxelShare = 0.0128;  ///< likewise: some 100 voxels with the margins
constexpr double kPatternShare = 0.06;
constexpr double kRampVoxels = 1;  ///< on each side of a surface, from one value to the other
constexpr int kMaxVoxels = 256;

/// The largest of 1, 2 and 5 times a power of ten up to a length.
double round_down(double mm) {
    const double power = std::pow(10, std::floor(std::log10(mm)));
    return (mm >= 5 * power ? 5 : mm >= 2 * power ? 2 : 1) * power;
}

/// Triangle wave in −1…1; bit-identical on every machine, unlike a cosine.
double wave(double x) {
    return 4 * std::abs(x - std::floor(x) - 0.5) - 1;
}

struct Content {
    SurfaceDistance surface;
    double value_hu;
};

/// Voxels of a scan from signed distances to surfaces, those of organs and then of contents. A
/// surface that is far from a cube of voxels has one distance in all of it, the middle's:
///
///     ┌───────┬───┬───┐
///     │  far  ├───┼─┬─┤╮     8, 4, 2 and 1 voxels: cubes are halved while a surface is near
///     │       │   ├─┼─┤ ╲ surface
///     ├───────┼───┴─┴─┤
class Filler {
  public:
    Filler(const Grid& grid, std::span<const SurfaceDistance> organs,
           std::span<const Content> contents, double pattern_mm)
        : m_grid(grid), m_organs(organs), m_contents(contents), m_pattern(pattern_mm) {
        for (Level& level : m_levels) {
            level.mm.resize(organs.size() + contents.size());
            level.is_known.resize(level.mm.size());
        }
    }
    static constexpr int kCube = 8;

    /// @param first  of kCube voxels along each axis, or as many as the grid has
    void fill(Vec3i first, std::span<std::int16_t> values) {
        std::fill(m_levels.front().is_known.begin(), m_levels.front().is_known.end(), char(0));
        fill(0, first, kCube, values);
    }

  private:
    static constexpr std::size_t kLevels = 4;
    /// Distances at the middle of a cube.
    struct Level {
        std::vector<double> mm;
        std::vector<char> is_known;  ///< for all of the cube
    };

    void fill(std::size_t level, Vec3i first, int size, std::span<std::int16_t> values) {
        Level& here = m_levels[level];
        measure(here, middle_of(first, size));
        const double voxel = m_grid.spacing_mm.x;
        const double reach = (0.5 * std::sqrt(3.0) * (size - 1) + kRampVoxels) * voxel;
        for (std::size_t n = 0; n < here.mm.size(); ++n)
            here.is_known[n] = here.is_known[n] || std::abs(here.mm[n]) > reach;
        keep_clear(here, 0, m_organs.size());
        keep_clear(here, m_organs.size(), here.mm.size());
        const Vec3i size_of_grid = m_grid.size;
        const auto all_known = [&] {
            return std::find(here.is_known.begin(), here.is_known.end(), char(0)) ==
                   here.is_known.end();
        };
        if (size == 1 || all_known()) {
            for (int k = first.z; k < std::min(first.z + size, size_of_grid.z); ++k)
                for (int j = first.y; j < std::min(first.y + size, size_of_grid.y); ++j)
                    for (int i = first.x; i < std::min(first.x + size, size_of_grid.x); ++i)
                        values[voxel_index(m_grid, {i, j, k})] = value_at({i, j, k}, here.mm);
            return;
        }
        const int half = size / 2;
        for (int n = 0; n < 8; ++n) {
            const Vec3i part = first + half * Vec3i{n & 1, n >> 1 & 1, n >> 2};
            if (part.x >= size_of_grid.x || part.y >= size_of_grid.y || part.z >= size_of_grid.z)
                continue;
            m_levels[level + 1] = here;
            fill(level + 1, part, half, values);
        }
    }

    Vec3d middle_of(Vec3i first, int size) const {
        Vec3d ijk;
        for (int a = 0; a < 3; ++a) ijk[a] = first[a] + 0.5 * (size - 1);
        return world_from_voxel(m_grid, ijk);
    }

    void measure(Level& level, Vec3d p) const {
        for (std::size_t n = 0; n < level.mm.size(); ++n)
            if (!level.is_known[n])
                level.mm[n] = n < m_organs.size()
                                  ? m_organs[n].signed_mm(p)
                                  : m_contents[n - m_organs.size()].surface.signed_mm(p);
    }

    /// Where solids may overlap, the deepest one decides, so that all distances are needed.
    static void keep_clear(Level& level, std::size_t begin, std::size_t end) {
        int inside = 0;
        for (std::size_t n = begin; n < end; ++n) inside += !level.is_known[n] || level.mm[n] < 0;
        for (std::size_t n = begin; inside > 1 && n < end; ++n)
            level.is_known[n] = level.is_known[n] && level.mm[n] > 0;
    }

    std::int16_t value_at(Vec3i ijk, std::span<const double> mm) const {
        const Vec3d p = world_from_voxel(m_grid, {double(ijk.x), double(ijk.y), double(ijk.z)});
        const auto organs = mm.first(m_organs.size()), contents = mm.subspan(m_organs.size());
        const auto nearest = std::min_element(organs.begin(), organs.end());
        const double own =
            kTissueHu + kNextHu * double((nearest - organs.begin()) % 4) +
            kPatternHu * wave(p.x / m_pattern) * wave(p.y / m_pattern) * wave(p.z / m_pattern);
        double inside = own;
        if (!contents.empty()) {
            const auto content = std::min_element(contents.begin(), contents.end());
            const double part = share_of(*content);
            inside = part * m_contents[std::size_t(content - contents.begin())].value_hu +
                     (1 - part) * own;
        }
        const double share = share_of(*nearest);
        return std::int16_t(std::round(share * inside + (1 - share) * kAirHu));
    }

    /// Share of a solid in a voxel; its surface is smooth if it is spread over two voxels.
    double share_of(double distance_mm) const {
        return std::clamp(0.5 - distance_mm / (2 * kRampVoxels * m_grid.spacing_mm.x), 0.0, 1.0);
    }

    const Grid& m_grid;
    std::span<const SurfaceDistance> m_organs;
    std::span<const Content> m_contents;
    double m_pattern;
    std::array<Level, kLevels> m_levels;
};

Result<std::vector<Content>> read_contents(std::span<const OrganContents> contents,
                                           double unit_mm) {
    std::vector<Content> read;
    for (const OrganContents& c : contents) {
        auto surface = read_surface(c.surface, unit_mm);
        if (!surface) return surface.error();
        auto distance = SurfaceDistance::create(joined(*surface));
        if (!distance) return within(c.surface, distance.error());
        read.push_back({std::move(*distance), c.value_hu});
    }
    return read;
}

/// @param contents  closed surfaces inside the organs, drawn with values of their own
Result<Volume> scan_of_organs(std::span<const Organ> organs,
                              std::span<const OrganContents> contents, double unit_mm,
                              const TaskArena& arena) {
    std::vector<SurfaceDistance> surfaces;
    std::vector<Vec3d> nodes;
    for (const Organ& organ : organs) {
        auto surface = SurfaceDistance::create(boundary_triangles(organ.mesh));
        if (!surface) return within(organ.name, surface.error());
        surfaces.push_back(std::move(*surface));
        nodes.insert(nodes.end(), organ.mesh.nodes_mm.begin(), organ.mesh.nodes_mm.end());
    }
    const auto inner = read_contents(contents, unit_mm);
    if (!inner) return inner.error();
    Vec3d low = nodes.front(), high = low;
    for (const Vec3d& p : nodes)
        for (int a = 0; a < 3; ++a) {
            low[a] = std::min(low[a], p[a]);
            high[a] = std::max(high[a], p[a]);
        }
    const Vec3d span = high - low;
    const double longest = std::max({span.x, span.y, span.z});
    Volume volume;
    volume.grid =
        grid_around(nodes, kMarginShare * longest, round_down(kVoxelShare * longest), kMaxVoxels);
    VoxelArray<std::int16_t> values(voxel_count(volume.grid));
    Vec3i cubes;
    for (int a = 0; a < 3; ++a)
        cubes[a] = (volume.grid.size[a] + Filler::kCube - 1) / Filler::kCube;
    const std::span<std::int16_t> voxels(values.data(), voxel_count(volume.grid));
    arena.for_each(
        std::int64_t(cubes.x) * cubes.y * cubes.z, 1, [&](std::int64_t begin, std::int64_t end) {
            Filler filler(volume.grid, surfaces, *inner, round_down(kPatternShare * longest));
            for (std::int64_t c = begin; c < end; ++c)
                filler.fill(Filler::kCube * Vec3i{int(c % cubes.x), int(c / cubes.x % cubes.y),
                                                  int(c / cubes.x / cubes.y)},
                            voxels);
        });
    volume.voxels = std::move(values);
    return volume;
}

// Surroundings of the organs: fat, muscle and wall, without air. They hold the organs in place, and
// the organs slide on them.

constexpr double kAir_hu = -250;      ///< lower values are air
constexpr double kHuPerMm = 250;      ///< a step between air and tissue over some voxels
constexpr double kStuffedCells = 12;  ///< tetrahedra of the mesher's lattice in a cube

/// A body of tetrahedra that fills a box around the organs, without the organs and the air. Its
/// nodes on the box's faces are held.
/// @param tetrahedra  approximate number
Result<Organ> make_surroundings(std::span<const Organ> organs, const Volume& scan,
                                double thickness_mm, std::int64_t tetrahedra,
                                const TaskArena& arena) {
    std::vector<SurfaceDistance> surfaces;
    std::vector<mesh::Bounds> bounds;
    mesh::Bounds box, whole;
    for (const Organ& organ : organs) {
        auto surface = SurfaceDistance::create(boundary_triangles(organ.mesh));
        if (!surface) return within(organ.name, surface.error());
        surfaces.push_back(std::move(*surface));
        bounds.emplace_back();
        for (const Vec3d& p : organ.mesh.nodes_mm) bounds.back().add(p);
        box.add(bounds.back());
    }
    // The scan's box along the world's axes; an oblique scan ends before its corners.
    const Vec3i size = scan.grid.size;
    for (int c = 0; c < 8; ++c)
        whole.add(world_from_voxel(
            scan.grid,
            {c & 1 ? size.x - 1.0 : 0.0, c & 2 ? size.y - 1.0 : 0.0, c & 4 ? size.z - 1.0 : 0.0}));
    Vec3d low, high;
    double volume = 1;
    for (int a = 0; a < 3; ++a) {
        low[a] = std::max(box.low[a] - thickness_mm, whole.low[a]);
        high[a] = std::min(box.high[a] + thickness_mm, whole.high[a]);
        volume *= high[a] - low[a];
    }
    const double cell = std::cbrt(kStuffedCells * volume / double(tetrahedra));
    const auto level = [&](Vec3d x) {
        double inside = kHuPerMm * 1e3;
        for (int a = 0; a < 3; ++a) inside = std::min({inside, x[a] - low[a], high[a] - x[a]});
        const Vec3d ijk = voxel_from_world(scan.grid, x);
        inside = std::min(inside, (double(sample_linear(scan, ijk)) - kAir_hu) / kHuPerMm);
        for (std::size_t n = 0; n < surfaces.size(); ++n)
            if (inside > 0 && bounds[n].distance_squared(x) < inside * inside)
                inside = std::min(inside, surfaces[n].signed_mm(x));
        return inside;
    };
    const double margin = 0.01 * cell;
    auto mesh = stuff_isosurface(level,
                                 {.begin_mm = low - Vec3d{margin, margin, margin},
                                  .end_mm = high + Vec3d{margin, margin, margin},
                                  .cell_mm = cell},
                                 arena);
    if (!mesh) return within("surroundings", mesh.error());
    (void)make_manifold(*mesh);
    (void)drop_crumbs(*mesh);
    Organ around{.name = "surroundings", .mesh = std::move(*mesh)};
    around.settings.name = around.name;
    for (int a = 0; a < 3; ++a)
        for (const double face : {low[a], high[a]}) {
            Vec3d one = low - Vec3d{margin, margin, margin},
                  other = high + Vec3d{margin, margin, margin};
            one[a] = face - margin;
            other[a] = face + margin;
            around.settings.held_mm.insert(around.settings.held_mm.end(), {one, other});
        }
    return around;
}

constexpr double kCellsPerCube = 12;        ///< tetrahedra of the mesher's lattice in a cube
constexpr double kSurroundingsShare = 0.5;  ///< of the tetrahedra
constexpr double kLeastCells = 400;         ///< of an organ

/// A body before its mesh is made: tetrahedra, or the closed surface that they will fill.
struct Source {
    std::optional<TetMesh> tetrahedra;
    TriangleMesh surface;
    double volume_mm3 = 0;  ///< of the surface
};

/// @param[out] notes  grows by remarks on the file
Result<Source> source_of_file(const std::string& file, double unit_mm,
                              std::vector<std::string>& notes) {
    const auto mesh = read_mesh(file, unit_mm);
    if (!mesh) return mesh.error();
    Source source;
    std::vector<std::string> remarks = mesh->notes;
    if (mesh->tetrahedra.empty())
        source.surface = cleaned({mesh->nodes_mm, mesh->triangles}, &remarks);
    for (const std::string& remark : remarks) notes.push_back(file + ": " + remark);
    if (!mesh->tetrahedra.empty()) {
        source.tetrahedra = with_used_nodes({mesh->nodes_mm, mesh->tetrahedra});
        if (const Status s = check_quality(tet_quality(*source.tetrahedra)); !s.ok())
            return within(file, s.error());
        return source;
    }
    if (mesh->triangles.empty())
        return within(file, {ErrorCode::Unsupported,
                             "found neither tetrahedra nor triangles, expected an organ"});
    if (const Status s = check_closed(source.surface); !s.ok()) return within(file, s.error());
    source.volume_mm3 = std::abs(enclosed_volume_mm3(source.surface));
    return source;
}

/// Whole numbers above 0 in a label map.
std::set<int> labels_in(const Volume& map) {
    std::set<int> found;
    int last = 0;
    std::visit(
        [&](const auto& voxels) {
            for (const auto voxel : voxels) {
                const double value = double(voxel);
                if (!(value >= 1 && value < INT32_MAX) || int(value) == last) continue;
                last = int(value);
                found.insert(last);
            }
        },
        map.voxels);
    return found;
}

/// The numbers in ascending order, with ranges: "1 to 5, 7".
std::string ranges_of(const std::set<int>& numbers) {
    std::string text;
    for (auto at = numbers.begin(); at != numbers.end();) {
        const int first = *at;
        int last = first;
        while (++at != numbers.end() && *at == last + 1) last = *at;
        text += (text.empty() ? "" : ", ") + std::to_string(first);
        if (last > first) text += " to " + std::to_string(last);
    }
    return text.empty() ? "none" : text;
}

/// Whether the map has the labels of all bodies.
Status check_bodies(const OrganFile& file, const Volume& map) {
    const std::set<int> there = labels_in(map);
    for (const OrganSettings& body : file.bodies)
        for (const int label : body.labels)
            if (there.count(label) == 0)
                return within(
                    file.label_volume,
                    expected_error("labels", "labels of this map (" + ranges_of(there) + ")",
                                   std::to_string(label)));
    return Ok{};
}

/// Names the bodies that have no name after their label.
Status name_bodies(OrganFile& file, const Volume& map) {
    const auto names =
        find_label_names(label_file(file.label_volume), map.key_values, file.label_names);
    if (!names) return about("label_names", names.error().code, names.error().message);
    for (OrganSettings& body : file.bodies) {
        if (!body.name.empty() || body.labels.empty()) continue;
        const int label = body.labels.front();
        const auto named = names->find(label);
        body.name = named == names->end() ? "label " + std::to_string(label) : named->second;
    }
    return Ok{};
}

Result<Source> source_of_labels(const OrganFile& file, const OrganSettings& settings,
                                const Volume& labels, const TaskArena& arena) {
    auto found = lumen_of_labels(labels, settings.labels, file.smoothing_voxels, arena);
    if (!found) return within(settings.name, found.error());
    Source source;
    source.surface = std::move(found->surface);
    source.volume_mm3 = std::abs(enclosed_volume_mm3(source.surface));
    return source;
}

std::uint64_t hash_of(const MadeOrgans& made) {
    const OrganFile& f = made.file;
    Hash64 hash;
    const auto add = [&](double number) { hash.add_word(std::bit_cast<std::uint64_t>(number)); };
    for (const double number : {f.fixed_hu, f.fixed_near_mm, f.friction, f.damping_per_s,
                                f.time_step_s, double(f.sub_steps), f.reach_mm, f.surroundings_pa})
        add(number);
    for (const Organ& organ : made.organs) {
        const OrganSettings& s = organ.settings;
        hash.add(std::span<const Vec3d>(organ.mesh.nodes_mm));
        hash.add(std::span<const std::array<std::int32_t, 4>>(organ.mesh.cells));
        for (const double number :
             {double(s.law), s.young_modulus_pa, s.poisson_ratio, s.density_kg_m3, s.held_back})
            add(number);
        if (s.law == BodyLaw::Ogden) add(s.ogden_alpha);
        hash.add(std::span<const Vec3d>(s.held_mm));
        for (const int label : s.labels) add(label);
    }
    return hash.value();
}

Result<MadeOrgans> make(const OrganFile& given, const TaskArena& arena) {
    MadeOrgans made{.file = given};
    OrganFile& file = made.file;
    if (!file.scan.empty()) {
        auto scan = read_volume(file.scan, file.reading, &made.notes);
        if (!scan) return scan.error();
        made.scan = std::move(*scan);
    }
    if (!file.label_volume.empty()) {
        auto labels = read_labels(file.label_volume);
        if (!labels) return about("label_volume", labels.error().code, labels.error().message);
        made.labels = std::make_shared<const Volume>(std::move(*labels));
        if (const Status s = check_bodies(file, *made.labels); !s.ok()) return s.error();
        if (const Status s = name_bodies(file, *made.labels); !s.ok()) return s.error();
    }
    std::vector<Source> sources;
    double volume = 0;
    for (const OrganSettings& body : file.bodies) {
        auto source = body.mesh.empty()
                          ? source_of_labels(file, body, *made.labels, arena)
                          : source_of_file(body.mesh, mm_of_unit(file.units), made.notes.notes);
        if (!source) return source.error();
        volume += source->volume_mm3;
        sources.push_back(std::move(*source));
    }
    const double count = double(file.tetrahedra) * (file.surroundings ? 1 - kSurroundingsShare : 1);
    const double cell = std::cbrt(kCellsPerCube * volume / count);
    for (std::size_t n = 0; n < sources.size(); ++n) {
        Organ organ{.name = file.bodies[n].name, .settings = file.bodies[n]};
        if (sources[n].tetrahedra) {
            organ.mesh = std::move(*sources[n].tetrahedra);
        } else {
            const double own = std::cbrt(kCellsPerCube * sources[n].volume_mm3 / kLeastCells);
            auto filled = fill_surface(std::move(sources[n].surface),
                                       {.cell_mm = std::min(cell, own)}, arena);
            if (!filled)
                return within(organ.settings.mesh.empty() ? organ.name : organ.settings.mesh,
                              filled.error());
            organ.mesh = std::move(filled->mesh);
        }
        made.organs.push_back(std::move(organ));
    }
    if (file.surroundings) {
        auto around =
            make_surroundings(made.organs, made.scan, file.surroundings_mm,
                              std::int64_t(kSurroundingsShare * double(file.tetrahedra)), arena);
        if (!around) return around.error();
        around->settings.young_modulus_pa = file.surroundings_pa;
        made.organs.push_back(std::move(*around));
    }
    if (file.scan.empty()) {
        auto scan = scan_of_organs(made.organs, file.contents, mm_of_unit(file.units), arena);
        if (!scan) return within(file.file, scan.error());
        made.scan = std::move(*scan);
    }
    made.hash = hash_of(made);
    return made;
}

}  // namespace

Result<MadeOrgans> make_organs(const OrganFile& file, const TaskArena& arena) noexcept {
    return attempt([&] {
        Result<MadeOrgans> made = make(file, arena);
        return made.ok() ? std::move(made) : in_one_line(made.error());
    });
}

}  // namespace pliant
