// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// ChainMail has no forces, but an exact limit of motion: a push by the whole reach is done up to
// the fraction at which links or movement limits are exhausted. That fraction is L. The grey values
// determine the stiffness below L.

#include <pliant/view/haptics.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/errors.h"
#include "haptics/walls.h"

namespace pliant {
namespace {

constexpr double kPoisson = 0.45, kReference = 1040 / 4095.0;  ///< w of 40 HU
constexpr double kTangential = 0.7;  ///< ratio to the stiffness along the normal: 2(1 − ν)/(2 − ν)
constexpr double kSame_mm = 0.5;  ///< a contact that moved by less keeps its values
constexpr double kSameDirection = 0.98;

/// Dräger's softness of a value in the law's range, 1 − w² [Draeger2005, 3.5.5].
double softness(double value, ValueSpan range) {
    const double w = std::clamp((value - range.low) / (range.high - range.low), 0.0, 0.999);
    return 1 - w * w;
}

/// F = k d/(1 − d/L) as long as it is softer than bone, then linear.
void wall_law(const ChainMailFeel::Give& give, double bone_n_m, double depth_mm, double& force_n,
              double& stiffness_n_m) {
    const double k = std::min(give.stiffness_n_m, bone_n_m), limit = give.limit_mm;
    if (!std::isfinite(limit)) {
        force_n = 1e-3 * k * depth_mm;
        stiffness_n_m = k;
        return;
    }
    const double last = limit * (1 - std::sqrt(k / bone_n_m));  // as stiff as bone beyond
    const double bent = std::min(depth_mm, last);
    const double share = limit > 0 ? 1 - bent / limit : 1;
    force_n = 1e-3 * (k * bent / share + bone_n_m * std::max(0.0, depth_mm - last));
    stiffness_n_m = depth_mm < last ? k / (share * share) : bone_n_m;
}

using FeelSettings = ChainMailFeelSettings;

constexpr Setting<FeelSettings> kRows[] = {
    setting<&FeelSettings::tool_radius_mm>({.name = "tool_radius_mm",
                                            .unit = "mm",
                                            .range = {0.01, 100},
                                            .text = "radius of the round tool"}),
    setting<&FeelSettings::iso_hu>(
        {.name = "iso_hu", .unit = "HU", .text = "threshold of the surface that is felt"}),
    setting<&FeelSettings::polarity>(
        {.name = "polarity",
         .choices = "rising|falling",
         .text = "rising: tissue is brighter than the lumen; falling: darker"}),
    setting<&FeelSettings::young_modulus_pa>({.name = "young_modulus_pa",
                                              .unit = "Pa",
                                              .range = {1, 1e9},
                                              .text = "Young's modulus of tissue of 40 HU"}),
    setting<&FeelSettings::bone_n_m>({.name = "bone_n_m",
                                      .unit = "N/m",
                                      .range = {1, 1e9},
                                      .text = "stiffness of bone and of links that are taut"}),
    setting<&FeelSettings::friction>(
        {.name = "friction", .range = {0, 10}, .text = "Coulomb's coefficient"}),
    setting<&FeelSettings::reach_mm>({.name = "reach_mm",
                                      .unit = "mm",
                                      .range = {0.1, 500},
                                      .text = "distance up to which surfaces and limits count"}),
};

}  // namespace

SettingRows<ChainMailFeelSettings> chainmail_feel_rows() noexcept {
    return kRows;
}

struct ChainMailFeel::Impl {
    Impl(const Volume& scan_, const Volume& shown_, ChainMail t, const ChainMailFeelSettings& s,
         const TaskArena& arena)
        : scan(scan_), shown(shown_), trial(std::move(t)), settings(s), walls(shown_, arena) {}

    const Volume& scan;
    const Volume& shown;
    ChainMail trial;
    ChainMailFeelSettings settings;
    ValueSpan range = trial.settings().range;
    Walls walls;

    // Cache of the last contact.
    bool has_contact = false;
    Vec3d contact_mm{0, 0, 0}, contact_normal{0, 0, 0};
    Give contact_give;

    double stiffness_below(Vec3d surface_mm, Vec3d normal) const;
    double pushed_mm(Vec3d surface_mm, Vec3d normal) const;
};

/// Stiffness of a punch on tissue with the mean value within two radii below the surface.
double ChainMailFeel::Impl::stiffness_below(Vec3d surface_mm, Vec3d normal) const {
    constexpr int kSamples = 8;
    const double a = settings.tool_radius_mm;
    double softer = 0;
    for (int s = 0; s < kSamples; ++s) {
        const double depth = a * (0.25 + 1.75 * s / (kSamples - 1));
        const double value =
            sample_linear(shown, voxel_from_world(shown.grid, surface_mm - depth * normal));
        softer += softness(value, range) / (1 - kReference * kReference) / kSamples;
    }
    const double young_pa = settings.young_modulus_pa / softer;
    return 2e-3 * a * young_pa / (1 - kPoisson * kPoisson);
}

/// Displacement of the wall so far, from its position in the scan.
double ChainMailFeel::Impl::pushed_mm(Vec3d surface_mm, Vec3d normal) const {
    if (&scan == &shown) return 0;
    const Vec3d spacing = scan.grid.spacing_mm;
    const double step = 0.5 * std::min({spacing.x, spacing.y, spacing.z});
    const auto is_tissue = [&](double way) {
        const double hu =
            sample_linear(scan, voxel_from_world(scan.grid, surface_mm + way * normal));
        return settings.polarity == Polarity::Rising ? hu >= settings.iso_hu : hu < settings.iso_hu;
    };
    double way = step;  // the surface itself is neither tissue nor lumen
    while (way < settings.reach_mm && is_tissue(way)) way += step;
    return way - step;
}

Result<std::unique_ptr<ChainMailFeel>> ChainMailFeel::create(const Volume& volume,
                                                             const ChainMailSettings& materials,
                                                             const ChainMailFeelSettings& settings,
                                                             const TaskArena& arena) {
    return create(volume, volume, materials, settings, arena);
}

Result<std::unique_ptr<ChainMailFeel>> ChainMailFeel::create(const Volume& scan,
                                                             const Volume& shown,
                                                             const ChainMailSettings& materials,
                                                             const ChainMailFeelSettings& settings,
                                                             const TaskArena& arena) {
    if (const Status s = check(settings, chainmail_feel_rows()); !s)
        return within("haptics", s.error());
    if (const Status status = check_volume(shown, "shown"); !status.ok()) return status.error();
    ChainMailSettings own = materials;
    own.history_max_steps = 0;
    auto trial = ChainMail::create(scan, own, arena);
    if (!trial.ok()) return trial.error();
    return std::unique_ptr<ChainMailFeel>(
        new ChainMailFeel(std::make_unique<Impl>(scan, shown, std::move(*trial), settings, arena)));
}

ChainMailFeel::ChainMailFeel(std::unique_ptr<Impl> impl) : m_impl(std::move(impl)) {}
ChainMailFeel::~ChainMailFeel() = default;

void ChainMailFeel::update(std::span<const Box3i> boxes) {
    if (boxes.empty()) return;
    m_impl->walls.update(boxes);
    m_impl->has_contact = false;
}

void ChainMailFeel::set_wall(double iso_hu, Polarity polarity) {
    ChainMailFeelSettings& s = m_impl->settings;
    if (iso_hu == s.iso_hu && polarity == s.polarity) return;
    s.iso_hu = iso_hu;
    s.polarity = polarity;
    m_impl->has_contact = false;
}

ChainMailFeel::Give ChainMailFeel::give_at(Vec3d surface_mm, Vec3d normal) {
    Impl& m = *m_impl;
    if (m.has_contact && norm(surface_mm - m.contact_mm) < kSame_mm &&
        dot(normal, m.contact_normal) > kSameDirection)
        return m.contact_give;
    m.has_contact = true;
    m.contact_mm = surface_mm;
    m.contact_normal = normal;
    m.contact_give.stiffness_n_m = m.stiffness_below(surface_mm, normal);
    m.contact_give.limit_mm = std::numeric_limits<double>::infinity();
    const double pushed = m.pushed_mm(surface_mm, normal);
    const Vec3d at_rest = surface_mm + pushed * normal;
    const auto report =
        m.trial.push({.point_mm = at_rest - (0.5 * m.settings.tool_radius_mm) * normal,
                      .push_mm = -m.settings.reach_mm * normal,
                      .sphere_radius_mm = m.settings.tool_radius_mm});
    if (report.ok() && report->grabbed_elements > 0 && report->step_fraction < 1)
        m.contact_give.limit_mm =
            std::max(0.0, report->step_fraction * m.settings.reach_mm - pushed);
    m.trial.reset();
    return m.contact_give;
}

HapticModel ChainMailFeel::model(Vec3d tool_mm, Vec3d proxy_mm) {
    Impl& m = *m_impl;
    HapticModel model = m.walls.around(m.settings, proxy_mm);
    if (model.plane_count == 0) return model;
    const WallContact contact = Walls::contact(model, tool_mm, m.settings.tool_radius_mm);
    const auto& [entry, surface, normal, depth] = contact;
    const Give give = give_at(surface, normal);
    double force = 0, stiffness = 0;
    wall_law(give, m.settings.bone_n_m, depth, force, stiffness);
    model.depth_mm = depth * normal;
    model.force_n = force * normal;
    const double aside = kTangential * stiffness;
    for (int c = 0; c < 3; ++c) {
        model.stiffness_n_m.columns[c] = ((stiffness - aside) * normal[c]) * normal;
        model.stiffness_n_m.columns[c][c] += aside;
    }
    return model;
}

}  // namespace pliant
