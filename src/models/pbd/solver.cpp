// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "pbd/solver.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <functional>
#include <limits>
#include <optional>
#include <utility>

#include "base/hash.h"
#include "pbd/arithmetic.h"
#include "pbd/awake.h"

namespace pliant::pbd {
namespace {

constexpr int kSolid = int(PbdKind::Solid);
constexpr std::int64_t kGrain = 4096;    ///< particles per task
constexpr std::int64_t kPinGrain = 512;  ///< attachments per task
/// Particles per cache line; ranges of threads start at such multiples.
constexpr std::int64_t kLine = 4;
/// Limit of a target's shift, in rest volumes: held particles may keep a volume from its target.
constexpr double kMaxShift = 0.5;

/// Passes the body by std::cref, so that std::function doesn't allocate.
template <class Body>
void for_each(const TaskArena& arena, std::int64_t count, std::int64_t grain, const Body& body) {
    arena.for_each(count, grain, std::cref(body));
}

template <class Real>
class SolverOf final : public Solver {
  public:
    SolverOf(const PbdParts& parts, const PbdSettings& settings, const Plan& plan,
             Kernels<Real> kernels)
        : m_parts(parts), m_settings(settings), m_plan(plan), m_kernels(kernels) {
        choose_origin();
        const auto numbers = std::size_t(plan.particle_count) * 4;
        m_x.assign(numbers, 0);
        m_before.assign(numbers, 0);
        m_v.assign(numbers, 0);
        for (std::size_t n = 0; n < parts.positions.size(); ++n) {
            put(m_x, std::int32_t(n), parts.positions[n] - m_origin);
            m_x[at(std::int32_t(n)) + 3] = Real(parts.inverse_masses[n]);
        }
        m_good_x = m_x;
        m_good_v = m_v;
        for (int kind = 0; kind < kKinds; ++kind) {
            m_multipliers[kind].assign(
                plan.kinds[kind].constraints.size() * std::size_t(kMultipliers[kind]), 0);
            fill_numbers(kind);
        }
        if (settings.volume_recovery > 0) {
            m_volume_shifts.assign(parts.volumes.size(), 0);
            for (const PbdVolume& v : parts.volumes)
                m_rest_volumes.push_back(rest_volume(parts, v));
        }
        m_forces.assign(parts.attachments.size(), Vec3d{0, 0, 0});
        m_awake_attachments.reserve(parts.attachments.size());
        m_pinned.reserve(parts.attachments.size());
        m_packs.emplace(parts, plan, m_numbers, settings.repacks);
        if (!settings.warm_starts) return;
        m_moves.assign(numbers, 0);
        m_solid_forces.assign(plan.kinds[kSolid].constraints.size() * std::size_t(kWarm), 0);
    }

    Status step(const TaskArena& arena) override {
        if (m_has_woken) find_awake();
        for (const std::size_t held : m_set_held) m_v[held] = m_v[held + 1] = m_v[held + 2] = 0;
        m_set_held.clear();
        if (m_all_set) stop_held();
        if (m_settings.warm_starts && std::exchange(m_recalls, false)) {
            std::fill(m_moves.begin(), m_moves.end(), Real(0));
            for_domains(arena, m_kernels.recall, arrays(true, false, true), false);
            for (int n = 0; n < m_trials; ++n) try_sub_step(arena);
        }
        m_trials = 0;
        for (int n = 0; n < m_settings.sub_steps; ++n) {
            if (n == 0) move(arena, false);
            project_all(arena);
            if (!m_parts.planes.empty()) project_planes(arena);
            if (n + 1 < m_settings.sub_steps) move(arena, true);
        }
        return finish(arena);
    }

    Vec3d position(std::int32_t particle) const override { return m_origin + get(m_x, particle); }
    Vec3d velocity(std::int32_t particle) const override { return get(m_v, particle); }
    double inverse_mass(std::int32_t particle) const override {
        return double(m_x[at(particle) + 3]);
    }
    void set_state(std::int32_t particle, Vec3d position, Vec3d velocity) override {
        if (!(m_x[at(particle) + 3] > 0)) m_set_held.push_back(at(particle));
        put(m_x, particle, position - m_origin);
        put(m_v, particle, velocity);
    }
    void set_inverse_mass(std::int32_t particle, double inverse_mass) override {
        Real& w = m_x[at(particle) + 3];
        if (m_keeps && (w > 0) != (Real(inverse_mass) > 0)) keep_others();
        m_has_woken |= (w > 0) != (Real(inverse_mass) > 0);
        w = Real(inverse_mass);
        if (inverse_mass == 0) put(m_v, particle, {0, 0, 0});
    }
    void load(std::span<const std::int32_t> particles, std::span<const Vec3d> forces) override {
        m_loads.reserve(particles.size());
        m_loads.clear();
        for (std::size_t n = 0; n < particles.size(); ++n)
            m_loads.push_back({at(particles[n]), forces[n]});
    }
    double multiplier(int kind, std::int32_t constraint, int part) const override {
        const std::int32_t found = m_packs->slot(kind, constraint);
        if (found < 0) return 0;
        const std::size_t pack = std::size_t(found) / kPack, lane = std::size_t(found) % kPack;
        const auto per_pack = std::size_t(kMultipliers[kind]);
        return double(m_multipliers[kind][(pack * per_pack + std::size_t(part)) * kPack + lane]) /
               (h() * h());
    }
    std::array<Vec3d, 3> solid_forces(std::int32_t solid) const override {
        const std::int32_t found = m_packs->slot(kSolid, solid);
        std::array<Vec3d, 3> forces{};
        if (found < 0) return forces;
        const Real* f = m_solid_forces.data() + found / kPack * kWarm * kPack + found % kPack;
        if (!(f[9 * kPack] > 0)) return forces;  // all corners are held
        const double per = 1 / (double(f[9 * kPack]) * h() * h());
        for (int n = 0; n < 9; ++n) forces[std::size_t(n / 3)][n % 3] = per * double(f[n * kPack]);
        return forces;
    }
    Vec3d attachment_force(std::int32_t attachment) const override {
        const auto a = std::size_t(attachment);
        return (1 / (h() * h())) * (is_held(m_parts.attachments[a]) ? held_pull(a) : m_forces[a]);
    }
    std::uint64_t hash() const override {
        Hash64 hash;
        for (std::size_t n = 0; n < m_parts.positions.size(); ++n)
            hash.add(std::span<const Real>(m_x.data() + at(std::int32_t(n)), 3));
        return hash.value();
    }

    void reserve_kept() override {
        m_kept_x.resize(m_x.size());
        m_kept_v.resize(m_v.size());
    }
    /// Copies the active particles; the others are copied when the first particle changes its
    /// state.
    void keep() noexcept override {
        m_keeps = true;
        m_kept_all = false;
        m_kept_set = m_all_set || !m_set_held.empty();
        for (const Range& range : m_awake_ranges) keep_range(range.begin, range.end);
        if (m_has_woken || m_kept_set) keep_others();
    }
    void take_back() noexcept override {
        m_keeps = false;
        m_set_held.clear();  // those before keep() are in m_kept_set
        if (!m_kept_all) {
            for (const Range& range : m_awake_ranges) {
                copy(m_kept_x, m_x, range.begin, range.end);
                copy(m_kept_v, m_v, range.begin, range.end);
            }
            return;
        }
        copy(m_kept_x, m_x, 0, m_plan.particle_count);
        copy(m_kept_v, m_v, 0, m_plan.particle_count);
        m_has_woken = true;
        m_all_set |= m_kept_set;
    }
    void put_all(std::span<const Vec3d> positions,
                 std::span<const Vec3d> velocities) noexcept override {
        for (std::size_t n = 0; n < positions.size(); ++n) {
            put(m_x, std::int32_t(n), positions[n] - m_origin);
            put(m_v, std::int32_t(n), velocities[n]);
        }
        m_all_set = m_recalls = true;
    }
    void recall_forces(std::int32_t trials) noexcept override {
        m_recalls = true;
        m_trials = trials;
    }

  private:
    std::size_t at(std::int32_t particle) const {
        return std::size_t(m_plan.particle_of[std::size_t(particle)]) * 4;
    }
    Vec3d get(const AlignedVector<Real>& values, std::int32_t particle) const {
        const Real* v = values.data() + at(particle);
        return {double(v[0]), double(v[1]), double(v[2])};
    }
    void put(AlignedVector<Real>& values, std::int32_t particle, Vec3d v) {
        Real* to = values.data() + at(particle);
        for (int c = 0; c < 3; ++c) to[c] = Real(v[c]);
    }
    /// Sets the origin to the middle of the body, where floats are finest.
    void choose_origin() {
        Vec3d low = m_parts.positions[0], high = low;
        for (const Vec3d& p : m_parts.positions)
            for (int c = 0; c < 3; ++c) {
                low[c] = std::min(low[c], p[c]);
                high[c] = std::max(high[c], p[c]);
            }
        m_origin = 0.5 * (low + high);
    }

    /// Empty lanes get valid numbers.
    void fill_numbers(int kind) {
        const auto& constraints = m_plan.kinds[kind].constraints;
        const auto per_pack = std::size_t(kNumbers[kind]);
        m_numbers[kind].assign(constraints.size() * per_pack, 0);
        for (std::size_t slot = 0; slot < constraints.size(); ++slot) {
            if (constraints[slot] < 0) continue;
            double found[kNumbers[kKinds - 1]];
            numbers_of(kind, std::size_t(constraints[slot]), found);
            for (std::size_t n = 0; n < per_pack; ++n)
                m_numbers[kind][(slot / kPack * per_pack + n) * kPack + slot % kPack] =
                    Real(found[n]);
        }
    }
    void numbers_of(int kind, std::size_t c, double* to) const {
        const bool compliant = m_settings.method == PbdMethod::Compliance;
        switch (PbdKind(kind)) {
            case PbdKind::Distance: {
                const PbdDistance& d = m_parts.distances[c];
                to[0] = rest_length(m_parts, d);
                to[1] = compliant ? d.compliance : d.stiffness;
                return;
            }
            case PbdKind::Bend: {
                const PbdBend& b = m_parts.bends[c];
                to[0] = rest_angle(m_parts, b);
                to[1] = compliant ? b.compliance : b.stiffness;
                return;
            }
            case PbdKind::Volume: {
                const PbdVolume& v = m_parts.volumes[c];
                to[0] = rest_volume(m_parts, v);
                to[1] = compliant ? v.compliance : v.stiffness;
                return;
            }
            case PbdKind::Solid:
                break;
        }
        const SolidNumbers s = solid_numbers(m_parts, m_parts.solids[c]);
        to[kExponent] = s.ogden_alpha;
        if (m_settings.warm_starts && s.ogden_alpha == 0) {
            const WarmSolid<double> w = warm_solid(s);
            for (const double number : {w.m00, w.m01, w.m02, w.m11, w.m12, w.m22, w.per_volume,
                                        w.h_stiffness, w.e_stiffness})
                *to++ = number;
            return;
        }
        std::copy_n(s.inverse, 9, to);
        to[9] = s.h_compliance;
        to[10] = s.e_compliance;
    }

    /// Ends a sub-step and starts the next; before the first one, velocities are kept.
    void move(const TaskArena& arena, bool ends_one) {
        const Vec3d g = h() * m_settings.gravity;
        const MoveArrays<Real> arrays{m_x.data(),
                                      m_before.data(),
                                      m_v.data(),
                                      or_null(m_moves),
                                      Real(h()),
                                      Real(ends_one ? 1 / h() : 0),
                                      Real(1 - m_settings.damping * h()),
                                      {Real(g.x), Real(g.y), Real(g.z), 0}};
        for_awake(arena, [&](std::int64_t begin, std::int64_t end) {
            if (!ends_one) {
                copy(m_x, m_good_x, begin, end);
                copy(m_v, m_good_v, begin, end);
            }
            m_kernels.move(arrays, begin, end);
        });
        for (const Load& load : m_loads)
            for (std::size_t c = 0; c < 3; ++c) {
                const Real push = Real(h() * load.force[int(c)]) * m_x[load.at + 3];
                m_v[load.at + c] += push;
                m_x[load.at + c] += arrays.h * push;
                m_before[load.at + c] += arrays.h * push;  // without the moves of warm starts
            }
    }
    void project_all(const TaskArena& arena) {
        for (int i = 0; i < m_settings.iterations; ++i) {
            const bool backward = m_settings.alternates && i % 2 == 1;
            if (backward) project_attachments(arena, false);
            project(arena, i, backward);
            if (!backward) project_attachments(arena, i == 0);
        }
    }
    /// Replaces the solids' forces by those of the first sub-step, which moves no particle. Contact
    /// puts particles back after a sub-step. At rest, the forces f of the last one are then those
    /// of the shape that f itself leads to from here, not those of the present shape. Trials find
    /// this f by iteration.
    void try_sub_step(const TaskArena& arena) {
        move(arena, false);
        project_all(arena);
        for_awake(arena, [&](std::int64_t begin, std::int64_t end) {
            copy(m_good_x, m_x, begin, end);
            copy(m_good_v, m_v, begin, end);
        });
    }
    Status finish(const TaskArena& arena) {
        const Real per_h = Real(1 / h());
        m_is_bad.store(false);
        for_awake(arena, [&](std::int64_t begin, std::int64_t end) {
            // All four components alike: the fourth is 0 in v, and a difference of equal masses in
            // x.
            int bad = 0;
            for (auto c = std::size_t(4 * begin); c < std::size_t(4 * end); ++c) {
                m_v[c] = m_v[c] + (m_x[c] - m_before[c]) * per_h;
                bad |= !(std::abs(m_v[c]) <= std::numeric_limits<Real>::max());
            }
            if (bad) m_is_bad.store(true);
        });
        if (!m_is_bad.load()) {
            recover_volumes(arena);
            return Ok{};
        }
        for_awake(arena, [&](std::int64_t begin, std::int64_t end) {
            copy(m_good_x, m_x, begin, end);
            copy(m_good_v, m_v, begin, end);
        });
        m_recalls = true;
        return Error{ErrorCode::LimitExceeded,
                     "step: a position or velocity is no longer finite; expected more sub-steps, "
                     "damping or compliance"};
    }

    /// Integral control of hard volumes: the error C that a lasting load leaves after the
    /// projections of a sub-step is compensated by shifting the target by as much in the other
    /// direction. The slow modes are oscillators with the damping c of velocities; their error
    /// grows if the rate is above c (docs/method/pbd.md).
    void recover_volumes(const TaskArena& arena) {
        constexpr int kVolume = int(PbdKind::Volume);
        const double share = m_settings.volume_recovery * m_settings.time_step;
        for_each(arena, std::int64_t(m_volume_shifts.size()), kGrain,
                 [&](std::int64_t begin, std::int64_t end) {
                     for (auto c = std::size_t(begin); c < std::size_t(end); ++c) {
                         const PbdVolume& v = m_parts.volumes[c];
                         if (m_settings.method == PbdMethod::Compliance && v.compliance > 0)
                             continue;
                         const std::int32_t slot = m_packs->slot(kVolume, std::int32_t(c));
                         if (slot < 0 || all_held(v.nodes)) continue;
                         const Vec3d p = get(m_x, v.nodes[0]);
                         const Vec3d e[3] = {get(m_x, v.nodes[1]) - p, get(m_x, v.nodes[2]) - p,
                                             get(m_x, v.nodes[3]) - p};
                         const double off =
                             pliant::dot(pliant::cross(e[0], e[1]), e[2]) / 6 - m_rest_volumes[c];
                         const double most = kMaxShift * m_rest_volumes[c];
                         m_volume_shifts[c] =
                             std::clamp(m_volume_shifts[c] - share * off, -most, most);
                         const Real target = Real(m_rest_volumes[c] + m_volume_shifts[c]);
                         m_numbers[kVolume][first_number(m_plan.kinds[kVolume].slots[c])] = target;
                         m_packs->set_number(kVolume, first_number(slot), target);
                     }
                 });
    }
    bool all_held(const std::array<std::int32_t, 4>& nodes) const {
        return std::none_of(nodes.begin(), nodes.end(),
                            [&](std::int32_t n) { return m_x[at(n) + 3] > 0; });
    }
    /// Index of a volume's first number.
    static std::size_t first_number(std::int32_t slot) {
        const auto at = std::size_t(slot);
        return at / kPack * std::size_t(kNumbers[int(PbdKind::Volume)]) * kPack + at % kPack;
    }

    struct Range {
        std::int64_t begin, end;  ///< range of particles, multiples of kLine
    };
    struct AwakeAttachment {
        std::int32_t number;
        bool is_pin;  ///< attaches a single particle, at…
        std::size_t at;
    };
    /// Calls body(begin, end) for ranges with all movable particles, and some others.
    template <class Body>
    void for_awake(const TaskArena& arena, const Body& body) {
        for_each(arena, std::int64_t(m_awake_ranges.size()), 1,
                 [&](std::int64_t first, std::int64_t last) {
                     for (std::int64_t r = first; r < last; ++r)
                         body(m_awake_ranges[std::size_t(r)].begin,
                              m_awake_ranges[std::size_t(r)].end);
                 });
    }
    static void copy(const AlignedVector<Real>& from, AlignedVector<Real>& to, std::int64_t begin,
                     std::int64_t end) {
        std::copy(from.data() + 4 * begin, from.data() + 4 * end, to.data() + 4 * begin);
    }
    bool is_held(const PbdAttachment& attachment) const {
        for (std::size_t n = 0; n < 4; ++n)
            if (attachment.weights[n] != 0 && m_x[at(attachment.nodes[n]) + 3] > 0) return false;
        return true;
    }

    /// Finds the movable particles, packs and attachments.
    void find_awake() {
        m_packs->update(m_x.data());
        m_awake_ranges.clear();
        for (std::int64_t line = 0; line < m_plan.particle_count; line += kLine) {
            bool moves = false;
            for (std::int64_t n = line; n < line + kLine; ++n)
                moves |= m_x[std::size_t(4 * n + 3)] > 0;
            if (!moves) continue;
            if (!m_awake_ranges.empty() && line - m_awake_ranges.back().end <= 2 * kLine &&
                line - m_awake_ranges.back().begin < kGrain)
                m_awake_ranges.back().end = line + kLine;
            else
                m_awake_ranges.push_back({line, line + kLine});
        }
        m_awake_attachments.clear();
        for (std::size_t a = 0; a < m_parts.attachments.size(); ++a)
            if (const PbdAttachment& attachment = m_parts.attachments[a]; !is_held(attachment)) {
                const auto& w = attachment.weights;
                const bool is_pin = w[0] == 1 && w[1] == 0 && w[2] == 0 && w[3] == 0;
                m_awake_attachments.push_back({std::int32_t(a), is_pin, at(attachment.nodes[0])});
            }
        m_pinned.clear();
        for (const AwakeAttachment& awake : m_awake_attachments)
            if (awake.is_pin) m_pinned.push_back(awake.at);
        std::sort(m_pinned.begin(), m_pinned.end());
        m_pins_only = m_pinned.size() == m_awake_attachments.size() &&
                      std::adjacent_find(m_pinned.begin(), m_pinned.end()) == m_pinned.end();
        m_recalls = true;
        m_has_woken = false;  // not before: if memory runs out, the next step repeats this
    }
    void stop_held() noexcept {
        for (std::size_t n = 0; n < m_x.size(); n += 4)
            if (!(m_x[n + 3] > 0)) m_v[n] = m_v[n + 1] = m_v[n + 2] = 0;
        m_all_set = false;
    }

    void keep_range(std::int64_t begin, std::int64_t end) noexcept {
        copy(m_x, m_kept_x, begin, end);
        copy(m_v, m_kept_v, begin, end);
    }
    /// Copies all particles outside of the awake ranges, which are still those of keep().
    void keep_others() noexcept {
        if (m_kept_all) return;
        std::int64_t from = 0;
        for (const Range& range : m_awake_ranges) {
            keep_range(from, range.begin);
            from = range.end;
        }
        keep_range(from, m_plan.particle_count);
        m_kept_all = true;
    }

    void project(const TaskArena& arena, int iteration, bool backward) {
        const bool last = iteration + 1 == m_settings.iterations;
        for_domains(arena, m_kernels.project, arrays(iteration == 0, backward, last), backward);
    }
    static Real* or_null(AlignedVector<Real>& values) {
        return values.empty() ? nullptr : values.data();
    }
    ProjectArrays<Real> arrays(bool first, bool backward, bool last) {
        ProjectArrays<Real> arrays{m_x.data(),
                                   {},
                                   Real(1 / (h() * h())),
                                   Real(h() * h()),
                                   m_settings.method == PbdMethod::Compliance,
                                   first,
                                   backward,
                                   last,
                                   or_null(m_solid_forces),
                                   or_null(m_moves),
                                   m_has_ogden};
        for (int kind = 0; kind < kKinds; ++kind)
            arrays.kinds[kind] = {m_packs->corners(kind), m_packs->numbers(kind),
                                  m_multipliers[kind].data()};
        return arrays;
    }
    /// Calls work for the packs of each domain.
    void for_domains(const TaskArena& arena,
                     void (*work)(const ProjectArrays<Real>&, const Domain&),
                     const ProjectArrays<Real>& arrays, bool backward) {
        for (std::size_t n = 0; n < m_plan.phases.size(); ++n) {
            const Phase phase = m_plan.phases[backward ? m_plan.phases.size() - 1 - n : n];
            for_each(arena, phase.end - phase.begin, 1, [&](std::int64_t begin, std::int64_t end) {
                for (auto d = std::size_t(phase.begin + begin); d < std::size_t(phase.begin + end);
                     ++d) {
                    const auto parts = m_packs->of_domain(d);
                    for (std::size_t k = 0; k < parts.size(); ++k)
                        work(arrays, parts[backward ? parts.size() - 1 - k : k]);
                }
            });
        }
    }

    double compliance_of(const PbdAttachment& attachment) const {
        return attachment.compliance / (h() * h());
    }
    /// Force of an attachment to held particles, which takes no part in the steps.
    Vec3d held_pull(std::size_t a) const {
        const PbdAttachment& attachment = m_parts.attachments[a];
        const double alpha = compliance_of(attachment);
        if (!(alpha > 0)) return {0, 0, 0};
        return (-1 / alpha) * off_target(attachment);
    }
    Vec3d off_target(const PbdAttachment& attachment) const {
        Vec3d c = m_origin - attachment.target;
        double sum = 0;
        for (std::size_t n = 0; n < 4; ++n) {
            const double b = attachment.weights[n];
            if (b == 0) continue;
            c = c + b * get(m_x, attachment.nodes[n]);
            sum += b;
        }
        return c + (sum - 1) * m_origin;
    }

    /// Projects the attachments; pins of different particles commute.
    void project_attachments(const TaskArena& arena, bool first) {
        const auto some = [&](std::int64_t begin, std::int64_t end) {
            for (std::int64_t n = begin; n < end; ++n) {
                const AwakeAttachment& awake = m_awake_attachments[std::size_t(n)];
                if (first) m_forces[std::size_t(awake.number)] = {0, 0, 0};
                awake.is_pin ? project_pin(awake) : project_attachment(awake);
            }
        };
        const auto count = std::int64_t(m_awake_attachments.size());
        m_pins_only ? for_each(arena, count, kPinGrain, some) : some(0, count);
    }
    /// Projects a pin. All three components have the same weight, so this is exact for each.
    void project_pin(const AwakeAttachment& awake) {
        const PbdAttachment& attachment = m_parts.attachments[std::size_t(awake.number)];
        Vec3d& multiplier = m_forces[std::size_t(awake.number)];
        const double alpha = compliance_of(attachment);
        Real* x = m_x.data() + awake.at;
        const Vec3d off =
            m_origin - attachment.target + Vec3d{double(x[0]), double(x[1]), double(x[2])};
        const Vec3d change = (-1 / (alpha + double(x[3]))) * (off + alpha * multiplier);
        multiplier = multiplier + change;
        for (int c = 0; c < 3; ++c) x[c] = Real(double(x[c]) + double(x[3]) * change[c]);
    }
    void project_attachment(const AwakeAttachment& awake) {
        const PbdAttachment& attachment = m_parts.attachments[std::size_t(awake.number)];
        Vec3d& multiplier = m_forces[std::size_t(awake.number)];
        const double alpha = compliance_of(attachment);
        double weight = alpha;
        for (std::size_t n = 0; n < 4; ++n) {
            const double b = attachment.weights[n];
            if (b != 0) weight += b * b * double(m_x[at(attachment.nodes[n]) + 3]);
        }
        if (!(weight > 0)) return;
        const Vec3d change = (-1 / weight) * (off_target(attachment) + alpha * multiplier);
        multiplier = multiplier + change;
        for (std::size_t n = 0; n < 4; ++n) {
            const double b = attachment.weights[n];
            if (b == 0) continue;
            Real* x = m_x.data() + at(attachment.nodes[n]);
            for (int axis = 0; axis < 3; ++axis)
                x[axis] = Real(double(x[axis]) + b * double(x[3]) * change[axis]);
        }
    }

    /// Moves particles out of the planes, and back along them within the friction limit.
    void project_planes(const TaskArena& arena) {
        const auto count = std::int64_t(m_parts.positions.size());
        for_each(arena, count, kGrain, [&](std::int64_t begin, std::int64_t end) {
            for (const PbdPlane& plane : m_parts.planes) {
                const Vec3d normal = normalized(plane.normal), point = plane.point - m_origin;
                for (auto n = std::size_t(4 * begin); n < std::size_t(4 * end); n += 4)
                    push_out(n, point, normal, plane.friction);
            }
        });
    }
    void push_out(std::size_t n, Vec3d point, Vec3d normal, double friction) {
        if (!(m_x[n + 3] > 0)) return;
        Vec3d x{m_x[n], m_x[n + 1], m_x[n + 2]};
        const double depth = pliant::dot(point - x, normal);
        if (!(depth > 0)) return;
        x = x + depth * normal;
        const Vec3d v{m_v[n], m_v[n + 1], m_v[n + 2]};
        const Vec3d old = Vec3d{m_before[n], m_before[n + 1], m_before[n + 2]} - h() * v;
        Vec3d slide = x - old;
        slide = slide - pliant::dot(slide, normal) * normal;
        const double way = norm(slide);
        if (way > 0) x = x - std::min(1.0, friction * depth / way) * slide;
        for (std::size_t c = 0; c < 3; ++c) m_x[n + c] = Real(x[int(c)]);
    }

    double h() const {
        return m_settings.time_step / m_settings.sub_steps;
    }  ///< duration of a
       ///< sub-step

    struct Load {
        std::size_t at;
        Vec3d force;
    };

    const PbdParts& m_parts;
    const PbdSettings& m_settings;
    const Plan& m_plan;
    Kernels<Real> m_kernels;
    const bool m_has_ogden = std::any_of(m_parts.solids.begin(), m_parts.solids.end(),
                                         [](const PbdSolid& s) { return s.ogden_alpha != 2; });
    Vec3d m_origin{0, 0, 0};
    /// [particle][4]: x, y, z, inverse mass in m_x. m_before is the state before the constraints.
    AlignedVector<Real> m_x, m_before, m_v, m_good_x, m_good_v;
    AlignedVector<Real> m_numbers[kKinds], m_multipliers[kKinds];
    std::vector<double> m_rest_volumes, m_volume_shifts;  ///< [volume], with volume recovery
    std::optional<AwakePacks<Real>> m_packs;
    std::vector<Range> m_awake_ranges;
    std::vector<AwakeAttachment> m_awake_attachments;
    bool m_pins_only = false;             ///< all are pins of different particles
    std::vector<std::size_t> m_pinned;    ///< particles of the pins
    std::vector<std::size_t> m_set_held;  ///< held particles that may have been given velocities
    bool m_all_set = false;               ///< any held particle may have been
    bool m_has_woken = true;              ///< some particle has become movable or held
    std::vector<Load> m_loads;
    std::vector<Vec3d> m_forces;  ///< multipliers of attachments
    AlignedVector<Real> m_kept_x, m_kept_v;
    AlignedVector<Real> m_solid_forces, m_moves;  ///< of ProjectArrays; empty without warm starts
    bool m_recalls = true;      ///< the next step begins with the forces of the present shape
    std::int32_t m_trials = 0;  ///< of the next step, if it recalls
    bool m_keeps = false;       ///< keep() was called, and take_back() not since then
    bool m_kept_all = false;    ///< includes particles outside of the awake ranges
    bool m_kept_set = false;    ///< held particles may have had velocities
    std::atomic<bool> m_is_bad = false;
};

}  // namespace

std::unique_ptr<Solver> make_solver(const PbdParts& parts, const PbdSettings& settings,
                                    const Plan& plan) {
    if (settings.precision == PbdPrecision::Double)
        return std::make_unique<SolverOf<double>>(parts, settings, plan, plain_kernels<double>());
    return std::make_unique<SolverOf<float>>(
        parts, settings, plan, settings.vectors ? vector_kernels() : plain_kernels<float>());
}

}  // namespace pliant::pbd
