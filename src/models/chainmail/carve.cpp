// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Carving: elements whose present position lies inside of the tool become void.
//
// A void element has no links and no position, so its displacement becomes zero: bricks without
// other elements can be dropped, and bounds stay tight. Undo restores it with its flags.

#include <algorithm>
#include <cmath>
#include <string>

#include "base/errors.h"
#include "base/stopwatch.h"
#include "chainmail/chainmail_impl.h"
#include "chainmail/cut.h"
#include "chainmail/operation.h"

namespace pliant {
namespace {

/// A capsule along the lattice's axes [fixed-point units].
struct Capsule {
    Vec3d from, along;
    double radius;

    bool holds(Position p) const {
        const Vec3d away{double(p.x) - from.x, double(p.y) - from.y, double(p.z) - from.z};
        const double length = dot(along, along);
        const double t = length > 0 ? std::clamp(dot(away, along) / length, 0.0, 1.0) : 0;
        const Vec3d apart = away - t * along;
        return dot(apart, apart) <= radius * radius;
    }
    PositionBox box() const {
        PositionBox box{};
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
        return about("carve", ErrorCode::InvalidArgument,
                     "expected positions within 100000 mm of the scan, found others");
    if (!(tool.radius_mm > 0 && tool.radius_mm <= kMaxMovementMm))
        return about(
            "carve", ErrorCode::InvalidArgument,
            "expected a radius above 0, up to 500 mm, found " + std::to_string(tool.radius_mm));
    return Capsule{kUnitsPerMm * from, kUnitsPerMm * along, kUnitsPerMm * tool.radius_mm};
}

/// Changes of a carving, complete before any of them is made.
struct Carving {
    EditMap edits;
    ImprintMap imprints;
    std::int64_t element_count = 0;
    bool in_tissue = false;  ///< of the scan
};

void carve_brick(const Lattice& lattice, Vec3i coord, const Capsule& tool, bool spare_fixed,
                 Carving& carving) {
    const BrickEdits* before = lattice.edits_of(coord);
    BrickEdits edits = before ? *before : BrickEdits(std::size_t(lattice.elements_per_brick()), 0);
    std::int64_t carved = 0;
    for (std::size_t n = 0; n < edits.size(); ++n) {
        const Vec3i e = lattice.element_of(coord, int(n));
        if (!tool.holds(
                moved_position(rest_position(lattice.grid(), e), lattice.displacement_at(e))))
            continue;
        const MaterialId material = lattice.material_at(e);
        if (material == kVoidMaterial) continue;
        if (spare_fixed && lattice.materials()[material].fixed) continue;
        edits[n] |= kVoid;
        ++carved;
        carving.in_tissue = carving.in_tissue || lattice.material_map().is_tissue(e);
    }
    carving.element_count += carved;
    if (carved > 0) carving.edits.emplace(coord, std::move(edits));
}

/// Removes the imprints of void elements.
void forget_void(const PlasticRest& rest, Carving& carving) {
    for (const auto& [coord, edits] : carving.edits) {
        const PlasticBrick* brick = rest.find(coord);
        if (!brick) continue;
        Imprint left = brick->imprint;
        for (auto& component : left)
            for (std::size_t n = 0; n < component.size(); ++n)
                if (edits[n] & kVoid) component[n] = 0;
        if (left != brick->imprint) carving.imprints[coord].imprint = std::move(left);
    }
}

/// Moves the void elements of a brick to their rest position. @pre the observer was told
void put_void_to_rest(Lattice& lattice, int index, const BrickEdits& edits) noexcept {
    Brick& brick = lattice.brick(index);
    for (std::size_t n = 0; n < edits.size(); ++n)
        if (edits[n] & kVoid)
            for (Fixed* u : brick.u) u[n] = 0;
    lattice.update_bounds(index);
}

}  // namespace

Result<CarveReport> ChainMail::Impl::carve(const CarveTool& tool) {
    const Stopwatch watch;
    const auto capsule = capsule_of(lattice.grid(), tool);
    if (!capsule.ok()) return capsule.error();
    const BrickSearch search(lattice);
    const std::int64_t max_elements = settings.max_elements;
    if (search.brick_count(capsule->box()) > max_elements / lattice.elements_per_brick() + 8)
        return about("carve", ErrorCode::LimitExceeded,
                     "the tool holds more than " + std::to_string(max_elements) +
                         " elements, expected a smaller one or a larger [lattice] max_elements");
    Operation step(*this, {.step = "carve", .ends_drag = true});
    Carving carving;
    search.for_each_brick(capsule->box(), [&](Vec3i coord, const PositionBox&) {
        carve_brick(lattice, coord, *capsule, tool.spare_fixed, carving);
    });
    if (!carving.in_tissue) return CarveReport{.carve_ms = watch.ms()};
    forget_void(plastic_rest, carving);
    for (const auto& [coord, edits] : carving.edits)
        if (const int index = lattice.find_brick(coord); index >= 0)
            lattice.before_move(lattice.brick(index));
    plastic_rest.prepare(lattice, carving.imprints);
    try {
        lattice.prepare_edits(carving.edits);
    } catch (...) {
        plastic_rest.finish(carving.imprints);
        throw;
    }
    // No allocations from here on.
    lattice.tick();
    for (const auto& [coord, edits] : carving.edits)
        if (const int index = lattice.find_brick(coord); index >= 0)
            put_void_to_rest(lattice, index, edits);
    lattice.exchange_edits(carving.edits);
    lattice.finish_edits(carving.edits);
    plastic_rest.exchange(lattice, carving.imprints);
    plastic_rest.finish(carving.imprints);
    lattice.drop_still_bricks();
    CarveReport report;
    report.carved_elements = carving.element_count;
    report.carve_ms = watch.ms();
    report.forgotten_steps = step.commit();
    return report;
}

Result<CarveReport> ChainMail::carve(const CarveTool& tool) {
    return attempt([&] { return m_impl->carve(tool); });
}

}  // namespace pliant
