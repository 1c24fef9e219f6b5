// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "hub/catheter_grip.h"

#include <cmath>
#include <utility>

#include "protocol/limits.h"

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

Result<CatheterGrip> CatheterGrip::create(const Drivable& catheter, std::uint32_t tool,
                                          double scale) {
    auto feel = CatheterFeel::create({.forward = normalized(catheter.entry().direction),
                                      .coupling_n_m = kCoupling_n_m / scale,
                                      .length_mm = catheter.length_mm(),
                                      .max_mm_s = kMaxInsert_mm_s,
                                      .max_deg_s = kMaxRotate_deg_s});
    if (!feel.ok()) return feel.error();
    return CatheterGrip(std::move(*feel), tool);
}

std::optional<Action> CatheterGrip::next(const HapticRecord& now, bool lets_go,
                                         const Scene& scene) {
    const Drivable& catheter = *scene.tissue().drivable();
    if (lets_go || (now.buttons & 1) || !catheter.failure().empty()) {
        m_feel.let_go();
        if (scene.has_contact(m_tool)) return ReleaseCommand{};
        return {};
    }
    const CatheterMeasures measures = catheter.measures();
    // After a reset the wire's position has changed, so the hand takes a new hold.
    if (!m_feel.holds() || measures.time_s < m_time_s)
        m_feel.take_hold(now.position_mm, now.roll_rad, measures);
    m_time_s = measures.time_s;
    m_turns = m_turns || now.roll_rad != 0;
    const CatheterCommand hand = catheter.hand();
    const CatheterFeel::Motion motion = m_feel.follow(now.position_mm, now.roll_rad, measures);
    const double insert = in_hundredths(motion.insert_mm_s);
    const double rotate = in_hundredths(motion.rotate_deg_s);
    DriveCommand drive;
    if (differs(insert, hand.insert_mm_s, kSame_mm_s)) drive.insert_mm_s = insert;
    // Without a device that measures rotation, the keys rotate the wire.
    if (m_turns && differs(rotate, hand.rotate_deg_s, kSame_deg_s)) drive.rotate_deg_s = rotate;
    if (!drive.insert_mm_s && !drive.rotate_deg_s) return {};
    return drive;
}

std::optional<HapticModel> CatheterGrip::model(const HapticRecord& now,
                                               const Drivable& catheter) const {
    if (!catheter.failure().empty()) return {};
    return m_feel.model(now.position_mm, catheter.measures());
}

double CatheterGrip::ahead_mm(const HapticRecord& now, const Drivable& catheter) const {
    return m_feel.holds() ? m_feel.ahead_mm(now.position_mm, catheter.measures()) : 0;
}

}  // namespace pliant::serve
