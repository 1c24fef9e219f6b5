// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "elastic/stiffness_map.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace pliant {
namespace {

constexpr std::int64_t kLastNodes = 400;  ///< a level of this size is the coarsest
constexpr double kLargestAspect = 1.5;    ///< edges up to this multiple of the shortest are doubled
constexpr float kJump = 2000;             ///< largest modulus of soft tissue over that of a void
constexpr int kHeldShare = 8;             ///< a node is held for the sake of a layer: 1 / share

std::int64_t node_count(Vec3i cells) {
    return std::int64_t(cells.x + 1) * (cells.y + 1) * (cells.z + 1);
}

std::size_t node_index(Vec3i nodes, Vec3i at) {
    return std::size_t(at.x) +
           std::size_t(nodes.x) * (std::size_t(at.y) + std::size_t(nodes.y) * std::size_t(at.z));
}

int halves(int cells, int shift) {
    return (cells + (1 << shift) - 1) >> shift;
}

/// Shifts of the levels, finest first.
std::vector<Vec3i> find_shifts(const Grid& grid) {
    std::vector<Vec3i> shifts{{0, 0, 0}};
    for (;;) {
        const Vec3i last = shifts.back();
        Vec3i cells, next = last;
        Vec3d edge;
        double shortest = HUGE_VAL;
        for (int a = 0; a < 3; ++a) {
            cells[a] = halves(grid.size[a] - 1, last[a]);
            edge[a] = grid.spacing_mm[a] * (1 << last[a]);
            if (cells[a] >= 4) shortest = std::min(shortest, edge[a]);
        }
        if (node_count(cells) <= kLastNodes) return shifts;
        for (int a = 0; a < 3; ++a)
            if (cells[a] >= 4 && edge[a] <= kLargestAspect * shortest) ++next[a];
        if (next == last) return shifts;
        shifts.push_back(next);
    }
}

}  // namespace

StiffnessMap::StiffnessMap(const Volume& volume, const ElasticScanSettings& settings,
                           const TaskArena& arena, const Field* edits)
    : m_volume(volume),
      m_edits(edits),
      m_table(settings.moduli_kpa),
      m_held_above(settings.held_above_hu),
      m_shifts(find_shifts(volume.grid)) {
    for (const Vec3i here : m_shifts) {
        const Vec3i last = m_shifts.back();
        Vec3i& cells = m_cells.emplace_back();
        for (int a = 0; a < 3; ++a)
            cells[a] = halves(volume.grid.size[a] - 1, last[a]) << (last[a] - here[a]);
    }
    const double nu = settings.poisson_ratio;
    m_lambda_per_mu = float(2 * nu / (1 - 2 * nu));
    m_mu_per_pa = float(1 / (2 * (1 + nu)));
    double largest = 0;  // of tissue that moves
    for (const auto& entry : m_table)
        if (entry.value <= m_held_above) largest = std::max(largest, entry.kpa);
    if (largest == 0)
        for (const auto& entry : m_table) largest = std::max(largest, entry.kpa);
    for (const LabelMaterial& material : settings.label_materials)
        if (material.elastic && material.law != LabelLaw::Immobile)
            largest = std::max(largest, material.elastic->young_modulus_kpa);
    m_void_mu = float(1000 * largest) * m_mu_per_pa / kJump;
    if (volume.is_16_bit()) {
        m_of_value.resize(65536);
        for (int value = -32768; value < 32768; ++value)
            m_of_value[std::size_t(value + 32768)] = m_mu_per_pa * modulus_of(float(value));
    }
    take_labels(settings);
    find_held_sides(settings);
    for (int level = 1; level < level_count(); ++level) {
        const Vec3i all = cells(level);
        m_mu.emplace_back(std::size_t(all.x) * std::size_t(all.y) * std::size_t(all.z));
        coarsen(level, {{0, 0, 0}, all}, arena);
        m_bone.emplace_back(std::size_t(node_count(all)));
        coarsen_bone(level, {{0, 0, 0}, all + Vec3i{1, 1, 1}}, arena);
    }
}

void StiffnessMap::take_labels(const ElasticScanSettings& settings) {
    ChainMailSettings labelled;
    labelled.label_materials = settings.label_materials;
    for (LabelMaterial& material : labelled.label_materials) material.along_direction = false;
    labelled.labels = settings.labels;
    m_labels = LabelMap(labelled);
    for (const LabelMaterial& material : settings.label_materials) {
        LabelledTissue& tissue = m_labelled.emplace_back();
        if (material.elastic)
            tissue.mu = float(1000 * material.elastic->young_modulus_kpa) * m_mu_per_pa;
        tissue.held_above = material.law == LabelLaw::Immobile ? -HUGE_VAL
                            : material.law == LabelLaw::Constant
                                ? HUGE_VAL
                                : material.bone_threshold_hu.value_or(m_held_above);
    }
}

void StiffnessMap::renew(const Box3i& voxels, const TaskArena& arena) {
    Box3i nodes = voxels;
    for (int level = 1; level < level_count(); ++level) {
        const Vec3i s = shift(level), all = cells(level), step = s - shift(level - 1);
        for (int a = 0; a < 3; ++a) {  // nodes that depend on one in the finer box
            nodes.begin[a] = std::max(nodes.begin[a] - step[a], 0) >> step[a];
            nodes.end[a] = std::min(((nodes.end[a] - 1 + 2 * step[a]) >> step[a]) + 1, all[a] + 1);
        }
        coarsen_bone(level, nodes, arena);
        Box3i changed;
        for (int a = 0; a < 3; ++a) {  // cells with a corner in the box
            changed.begin[a] = std::max(voxels.begin[a] - 1, 0) >> s[a];
            changed.end[a] = std::min(((voxels.end[a] - 1) >> s[a]) + 1, all[a]);
        }
        coarsen(level, changed, arena);
    }
}

Vec3d StiffnessMap::spacing_mm(int level) const {
    const Vec3i s = shift(level);
    const Vec3d& h = grid().spacing_mm;
    return {h.x * (1 << s.x), h.y * (1 << s.y), h.z * (1 << s.z)};
}

/// Young's modulus [Pa] of a voxel's value; a value that is no number is void.
float StiffnessMap::modulus_of(float value) const {
    if (!(double(value) > m_table.front().value)) return float(1000 * m_table.front().kpa);
    for (std::size_t n = 1; n < m_table.size(); ++n) {
        const auto &low = m_table[n - 1], &high = m_table[n];
        if (double(value) >= high.value) continue;
        const double part = (double(value) - low.value) / (high.value - low.value);
        return float(1000 * (low.kpa + part * (high.kpa - low.kpa)));
    }
    return float(1000 * m_table.back().kpa);
}

void StiffnessMap::find_held_sides(const ElasticScanSettings& settings) {
    const Vec3i size = grid().size;
    if (settings.held_sides) {
        for (const std::string& side : *settings.held_sides)
            m_is_side_held[side[1] - 'x'][side[0] == '+'] = true;
        return;
    }
    for (int a = 0; a < 3; ++a)
        for (int end = 0; end < 2; ++end) {
            Box3i face{{0, 0, 0}, size};
            (end ? face.begin : face.end)[a] = end ? size[a] - 1 : 1;
            for (int k = face.begin.z; k < face.end.z; ++k)
                for (int j = face.begin.y; j < face.end.y; ++j)
                    for (int i = face.begin.x; i < face.end.x && !m_is_side_held[a][end]; ++i)
                        m_is_side_held[a][end] = is_tissue({i, j, k});
        }
}

bool StiffnessMap::is_held(int level, Vec3i node) const {
    const Vec3i s = shift(level), size = grid().size;
    for (int a = 0; a < 3; ++a) {
        const int voxel = node[a] << s[a];
        // The node nearest to the last voxel, and all beyond it, are on the side.
        const bool last = voxel + ((1 << s[a]) - 1) / 2 >= size[a] - 1;
        if ((voxel == 0 && m_is_side_held[a][0]) || (last && m_is_side_held[a][1])) return true;
    }
    return is_bone_node(level, node);
}

bool StiffnessMap::is_bone_node(int level, Vec3i node) const {
    const Vec3i nodes = level > 0 ? cells(level) + Vec3i{1, 1, 1} : grid().size;
    if (!contains(Box3i{{0, 0, 0}, nodes}, node)) return false;
    return level > 0 ? m_bone[std::size_t(level - 1)][node_index(nodes, node)] != 0 : is_bone(node);
}

/// Writes whether the nodes of a row of a level are bone; none is beyond the lattice.
void StiffnessMap::bone_row(int level, Vec3i first, int count, std::uint8_t* row) const {
    const Vec3i nodes = level > 0 ? cells(level) + Vec3i{1, 1, 1} : grid().size;
    std::fill_n(row, count, std::uint8_t(0));
    if (first.y < 0 || first.y >= nodes.y || first.z < 0 || first.z >= nodes.z) return;
    const int begin = std::max(first.x, 0), end = std::min(first.x + count, nodes.x);
    if (begin >= end) return;
    std::uint8_t* const to = row + (begin - first.x);
    const std::size_t at = node_index(nodes, {begin, first.y, first.z});
    const auto* const values = std::get_if<0>(&m_volume.voxels);
    if (level > 0) {
        std::copy_n(m_bone[std::size_t(level - 1)].data() + at, end - begin, to);
    } else if (values && m_labels.empty() && !(m_edits && !m_edits->all_edits().empty())) {
        const std::int16_t* const from = values->data() + at;
        for (int i = 0; i < end - begin; ++i) to[i] = double(from[i]) > m_held_above;
    } else {
        for (int i = begin; i < end; ++i) to[i - begin] = is_bone({i, first.y, first.z});
    }
}

/// A coarser node is bone if the finer one at its place is. So that a single layer of bone between
/// them holds as well, it is bone too if such finer nodes, none of whose other parents is bone
/// itself, have an eighth of the node's weight.
void StiffnessMap::coarsen_bone(int level, const Box3i& box, const TaskArena& arena) {
    const Vec3i step = shift(level) - shift(level - 1);
    const Vec3i nodes = cells(level) + Vec3i{1, 1, 1};
    const int weight = 1 << (step.x + step.y + step.z);
    const int width = ((box.end.x - 1 - box.begin.x) << step.x) + 1 + 2 * step.x;
    auto& to = m_bone[std::size_t(level - 1)];
    const auto is_left_out = [&](Vec3i node, Vec3i offset) {
        for (int c = 1; c < 8; ++c) {  // the other parents
            Vec3i parent = node;
            bool differs = true;
            for (int a = 0; a < 3; ++a) {
                if (!(c >> a & 1)) continue;
                differs = differs && offset[a] != 0;
                parent[a] += 2 * offset[a];
            }
            if (differs && is_bone_node(level - 1, parent)) return false;
        }
        return true;
    };
    arena.for_each(box.end.z - box.begin.z, 1, [&](std::int64_t begin, std::int64_t end) {
        std::vector<std::uint8_t> rows[3][3];
        for (auto& plane : rows)
            for (auto& row : plane) row.resize(std::size_t(width));
        for (int k = box.begin.z + int(begin); k < box.begin.z + int(end); ++k)
            for (int j = box.begin.y; j < box.end.y; ++j) {
                bool is_any = false;
                const Vec3i first{(box.begin.x << step.x) - step.x, j << step.y, k << step.z};
                for (int z = -step.z; z <= step.z; ++z)
                    for (int y = -step.y; y <= step.y; ++y) {
                        auto& row = rows[z + 1][y + 1];
                        bone_row(level - 1, first + Vec3i{0, y, z}, width, row.data());
                        is_any = is_any || std::ranges::find(row, 1) != row.end();
                    }
                std::uint8_t* const out = to.data() + node_index(nodes, {box.begin.x, j, k});
                std::fill_n(out, box.end.x - box.begin.x, std::uint8_t(0));
                for (int i = 0; is_any && i < box.end.x - box.begin.x; ++i) {
                    const int at = (i << step.x) + step.x;
                    int sum = rows[1][1][std::size_t(at)] ? 8 * weight : 0;
                    for (int z = -step.z; z <= step.z; ++z)
                        for (int y = -step.y; y <= step.y; ++y)
                            for (int x = -step.x; x <= step.x && sum < 8 * weight; ++x)
                                if (rows[z + 1][y + 1][std::size_t(at + x)] &&
                                    is_left_out({(box.begin.x + i) << step.x, first.y, first.z},
                                                {x, y, z}))
                                    sum += 8 >> (std::abs(x) + std::abs(y) + std::abs(z));
                    out[i] = kHeldShare * sum >= 8 * weight;
                }
            }
    });
}

// Edits.

std::uint8_t StiffnessMap::edits_at(Vec3i ijk) const {
    if (m_edits->all_edits().empty()) return 0;
    const Vec3i brick = m_edits->brick_of(ijk);
    const BrickEdits* const edits = m_edits->edits_of(brick);
    return edits ? (*edits)[std::size_t(m_edits->index_in_brick(ijk, brick))] : std::uint8_t(0);
}

/// Whether one of a cell's twelve links is cut.
bool StiffnessMap::is_slit(Vec3i cell) const {
    for (int c = 0; c < 8; ++c) {
        const std::uint8_t edits = edits_at(cell + Vec3i{c & 1, c >> 1 & 1, c >> 2});
        for (int a = 0; a < 3; ++a)
            if (!(c >> a & 1) && (edits & (kCutX << a))) return true;
    }
    return false;
}

/// Shear modulus of a cell that has an edited voxel.
float StiffnessMap::edited_mu(Vec3i cell) const {
    if (is_slit(cell)) return kSlit * m_void_mu;
    float sum = 0;
    for (int c = 0; c < 8; ++c) {
        const Vec3i voxel = cell + Vec3i{c & 1, c >> 1 & 1, c >> 2};
        if (!is_carved(voxel)) sum += 0.125F * mu_of(voxel);
    }
    return std::max(sum, m_void_mu);
}

/// Visits the cells with an edited voxel in a row of count cells of level 0, some of them twice.
template <class Visit>
void StiffnessMap::for_each_edited(Vec3i first, int count, const Visit& visit) const {
    if (!m_edits || m_edits->all_edits().empty()) return;
    const int size = m_edits->brick_size();
    for (int corner = 0; corner < 4; ++corner) {
        const int y = first.y + (corner & 1), z = first.z + (corner >> 1);
        for (int x = first.x; x <= first.x + count;) {
            const Vec3i brick = m_edits->brick_of({x, y, z});
            const int end = std::min(size * (brick.x + 1), first.x + count + 1);
            if (const BrickEdits* const edits = m_edits->edits_of(brick))
                for (int i = x; i < end; ++i) {
                    if (!(*edits)[std::size_t(m_edits->index_in_brick({i, y, z}, brick))]) continue;
                    if (i > first.x) visit(i - 1);
                    if (i < first.x + count) visit(i);
                }
            x = end;
        }
    }
}

/// Shear moduli of a row of level 0, inside of the scan.
void StiffnessMap::fine_row(Vec3i first, int count, float* mu) const {
    std::fill_n(mu, count, 0.0F);
    float before = 0;
    const auto add = [&](const auto& of_voxel) {
        before = of_voxel(0);
        for (int i = 0; i < count; ++i) {
            const float next = of_voxel(i + 1);
            mu[i] += 0.125F * (before + next);
            before = next;
        }
    };
    for (int corner = 0; corner < 4; ++corner) {
        const Vec3i begin{first.x, first.y + (corner & 1), first.z + (corner >> 1)};
        const std::size_t at = voxel_index(grid(), begin);
        if (!m_labels.empty()) {
            add([&](int i) { return mu_of(begin + Vec3i{i, 0, 0}); });
        } else if (const auto* values = std::get_if<0>(&m_volume.voxels)) {
            const std::int16_t* const row = values->data() + at;
            add([&](int i) { return m_of_value[std::size_t(row[i] + 32768)]; });
        } else {
            const float* const row = std::get_if<1>(&m_volume.voxels)->data() + at;
            add([&](int i) { return m_mu_per_pa * modulus_of(row[i]); });
        }
    }
    for (int i = 0; i < count; ++i) mu[i] = std::max(mu[i], m_void_mu);
    for_each_edited(first, count, [&](int x) {
        mu[x - first.x] = edited_mu({x, first.y, first.z});
    });
}

void StiffnessMap::moduli(int level, const Box3i& box, std::size_t stride, std::size_t rows,
                          float* mu) const {
    const Vec3i all = cells(level), size = grid().size;
    for (int k = box.begin.z; k < box.end.z; ++k)
        for (int j = box.begin.y; j < box.end.y; ++j) {
            float* const row =
                mu + stride * (std::size_t(j - box.begin.y) + rows * std::size_t(k - box.begin.z));
            const int count = box.end.x - box.begin.x;
            if (level > 0) {
                const float* const from =
                    m_mu[std::size_t(level - 1)].data() + box.begin.x +
                    std::size_t(all.x) * (std::size_t(j) + std::size_t(all.y) * std::size_t(k));
                std::copy_n(from, count, row);
            } else if (j + 1 < size.y && k + 1 < size.z) {
                const int inside = std::clamp(size.x - 1 - box.begin.x, 0, count);
                fine_row({box.begin.x, j, k}, inside, row);
                std::fill(row + inside, row + count, m_void_mu);
            } else {
                std::fill_n(row, count, m_void_mu);
            }
        }
}

void StiffnessMap::kinds(int level, const Box3i& box, std::size_t stride, std::size_t rows,
                         CellKind* out) const {
    const Vec3i size = grid().size;
    const int count = box.end.x - box.begin.x;
    const auto kind_if = [](bool is_tissue) {
        return is_tissue ? CellKind::Tissue : CellKind::Open;
    };
    std::vector<float> mu(level > 0 ? std::size_t(count) : 0);
    for (int k = box.begin.z; k < box.end.z; ++k)
        for (int j = box.begin.y; j < box.end.y; ++j) {
            CellKind* const row =
                out + stride * (std::size_t(j - box.begin.y) + rows * std::size_t(k - box.begin.z));
            if (level > 0) {
                moduli(level, {{box.begin.x, j, k}, {box.end.x, j + 1, k + 1}}, mu.size(), 1,
                       mu.data());
                for (std::size_t i = 0; i < mu.size(); ++i)
                    row[i] = kind_if(mu[i] > kTissue * m_void_mu);
                continue;
            }
            const auto is_solid = [&](int x) {  // the four voxels of a cell's face
                for (int c = 0; c < 4; ++c)
                    if (!is_tissue({x, j + (c & 1), k + (c >> 1)})) return false;
                return true;
            };
            std::fill_n(row, count, CellKind::Open);
            const int inside = std::min(count, size.x - 1 - box.begin.x);
            if (j + 1 >= size.y || k + 1 >= size.z || inside <= 0) continue;
            bool before = is_solid(box.begin.x);
            for (int i = 0; i < inside; ++i) {
                const bool next = is_solid(box.begin.x + i + 1);
                row[i] = kind_if(before && next);
                before = next;
            }
            for_each_edited({box.begin.x, j, k}, inside, [&](int x) {
                if (is_slit({x, j, k})) row[x - box.begin.x] = CellKind::Slit;
            });
        }
}

/// Moduli of some cells of a level from those of the next finer one.
void StiffnessMap::coarsen(int level, const Box3i& box, const TaskArena& arena) {
    const Vec3i coarse = cells(level), step = shift(level) - shift(level - 1);
    auto& to = m_mu[std::size_t(level - 1)];
    const float weight = 1.0F / float(1 << (step.x + step.y + step.z));
    const int count = box.end.x - box.begin.x, first = box.begin.x << step.x;
    arena.for_each(box.end.z - box.begin.z, 1, [&](std::int64_t begin, std::int64_t end) {
        std::vector<float> row(std::size_t(count << step.x));
        for (int k = box.begin.z + int(begin); k < box.begin.z + int(end); ++k)
            for (int j = box.begin.y; j < box.end.y; ++j) {
                float* const out = to.data() + box.begin.x +
                                   std::size_t(coarse.x) *
                                       (std::size_t(j) + std::size_t(coarse.y) * std::size_t(k));
                std::fill_n(out, count, 0.0F);
                for (int z = k << step.z; z < (k + 1) << step.z; ++z)
                    for (int y = j << step.y; y < (j + 1) << step.y; ++y) {
                        moduli(level - 1, {{first, y, z}, {first + int(row.size()), y + 1, z + 1}},
                               row.size(), 1, row.data());
                        for (std::size_t i = 0; i < row.size(); ++i)
                            out[i >> step.x] += weight * row[i];
                    }
            }
    });
}

}  // namespace pliant
