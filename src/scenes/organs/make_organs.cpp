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
#include "organs/label_names.h"
#include "organs/organ_scan.h"
#include "organs/surroundings.h"

namespace pliant {
namespace {

constexpr double kCellsPerCube = 12;        ///< tetrahedra of the mesher's lattice in a cube
constexpr double kSurroundingsShare = 0.5;  ///< of the tetrahedra
constexpr double kLeastCells = 400;         ///< of an organ

/// A body before its mesh is made: tetrahedra, or the closed surface that they will fill.
struct Source {
    std::optional<TetMesh> tetrahedra;
    TriangleMesh surface;
    double volume_mm3 = 0;  ///< of the surface
};

Result<Source> source_of_file(const std::string& file) {
    const auto mesh = read_mesh(file);
    if (!mesh) return mesh.error();
    Source source;
    if (!mesh->tetrahedra.empty()) {
        source.tetrahedra = with_used_nodes({mesh->nodes_mm, mesh->tetrahedra});
        if (const Status s = check_quality(tet_quality(*source.tetrahedra)); !s.ok())
            return within(file, s.error());
        return source;
    }
    if (mesh->triangles.empty())
        return within(file, {ErrorCode::Unsupported,
                             "found neither tetrahedra nor triangles, expected an organ"});
    source.surface = joined({mesh->nodes_mm, mesh->triangles});
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
    const auto names = find_label_names(file.label_volume, map.key_values, file.label_names);
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
        auto labels = read_volume(file.label_volume);
        if (!labels) return about("label_volume", labels.error().code, labels.error().message);
        made.labels = std::make_shared<const Volume>(std::move(*labels));
        if (const Status s = check_bodies(file, *made.labels); !s.ok()) return s.error();
        if (const Status s = name_bodies(file, *made.labels); !s.ok()) return s.error();
    }
    std::vector<Source> sources;
    double volume = 0;
    for (const OrganSettings& body : file.bodies) {
        auto source = body.mesh.empty() ? source_of_labels(file, body, *made.labels, arena)
                                        : source_of_file(body.mesh);
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
        auto scan = scan_of_organs(made.organs, file.contents, arena);
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
