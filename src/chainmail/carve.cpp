// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Carving: elements whose present place lies inside of the tool become void.
//
// A void element pulls nothing and is nowhere, so its displacement becomes zero: bricks that hold
// nothing else can go, and no bound is wider than what is there. Undo brings it back with its
// flags.

#include <algorithm>
#include <chrono>
#include <cmath>
#include <string>

#include "chainmail/chainmail_impl.h"
#include "chainmail/cut_search.h"

namespace pliant {
namespace {

/// A capsule along the lattice's axes [fixed-point units].
struct Capsule {
    Vec3d from, along;
    double radius;

    bool holds(Place p) const {
        const Vec3d away{double(p.x) - from.x, double(p.y) - from.y, double(p.z) - from.z};
        const double length = dot(along, along);
        const double t = length > 0 ? std::clamp(dot(away, along) / length, 0.0, 1.0) : 0;
        const Vec3d apart = away - t * along;
        return dot(apart, apart) <= radius * radius;
    }
    PlaceBox box() const {
        PlaceBox box{};
        for (int a = 0; a < 3; ++a) {
            const double low = from[a] + std::min(along[a], 0.0) - radius;
            const double high = from[a] + std::max(along[a], 0.0) + radius;
            box.low[a] = std::llround(std::floor(low));
            box.high[a] = std::llround(std::ceil(high));
        }
        return box;
    }
};

Result<Capsule> capsule_of(const Grid& grid, const CarveTool& tool) {
    const Vec3d from = lattice_from_world_vector(grid, tool.from_mm - grid.origin_mm);
    const Vec3d along = lattice_from_world_vector(grid, tool.to_mm - tool.from_mm);
    if (!(norm(from) <= 1e5 && norm(along) <= 1e5))
        return Error{ErrorCode::InvalidArgument,
                     "carve: expected places within 100000 mm of the scan, found others"};
    if (!(tool.radius_mm > 0 && tool.radius_mm <= kMaxMovementMm))
        return Error{ErrorCode::InvalidArgument,
                     "carve: expected a radius above 0, up to 500 mm, found " +
                         std::to_string(tool.radius_mm)};
    return Capsule{kUnitsPerMm * from, kUnitsPerMm * along, kUnitsPerMm * tool.radius_mm};
}

/// @returns how many elements of the brick became void
std::int64_t carve_brick(Lattice& lattice, Vec3i coord, const Capsule& tool, bool spare_fixed) {
    const BrickEdits* before = lattice.edits_of(coord);
    BrickEdits edits = before ? *before : BrickEdits(std::size_t(lattice.elements_per_brick()), 0);
    std::vector<std::size_t> carved;
    for (std::size_t n = 0; n < edits.size(); ++n) {
        const Vec3i e = lattice.element_of(coord, int(n));
        if (!tool.holds(moved_place(rest_place(lattice.grid(), e), lattice.displacement_at(e))))
            continue;
        const MaterialId material = lattice.material_at(e);
        if (material == kVoidMaterial) continue;
        if (spare_fixed && lattice.materials()[material].fixed) continue;
        edits[n] |= kVoid;
        carved.push_back(n);
    }
    if (carved.empty()) return 0;
    lattice.set_edits(coord, std::move(edits));
    if (const int index = lattice.find_brick(coord); index >= 0) {
        lattice.before_move(lattice.brick(index));
        for (const std::size_t n : carved)
            for (Fixed* u : lattice.brick(index).u) u[n] = 0;
        lattice.update_bounds(index);
    }
    return std::int64_t(carved.size());
}

}  // namespace

Result<CarveReport> ChainMail::carve(const CarveTool& tool) {
    const auto start = std::chrono::steady_clock::now();
    Lattice& lattice = m_impl->lattice;
    const auto capsule = capsule_of(lattice.grid(), tool);
    if (!capsule.ok()) return capsule.error();
    const BrickSearch search(lattice);
    const std::int64_t max_elements = m_impl->settings.max_elements;
    if (search.brick_count(capsule->box()) > max_elements / lattice.elements_per_brick() + 8)
        return Error{ErrorCode::LimitExceeded,
                     "carve: the tool holds more than " + std::to_string(max_elements) +
                         " elements, expected a smaller one or a larger [lattice] max_elements"};
    m_impl->let_go();
    m_impl->begin_step("carve");
    std::vector<Vec3i> coords;
    search.for_each_brick(capsule->box(),
                          [&](Vec3i coord, const PlaceBox&) { coords.push_back(coord); });
    CarveReport report;
    lattice.tick();
    for (const Vec3i& coord : coords)
        report.carved_elements += carve_brick(lattice, coord, *capsule, tool.spare_fixed);
    m_impl->plastic_rest.forget_void(lattice, coords);
    lattice.drop_still_bricks();
    const std::chrono::duration<double, std::milli> elapsed =
        std::chrono::steady_clock::now() - start;
    report.carve_ms = elapsed.count();
    report.forgotten_steps = m_impl->end_step();
    return report;
}

}  // namespace pliant
