// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "hub/catheter_grip.h"

#include <cmath>
#include <utility>

#include "protocol/limits.h"
#include "session/vessel_tissue.h"

namespace pliant::serve {
namespace {

constexpr double kCoupling_n_m = 300;  ///< at the device
// Smaller changes of speed cause no command.
constexpr double kSame_mm_s = 0.2, kSame_deg_s = 1;

/// Rounds to hundredths, for short records.
double in_hundredths(double value) {
    return std::round(100 * value) / 100;
}
bool differs(double a, double b, double same) {
    return (a == 0) != (b == 0) || std::abs(a - b) > same;
}

}  // namespace

Vec3d forward_of(const VesselTissue& vessel) {
    return normalized(vessel.made().settings.entry.direction);
}

Result<CatheterGrip> CatheterGrip::create(const VesselTissue& vessel, std::uint32_t tool,
                                          double scale) {
    auto feel = CatheterFeel::create({.forward = forward_of(vessel),
                                      .coupling_n_m = kCoupling_n_m / scale,
                                      .length_mm = vessel.made().settings.catheter.length_mm,
                                      .max_mm_s = kMaxInsert_mm_s,
                                      .max_deg_s = kMaxRotate_deg_s});
    if (!feel.ok()) return feel.error();
    return CatheterGrip(std::move(*feel), tool);
}

std::optional<Action> CatheterGrip::next(const HapticRecord& now, bool lets_go,
                                         const Scene& scene) {
    const VesselTissue& vessel = *scene.catheter();
    if (lets_go || (now.buttons & 1) || !vessel.failure().empty()) {
        m_feel.let_go();
        if (scene.has_contact(m_tool)) return ReleaseCommand{};
        return {};
    }
    const CatheterMeasures measures = vessel.measures();
    // After a reset the wire's position has changed, so the hand takes a new hold.
    if (!m_feel.holds() || measures.time_s < m_time_s)
        m_feel.take_hold(now.position_mm, now.roll_rad, measures);
    m_time_s = measures.time_s;
    m_turns = m_turns || now.roll_rad != 0;
    const CatheterFeel::Motion motion = m_feel.follow(now.position_mm, now.roll_rad, measures);
    const double insert = in_hundredths(motion.insert_mm_s);
    const double rotate = in_hundredths(motion.rotate_deg_s);
    DriveCommand drive;
    if (differs(insert, vessel.hand().insert_mm_s, kSame_mm_s)) drive.insert_mm_s = insert;
    // Without a device that measures rotation, the keys rotate the wire.
    if (m_turns && differs(rotate, vessel.hand().rotate_deg_s, kSame_deg_s))
        drive.rotate_deg_s = rotate;
    if (!drive.insert_mm_s && !drive.rotate_deg_s) return {};
    return drive;
}

std::optional<HapticModel> CatheterGrip::model(const HapticRecord& now,
                                               const VesselTissue& vessel) const {
    if (!vessel.failure().empty()) return {};
    return m_feel.model(now.position_mm, vessel.measures());
}

double CatheterGrip::ahead_mm(const HapticRecord& now, const VesselTissue& vessel) const {
    return m_feel.holds() ? m_feel.ahead_mm(now.position_mm, vessel.measures()) : 0;
}

}  // namespace pliant::serve
