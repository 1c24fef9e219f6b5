// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "base/units.h"
#include "catheter/scene_impl.h"
#include "catheter/state_numbers.h"
#include "pbd/solver.h"

#include <cmath>
#include <new>

#include "base/hash.h"
#include "base/text.h"
#include "pbd/volume_change.h"

namespace pliant {
namespace {

/// The state that a step changes.
struct CatheterState {
    CatheterCommand command;
    double inserted = 0, rotated = 0, depth = 0, sub_step_s = 0;
    std::int64_t steps = 0;
    std::int32_t awake = 0;
    catheter::RodWire wire;
    std::vector<Vec3d> positions, velocities;
    std::vector<std::int32_t> boxes;

    void exchange(catheter::StateNumbers& state) {
        for (double* v : {&command.insert_mm_s, &command.rotate_deg_s, &command.bend_first_deg,
                          &command.bend_second_deg, &inserted, &rotated, &depth, &sub_step_s})
            state.value(*v);
        state.whole(steps);
        state.whole(awake);
        wire.exchange(state);
        state.positions(positions);
        state.positions(velocities);
        state.wholes_to_the_end(boxes);
    }
};

}  // namespace

CatheterEntry entry_at(const VesselEnd& end, double inwards) {
    return {end.centre_mm - inwards * end.radius_mm * end.outward, -end.outward, 5};
}

std::vector<std::string> warnings_of(const CatheterMeasures& m) {
    constexpr double kBeyond_mm = 0.1;
    const auto rounded = [](double value) { return text_of(std::round(1e3 * value) / 1e3); };
    std::vector<std::string> warnings;
    if (m.depth_mm > kBeyond_mm) {
        const double yields_mm = m.contact_mm_per_n * m.largest_contact_n;
        warnings.push_back("the catheter is " + rounded(m.depth_mm) +
                           " mm beyond the wall, expected at most " + text_of(kBeyond_mm) + ": " +
                           (yields_mm > m.depth_mm / 2
                                ? "a contact of " + rounded(m.largest_contact_n) + " N yields by " +
                                      rounded(yields_mm) + " mm, lower contact_mm_per_n, " +
                                      short_text(m.contact_mm_per_n)
                                : "raise sub_steps"));
    }
    if (m.needed_sub_steps > catheter::kMaxSubSteps)
        warnings.push_back("sub_steps: expected at most " + std::to_string(catheter::kMaxSubSteps) +
                           " for the tip's bending and waves in the wall, found " +
                           std::to_string(m.needed_sub_steps) +
                           "; larger cells, longer segments, a shorter time_step_s or a softer or "
                           "heavier tip or wall need fewer");
    if (m.inverted > 0)
        warnings.push_back(std::to_string(m.inverted) +
                           (m.inverted == 1 ? " tetrahedron is" : " tetrahedra are") +
                           " inverted, expected none: raise sub_steps");
    if (m.left_end > 0)
        warnings.push_back("the tip has left the vessel through open end " +
                           std::to_string(m.left_end));
    return warnings;
}

/// Calls work with a function from a particle to its position: from a copy of all positions, or
/// without memory for that, one by one.
template <class Work>
void CatheterScene::Impl::with_positions(const Work& work) const {
    const auto count = std::size_t(body.particle_count());
    const std::unique_ptr<Vec3d[]> copied(new (std::nothrow) Vec3d[count]);
    if (!copied) return work([&](std::int32_t n) { return body.position(n); });
    body.get_positions({copied.get(), count});
    work([&](std::int32_t n) { return copied[std::size_t(n)]; });
}

template <class Position>
bool CatheterScene::Impl::has_moved(const Cell& cell, const Position& position) const {
    return std::any_of(cell.begin(), cell.end(),
                       [&](std::int32_t n) { return position(n) != rest_position(n); });
}

template <class Position>
std::int64_t CatheterScene::Impl::inverted_in_wall(const Position& position) const {
    std::int64_t inverted = 0;
    for (const Cell& cell : wall.mesh.cells)
        inverted += has_moved(cell, position) && !(pbd::volume_at(cell, position) > 0);
    return inverted;
}

template <class Position>
double CatheterScene::Impl::wall_energy(const Position& position) const {
    double elastic = 0;
    const bool has_energy = settings.wall.model == WallModel::Solid;
    const double e = settings.wall.young_modulus_pa, nu = settings.wall.poisson_ratio;
    const double mu = e / (2 * (1 + nu)), lambda = e * nu / ((1 + nu) * (1 - 2 * nu));
    for (const Cell& cell : wall.mesh.cells) {
        if (!has_energy || !has_moved(cell, position)) continue;
        const auto edges = [&](const auto& x) {
            const Vec3d from = x(cell[0]);
            return Mat3d{{x(cell[1]) - from, x(cell[2]) - from, x(cell[3]) - from}};
        };
        const Mat3d at_rest = edges([&](std::int32_t n) { return rest_position(n); }),
                    f = edges(position) * inverse(at_rest);
        const double j = determinant(f), volume = determinant(at_rest) / 6;
        double squares = 0;
        for (const Vec3d& c : f.columns) squares += dot(c, c);
        elastic += volume * 0.5 * (mu * (squares - 4 * j + j * j) + lambda * (j - 1) * (j - 1));
    }
    for (const PbdAttachment& at : body.parts().attachments) {
        const Vec3d off = position(at.nodes[0]) - at.target;
        elastic += 0.5 * dot(off, off) / at.compliance;
    }
    return elastic;
}

CatheterScene::CatheterScene(std::unique_ptr<Impl> impl) : m_impl(std::move(impl)) {}
CatheterScene::~CatheterScene() = default;
CatheterScene::CatheterScene(CatheterScene&&) noexcept = default;
CatheterScene& CatheterScene::operator=(CatheterScene&&) noexcept = default;

Result<CatheterScene> CatheterScene::create(VesselWall wall,
                                            const CatheterSettings& wanted) noexcept {
    return attempt([&] { return make(std::move(wall), wanted); });
}

Result<CatheterScene> CatheterScene::make(VesselWall wall, const CatheterSettings& wanted) {
    if (const Status s = catheter::check(wanted); !s.ok()) return s.error();
    if (const Status s = pbd::GhostSurface::check(wall.mesh, wall.ghost, wall.ghost_positions);
        !s.ok())
        return invalid("wall: " + s.error().message);
    auto ends = catheter::OpenEnds::create(wall);
    if (!ends) return invalid("wall: " + ends.error().message);
    if (const Status s = catheter::check_entry(wall, wanted.entry, wanted.catheter.segment_mm);
        !s.ok())
        return s.error();
    CatheterSettings settings = wanted;
    const std::int32_t needed = catheter::needed_sub_steps(wall, wanted);
    settings.sub_steps = std::min(needed, catheter::kMaxSubSteps);
    settings.catheter.contact_mm_per_n = catheter::contact_mm_per_n_of(wanted.catheter);
    auto body = catheter::body_of(wall, settings);
    if (!body) return body.error();
    std::unique_ptr<PbdBoxes> boxes;
    if (settings.local && settings.wall.model != WallModel::Rigid) {
        auto made = PbdBoxes::create(wall.mesh, {.side = settings.box_mm});
        if (!made) return made.error();
        boxes = std::make_unique<PbdBoxes>(std::move(*made));
    }
    auto impl =
        std::make_unique<Impl>(std::move(wall), settings, std::move(*body), std::move(*ends));
    impl->boxes = std::move(boxes);
    impl->needed_sub_steps = needed;
    return CatheterScene(std::move(impl));
}

const CatheterSettings& CatheterScene::settings() const {
    return m_impl->settings;
}
const VesselWall& CatheterScene::wall() const {
    return m_impl->wall;
}

Status CatheterScene::check_command(const CatheterCommand& c) {
    for (const double value : {c.insert_mm_s, c.rotate_deg_s, c.bend_first_deg, c.bend_second_deg})
        if (!std::isfinite(value)) return invalid("command: expected numbers");
    if (std::abs(c.insert_mm_s) > 1000)
        return invalid("command: insert_mm_s: expected -1000 to 1000, found " +
                       text_of(c.insert_mm_s));
    return Ok{};
}

Status CatheterScene::command(const CatheterCommand& c) noexcept {
    const Status status = attempt([&] { return check_command(c); });
    if (status.ok()) m_impl->command = c;
    return status;
}

const CatheterCommand& CatheterScene::hand() const {
    return m_impl->command;
}

Status CatheterScene::rig_tip(const std::optional<TipRig>& rig) noexcept {
    if (!rig) {
        m_impl->wire.rig_tip({});
        return Ok{};
    }
    return attempt([&]() -> Status {
        const TipHold held = rig->hold.value_or(TipHold{});
        const Rotation& q = held.frame;
        const double size = std::sqrt(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z);
        for (const Vec3d& v : {rig->force_n, rig->moment_n_mm, held.position_mm})
            if (!is_finite(v)) return invalid("tip: expected numbers, found " + text_of(v));
        if (!(std::abs(size - 1) < 1e-6))
            return invalid("tip: frame: expected a rotation of length 1, found " + text_of(size));
        m_impl->wire.rig_tip(catheter::WireRig{.force = kMicronewtonsPerNewton * rig->force_n,
                                               .moment = kMicronewtonsPerNewton * rig->moment_n_mm,
                                               .hold = rig->hold});
        return Ok{};
    });
}

Status CatheterScene::step(std::int32_t count, const TaskArena& arena) noexcept {
    for (std::int32_t n = 0; n < count; ++n)
        if (const Status s = m_impl->step(arena); !s.ok()) return s;
    return Ok{};
}

CatheterMeasures CatheterScene::quick_measures() const noexcept {
    const Impl& i = *m_impl;
    CatheterMeasures m;
    m.steps = i.now.steps;
    m.time_s = double(i.now.steps) * i.settings.time_step_s;
    m.inserted_mm = i.now.inserted;
    m.rotated_deg = i.now.rotated;
    const Vec3d axis = normalized(i.settings.entry.direction);
    m.force_n = -dot(i.wire.base_force(), axis) / kMicronewtonsPerNewton;
    m.torque_n_mm = -dot(i.wire.base_moment(), axis) / kMicronewtonsPerNewton;
    m.contact_n = i.now.contact / kMicronewtonsPerNewton;
    m.largest_contact_n = i.now.largest_contact / kMicronewtonsPerNewton;
    m.contact_mm_per_n = i.settings.catheter.contact_mm_per_n;
    m.depth_mm = i.now.depth;
    m.left_end = i.now.left_end;
    m.wire_energy_mj = i.wire.elastic_energy() / kNanojoulesPerMillijoule;
    m.active_tetrahedra = std::max(0, i.now.awake);
    m.sub_steps = i.now.sub_steps;
    m.needed_sub_steps = i.needed_sub_steps;
    return m;
}

CatheterMeasures CatheterScene::measures() const noexcept {
    CatheterMeasures m = quick_measures();
    const Impl& i = *m_impl;
    const auto& rest = i.wall.mesh.nodes_mm;
    double kinetic = i.wire.kinetic_energy();
    for (std::size_t n = 0; n < rest.size(); ++n) {
        const double w = i.body.inverse_mass(std::int32_t(n));
        const Vec3d v = i.body.velocity(std::int32_t(n));
        if (w > 0) kinetic += 0.5 * dot(v, v) / w;
    }
    m.kinetic_energy_mj = kinetic / kNanojoulesPerMillijoule;
    i.with_positions([&](const auto& position) {
        for (std::size_t n = 0; n < rest.size(); ++n)
            m.wall_moved_mm = std::max(m.wall_moved_mm, norm(position(std::int32_t(n)) - rest[n]));
        m.wall_energy_mj = i.wall_energy(position) / kNanojoulesPerMillijoule;
        m.inverted = i.inverted_in_wall(position);
        m.volume = pbd::volume_change_of(i.body.parts(), position);
    });
    return m;
}

std::int64_t CatheterScene::inverted_tetrahedra() const noexcept {
    const Impl& i = *m_impl;
    std::int64_t inverted = 0;
    i.with_positions([&](const auto& position) { inverted = i.inverted_in_wall(position); });
    return inverted;
}

std::span<const Vec3d> CatheterScene::wire_positions() const {
    return m_impl->wire.positions();
}
std::int32_t CatheterScene::first_inserted() const {
    return m_impl->wire.first();
}
Vec3d CatheterScene::tip_mm() const {
    return m_impl->wire.positions().back();
}
Rotation CatheterScene::tip_frame() const {
    return m_impl->wire.tip_frame();
}
std::vector<Vec3d> CatheterScene::wall_positions() const {
    std::vector<Vec3d> positions(std::size_t(m_impl->body.particle_count()));
    m_impl->body.get_positions(positions);
    return positions;
}
std::vector<Vec3d> CatheterScene::ghost_positions() const {
    const TetMesh now{wall_positions(), m_impl->wall.mesh.cells};
    std::vector<Vec3d> positions;
    for (const Embedded& e : m_impl->wall.ghost_positions) positions.push_back(position_of(e, now));
    return positions;
}
const PbdBody& CatheterScene::body() const {
    return m_impl->body;
}
std::uint64_t CatheterScene::hash() const noexcept {
    Hash64 hash;
    m_impl->wire.add_to(hash);
    const std::uint64_t wall = m_impl->body.hash();
    hash.add(std::span<const std::uint64_t>(&wall, 1));
    return hash.value();
}

// State of a catheter in its vessel as numbers, for undo and files.

std::vector<double> CatheterScene::state() const {
    const Impl& i = *m_impl;
    CatheterState state{.command = i.command,
                        .inserted = i.now.inserted,
                        .rotated = i.now.rotated,
                        .depth = i.now.depth,
                        .sub_step_s = i.now.pace.wanted_s(),
                        .steps = i.now.steps,
                        .awake = i.now.awake,
                        .wire = i.wire,
                        .positions = i.is_rigid() ? std::vector<Vec3d>() : wall_positions(),
                        .velocities = {},
                        .boxes = {}};
    for (std::int32_t n = 0; !i.is_rigid() && n < i.body.particle_count(); ++n)
        state.velocities.push_back(i.body.velocity(n));
    if (i.boxes) state.boxes = i.boxes->state();
    catheter::StateNumbers numbers;
    state.exchange(numbers);
    return numbers.take();
}

Status CatheterScene::restore(std::span<const double> numbers, const TaskArena& arena) noexcept {
    const Status status = attempt([&] { return put(numbers); });
    // Without memory, the next step finds contact.
    if (status.ok())
        (void)attempt([&]() -> Status {
            m_impl->renew_contact(arena);
            return Ok{};
        });
    return status;
}

Status CatheterScene::put(std::span<const double> numbers) {
    Impl& i = *m_impl;
    const auto count = i.is_rigid() ? 0 : std::size_t(i.body.particle_count());
    CatheterState state{.command = {},
                        .wire = i.wire,
                        .positions = std::vector<Vec3d>(count),
                        .velocities = std::vector<Vec3d>(count),
                        .boxes = {}};
    catheter::StateNumbers reading(numbers);
    state.exchange(reading);
    if (!reading.is_good() || !(state.inserted >= 0 && state.inserted <= i.wire.length()) ||
        state.boxes.empty() == (i.boxes != nullptr))
        return invalid("state: expected one of a scene with the same wall and catheter");
    if (const Status s = check_command(state.command); !s.ok()) return s;
    for (std::size_t n = 0; n < count; ++n)
        if (const Status s = pbd::check_state(state.positions[n], state.velocities[n]); !s.ok())
            return s;
    if (i.boxes)
        if (const Status s = i.boxes->restore(state.boxes, i.body); !s.ok()) return s;
    // The rest can't fail.
    if (!i.is_rigid()) PbdRollback::put_all(i.body, state.positions, state.velocities);
    i.wire = state.wire;
    i.command = state.command;
    i.now.pace.set_wanted_s(state.sub_step_s);
    i.now.inserted = state.inserted;
    i.now.rotated = state.rotated;
    i.now.depth = state.depth;
    i.now.contact = i.now.largest_contact = 0;
    i.now.steps = state.steps;
    i.now.sub_steps = 0;
    i.now.awake = state.awake;
    i.ends.follow(i.wire);
    i.now.left_end = i.ends.left();
    i.is_contact_old = true;
    return Ok{};
}

}  // namespace pliant
