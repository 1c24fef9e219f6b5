// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <utility>

#include "base/errors.h"
#include "base/text.h"
#include "gym/endoscope_scope.h"
#include "gym/endoscope_sight.h"
#include "gym/for_all.h"

namespace pliant {
namespace {

constexpr int kMaxCount = 4096, kMaxPixels = 8192;
constexpr std::size_t kActions = 4;

Status check_range(const char* name, double value, double low, double high) {
    if (value >= low && value <= high) return Ok{};
    return expected_error(name, "a number " + short_text(low) + " to " + short_text(high),
                          text_of(value));
}

Status check_arena(const Volume& scan, const EndoscopeArenaSettings& s) {
    for (const Status& status : {check_volume(scan), check_range("count", s.count, 1, kMaxCount),
                                 check_range("width", s.width, 1, kMaxPixels),
                                 check_range("height", s.height, 1, kMaxPixels),
                                 check_range("control_hz", s.control_hz, 1e-3, 1e6),
                                 check_range("radius_mm", s.radius_mm, 1e-3, 100),
                                 check_range("relax_sweeps", s.relax_sweeps, 0, 1000),
                                 check_range("relax_every", s.relax_every, 1, 1000),
                                 check_range("young_modulus_pa", s.young_modulus_pa, 1, 1e9),
                                 check_range("field_of_view_deg", s.field_of_view_deg, 1, 170),
                                 check_range("barrel_distortion", s.barrel_distortion, 0, 2),
                                 check_range("scale", s.materials.scale, 1, 1)})
        if (!status.ok()) return status;
    if (!std::isfinite(s.iso_hu))
        return about("iso_hu", ErrorCode::InvalidArgument, "expected a number");
    if (s.labels && s.labels->grid.size != scan.grid.size)
        return about("labels", ErrorCode::InvalidArgument, "expected the scan's size");
    return Ok{};
}

}  // namespace

struct EndoscopeArena::Impl {
    Impl(const Volume& v, const EndoscopeArenaSettings& s, const TaskArena& t) : scan(v, s, t) {
        const std::size_t pixels = pixels_of_one() * std::size_t(s.count);
        if (s.has_colour) colour.resize(pixels);
        if (s.has_depth) depth_mm.resize(pixels);
        if (s.has_normals) normals.resize(pixels);
        if (s.has_flow) {
            flow.resize(2 * pixels);
            visibility.resize(pixels);
            scene_flow_mm.resize(pixels);
            if (s.labels) labels.resize(pixels);
        }
        stale.assign(std::size_t(s.count), true);
        follows.assign(std::size_t(s.count), false);
        for (int n = 0; n < s.count; ++n) sights.emplace_back(scan);
    }

    std::size_t pixels_of_one() const {
        return std::size_t(scan.settings.width) * std::size_t(scan.settings.height);
    }
    SightTarget target(std::size_t n) {
        const std::size_t one = pixels_of_one();
        const auto part = [&]<class T>(std::vector<T>& all, std::size_t values = 1) {
            return all.empty() ? std::span<T>()
                               : std::span<T>(all).subspan(n * one * values, one * values);
        };
        return {part(colour),     part(depth_mm),      part(normals), part(flow, 2),
                part(visibility), part(scene_flow_mm), part(labels)};
    }

    /// Calls work(n) for all endoscopes. @returns the first error by number
    template <class Work>
    Status for_all(const Work& work) {
        return gym::for_all(scopes.size(), scan.threads, work);
    }

    Status look() {
        return for_all([&](std::size_t n) -> Status {
            if (!stale[n]) return Ok{};
            if (const Status s = scopes[n]->follow(); !s.ok()) return s;
            // After a failure in it, the points of the last picture are lost.
            sights[n].look(*scopes[n], std::exchange(follows[n], 0) != 0, target(n));
            stale[n] = 0;
            follows[n] = 1;
            return Ok{};
        });
    }

    /// The result of a change of an endoscope's state, unless that was refused.
    Status changed(std::size_t n, Status result) {
        if (result.ok() || result.error().code == ErrorCode::LimitExceeded) {
            stale[n] = 1;
            follows[n] = 0;
        }
        return result;
    }

    ArenaScan scan;
    std::vector<std::unique_ptr<Scope>> scopes;
    std::vector<Sight> sights;
    std::vector<Rgb8> colour;
    std::vector<float> depth_mm;
    std::vector<Vec3f> normals;
    std::vector<float> flow;
    std::vector<FlowVisibility> visibility;
    std::vector<Vec3f> scene_flow_mm;
    std::vector<std::int16_t> labels;
    std::vector<std::uint8_t> stale;    ///< the picture is not of the present state
    std::vector<std::uint8_t> follows;  ///< the picture is that of the state before the next step
};

EndoscopeArena::EndoscopeArena(std::unique_ptr<Impl> impl) : m_impl(std::move(impl)) {}
EndoscopeArena::~EndoscopeArena() = default;

Result<std::unique_ptr<EndoscopeArena>> EndoscopeArena::create(
    const Volume& scan, const EndoscopeArenaSettings& settings, const TaskArena& threads) noexcept {
    return attempt([&]() -> Result<std::unique_ptr<EndoscopeArena>> {
        if (const Status s = check_arena(scan, settings); !s.ok()) return s.error();
        auto impl = std::make_unique<Impl>(scan, settings, threads);
        std::optional<EndoscopePose> start;
        if (const auto view = find_endoscope(scan, settings.iso_hu, settings.polarity, threads))
            start = EndoscopePose{view->eye_mm, view->look, view->up};
        impl->scopes.resize(std::size_t(settings.count));
        for (auto& scope : impl->scopes) {
            auto made = Scope::create(impl->scan);
            if (!made) return made.error();
            scope = std::move(*made);
            // A scan without a lumen has no start; then place() has to succeed first.
            if (!start) continue;
            if (const Status s = scope->place(*start);
                !s.ok() && s.error().code == ErrorCode::LimitExceeded)
                return s.error();
        }
        return std::unique_ptr<EndoscopeArena>(new EndoscopeArena(std::move(impl)));
    });
}

Status EndoscopeArena::place(int endoscope, const EndoscopePose& pose) noexcept {
    PLIANT_ASSERT(endoscope >= 0 && endoscope < count());
    return attempt([&]() -> Status {
        const auto n = std::size_t(endoscope);
        return m_impl->changed(n, m_impl->scopes[n]->place(pose));
    });
}

Status EndoscopeArena::step(std::span<const double> actions,
                            std::span<const std::uint8_t> moves) noexcept {
    return attempt([&]() -> Status {
        const std::size_t count = m_impl->scopes.size();
        if (actions.size() != kActions * count)
            return expected_error("actions", std::to_string(kActions * count) + " numbers",
                                  std::to_string(actions.size()));
        if (!moves.empty() && moves.size() != count)
            return expected_error("moves", std::to_string(count) + " flags",
                                  std::to_string(moves.size()));
        for (std::size_t n = 0; n < actions.size(); ++n) {
            const bool is_used = moves.empty() || moves[n / kActions] != 0;
            if (is_used && !std::isfinite(actions[n]))
                return expected_error("actions", "finite numbers", text_of(actions[n]));
            const double mm = actions[n] / m_impl->scan.settings.control_hz;
            if (is_used && n % kActions == 0 && !(std::abs(mm) <= 500))
                return expected_error("actions", "an advance of at most 500 mm a step",
                                      short_text(mm));
        }
        Status moved = m_impl->for_all([&](std::size_t n) -> Status {
            if (!moves.empty() && !moves[n]) return Ok{};
            const Status s = m_impl->scopes[n]->step(&actions[kActions * n]);
            m_impl->stale[n] = 1;
            return s;
        });
        if (!moved.ok()) return moved;
        return m_impl->look();
    });
}

Status EndoscopeArena::look() noexcept {
    return attempt([&] { return m_impl->look(); });
}

Result<PushReport> EndoscopeArena::push(int endoscope, const Push& push) noexcept {
    PLIANT_ASSERT(endoscope >= 0 && endoscope < count());
    return attempt([&] {
        const auto n = std::size_t(endoscope);
        auto done = m_impl->scopes[n]->push(push);
        // The deformed scan may be behind.
        if (!done.ok() && done.error().code == ErrorCode::LimitExceeded) m_impl->stale[n] = 1;
        return done;
    });
}

EndoscopePictures EndoscopeArena::pictures() const {
    return {m_impl->colour,     m_impl->depth_mm,      m_impl->normals, m_impl->flow,
            m_impl->visibility, m_impl->scene_flow_mm, m_impl->labels};
}

Image EndoscopeArena::picture(int endoscope, int width, int height) const {
    const Scope& scope = *m_impl->scopes[std::size_t(endoscope)];
    return scope.rays().endoscope_view(scope.camera(), width, height);
}

const EndoscopeState& EndoscopeArena::state(int endoscope) const {
    return m_impl->scopes[std::size_t(endoscope)]->state();
}
int EndoscopeArena::count() const {
    return int(m_impl->scopes.size());
}
const EndoscopeArenaSettings& EndoscopeArena::settings() const {
    return m_impl->scan.settings;
}
Endoscope EndoscopeArena::camera(int endoscope) const {
    return m_impl->scopes[std::size_t(endoscope)]->camera();
}
const Volume& EndoscopeArena::scan() const {
    return m_impl->scan.volume;
}
const Volume& EndoscopeArena::volume(int endoscope) const {
    return m_impl->scopes[std::size_t(endoscope)]->volume();
}
const Deformation* EndoscopeArena::deformation(int endoscope) const {
    const ChainMail* const tissue = m_impl->scopes[std::size_t(endoscope)]->tissue();
    return tissue ? &tissue->deformation() : nullptr;
}
std::uint64_t EndoscopeArena::hash(int endoscope) const {
    return m_impl->scopes[std::size_t(endoscope)]->hash();
}

Result<std::vector<std::byte>> EndoscopeArena::save_state(int endoscope) const noexcept {
    return attempt([&]() -> Result<std::vector<std::byte>> {
        std::vector<std::byte> bytes;
        const Status s = m_impl->scopes[std::size_t(endoscope)]->save(bytes);
        if (!s.ok()) return s.error();
        return bytes;
    });
}

Status EndoscopeArena::load_state(int endoscope, std::span<const std::byte> state) noexcept {
    return attempt([&]() -> Status {
        const auto n = std::size_t(endoscope);
        return m_impl->changed(n, m_impl->scopes[n]->load(state));
    });
}

}  // namespace pliant
