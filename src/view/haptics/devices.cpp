// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Built-in devices, and the syntax of device names. Plug-ins are in plugin_device.cpp.

#include <pliant/core/files.h>
#include <pliant/core/text.h>
#include <pliant/view/haptics.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <fstream>
#include <sstream>

#include "haptics/pace.h"
#include "haptics/plugin_device.h"
#include "haptics/space_mouse.h"

namespace pliant {
namespace {

constexpr std::array<HapticDeviceKind, 6> kKinds = {{
    {"3D Systems Touch", {3.3, 400, 4, {160, 120, 70}}},
    {"3D Systems Phantom Omni", {3.3, 700, 5, {160, 120, 70}}},
    {"3D Systems Phantom Desktop", {7.9, 1000, 5, {160, 120, 120}}},
    {"3D Systems Phantom Premium 1.5 6DOF", {8.5, 800, 5, {381, 267, 191}}},
    {"3D Systems Phantom Premium 3.0", {22, 1000, 5, {838, 584, 406}}},
    {"any other", {6, 1000, 8, {150, 150, 150}}},
}};

/// The simulated device in real time: each read advances it by the elapsed time.
class RealTimeVirtualDevice : public HapticDevice {
  public:
    explicit RealTimeVirtualDevice(const VirtualDeviceSettings& settings) : m_device(settings) {}

    std::string name() const override { return "virtual"; }
    HapticLimits limits() const override { return {8, 0.8 * stable_n_m(), 5, {200, 200, 200}}; }
    bool read(HapticReading& reading) noexcept override {
        const std::int64_t now = steady_now_ns();
        if (m_last_ns > 0)
            m_device.advance(m_force_n, std::min(1e-9 * double(now - m_last_ns), kLongest_s));
        m_last_ns = now;
        reading.position_mm = m_device.seen_position_mm();
        return true;
    }
    bool write(Vec3d force_n) noexcept override {
        m_force_n = force_n;
        return true;
    }

  private:
    static constexpr double kLongest_s = 0.02;  ///< maximum step after a delay of the machine

    /// 2b/T at 1 kHz [Colgate1997].
    double stable_n_m() const { return 2 * m_device.settings().damping_n_s_m / 1e-3; }

    VirtualDevice m_device;
    Vec3d m_force_n{0, 0, 0};
    std::int64_t m_last_ns = 0;
};

/// Positions from a file, one per period; it stays at the last one.
class ReplayDevice : public HapticDevice {
  public:
    struct Position {
        Vec3d position_mm{0, 0, 0};
        double roll_rad = 0;
    };
    explicit ReplayDevice(std::vector<Position> positions) : m_positions(std::move(positions)) {}

    std::string name() const override { return "replay"; }
    static constexpr double kFarthest_mm = 500;  ///< along an axis
    HapticLimits limits() const override {
        constexpr double kAcross = 2 * kFarthest_mm;
        return {1000, 1e5, 1000, {kAcross, kAcross, kAcross}};
    }
    bool read(HapticReading& reading) noexcept override {
        reading.position_mm = m_positions[m_at].position_mm;
        reading.roll_rad = m_positions[m_at].roll_rad;
        if (m_at + 1 < m_positions.size()) ++m_at;
        return true;
    }
    bool write(Vec3d) noexcept override { return true; }

  private:
    std::vector<Position> m_positions;
    std::size_t m_at = 0;
};

Result<std::unique_ptr<HapticDevice>> open_virtual(const std::string& hand) {
    VirtualDeviceSettings settings;
    settings.coulomb_n = 0.05;
    settings.encoder_mm = 0.02;
    if (hand == "spring" || hand.empty())
        settings.hand = spring_hand({0, 0, 0});
    else if (hand == "active") {
        // The spring keeps the oscillation around a fixed position.
        settings.hand = spring_hand({0, 0, 0}, 100, 1);
        settings.hand.sine_n = {0, 0, 2};
        settings.hand.frequency_hz = 10;
    } else if (hand == "tap") {
        // Moves to and fro by some 8 mm in free space, once in two seconds.
        settings.hand = spring_hand({0, 0, 0});
        settings.hand.sine_n = {0, 0, -2.4};
        settings.hand.frequency_hz = 0.5;
    } else if (hand != "free")
        return Error{ErrorCode::InvalidArgument,
                     "haptic device 'virtual:" + hand +
                         "': expected virtual, virtual:free, virtual:spring, virtual:tap or "
                         "virtual:active"};
    return make_virtual_device(settings);
}

Result<std::unique_ptr<HapticDevice>> open_replay(const std::string& file) {
    const auto wrong = [&](ErrorCode code, const std::string& what) -> Error {
        return {code, "haptic device 'replay:" + file + "': " + what};
    };
    const auto text = read_small_file(file, std::string::npos, "a recording of pliant haptics");
    if (!text) return wrong(text.error().code, text.error().message.substr(file.size() + 2));
    std::istringstream stream(*text);
    std::vector<ReplayDevice::Position> positions;
    std::string line;
    for (int number = 1; std::getline(stream, line); ++number) {
        if (line.empty() || line[0] == '#') continue;
        double values[5] = {};
        const char* at = line.data();
        const char* const end = at + line.size();
        int count = 0;
        for (; count < 5; ++count) {
            while (at != end && *at == ' ') ++at;
            const auto [next, error] = std::from_chars(at, end, values[count]);
            if (error != std::errc{}) break;
            at = next;
        }
        const Vec3d position{values[1], values[2], values[3]};
        const double farthest =
            std::max({std::abs(position.x), std::abs(position.y), std::abs(position.z)});
        if (count < 4 || at != end || !is_finite(position) || !(std::abs(values[4]) <= 4) ||
            farthest > ReplayDevice::kFarthest_mm)
            return wrong(ErrorCode::Unreadable,
                         "line " + std::to_string(number) +
                             ": expected time_ns x y z [roll], within 500 mm and 4 rad");
        positions.push_back({position, values[4]});
    }
    if (positions.empty()) return wrong(ErrorCode::Unreadable, "expected positions, found none");
    return std::unique_ptr<HapticDevice>(std::make_unique<ReplayDevice>(std::move(positions)));
}

}  // namespace

std::span<const HapticDeviceKind> known_haptic_devices() {
    return kKinds;
}

std::unique_ptr<HapticDevice> make_virtual_device(const VirtualDeviceSettings& settings) {
    return std::make_unique<RealTimeVirtualDevice>(settings);
}

Result<std::unique_ptr<HapticDevice>> open_haptic_device(const std::string& what) {
    const auto colon = what.find(':');
    const std::string kind = what.substr(0, colon);
    const std::string rest = colon == std::string::npos ? "" : what.substr(colon + 1);
    if (kind == "virtual") return open_virtual(rest);
    if (kind == "replay") return open_replay(rest);
    if (kind == "spacemouse") return open_space_mouse(rest);
    return open_plugin_device(kind, rest);
}

Status write_haptic_recording(const std::filesystem::path& path,
                              std::span<const HapticRecord> records) {
    StagedFiles files;
    const auto staged = files.stage(path);
    if (!staged.ok()) return staged.error();
    std::ofstream stream(*staged, std::ios::binary);
    stream << "# pliant haptics: time_ns x y z [mm] roll [rad], of the device\n";
    for (const HapticRecord& r : records) {
        stream << std::to_string(r.time_ns);
        for (const double value : {r.device_mm.x, r.device_mm.y, r.device_mm.z, r.roll_rad})
            stream << ' ' << text_of(value);
        stream << '\n';
    }
    stream.close();
    if (!stream)
        return Error{ErrorCode::Unwritable, path.filename().string() + ": can't be written"};
    return files.commit();
}

}  // namespace pliant
