// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include <pliant/models/eye_deformation.h>
#include <pliant/resample.h>

#include <cmath>
#include <optional>
#include <utility>

#include "base/errors.h"
#include "base/text.h"

namespace pliant {

struct EyeDeformation::Impl {
    Impl(ChainMail t, const EyeSettings& s) : tissue(std::move(t)), settings(s) {}

    ChainMail tissue;
    EyeSettings settings;
    std::optional<LiveDeformation> live;  ///< set after construction
};

EyeDeformation::EyeDeformation(std::unique_ptr<Impl> impl) : m_impl(std::move(impl)) {}
EyeDeformation::~EyeDeformation() = default;

Result<std::unique_ptr<EyeDeformation>> EyeDeformation::create(const Volume& scan,
                                                               const EyeSettings& settings,
                                                               const TaskArena& arena) noexcept {
    return attempt([&]() -> Result<std::unique_ptr<EyeDeformation>> {
        if (!(settings.radius_mm > 0) || !std::isfinite(settings.radius_mm))
            return expected_error("radius_mm", "a radius above 0", text_of(settings.radius_mm));
        auto tissue = ChainMail::create(scan, settings.materials, arena);
        if (!tissue) return tissue.error();
        auto impl = std::make_unique<Impl>(std::move(*tissue), settings);
        auto live = LiveDeformation::create(impl->tissue);
        if (!live) return live.error();
        impl->live.emplace(std::move(*live));
        return std::unique_ptr<EyeDeformation>(new EyeDeformation(std::move(impl)));
    });
}

Result<EyeMove> EyeDeformation::deform(Vec3d last_eye_mm, Vec3d eye_mm) noexcept {
    return attempt([&]() -> Result<EyeMove> {
        EyeMove move{.eye_mm = eye_mm};
        if (eye_mm != last_eye_mm) {
            const Push path{last_eye_mm, eye_mm - last_eye_mm, m_impl->settings.radius_mm};
            const auto slid = slide_sphere(m_impl->tissue, path, m_impl->settings.values);
            if (!slid) return slid.error();
            move.eye_mm = slid->end_mm;
            move.touched = slid->contacts > 0;
            move.is_stopped = slid->limited_by != LimitedBy::None;
            move.solve_ms = slid->slide_ms;
        }
        const auto update = m_impl->live->update();
        if (!update) return update.error();
        move.boxes = update->boxes;
        move.resample_ms = update->resample_ms;
        return move;
    });
}

const Volume& EyeDeformation::volume() const {
    return m_impl->live->volume();
}

ChainMail& EyeDeformation::tissue() {
    return m_impl->tissue;
}

}  // namespace pliant
