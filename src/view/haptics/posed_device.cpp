// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "haptics/posed_device.h"

#include <cmath>
#include <numbers>

#include "haptics/pace.h"

namespace pliant {
namespace {

constexpr double kSmooth_s = 0.012;  ///< time constant of the smoothing
constexpr std::int64_t kLost_ns = 500'000'000;

class PosedDevice : public HapticDevice {
  public:
    PosedDevice(std::shared_ptr<PosedPositions> positions, const char* name)
        : m_positions(std::move(positions)), m_name(name) {}

    std::string name() const override { return m_name; }
    HapticLimits limits() const override { return {8, 1000, 5, {200, 200, 200}}; }
    bool read(HapticReading& reading) noexcept override {
        if (const PosedPosition* said = m_positions->read()) m_said = *said;
        const std::int64_t now = steady_now_ns();
        if (m_said.said_ns == 0 || now - m_said.said_ns > kLost_ns) return false;
        if (m_last_ns == 0) {
            m_position_mm = m_said.position_mm;
            m_roll_rad = m_said.roll_rad;
        }
        const double passed_s = m_last_ns == 0 ? 0 : 1e-9 * double(now - m_last_ns);
        m_position_mm = posed_step(m_position_mm, m_said.position_mm, passed_s);
        m_roll_rad = posed_step({m_roll_rad, 0, 0}, {m_said.roll_rad, 0, 0}, passed_s).x;
        m_last_ns = now;
        reading.position_mm = m_position_mm;
        reading.roll_rad = std::remainder(m_roll_rad, 2 * std::numbers::pi);
        reading.buttons = m_said.buttons;
        return true;
    }
    bool write(Vec3d) noexcept override { return true; }

  private:
    std::shared_ptr<PosedPositions> m_positions;
    const char* m_name;
    PosedPosition m_said;
    Vec3d m_position_mm{0, 0, 0};
    double m_roll_rad = 0;
    std::int64_t m_last_ns = 0;
};

}  // namespace

Vec3d posed_step(Vec3d from_mm, Vec3d to_mm, double passed_s) {
    return from_mm + (1 - std::exp(-passed_s / kSmooth_s)) * (to_mm - from_mm);
}

std::unique_ptr<HapticDevice> make_posed_device(std::shared_ptr<PosedPositions> positions,
                                                const char* name) {
    return std::make_unique<PosedDevice>(std::move(positions), name);
}

}  // namespace pliant
