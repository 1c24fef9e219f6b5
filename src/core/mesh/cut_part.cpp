// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "mesh/cut_part.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

namespace pliant {
namespace {

using Loop = std::span<const std::int32_t>;

Loop loop_of(const CutPart& part, const CutPart::Face& face) {
    return {part.loops.data() + face.begin, part.loops.data() + face.end};
}

void add_face(CutPart& part, Loop loop, std::int32_t side) {
    const auto begin = std::int32_t(part.loops.size());
    part.loops.insert(part.loops.end(), loop.begin(), loop.end());
    part.faces.push_back({begin, std::int32_t(part.loops.size()), side});
}

/// Coordinates in which the tetrahedron's volume is 1/6.
Vec3d unit_position(const std::array<double, 4>& w) {
    return {w[1], w[2], w[3]};
}

const CutPart::Crossing* crossing_at(const CutPart& part, std::int32_t a, std::int32_t b) {
    for (const CutPart::Crossing& c : part.begun)
        if ((c.a == a && c.b == b) || (c.a == b && c.b == a)) return &c;
    return nullptr;
}

/// Sum of the volumes between a point and the faces, as a fraction of the tetrahedron's.
double volume_from(const CutPart& part, Vec3d from) {
    double sum = 0;
    for (const CutPart::Face& face : part.faces) {
        const Loop loop = loop_of(part, face);
        const auto position = [&](std::size_t n) {
            return unit_position(part.points[std::size_t(loop[n])].weights) - from;
        };
        for (std::size_t n = 1; n + 1 < loop.size(); ++n)
            sum += dot(position(0), cross(position(n), position(n + 1)));
    }
    return sum;
}

template <class Visit>
void for_each_edge(const CutPart& part, const Visit& visit) {
    for (const CutPart::Face& face : part.faces) {
        const Loop loop = loop_of(part, face);
        for (std::size_t n = 0; n < loop.size(); ++n) {
            const std::int32_t a = loop[n], b = loop[n + 1 < loop.size() ? n + 1 : 0];
            if (a < b) visit(a, b);  // the other face has it from b to a
        }
    }
}

CutPart::Point between(const CutPart::Point& a, const CutPart::Point& b, double at) {
    CutPart::Point point{{}, -1};
    for (std::size_t k = 0; k < 4; ++k)
        point.weights[k] = a.weights[k] + at * (b.weights[k] - a.weights[k]);
    return point;
}

/// One of the two polyhedra of a split, while it is made.
struct Half {
    CutPart part{};
    std::vector<std::int32_t> labels{};    ///< [point]
    std::vector<std::int32_t> new_of{};    ///< [point of the old part], or −1
    std::vector<std::int32_t> cross_of{};  ///< [crossing of the old part], or −1
};

/// Separates the points of one label from all others.
class Splitter {
  public:
    Splitter(const CutPart& part, const std::vector<std::int32_t>& labels, std::int32_t label)
        : m_part(part), m_labels(labels), m_label(label) {
        for (Half& side : m_halves) {
            side.new_of.assign(part.points.size(), -1);
            side.cross_of.assign(part.begun.size(), -1);
        }
    }

    /// @returns whether the chords close to loops
    bool run() {
        for (std::size_t n = 0; n < m_part.points.size(); ++n) {
            Half& side = m_halves[is_first(std::int32_t(n)) ? 0 : 1];
            side.new_of[n] = std::int32_t(side.part.points.size());
            side.part.points.push_back(m_part.points[n]);
            side.labels.push_back(m_labels[n]);
        }
        add_crossings();
        for (const CutPart::Face& face : m_part.faces)
            if (!divide(face)) return false;
        if (!cap()) return false;
        keep_crossings();
        return true;
    }

    Half& first() { return m_halves[0]; }
    Half& second() { return m_halves[1]; }

  private:
    bool is_first(std::int32_t point) const { return m_labels[std::size_t(point)] == m_label; }

    void add_crossings() {
        for (std::size_t c = 0; c < m_part.begun.size(); ++c) {
            const auto& [a, b, at] = m_part.begun[c];
            if (is_first(a) == is_first(b)) continue;
            const auto point =
                between(m_part.points[std::size_t(a)], m_part.points[std::size_t(b)], at);
            for (int s = 0; s < 2; ++s) {
                Half& side = m_halves[s];
                const std::int32_t end = is_first(a) == (s == 0) ? a : b;
                side.cross_of[c] = std::int32_t(side.part.points.size());
                side.part.points.push_back(point);
                side.labels.push_back(m_labels[std::size_t(end)]);
            }
        }
        m_next.assign(m_part.begun.size(), -1);
        m_is_end.assign(m_part.begun.size(), 0);
    }

    std::int32_t crossing(std::int32_t a, std::int32_t b) const {
        const CutPart::Crossing* found = crossing_at(m_part, a, b);
        return found ? std::int32_t(found - m_part.begun.data()) : -1;
    }

    bool divide(const CutPart::Face& face) {
        const Loop loop = loop_of(m_part, face);
        const auto size = loop.size();
        const auto changes_after = [&](std::size_t n) {
            return is_first(loop[n]) != is_first(loop[(n + 1) % size]);
        };
        std::size_t start = 0;  // the first point of a run of the first side
        while (start < size && !(is_first(loop[start]) && changes_after((start + size - 1) % size)))
            ++start;
        if (start == size) {
            Half& side = m_halves[is_first(loop[0]) ? 0 : 1];
            m_loop.clear();
            for (const std::int32_t point : loop) m_loop.push_back(side.new_of[std::size_t(point)]);
            add_face(side.part, m_loop, face.side);
            return true;
        }
        m_loop.clear();
        m_other.clear();
        std::int32_t entry = -1;
        for (std::size_t k = 0; k < size; ++k) {
            const std::size_t n = (start + k) % size, before = (n + size - 1) % size;
            const std::int32_t point = loop[n];
            if (changes_after(before)) {
                const std::int32_t c = crossing(loop[before], point);
                if (c < 0) return false;
                m_other.push_back(m_halves[1].cross_of[std::size_t(c)]);
                if (is_first(point)) {
                    entry = c;
                } else {
                    // The run ends: its face is closed by a chord, the cap has it the other way.
                    m_loop.push_back(m_halves[0].cross_of[std::size_t(c)]);
                    m_loop.push_back(m_halves[0].cross_of[std::size_t(entry)]);
                    add_face(m_halves[0].part, m_loop, face.side);
                    m_loop.clear();
                    if (m_next[std::size_t(entry)] >= 0 || m_is_end[std::size_t(c)]) return false;
                    m_next[std::size_t(entry)] = c;
                    m_is_end[std::size_t(c)] = 1;
                }
            }
            if (is_first(point))
                m_loop.push_back(m_halves[0].new_of[std::size_t(point)]);
            else
                m_other.push_back(m_halves[1].new_of[std::size_t(point)]);
        }
        add_face(m_halves[1].part, m_other, face.side);
        return true;
    }

    bool cap() {
        std::vector<std::int32_t> ring;
        for (std::size_t c = 0; c < m_next.size(); ++c) {
            if (m_halves[0].cross_of[c] < 0) continue;
            if (m_next[c] == kCapped) continue;
            ring.clear();
            for (auto at = std::int32_t(c); m_next[std::size_t(at)] != kCapped;) {
                ring.push_back(at);
                at = std::exchange(m_next[std::size_t(at)], kCapped);
                if (at < 0) return false;
            }
            if (ring.size() < 3) return false;
            if (ring.size() > 3) choose_fan(ring);
            for (std::size_t n = 1; n + 1 < ring.size(); ++n)
                for (int s = 0; s < 2; ++s) {
                    Half& half = m_halves[s];
                    std::array<std::int32_t, 3> triangle{half.cross_of[std::size_t(ring[0])],
                                                         half.cross_of[std::size_t(ring[n])],
                                                         half.cross_of[std::size_t(ring[n + 1])]};
                    if (s == 1) std::swap(triangle[1], triangle[2]);
                    add_face(half.part, triangle, -1);
                }
        }
        return true;
    }

    /// Rotates a ring to the fan with which the smaller half is largest: a fan through crossings
    /// that aren't in one plane may leave the polyhedron.
    void choose_fan(std::vector<std::int32_t>& ring) const {
        std::vector<Vec3d> positions;
        for (const std::int32_t c : ring) {
            const std::int32_t point = m_halves[0].cross_of[std::size_t(c)];
            positions.push_back(unit_position(m_halves[0].part.points[std::size_t(point)].weights));
        }
        const Vec3d from = positions[0];
        const double open[] = {volume_from(m_halves[0].part, from),
                               volume_from(m_halves[1].part, from)};
        constexpr double kNoise = 1e-12;  // crossings in one plane keep their order
        std::size_t best = 0;
        double largest = -std::numeric_limits<double>::infinity();
        for (std::size_t start = 0; start < ring.size(); ++start) {
            double cap = 0;
            for (std::size_t n = 1; n + 1 < ring.size(); ++n)
                cap += dot(positions[start] - from,
                           cross(positions[(start + n) % ring.size()] - from,
                                 positions[(start + n + 1) % ring.size()] - from));
            const double smaller = std::min(open[0] + cap, open[1] - cap);
            if (smaller > largest + kNoise) {
                largest = smaller;
                best = start;
            }
        }
        std::rotate(ring.begin(), ring.begin() + std::ptrdiff_t(best), ring.end());
    }

    void keep_crossings() {
        for (const auto& [a, b, at] : m_part.begun) {
            if (is_first(a) != is_first(b)) continue;
            Half& side = m_halves[is_first(a) ? 0 : 1];
            side.part.begun.push_back(
                {side.new_of[std::size_t(a)], side.new_of[std::size_t(b)], at});
        }
    }

    static constexpr std::int32_t kCapped = -2;

    const CutPart& m_part;
    const std::vector<std::int32_t>& m_labels;
    std::int32_t m_label;
    Half m_halves[2];
    std::vector<std::int32_t> m_next;    ///< [crossing] next one around the first side's cap
    std::vector<std::uint8_t> m_is_end;  ///< [crossing] whether it is the next one of another
    std::vector<std::int32_t> m_loop, m_other;
};

struct Vec2 {
    double x, y;
};

double twice_area(std::span<const Vec2> polygon) {
    double sum = 0;
    for (std::size_t n = 0; n < polygon.size(); ++n) {
        const Vec2 p = polygon[n], q = polygon[n + 1 < polygon.size() ? n + 1 : 0];
        sum += p.x * q.y - p.y * q.x;
    }
    return sum;
}

/// The face's polygon in two of its barycentric coordinates, counter-clockwise.
void project(const CutPart& part, const CutPart::Face& face, const std::array<int, 3>& corners,
             std::vector<Vec2>& polygon) {
    polygon.clear();
    for (const std::int32_t point : loop_of(part, face)) {
        const auto& w = part.points[std::size_t(point)].weights;
        polygon.push_back({w[std::size_t(corners[0])], w[std::size_t(corners[1])]});
    }
    if (twice_area(polygon) < 0) std::reverse(polygon.begin(), polygon.end());
}

/// Keeps the part of a polygon to the left of the line from a to b.
void clip(std::vector<Vec2>& polygon, Vec2 a, Vec2 b, std::vector<Vec2>& result) {
    const auto level = [&](Vec2 p) {
        return (b.x - a.x) * (p.y - a.y) - (b.y - a.y) * (p.x - a.x);
    };
    result.clear();
    for (std::size_t n = 0; n < polygon.size(); ++n) {
        const Vec2 p = polygon[n], q = polygon[n + 1 < polygon.size() ? n + 1 : 0];
        const double lp = level(p), lq = level(q);
        if (lp >= 0) result.push_back(p);
        if ((lp > 0 && lq < 0) || (lp < 0 && lq > 0)) {
            const double t = lp / (lp - lq);
            result.push_back({p.x + t * (q.x - p.x), p.y + t * (q.y - p.y)});
        }
    }
    polygon.swap(result);
}

}  // namespace

CutPart whole_part() {
    CutPart part;
    for (std::int32_t k = 0; k < 4; ++k) {
        part.points.push_back({{}, k});
        part.points.back().weights[std::size_t(k)] = 1;
    }
    static constexpr std::int32_t kFaces[4][3] = {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}};
    for (std::int32_t k = 0; k < 4; ++k) add_face(part, kFaces[k], k);
    return part;
}

double share_of(const CutPart& part) {
    return volume_from(part, unit_position(part.points[0].weights));
}

double side_area(const CutPart& part, int side) {
    double sum = 0;
    std::vector<Vec2> polygon;
    for (const CutPart::Face& face : part.faces) {
        if (face.side != side) continue;
        project(part, face, {(side + 1) % 4, (side + 2) % 4, (side + 3) % 4}, polygon);
        sum += twice_area(polygon);
    }
    return sum;
}

bool have_common_area(const CutPart& p, int p_side, const std::array<int, 3>& p_corners,
                      const CutPart& q, int q_side, const std::array<int, 3>& q_corners) {
    std::vector<Vec2> frame, polygon, scratch;
    for (const CutPart::Face& p_face : p.faces) {
        if (p_face.side != p_side) continue;
        project(p, p_face, p_corners, frame);
        if (twice_area(frame) <= kSmallestShare) continue;  // it would clip nothing
        for (const CutPart::Face& q_face : q.faces) {
            if (q_face.side != q_side) continue;
            project(q, q_face, q_corners, polygon);
            for (std::size_t n = 0; n < frame.size() && !polygon.empty(); ++n)
                clip(polygon, frame[n], frame[n + 1 < frame.size() ? n + 1 : 0], scratch);
            if (twice_area(polygon) > kSmallestShare) return true;
        }
    }
    return false;
}

double winding_number(const CutPart& part, const std::array<double, 4>& weights) {
    const Vec3d from = unit_position(weights);
    double sum = 0;
    for (const CutPart::Face& face : part.faces) {
        const Loop loop = loop_of(part, face);
        const auto position = [&](std::size_t n) {
            return unit_position(part.points[std::size_t(loop[n])].weights) - from;
        };
        for (std::size_t n = 1; n + 1 < loop.size(); ++n) {
            const Vec3d a = position(0), b = position(n), c = position(n + 1);
            const double la = norm(a), lb = norm(b), lc = norm(c);
            // Half of the solid angle [Oosterom1983].
            sum += std::atan2(dot(a, cross(b, c)),
                              la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb);
        }
    }
    return sum / (2 * std::numbers::pi);
}

int find_components(const CutPart& part, std::vector<std::int32_t>& component_of) {
    std::vector<std::int32_t>& parent = component_of;
    parent.resize(part.points.size());
    for (std::size_t n = 0; n < parent.size(); ++n) parent[n] = std::int32_t(n);
    const auto root = [&](std::int32_t n) {
        while (parent[std::size_t(n)] != n) n = parent[std::size_t(n)];
        return n;
    };
    for_each_edge(part, [&](std::int32_t a, std::int32_t b) {
        if (crossing_at(part, a, b)) return;
        const std::int32_t p = root(a), q = root(b);
        parent[std::size_t(std::max(p, q))] = std::min(p, q);
    });
    int count = 0;
    // A root comes before all others of its component.
    for (std::size_t n = 0; n < parent.size(); ++n)
        parent[n] = parent[n] == std::int32_t(n) ? count++ : parent[std::size_t(parent[n])];
    return count;
}

std::vector<CutPart> split(CutPart part) {
    std::vector<std::int32_t> labels;
    const int count = find_components(part, labels);
    std::vector<CutPart> parts;
    for (std::int32_t label = 0; label + 1 < count; ++label) {
        Splitter splitter(part, labels, label);
        if (!splitter.run()) return {};
        parts.push_back(std::move(splitter.first().part));
        CutPart rest = std::move(splitter.second().part);
        labels = std::move(splitter.second().labels);
        // Chords and caps between the components that are left are crossed as well, half way.
        std::vector<CutPart::Crossing> more;
        for_each_edge(rest, [&](std::int32_t a, std::int32_t b) {
            if (labels[std::size_t(a)] != labels[std::size_t(b)] && !crossing_at(rest, a, b))
                more.push_back({a, b, 0.5});
        });
        rest.begun.insert(rest.begun.end(), more.begin(), more.end());
        part = std::move(rest);
    }
    parts.push_back(std::move(part));
    return parts;
}

}  // namespace pliant
