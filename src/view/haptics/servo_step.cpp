// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// One period, in this order: proxy, law, blending, safe stop, energy, limits.

#include <pliant/view/haptics.h>

#include <algorithm>

namespace pliant {
namespace {

constexpr double kMetres = 1e-3;                         ///< m per mm
constexpr double kVelocityTime_s = 0.005;                ///< of the velocity filter, because
                                                         ///< encoders are quantised
constexpr double kShortest_s = 1e-4, kLongest_s = 0.01;  ///< range of the periods used for rates

/// Position of the proxy, and the contact's normal.
struct Contact {
    Vec3d proxy_mm{0, 0, 0};
    Vec3d normal{0, 0, 0};  ///< from the tool to the free side; 0: no contact
    bool is_boxed_in = false;
};

Contact find_contact(const HapticModel& model, Vec3d x, Vec3d earlier_proxy) {
    Contact contact;
    const Vec3d nearest = nearest_free_position(model, x, &contact.is_boxed_in);
    contact.proxy_mm = nearest;
    const double depth = norm(nearest - x);
    if (!(depth > 0)) return contact;
    contact.normal = (1 / depth) * (nearest - x);
    if (!(model.friction > 0)) return contact;
    // The free side lies beyond the plane through `nearest`. The proxy sticks to its position on
    // that plane within the friction cone, and otherwise slides until it is within it.
    Vec3d behind = nearest_free_position(model, earlier_proxy) - nearest;
    behind = behind - dot(behind, contact.normal) * contact.normal;
    const double length = norm(behind), held = model.friction * depth;
    const Vec3d kept = length > held ? (held / length) * behind : behind;
    contact.proxy_mm = nearest_free_position(model, nearest + kept);
    return contact;
}

/// F = f₀ + K (δ − δ₀), limited to feasible contact forces.
Vec3d law(const HapticModel& model, double largest_n_m, const Contact& contact, Vec3d x) {
    const Vec3d proxy = model.held ? model.anchor_mm : contact.proxy_mm;
    const Vec3d depth = proxy - x;
    const Vec3d force = model.force_n + model.stiffness_n_m * (kMetres * (depth - model.depth_mm));
    if (model.held) return force;
    const Vec3d n = contact.normal;
    const double most = largest_n_m * kMetres * dot(n, depth);
    const double normal = std::min(dot(force, n), most);
    if (!(normal > 0)) return {0, 0, 0};
    Vec3d tangential = force - dot(force, n) * n;
    const double length = norm(tangential), cone = model.friction * normal;
    if (length > cone) tangential = (cone / length) * tangential;
    return normal * n + tangential;
}

/// Computes the force at x, before blending. Moves the proxy.
Vec3d force_at(double largest_n_m, Vec3d x, HapticState& s, std::uint32_t& flags) {
    if (s.model.held) {
        s.in_contact = true;
        s.proxy_mm = s.model.anchor_mm;
        return law(s.model, largest_n_m, {}, x);
    }
    const Contact contact = find_contact(s.model, x, s.proxy_mm);
    if (contact.is_boxed_in) flags |= kHapticBoxedIn;
    s.proxy_mm = contact.proxy_mm;
    s.in_contact = contact.normal != Vec3d{0, 0, 0};
    return s.in_contact ? law(s.model, largest_n_m, contact, x) : Vec3d{0, 0, 0};
}

double blend_weight(const HapticSettings& settings, const HapticState& s) {
    const double span = std::min(double(s.update_ns), settings.blend_s * 1e9);
    if (!(span > 0)) return 0;
    return std::max(0.0, 1 - double(s.time_ns - s.model_time_ns) / span);
}

void take(const HapticModel& fresh, HapticState& s) {
    s.update_ns = s.model_time_ns < 0 ? 0 : s.time_ns - s.model_time_ns;
    s.model_time_ns = s.time_ns;
    s.model = fresh;
}

void follow(Vec3d x, double period_s, HapticState& s) {
    if (s.time_ns >= 0 && period_s > 0) {
        const double share = period_s / (kVelocityTime_s + period_s);
        const Vec3d now = (1 / period_s) * (x - s.position_mm);
        s.velocity_mm_s = s.velocity_mm_s + share * (now - s.velocity_mm_s);
    } else {
        s.proxy_mm = x;
    }
    s.position_mm = x;
}

/// Limits the energy spent by force along the motion to the energy taken.
bool bound_energy(double period_s, const HapticState& s, Vec3d& force) {
    const double spent = kMetres * period_s * dot(force, s.velocity_mm_s);
    if (spent <= 0 || spent <= s.energy_j) return false;
    force = (std::max(0.0, s.energy_j) / spent) * force;
    return true;
}

}  // namespace

HapticForce servo_step(const HapticSettings& settings, const HapticModel* fresh,
                       const HapticReading& reading, HapticState& s) {
    const HapticWorkspace& w = settings.workspace;
    const double felt = w.scale * w.force_scale;  // stiffness at the device / in the scene
    const double largest_n_m = felt > 0 ? settings.max_stiffness_n_m / felt : 0;
    const Vec3d x = w.origin_mm + w.scale * (w.rotation * reading.position_mm);
    const double passed_s = s.time_ns < 0 ? 0 : 1e-9 * double(reading.time_ns - s.time_ns);
    const double period_s = std::clamp(passed_s, kShortest_s, kLongest_s);
    HapticForce out;
    if (s.time_ns >= 0) s.energy_j -= kMetres * dot(s.force_n, x - s.position_mm);
    follow(x, s.time_ns < 0 ? 0 : period_s, s);
    s.time_ns = reading.time_ns;

    const bool was_in_contact = s.in_contact;
    Vec3d force = force_at(largest_n_m, x, s, out.flags);
    if (!s.in_contact && was_in_contact) {  // the tool left the contact
        s.correction_n = {0, 0, 0};
        s.energy_j = std::min(s.energy_j, 0.0);
    }
    if (fresh && fresh->number != s.model.number) {
        const Vec3d before = force + blend_weight(settings, s) * s.correction_n;
        take(*fresh, s);
        force = force_at(largest_n_m, x, s, out.flags);
        s.swap_step_n = norm(force - before);
        s.correction_n = before - force;
        out.flags |= kHapticNewModel;
    }
    force = force + blend_weight(settings, s) * s.correction_n;
    if (settings.damping_n_s_m > 0 && s.in_contact) {
        const Vec3d damped = force - (settings.damping_n_s_m * kMetres) * s.velocity_mm_s;
        // A surface doesn't pull.
        force = s.model.held || dot(damped, force) > 0 ? damped : Vec3d{0, 0, 0};
    }

    const bool is_stale = s.model_time_ns < 0 || reading.stop ||
                          double(s.time_ns - s.model_time_ns) > settings.stale_s * 1e9;
    const double change = period_s / settings.ramp_s;
    s.gain = std::clamp(s.gain + (is_stale ? -change : change), 0.0, 1.0);
    if (is_stale) out.flags |= kHapticStale;
    force = s.gain * force;
    if (settings.bounded_energy && bound_energy(period_s, s, force))
        out.flags |= kHapticEnergyLimit;

    const double most = w.force_scale > 0 ? settings.max_force_n / w.force_scale : 0;
    if (const double size = norm(force); size > most) {
        force = (most / size) * force;
        out.flags |= kHapticForceLimit;
    }
    const double most_change =
        w.force_scale > 0 ? settings.max_force_rate_n_s * period_s / w.force_scale : 0;
    const Vec3d step = force - s.force_n;
    // The rate is not limited in free space: the force is zero at once.
    const bool is_free = force == Vec3d{0, 0, 0} && !s.in_contact;
    if (const double size = norm(step); size > most_change && !is_free) {
        force = s.force_n + (most_change / size) * step;
        out.flags |= kHapticRateLimit;
    }
    s.force_n = force;
    if (s.in_contact) out.flags |= kHapticContact;
    out.force_n = w.force_scale * (transposed(w.rotation) * force);
    return out;
}

}  // namespace pliant
