// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include <cmath>
#include <string>

#include "base/errors.h"
#include "base/text.h"
#include "pbd/solver.h"

namespace pliant::pbd {
namespace {

Error bad_part(const char* what, std::size_t index, const std::string& expected) {
    return invalid(std::string(what) + " " + std::to_string(index) + ": expected " + expected);
}

bool is_amount(double value) {
    return std::isfinite(value) && value >= 0;
}

/// Checks one constraint; errors have its kind and number.
struct Checker {
    const PbdParts& parts;
    PbdMethod method;
    const char* what;
    std::size_t index;

    Status nodes(std::span<const std::int32_t> found) const {
        const auto count = parts.positions.size();
        for (std::size_t n = 0; n < found.size(); ++n) {
            if (found[n] < 0 || std::size_t(found[n]) >= count)
                return bad_part(
                    what, index,
                    "nodes below " + std::to_string(count) + ", found " + std::to_string(found[n]));
            for (std::size_t m = 0; m < n; ++m)
                if (found[m] == found[n])
                    return bad_part(
                        what, index,
                        "different nodes, found " + std::to_string(found[n]) + " twice");
        }
        return Ok{};
    }
    Status law(double compliance, double stiffness) const {
        if (!is_amount(compliance))
            return bad_part(what, index,
                            "a compliance of 0 or more, found " + short_text(compliance));
        if (!(stiffness >= 0 && stiffness <= 1))
            return bad_part(what, index, "a stiffness of 0 to 1, found " + short_text(stiffness));
        return Ok{};
    }
    Status volume(const std::array<std::int32_t, 4>& tetrahedron) const {
        const double found = tetrahedron_volume(tetrahedron, parts.positions);
        if (found > 0 && std::isfinite(found)) return Ok{};
        return bad_part(what, index,
                        "a volume above 0, found " + short_text(found) +
                            (found < 0 ? ": the tetrahedron is inverted" : ""));
    }

    /// The volume constraint beside a negative exponent has a stiffness of λ + 2µ/α.
    Status exponent(const PbdSolid& t) const {
        const double alpha = t.ogden_alpha, nu = t.poisson_ratio;
        if (!((alpha >= 2 && alpha <= 40) || (alpha >= -40 && alpha <= -1)))
            return bad_part(
                what, index,
                "an Ogden exponent of 2 to 40, or −40 to −1, found " + short_text(alpha));
        const double least = (1 - 2 * nu) / nu;
        if (alpha < 0 && -alpha <= least)
            return bad_part(what, index,
                            "an Ogden exponent below " + short_text(-least) +
                                " for a Poisson's ratio of " + short_text(nu) + ", found " +
                                short_text(alpha));
        return Ok{};
    }

    Status operator()(const PbdDistance& d) const {
        if (const Status s = nodes(d.nodes); !s.ok()) return s;
        if (std::isnan(d.rest_length) || std::isinf(d.rest_length))
            return bad_part(what, index, "a rest length that is a number");
        return law(d.compliance, d.stiffness);
    }
    Status operator()(const PbdBend& b) const {
        if (const Status s = nodes(b.nodes); !s.ok()) return s;
        if (std::isinf(b.rest_angle)) return bad_part(what, index, "a rest angle that is a number");
        return law(b.compliance, b.stiffness);
    }
    Status operator()(const PbdVolume& v) const {
        if (const Status s = nodes(v.nodes); !s.ok()) return s;
        if (std::isnan(v.rest_volume) || std::isinf(v.rest_volume))
            return bad_part(what, index, "a rest volume that is a number");
        if (v.rest_volume < 0)
            if (const Status s = volume(v.nodes); !s.ok()) return s;
        return law(v.compliance, v.stiffness);
    }
    Status operator()(const PbdSolid& t) const {
        if (const Status s = nodes(t.nodes); !s.ok()) return s;
        if (method != PbdMethod::Compliance)
            return bad_part(what, index, "method Compliance, found Stiffness, which has no moduli");
        if (!(std::isfinite(t.young_modulus) && t.young_modulus > 0))
            return bad_part(what, index,
                            "a Young's modulus above 0, found " + short_text(t.young_modulus));
        if (!(t.poisson_ratio > 0 && t.poisson_ratio < 0.5))
            return bad_part(
                what, index,
                "a Poisson's ratio above 0 and below 0.5, found " + short_text(t.poisson_ratio));
        if (const Status s = exponent(t); !s.ok()) return s;
        return volume(t.nodes);
    }
    Status operator()(const PbdAttachment& a) const {
        bool any = false;
        for (std::size_t n = 0; n < 4; ++n) {
            if (!std::isfinite(a.weights[n]))
                return bad_part(what, index, "weights that are numbers");
            if (a.weights[n] == 0) continue;
            any = true;
            if (a.nodes[n] < 0 || std::size_t(a.nodes[n]) >= parts.positions.size())
                return bad_part(what, index,
                                "nodes below " + std::to_string(parts.positions.size()) +
                                    ", found " + std::to_string(a.nodes[n]));
        }
        if (!any) return bad_part(what, index, "a weight that isn't 0");
        if (!is_finite(a.target)) return bad_part(what, index, "a target of three numbers");
        return law(a.compliance, 1);
    }
    Status operator()(const PbdPlane& p) const {
        if (!is_finite(p.point)) return bad_part(what, index, "a point of three numbers");
        if (!is_finite(p.normal) || !(norm(p.normal) > 0))
            return bad_part(what, index, "a normal that isn't 0");
        if (!is_amount(p.friction))
            return bad_part(what, index,
                            "a friction of 0 or more, found " + short_text(p.friction));
        return Ok{};
    }
};

template <class Part>
Status check_all(const PbdParts& parts, PbdMethod method, const char* what,
                 const std::vector<Part>& all) {
    if (all.size() > std::size_t(INT32_MAX) / 2)
        return invalid(std::string(what) + "s: expected at most 1073741823, found " +
                       std::to_string(all.size()));
    for (std::size_t n = 0; n < all.size(); ++n)
        if (const Status s = Checker{parts, method, what, n}(all[n]); !s.ok()) return s;
    return Ok{};
}

}  // namespace

Status check_inverse_mass(const char* what, std::size_t particle, double inverse_mass) {
    if (is_amount(inverse_mass)) return Ok{};
    return bad_part(what, particle,
                    "an inverse mass of 0 or more, found " + short_text(inverse_mass) +
                        (std::isinf(inverse_mass) ? ": a mass of 0" : ""));
}

Status check_state(Vec3d position, Vec3d velocity) {
    if (!is_finite(position) || !is_finite(velocity))
        return invalid("set_state: expected a position and a velocity of three numbers");
    return Ok{};
}

Status check_parts(const PbdParts& parts, PbdMethod method) {
    constexpr std::size_t kMost = std::size_t(1) << 29;
    if (parts.positions.empty() || parts.positions.size() > kMost)
        return invalid("positions: expected 1 to " + std::to_string(kMost) + ", found " +
                       std::to_string(parts.positions.size()));
    if (parts.inverse_masses.size() != parts.positions.size())
        return invalid("inverse_masses: expected one for each of " +
                       std::to_string(parts.positions.size()) + " positions, found " +
                       std::to_string(parts.inverse_masses.size()));
    for (std::size_t n = 0; n < parts.positions.size(); ++n) {
        if (!is_finite(parts.positions[n])) return bad_part("position", n, "three numbers");
        if (const Status s = check_inverse_mass("particle", n, parts.inverse_masses[n]); !s.ok())
            return s;
    }
    if (const Status s = check_all(parts, method, "distance", parts.distances); !s.ok()) return s;
    if (const Status s = check_all(parts, method, "bend", parts.bends); !s.ok()) return s;
    if (const Status s = check_all(parts, method, "volume", parts.volumes); !s.ok()) return s;
    if (const Status s = check_all(parts, method, "solid", parts.solids); !s.ok()) return s;
    if (const Status s = check_all(parts, method, "attachment", parts.attachments); !s.ok())
        return s;
    return check_all(parts, method, "plane", parts.planes);
}

Status check_settings(const PbdSettings& s) {
    if (Status status = check(s, pbd_rows()); !status.ok()) return status;
    if (s.damping * s.time_step > s.sub_steps)
        return invalid("damping: expected 0 to " + short_text(s.sub_steps / s.time_step) +
                       ", one over the sub-step, found " + short_text(s.damping));
    if (s.volume_recovery > s.damping)
        return invalid("volume_recovery: expected 0 to " + short_text(s.damping) +
                       ", the damping, found " + short_text(s.volume_recovery));
    if (s.alternates && s.iterations % 2 != 0)
        return invalid("iterations: expected an even number where they go to and fro, found " +
                       std::to_string(s.iterations));
    return Ok{};
}

}  // namespace pliant::pbd
