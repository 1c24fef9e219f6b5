// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The fillet between tubes is independent of their order. With m the minimum distance, it is
//   m − k/4 · Σ max(0, 1 − (dᵢ − m)/k)²   over the other tubes,
// the usual quadratic fillet for two tubes. Pieces of one tube are united without a fillet, so that
// a tube doesn't swell at its joints.

#include "volume/phantom_tubes.h"

#include "volume/phantom_noise.h"

#include <array>
#include <atomic>
#include <bit>
#include <span>

namespace pliant::phantom {
namespace {

constexpr std::size_t kChunk = 4;  // pieces

/// Surfaces of one tube at a point, without fillets.
TubePosition position_in(const Tube& tube, const TubeRow::Nearest& n, Vec3d p) {
    TubePosition position;
    const double out = std::max(n.axis_mm, 1e-6);
    position.back = dot(n.out, tube.back) / out;
    const double flat = tube.flatness * n.radius_mm * ramp(0.25, 0.95, position.back);
    position.smooth_mm = n.distance_mm + flat;
    position.outer_mm = position.smooth_mm - tube.wall_mm;
    position.lumen_mm = position.smooth_mm;
    if (tube.ring_mm <= 0) return position;
    const double uneven = 0.16 * value_noise(p * 0.11, 21);
    position.ring = wave(n.along_mm / tube.ring_mm + uneven);
    const double horseshoe = 1 - ramp(0.35, 0.75, position.back);
    const double ring = 0.5 * tube.ring_depth_mm * (1 + position.ring) * horseshoe;
    const Vec3d side = cross(tube.back, n.axis);
    const double fold = 0.45 * tube.ring_depth_mm * (1 - horseshoe) *
                        (1 + wave(dot(n.out, side) / (0.42 * n.radius_mm)));
    // Rings fade out towards the axis, where the direction is undefined.
    position.lumen_mm += (ring + fold) * ramp(0.2, 0.6, n.axis_mm / n.radius_mm);
    return position;
}

/// Fillet term of a tube that is `further_mm` farther away than the nearest.
double fillet(double further_mm, double k) {
    const double h = std::max(0.0, 1 - further_mm / k);
    return 0.25 * k * h * h;
}

/// Blends the surfaces of several tubes, with the ring of the nearest one.
TubePosition blended(std::span<const TubePosition> near, const TubePosition& best, double k) {
    TubePosition result = best;
    for (const TubePosition& position : near) {
        result.lumen_mm = std::min(result.lumen_mm, position.lumen_mm);
        result.outer_mm = std::min(result.outer_mm, position.outer_mm);
    }
    const double own = fillet(0, k);  // of the nearest tube, which is excluded
    double lumen = -own, smooth = -own, outer = -own;
    for (const TubePosition& position : near) {
        lumen += fillet(position.lumen_mm - result.lumen_mm, k);
        smooth += fillet(position.smooth_mm - result.smooth_mm, k);
        outer += fillet(position.outer_mm - result.outer_mm, k);
    }
    result.lumen_mm -= lumen;
    result.smooth_mm -= smooth;
    result.outer_mm -= outer;
    return result;
}

}  // namespace

TubeRow::TubeRow(const std::vector<TubePoint>& points) {
    double start = 0;
    for (std::size_t n = 0; n + 1 < points.size(); ++n) {
        const TubePoint &a = points[n], &b = points[n + 1];
        const Vec3d along = b.x - a.x;
        const double length = norm(along);
        m_pieces.push_back({a.x, along, 1 / (length * length), length, start, a.radius_mm,
                            b.radius_mm - a.radius_mm});
        start += length;
    }
    const auto sphere_around = [&](std::size_t begin, std::size_t end, Vec3d& centre) {
        centre = 0.5 * (points[begin].x + points[end].x);
        double radius = 0;
        for (std::size_t n = begin; n <= end; ++n)
            radius = std::max(radius, norm(points[n].x - centre) + points[n].radius_mm);
        return radius;
    };
    for (std::size_t n = 0; n < m_pieces.size(); n += kChunk) {
        Chunk chunk{{0, 0, 0}, 0, n, std::min(n + kChunk, m_pieces.size())};
        chunk.radius_mm = sphere_around(chunk.begin, chunk.end, chunk.centre);
        m_chunks.push_back(chunk);
    }
    m_radius_mm = sphere_around(0, m_pieces.size(), m_centre);
}

TubeRow::Nearest TubeRow::find(Vec3d p, double at_most_mm) const {
    // Compares squares: |out| − radius < least, without a root until a piece is nearer.
    double least = at_most_mm, least_t = 0;
    std::size_t least_n = m_pieces.size();
    const auto may_be_nearer = [&least](Vec3d out, double radius) {
        const double reach = least + radius;
        return reach > 0 && dot(out, out) < reach * reach;
    };
    for (const Chunk& chunk : m_chunks) {
        if (!may_be_nearer(p - chunk.centre, chunk.radius_mm)) continue;
        for (std::size_t n = chunk.begin; n < chunk.end; ++n) {
            const Piece& piece = m_pieces[n];
            const Vec3d from = p - piece.from;
            const double t = clamp01(dot(from, piece.along) * piece.per_square);
            const Vec3d out = from - t * piece.along;
            const double radius = piece.radius_mm + t * piece.growth_mm;
            if (!may_be_nearer(out, radius)) continue;
            least = norm(out) - radius;
            least_t = t;
            least_n = n;
        }
    }
    Nearest none;
    none.distance_mm = at_most_mm;
    if (least_n == m_pieces.size()) return none;
    const Piece& piece = m_pieces[least_n];
    const Vec3d out = p - piece.from - least_t * piece.along;
    return {norm(out) - (piece.radius_mm + least_t * piece.growth_mm),
            norm(out),
            piece.radius_mm + least_t * piece.growth_mm,
            piece.start_mm + least_t * piece.length_mm,
            out,
            (1 / piece.length_mm) * piece.along};
}

TubeTree::TubeTree(std::vector<Tube> tubes, double fillet_mm)
    : m_tubes(std::move(tubes)), m_fillet_mm(fillet_mm) {
    static std::atomic<std::uint64_t> trees = 0;
    m_identity = ++trees;
    for (const Tube& tube : m_tubes) m_rows.emplace_back(tube.points);
}

TubePosition TubeTree::find(Vec3d p) const {
    struct Answer {
        std::uint64_t identity = 0;
        Vec3d p{0, 0, 0};
        TubePosition position;
    };
    thread_local std::array<Answer, 32> answers;
    const std::uint64_t bits = std::bit_cast<std::uint64_t>(p.x) * 0x9e3779b97f4a7c15ULL ^
                               std::bit_cast<std::uint64_t>(p.y) * 0xd6e8feb86659fd93ULL ^
                               std::bit_cast<std::uint64_t>(p.z) * 0xa0761d6478bd642fULL;
    Answer& answer = answers[(bits ^ bits >> 29) * 0x9e3779b97f4a7c15ULL >> 59];
    if (answer.identity != m_identity || !(answer.p == p)) answer = {m_identity, p, find_anew(p)};
    return answer.position;
}

TubePosition TubeTree::find_anew(Vec3d p) const {
    constexpr std::size_t kNear = 6;
    constexpr double kWalls_mm = 2;  // maximum difference between walls
    constexpr double kCapped_mm = kFar_mm + 1;
    TubePosition near[kNear], best;
    std::size_t count = 0;
    for (std::size_t n = 0; n < m_tubes.size(); ++n) {
        const double reach = best.smooth_mm + 2 * m_fillet_mm + kWalls_mm;
        const double least = m_rows[n].least_distance(p);
        if (least > reach) continue;
        TubePosition position;
        if (least > kFar_mm) {
            position.lumen_mm = position.smooth_mm = least;
            position.outer_mm = least - m_tubes[n].wall_mm;
        } else {
            const TubeRow::Nearest nearest = m_rows[n].find(p, std::min(reach, kCapped_mm));
            if (nearest.distance_mm >= reach) continue;
            position = position_in(m_tubes[n], nearest, p);
            if (position.smooth_mm > kFar_mm) {
                position.lumen_mm = position.smooth_mm = kFar_mm;
                position.outer_mm = kFar_mm - m_tubes[n].wall_mm;
            }
        }
        if (position.smooth_mm < best.smooth_mm) best = position;
        std::size_t slot = count;
        if (count == kNear) {  // full: replaces the farthest
            slot = 0;
            for (std::size_t m = 1; m < kNear; ++m)
                if (near[m].smooth_mm > near[slot].smooth_mm) slot = m;
            if (near[slot].smooth_mm <= position.smooth_mm) continue;
        } else {
            ++count;
        }
        near[slot] = position;
    }
    return blended(std::span<const TubePosition>(near, count), best, m_fillet_mm);
}

std::vector<TubePoint> smooth_row(const std::vector<TubePoint>& row, int pieces) {
    std::vector<TubePoint> out;
    const auto at = [&](std::ptrdiff_t n) {
        return row[std::size_t(std::clamp<std::ptrdiff_t>(n, 0, std::ptrdiff_t(row.size()) - 1))];
    };
    for (std::ptrdiff_t n = 0; n + 1 < std::ptrdiff_t(row.size()); ++n)
        for (int piece = 0; piece < pieces; ++piece) {
            const double t = double(piece) / pieces, t2 = t * t, t3 = t2 * t;
            const double w[4] = {0.5 * (-t3 + 2 * t2 - t), 0.5 * (3 * t3 - 5 * t2 + 2),
                                 0.5 * (-3 * t3 + 4 * t2 + t), 0.5 * (t3 - t2)};
            TubePoint point{{0, 0, 0}, 0};
            for (int m = 0; m < 4; ++m) {
                const TubePoint q = at(n + m - 1);
                point.x = point.x + w[m] * q.x;
                point.radius_mm += w[m] * q.radius_mm;
            }
            out.push_back(point);
        }
    out.push_back(row.back());
    return out;
}

ScalarField row_of_capsules(const std::vector<TubePoint>& row) {
    return [tube = TubeRow(row)](Vec3d p) {
        const double least = tube.least_distance(p);
        if (least > TubeTree::kFar_mm) return least;
        return tube.find(p, TubeTree::kFar_mm).distance_mm;
    };
}

}  // namespace pliant::phantom
