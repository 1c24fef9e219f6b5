// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The servo thread, and the devices that it can run.
//
//   auto device = open_haptic_device("virtual:active");          // or "./libmaker.so"
//   auto servo = HapticServo::start(std::move(*device), {});
//   // 30 times a second:
//   (*servo)->post(*checked_model(model, (*servo)->largest_stiffness_n_m()));
//   const HapticRecord now = (*servo)->latest();  // position of the tool, and its force
//
// The thread takes no lock, doesn't allocate and prints nothing. Models reach it by one atomic
// exchange. It writes its records to a ring that every thread may read.

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

/// A kind of device and its limits.
struct HapticDeviceKind {
    std::string_view name;
    HapticLimits limits;
};
/// Known devices, with force, stiffness and damping as in CHAI3D.
std::span<const HapticDeviceKind> known_haptic_devices();

class HapticDevice {
  public:
    virtual ~HapticDevice() = default;
    virtual std::string name() const = 0;
    virtual HapticLimits limits() const = 0;
    // Called on the servo's thread: no lock, no allocation, no waiting.
    /// @param[out] reading  position, roll and buttons, at the time of the call
    virtual bool read(HapticReading& reading) noexcept = 0;
    virtual bool write(Vec3d force_n) noexcept = 0;
};

/// Opens `virtual[:free|spring|tap|active]`, `replay:FILE`, `spacemouse[:LIBRARY]` (loads libspnav
/// now), or a plug-in: `FILE.so[:WHICH]`, a path with a / in it or a name known to the system's
/// loader.
/// @returns NotFound, Unsupported or Unreadable, with one line that names the missing part and the
///          remedy
Result<std::unique_ptr<HapticDevice>> open_haptic_device(const std::string& what);
/// Creates a simulated device that moves in real time.
std::unique_ptr<HapticDevice> make_virtual_device(const VirtualDeviceSettings& settings);

/// Record of one period. Times count from the servo's start.
struct HapticRecord {
    std::int64_t period = 0;  ///< from 0
    std::int64_t time_ns = 0;
    std::int64_t period_ns = 0;   ///< since the previous period
    std::int64_t compute_ns = 0;  ///< to read, compute and write
    std::int64_t age_ns = -1;     ///< age of the model; −1: no model
    std::int64_t model = 0;       ///< number of the model
    Vec3d position_mm{0, 0, 0};   ///< of the tool in the scene
    Vec3d proxy_mm{0, 0, 0};
    Vec3d force_n{0, 0, 0};    ///< on the tool, in the scene
    double swap_step_n = 0;    ///< as in HapticState
    double energy_j = 0;       ///< work of the device on the servo so far
    Vec3d device_mm{0, 0, 0};  ///< raw reading, for replay
    double roll_rad = 0;       ///< raw reading, for replay
    std::uint32_t flags = 0;   ///< HapticFlags
    std::uint32_t buttons = 0;
};

/// Writes one line per period for `replay:FILE`: time_ns x y z [mm] roll [rad], in the device's
/// frame.
Status write_haptic_recording(const std::filesystem::path& path,
                              std::span<const HapticRecord> records);

struct HapticServoSettings {
    HapticSettings step{};
    double rate_hz = 1000;  ///< 500…5000
    int priority = 40;      ///< real-time priority, if the system allows it; 0: none
};

class HapticServo {
  public:
    /// Starts the thread. The limits of the device and of the settings both hold.
    /// @returns InvalidArgument that names the setting
    static Result<std::unique_ptr<HapticServo>> start(std::unique_ptr<HapticDevice> device,
                                                      const HapticServoSettings& settings);
    /// Ramps the force down and stops the thread and the device.
    ~HapticServo();
    HapticServo(const HapticServo&) = delete;
    HapticServo& operator=(const HapticServo&) = delete;

    /// Posts a model, always from the same thread. @param model  from checked_model(), ascending
    /// number
    void post(const HapticModel& model);
    double largest_stiffness_n_m() const;  ///< in the scene

    /// Ramps the force to 0, and keeps it there until a call with false.
    void set_stop(bool stop);

    HapticRecord latest() const;
    /// Reads records from number `next` on, and advances `next`. @param[out] lost  incremented by
    /// the number of overwritten records
    std::size_t read(std::uint64_t& next, std::span<HapticRecord> records,
                     std::uint64_t& lost) const;

    const HapticDevice& device() const;
    /// Whether the system granted real-time priority; if not, note() is one line with the remedy.
    bool is_real_time() const;
    const std::string& note() const;

  private:
    struct Impl;
    explicit HapticServo(std::unique_ptr<Impl> impl);
    std::unique_ptr<Impl> m_impl;
};

/// A loop that only keeps time: measures the jitter of the machine.
class IdleLoop {
  public:
    explicit IdleLoop(double rate_hz, int priority = 40);
    ~IdleLoop();
    IdleLoop(const IdleLoop&) = delete;
    IdleLoop& operator=(const IdleLoop&) = delete;

    /// Returns the periods since the last call [ns].
    std::vector<std::int64_t> take();

  private:
    struct Impl;
    std::unique_ptr<Impl> m_impl;
};

}  // namespace pliant
#pragma GCC visibility pop
