// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A SpaceMouse through a library that is found when it is asked for: a fake one, and none.

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <cstdlib>
#include <string>
#include <thread>

#include "haptics/space_mouse.h"

namespace pliant {
namespace {

constexpr const char* kFake = "spacemouse:" PLIANT_FAKE_SPNAV_LIBRARY;

TEST(SpaceMouse, MovesAsItsCapIsHeld) {
    for (int time = 0; time < 2; ++time) {  // and again, once it is closed
        auto device = open_haptic_device(kFake);
        ASSERT_TRUE(device.ok()) << device.error().message;
        EXPECT_EQ((*device)->name(), "SpaceMouse");
        EXPECT_TRUE((*device)->write({0, 0, 1}));
        // Pushed to the right and away, and turned: it goes on as long as it is held so.
        HapticReading reading;
        for (int n = 0; n < 2000 && !(reading.position_mm.x > 2); ++n) {
            std::this_thread::sleep_for(std::chrono::milliseconds(5));
            (*device)->read(reading);
        }
        EXPECT_GT(reading.position_mm.x, 2);
        EXPECT_NEAR(reading.position_mm.y, 0, 1e-12);
        EXPECT_NEAR(reading.position_mm.z, -reading.position_mm.x, 1e-9);
        EXPECT_EQ(reading.buttons, 1U);
        EXPECT_NE(reading.roll_rad, 0);
    }
}

TEST(SpaceMouse, GoesWhereAndAsFarAsItMay) {
    const CapPosition right = cap_moved({}, {350, 0, 0, 0}, 0.5);
    EXPECT_NEAR(right.position_mm.x, 20, 1e-9);
    EXPECT_EQ(right.roll_rad, 0);
    // libspnav's third axis leads away from the user, the device's towards him.
    EXPECT_NEAR(cap_moved({}, {0, -350, 350, 0}, 1).position_mm.z, -40, 1e-9);
    EXPECT_NEAR(cap_moved({}, {0, -350, 350, 0}, 1).position_mm.y, -40, 1e-9);
    EXPECT_NEAR(cap_moved({}, {0, 0, 0, -350}, 1).roll_rad, 3, 1e-9);
    EXPECT_NEAR(cap_moved({}, {700, 0, 0, 0}, 1).position_mm.x, 40, 1e-9);  // no faster
    // A cap that is let go doesn't come back to exactly 0.
    EXPECT_EQ(cap_moved({{1, 2, 3}, 4}, {15, -15, 15, 15}, 1).position_mm, (Vec3d{1, 2, 3}));
    EXPECT_EQ(cap_moved({{1, 2, 3}, 4}, {15, -15, 15, 15}, 1).roll_rad, 4);
    EXPECT_EQ(cap_moved({{99, 0, -99}, 0}, {350, 0, 350, 0}, 1).position_mm, (Vec3d{100, 0, -100}));
}

TEST(SpaceMouse, SaysWhatIsMissingAndWhatToDo) {
    const auto message_of = [](const std::string& what) {
        const auto device = open_haptic_device(what);
        EXPECT_FALSE(device.ok());
        const std::string message = device.ok() ? "" : device.error().message;
        EXPECT_EQ(message.find('\n'), std::string::npos);
        return message;
    };
    const std::string missing = message_of("spacemouse:./libnone.so");
    EXPECT_NE(missing.find("'spacemouse': expected libspnav"), std::string::npos) << missing;
    EXPECT_NE(missing.find("libspnav0 and spacenavd"), std::string::npos) << missing;
    const std::string other = message_of("spacemouse:libz.so.1");
    EXPECT_NE(other.find("spnav_open"), std::string::npos) << other;
    setenv("PLIANT_FAKE_SPNAV", "off", 1);
    const std::string daemon = message_of(kFake);
    unsetenv("PLIANT_FAKE_SPNAV");
    EXPECT_NE(daemon.find("systemctl start spacenavd"), std::string::npos) << daemon;
}

}  // namespace
}  // namespace pliant
