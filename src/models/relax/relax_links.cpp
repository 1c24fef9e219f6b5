// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "relax/relax_links.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace pliant {
namespace {

constexpr double kUnitWeight = 64;  ///< for an element whose links may change by their own length
constexpr double kMaxWeight = 32767;

std::vector<HalfLimits> limits_of(const MaterialTable& materials) {
    std::vector<HalfLimits> limits;
    for (int id = 0; id < materials.size(); ++id) limits.push_back(materials[MaterialId(id)]);
    return limits;
}

}  // namespace

ElasticWeights::ElasticWeights(const MaterialTable& materials, Vec3d spacing_mm) {
    const double least = std::min({spacing_mm.x, spacing_mm.y, spacing_mm.z});
    for (int b = 0; b < 3; ++b) {
        auto& weights = m_weights[std::size_t(b)];
        weights.resize(std::size_t(materials.size()), 0);
        const double h = spacing_mm[b];
        for (std::size_t id = kVoidMaterial + 1; id < weights.size(); ++id) {
            const HalfLimits& half = materials[MaterialId(id)];
            const double room = (double(half.compress[b]) + half.stretch[b] + 4.0 * half.shear[b]) /
                                6 * 2 / kUnitsPerMm;
            const double weight = kUnitWeight * (least / h) * (least / h) / (room / h);
            weights[id] = std::uint16_t(std::lround(std::clamp(weight, 1.0, kMaxWeight)));
        }
    }
}

std::size_t BrickLinks::bytes() const {
    std::size_t bytes = fixed.size();
    for (const auto* arrays : {&shear, &stretch, &compress})
        for (const auto& array : *arrays) bytes += array.size() * sizeof(Fixed);
    for (const auto& array : weight) bytes += array.size() * sizeof(std::uint16_t);
    return bytes;
}

/// A brick and the adjacent layers of its six neighbours, in the order of Lattice::face.
struct BrickLinksMaker::Neighbourhood {
    const Brick* brick;
    std::array<std::vector<MaterialId>, 6> beside;
    std::array<std::vector<std::uint8_t>, 3> cut_below;  ///< empty: no edits there
    bool any_edits = false;
};

BrickLinksMaker::BrickLinksMaker(const Lattice& lattice)
    : BrickLinksMaker(lattice, limits_of(lattice.materials())) {}

BrickLinksMaker::BrickLinksMaker(const Lattice& lattice, std::vector<HalfLimits> limits)
    : m_lattice(lattice),
      m_limits(std::move(limits)),
      m_is_symmetric(lattice.materials().is_symmetric()),
      m_weights(lattice.materials(), lattice.grid().spacing_mm) {}

BrickLinksMaker::Neighbourhood BrickLinksMaker::look_around(const Brick& brick) const {
    Neighbourhood around{&brick, {}, {}, brick.edits != nullptr};
    for (int side = 0; side < 6; ++side) {
        const int b = side / 2;
        const bool high = side % 2;
        Vec3i coord = brick.coord;
        coord[b] += high ? 1 : -1;
        const int index = brick.neighbours[std::size_t(side)];
        const Brick* there = index < 0 ? nullptr : &m_lattice.brick(index);
        const BrickEdits* edits = m_lattice.edits_of(coord);
        around.any_edits |= edits != nullptr;
        for (const int n : m_lattice.face(b, !high)) {
            around.beside[std::size_t(side)].push_back(
                there ? there->material[n] : m_lattice.material_at(m_lattice.element_of(coord, n)));
            if (edits && !high)
                around.cut_below[std::size_t(b)].push_back((*edits)[std::size_t(n)] & (kCutX << b));
        }
    }
    return around;
}

bool BrickLinksMaker::is_uniform(const Neighbourhood& around) const {
    if (around.any_edits) return false;
    const MaterialId first = around.brick->material[0];
    const auto same = [&](MaterialId id) { return id == first; };
    const MaterialId* own = around.brick->material;
    if (!std::all_of(own, own + m_lattice.elements_per_brick(), same)) return false;
    return std::all_of(around.beside.begin(), around.beside.end(), [&](const auto& layer) {
        return std::all_of(layer.begin(), layer.end(), same);
    });
}

/// Calls visit(link, material below, material above, whether it is cut).
template <class Visit>
void BrickLinksMaker::for_each_link(const Neighbourhood& around, int b, const Visit& visit) const {
    const auto axis = std::size_t(b);
    const int size = m_lattice.brick_size(), stride = m_lattice.stride(b);
    const Vec3i strides = link_strides(size, b);
    const MaterialId* own = around.brick->material;
    const std::uint8_t* edits = around.brick->edits;
    const auto& cut_below = around.cut_below[axis];
    for (int f = 0; f < size * size; ++f) {
        const auto face_index = std::size_t(f);
        const int first = m_lattice.face(b, false)[face_index];
        const int first_link = f % size * strides[(b + 1) % 3] + f / size * strides[(b + 2) % 3];
        MaterialId low = around.beside[2 * axis][face_index];
        bool is_cut = !cut_below.empty() && cut_below[face_index] != 0;
        for (int layer = 0; layer <= size; ++layer) {
            const int n = first + layer * stride;
            const MaterialId high = layer < size ? own[n] : around.beside[2 * axis + 1][face_index];
            visit(std::size_t(first_link + layer * strides[b]), low, high, is_cut);
            low = high;
            is_cut = layer < size && edits && (edits[n] & (kCutX << b));
        }
    }
}

void BrickLinksMaker::fill_limits(const Neighbourhood& around, int b, BrickLinks& links) const {
    const auto axis = std::size_t(b);
    const int size = m_lattice.brick_size();
    const auto count = std::size_t((size + 1) * size * size);
    links.shear[axis].resize(count);
    if (!m_is_symmetric) links.stretch[axis].resize(count), links.compress[axis].resize(count);
    for_each_link(around, b, [&](std::size_t link, MaterialId low, MaterialId high, bool is_cut) {
        const HalfLimits &p = m_limits[low], &q = m_limits[high];
        links.shear[axis][link] = is_cut ? kUnlinked : p.shear[b] + q.shear[b];
        if (m_is_symmetric) return;
        links.stretch[axis][link] = is_cut ? kUnlinked : p.stretch[b] + q.stretch[b];
        links.compress[axis][link] = is_cut ? kUnlinked : p.compress[b] + q.compress[b];
    });
}

void BrickLinksMaker::fill_weights(const Neighbourhood& around, int b, BrickLinks& links) const {
    const auto axis = std::size_t(b);
    const int size = m_lattice.brick_size();
    links.weight[axis].resize(std::size_t((size + 1) * size * size));
    std::uint16_t* weights = links.weight[axis].data();
    for_each_link(around, b, [&](std::size_t link, MaterialId low, MaterialId high, bool is_cut) {
        const bool pulls = !is_cut && low != kVoidMaterial && high != kVoidMaterial;
        weights[link] = std::uint16_t(pulls ? m_weights(low, b) + m_weights(high, b) : 0);
    });
}

BrickLinks BrickLinksMaker::links_of(const Neighbourhood& around) const {
    BrickLinks links;
    for (int b = 0; b < 3; ++b) fill_limits(around, b, links), fill_weights(around, b, links);
    links.least_movement = INT32_MAX;
    for (int n = 0; n < m_lattice.elements_per_brick(); ++n) {
        const MaterialId id = around.brick->material[n];
        if (m_limits[id].fixed) {
            links.fixed.resize(std::size_t(m_lattice.elements_per_brick()), 0);
            links.fixed[std::size_t(n)] = 1;
        } else if (id != kVoidMaterial) {
            links.least_movement = std::min(links.least_movement, m_limits[id].max_movement);
        }
    }
    return links;
}

std::shared_ptr<const BrickLinks> BrickLinksMaker::make(const Brick& brick, bool with_limits) {
    const Neighbourhood around = look_around(brick);
    if (!is_uniform(around)) {
        if (with_limits) return std::make_shared<const BrickLinks>(links_of(around));
        const auto links = std::make_shared<BrickLinks>();
        for (int b = 0; b < 3; ++b) fill_weights(around, b, *links);
        return links;
    }
    const std::lock_guard lock(m_mutex);
    auto& shared = m_uniform[brick.material[0]];
    if (!shared) shared = std::make_shared<const BrickLinks>(links_of(around));
    return shared;
}

}  // namespace pliant
