// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The servo on a thread of its own, and the devices that it can run.
//
//   auto device = open_haptic_device("virtual:active");          // or "./libmaker.so"
//   auto servo = HapticServo::start(std::move(*device), {});
//   // 30 times a second:
//   (*servo)->post(*checked_model(model, (*servo)->largest_stiffness_n_m()));
//   const HapticRecord now = (*servo)->latest();  // position of the tool, and its force
//
// The thread takes no lock, allocates nothing and prints nothing; models reach it by one atomic
// exchange, and what it did goes into a ring that anybody may read.

#pragma once

#include <pliant/haptics_virtual.h>

#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#pragma GCC visibility push(default)
namespace pliant {

struct HapticLimits {
    double max_force_n = 3;
    double max_stiffness_n_m = 600;
    double max_damping_n_s_m = 5;
    Vec3d workspace_mm{150, 150, 150};
};

/// A kind of device, and what is known of it.
struct HapticDeviceKind {
    std::string_view name;
    HapticLimits limits;
};
/// Force, stiffness and damping as CHAI3D has them for the makers' devices.
std::span<const HapticDeviceKind> known_haptic_devices();

class HapticDevice {
  public:
    virtual ~HapticDevice() = default;
    virtual std::string name() const = 0;
    virtual HapticLimits limits() const = 0;
    // On the servo's thread: no lock, no allocation, no waiting.
    /// @param[out] reading  place, roll and buttons; its time is when it is asked for
    virtual bool read(HapticReading& reading) noexcept = 0;
    virtual bool write(Vec3d force_n) noexcept = 0;
};

/// `virtual[:free|spring|tap|active]`, `replay:FILE`, `spacemouse[:LIBRARY]` (libspnav, loaded
/// now), or a plug-in: `FILE.so[:WHICH]`, a path with a / in it or a name that the system's loader
/// knows.
/// @returns NotFound, Unsupported or Unreadable, with one line that says what is missing and what
///          to do
Result<std::unique_ptr<HapticDevice>> open_haptic_device(const std::string& what);
/// Moves in real time, whoever holds it.
std::unique_ptr<HapticDevice> make_virtual_device(const VirtualDeviceSettings& settings);

/// What happened in one period. Times from the servo's start.
struct HapticRecord {
    std::int64_t period = 0;  ///< from 0
    std::int64_t time_ns = 0;
    std::int64_t period_ns = 0;   ///< since the one before
    std::int64_t compute_ns = 0;  ///< to read, compute and write
    std::int64_t age_ns = -1;     ///< of the model; −1: there is none
    std::int64_t model = 0;       ///< its number
    Vec3d position_mm{0, 0, 0};   ///< of the tool in the scene
    Vec3d proxy_mm{0, 0, 0};
    Vec3d force_n{0, 0, 0};    ///< on the tool, in the scene
    double swap_step_n = 0;    ///< HapticState's
    double energy_j = 0;       ///< work of the device on the servo so far
    Vec3d device_mm{0, 0, 0};  ///< as it was read: what replay needs
    double roll_rad = 0;       ///< likewise
    std::uint32_t flags = 0;   ///< HapticFlags
    std::uint32_t buttons = 0;
};

/// Writes a line for each period, to be opened as `replay:FILE`: time_ns x y z [mm] roll [rad], of
/// the device.
Status write_haptic_recording(const std::filesystem::path& path,
                              std::span<const HapticRecord> records);

struct HapticServoSettings {
    HapticSettings step{};
    double rate_hz = 1000;  ///< 500…5000
    int priority = 40;      ///< real-time, where the system allows it; 0: none
};

class HapticServo {
  public:
    /// Limits of the device hold beside those of the settings.
    /// @returns InvalidArgument that names the setting
    static Result<std::unique_ptr<HapticServo>> start(std::unique_ptr<HapticDevice> device,
                                                      const HapticServoSettings& settings);
    /// Ends the force, the thread and the device.
    ~HapticServo();
    HapticServo(const HapticServo&) = delete;
    HapticServo& operator=(const HapticServo&) = delete;

    /// From one thread. @param model  as checked_model() made it, with an ascending number
    void post(const HapticModel& model);
    double largest_stiffness_n_m() const;  ///< in the scene

    /// Force goes to 0, and stays there until it may come back.
    void set_stop(bool stop);

    HapticRecord latest() const;
    /// Records from number `next` on, which is moved on. @param[out] lost  too old to be read,
    /// added
    std::size_t read(std::uint64_t& next, std::span<HapticRecord> records,
                     std::uint64_t& lost) const;

    const HapticDevice& device() const;
    /// Whether the system gave real-time priority; if not, one line with what would.
    bool is_real_time() const;
    const std::string& note() const;

  private:
    struct Impl;
    explicit HapticServo(std::unique_ptr<Impl> impl);
    std::unique_ptr<Impl> m_impl;
};

/// A loop that does nothing but keep time: what the machine alone makes of it.
class IdleLoop {
  public:
    explicit IdleLoop(double rate_hz, int priority = 40);
    ~IdleLoop();
    IdleLoop(const IdleLoop&) = delete;
    IdleLoop& operator=(const IdleLoop&) = delete;

    /// Periods since the last call [ns].
    std::vector<std::int64_t> take();

  private:
    struct Impl;
    std::unique_ptr<Impl> m_impl;
};

}  // namespace pliant
#pragma GCC visibility pop
