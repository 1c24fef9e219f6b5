// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Construction of the wall, the path through its lumen, and the guide's end from a scene file.

#include <pliant/mesh_files.h>
#include <pliant/models/catheter.h>
#include <pliant/models/scene_files.h>
#include <pliant/render.h>
#include <pliant/scan_files.h>

#include <algorithm>

#include "base/errors.h"
#include "base/text.h"
#include "mesh/box_tree.h"

namespace pliant {
namespace {

/// The way along the first branch to the start of another, and along that.
std::vector<Vec3d> way_into(const Centreline& tree, std::size_t branch) {
    std::vector<Vec3d> way;
    const Vec3d start = tree.branches[branch].front().position_mm;
    const auto& trunk = tree.branches.front();
    const auto nearest =
        std::min_element(trunk.begin(), trunk.end(), [&](const auto& p, const auto& q) {
            return norm(p.position_mm - start) < norm(q.position_mm - start);
        });
    for (auto p = trunk.begin(); p != nearest; ++p) way.push_back(p->position_mm);
    for (const CentrePoint& p : tree.branches[branch]) way.push_back(p.position_mm);
    return way;
}

/// Sweeps a tube; a tree has no sweep.
Result<VesselWall> wall_of_phantom(const VesselFile& v, std::vector<Vec3d>& way,
                                   const TaskArena& arena) {
    constexpr std::size_t kCarotid = 2;
    const auto tree = phantom_centreline(v.phantom);
    if (!tree) return tree.error();
    const bool is_tube = tree->branches.size() == 1;
    if (way.empty() && is_tube)
        for (const CentrePoint& p : tree->branches[0]) way.push_back(p.position_mm);
    else if (way.empty())
        way = way_into(*tree, kCarotid);
    if (!is_tube) return wall_around_centreline(*tree, v.wall, arena);
    return swept_tube(tree->branches[0],
                      {.thickness_mm = v.wall.thickness_mm, .layers = v.wall.layers});
}

Error named(const std::string& file, const Error& error) {
    return {error.code, file + ": " + error.message};
}

Result<std::vector<Vec3d>> way_from_file(const VesselFile& v) {
    const auto mesh = read_mesh(v.way_file);
    if (!mesh) return mesh.error();
    if (std::size_t(v.way_branch) > mesh->lines.size())
        return Error{ErrorCode::InvalidArgument,
                     v.way_file + ": has " + std::to_string(mesh->lines.size()) +
                         " lines, expected one of [way] branch " + std::to_string(v.way_branch)};
    std::vector<Vec3d> way;
    for (const std::int32_t n : mesh->lines[std::size_t(v.way_branch) - 1])
        way.push_back(mesh->nodes_mm[std::size_t(n)]);
    if (v.way_reverse) std::reverse(way.begin(), way.end());
    return way;
}

/// Whether a catheter may lie in a file's vessel: one in metres is smaller than any catheter.
Status check_size(std::span<const Vec3d> nodes_mm) {
    constexpr double kShortest_mm = 10;  // [catheter] length_mm
    mesh::Bounds box;
    for (const Vec3d& p : nodes_mm) box.add(p);
    const double across = nodes_mm.empty() ? kShortest_mm : norm(box.high - box.low);
    if (across >= kShortest_mm) return Ok{};
    return invalid("it is " + short_text(across) + " mm across, expected " +
                   short_text(kShortest_mm) +
                   " or more, the length of the shortest catheter; lengths are in millimetres: "
                   "multiply metres by 1000");
}

Result<VesselWall> wall_of_given_mesh(const VesselFile& v, const TaskArena& arena) {
    auto mesh = read_tetrahedra(v.mesh);
    if (!mesh) return named(v.file + ": [vessel] mesh", mesh.error());
    if (const Status s = check_size(mesh->nodes_mm); !s)
        return named(v.file + ": [vessel] mesh: " + v.mesh, s.error());
    TriangleMesh lumen;
    if (!v.ghost.empty()) {
        auto ghost = read_surface(v.ghost);
        if (!ghost) return named(v.file + ": [vessel] ghost", ghost.error());
        lumen = std::move(*ghost);
    }
    auto wall = wall_of_mesh(std::move(*mesh), std::move(lumen), arena);
    if (!wall) return named(v.file + ": [vessel] mesh: " + v.mesh, wall.error());
    return wall;
}

Result<VesselWall> wall_of_surface(const VesselFile& v, const TaskArena& arena) {
    const auto surface = read_surface(v.surface);
    if (!surface) return surface.error();
    if (const Status s = check_size(surface->nodes_mm); !s) return named(v.surface, s.error());
    std::vector<VesselEnd> ends;
    if (!v.ends.empty()) {
        const auto mesh = read_mesh(v.ends);
        if (!mesh) return mesh.error();
        const auto centreline = centreline_of(*mesh);
        if (!centreline) return named(v.ends, centreline.error());
        ends = ends_of(*centreline, v.trim);
    }
    auto wall = wall_around_surface(*surface, ends, v.wall, arena);
    if (!wall) return named(v.surface, wall.error());
    return wall;
}

Result<VesselWall> wall_of_volume(const VesselFile& v, const Volume& volume,
                                  std::span<const Vec3d> way, const TaskArena& arena) {
    const auto lumen = v.scan.empty() ? lumen_of_labels(volume, v.labels, v.smoothing_voxels, arena)
                                      : lumen_of_region(volume,
                                                        {.seed_mm = way.front(),
                                                         .low = v.low_hu,
                                                         .high = v.high_hu,
                                                         .smoothing_voxels = v.smoothing_voxels,
                                                         .way_mm = {way.begin(), way.end()},
                                                         .within_mm = v.within_mm},
                                                        arena);
    const std::string& file = v.scan.empty() ? v.labels_file : v.scan;
    if (!lumen) return named(file, lumen.error());
    auto wall = wall_around_surface(lumen->surface, lumen->ends, v.wall, arena);
    if (!wall) return named(file, wall.error());
    return wall;
}

Result<CatheterSettings> settings_with_entry(const VesselFile& v, const VesselWall& wall) {
    CatheterSettings settings = v.settings;
    if (v.entry_given) return settings;
    if (std::size_t(v.entry_end) > wall.ends.size())
        return Error{ErrorCode::InvalidArgument,
                     v.file + ": [entry] end: expected one of the vessel's " +
                         std::to_string(wall.ends.size()) + " open ends, found " +
                         std::to_string(v.entry_end)};
    settings.entry = entry_at(wall.ends[std::size_t(v.entry_end) - 1], v.entry_inwards);
    settings.entry.inserted_mm = v.settings.entry.inserted_mm;
    return settings;
}

bool wants_way(const VesselAct& act) {
    return act.follow || act.until_way_mm.has_value();
}

/// Finds the path from the entry to the farthest end in a synthetic scan of the wall. Without a
/// path: empty, or an error if an act needs one.
Result<std::vector<Vec3d>> way_through(const VesselFile& v, const MadeVessel& made,
                                       const TaskArena& arena) {
    const bool is_wanted = std::any_of(v.acts.begin(), v.acts.end(), wants_way);
    if (made.wall.ends.size() < 2) {
        if (!is_wanted) return std::vector<Vec3d>{};
        return expected_error(v.file + ": [way] points_mm", "a way in a vessel with one open end",
                              "none");
    }
    const Vec3d from = made.settings.entry.position_mm;
    const auto distance = [&](const VesselEnd& end) { return norm(end.centre_mm - from); };
    const auto& ends = made.wall.ends;
    const auto far = std::max_element(
        ends.begin(), ends.end(),
        [&](const VesselEnd& a, const VesselEnd& b) { return distance(a) < distance(b); });
    auto scan = scan_of_vessel(made.wall, arena);
    if (!scan) return scan.error();
    const auto path = find_lumen_path(
        *scan, from, entry_at(*far).position_mm,
        {.iso_hu = 200, .polarity = Polarity::Falling, .reach_mm = far->radius_mm}, arena);
    if (path) return path->points_mm;
    if (!is_wanted) return std::vector<Vec3d>{};
    if (path.error().message.starts_with("from"))
        return invalid(v.file +
                       ": [entry] place_mm: expected a position in the vessel's lumen, found " +
                       text_of(from) + " outside of it");
    return named(v.file + ": [way] points_mm: none is found from the entry to end " +
                     std::to_string(far - ends.begin() + 1),
                 path.error());
}

Result<MadeVessel> make_all_of(const VesselFile& v, const TaskArena& arena) {
    MadeVessel made;
    if (!v.way_file.empty()) {
        auto way = way_from_file(v);
        if (!way) return way.error();
        made.way = std::move(*way);
    } else {
        made.way = v.way_mm;
    }
    Result<VesselWall> wall = Error{ErrorCode::InvalidArgument, ""};
    if (!v.phantom.empty()) {
        wall = wall_of_phantom(v, made.way, arena);
    } else if (!v.mesh.empty()) {
        wall = wall_of_given_mesh(v, arena);
        made.has_own_ghost = !v.ghost.empty();
    } else if (!v.centreline.empty()) {
        const auto mesh = read_mesh(v.centreline);
        if (!mesh) return mesh.error();
        if (const Status s = check_size(mesh->nodes_mm); !s) return named(v.centreline, s.error());
        const auto centreline = centreline_of(*mesh);
        if (!centreline) return named(v.centreline, centreline.error());
        wall = wall_around_centreline(*centreline, v.wall, arena);
        if (!wall) return named(v.centreline, wall.error());
    } else if (!v.surface.empty()) {
        wall = wall_of_surface(v, arena);
    } else {
        auto volume = read_volume(v.scan.empty() ? v.labels_file : v.scan);
        if (!volume) return volume.error();
        if (made.way.size() == 2) {  // in the label volume: values of 1 and more
            const bool labels = v.scan.empty();
            auto way = find_lumen_path(
                *volume, made.way[0], made.way[1],
                {.iso_hu = labels ? 0.5 : v.low_hu, .polarity = Polarity::Falling, .reach_mm = 6},
                arena);
            if (!way) return named("[way] points_mm", way.error());
            made.way = std::move(way->points_mm);
        }
        wall = wall_of_volume(v, *volume, made.way, arena);
        if (!v.scan.empty()) made.scan = std::move(*volume);
    }
    if (!wall) return wall.error();
    made.wall = std::move(*wall);
    const TetQuality quality = tet_quality(made.wall.mesh);
    if (const Status s = check_quality(quality); !s) return named("[vessel]", s.error());
    auto settings = settings_with_entry(v, made.wall);
    if (!settings) return settings.error();
    made.settings = *settings;
    if (!v.mesh.empty() && made.way.empty()) {
        auto way = way_through(v, made, arena);
        if (!way) return way.error();
        made.way = std::move(*way);
    }
    return made;
}

}  // namespace

Result<MadeVessel> make_vessel(const VesselFile& file, const TaskArena& arena) noexcept {
    return attempt([&] { return make_all_of(file, arena); });
}

}  // namespace pliant
