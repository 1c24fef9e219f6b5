// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A sub-step: the body's own one, then contact in strides (tool_contact.h), the last of which
// includes the pieces (piece_contact.h). All touches are projected one after the other, those of
// tools last, until no depth is left or the iterations are used up. A node's velocity changes as if
// it had moved by contact during the sub-step.

#include <pliant/models/body_contact.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "base/errors.h"
#include "pbd/piece_contact.h"
#include "pbd/rollback.h"
#include "pbd/tool_contact.h"

namespace pliant {
namespace {

using ContactRows = BodyContactSettings;

constexpr Setting<ContactRows> kContact[] = {
    setting<&ContactRows::friction>(
        {.name = "friction", .range = {.low = 0}, .text = "Coulomb friction coefficient"}),
    setting<&ContactRows::iterations>({.name = "iterations",
                                       .range = {.low = 1},
                                       .text = "over all touches of a sub-step, at most"}),
    setting<&ContactRows::gap>(
        {.name = "gap",
         .range = {.low = 0},
         .text = "distance that pieces keep, unless they are nearer at rest"}),
    setting<&ContactRows::recovery_speed>(
        {.name = "recovery_speed",
         .range = {.low = 0},
         .above_low = true,
         .text = "speed at which overlaps that exist before a step are resolved"}),
    setting<&ContactRows::touched_mass>(
        {.name = "touched_mass",
         .range = {.low = 1},
         .text = "factor of the mass of nodes that a tool touches, during "
                 "the body's solution"}),
};

constexpr int kMaxStrides = 2048;        ///< of a sub-step
constexpr double kMaxRadii = 1000;       ///< motion of a tool in a sub-step
constexpr double kStride = 0.5;          ///< approach in a stride, in radii
constexpr double kStuck = 0.4;           ///< depth with which no stride begins, in radii
constexpr double kToolTolerance = 1e-3;  ///< depth that may remain, in radii
constexpr double kTiny = 0.1;            ///< shift that moves no other touch, in slops
constexpr double kTouching = 1.002;      ///< distance within which nodes are touched [radii]

std::vector<Vec3d> positions_of(const pbd::BodySurface& surface, const TetMesh& mesh) {
    std::vector<Vec3d> x;
    for (const std::int32_t p : surface.particles()) x.push_back(mesh.nodes_mm[std::size_t(p)]);
    return x;
}

/// A node and the nearest triangle of another piece. C = Σ shares·x·normal − limit
struct PieceRow {
    std::array<std::int32_t, 4> nodes;  ///< the node, and those of the triangle
    std::array<double, 4> shares;       ///< 1, and minus the triangle's weights
    std::array<double, 4> moves;        ///< of the nodes by a unit impulse: shares / mass
    Vec3d normal, apart;                ///< apart: Σ shares·x at the start of the sub-step
    double limit, weight;               ///< weight: Σ shares² / mass
    double push;
    Vec3d drag;
    std::int32_t piece_of_node, piece_of_triangle;  ///< indices
    std::int64_t seen = -1;                         ///< shifts of nodes when it was last projected

    Vec3d apart_at(std::span<const Vec3d> x) const {
        Vec3d d = x[std::size_t(nodes[0])];
        for (std::size_t k = 1; k < 4; ++k) d = d + shares[k] * x[std::size_t(nodes[k])];
        return d;
    }
};

Status check_tool(const BodyTool& start, const BodyTool& end, std::int32_t count,
                  const std::string& name) {
    if (!is_finite(start.from) || !is_finite(start.to) || !is_finite(end.from) ||
        !is_finite(end.to))
        return invalid(name + ": expected finite positions");
    if (!(std::isfinite(start.radius) && start.radius > 0))
        return invalid(name + ": expected a radius above 0, found " + std::to_string(start.radius));
    if (start.radius != end.radius)
        return invalid(name + ": expected the same radius at the start and at the end, found " +
                       std::to_string(start.radius) + " and " + std::to_string(end.radius));
    const double moved = std::max(norm(end.from - start.from), norm(end.to - start.to));
    if (!(moved <= kMaxRadii * start.radius * count))
        return invalid(name + ": expected a motion of at most 1000 radii in a step, found " +
                       std::to_string(moved / count) + " at a radius of " +
                       std::to_string(start.radius));
    return Ok{};
}

}  // namespace

SettingRows<BodyContactSettings> body_contact_rows() noexcept {
    return kContact;
}

struct BodyContact::Impl {
    Impl(const TetMesh& mesh, std::span<const std::int32_t> numbers, const BodyContactSettings& s)
        : settings(s),
          particle_count(mesh.nodes_mm.size()),
          surface(mesh, numbers),
          start(positions_of(surface, mesh)),
          free(start),
          boxes(surface),
          pieces(surface, start, s.gap),
          masses(start.size(), 0),
          shifts(start.size()),
          share_of(start.size(), 0),
          kept_x(particle_count),
          kept_v(particle_count) {
        motion.friction = s.friction;
        motion.tiny = kTiny * pieces.slop();
        motion.shifted_at.assign(start.size(), 0);
        motion.x = motion.before = start;
        motion.tool_w.assign(start.size(), 0);
        touched.reserve(start.size());
        found.reserve(start.size());
        rows.reserve(start.size());
        piece_numbers.assign(numbers.begin(), numbers.end());
        std::sort(piece_numbers.begin(), piece_numbers.end());
        piece_numbers.erase(std::unique(piece_numbers.begin(), piece_numbers.end()),
                            piece_numbers.end());
        piece_sums.assign(piece_numbers.size(), {0, 0, 0});
        piece_forces = piece_sums;
        for (const pbd::Patch& patch : surface.patches())
            for (std::int32_t t = patch.begin; t < patch.end; ++t)
                index_of_triangle.push_back(std::int32_t(index_of(patch.piece)));
        for (const std::int32_t piece : surface.pieces())
            index_of_node.push_back(std::int32_t(index_of(piece)));
    }

    struct Touched {
        std::int32_t node;
        double inverse_mass;
    };

    BodyContactSettings settings;
    std::size_t particle_count;
    pbd::BodySurface surface;
    std::vector<Vec3d> start, free;  ///< at the start of the sub-step; after the body's own one
    pbd::PatchBoxes boxes;
    pbd::PieceContact pieces;
    pbd::ToolContact tools;
    pbd::SurfaceMotion motion;
    std::vector<pbd::PieceTouch> found;
    std::vector<PieceRow> rows;
    std::vector<pbd::ToolMotion> moving;
    std::vector<Touched> touched;                 ///< nodes whose masses are changed
    std::vector<double> masses;                   ///< [node]: inverse, in this call
    std::vector<Vec3d> shifts;                    ///< [node]: displacement by contact
    std::vector<double> share_of;                 ///< [node]: largest weight in a touch of a tool
    std::vector<Vec3d> kept_x, kept_v;            ///< [particle]: before the call
    std::vector<Vec3d> sums, forces;              ///< [tool]: during the call, and after it
    std::vector<std::int32_t> piece_numbers;      ///< sorted
    std::vector<Vec3d> piece_sums, piece_forces;  ///< [index in piece_numbers]
    std::vector<std::int32_t> index_of_triangle, index_of_node;
    double depth = 0, depth_left = 0;
    std::int64_t touch_count = 0, touches = 0;

    Status steps(std::int32_t count, PbdBody& body, std::span<const BodyTool> at_start,
                 std::span<const BodyTool> at_end, const TaskArena& arena);
    Status sub_step(PbdBody& body, std::span<const BodyTool> at_start,
                    std::span<const BodyTool> at_end, double from, double to,
                    const TaskArena& arena);
    void read(const PbdBody& body, std::vector<Vec3d>& to) const {
        for (std::size_t n = 0; n < to.size(); ++n) to[n] = body.position(surface.particles()[n]);
    }
    void place_tools(std::span<const BodyTool> at_start, std::span<const BodyTool> at_end,
                     double from, double to, double recovered);
    std::size_t index_of(std::int32_t piece) const {
        return std::size_t(std::lower_bound(piece_numbers.begin(), piece_numbers.end(), piece) -
                           piece_numbers.begin());
    }
    Status weigh_down(PbdBody& body);
    void let_up(PbdBody& body) noexcept;
    int stride_count() const;
    void see_masses(const PbdBody& body);
    void find_pieces(double recovered, const TaskArena& arena);
    double project_pieces();
    void solve(const PbdBody& body, int strides, double recovered, const TaskArena& arena);
    Status write(PbdBody& body, double h);
    void measure(std::span<const BodyTool> at_start, std::span<const BodyTool> at_end, double to);
};

/// Puts each tool where it was and is, or further out if it overlaps the body.
void BodyContact::Impl::place_tools(std::span<const BodyTool> at_start,
                                    std::span<const BodyTool> at_end, double from, double to,
                                    double recovered) {
    moving.clear();
    for (std::size_t n = 0; n < at_start.size(); ++n) {
        pbd::ToolMotion tool{pbd::tool_at(at_start[n], at_end[n], from),
                             pbd::tool_at(at_start[n], at_end[n], to)};
        const double tolerated = std::min(recovered, 0.25 * tool.start.radius);
        const pbd::ToolDepth depth_now =
            pbd::depth_of(surface, boxes, start, tool.start, tolerated);
        if (depth_now.out != Vec3d{0, 0, 0}) {
            const Vec3d shift = (depth_now.depth - tolerated) * depth_now.out;
            for (BodyTool* each : {&tool.start, &tool.end}) {
                each->from = each->from + shift;
                each->to = each->to + shift;
            }
            const pbd::ToolDepth shifted =
                pbd::depth_of(surface, boxes, start, tool.start, kStuck * tool.start.radius);
            tool.is_stuck = shifted.crosses || shifted.out != Vec3d{0, 0, 0};
        }
        moving.push_back(tool);
    }
}

/// Makes nodes that tools touch heavier, until let_up().
Status BodyContact::Impl::weigh_down(PbdBody& body) {
    touched.clear();
    if (settings.touched_mass == 1) return Ok{};
    tools.look(surface, boxes, start, moving, 0);
    tools.for_touched(surface, start, kTouching, [&](std::int32_t n, double weight) {
        double& share = share_of[std::size_t(n)];
        if (share == 0 && weight > 0)
            touched.push_back({n, body.inverse_mass(surface.particles()[std::size_t(n)])});
        share = std::max(share, weight);
    });
    Status status = Ok{};
    for (const Touched& t : touched) {
        double& share = share_of[std::size_t(t.node)];
        if (status.ok())
            status = body.set_inverse_mass(
                surface.particles()[std::size_t(t.node)],
                t.inverse_mass / (1 + (settings.touched_mass - 1) * std::min(1.0, share)));
        share = 0;
    }
    return status;
}

void BodyContact::Impl::let_up(PbdBody& body) noexcept {
    for (const Touched& t : touched)
        (void)body.set_inverse_mass(surface.particles()[std::size_t(t.node)], t.inverse_mass);
    touched.clear();
}

/// Strides such that no tool and node approach by more than half of a radius in one of them.
int BodyContact::Impl::stride_count() const {
    double farthest = 0;
    for (std::size_t n = 0; n < free.size(); ++n) {
        const Vec3d by = free[n] - start[n];
        farthest = std::max(farthest, dot(by, by));
    }
    farthest = std::sqrt(farthest);
    double strides = 1;
    for (const pbd::ToolMotion& tool : moving) {
        mesh::Bounds way;
        for (const BodyTool* each : {&tool.start, &tool.end}) {
            way.add(each->from);
            way.add(each->to);
        }
        way = pbd::grown(way, 2 * tool.start.radius + farthest);
        double nearest = 0;
        for (std::size_t p = 0; p < surface.patches().size(); ++p) {
            if (!pbd::overlap(way, boxes.box(p))) continue;
            for (const std::int32_t n : surface.nodes_of(p))
                nearest = std::max(nearest, norm(free[std::size_t(n)] - start[std::size_t(n)]));
        }
        const double moved =
            std::max(norm(tool.end.from - tool.start.from), norm(tool.end.to - tool.start.to));
        strides = std::max(strides, std::ceil((moved + nearest) / (kStride * tool.start.radius)));
    }
    return int(std::min(strides, double(kMaxStrides)));
}

void BodyContact::Impl::see_masses(const PbdBody& body) {
    tools.for_nodes(surface, [&](std::int32_t n) {
        motion.tool_w[std::size_t(n)] = body.inverse_mass(surface.particles()[std::size_t(n)]);
    });
}

/// Finds the touches of pieces.
void BodyContact::Impl::find_pieces(double recovered, const TaskArena& arena) {
    pieces.find(surface, start, motion.x, arena, found);
    for (const pbd::PieceTouch& touch : found) {
        const auto& t = surface.triangles()[std::size_t(touch.triangle)];
        PieceRow row{{touch.node, t[0], t[1], t[2]},
                     {1, -touch.weights[0], -touch.weights[1], -touch.weights[2]},
                     {},
                     touch.normal,
                     touch.apart,
                     // An overlap that existed before is resolved over several sub-steps.
                     std::min(touch.limit, dot(touch.apart, touch.normal) + recovered),
                     0,
                     0,
                     {0, 0, 0},
                     index_of_node[std::size_t(touch.node)],
                     index_of_triangle[std::size_t(touch.triangle)]};
        for (std::size_t k = 0; k < 4; ++k) {
            row.moves[k] = row.shares[k] * masses[std::size_t(row.nodes[k])];
            row.weight += row.shares[k] * row.moves[k];
        }
        if (row.weight > 0) rows.push_back(row);
    }
}

/// Projects the touches whose nodes have moved since their last projection.
double BodyContact::Impl::project_pieces() {
    double deepest = 0;
    const std::vector<std::int64_t>& shifted_at = motion.shifted_at;
    for (PieceRow& row : rows) {
        std::int64_t last = 0;
        for (const std::int32_t n : row.nodes) last = std::max(last, shifted_at[std::size_t(n)]);
        if (last <= row.seen) continue;
        Vec3d apart = row.apart_at(motion.x);
        const double lacking = row.limit - dot(apart, row.normal);
        deepest = std::max(deepest, lacking);
        const double push = std::max(0.0, row.push + lacking / row.weight);
        Vec3d impulse = (push - row.push) * row.normal;
        row.push = push;
        if (settings.friction > 0) {
            apart = apart + row.weight * impulse;
            Vec3d slid = apart - row.apart;
            slid = slid - dot(slid, row.normal) * row.normal;
            Vec3d drag = row.drag - (1 / row.weight) * slid;
            const double size = norm(drag), most = settings.friction * push;
            if (size > most) drag = (most / size) * drag;
            impulse = impulse + (drag - row.drag);
            row.drag = drag;
        }
        if (impulse != Vec3d{0, 0, 0})
            for (std::size_t k = 0; k < 4; ++k) motion.move(row.nodes[k], row.moves[k] * impulse);
        row.seen = motion.shifts;
    }
    return deepest;
}

/// All strides of a sub-step. @pre free, start and boxes are known
void BodyContact::Impl::solve(const PbdBody& body, int strides, double recovered,
                              const TaskArena& arena) {
    std::fill(shifts.begin(), shifts.end(), Vec3d{0, 0, 0});
    motion.before = start;
    for (int s = 1; s <= strides; ++s) {
        const double share = double(s) / strides;
        const auto without = [&](std::size_t n) {
            return s == strides ? free[n] : (1 - share) * start[n] + share * free[n];
        };
        if (s > 1) motion.before = motion.x;
        for (std::size_t n = 0; n < free.size(); ++n) motion.x[n] = shifts[n] + without(n);
        if (!moving.empty()) boxes.update(surface, motion.x);
        tools.look(surface, boxes, motion.x, moving, share);
        see_masses(body);
        rows.clear();
        if (s == strides) find_pieces(recovered, arena);
        for (int i = 0; i < settings.iterations; ++i) {
            const double pieces_depth = project_pieces();
            const double tools_depth = tools.project(surface, motion, moving, strides);
            if (pieces_depth <= pieces.slop() && tools_depth <= kToolTolerance) break;
        }
        for (std::size_t n = 0; n < free.size(); ++n) shifts[n] = motion.x[n] - without(n);
    }
}

Status BodyContact::Impl::write(PbdBody& body, double h) {
    for (std::size_t n = 0; n < shifts.size(); ++n) {
        if (shifts[n] == Vec3d{0, 0, 0}) continue;
        const std::int32_t p = surface.particles()[n];
        if (const Status s = body.set_state(p, motion.x[n], body.velocity(p) + (1 / h) * shifts[n]);
            !s.ok())
            return s;
    }
    return Ok{};
}

void BodyContact::Impl::measure(std::span<const BodyTool> at_start,
                                std::span<const BodyTool> at_end, double to) {
    depth = 0;
    touch_count = tools.touches();
    for (const PieceRow& row : rows) {
        const std::int32_t piece = piece_numbers[std::size_t(row.piece_of_triangle)];
        depth = std::max(depth, pieces.limit_of(row.nodes[0], piece) + pieces.slop() -
                                    dot(row.apart_at(motion.x), row.normal));
        touch_count += row.push > 0;
    }
    for (std::size_t n = 0; n < at_start.size(); ++n)
        depth = std::max(depth, pbd::depth_of(surface, boxes, motion.x,
                                              pbd::tool_at(at_start[n], at_end[n], to), 0)
                                    .depth);
}

Status BodyContact::Impl::sub_step(PbdBody& body, std::span<const BodyTool> at_start,
                                   std::span<const BodyTool> at_end, double from, double to,
                                   const TaskArena& arena) {
    const double h = body.settings().time_step, recovered = settings.recovery_speed * h;
    read(body, start);
    if (!at_start.empty()) boxes.update(surface, start);
    place_tools(at_start, at_end, from, to, recovered);
    if (const Status s = weigh_down(body); !s.ok()) return s;
    if (const Status s = body.step(1, arena); !s.ok()) return s;
    read(body, free);
    if (!at_start.empty()) boxes.update(surface, free);
    solve(body, stride_count(), recovered, arena);
    let_up(body);
    if (const Status s = write(body, h); !s.ok()) return s;
    for (std::size_t n = 0; n < moving.size(); ++n)
        sums[n] = sums[n] + (1 / (h * h)) * moving[n].impulse;
    for (const PieceRow& row : rows) {
        const Vec3d force = (1 / (h * h)) * (row.push * row.normal + row.drag);
        Vec3d& on = piece_sums[std::size_t(row.piece_of_node)];
        Vec3d& back = piece_sums[std::size_t(row.piece_of_triangle)];
        on = on + force;
        back = back - force;
    }
    return Ok{};
}

Status BodyContact::Impl::steps(std::int32_t count, PbdBody& body,
                                std::span<const BodyTool> at_start,
                                std::span<const BodyTool> at_end, const TaskArena& arena) {
    sums.assign(at_start.size(), Vec3d{0, 0, 0});
    forces.reserve(sums.size());
    std::fill(piece_sums.begin(), piece_sums.end(), Vec3d{0, 0, 0});
    for (std::size_t n = 0; n < kept_x.size(); ++n) {
        kept_x[n] = body.position(std::int32_t(n));
        kept_v[n] = body.velocity(std::int32_t(n));
    }
    for (std::size_t n = 0; n < masses.size(); ++n)
        masses[n] = body.inverse_mass(surface.particles()[n]);
    const Status status = attempt([&]() -> Status {
        for (std::int32_t n = 0; n < count; ++n)
            if (const Status s = sub_step(body, at_start, at_end, double(n) / count,
                                          double(n + 1) / count, arena);
                !s.ok())
                return s;
        if (!at_start.empty()) boxes.update(surface, motion.x);
        measure(at_start, at_end, 1);
        return Ok{};
    });
    if (!status.ok()) {
        let_up(body);
        PbdRollback::put_all(body, kept_x, kept_v);
        return status;
    }
    forces.assign(sums.begin(), sums.end());
    for (Vec3d& force : forces) force = (1.0 / count) * force;
    for (std::size_t n = 0; n < piece_sums.size(); ++n)
        piece_forces[n] = (1.0 / count) * piece_sums[n];
    depth_left = depth;
    touches = touch_count;
    return Ok{};
}

BodyContact::BodyContact(std::unique_ptr<Impl> impl) : m_impl(std::move(impl)) {}
BodyContact::~BodyContact() = default;
BodyContact::BodyContact(BodyContact&&) noexcept = default;
BodyContact& BodyContact::operator=(BodyContact&&) noexcept = default;

Result<BodyContact> BodyContact::create(const TetMesh& mesh, std::span<const std::int32_t> numbers,
                                        const BodyContactSettings& settings) noexcept {
    return attempt([&]() -> Result<BodyContact> {
        if (const Status s = check(settings, body_contact_rows()); !s.ok()) return s.error();
        if (const Status s = check_cells(mesh); !s.ok()) return s.error();
        if (mesh.cells.empty()) return expected_error("mesh", "tetrahedra", "none");
        if (!numbers.empty() && numbers.size() != mesh.cells.size())
            return expected_error(
                "pieces",
                "a number for each of " + std::to_string(mesh.cells.size()) + " tetrahedra",
                std::to_string(numbers.size()));
        std::vector<std::int32_t> of_cells(numbers.begin(), numbers.end());
        if (of_cells.empty()) {
            const std::vector<std::int32_t> of_nodes = pieces(mesh);
            for (const auto& cell : mesh.cells) of_cells.push_back(of_nodes[std::size_t(cell[0])]);
        }
        for (std::size_t c = 0; c < of_cells.size(); ++c)
            if (of_cells[c] < 0)
                return expected_error(
                    "pieces", "numbers of 0 or more",
                    std::to_string(of_cells[c]) + " for tetrahedron " + std::to_string(c));
        return BodyContact(std::make_unique<Impl>(mesh, of_cells, settings));
    });
}

Status BodyContact::step(std::int32_t count, PbdBody& body, std::span<const BodyTool> at_start,
                         std::span<const BodyTool> at_end, const TaskArena& arena) noexcept {
    return attempt([&]() -> Status {
        if (count < 0)
            return invalid("step: expected 0 steps or more, found " + std::to_string(count));
        if (std::size_t(body.particle_count()) != m_impl->particle_count)
            return invalid("step: expected a body of " + std::to_string(m_impl->particle_count) +
                           " particles, found " + std::to_string(body.particle_count()));
        if (body.settings().sub_steps != 1)
            return invalid("sub_steps: expected 1, found " +
                           std::to_string(body.settings().sub_steps));
        if (at_start.size() != at_end.size())
            return invalid("step: expected as many tools at the end as at the start, found " +
                           std::to_string(at_end.size()) + " and " +
                           std::to_string(at_start.size()));
        if (count == 0) return Ok{};
        for (std::size_t n = 0; n < at_start.size(); ++n)
            if (const Status s =
                    check_tool(at_start[n], at_end[n], count, "tool " + std::to_string(n));
                !s.ok())
                return s;
        return m_impl->steps(count, body, at_start, at_end, arena);
    });
}

Vec3d BodyContact::force(std::size_t tool) const noexcept {
    return tool < m_impl->forces.size() ? m_impl->forces[tool] : Vec3d{0, 0, 0};
}
Vec3d BodyContact::piece_force(std::int32_t piece) const noexcept {
    const std::size_t index = m_impl->index_of(piece);
    if (index == m_impl->piece_numbers.size() || m_impl->piece_numbers[index] != piece)
        return {0, 0, 0};
    return m_impl->piece_forces[index];
}
double BodyContact::depth_left() const noexcept {
    return m_impl->depth_left;
}
std::int64_t BodyContact::touches() const noexcept {
    return m_impl->touches;
}

}  // namespace pliant
