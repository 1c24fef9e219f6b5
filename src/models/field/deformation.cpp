// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include <pliant/deformation.h>
#include <pliant/result.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "base/errors.h"
#include "base/text.h"
#include "field/field_state.h"
#include "field/writable_field.h"
#include "volume/boxes.h"

namespace pliant {
namespace {

std::size_t element_count(const Box3i& box) {
    return is_empty(box) ? 0 : dense_count(box.end - box.begin);
}

Error wrong_count(const Box3i& box, std::size_t found, const char* of) {
    return Error{ErrorCode::InvalidArgument, "deformation: expected " + std::string(of) + " of " +
                                                 std::to_string(element_count(box)) +
                                                 " elements, found " + std::to_string(found)};
}

/// Calls visit(coord, part) for each brick that a box cuts, with the elements in both.
template <class Visit>
void for_each_brick_of(const Field& field, const Box3i& box, const Visit& visit) {
    if (is_empty(box)) return;
    const int size = field.brick_size();
    const Vec3i first = field.brick_of(box.begin), last = field.brick_of(box.end - Vec3i{1, 1, 1});
    for (int z = first.z; z <= last.z; ++z)
        for (int y = first.y; y <= last.y; ++y)
            for (int x = first.x; x <= last.x; ++x) {
                const Vec3i coord{x, y, z};
                const Vec3i corner = size * coord;
                visit(coord, overlap(box, {corner, corner + Vec3i{size, size, size}}));
            }
}

/// Calls visit(ijk, n) for each element of a part of a box, with its index in the box.
template <class Visit>
void for_each_element(const Box3i& part, const Box3i& box, const Visit& visit) {
    const Vec3i size = box.end - box.begin;
    for (int z = part.begin.z; z < part.end.z; ++z)
        for (int y = part.begin.y; y < part.end.y; ++y) {
            const Vec3i row = Vec3i{part.begin.x, y, z} - box.begin;
            std::size_t n = std::size_t(row.x) +
                            std::size_t(size.x) *
                                (std::size_t(row.y) + std::size_t(size.y) * std::size_t(row.z));
            for (int x = part.begin.x; x < part.end.x; ++x, ++n) visit(Vec3i{x, y, z}, n);
        }
}

Status check_displacements(std::span<const Vec3d> displacements_mm) {
    for (const Vec3d& u : displacements_mm)
        for (int a = 0; a < 3; ++a)
            if (!(std::abs(u[a]) <= kMaxMovementMm))
                return Error{ErrorCode::InvalidArgument,
                             "deformation: expected displacements of up to " +
                                 std::to_string(int(kMaxMovementMm)) + " mm along an axis, found " +
                                 text_of(u)};
    return Ok{};
}

void write_displacements(WritableField& field, const Box3i& box, std::span<const Vec3d> u_mm) {
    const Mat3d axes = inverse(field.grid().direction);
    std::vector<std::pair<int, Box3i>> parts;
    std::vector<int> bricks;
    const std::uint64_t made = field.made_count();
    try {
        for_each_brick_of(field, box, [&](Vec3i coord, const Box3i& part) {
            parts.emplace_back(field.ensure_brick(coord), part);
        });
        for (const auto& [index, part] : parts) bricks.push_back(index);
    } catch (...) {
        field.drop_made_since(made);
        throw;
    }
    const std::uint64_t now = field.tick();
    for (const auto& [index, part] : parts) {
        FieldBrick& brick = field.brick(index);
        if (brick.is_unplaced) field.place_at_rest(brick);
        for_each_element(part, box, [&](Vec3i ijk, std::size_t n) {
            const Vec3d along = axes * u_mm[n];
            const auto e = std::size_t(field.index_in_brick(ijk, brick.coord));
            for (int a = 0; a < 3; ++a) brick.u[std::size_t(a)][e] = units_from_mm(along[a]);
        });
        field.written(brick, now);
    }
    field.drop_still_bricks(bricks);
}

void replace_edits(WritableField& field, const Box3i& box, std::span<const std::uint8_t> flags) {
    EditMap edits;
    for_each_brick_of(field, box, [&](Vec3i coord, const Box3i& part) {
        const BrickEdits* before = field.edits_of(coord);
        BrickEdits own = before ? *before : BrickEdits(std::size_t(field.elements_per_brick()));
        for_each_element(part, box, [&](Vec3i ijk, std::size_t n) {
            own[std::size_t(field.index_in_brick(ijk, coord))] = flags[n];
        });
        if (before ? own != *before
                   : std::any_of(own.begin(), own.end(), [](auto f) { return f != 0; }))
            edits.emplace(coord, std::move(own));
    });
    field.prepare_edits(edits);
    field.exchange_edits(edits);
    field.finish_edits(edits);
}

}  // namespace

Result<Deformation> Deformation::create(const Grid& grid) noexcept {
    return attempt([&]() -> Result<Deformation> {
        for (int a = 0; a < 3; ++a)
            if (grid.size[a] < 1)
                return Error{
                    ErrorCode::InvalidArgument,
                    "deformation: expected a grid of at least one voxel along each axis, found " +
                        std::to_string(grid.size[a])};
        return Deformation(std::make_unique<WritableField>(grid));
    });
}

Deformation::Deformation(const Field& field) noexcept : m_field(&field) {}
Deformation::Deformation(std::unique_ptr<WritableField> own) noexcept
    : m_own(std::move(own)), m_field(m_own.get()) {}
Deformation::~Deformation() = default;
Deformation::Deformation(Deformation&&) noexcept = default;
Deformation& Deformation::operator=(Deformation&&) noexcept = default;

const Grid& Deformation::grid() const {
    return m_field->grid();
}

Vec3d Deformation::displacement_mm(Vec3i ijk) const {
    const Vec3<Fixed> u = m_field->displacement_at(ijk);
    return world_from_lattice_vector(grid(),
                                     {mm_from_units(u.x), mm_from_units(u.y), mm_from_units(u.z)});
}

bool Deformation::is_void(Vec3i ijk) const {
    return m_field->is_void(ijk);
}

bool Deformation::is_linked(Vec3i ijk, int axis) const {
    return m_field->is_linked(ijk, axis);
}

Box3i Deformation::moved_box() const {
    return pliant::moved_box(*m_field);
}

std::uint64_t Deformation::version() const {
    return m_field->clock() + m_field->links_version();
}

std::uint64_t Deformation::hash() const {
    return hash_state(*m_field);
}

Status Deformation::write(const Box3i& elements, std::span<const Vec3d> displacements_mm) noexcept {
    PLIANT_ASSERT(m_own);
    return attempt([&]() -> Status {
        if (displacements_mm.size() != element_count(elements))
            return wrong_count(elements, displacements_mm.size(), "displacements");
        if (const Status s = check_displacements(displacements_mm); !s.ok()) return s;
        write_displacements(*m_own, elements, displacements_mm);
        return Ok{};
    });
}

Status Deformation::edit(const Box3i& elements, std::span<const std::uint8_t> edits) noexcept {
    PLIANT_ASSERT(m_own);
    return attempt([&]() -> Status {
        if (edits.size() != element_count(elements))
            return wrong_count(elements, edits.size(), "edits");
        replace_edits(*m_own, elements, edits);
        return Ok{};
    });
}

void Deformation::reset() noexcept {
    PLIANT_ASSERT(m_own);
    m_own->tick();
    m_own->drop_all_bricks();
    m_own->drop_all_edits();
}

Result<DeformationState> state_of(const MovingScan& scan) noexcept {
    return attempt([&]() -> Result<DeformationState> {
        if (const Status s = scan.update_deformation(); !s.ok()) return s.error();
        return state_of_field(scan.deformation().field(), scan.arena());
    });
}

}  // namespace pliant
