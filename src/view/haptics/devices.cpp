// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Built-in devices, and the syntax of device names.

#include <pliant/core/files.h>
#include <pliant/core/output_file.h>
#include <pliant/core/text.h>
#include <pliant/view/haptics.h>
#include <pliant/view/haptics_device.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <numbers>
#include <sstream>

#include <dlfcn.h>

#include "base/input_file.h"
#include "haptics/pace.h"
#include "haptics/space_mouse.h"

namespace pliant {
namespace {

// Device plug-ins, loaded at run time (pliant/view/haptics_device.h).

constexpr double kPi = std::numbers::pi;

/// Angle of a rotation about z, without its tilt (swing-twist decomposition).
double roll_of(const double (&q)[4]) {
    return q[0] == 0 && q[3] == 0 ? 0 : std::remainder(2 * std::atan2(q[3], q[0]), 2 * kPi);
}

class PluginDevice : public HapticDevice {
  public:
    PluginDevice(void* library, const pliant_haptic_device& plugin, void* device,
                 const HapticLimits& limits)
        : m_library(library), m_plugin(plugin), m_device(device), m_limits(limits) {}
    ~PluginDevice() override {
        m_plugin.close(m_device);
        dlclose(m_library);
    }

    std::string name() const override { return m_plugin.name ? m_plugin.name : "plug-in"; }
    HapticLimits limits() const override { return m_limits; }
    bool read(HapticReading& reading) noexcept override {
        pliant_haptic_pose pose{};
        if (m_plugin.read(m_device, &pose) != 0) return false;
        reading.position_mm = {pose.position_mm[0], pose.position_mm[1], pose.position_mm[2]};
        reading.buttons = pose.buttons;
        reading.roll_rad = roll_of(pose.orientation);
        return is_finite(reading.position_mm) && std::isfinite(reading.roll_rad);
    }
    bool write(Vec3d force_n) noexcept override {
        const double force[3] = {force_n.x, force_n.y, force_n.z};
        return m_plugin.write(m_device, force) == 0;
    }

  private:
    void* m_library;
    const pliant_haptic_device& m_plugin;
    void* m_device;
    HapticLimits m_limits;
};

/// Reads the limits of the plug-in's device; false if they are implausible.
bool get_limits(const pliant_haptic_device& plugin, void* device, HapticLimits& limits) {
    pliant_haptic_limits l{};
    if (plugin.get_limits(device, &l) != 0) return false;
    limits = {l.max_force_n,
              l.max_stiffness_n_m,
              l.max_damping_n_s_m,
              {l.workspace_mm[0], l.workspace_mm[1], l.workspace_mm[2]}};
    const auto is_good = [](double v) { return v >= 0 && std::isfinite(v); };
    return is_good(limits.max_force_n) && is_good(limits.max_stiffness_n_m) &&
           is_good(limits.max_damping_n_s_m);
}

/// Returns the library's export if it suits this version of Pliant.
Result<const pliant_haptic_device*> plugin_of(void* library, const std::string& name) {
    const auto wrong = [&](const std::string& what) -> Error {
        return {ErrorCode::Unsupported, "haptic device '" + name + "': " + what};
    };
    void* const symbol = dlsym(library, "pliant_haptic_device_v1");
    if (!symbol)
        return wrong(
            "expected a plug-in that exports pliant_haptic_device_v1(), found none in it; "
            "examples/haptic_device has one to begin with");
    const auto get = reinterpret_cast<pliant_haptic_device_function>(symbol);
    const pliant_haptic_device* const plugin = get();
    if (!plugin) return wrong("expected a device of pliant_haptic_device_v1(), found null");
    if (plugin->version != PLIANT_HAPTIC_DEVICE_VERSION ||
        plugin->size != sizeof(pliant_haptic_device))
        return wrong("expected version " + std::to_string(PLIANT_HAPTIC_DEVICE_VERSION) + " with " +
                     std::to_string(sizeof(pliant_haptic_device)) + " bytes, found version " +
                     std::to_string(plugin->version) + " with " + std::to_string(plugin->size) +
                     "; build it anew with this pliant/view/haptics_device.h");
    if (!plugin->open || !plugin->get_limits || !plugin->read || !plugin->write || !plugin->close)
        return wrong("expected the functions open, get_limits, read, write and close");
    return plugin;
}

Result<std::unique_ptr<HapticDevice>> open_plugin_device(const std::string& library_name,
                                                         const std::string& which) {
    if (library_name.empty())
        return Error{
            ErrorCode::InvalidArgument,
            "haptic device: expected virtual, replay:FILE, spacemouse or a plug-in's file"};
    std::string why;
    void* const library = load_library(library_name, why);
    if (!library) {
        return Error{
            ErrorCode::NotFound,
            "haptic device '" + library_name +
                "': expected virtual, replay:FILE, spacemouse or a "
                "plug-in that can be loaded: " +
                why +
                "; build one from examples/haptic_device with your device's kit, and name it "
                "with its path"};
    }
    const auto plugin = plugin_of(library, library_name);
    if (!plugin.ok()) {
        dlclose(library);
        return plugin.error();
    }
    void* device = nullptr;
    char message[256] = "";
    if ((*plugin)->open(which.c_str(), &device, message, sizeof message) != 0) {
        message[sizeof message - 1] = 0;
        Error error{ErrorCode::NotFound, "haptic device '" + library_name + "': " +
                                             (message[0] ? message : "it could not be opened")};
        dlclose(library);
        return error;
    }
    HapticLimits limits;
    if (!get_limits(**plugin, device, limits)) {
        (*plugin)->close(device);
        dlclose(library);
        return Error{ErrorCode::Unsupported,
                     "haptic device '" + library_name +
                         "': expected limits of 0 or more for force, stiffness and damping"};
    }
    return std::unique_ptr<HapticDevice>(
        std::make_unique<PluginDevice>(library, **plugin, device, limits));
}

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

constexpr double kMetresPerMm = 1e-3;

double energy_of(double mass_kg, Vec3d velocity_mm_s) {
    return 0.5 * mass_kg * kMetresPerMm * kMetresPerMm * dot(velocity_mm_s, velocity_mm_s);
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
    OutputFile file(*staged, path.filename().string());
    file.write("# pliant haptics: time_ns x y z [mm] roll [rad], of the device\n");
    for (const HapticRecord& r : records) {
        file.write(std::to_string(r.time_ns));
        for (const double value : {r.device_mm.x, r.device_mm.y, r.device_mm.z, r.roll_rad})
            file.write(' ' + text_of(value));
        file.write("\n");
    }
    if (const Status s = file.close(); !s.ok()) return s;
    return files.commit();
}

// A mass in equal small steps: half kick, drift, half kick (leapfrog), with negligible energy error
// of the integrator; friction is exact. The work of each force is computed from its change of
// speed, so the sum of all work is the kinetic energy.

VirtualHand spring_hand(Vec3d target_mm, double stiffness_n_m, double damping_n_s_m) {
    VirtualHand hand;
    hand.stiffness_n_m = stiffness_n_m;
    hand.damping_n_s_m = damping_n_s_m;
    hand.target_mm = target_mm;
    return hand;
}

VirtualHand active_hand(Vec3d amplitude_n, double frequency_hz) {
    VirtualHand hand;
    hand.sine_n = amplitude_n;
    hand.frequency_hz = frequency_hz;
    return hand;
}

VirtualDevice::VirtualDevice(const VirtualDeviceSettings& settings)
    : m_settings(settings),
      m_position_mm(settings.position_mm),
      m_velocity_mm_s(settings.velocity_mm_s) {}

Vec3d VirtualDevice::hand_force_n() const {
    const VirtualHand& hand = m_settings.hand;
    const double phase = 2 * std::numbers::pi * hand.frequency_hz * m_time_s;
    return hand.steady_n + std::sin(phase) * hand.sine_n +
           (kMetresPerMm * hand.stiffness_n_m) * (hand.target_mm - m_position_mm);
}

double VirtualDevice::kinetic_j() const {
    return energy_of(m_settings.mass_kg, m_velocity_mm_s);
}

void VirtualDevice::kick(Vec3d servo_n, double seconds) {
    const Vec3d hand_n = hand_force_n();
    const Vec3d before = m_velocity_mm_s;
    m_velocity_mm_s = before + (seconds / (m_settings.mass_kg * kMetresPerMm)) * (servo_n + hand_n);
    const Vec3d way_m = (0.5 * kMetresPerMm * seconds) * (before + m_velocity_mm_s);
    m_work_of_servo_j += dot(servo_n, way_m);
    m_work_of_hand_j += dot(hand_n, way_m);
}

void VirtualDevice::rub(double seconds) {
    const double own = m_settings.damping_n_s_m, hand = m_settings.hand.damping_n_s_m;
    if (own + hand > 0) {
        const double before = kinetic_j();
        m_velocity_mm_s = std::exp(-(own + hand) * seconds / m_settings.mass_kg) * m_velocity_mm_s;
        const double taken = before - kinetic_j();
        m_lost_j += own / (own + hand) * taken;
        m_work_of_hand_j -= hand / (own + hand) * taken;
    }
    const double speed = norm(m_velocity_mm_s);
    if (m_settings.coulomb_n > 0 && speed > 0) {
        const double before = kinetic_j();
        const double slower = m_settings.coulomb_n * seconds / (m_settings.mass_kg * kMetresPerMm);
        m_velocity_mm_s = std::max(0.0, 1 - slower / speed) * m_velocity_mm_s;
        m_lost_j += before - kinetic_j();
    }
}

void VirtualDevice::advance(Vec3d force_n, double seconds) {
    const double h = seconds / m_settings.sub_steps;
    for (int s = 0; s < m_settings.sub_steps; ++s) {
        kick(force_n, h / 2);
        rub(h / 2);
        m_position_mm = m_position_mm + h * m_velocity_mm_s;
        m_time_s += h;
        rub(h / 2);
        kick(force_n, h / 2);
    }
    m_lowest_passivity_j = std::min(m_lowest_passivity_j, passivity_j());
}

Vec3d VirtualDevice::seen_position_mm() const {
    const double step = m_settings.encoder_mm;
    if (!(step > 0)) return m_position_mm;
    Vec3d seen{};
    for (int a = 0; a < 3; ++a) seen[a] = step * std::round(m_position_mm[a] / step);
    return seen;
}

}  // namespace pliant
