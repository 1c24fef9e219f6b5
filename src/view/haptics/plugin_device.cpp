// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "haptics/plugin_device.h"

#include <dlfcn.h>
#include <pliant/view/haptics_device.h>

#include <cmath>
#include <numbers>

#include "base/input_file.h"

namespace pliant {
namespace {

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

}  // namespace

void* load_library(const std::string& name, std::string& why) {
    // The loader would wait for a pipe.
    const auto type = type_of(name);
    const bool may_wait = type && *type != std::filesystem::file_type::regular &&
                          *type != std::filesystem::file_type::not_found;
    void* const loaded = may_wait ? nullptr : dlopen(name.c_str(), RTLD_NOW | RTLD_LOCAL);
    if (loaded || !why.empty()) return loaded;
    const char* const error = may_wait ? nullptr : dlerror();
    why = error ? error : name + " is no regular file";
    return nullptr;
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

}  // namespace pliant
