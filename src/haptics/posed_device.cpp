// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "haptics/posed_device.h"

#include <cmath>

#include "haptics/pace.h"

namespace pliant {
namespace {

constexpr double kSmooth_s = 0.012;  ///< in which 1 − 1/e of the way to a new place is gone
constexpr std::int64_t kLost_ns = 500'000'000;

class PosedDevice : public HapticDevice {
  public:
    explicit PosedDevice(std::shared_ptr<PosedPlaces> places) : m_places(std::move(places)) {}

    std::string name() const override { return "browser"; }
    HapticLimits limits() const override { return {8, 1000, 5, {200, 200, 200}}; }
    bool read(HapticReading& reading) noexcept override {
        if (const PosedPlace* said = m_places->read()) m_said = *said;
        const std::int64_t now = steady_now_ns();
        if (m_said.said_ns == 0 || now - m_said.said_ns > kLost_ns) return false;
        m_place_mm = m_last_ns == 0 ? m_said.position_mm
                                    : posed_step(m_place_mm, m_said.position_mm,
                                                 1e-9 * double(now - m_last_ns));
        m_last_ns = now;
        reading.position_mm = m_place_mm;
        return true;
    }
    bool write(Vec3d) noexcept override { return true; }

  private:
    std::shared_ptr<PosedPlaces> m_places;
    PosedPlace m_said;
    Vec3d m_place_mm{0, 0, 0};
    std::int64_t m_last_ns = 0;
};

}  // namespace

Vec3d posed_step(Vec3d from_mm, Vec3d to_mm, double passed_s) {
    return from_mm + (1 - std::exp(-passed_s / kSmooth_s)) * (to_mm - from_mm);
}

std::unique_ptr<HapticDevice> make_posed_device(std::shared_ptr<PosedPlaces> places) {
    return std::make_unique<PosedDevice>(std::move(places));
}

}  // namespace pliant
