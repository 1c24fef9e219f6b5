// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// pliant haptics: jitter of the servo on this machine. A device touches a tissue that is solved
// some thirty times a second, and the timing of each period is recorded. An idle loop runs in
// parallel to measure the jitter of the machine alone.

#include <pliant/chainmail.h>
#include <pliant/core/files.h>
#include <pliant/core/output_file.h>
#include <pliant/render.h>
#include <pliant/resample.h>
#include <pliant/view/haptics.h>
#include <pliant/volume.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <optional>
#include <thread>
#include <tuple>

#include "json.h"
#include "options.h"
#include "progress.h"

namespace pliant::app {
namespace {

using Clock = std::chrono::steady_clock;
/// Tissue with its surface at z = 0 and increasing stiffness: F = 80 d + 30'000 d² [N, m].
HapticModel tissue_at(Vec3d tool_mm, double largest_n_m) {
    const double d = std::max(0.0, -1e-3 * tool_mm.z);
    Mat3d change{};
    change.columns[2].z = -(80 + 60'000 * d);
    HapticModel model = model_of_contact({tool_mm.x, tool_mm.y, 0}, {0, 0, 1}, tool_mm,
                                         {0, 0, 80 * d + 30'000 * d * d}, change);
    model.friction = 0.2;
    return checked_model(model, largest_n_m).value();
}

/// Background load typical of the program: pushes, resamples and draws a phantom.
class Load {
  public:
    explicit Load(int threads) : m_thread([this, threads] { run(threads); }) {}
    ~Load() {
        m_quit = true;
        m_thread.join();
    }
    std::int64_t frames() const { return m_frames; }

  private:
    void run(int threads) {
        const TaskArena arena(threads);
        const auto phantom = make_phantom({.name = "airway"}, arena);
        if (!phantom.ok() || phantom->landmarks.empty()) return;
        auto tissue = ChainMail::create(phantom->volume, {}, arena);
        if (!tissue.ok()) return;
        auto live = LiveDeformation::create(*tissue);
        if (!live) return;
        RayCaster caster(live->volume(), arena);
        const PhantomLandmark& place = phantom->landmarks.front();
        while (!m_quit) {
            (void)tissue->push(
                {.point_mm = place.push_point_mm, .push_mm = place.push_mm, .sphere_radius_mm = 3});
            if (const auto update = live->update()) caster.update(update->boxes);
            (void)caster.endoscope_view({.eye_mm = place.eye_mm, .look = place.look}, 512, 512);
            tissue->reset();
            ++m_frames;
        }
    }

    std::atomic<bool> m_quit{false};
    std::atomic<std::int64_t> m_frames{0};
    std::thread m_thread;
};

Json spread_of(std::vector<double> values) {
    if (values.empty()) return nullptr;
    std::sort(values.begin(), values.end());
    const auto at = [&](double share) {
        return values[std::size_t(share * double(values.size() - 1))];
    };
    return {{"p50", at(0.5)}, {"p99", at(0.99)}, {"p99.9", at(0.999)}, {"max", values.back()}};
}

/// Number of values above a limit, per million.
double per_million(const std::vector<double>& values, double limit) {
    const auto over =
        std::count_if(values.begin(), values.end(), [=](double v) { return v > limit; });
    return values.empty() ? 0 : 1e6 * double(over) / double(values.size());
}

struct Collected {
    std::vector<double> period_us, compute_us, age_ms, unblended_n, felt_n, idle_us;
    std::vector<HapticRecord> records;  ///< if requested
    std::int64_t late = 0, contact = 0, stale = 0, rate_limited = 0, energy_limited = 0;
    std::uint64_t lost = 0;
    double lowest_energy_j = 0, last_energy_j = 0;
    Vec3d last_force_n{0, 0, 0};

    void add(const HapticRecord& r, bool keep) {
        if (r.period > 0) period_us.push_back(1e-3 * double(r.period_ns));
        compute_us.push_back(1e-3 * double(r.compute_ns));
        if (r.age_ns >= 0) age_ms.push_back(1e-6 * double(r.age_ns));
        if (r.flags & kHapticNewModel && r.flags & kHapticContact) {
            unblended_n.push_back(r.swap_step_n);
            felt_n.push_back(norm(r.force_n - last_force_n));
        }
        last_force_n = r.force_n;
        late += (r.flags & kHapticLate) != 0;
        contact += (r.flags & kHapticContact) != 0;
        stale += (r.flags & kHapticStale) != 0;
        rate_limited += (r.flags & kHapticRateLimit) != 0;
        energy_limited += (r.flags & kHapticEnergyLimit) != 0;
        last_energy_j = r.energy_j;
        lowest_energy_j = std::min(lowest_energy_j, r.energy_j);
        if (keep) records.push_back(r);
    }
};

Collected collect(const HapticsOptions& o, HapticServo& servo) {
    Collected c;
    IdleLoop idle(o.rate_hz);
    std::optional<Load> load;
    if (o.load) load.emplace(o.threads);
    std::optional<ProgressBar> bar(std::in_place, "haptics");
    std::vector<HapticRecord> records(4096);
    std::uint64_t next = 0;
    std::int64_t number = 0;
    const auto begin = Clock::now();
    const auto step = std::chrono::duration<double>(1 / o.update_hz);
    for (auto wake = begin;;) {
        const double seconds = std::chrono::duration<double>(Clock::now() - begin).count();
        if (seconds >= 60 * o.minutes) break;
        HapticModel model = tissue_at(servo.latest().position_mm, servo.largest_stiffness_n_m());
        model.number = ++number;
        servo.post(model);
        const std::size_t count = servo.read(next, records, c.lost);
        for (std::size_t k = 0; k < count; ++k) c.add(records[k], !o.record.empty());
        for (const std::int64_t ns : idle.take()) c.idle_us.push_back(1e-3 * double(ns));
        bar->show(seconds / (60 * o.minutes));
        wake += std::chrono::duration_cast<Clock::duration>(step);
        std::this_thread::sleep_until(wake);
    }
    return c;
}

Json report_of(const HapticsOptions& o, const HapticServo& servo, const Collected& c) {
    return {{"device", servo.device().name()},
            {"rate_hz", o.rate_hz},
            {"update_hz", o.update_hz},
            {"load", o.load},
            {"real_time", servo.is_real_time()},
            {"note", servo.note()},
            {"periods", c.compute_us.size()},
            {"records_lost", c.lost},
            {"period_us", spread_of(c.period_us)},
            {"misses_over_1500_us_per_million", per_million(c.period_us, 1500)},
            {"misses_over_2000_us_per_million", per_million(c.period_us, 2000)},
            {"beats_left_out", c.late},
            {"compute_us", spread_of(c.compute_us)},
            {"model_age_ms", spread_of(c.age_ms)},
            {"periods_in_contact", c.contact},
            {"periods_with_a_stale_model", c.stale},
            {"periods_cut_by_force_rate", c.rate_limited},
            {"periods_cut_by_energy", c.energy_limited},
            {"force_step_at_a_new_model_n", spread_of(c.felt_n)},
            {"force_step_without_blending_n", spread_of(c.unblended_n)},
            {"lowest_energy_j", c.lowest_energy_j},
            {"energy_j", c.last_energy_j},
            {"idle_period_us", spread_of(c.idle_us)},
            {"idle_misses_over_1500_us_per_million", per_million(c.idle_us, 1500)},
            {"idle_misses_over_2000_us_per_million", per_million(c.idle_us, 2000)}};
}

void print(const Json& r) {
    const auto line = [&](const char* title, const char* key) {
        const Json& s = r[key];
        if (s.is_null())
            std::printf("%-34s none\n", title);
        else
            std::printf("%-34s %10.3f %10.3f %10.3f %10.3f\n", title, s["p50"].get<double>(),
                        s["p99"].get<double>(), s["p99.9"].get<double>(), s["max"].get<double>());
    };
    std::printf("%s at %g Hz, tissue at %g Hz, %lld periods%s\n",
                r["device"].get<std::string>().c_str(), r["rate_hz"].get<double>(),
                r["update_hz"].get<double>(), r["periods"].get<long long>(),
                r["load"].get<bool>() ? ", under load" : "");
    if (!r["real_time"].get<bool>())
        std::printf("note: %s\n", r["note"].get<std::string>().c_str());
    std::printf("%-34s %10s %10s %10s %10s\n", "", "p50", "p99", "p99.9", "max");
    line("period [us]", "period_us");
    line("  of an idle loop beside it", "idle_period_us");
    line("to read, compute and write [us]", "compute_us");
    line("age of the model [ms]", "model_age_ms");
    line("force step at a new model [N]", "force_step_at_a_new_model_n");
    line("  without blending", "force_step_without_blending_n");
    std::printf("misses per million over 1.5 ms %.0f (idle loop %.0f), over 2 ms %.0f (%.0f)\n",
                r["misses_over_1500_us_per_million"].get<double>(),
                r["idle_misses_over_1500_us_per_million"].get<double>(),
                r["misses_over_2000_us_per_million"].get<double>(),
                r["idle_misses_over_2000_us_per_million"].get<double>());
    std::printf("energy taken from the device: %.4f J, never below %.6f J\n",
                r["energy_j"].get<double>(), r["lowest_energy_j"].get<double>());
}

int list_devices() {
    std::printf("%-38s %9s %14s %14s\n", "", "force [N]", "stiffness", "damping");
    std::printf("%-38s %9s %14s %14s\n", "", "", "[N/m]", "[N s/m]");
    for (const HapticDeviceKind& kind : known_haptic_devices())
        std::printf("%-38s %9.1f %14.0f %14.0f\n", std::string(kind.name).c_str(),
                    kind.limits.max_force_n, kind.limits.max_stiffness_n_m,
                    kind.limits.max_damping_n_s_m);
    std::printf(
        "\nvirtual[:free|spring|tap|active], spacemouse and replay:FILE are built in; others are "
        "plug-ins,\nmade with the maker's kit (examples/haptic_device): --device ./libmaker.so\n");
    return kExitOk;
}

Error about_option(const char* option, const Error& error) {
    return {error.code, std::string(option) + ": " + error.message};
}

/// Both output files, staged before the minutes of the check, so that errors are reported early.
struct HapticsOutputs {
    StagedFiles files;
    std::filesystem::path record, out;

    Status stage(const HapticsOptions& o) {
        for (const auto& [option, name, place] :
             {std::tuple("--record", &o.record, &record), {"--out", &o.out, &out}}) {
            if (name->empty()) continue;
            const auto staged = files.stage(*name);
            if (!staged) return about_option(option, staged.error());
            *place = *staged;
        }
        return Ok{};
    }
    Status write(const Collected& collected, const Json& report) {
        if (!record.empty())
            if (const Status s = write_haptic_recording(record, collected.records); !s)
                return about_option("--record", s.error());
        if (!out.empty()) {
            OutputFile file(out, "--out: " + out.string());
            file.write(report.dump(2) + '\n');
            if (const Status s = file.close(); !s) return s;
        }
        return files.commit();
    }
};

}  // namespace

int run_haptics(const HapticsOptions& o) {
    if (o.what == "devices") return list_devices();
    auto device = open_haptic_device(o.device);
    if (!device.ok()) return bad_input("--device: " + device.error().message);
    HapticsOutputs outputs;
    if (const Status s = outputs.stage(o); !s) return bad_input(s.error().message);
    HapticServoSettings settings;
    settings.rate_hz = o.rate_hz;
    settings.step.max_force_n = 1000;  // the device's limits apply
    settings.step.max_stiffness_n_m = 1e5;
    auto servo = HapticServo::start(std::move(*device), settings);
    if (!servo.ok()) return bad_input(servo.error().message);
    const Collected collected = collect(o, **servo);
    const Json report = report_of(o, **servo, collected);
    servo->reset();
    if (const Status s = outputs.write(collected, report); !s) return bad_input(s.error().message);
    if (o.json)
        std::printf("%s\n", report.dump().c_str());
    else
        print(report);
    return kExitOk;
}

}  // namespace pliant::app
