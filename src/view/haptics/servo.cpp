// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include <pliant/view/haptics.h>

#include <algorithm>
#include <atomic>
#include <system_error>
#include <thread>

#include "haptics/pace.h"
#include "haptics/record_ring.h"
#include "haptics/triple_buffer.h"

namespace pliant {
namespace {

constexpr std::size_t kRecords = 8192;  ///< eight seconds at 1 kHz

Error wrong(const std::string& what) {
    return {ErrorCode::InvalidArgument, "haptics: " + what};
}

}  // namespace

struct HapticServo::Impl {
    std::unique_ptr<HapticDevice> device;
    HapticServoSettings settings;
    TripleBuffer<HapticModel> models;
    RecordRing<HapticRecord, kRecords> ring;
    std::atomic<bool> stop{false}, quit{false}, is_begun{false};
    std::string note;
    std::thread thread;

    void run() noexcept;
    void period(std::int64_t start_ns, bool is_late, HapticState& state, HapticRecord& record);
};

/// One period. It must not wait, allocate, print or throw.
void HapticServo::Impl::period(std::int64_t start_ns, bool is_late, HapticState& state,
                               HapticRecord& record) {
    const std::int64_t begin_ns = steady_now_ns();
    HapticReading reading;
    const bool is_read = device->read(reading);
    reading.time_ns = begin_ns - start_ns;
    reading.stop = stop.load(std::memory_order_relaxed);
    HapticForce force;
    if (is_read) {
        const Vec3d earlier = state.position_mm;
        const Vec3d sent = state.force_n;
        const bool is_first = state.time_ns < 0;
        force = servo_step(settings.step, models.read(), reading, state);
        if (!is_first) record.energy_j -= 1e-3 * dot(sent, state.position_mm - earlier);
    } else {
        force.flags = kHapticDeviceLost;
        state.force_n = {0, 0, 0};
    }
    if (!device->write(force.force_n)) force.flags |= kHapticDeviceLost;
    record.period_ns = record.period == 0 ? 0 : reading.time_ns - record.time_ns;
    record.time_ns = reading.time_ns;
    record.age_ns = state.model_time_ns < 0 ? -1 : reading.time_ns - state.model_time_ns;
    record.model = state.model.number;
    record.position_mm = state.position_mm;
    record.proxy_mm = state.proxy_mm;
    record.force_n = state.force_n;
    record.swap_step_n = state.swap_step_n;
    record.device_mm = reading.position_mm;
    record.flags = force.flags | (is_late ? unsigned(kHapticLate) : 0u);
    record.buttons = reading.buttons;
    record.roll_rad = reading.roll_rad;
    record.compute_ns = steady_now_ns() - begin_ns;
    ring.write(record);
    ++record.period;
}

void HapticServo::Impl::run() noexcept {
    // Called by the thread itself, because its creator may have to wait.
    note = ask_for_real_time(pthread_self(), settings.priority);
    is_begun.store(true, std::memory_order_release);
    is_begun.notify_one();
    HapticState state;
    HapticRecord record;
    Pace pace(settings.rate_hz);
    const std::int64_t start_ns = steady_now_ns();
    bool is_late = false;
    while (!quit.load(std::memory_order_relaxed)) {
        period(start_ns, is_late, state, record);
        is_late = pace.wait();
    }
    device->write({0, 0, 0});
}

SettingRows<HapticServoSettings> haptic_servo_rows() noexcept {
    using S = HapticServoSettings;
    static constexpr Setting<S> kRows[] = {
        setting<&S::rate_hz>({.name = "rate_hz",
                              .unit = "Hz",
                              .range = {500, 5000},
                              .text = "periods of the servo per second"}),
        setting<&S::priority>({.name = "priority",
                               .range = {0, 99},
                               .text = "real-time priority, if the system allows it; 0: none"}),
    };
    return kRows;
}

Result<std::unique_ptr<HapticServo>> HapticServo::start(std::unique_ptr<HapticDevice> device,
                                                        const HapticServoSettings& settings) {
    if (!device) return wrong("expected a device");
    if (const Status status = check(settings, haptic_servo_rows()); !status.ok())
        return wrong(status.error().message);
    if (const Status status = check_haptic_settings(settings.step); !status.ok())
        return status.error();
    auto impl = std::make_unique<Impl>();
    impl->settings = settings;
    HapticSettings& step = impl->settings.step;
    const HapticLimits limits = device->limits();
    step.max_force_n = std::min(step.max_force_n, limits.max_force_n);
    step.max_stiffness_n_m = std::min(step.max_stiffness_n_m, limits.max_stiffness_n_m);
    step.damping_n_s_m = std::min(step.damping_n_s_m, limits.max_damping_n_s_m);
    impl->device = std::move(device);
    Impl* const servo = impl.get();
    try {
        servo->thread = std::thread([servo] { servo->run(); });
    } catch (const std::system_error&) {
        return Error{ErrorCode::LimitExceeded, "haptics: expected room for one more thread"};
    }
    servo->is_begun.wait(false, std::memory_order_acquire);
    return std::unique_ptr<HapticServo>(new HapticServo(std::move(impl)));
}

HapticServo::HapticServo(std::unique_ptr<Impl> impl) : m_impl(std::move(impl)) {}

HapticServo::~HapticServo() {
    m_impl->quit.store(true, std::memory_order_relaxed);
    m_impl->thread.join();
}

void HapticServo::post(const HapticModel& model) {
    m_impl->models.write(model);
}

double HapticServo::largest_stiffness_n_m() const {
    const HapticSettings& step = m_impl->settings.step;
    const double felt = step.workspace.scale * step.workspace.force_scale;
    return felt > 0 ? step.max_stiffness_n_m / felt : 0;
}

void HapticServo::set_stop(bool stop) {
    m_impl->stop.store(stop, std::memory_order_relaxed);
}

HapticRecord HapticServo::latest() const {
    HapticRecord record;
    for (int attempt = 0; attempt < 100; ++attempt) {
        const std::uint64_t written = m_impl->ring.written();
        if (written > 0 && m_impl->ring.read(written - 1, record)) break;
    }
    return record;
}

std::size_t HapticServo::read(std::uint64_t& next, std::span<HapticRecord> records,
                              std::uint64_t& lost) const {
    std::size_t count = 0;
    const std::uint64_t written = m_impl->ring.written();
    if (written > next + kRecords) {
        lost += written - kRecords - next;
        next = written - kRecords;
    }
    for (; next < written && count < records.size(); ++next) {
        if (m_impl->ring.read(next, records[count]))
            ++count;
        else
            ++lost;
    }
    return count;
}

const HapticDevice& HapticServo::device() const {
    return *m_impl->device;
}
bool HapticServo::is_real_time() const {
    return m_impl->note.empty();
}
const std::string& HapticServo::note() const {
    return m_impl->note;
}

struct IdleLoop::Impl {
    struct Beat {
        std::int64_t period_ns;
    };
    RecordRing<Beat, kRecords> ring;
    std::atomic<bool> quit{false};
    std::uint64_t next = 0;
    std::thread thread;
};

IdleLoop::IdleLoop(double rate_hz, int priority) : m_impl(std::make_unique<Impl>()) {
    Impl* const loop = m_impl.get();
    loop->thread = std::thread([loop, rate_hz, priority] {
        (void)ask_for_real_time(pthread_self(), priority);
        Pace pace(rate_hz);
        std::int64_t last = steady_now_ns();
        while (!loop->quit.load(std::memory_order_relaxed)) {
            pace.wait();
            const std::int64_t now = steady_now_ns();
            loop->ring.write({now - last});
            last = now;
        }
    });
}

IdleLoop::~IdleLoop() {
    m_impl->quit.store(true, std::memory_order_relaxed);
    m_impl->thread.join();
}

std::vector<std::int64_t> IdleLoop::take() {
    std::vector<std::int64_t> periods;
    const std::uint64_t written = m_impl->ring.written();
    if (written > m_impl->next + kRecords) m_impl->next = written - kRecords;
    for (; m_impl->next < written; ++m_impl->next)
        if (Impl::Beat beat{}; m_impl->ring.read(m_impl->next, beat))
            periods.push_back(beat.period_ns);
    return periods;
}

}  // namespace pliant
