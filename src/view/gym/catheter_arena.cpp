// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include <pliant/data/gym.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>

#include "base/errors.h"
#include "base/hash.h"
#include "base/text.h"
#include "gym/device_shadow.h"
#include "gym/for_all.h"
#include "render/camera.h"
#include "render/detector.h"

namespace pliant {
namespace {

constexpr std::size_t kNumbers = 3;  ///< of an action
constexpr double kDegrees = 180 / std::numbers::pi;
constexpr double kTurning_s = 0.2;  ///< of place()
constexpr int kPolled = 4;          ///< time steps from one look at an interruption to the next

Status check_bounds(const char* name, double value, double low, double high) {
    if (value >= low && value <= high) return Ok{};
    return expected_error(name, "a number " + short_text(low) + " to " + short_text(high),
                          text_of(value));
}

Status check_catheters(const Volume& scan, const CatheterArenaSettings& s) {
    for (const Status& status :
         {check_volume(scan), check_bounds("count", s.count, 1, 4096),
          check_bounds("width", s.width, 1, 8192), check_bounds("height", s.height, 1, 8192),
          check_bounds("control_hz", s.control_hz, 1e-2, 1e5),
          check_bounds("device_water", s.device_water, 0, 1000),
          check_bounds("points", s.points, 1, 1024),
          check_bounds("points_mm", s.points_mm, 1e-3, 1e4),
          check_bounds("max_bend_rad", s.max_bend_rad, 0, 2 * std::numbers::pi),
          check_bounds("bend_rad", s.bend_rad, -s.max_bend_rad, s.max_bend_rad),
          check_bounds("view.source_mm", s.view.source_mm, 1, 1e6),
          check_bounds("view.width_mm", s.view.width_mm, 1e-3, 1e6),
          check_bounds("view.contrast", s.view.contrast, 1e-6, 1e6),
          check_bounds("view.noise", s.view.noise, 0, 1e6),
          check_bounds("time_step_s", s.catheter.time_step_s, 1e-5, 0.05)})
        if (!status.ok()) return status;
    if (!(norm(s.view.look) > 0))
        return expected_error("view.look", "a direction", text_of(s.view.look));
    return Ok{};
}

/// The scan's shadow, for pictures of one size.
struct Roadmap {
    gym::XRay rays;
    render::Camera camera;
    std::vector<float> water_mm;
    double exposure_mm;

    Roadmap(const Volume& scan, const Fluoroscopy& view, int width, int height,
            const TaskArena& threads)
        : rays(view, width, height),
          camera(render::x_ray_source(view, width, height), width, height),
          water_mm(water_lengths_mm(scan, view, width, height, threads)),
          exposure_mm(view.exposure_water_mm
                          ? *view.exposure_water_mm
                          : render::metered_water_mm(scan, view, width, height)) {}
};

/// One catheter, with the scratch memory of its pictures.
struct ArenaCatheter {
    explicit ArenaCatheter(CatheterScene made) : scene(std::move(made)) {}

    CatheterScene scene;
    CatheterArenaState state;
    bool is_stale = true;      ///< the picture is not of the present state
    std::vector<double> kept;  ///< before a step
    CatheterArenaState kept_state;
    std::vector<Vec3d> wall;
    std::vector<gym::NearWire> nearest;
    std::vector<float> water_mm;
};

}  // namespace

struct CatheterArena::Impl {
    Impl(const Volume& v, const CatheterArenaSettings& s, const TaskArena& t)
        : scan(v), settings(s), threads(t) {
        const double duration = 1 / s.control_hz;
        steps = std::max(1, int(std::ceil(duration / s.catheter.time_step_s - 1e-9)));
        settings.catheter.time_step_s = duration / steps;
    }

    const TaskArena& inner() const {
        return gym::is_parallel_outside(catheters.size(), threads) ? one : threads;
    }
    std::size_t pixels() const {
        return std::size_t(settings.width) * std::size_t(settings.height);
    }
    std::span<const Vec3d> wire_of(const ArenaCatheter& c) const {
        const auto all = c.scene.wire_positions();
        return all.subspan(std::size_t(c.scene.first_inserted()));
    }
    /// Nodes beyond the guide, behind the guide's end.
    std::vector<Vec3d> outside_of_guide(const ArenaCatheter& c) const {
        const auto wire = wire_of(c);
        std::vector<Vec3d> nodes{settings.catheter.entry.position_mm};
        if (wire.size() > 1) nodes.insert(nodes.end(), wire.begin() + 1, wire.end());
        return nodes;
    }

    Status start() {
        initial = catheters.front()->scene.state();
        for (auto& c : catheters) measure(*c);
        return Ok{};
    }

    /// @param action  insertion, rotation, bending; count time steps
    Status move(ArenaCatheter& c, const double* action, int count) const {
        const double h = settings.catheter.time_step_s;
        for (int n = 0; n < count; ++n) {
            const double bend = std::clamp(c.state.bend_rad + h * action[2], -settings.max_bend_rad,
                                           settings.max_bend_rad);
            const bool is_out = c.scene.quick_measures().left_end > 0;
            if (const Status s =
                    c.scene.command({.insert_mm_s = is_out ? std::min(action[0], 0.0) : action[0],
                                     .rotate_deg_s = action[1] * kDegrees,
                                     .bend_first_deg = bend * kDegrees});
                !s.ok())
                return s;
            if (const Status s = c.scene.step(1, inner()); !s.ok()) return s;
            c.state.bend_rad = bend;
        }
        return Ok{};
    }

    void measure(ArenaCatheter& c) const {
        const CatheterMeasures m = c.scene.quick_measures();
        const Rotation frame = c.scene.tip_frame();
        CatheterArenaState& s = c.state;
        s.tip_mm = c.scene.tip_mm();
        s.ahead = rotated(frame, {0, 0, 1});
        s.bends_to = rotated(frame, {1, 0, 0});
        s.inserted_mm = m.inserted_mm;
        s.rotated_rad = m.rotated_deg / kDegrees;
        s.push_n = m.force_n;
        s.wall_force_n = m.contact_n;
        s.depth_mm = m.depth_mm;
        s.left_end = m.left_end;
        s.max_displacement_mm = 0;
        if (settings.catheter.wall.model == WallModel::Rigid) return;
        const auto& rest = c.scene.wall().mesh.nodes_mm;
        c.wall.resize(rest.size());
        c.scene.body().get_positions(c.wall);
        double square = 0;
        for (std::size_t n = 0; n < rest.size(); ++n) {
            const Vec3d by = c.wall[n] - rest[n];
            square = std::max(square, dot(by, by));
        }
        s.max_displacement_mm = std::sqrt(square);
    }

    void keep(ArenaCatheter& c) const {
        c.kept = c.scene.state();
        c.kept_state = c.state;
    }
    /// An interruption doesn't end this.
    void take_back(ArenaCatheter& c) const {
        if (c.kept.empty()) return;
        (void)c.scene.restore(c.kept, one);
        c.state = c.kept_state;
    }

    Status step(std::span<const double> actions, std::span<const std::uint8_t> moves) {
        const auto is_moving = [&](std::size_t n) { return moves.empty() || moves[n]; };
        for (auto& c : catheters) c->kept.clear();
        const auto go = [&]() -> Status {
            if (const Status s = gym::for_all(catheters.size(), threads,
                                              [&](std::size_t n) -> Status {
                                                  if (is_moving(n)) keep(*catheters[n]);
                                                  return Ok{};
                                              });
                !s.ok())
                return s;
            for (int done = 0; done < steps; done += kPolled) {
                const int count = std::min(kPolled, steps - done);
                const Status s =
                    gym::for_all(catheters.size(), threads, [&](std::size_t n) -> Status {
                        if (!is_moving(n)) return Ok{};
                        return move(*catheters[n], &actions[kNumbers * n], count);
                    });
                if (!s.ok()) return s;
            }
            return Ok{};
        };
        const Status done = attempt(go);
        if (!done.ok()) {
            for (auto& c : catheters) take_back(*c);
            return done;
        }
        for (std::size_t n = 0; n < catheters.size(); ++n) {
            if (!is_moving(n)) continue;
            ++catheters[n]->state.steps;
            measure(*catheters[n]);
            catheters[n]->is_stale = true;
        }
        return Ok{};
    }

    void track(std::size_t n) {
        const std::vector<Vec3d> nodes = outside_of_guide(*catheters[n]);
        float* to = points.data() + 2 * n * std::size_t(settings.points);
        std::size_t at = nodes.size() - 1;
        double before = 0;  // from nodes[at] to the last point, towards the guide
        for (int p = 0; p < settings.points; ++p) {
            double left = p == 0 ? 0 : before + settings.points_mm;
            while (at > 0 && left > norm(nodes[at - 1] - nodes[at])) {
                left -= norm(nodes[at - 1] - nodes[at]);
                --at;
            }
            const double length = at > 0 ? norm(nodes[at - 1] - nodes[at]) : 0;
            const Vec3d position =
                length > 0 ? nodes[at] + (left / length) * (nodes[at - 1] - nodes[at]) : nodes[at];
            before = at > 0 ? left : 0;
            const gym::Projected projected = roadmap->rays.project(position);
            *to++ = float(projected.right_mm);
            *to++ = float(projected.up_mm);
        }
    }

    /// @param[out] picture  one for each pixel
    void draw(ArenaCatheter& c, const Roadmap& map, int width, int height,
              std::span<std::uint8_t> picture) const {
        const std::vector<Vec3d> nodes = outside_of_guide(c);
        c.water_mm = map.water_mm;
        map.rays.add_wire(nodes, settings.catheter.catheter.radius_mm, settings.device_water,
                          c.nearest, c.water_mm);
        Fluoroscopy view = settings.view;
        view.seed += std::uint32_t(c.state.steps);
        std::size_t n = 0;
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x, ++n)
                picture[n] = render::detected(view, map.camera, x, y, double(c.water_mm[n]),
                                              map.exposure_mm);
    }

    Status look() {
        return gym::for_all(catheters.size(), threads, [&](std::size_t n) -> Status {
            ArenaCatheter& c = *catheters[n];
            if (!c.is_stale) return Ok{};
            track(n);
            if (settings.has_pictures)
                draw(c, *roadmap, settings.width, settings.height,
                     std::span(grey).subspan(n * pixels(), pixels()));
            c.is_stale = false;
            return Ok{};
        });
    }

    const Volume& scan;
    CatheterArenaSettings settings;
    const TaskArena& threads;
    TaskArena one{HostJobs{}};  ///< a catheter's own loops if the catheters are the parallel part
    int steps = 1;              ///< time steps in one of control
    std::vector<std::unique_ptr<ArenaCatheter>> catheters;
    std::vector<double> initial;             ///< state of a scene
    std::unique_ptr<Roadmap> roadmap, last;  ///< last: of picture()
    int last_width = 0, last_height = 0;
    std::vector<std::uint8_t> grey;
    std::vector<float> points;
};

CatheterArena::CatheterArena(std::unique_ptr<Impl> impl) : m_impl(std::move(impl)) {}
CatheterArena::~CatheterArena() = default;

Result<std::unique_ptr<CatheterArena>> CatheterArena::create(const VesselWall& wall,
                                                             const Volume& scan,
                                                             const CatheterArenaSettings& settings,
                                                             const TaskArena& threads) noexcept {
    return attempt([&]() -> Result<std::unique_ptr<CatheterArena>> {
        if (const Status s = check_catheters(scan, settings); !s.ok()) return s.error();
        auto impl = std::make_unique<Impl>(scan, settings, threads);
        impl->catheters.resize(std::size_t(settings.count));
        const Status made =
            gym::for_all(impl->catheters.size(), threads, [&](std::size_t n) -> Status {
                auto scene = CatheterScene::create(wall, impl->settings.catheter);
                if (!scene) return scene.error();
                impl->catheters[n] = std::make_unique<ArenaCatheter>(std::move(*scene));
                impl->catheters[n]->state.bend_rad = settings.bend_rad;
                return Ok{};
            });
        if (!made.ok()) return made.error();
        impl->points.resize(2 * std::size_t(settings.points) * impl->catheters.size());
        if (settings.has_pictures) impl->grey.resize(impl->pixels() * impl->catheters.size());
        // Projections need the rays alone.
        const int width = settings.has_pictures ? settings.width : 1,
                  height = settings.has_pictures ? settings.height : 1;
        impl->roadmap = std::make_unique<Roadmap>(scan, settings.view, width, height, threads);
        if (const Status s = impl->start(); !s.ok()) return s.error();
        return std::unique_ptr<CatheterArena>(new CatheterArena(std::move(impl)));
    });
}

Status CatheterArena::place(int catheter, double rotated_rad) noexcept {
    PLIANT_ASSERT(catheter >= 0 && catheter < count());
    return attempt([&]() -> Status {
        if (!(std::abs(rotated_rad) <= 1e4))
            return expected_error("rotated_rad", "a number -10000 to 10000", text_of(rotated_rad));
        Impl& i = *m_impl;
        ArenaCatheter& c = *i.catheters[std::size_t(catheter)];
        i.keep(c);
        const auto go = [&]() -> Status {
            if (const Status s = c.scene.restore(i.initial, i.threads); !s.ok()) return s;
            c.state = {};
            c.state.bend_rad = i.settings.bend_rad;
            const double h = i.settings.catheter.time_step_s;
            const int count = std::max(1, int(std::ceil(kTurning_s / h)));
            const double action[] = {0, rotated_rad / (count * h), 0};
            return i.move(c, action, count);
        };
        if (const Status s = attempt(go); !s.ok()) {
            i.take_back(c);
            return s;
        }
        i.measure(c);
        c.is_stale = true;
        return Ok{};
    });
}

Status CatheterArena::step(std::span<const double> actions,
                           std::span<const std::uint8_t> moves) noexcept {
    return attempt([&]() -> Status {
        const std::size_t count = m_impl->catheters.size();
        if (actions.size() != kNumbers * count)
            return expected_error("actions", std::to_string(kNumbers * count) + " numbers",
                                  std::to_string(actions.size()));
        if (!moves.empty() && moves.size() != count)
            return expected_error("moves", std::to_string(count) + " flags",
                                  std::to_string(moves.size()));
        for (std::size_t n = 0; n < actions.size(); ++n) {
            if (!moves.empty() && !moves[n / kNumbers]) continue;
            if (!std::isfinite(actions[n]))
                return expected_error("actions", "finite numbers", text_of(actions[n]));
            if (!(std::abs(actions[n]) <= 1000))
                return expected_error("actions", "speeds of at most 1000 mm/s or rad/s",
                                      short_text(actions[n]));
        }
        if (const Status s = m_impl->step(actions, moves); !s.ok()) return s;
        return m_impl->look();
    });
}

Status CatheterArena::look() noexcept {
    return attempt([&] { return m_impl->look(); });
}

std::span<const std::uint8_t> CatheterArena::pictures() const {
    return m_impl->grey;
}
std::span<const float> CatheterArena::points() const {
    return m_impl->points;
}

std::array<double, 2> CatheterArena::project(Vec3d point_mm) const {
    const gym::Projected p = m_impl->roadmap->rays.project(point_mm);
    constexpr double kNone = std::numeric_limits<double>::infinity();
    if (p.scale == 0) return {kNone, kNone};
    return {p.right_mm, p.up_mm};
}

Result<Image> CatheterArena::picture(int catheter, int width, int height) const noexcept {
    return attempt([&]() -> Result<Image> {
        Impl& i = *m_impl;
        if (!i.last || i.last_width != width || i.last_height != height) {
            i.last = std::make_unique<Roadmap>(i.scan, i.settings.view, width, height, i.threads);
            i.last_width = width;
            i.last_height = height;
        }
        std::vector<std::uint8_t> grey(std::size_t(width) * std::size_t(height));
        i.draw(*i.catheters[std::size_t(catheter)], *i.last, width, height, grey);
        Image image{width, height, {}};
        for (const std::uint8_t g : grey) image.pixels.push_back({g, g, g});
        return image;
    });
}

const CatheterArenaState& CatheterArena::state(int catheter) const {
    return m_impl->catheters[std::size_t(catheter)]->state;
}
const CatheterScene& CatheterArena::scene(int catheter) const {
    return m_impl->catheters[std::size_t(catheter)]->scene;
}
int CatheterArena::count() const {
    return int(m_impl->catheters.size());
}
const CatheterArenaSettings& CatheterArena::settings() const {
    return m_impl->settings;
}
std::uint64_t CatheterArena::hash(int catheter) const {
    const ArenaCatheter& c = *m_impl->catheters[std::size_t(catheter)];
    Hash64 hash;
    hash.add_word(c.scene.hash());
    hash.add(std::span<const double>(&c.state.bend_rad, 1));
    return hash.value();
}

Result<std::vector<double>> CatheterArena::save_state(int catheter) const noexcept {
    return attempt([&]() -> Result<std::vector<double>> {
        const ArenaCatheter& c = *m_impl->catheters[std::size_t(catheter)];
        std::vector<double> numbers{c.state.bend_rad, double(c.state.steps)};
        const auto scene = c.scene.state();
        numbers.insert(numbers.end(), scene.begin(), scene.end());
        return numbers;
    });
}

Status CatheterArena::load_state(int catheter, std::span<const double> state) noexcept {
    return attempt([&]() -> Status {
        Impl& i = *m_impl;
        ArenaCatheter& c = *i.catheters[std::size_t(catheter)];
        if (state.size() < 2 || !(std::abs(state[0]) <= i.settings.max_bend_rad) ||
            !(state[1] >= 0 && state[1] < 1e15))
            return invalid("state: expected one of an arena with the same wall and settings");
        if (const Status s = c.scene.restore(state.subspan(2), i.threads); !s.ok()) return s;
        c.state.bend_rad = state[0];
        c.state.steps = std::int64_t(state[1]);
        i.measure(c);
        c.is_stale = true;
        return Ok{};
    });
}

}  // namespace pliant
