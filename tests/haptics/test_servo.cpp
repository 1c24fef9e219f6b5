// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The servo's thread, its communication, and devices. No test depends on durations.
// Covers: haptics/devices.cpp.

#include <gtest/gtest.h>
#include <pliant/view/haptics.h>

#include <atomic>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <mutex>
#include <thread>
#include <vector>

#include "haptics/record_ring.h"
#include "haptics/triple_buffer.h"
#include "support/temporary_folder.h"
#include "watch_thread.h"

namespace pliant {
namespace {

HapticModel flat(double stiffness_n_m, std::int64_t number) {
    HapticModel model;
    model.number = number;
    model.plane_count = 1;
    model.planes[0] = {{0, 0, 0}, {0, 0, 1}};
    for (int c = 0; c < 3; ++c) model.stiffness_n_m.columns[c][c] = stiffness_n_m;
    return model;
}

TEST(TripleBuffer, GivesWholeValuesInOrderAndTheLastOne) {
    struct Value {
        std::int64_t words[64]{};
    };
    constexpr std::int64_t kLast = 50'000;
    TripleBuffer<Value> buffer;
    EXPECT_EQ(buffer.read(), nullptr);
    std::thread writer([&] {
        Value value;
        for (std::int64_t n = 1; n <= kLast; ++n) {
            for (std::int64_t& word : value.words) word = n;
            buffer.write(value);
        }
    });
    std::int64_t last = 0, seen = 0;
    while (last < kLast) {
        const Value* const value = buffer.read();
        if (!value) continue;
        ++seen;
        ASSERT_GT(value->words[0], last);
        last = value->words[0];
        for (const std::int64_t word : value->words) ASSERT_EQ(word, last);
    }
    writer.join();
    EXPECT_EQ(buffer.read(), nullptr);
    EXPECT_GT(seen, 0);
}

TEST(RecordRing, GivesWholeRecordsToManyReaders) {
    struct Record {
        std::uint64_t words[20]{};
    };
    constexpr std::uint64_t kCount = 30'000;
    RecordRing<Record, 64> ring;
    Record none;
    EXPECT_FALSE(ring.read(0, none));
    std::atomic<int> broken{0};
    std::vector<std::thread> readers;
    for (int r = 0; r < 2; ++r)
        readers.emplace_back([&] {
            for (std::uint64_t written = 0; written < kCount;) {
                written = ring.written();
                for (std::uint64_t n = written > 64 ? written - 64 : 0; n < written; ++n) {
                    Record record;
                    if (!ring.read(n, record)) continue;
                    for (const std::uint64_t word : record.words) broken += word != n;
                }
            }
        });
    for (std::uint64_t n = 0; n < kCount; ++n) {
        Record record;
        for (std::uint64_t& word : record.words) word = n;
        ring.write(record);
    }
    for (std::thread& reader : readers) reader.join();
    EXPECT_EQ(broken, 0);
    Record record;
    EXPECT_TRUE(ring.read(kCount - 1, record));
    EXPECT_TRUE(ring.read(kCount - 64, record));
    EXPECT_FALSE(ring.read(kCount - 65, record));
}

/// Goes up and down through the surface, and watches the thread that asks it.
class WatchingDevice : public HapticDevice {
  public:
    struct Seen {
        std::atomic<std::int64_t> allocations{0}, locks{0}, periods{0};
        std::atomic<double> last_force_n{-1};
    };
    explicit WatchingDevice(Seen& seen, std::int64_t lost_from = 1'000'000'000)
        : m_seen(seen), m_lost_from(lost_from) {}

    std::string name() const override { return "watching"; }
    HapticLimits limits() const override { return {}; }
    bool read(HapticReading& reading) noexcept override {
        test::watch_this_thread();
        const std::int64_t n = m_seen.periods.load();
        reading.position_mm = {0, 0, std::sin(0.05 * double(n))};
        return n < m_lost_from;
    }
    bool write(Vec3d force_n) noexcept override {
        m_seen.last_force_n = norm(force_n);
        m_seen.allocations = test::allocations_of_this_thread();
        m_seen.locks = test::locks_of_this_thread();
        ++m_seen.periods;
        return true;
    }

  private:
    Seen& m_seen;
    std::int64_t m_lost_from;
};

TEST(HapticServo, TakesNoLockAndAllocatesNothing) {
    if (!test::can_watch_threads()) GTEST_SKIP() << "a sanitizer has these functions for itself";
    // The watch detects allocations and locks.
    std::thread([] {
        test::watch_this_thread();
        std::mutex mutex;
        mutex.lock();
        mutex.unlock();
        // volatile, because a compiler may remove an unused allocation.
        void* volatile memory = std::malloc(100);
        std::free(memory);
        EXPECT_GE(test::allocations_of_this_thread(), 1);
        EXPECT_GE(test::locks_of_this_thread(), 1);
    }).join();

    WatchingDevice::Seen seen;
    {
        auto servo = HapticServo::start(std::make_unique<WatchingDevice>(seen), {});
        ASSERT_TRUE(servo.ok()) << servo.error().message;
        for (std::int64_t n = 1; seen.periods < 600; ++n) {
            HapticModel model = flat(500, n);
            model.friction = 0.3;
            model.plane_count = HapticModel::kMaxPlanes;
            for (int k = 1; k < model.plane_count; ++k)
                model.planes[k] = {{0, 0, -0.2}, {std::sin(0.5 * k), std::cos(0.5 * k), 1}};
            (*servo)->post(*checked_model(model, 500));
            std::this_thread::sleep_for(std::chrono::milliseconds(5));
        }
        const HapticRecord latest = (*servo)->latest();
        EXPECT_GT(latest.model, 3);
    }
    EXPECT_EQ(seen.allocations, 0);
    EXPECT_EQ(seen.locks, 0);
    EXPECT_EQ(seen.last_force_n, 0);  // the last thing that it wrote
}

TEST(HapticServo, RecordsWhatItsFunctionGivesAgainBitForBit) {
    WatchingDevice::Seen seen;
    HapticServoSettings settings;
    settings.step.damping_n_s_m = 0.1;
    auto servo = HapticServo::start(std::make_unique<WatchingDevice>(seen), settings);
    ASSERT_TRUE(servo.ok());
    std::vector<HapticModel> models(1);
    for (std::int64_t n = 1; seen.periods < 800; ++n) {
        models.push_back(*checked_model(flat(200 + 10 * double(n % 20), n), 600));
        (*servo)->post(models.back());
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    std::vector<HapticRecord> records(4000);
    std::uint64_t next = 0, lost = 0;
    records.resize((*servo)->read(next, records, lost));
    EXPECT_EQ(lost, 0u);
    ASSERT_GE(records.size(), 800u);
    HapticState state;
    double most_n = 0;
    for (std::size_t k = 0; k < records.size(); ++k) {
        const HapticRecord& r = records[k];
        ASSERT_EQ(r.period, std::int64_t(k));
        const HapticModel* const fresh =
            r.flags & kHapticNewModel ? &models[std::size_t(r.model)] : nullptr;
        servo_step(settings.step, fresh, {r.time_ns, r.device_mm, false, 0}, state);
        ASSERT_EQ(std::memcmp(&state.force_n, &r.force_n, sizeof r.force_n), 0) << k;
        most_n = std::max(most_n, norm(r.force_n));
    }
    EXPECT_GT(most_n, 0.1);
}

TEST(HapticServo, StopsWhereItIsTold) {
    WatchingDevice::Seen seen;
    auto servo = HapticServo::start(std::make_unique<WatchingDevice>(seen), {});
    ASSERT_TRUE(servo.ok());
    std::int64_t number = 0;
    const auto run_for = [&](std::int64_t periods) {
        const std::int64_t end = seen.periods + periods;
        while (seen.periods < end) {
            (*servo)->post(flat(500, ++number));
            std::this_thread::sleep_for(std::chrono::milliseconds(5));
        }
    };
    const auto strongest_since = [&](std::uint64_t next) {
        std::vector<HapticRecord> records(4000);
        std::uint64_t lost = 0;
        records.resize((*servo)->read(next, records, lost));
        double most = 0;
        for (const HapticRecord& r : records) most = std::max(most, norm(r.force_n));
        return most;
    };
    run_for(400);
    EXPECT_GT(strongest_since(0), 0.1);
    (*servo)->set_stop(true);
    run_for(250);  // a ramp is 100 ms of time, and so at most as many periods
    const auto stopped = std::uint64_t((*servo)->latest().period);
    run_for(150);
    EXPECT_EQ(strongest_since(stopped), 0);
    (*servo)->set_stop(false);
    run_for(400);
    EXPECT_GT(strongest_since(stopped), 0.1);
}

TEST(HapticServo, SaysThatTheDeviceIsLostAndSendsNoForce) {
    WatchingDevice::Seen seen;
    auto servo = HapticServo::start(std::make_unique<WatchingDevice>(seen, 300), {});
    ASSERT_TRUE(servo.ok());
    for (std::int64_t n = 1; seen.periods < 320; ++n) {
        (*servo)->post(flat(500, n));
        std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    EXPECT_TRUE((*servo)->latest().flags & kHapticDeviceLost);
    EXPECT_EQ(seen.last_force_n, 0);
}

TEST(HapticServo, RefusesSettingsOutOfRange) {
    WatchingDevice::Seen seen;
    const auto message_of = [&](const HapticServoSettings& settings) {
        auto servo = HapticServo::start(std::make_unique<WatchingDevice>(seen), settings);
        return servo.ok() ? std::string() : servo.error().message;
    };
    HapticServoSettings settings;
    settings.rate_hz = 100;
    EXPECT_EQ(message_of(settings), "haptics: rate_hz: expected 500 to 5000 Hz, found 100");
    settings = {};
    settings.step.max_force_n = -1;
    EXPECT_EQ(message_of(settings), "haptics: max_force_n: expected 0 to 1000, found -1.000000");
    settings = {};
    settings.step.max_stiffness_n_m = 5000;
    auto servo = HapticServo::start(std::make_unique<WatchingDevice>(seen), settings);
    ASSERT_TRUE(servo.ok());
    EXPECT_EQ((*servo)->largest_stiffness_n_m(), HapticLimits{}.max_stiffness_n_m);
    EXPECT_EQ((*servo)->is_real_time(), (*servo)->note().empty());
}

TEST(Devices, VirtualOneIsHeldByAnyHand) {
    for (const char* what :
         {"virtual", "virtual:free", "virtual:spring", "virtual:tap", "virtual:active"}) {
        auto device = open_haptic_device(what);
        ASSERT_TRUE(device.ok()) << what;
        HapticReading reading;
        EXPECT_TRUE((*device)->read(reading));
        EXPECT_TRUE((*device)->write({0, 0, 1}));
        EXPECT_GT((*device)->limits().max_stiffness_n_m, 0);
    }
    const auto wrong = open_haptic_device("virtual:robot");
    ASSERT_FALSE(wrong.ok());
    EXPECT_EQ(wrong.error().message,
              "haptic device 'virtual:robot': expected virtual, virtual:free, virtual:spring, "
              "virtual:tap or virtual:active");
}

TEST(Devices, ReplayGivesTheRecordedPlaces) {
    const test::TemporaryFolder folder;
    std::vector<HapticRecord> records(3);
    for (std::size_t k = 0; k < 3; ++k) {
        records[k].time_ns = std::int64_t(k) * 1'000'000;
        records[k].device_mm = {0.1 * double(k), 1.0 / 3, -2e-7};
    }
    const auto path = folder.path() / "recording.txt";
    ASSERT_TRUE(write_haptic_recording(path, records).ok());
    auto device = open_haptic_device("replay:" + path.string());
    ASSERT_TRUE(device.ok()) << device.error().message;
    HapticReading reading;
    for (std::size_t k = 0; k < 5; ++k) {
        EXPECT_TRUE((*device)->read(reading));
        EXPECT_EQ(reading.position_mm, records[std::min<std::size_t>(k, 2)].device_mm);
    }
    std::ofstream(path) << "0 1 2 3\n5 1 x 3\n";
    const auto broken = open_haptic_device("replay:" + path.string());
    ASSERT_FALSE(broken.ok());
    EXPECT_NE(broken.error().message.find("line 2: expected time_ns x y z"), std::string::npos);
    EXPECT_FALSE(open_haptic_device("replay:" + (folder.path() / "none").string()).ok());
}

TEST(Devices, ThePlugInOfTheExampleIsLoaded) {
    auto device = open_haptic_device(PLIANT_EXAMPLE_DEVICE);
    ASSERT_TRUE(device.ok()) << device.error().message;
    EXPECT_EQ((*device)->name(), "example circle");
    EXPECT_EQ((*device)->limits().max_stiffness_n_m, 400);
    HapticReading reading;
    ASSERT_TRUE((*device)->read(reading));
    EXPECT_EQ(reading.position_mm, (Vec3d{10, 0, 0}));
    EXPECT_TRUE((*device)->write({0, 0, 1}));
    const auto second = open_haptic_device(PLIANT_EXAMPLE_DEVICE);
    ASSERT_FALSE(second.ok());
    EXPECT_NE(second.error().message.find("already open"), std::string::npos);
    device->reset();
    EXPECT_TRUE(open_haptic_device(PLIANT_EXAMPLE_DEVICE ":circle").ok());
    EXPECT_FALSE(open_haptic_device(PLIANT_EXAMPLE_DEVICE ":square").ok());
}

TEST(Devices, APlugInThatIsMissingOrWrongSaysWhatToDo) {
    const auto message_of = [](const std::string& what) {
        const auto device = open_haptic_device(what);
        return device.ok() ? std::string() : device.error().message;
    };
    const std::string missing = message_of("./libmaker.so");
    EXPECT_NE(missing.find("'./libmaker.so'"), std::string::npos) << missing;
    EXPECT_NE(missing.find("examples/haptic_device"), std::string::npos) << missing;
    EXPECT_EQ(missing.find('\n'), std::string::npos);
    const std::string wrong = message_of(PLIANT_WRONG_DEVICE);
    EXPECT_NE(wrong.find("found version 99 with 12"), std::string::npos) << wrong;
    const std::string other = message_of("libz.so.1");
    EXPECT_NE(other.find("pliant_haptic_device_v1"), std::string::npos) << other;
}

}  // namespace
}  // namespace pliant
