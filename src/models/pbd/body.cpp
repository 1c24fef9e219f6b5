// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include <pliant/models/pbd.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <utility>

#include "base/errors.h"
#include "pbd/arithmetic.h"
#include "pbd/ogden.h"
#include "pbd/rollback.h"
#include "pbd/solver.h"
#include "pbd/volume_change.h"

namespace pliant {
namespace {

using B = PbdSettings;
using X = PbdBoxSettings;

constexpr Setting<B> kBody[] = {
    setting<&B::time_step>({.name = "time_step",
                            .range = {.low = 0},
                            .above_low = true,
                            .text = "duration of a step"}),
    setting<&B::sub_steps>(
        {.name = "sub_steps", .range = {.low = 1}, .text = "sub-steps of a step"}),
    setting<&B::iterations>({.name = "iterations",
                             .range = {.low = 1},
                             .text = "visits of each constraint in a sub-step"}),
    setting<&B::gravity>({.name = "gravity", .text = "acceleration of all particles"}),
    setting<&B::damping>({.name = "damping",
                          .range = {.low = 0},
                          .text = "of velocities [1/time]; at most one over the sub-step"}),
    setting<&B::method>({.name = "method",
                         .choices = "compliance|stiffness",
                         .text = "XPBD with compliance, or PBD with stiffness"}),
    setting<&B::precision>(
        {.name = "precision", .choices = "float|double", .text = "of the arithmetic"}),
    setting<&B::vectors>(
        {.name = "vectors", .text = "vector instructions; the scalar code gives the same bits"}),
    setting<&B::domain_particles>(
        {.name = "domain_particles", .range = {.low = 1}, .text = "particles per domain"}),
    setting<&B::alternates>({.name = "alternates",
                             .text = "every second iteration visits the constraints in the "
                                     "opposite order"}),
    setting<&B::volume_recovery>({.name = "volume_recovery",
                                  .range = {.low = 0},
                                  .text =
                                      "rate [1/time] at which hard volumes recover under a lasting "
                                      "load; at most the damping"}),
    setting<&B::repacks>(
        {.name = "repacks", .text = "repacks the free constraints if many particles are held"}),
    setting<&B::warm_starts>(
        {.name = "warm_starts", .text = "sub-steps begin with the solids' forces in the last one"}),
};

constexpr Setting<X> kBoxes[] = {
    setting<&X::side>(
        {.name = "side", .range = {.low = 0}, .above_low = true, .text = "edge of a box"}),
    setting<&X::span>(
        {.name = "span", .text = "margin of a box on each side; negative: a third of its edge"}),
    setting<&X::blend_steps>(
        {.name = "blend_steps", .range = {.low = 1}, .text = "steps from held to movable"}),
    setting<&X::settled>({.name = "settled",
                          .range = {.low = 0},
                          .text = "a box rests if all its particles are within this distance of "
                                  "their rest positions"}),
};

}  // namespace

struct PbdBody::Impl {
    PbdParts parts;
    PbdSettings settings;
    pbd::Plan plan;
    std::unique_ptr<pbd::Solver> solver;
    double kept_time_step = 0;

    Status check_particle(const char* what, std::int32_t particle) const {
        if (particle >= 0 && std::size_t(particle) < parts.positions.size()) return Ok{};
        return Error{ErrorCode::InvalidArgument, std::string(what) +
                                                     ": expected a particle below " +
                                                     std::to_string(parts.positions.size()) +
                                                     ", found " + std::to_string(particle)};
    }
};

PbdBody::PbdBody(std::unique_ptr<Impl> impl) : m_impl(std::move(impl)) {}
PbdBody::~PbdBody() = default;
PbdBody::PbdBody(PbdBody&&) noexcept = default;
PbdBody& PbdBody::operator=(PbdBody&&) noexcept = default;

Result<PbdBody> PbdBody::create(PbdParts parts, const PbdSettings& settings) {
    return attempt([&]() -> Result<PbdBody> {
        if (const Status s = pbd::check_settings(settings); !s.ok()) return s.error();
        if (const Status s = pbd::check_parts(parts, settings.method); !s.ok()) return s.error();
        auto impl = std::make_unique<Impl>();
        impl->parts = std::move(parts);
        impl->settings = settings;
        impl->plan = pbd::make_plan(impl->parts, settings.domain_particles);
        impl->solver = pbd::make_solver(impl->parts, impl->settings, impl->plan);
        return PbdBody(std::move(impl));
    });
}

const PbdParts& PbdBody::parts() const {
    return m_impl->parts;
}

const PbdSettings& PbdBody::settings() const {
    return m_impl->settings;
}

Status PbdBody::set_time_step(double time_step) {
    PbdSettings changed = m_impl->settings;
    changed.time_step = time_step;
    if (const Status s = pbd::check_settings(changed); !s.ok()) return s;
    m_impl->settings.time_step = time_step;
    return Ok{};
}

Status PbdBody::step(std::int32_t count, const TaskArena& arena) {
    if (count < 0)
        return Error{ErrorCode::InvalidArgument,
                     "step: expected 0 steps or more, found " + std::to_string(count)};
    // The solver allocates before any motion, if at all.
    return attempt([&]() -> Status {
        for (std::int32_t n = 0; n < count; ++n)
            if (const Status s = m_impl->solver->step(arena); !s.ok()) return s;
        return Ok{};
    });
}

void PbdBody::recall_forces(std::int32_t trials) noexcept {
    m_impl->solver->recall_forces(trials);
}

double wave_sub_steps(const PbdParts& parts, double duration) {
    constexpr double kStiffness = 1.4;  // of the median solid: q of pbd.md, in a sub-step
    using StiffnessAndVolume = std::pair<double, double>;
    std::map<std::pair<double, double>, std::vector<StiffnessAndVolume>> by_material;
    for (const PbdSolid& solid : parts.solids) {
        const pbd::SolidNumbers s = pbd::solid_numbers(parts, solid);
        const auto weight = [&](std::size_t n) {
            return parts.inverse_masses[std::size_t(solid.nodes[n])];
        };
        Vec3d sum{0, 0, 0};  // of the gradients of the last three corners, that of the first is −
        double weights = 0;
        for (std::size_t n = 0; n < 3; ++n) {
            const Vec3d g{s.inverse[3 * n], s.inverse[3 * n + 1], s.inverse[3 * n + 2]};
            sum = sum + g;
            weights += weight(n + 1) * dot(g, g);
        }
        weights += weight(0) * dot(sum, sum);
        if (!(weights > 0)) continue;
        const double bulk = 1 / s.h_compliance + 2 / (3 * s.e_compliance);
        by_material[{solid.young_modulus, solid.poisson_ratio}].push_back(
            {bulk * weights, pbd::tetrahedron_volume(solid.nodes, parts.positions)});
    }
    double most = 1;
    for (auto& [material, solids] : by_material) {
        std::sort(solids.begin(), solids.end());
        double left = 0;
        for (const auto& [stiffness, volume] : solids) left += volume / 2;
        auto median = solids.begin();
        for (; median + 1 != solids.end() && median->second < left; ++median)
            left -= median->second;
        most = std::max(most, duration * std::sqrt(median->first / kStiffness));
    }
    return most;
}

std::int32_t PbdBody::particle_count() const {
    return std::int32_t(m_impl->parts.positions.size());
}
Vec3d PbdBody::position(std::int32_t particle) const {
    PLIANT_ASSERT(particle >= 0 && particle < particle_count());
    return m_impl->solver->position(particle);
}
Vec3d PbdBody::velocity(std::int32_t particle) const {
    PLIANT_ASSERT(particle >= 0 && particle < particle_count());
    return m_impl->solver->velocity(particle);
}
double PbdBody::inverse_mass(std::int32_t particle) const {
    PLIANT_ASSERT(particle >= 0 && particle < particle_count());
    return m_impl->solver->inverse_mass(particle);
}
void PbdBody::get_positions(std::span<Vec3d> positions) const {
    PLIANT_ASSERT(std::int32_t(positions.size()) == particle_count());
    for (std::size_t n = 0; n < positions.size(); ++n) positions[n] = position(std::int32_t(n));
}

Status PbdBody::set_state(std::int32_t particle, Vec3d position, Vec3d velocity) {
    if (const Status s = m_impl->check_particle("set_state", particle); !s.ok()) return s;
    if (const Status s = pbd::check_state(position, velocity); !s.ok()) return s;
    return attempt([&]() -> Status {
        m_impl->solver->set_state(particle, position, velocity);
        return Ok{};
    });
}
Status PbdBody::set_inverse_mass(std::int32_t particle, double inverse_mass) {
    if (const Status s = m_impl->check_particle("set_inverse_mass", particle); !s.ok()) return s;
    if (const Status s = pbd::check_inverse_mass("set_inverse_mass: particle",
                                                 std::size_t(particle), inverse_mass);
        !s.ok())
        return s;
    m_impl->solver->set_inverse_mass(particle, inverse_mass);
    return Ok{};
}
Status PbdBody::load(std::span<const std::int32_t> particles, std::span<const Vec3d> forces) {
    if (particles.size() != forces.size())
        return Error{ErrorCode::InvalidArgument,
                     "load: expected a force for each of " + std::to_string(particles.size()) +
                         " particles, found " + std::to_string(forces.size())};
    for (std::size_t n = 0; n < particles.size(); ++n) {
        if (const Status s = m_impl->check_particle("load", particles[n]); !s.ok()) return s;
        if (!is_finite(forces[n]))
            return Error{ErrorCode::InvalidArgument,
                         "load: expected three numbers as the force on particle " +
                             std::to_string(particles[n])};
    }
    return attempt([&]() -> Status {
        m_impl->solver->load(particles, forces);
        return Ok{};
    });
}
Status PbdBody::move_attachment(std::int32_t attachment, Vec3d target) {
    auto& all = m_impl->parts.attachments;
    if (attachment < 0 || std::size_t(attachment) >= all.size())
        return Error{ErrorCode::InvalidArgument, "move_attachment: expected an attachment below " +
                                                     std::to_string(all.size()) + ", found " +
                                                     std::to_string(attachment)};
    if (!is_finite(target))
        return Error{ErrorCode::InvalidArgument, "move_attachment: expected three numbers"};
    all[std::size_t(attachment)].target = target;
    return Ok{};
}

double PbdBody::multiplier(PbdKind kind, std::int32_t constraint) const {
    PLIANT_ASSERT(kind != PbdKind::Solid);
    return m_impl->solver->multiplier(int(kind), constraint, 0);
}
Vec3d PbdBody::attachment_force(std::int32_t attachment) const {
    return m_impl->solver->attachment_force(attachment);
}

std::vector<Vec3d> PbdBody::constraint_forces() const {
    const PbdParts& parts = m_impl->parts;
    const pbd::Solver& solver = *m_impl->solver;
    std::vector<Vec3d> forces(parts.positions.size(), Vec3d{0, 0, 0});
    const auto add = [&](std::int32_t node, double s, const pbd::Triple<double>& g) {
        Vec3d& f = forces[std::size_t(node)];
        f = f + s * Vec3d{g.x, g.y, g.z};
    };
    const auto corners = [&](std::span<const std::int32_t> nodes, pbd::Corner<double>(&p)[4]) {
        for (std::size_t n = 0; n < nodes.size(); ++n) {
            const Vec3d x = solver.position(nodes[n]);
            p[n] = {{x.x, x.y, x.z}, 0};
        }
    };
    for (int kind = 0; kind < pbd::kKinds; ++kind)
        for (std::size_t c = 0; c < pbd::constraint_count(parts, kind); ++c) {
            const auto nodes = pbd::nodes_of(parts, kind, c);
            const double lambda = solver.multiplier(kind, std::int32_t(c), 0);
            pbd::Corner<double> p[4];
            corners(nodes, p);
            if (PbdKind(kind) == PbdKind::Distance) {
                const Vec3d d = position(nodes[0]) - position(nodes[1]);
                const double length = norm(d);
                if (!(length > 0)) continue;
                add(nodes[0], lambda / length, {d.x, d.y, d.z});
                add(nodes[1], -lambda / length, {d.x, d.y, d.z});
            } else if (PbdKind(kind) == PbdKind::Solid && m_impl->settings.warm_starts) {
                const auto f = solver.solid_forces(std::int32_t(c));
                for (std::size_t n = 0; n < 3; ++n) {
                    add(nodes[n + 1], 1, {f[n].x, f[n].y, f[n].z});
                    add(nodes[0], -1, {f[n].x, f[n].y, f[n].z});
                }
            } else if (PbdKind(kind) == PbdKind::Solid) {
                const pbd::SolidNumbers numbers = pbd::solid_numbers(parts, parts.solids[c]);
                pbd::Solid<double> s{};
                for (int n = 0; n < 9; ++n) s.inverse[n / 3][n % 3] = numbers.inverse[n];
                const auto g = numbers.ogden_alpha == 0
                                   ? pbd::solid_constraints(p, s)
                                   : pbd::ogden_constraints(p, pbd::ogden_solid(numbers));
                const double other = solver.multiplier(kind, std::int32_t(c), 1);
                for (std::size_t n = 0; n < 4; ++n) {
                    add(nodes[n], lambda, g.gh[n]);
                    add(nodes[n], other, g.ge[n]);
                }
            } else {
                const auto g = PbdKind(kind) == PbdKind::Bend ? pbd::bend_constraint(p, 0.0)
                                                              : pbd::volume_constraint(p, 0.0);
                for (std::size_t n = 0; n < 4; ++n) add(nodes[n], lambda, g.g[n]);
            }
        }
    return forces;
}

std::uint64_t PbdBody::hash() const {
    return m_impl->solver->hash();
}

void PbdRollback::reserve(PbdBody& body) {
    body.m_impl->solver->reserve_kept();
}
void PbdRollback::keep(PbdBody& body) noexcept {
    body.m_impl->kept_time_step = body.m_impl->settings.time_step;
    body.m_impl->solver->keep();
}
void PbdRollback::take_back(PbdBody& body) noexcept {
    body.m_impl->settings.time_step = body.m_impl->kept_time_step;
    body.m_impl->solver->take_back();
}
void PbdRollback::put_all(PbdBody& body, std::span<const Vec3d> positions,
                          std::span<const Vec3d> velocities) noexcept {
    body.m_impl->solver->put_all(positions, velocities);
}

VolumeChange volume_change(const PbdParts& parts, std::span<const Vec3d> positions) {
    PLIANT_ASSERT(positions.size() == parts.positions.size());
    return pbd::volume_change_of(parts, [&](std::int32_t n) { return positions[std::size_t(n)]; });
}

// The tables of settings of bodies and boxes. Units are any consistent set.

SettingRows<PbdSettings> pbd_rows() noexcept {
    return kBody;
}
SettingRows<PbdBoxSettings> pbd_box_rows() noexcept {
    return kBoxes;
}

}  // namespace pliant
