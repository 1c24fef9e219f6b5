// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "haptics/space_mouse.h"

#include <dlfcn.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <system_error>
#include <thread>

#include "base/input_file.h"
#include "haptics/pace.h"
#include "haptics/posed_device.h"

namespace pliant {
namespace {

// From libspnav's documentation; its header isn't needed.
constexpr int kMotion = 1, kButton = 2;
struct SpnavMotion {
    int type, x, y, z, rx, ry, rz;
    unsigned period;
    int* data;
};
struct SpnavButton {
    int type, press, number;
};
union SpnavEvent {
    int type;
    SpnavMotion motion;
    SpnavButton button;
    char room[256];  // newer versions have longer events
};

constexpr double kFull = 350;  ///< full deflection of the cap
constexpr double kDeadZone = 0.05;
constexpr double kFastest_mm_s = 40, kFastest_rad_s = 3;
constexpr double kFarthest_mm = 100;
constexpr std::chrono::milliseconds kBeat{4};

double curved(double number) {
    const double share = std::abs(number) / kFull;
    const double over = std::clamp((share - kDeadZone) / (1 - kDeadZone), 0.0, 1.0);
    return std::copysign(over * over, number);
}

Error wrong_mouse(ErrorCode code, const std::string& what) {
    return {code, "haptic device 'spacemouse': " + what};
}

class SpaceMouse : public HapticDevice {
  public:
    using Poll = int (*)(SpnavEvent*);
    using Close = int (*)();

    SpaceMouse(void* library, Poll poll, Close close)
        : m_library(library), m_poll(poll), m_close(close) {}
    ~SpaceMouse() override {
        m_quit.store(true, std::memory_order_relaxed);
        if (m_thread.joinable()) m_thread.join();
        m_close();
        dlclose(m_library);
    }
    /// @returns false if the system has no thread left
    bool start() {
        try {
            m_thread = std::thread([this] { follow(); });
        } catch (const std::system_error&) {
            return false;
        }
        return true;
    }

    std::string name() const override { return m_device->name(); }
    HapticLimits limits() const override { return m_device->limits(); }
    bool read(HapticReading& reading) noexcept override { return m_device->read(reading); }
    bool write(Vec3d force_n) noexcept override { return m_device->write(force_n); }

  private:
    /// Reads libspnav's socket, which the servo's thread must not do.
    void follow() {
        CapPosition position;
        CapMotion motion;
        std::uint32_t buttons = 0;
        for (std::int64_t last = steady_now_ns(); !m_quit.load(std::memory_order_relaxed);) {
            SpnavEvent event{};
            while (m_poll(&event) != 0) take(event, motion, buttons);
            const std::int64_t now = steady_now_ns();
            position = cap_moved(position, motion, 1e-9 * double(now - last));
            last = now;
            m_positions->write({now, position.position_mm, position.roll_rad, buttons});
            std::this_thread::sleep_for(kBeat);
        }
    }
    static void take(const SpnavEvent& event, CapMotion& motion, std::uint32_t& buttons) {
        if (event.type == kMotion) {
            const SpnavMotion& m = event.motion;
            motion = {double(m.x), double(m.y), double(m.z), double(m.rz)};
        } else if (event.type == kButton && event.button.number >= 0 && event.button.number < 32) {
            const std::uint32_t bit = std::uint32_t(1) << event.button.number;
            buttons = event.button.press ? buttons | bit : buttons & ~bit;
        }
    }

    void* m_library;
    Poll m_poll;
    Close m_close;
    std::shared_ptr<PosedPositions> m_positions = std::make_shared<PosedPositions>();
    std::unique_ptr<HapticDevice> m_device = make_posed_device(m_positions, "SpaceMouse");
    std::atomic<bool> m_quit{false};
    std::thread m_thread;
};

void* load(const std::string& library, std::string& why) {
    if (!library.empty()) return load_library(library, why);
    void* const found = load_library("libspnav.so.0", why);
    return found ? found : load_library("libspnav.so", why);
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

CapPosition cap_moved(const CapPosition& from, const CapMotion& motion, double passed_s) {
    // libspnav's third axis points away from the user; its helper moves objects that way.
    const Vec3d speed =
        kFastest_mm_s * Vec3d{curved(motion.x), curved(motion.y), -curved(motion.z)};
    CapPosition to = from;
    for (int a = 0; a < 3; ++a)
        to.position_mm[a] =
            std::clamp(from.position_mm[a] + passed_s * speed[a], -kFarthest_mm, kFarthest_mm);
    to.roll_rad -= passed_s * kFastest_rad_s * curved(motion.roll);
    return to;
}

Result<std::unique_ptr<HapticDevice>> open_space_mouse(const std::string& library) {
    std::string why;
    void* const loaded = load(library, why);
    if (!loaded)
        return wrong_mouse(ErrorCode::NotFound,
                           "expected libspnav on this machine, found none: " + why +
                               "; install it with its daemon (Debian: libspnav0 and spacenavd)");
    const auto open = reinterpret_cast<int (*)()>(dlsym(loaded, "spnav_open"));
    const auto close = reinterpret_cast<SpaceMouse::Close>(dlsym(loaded, "spnav_close"));
    const auto poll = reinterpret_cast<SpaceMouse::Poll>(dlsym(loaded, "spnav_poll_event"));
    if (!open || !close || !poll) {
        dlclose(loaded);
        return wrong_mouse(ErrorCode::Unsupported,
                           "expected spnav_open, spnav_close and spnav_poll_event in the library, "
                           "found not all of them; install libspnav 0.2 or later");
    }
    if (open() == -1) {
        dlclose(loaded);
        return wrong_mouse(ErrorCode::NotFound,
                           "expected the daemon spacenavd to run, found none that answers; start "
                           "it (systemctl start spacenavd), with the device plugged in");
    }
    auto mouse = std::make_unique<SpaceMouse>(loaded, poll, close);
    if (!mouse->start())
        return wrong_mouse(ErrorCode::LimitExceeded, "expected room for one more thread");
    return std::unique_ptr<HapticDevice>(std::move(mouse));
}

}  // namespace pliant
