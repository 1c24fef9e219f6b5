// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include <pliant/resample.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <functional>
#include <iterator>

#include "base/errors.h"
#include "base/half.h"
#include "field/field.h"

namespace pliant {
namespace {

// Distance of a position at rest from carved elements and cut links.

class RawTissue {
  public:
    /// Keeps a reference: the lattice must stay as it is.
    explicit RawTissue(const Field& field) : m_field(field) {
        if (field.all_edits().empty()) return;
        const auto& edits = field.all_edits();
        m_bricks = {edits.begin()->first, edits.begin()->first};
        for (const auto& [coord, flags] : edits)
            for (int a = 0; a < 3; ++a) {
                m_bricks.begin[a] = std::min(m_bricks.begin[a], coord[a]);
                m_bricks.end[a] = std::max(m_bricks.end[a], coord[a] + 1);
            }
    }
    /// Whether there are no edits.
    bool is_empty() const { return m_field.all_edits().empty(); }

    /// Distance to the nearest of them in the maximum norm [voxels], or reach.
    /// @param x  continuous element index at rest
    double distance(Vec3d x, double reach) const {
        // Elements with a flag may have a cut link to an element that is 1 further.
        const double size = m_field.brick_size();
        for (int a = 0; a < 3; ++a)
            if (!(x[a] + reach >= size * m_bricks.begin[a] &&
                  x[a] - reach - 1 < size * m_bricks.end[a]))
                return reach;
        Box3i bricks;
        for (int a = 0; a < 3; ++a) {
            const double low = std::floor(x[a] - reach) - 1, high = std::floor(x[a] + reach);
            bricks.begin[a] = std::max(int(std::floor(low / size)), m_bricks.begin[a]);
            bricks.end[a] = std::min(int(std::floor(high / size)) + 1, m_bricks.end[a]);
        }
        // The brick that contains x first: others then have a small range to search.
        double nearest = reach;
        const auto look_in = [&](Vec3i brick) {
            if (const BrickEdits* edits = m_field.edits_of(brick))
                nearest = distance_in(brick, *edits, x, nearest);
        };
        const Vec3i own{int(std::floor(x.x / size)), int(std::floor(x.y / size)),
                        int(std::floor(x.z / size))};
        if (contains(bricks, own)) look_in(own);
        for (int k = bricks.begin.z; k < bricks.end.z; ++k)
            for (int j = bricks.begin.y; j < bricks.end.y; ++j)
                for (int i = bricks.begin.x; i < bricks.end.x && nearest > 0; ++i)
                    if (own != Vec3i{i, j, k}) look_in({i, j, k});
        return nearest;
    }

  private:
    double distance_in(Vec3i brick, const BrickEdits& edits, Vec3d x, double nearest) const {
        const int size = m_field.brick_size();
        const Vec3i first = size * brick;
        Box3i near;  // elements of the brick that may be nearer
        for (int a = 0; a < 3; ++a) {
            near.begin[a] = std::max(int(std::ceil(x[a] - nearest)) - 1 - first[a], 0);
            near.end[a] = std::min(int(std::floor(x[a] + nearest)) + 1 - first[a], size);
        }
        const auto is_beyond = [&](int axis, int element) {
            const double away = x[axis] - (first[axis] + element);
            return -away >= nearest || away - 1 >= nearest;
        };
        for (int k = near.begin.z; k < near.end.z; ++k) {
            if (is_beyond(2, k)) continue;
            for (int j = near.begin.y; j < near.end.y; ++j) {
                if (is_beyond(1, j)) continue;
                const std::uint8_t* row = edits.data() + size * (j + size * k);
                if (std::none_of(row + near.begin.x, row + std::max(near.end.x, near.begin.x),
                                 [](std::uint8_t flags) { return flags; }))
                    continue;
                for (int i = near.begin.x; i < near.end.x; ++i) {
                    const std::uint8_t flags = row[i];
                    if (!flags) continue;
                    const Vec3i e = first + Vec3i{i, j, k};
                    double away = 0;
                    for (int a = 0; a < 3; ++a) {
                        const double over = x[a] - e[a] - ((flags & kCutX << a) ? 1 : 0);
                        away = std::max({away, e[a] - x[a], over});
                    }
                    nearest = std::min(nearest, away);
                }
            }
        }
        return nearest;
    }

    const Field& m_field;
    Box3i m_bricks;  ///< box of all bricks with edits
};

constexpr std::int64_t kRowsPerTask = 64;

/// −0 becomes +0: a node at rest is all zero bits.
std::uint16_t half_of(double value) {
    const std::uint16_t half = half_from_float(float(value));
    return half == 0x8000U ? std::uint16_t(0) : half;
}

int node_count_along(int voxels) {
    return (std::max(voxels, 1) - 1 + kRestStep - 1) / kRestStep + 1;
}

/// Nodes whose voxel lies in a box.
Box3i nodes_of(const Box3i& voxels, Vec3i size, Vec3i counts) {
    Box3i nodes;
    for (int a = 0; a < 3; ++a) {
        nodes.begin[a] = (std::max(voxels.begin[a], 0) + kRestStep - 1) / kRestStep;
        nodes.end[a] =
            voxels.end[a] >= size[a] ? counts[a] : (voxels.end[a] + kRestStep - 1) / kRestStep;
    }
    return nodes;
}

}  // namespace

/// Writes nodes of a field, row by row; several threads may write rows.
class RestField::Writer {
  public:
    Writer(RestField& field, const Field& tissue)
        : m_field(field), m_tissue(tissue), m_raw(tissue) {
        const Vec3d s = field.m_grid.spacing_mm;
        m_voxels_from_mm = inverse(field.m_grid.direction);
        for (Vec3d& column : m_voxels_from_mm.columns)
            column = {column.x / s.x, column.y / s.y, column.z / s.z};
    }
    bool has_edits() const { return !m_raw.is_empty(); }
    std::int64_t moved() const { return m_moved; }

    /// Writes the nodes begin…end of a row. @param offset  sets the first three halves of a voxel,
    /// or keeps them
    /// @param looks_for_gaps  false: voxels are unchanged, so only a raw node can be in a gap
    /// @returns the nodes from the first to the last that changed
    template <class Offset>
    Box3i write(Vec3i begin, int end, bool looks_for_gaps, const Offset& offset) {
        Box3i changed;
        std::int64_t moved = 0;
        std::uint16_t* to = m_field.m_halves.data() + m_field.index(begin);
        for (Vec3i node = begin; node.x < end; ++node.x, to += 4) {
            Vec3i voxel;
            for (int a = 0; a < 3; ++a)
                voxel[a] = std::min(kRestStep * node[a], m_field.m_grid.size[a] - 1);
            std::array<std::uint16_t, 4> now{to[0], to[1], to[2], to[3]};
            offset(voxel, now);
            now[3] = m_raw.is_empty() ? std::uint16_t(0) : raw_at(voxel, now, looks_for_gaps);
            if (std::equal(now.begin(), now.end(), to)) continue;
            const auto is_moved = [](const std::uint16_t* n) {
                return n[0] || n[1] || n[2] || n[3];
            };
            moved += is_moved(now.data()) - is_moved(to);
            std::copy(now.begin(), now.end(), to);
            if (is_empty(changed)) changed = {node, node + Vec3i{1, 1, 1}};
            changed.end.x = node.x + 1;
        }
        m_moved += moved;
        return changed;
    }

  private:
    /// Depends on the halves alone, not on the time of their writing.
    std::uint16_t raw_at(Vec3i voxel, const std::array<std::uint16_t, 4>& node,
                         bool looks_for_gaps) const {
        const Vec3d u{float_from_half(node[0]), float_from_half(node[1]), float_from_half(node[2])};
        if (u == Vec3d{0, 0, 0} && (looks_for_gaps || node[3] == half_from_float(1))) {
            // Nothing is shown there although the element has left: an opened gap.
            static const Fixed kLeft = units_from_mm(1.0 / 1024);
            const Vec3<Fixed> moved = m_tissue.displacement_at(voxel);
            if (std::abs(moved.x) > kLeft || std::abs(moved.y) > kLeft || std::abs(moved.z) > kLeft)
                return half_from_float(1);
        }
        const Vec3d p{double(voxel.x), double(voxel.y), double(voxel.z)};
        const double distance = m_raw.distance(p - m_voxels_from_mm * u, kRawReach);
        return half_of(std::clamp((kRawReach - distance) / kRestStep, 0.0, 1.0));
    }

    RestField& m_field;
    const Field& m_tissue;
    const RawTissue m_raw;
    Mat3d m_voxels_from_mm;
    std::atomic<std::int64_t> m_moved = 0;
};

RestField::RestField(const Grid& grid)
    : m_grid(grid),
      m_counts{node_count_along(grid.size.x), node_count_along(grid.size.y),
               node_count_along(grid.size.z)} {}

Result<std::span<const Box3i>> RestField::update(const LiveDeformation& live,
                                                 std::span<const Box3i> boxes) noexcept {
    return attempt([&]() -> Result<std::span<const Box3i>> {
        const Field& tissue = live.scan().deformation().field();
        const bool has_edits = !tissue.all_edits().empty();
        const bool looks_at_links =
            (has_edits || m_had_edits) && tissue.links_version() != m_links_version;
        m_boxes.clear();
        if (boxes.empty() && !looks_at_links) return std::span<const Box3i>(m_boxes);
        if (m_halves.empty()) m_halves.assign(index({0, 0, m_counts.z}), 0);
        Writer writer(*this, tissue);
        const auto from_live = [&](Vec3i voxel, std::array<std::uint16_t, 4>& node) {
            const Vec3f back = live.source_offset_mm(voxel);
            for (int a = 0; a < 3; ++a) node[std::size_t(a)] = half_of(-back[a]);
        };
        // Rows of nodes first, then their changed parts.
        for (const Box3i& box : boxes) {
            const Box3i nodes = nodes_of(box, m_grid.size, m_counts);
            for (int k = nodes.begin.z; k < nodes.end.z; ++k)
                for (int j = nodes.begin.y; j < nodes.end.y; ++j)
                    if (nodes.begin.x < nodes.end.x)
                        m_boxes.push_back({{nodes.begin.x, j, k}, {nodes.end.x, j + 1, k + 1}});
        }
        const auto write_rows = [&](std::int64_t begin, std::int64_t end) {
            for (auto row = std::size_t(begin); row < std::size_t(end); ++row)
                m_boxes[row] =
                    writer.write(m_boxes[row].begin, m_boxes[row].end.x, true, from_live);
        };
        live.scan().arena().for_each(std::int64_t(m_boxes.size()), kRowsPerTask,
                                     std::ref(write_rows));
        std::erase_if(m_boxes, [](const Box3i& row) { return is_empty(row); });
        if (looks_at_links) {
            // Boxes where tissue is raw now, and where it was.
            std::vector<Box3i> rows(std::size_t(m_counts.y) * std::size_t(m_counts.z));
            const auto task = [&](std::int64_t begin, std::int64_t end) {
                for (std::int64_t row = begin; row < end; ++row)
                    rows[std::size_t(row)] =
                        writer.write({0, int(row % m_counts.y), int(row / m_counts.y)}, m_counts.x,
                                     !m_had_edits, [](Vec3i, std::array<std::uint16_t, 4>&) {});
            };
            live.scan().arena().for_each(std::int64_t(rows.size()), kRowsPerTask, std::ref(task));
            std::copy_if(rows.begin(), rows.end(), std::back_inserter(m_boxes),
                         [](const Box3i& row) { return !is_empty(row); });
        }
        m_links_version = tissue.links_version();
        m_had_edits = has_edits;
        m_moved += writer.moved();
        if (m_moved == 0) m_halves = {};
        return std::span<const Box3i>(m_boxes);
    });
}

Result<RestField> RestField::create(const MovingScan& scan, const Deformed& deformed) noexcept {
    return attempt([&]() -> Result<RestField> {
        const Grid& grid = scan.volume().grid;
        if (deformed.volume.grid != grid)
            return invalid("deformed: expected the grid of the scan, found another one");
        const Box3i box = deformed.dirty_box;
        if (!is_empty(box) && deformed.inverse_mm.size() != std::size_t(node_count(box)))
            return invalid("deformed: expected the inverse displacement, found none");
        if (const Status s = scan.update_deformation(); !s.ok()) return s.error();
        RestField field(grid);
        const Field& tissue = scan.deformation().field();
        if (is_empty(box) && tissue.all_edits().empty()) return field;
        field.m_halves.assign(field.index({0, 0, field.m_counts.z}), 0);
        Writer writer(field, tissue);
        const Vec3i n = box.end - box.begin;
        const auto from_box = [&](Vec3i voxel, std::array<std::uint16_t, 4>& node) {
            if (is_empty(box) || !contains(box, voxel)) return;
            const Vec3i p = voxel - box.begin;
            const Vec3f back =
                deformed.inverse_mm[std::size_t(p.x) +
                                    std::size_t(n.x) *
                                        (std::size_t(p.y) + std::size_t(n.y) * std::size_t(p.z))];
            for (int a = 0; a < 3; ++a) node[std::size_t(a)] = half_of(-back[a]);
        };
        const auto task = [&](std::int64_t begin, std::int64_t end) {
            for (std::int64_t row = begin; row < end; ++row)
                writer.write({0, int(row % field.m_counts.y), int(row / field.m_counts.y)},
                             field.m_counts.x, true, from_box);
        };
        scan.arena().for_each(std::int64_t(field.m_counts.y) * field.m_counts.z, kRowsPerTask,
                              std::ref(task));
        field.m_links_version = tissue.links_version();
        field.m_had_edits = writer.has_edits();
        field.m_moved = writer.moved();
        if (field.m_moved == 0) field.m_halves = {};
        return field;
    });
}

RestField::Sample RestField::at(Vec3d ijk) const {
    Sample sample;
    if (m_halves.empty()) return sample;
    Vec3i low;
    std::array<float, 3> t{};
    for (int a = 0; a < 3; ++a) {
        const double last = m_counts[a] - 1;
        // Written so that NaN becomes 0.
        const double x = ijk[a] > 0 ? std::min(ijk[a] / kRestStep, last) : 0;
        low[a] = std::min(int(x), std::max(m_counts[a] - 2, 0));
        t[std::size_t(a)] = float(x - low[a]);
    }
    for (int c = 0; c < 8; ++c) {
        Vec3i node = low;
        float weight = 1;
        for (int a = 0; a < 3; ++a) {
            const bool high = c >> a & 1;
            node[a] = std::min(node[a] + high, m_counts[a] - 1);
            weight *= high ? t[std::size_t(a)] : 1 - t[std::size_t(a)];
        }
        if (weight == 0) continue;
        const std::uint16_t* from = m_halves.data() + index(node);
        for (int a = 0; a < 3; ++a) sample.offset_mm[a] += weight * float_from_half(from[a]);
        sample.raw += weight * float_from_half(from[3]);
    }
    return sample;
}

void RestField::copy(const Box3i& nodes, std::span<std::uint16_t> halves) const {
    if (m_halves.empty()) {
        std::fill(halves.begin(), halves.end(), std::uint16_t(0));
        return;
    }
    const auto width = 4 * std::ptrdiff_t(nodes.end.x - nodes.begin.x);
    auto to = halves.begin();
    for (int k = nodes.begin.z; k < nodes.end.z; ++k)
        for (int j = nodes.begin.y; j < nodes.end.y; ++j)
            to = std::copy_n(m_halves.begin() + std::ptrdiff_t(index({nodes.begin.x, j, k})), width,
                             to);
}

}  // namespace pliant
