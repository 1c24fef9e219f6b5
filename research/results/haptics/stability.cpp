// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Onset of a wall's oscillation, and impacts of a free device.

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "figures.h"
#include "tissues.h"

namespace pliant::results {
namespace {

constexpr double kMass_kg = 0.1, kDamping = 0.5;

struct Case {
    const char* name;
    HapticScheme scheme;
    int update_periods;
    double period_s;  ///< hold time of the force
};
constexpr std::array<Case, 3> kCases = {{
    {"local model, 30 Hz", HapticScheme::LinearLaw, 33, 1e-3},
    {"force held, 1 kHz", HapticScheme::Hold, 1, 1e-3},
    {"force held, 30 Hz", HapticScheme::Hold, 33, 33e-3},
}};

HapticTissue tissue_of(HapticScheme scheme, double k) {
    return
        [=](Vec3d x) { return scheme == HapticScheme::LinearLaw ? wall(k) : force_of_wall(k, x); };
}

/// Growth rate of an oscillation around 2 mm [1/s].
double growth(const Case& c, double stiffness_n_m) {
    HapticRun run;
    run.scheme = c.scheme;
    run.settings.max_force_n = 1000;
    run.settings.max_force_rate_n_s = 1e6;
    run.settings.max_stiffness_n_m = 1e5;
    run.settings.ramp_s = 0.001;
    run.settings.bounded_energy = false;
    run.update_periods = c.update_periods;
    VirtualDeviceSettings settings;
    settings.position_mm = {0, 0, -2.02};
    settings.hand.steady_n = {0, 0, -2e-3 * stiffness_n_m};
    VirtualDevice device(settings);
    double early = 0, late = 0, last_s = 0;
    run_haptics(device, run, 4000, tissue_of(c.scheme, stiffness_n_m),
                [&](const HapticReading& reading, const HapticModel*, const HapticState&,
                    const HapticForce&) {
                    const double t = 1e-9 * double(reading.time_ns);
                    const double off = std::abs(device.position_mm().z + 2);
                    if (t > 0.5 && t < 1.2) early = std::max(early, off);
                    if (t > last_s + 0.7 || t < 1.2) last_s = t, late = 0;
                    late = std::max(late, off);
                    return off < 1.9;
                });
    const double span = device.time_s() - 0.35 - 0.85;
    return std::log(late / early) / std::max(span, 0.1);
}

double boundary(const Case& c) {
    double low = 0.5 * 2 * kDamping / c.period_s, high = 4 * low;
    while (high > 1.005 * low) {
        const double middle = std::sqrt(low * high);
        (growth(c, middle) > 0 ? high : low) = middle;
    }
    return low;
}

/// Stability boundary of a mass with a force −K x held for T: the determinant of its map is 1.
double exact_boundary(double period) {
    const double a = std::exp(-kDamping * period / kMass_kg);
    const double alpha = kMass_kg / kDamping * (1 - a), gamma = (1 - a) / kDamping;
    return (1 - a) / (gamma * alpha - (period - alpha) / kDamping * a);
}

struct Tap {
    std::vector<Point2> way;
    double ratio = 0;
};
Tap tap(HapticScheme scheme, double stiffness_n_m, double extrapolated_updates) {
    HapticRun run;
    run.scheme = scheme;
    run.settings.max_force_n = 20;
    run.settings.max_stiffness_n_m = stiffness_n_m;
    run.settings.bounded_energy = false;
    run.extrapolated_updates = extrapolated_updates;
    VirtualDeviceSettings settings;
    settings.position_mm = {0, 0, 60};
    settings.velocity_mm_s = {0, 0, -300 - 60 * kDamping / kMass_kg};
    VirtualDevice device(settings);
    Tap result;
    double before = 0, after = 0, hit_s = -1;
    run_haptics(device, run, 3000, tissue_of(scheme, stiffness_n_m),
                [&](const HapticReading& reading, const HapticModel*, const HapticState& state,
                    const HapticForce&) {
                    const double t = 1e-9 * double(reading.time_ns);
                    if (device.position_mm().z > 0 && hit_s < 0) before = device.kinetic_j();
                    if (device.position_mm().z < 0 && hit_s < 0) hit_s = t;
                    if (hit_s >= 0) {
                        result.way.push_back({1000 * (t - hit_s), device.position_mm().z});
                        if (state.force_n == Vec3d{0, 0, 0} && device.position_mm().z > 0 &&
                            device.velocity_mm_s().z > 0)
                            after = std::max(after, device.kinetic_j());
                    }
                    return hit_s < 0 || t < hit_s + 0.2;
                });
    result.ratio = after / before;
    return result;
}

}  // namespace

void add_stability(Page& page) {
    page.heading(2, "Where a wall begins to swing");
    page.paragraph(
        "A mass of 0.1 kg with a damping of b = 0.5 Ns/m is pressed 2 mm into a wall and pushed "
        "off a little. Growth of its swing for local models that come at 30 Hz, and for forces "
        "held for 1 ms and for 33 ms. Theory for small bT/m: K T/2b − 1. Without "
        "`bounded_energy`.");
    Chart chart(640, 400, {"stiffness K [units of 2b/T]", 0.4, 1.6, 0.2, 1},
                {"growth of the swing [units of b/2m]", -0.8, 0.8, 0.2, 1});
    chart.mark(1, {kDark, 1, 0.6}, "boundary in theory");
    const Ink inks[] = {{kBlue, 5}, {kOrange, 1.5}, {kRed, 1.5}};
    std::vector<std::vector<std::string>> rows;
    for (std::size_t n = 0; n < kCases.size(); ++n) {
        const Case& c = kCases[n];
        const double unit = 2 * kDamping / c.period_s;
        std::vector<Point2> curve;
        for (double share = 0.45; share <= 1.55; share += 0.1)
            curve.push_back({share, growth(c, share * unit) * 2 * kMass_kg / kDamping});
        chart.curve(curve, inks[n], c.name);
        const double found = boundary(c);
        rows.push_back({c.name, fixed_text(unit, 1), fixed_text(exact_boundary(c.period_s), 1),
                        fixed_text(found, 1), fixed_text(100 * (found / unit - 1), 1)});
    }
    page.picture("stability", "growth of a swing over the wall's stiffness", chart.image());
    page.table({"the servo has", "2b/T [N/m]", "exact, of the sampled mass [N/m]", "found [N/m]",
                "off 2b/T [%]"},
               rows);
}

void add_taps(Page& page) {
    page.heading(2, "Tapping a wall");
    page.paragraph(
        "A free device hits a wall with 0.3 m/s: a local model of 600 N/m, and a wall of 300 N/m "
        "whose force is held for 33 ms or extrapolated from the last two forces [Choi2004], for "
        "one update or without end. The paper doesn't say how far it extrapolates. Here every "
        "update comes in time, so both extrapolations are the same: the dots of the second lie on "
        "the curve of the first.");
    static constexpr std::string_view kEndless = "extrapolated without end";
    struct Row {
        std::string name;
        HapticScheme scheme;
        double stiffness_n_m, updates;
        Ink ink;
    };
    const Row rows[] = {
        {"local model", HapticScheme::LinearLaw, 300, 1, {kGreen, 1.5}},
        {"local model", HapticScheme::LinearLaw, 600, 1, {kBlue, 2.5}},
        {"local model", HapticScheme::LinearLaw, 900, 1, {kGreen, 1.5}},
        {"force held", HapticScheme::Hold, 300, 1, {kOrange, 1.5}},
        {"extrapolated, one update", HapticScheme::Extrapolate, 300, 1, {kRed, 2.5}},
        {std::string(kEndless), HapticScheme::Extrapolate, 300, 1e6, {kDark, 2.5}},
    };
    double low = 0, high = 0;
    std::vector<Tap> taps;
    for (const Row& row : rows) {
        taps.push_back(tap(row.scheme, row.stiffness_n_m, row.updates));
        for (const Point2& p : taps.back().way) {
            low = std::min(low, p.y);
            high = std::max(high, p.y);
        }
    }
    constexpr double kStep_mm = 10;
    Chart chart(640, 400, {"time since the contact [ms]", 0, 200, 20},
                {"position; the wall is below 0 [mm]", kStep_mm * std::floor(low / kStep_mm),
                 kStep_mm * std::ceil(high / kStep_mm), kStep_mm});
    std::vector<std::vector<std::string>> table;
    for (std::size_t n = 0; n < taps.size(); ++n) {
        const Row& row = rows[n];
        const Tap& t = taps[n];
        const std::string name = row.name + (", " + fixed_text(row.stiffness_n_m, 0) + " N/m");
        if (row.name == kEndless) {
            std::vector<Point2> some;
            for (std::size_t k = 0; k < t.way.size(); k += 8) some.push_back(t.way[k]);
            chart.dots(some, row.ink, name);
        } else if (row.ink.colour != kGreen) {
            chart.curve(t.way, row.ink, name);
        }
        table.push_back({row.name, fixed_text(row.stiffness_n_m, 0), fixed_text(t.ratio, 2)});
    }
    page.picture("tap", "position of a device that hits a wall", chart.image());
    page.table({"the servo has", "K [N/m]", "energy after it / before it"}, table);
}

}  // namespace pliant::results
