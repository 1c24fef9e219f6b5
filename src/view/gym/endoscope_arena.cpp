// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include <pliant/resample.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <utility>

#include "base/errors.h"
#include "base/text.h"
#include "gym/endoscope_scope.h"
#include "gym/for_all.h"
#include "render/camera.h"
#include "resample/material_points.h"

namespace pliant {
namespace {

// The pictures of one endoscope of an arena, and the flow from one to the next.

/// Where one endoscope's pictures are written.
struct SightTarget {
    std::span<Rgb8> colour;
    std::span<float> depth_mm;
    std::span<Vec3f> normals;
    std::span<float> flow;
    std::span<FlowVisibility> visibility;
    std::span<Vec3f> scene_flow_mm;
    std::span<std::int16_t> labels;
};

class Sight {
  public:
    explicit Sight(const ArenaScan& scan) : m_scan(scan) {}

    /// Makes the pictures. @param follows  whether the last picture was that of the step before;
    /// else the flow is 0
    void look(const Scope& scope, bool follows, const SightTarget& target);

  private:
    void trace_flow(const Scope& scope, const SightTarget& target) const;
    void find_rest(const Scope& scope, const SightTarget& target, std::span<const Vec3f> normals);

    const ArenaScan& m_scan;
    // Per pixel of the last picture.
    std::vector<Vec3f> m_normals;      ///< if only labels need them
    std::vector<Vec3d> m_points_mm;    ///< infinite: none
    std::vector<Vec3d> m_rest_voxels;  ///< infinite: none
};

constexpr std::int64_t kRows = 16;  // of pixels, for each task
constexpr double kNowhere = std::numeric_limits<double>::infinity();

/// The wall is drawn where resampled values cross the threshold, up to about half a voxel beside
/// the tissue that was there. Tissue that is less than this behind the wall is not hidden.
constexpr double kBesideVoxels = 1;
constexpr double kBehindVoxels = 1;  // depth of a label behind the wall

bool is_there(Vec3d p) {
    return std::isfinite(p.x);
}

/// Calls visit(x, y) for the pixels of some rows in blocks of 4 × 2, the order that rays like best.
template <class Visit>
void for_each_in_blocks(int width, int begin, int end, const Visit& visit) {
    for (int top = begin; top < end; top += 2)
        for (int left = 0; left < width; left += 4)
            for (int y = top; y < std::min(top + 2, end); ++y)
                for (int x = left; x < std::min(left + 4, width); ++x) visit(x, y);
}

std::unique_ptr<MaterialPoints> points_of(const Scope& scope) {
    if (!scope.tissue()) return nullptr;
    return std::make_unique<MaterialPoints>(scope.tissue()->deformation().field());
}

void Sight::look(const Scope& scope, bool follows, const SightTarget& target) {
    const EndoscopeArenaSettings& s = m_scan.settings;
    const std::size_t count = std::size_t(s.width) * std::size_t(s.height);
    if (s.has_flow) {
        if (follows && m_points_mm.size() == count) {
            trace_flow(scope, target);
        } else {
            std::fill(target.flow.begin(), target.flow.end(), 0.0F);
            std::fill(target.visibility.begin(), target.visibility.end(), FlowVisibility::None);
            std::fill(target.scene_flow_mm.begin(), target.scene_flow_mm.end(), Vec3f{0, 0, 0});
        }
        m_points_mm.resize(count);
        m_rest_voxels.resize(count);
    }
    Endoscope camera = scope.camera();
    if (!s.has_colour && s.field_stop == FieldStop::Full) camera.style = Style::Plain;
    EndoscopeFrame frame{.colour = target.colour,
                         .depth_mm = target.depth_mm,
                         .normals = target.normals,
                         .is_smooth = s.is_smooth};
    if (s.has_flow) frame.points_mm = m_points_mm;
    if (s.has_flow && s.labels && frame.normals.empty()) {
        m_normals.resize(count);
        frame.normals = m_normals;
    }
    scope.rays().endoscope_frame(camera, s.width, s.height, frame);
    if (s.has_flow) find_rest(scope, target, frame.normals);
}

void Sight::find_rest(const Scope& scope, const SightTarget& target,
                      std::span<const Vec3f> normals) {
    const Grid& grid = m_scan.volume.grid;
    const Vec3d h = grid.spacing_mm;
    const double behind_mm = kBehindVoxels * std::max({h.x, h.y, h.z});
    const Volume* const labels = m_scan.settings.labels.get();
    const render::Camera camera(scope.camera(), 1, 1);
    m_scan.threads.for_each(
        m_scan.settings.height, kRows, [&](std::int64_t begin, std::int64_t end) {
            const auto tissue = points_of(scope);
            const auto rest_of = [&](Vec3d point_mm) -> std::optional<Vec3d> {
                const Vec3d now = voxel_from_world(grid, point_mm);
                return tissue ? tissue->rest(now) : now;
            };
            const std::size_t first = std::size_t(begin) * std::size_t(m_scan.settings.width);
            const std::size_t last = std::size_t(end) * std::size_t(m_scan.settings.width);
            for (std::size_t n = first; n < last; ++n) {
                std::optional<Vec3d> rest;
                if (is_there(m_points_mm[n])) rest = rest_of(m_points_mm[n]);
                m_rest_voxels[n] = rest.value_or(Vec3d{kNowhere, kNowhere, kNowhere});
                if (!labels) continue;
                target.labels[n] = 0;
                if (!rest) continue;
                const Vec3f out = normals[n];
                const Vec3d normal = double(out.x) * camera.right() - double(out.y) * camera.up() +
                                     double(out.z) * camera.forward();
                const auto inside = rest_of(m_points_mm[n] - behind_mm * normal);
                const Vec3d at = inside.value_or(*rest);
                Vec3i voxel;
                for (int a = 0; a < 3; ++a)
                    voxel[a] = std::clamp(int(std::lround(at[a])), 0, grid.size[a] - 1);
                target.labels[n] = std::int16_t(labels->at(voxel));
            }
        });
}

void Sight::trace_flow(const Scope& scope, const SightTarget& target) const {
    const EndoscopeArenaSettings& s = m_scan.settings;
    const Grid& grid = m_scan.volume.grid;
    const Vec3d h = grid.spacing_mm;
    const double beside_mm = kBesideVoxels * std::max({h.x, h.y, h.z});
    const Endoscope view = scope.camera();
    const render::Camera camera(view, s.width, s.height);
    m_scan.threads.for_each(s.height, kRows, [&](std::int64_t begin, std::int64_t end) {
        const auto tissue = points_of(scope);
        std::vector<Vec3d> directions;
        std::vector<std::size_t> asked;
        for_each_in_blocks(s.width, int(begin), int(end), [&](int x, int y) {
            const std::size_t n = std::size_t(y) * std::size_t(s.width) + std::size_t(x);
            float* const flow = &target.flow[2 * n];
            flow[0] = flow[1] = 0;
            target.visibility[n] = FlowVisibility::None;
            target.scene_flow_mm[n] = {0, 0, 0};
            if (!is_there(m_rest_voxels[n])) return;
            const Vec3d q =
                world_from_voxel(grid, tissue ? tissue->now(m_rest_voxels[n]) : m_rest_voxels[n]);
            const Vec3d moved = q - m_points_mm[n];
            target.scene_flow_mm[n] = {float(moved.x), float(moved.y), float(moved.z)};
            target.visibility[n] = FlowVisibility::Outside;
            const Vec3d from_eye = q - view.eye_mm;
            const auto at = camera.project(from_eye);
            if (!at) return;
            flow[0] = float(at->x - (x + 0.5));
            flow[1] = float(at->y - (y + 0.5));
            const bool is_inside =
                at->x >= 0 && at->x <= s.width && at->y >= 0 && at->y <= s.height;
            if (!is_inside) return;
            asked.push_back(n);
            directions.push_back(from_eye);
        });
        std::vector<double> shares(directions.size());
        scope.rays().first_hits(view.eye_mm, directions, s.iso_hu, s.polarity, shares);
        for (std::size_t n = 0; n < asked.size(); ++n) {
            const double behind_mm = (1 - shares[n]) * norm(directions[n]);
            target.visibility[asked[n]] =
                behind_mm > beside_mm ? FlowVisibility::Hidden : FlowVisibility::Seen;
        }
    });
}

constexpr int kMaxCount = 4096, kMaxPixels = 8192;
constexpr std::size_t kActions = 4;

Status check_range(const char* name, double value, double low, double high) {
    if (value >= low && value <= high) return Ok{};
    return expected_error(name, "a number " + short_text(low) + " to " + short_text(high),
                          text_of(value));
}

double scale_of(const ScanTissueSettings& materials) {
    const auto* const chainmail = std::get_if<ChainMailSettings>(&materials);
    return chainmail ? chainmail->scale : 1;
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
                                 check_range("scale", scale_of(s.materials), 1, 1)})
        if (!status.ok()) return status;
    if (!std::isfinite(s.iso_hu))
        return about("iso_hu", ErrorCode::InvalidArgument, "expected a number");
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
        EndoscopeArenaSettings placed = settings;
        if (settings.labels) {
            auto labels = labels_on(*settings.labels, scan.grid, threads);
            if (!labels) return labels.error();
            placed.labels = std::make_shared<const Volume>(std::move(*labels));
        }
        auto impl = std::make_unique<Impl>(scan, placed, threads);
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
    const Tissue* const tissue = m_impl->scopes[std::size_t(endoscope)]->tissue();
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
