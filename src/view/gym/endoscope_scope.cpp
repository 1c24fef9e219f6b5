// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "gym/endoscope_scope.h"

#include <pliant/core/output_file.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <numbers>

#include <stdlib.h>
#include <unistd.h>

#include "base/errors.h"
#include "base/hash.h"
#include "base/text.h"
#include "field/field.h"
#include "render/camera.h"

namespace pliant {
namespace {

constexpr std::uint32_t kTip = 1, kOther = 2;  ///< tools
constexpr double kPoisson = 0.45;
constexpr double kFeelWithin_mm = 10;  // deepest indentation that the force distinguishes
constexpr std::uint64_t kStateKind = 0x31'6d'79'67'2e'74'6c'70;  // "plt.gym1"

TissueValues tissue_values(const EndoscopeArenaSettings& s) {
    return {s.iso_hu, s.polarity == Polarity::Rising};
}

/// Unit vectors of a camera's axes.
EndoscopePose upright(const EndoscopePose& pose) {
    const render::Camera camera({.look = pose.look, .up = pose.up}, 1, 1);
    return {pose.eye_mm, camera.forward(), camera.up()};
}

/// Rotation by the length of a vector about its direction [rad].
Vec3d rotated(Vec3d v, Vec3d turn) {
    const double angle = norm(turn);
    if (!(angle > 0)) return v;
    const Vec3d axis = (1 / angle) * turn;
    return std::cos(angle) * v + std::sin(angle) * cross(axis, v) +
           (1 - std::cos(angle)) * dot(axis, v) * axis;
}

/// A folder for one file, removed with it.
class TemporaryFile {
  public:
    TemporaryFile() {
        std::error_code error;
        std::string folder =
            (std::filesystem::temp_directory_path(error) / "pliant-gym-XXXXXX").string();
        m_file = folder + "/tissue.plst";
        m_folder.reserve(folder.size());
        if (error || !::mkdtemp(folder.data())) return;
        m_folder = folder;
        m_file.replace(0, folder.size(), folder);
    }
    ~TemporaryFile() {  // without memory
        if (!is_there()) return;
        ::unlink(m_file.c_str());
        ::rmdir(m_folder.c_str());
    }
    TemporaryFile(const TemporaryFile&) = delete;
    TemporaryFile& operator=(const TemporaryFile&) = delete;

    bool is_there() const { return !m_folder.empty(); }
    const std::string& path() const { return m_file; }

  private:
    std::string m_folder, m_file;
};

/// All of a state but the tissue.
struct Head {
    std::uint64_t kind = kStateKind;
    std::uint64_t tissue_bytes = 0;  ///< that follow; 0: rigid walls
    std::int64_t steps = 0;
    Vec3d eye{}, look{}, up{}, force{};
    double max_displacement = 0;
    std::uint64_t flags = 0;  ///< touching, stopped
};
static_assert(std::is_trivially_copyable_v<Head> && sizeof(Head) == 136);

}  // namespace

Result<std::unique_ptr<Scope>> Scope::create(const ArenaScan& scan) {
    std::unique_ptr<Scope> made(new Scope(scan));
    if (scan.settings.deforms) {
        ScanTissueSettings materials = scan.settings.materials;
        if (auto* const chainmail = std::get_if<ChainMailSettings>(&materials))
            chainmail->history_max_steps = 1;  // a slide that would close the lumen is undone
        auto tissue = make_scan_tissue(scan.volume, materials, scan.one);
        if (!tissue) return tissue.error();
        made->m_tissue = std::move(*tissue);
        if (std::holds_alternative<ElasticScanSettings>(materials))
            made->m_elastic = dynamic_cast<NodeTissue*>(made->m_tissue.get());
        auto live = LiveDeformation::create(*made->m_tissue);
        if (!live) return live.error();
        made->m_live.emplace(std::move(*live));
        made->m_rays.emplace(made->m_live->volume(), scan.threads);
    }
    return made;
}

Endoscope Scope::camera() const {
    const EndoscopeArenaSettings& s = m_scan.settings;
    return {.eye_mm = m_state.pose.eye_mm,
            .look = m_state.pose.look,
            .up = m_state.pose.up,
            .field_of_view_deg = s.field_of_view_deg,
            .barrel_distortion = s.barrel_distortion,
            .iso_hu = s.iso_hu,
            .polarity = s.polarity,
            .style = s.style,
            .lining = s.lining,
            .field_stop = s.field_stop};
}

bool Scope::is_free(Vec3d position_mm) const {
    const Grid& grid = m_scan.volume.grid;
    const Vec3d ijk = voxel_from_world(grid, position_mm);
    for (int a = 0; a < 3; ++a)
        if (!(ijk[a] >= 0 && ijk[a] <= grid.size[a] - 1)) return false;
    return !tissue_values(m_scan.settings).hold(double(sample_linear(volume(), ijk)));
}

Status Scope::place(const EndoscopePose& pose) {
    if (!is_finite(pose.eye_mm) || !is_finite(pose.look) || !is_finite(pose.up) ||
        !(norm(pose.look) > 0))
        return about("pose", ErrorCode::InvalidArgument,
                     "expected finite numbers, and a look above 0");
    const Vec3d ijk = voxel_from_world(m_scan.volume.grid, pose.eye_mm);
    const bool is_lumen =
        !tissue_values(m_scan.settings).hold(double(sample_linear(m_scan.volume, ijk)));
    bool is_inside = true;
    for (int a = 0; a < 3; ++a)
        is_inside = is_inside && ijk[a] >= 0 && ijk[a] <= m_scan.volume.grid.size[a] - 1;
    if (!is_inside || !is_lumen)
        return about("eye_mm", ErrorCode::InvalidArgument,
                     "expected a position in a lumen of the scan, found " +
                         short_text(pose.eye_mm) + (is_inside ? " in tissue" : " outside"));
    m_state = {};
    m_state.pose = upright(pose);
    if (!m_tissue) return Ok{};
    if (const Status s = m_tissue->reset(); !s.ok()) return s;
    return follow();
}

void Scope::turn(const double* action) {
    const double seconds = 1 / m_scan.settings.control_hz;
    EndoscopePose& pose = m_state.pose;
    const Vec3d right = cross(pose.look, pose.up);
    const Vec3d turn = seconds * (action[1] * pose.look + action[2] * right - action[3] * pose.up);
    pose = upright({pose.eye_mm, rotated(pose.look, turn), rotated(pose.up, turn)});
}

/// Cuts the way at the outermost voxel centres.
Vec3d Scope::end_in_scan(Vec3d end_mm) const {
    constexpr double kInside = 1e-6;  // voxels
    const Grid& grid = m_scan.volume.grid;
    const Vec3d from = voxel_from_world(grid, m_state.pose.eye_mm),
                to = voxel_from_world(grid, end_mm);
    double share = 1;
    for (int a = 0; a < 3; ++a) {
        const double last = grid.size[a] - 1;
        if (to[a] < 0) share = std::min(share, (from[a] - kInside) / (from[a] - to[a]));
        if (to[a] > last) share = std::min(share, (last - kInside - from[a]) / (to[a] - from[a]));
    }
    share = std::clamp(share, 0.0, 1.0);
    return share < 1 ? m_state.pose.eye_mm + share * (end_mm - m_state.pose.eye_mm) : end_mm;
}

Status Scope::step(const double* action) {
    const EndoscopeState before = m_state;
    const Status done = attempt([&] { return advance(action); });
    if (!done.ok()) m_state = before;
    return done;
}

Status Scope::advance(const double* action) {
    turn(action);
    const double way_mm = action[0] / m_scan.settings.control_hz;
    const Vec3d meant = m_state.pose.eye_mm + way_mm * m_state.pose.look;
    const Vec3d wanted = end_in_scan(meant);
    m_state.is_stopped = wanted != meant;
    if (!m_tissue)
        slide_along(wanted);
    else if (const Status s = push_through(wanted); !s.ok())
        return s;
    feel(wanted);
    measure();
    ++m_state.steps;
    return Ok{};
}

Status Scope::push_through(Vec3d wanted_mm) {
    if (m_elastic) return push_elastic(wanted_mm);
    const EndoscopeArenaSettings& s = m_scan.settings;
    if (const Status slid = slide(wanted_mm); !slid.ok()) return slid;
    if (is_time_to_settle() && m_tissue->deformation().field().resident_brick_count() > 0) {
        // The tip keeps tissue off where it is now, also if it has not slid there.
        m_tissue->release(kTip);
        if (const Status placed = m_tissue->place_eye(kTip, m_state.pose.eye_mm, s.radius_mm);
            !placed.ok())
            return placed;
        if (const auto done = m_tissue->advance({.max_steps = s.relax_sweeps}); !done)
            return done.error();
    }
    return follow();
}

/// Slides the tip, unless it has no way to go.
Status Scope::slide(Vec3d wanted_mm) {
    const EndoscopeArenaSettings& s = m_scan.settings;
    const Vec3d way = wanted_mm - m_state.pose.eye_mm;
    if (!(norm(way) > 0)) return Ok{};
    const auto slid =
        m_tissue->slide(kTip, {m_state.pose.eye_mm, way, s.radius_mm}, tissue_values(s));
    if (!slid) return slid.error();
    m_state.pose.eye_mm = slid->end_mm;
    m_state.is_stopped = m_state.is_stopped || slid->limited_by != LimitedBy::None;
    return Ok{};
}

/// The same in the elastic scan. Its tip is a tool while it touches, which has a force, and an eye
/// otherwise. Its sphere keeps nodes out, but tissue between them may reach the eye: then the step
/// is undone.
Status Scope::push_elastic(Vec3d wanted_mm) {
    const EndoscopeArenaSettings& s = m_scan.settings;
    const Vec3d before_mm = m_state.pose.eye_mm;
    const auto place_eye = [&](double radius_mm) {
        return m_tissue->place_eye(kTip, m_state.pose.eye_mm, radius_mm);
    };
    m_elastic->state(m_before);
    const Status moved = [&]() -> Status {
        if (const Status placed = place_eye(0); !placed.ok()) return placed;
        if (const Status slid = slide(wanted_mm); !slid.ok()) return slid;
        if (!m_tissue->is_touched_by(kTip))
            if (const Status placed = place_eye(s.radius_mm); !placed.ok()) return placed;
        if (!is_time_to_settle()) return Ok{};
        const auto done = m_tissue->advance({.max_steps = s.relax_sweeps});
        return done ? Status(Ok{}) : Status(done.error());
    }();
    if (!moved.ok()) return moved;
    if (const Status shown = follow(); !shown.ok()) return shown;
    if (is_free(m_state.pose.eye_mm)) return Ok{};
    if (const Status undone = m_elastic->set_state(m_before); !undone.ok()) return undone;
    m_state.pose.eye_mm = before_mm;
    m_state.is_stopped = true;
    if (const Status placed = place_eye(s.radius_mm); !placed.ok()) return placed;
    return follow();
}

bool Scope::is_time_to_settle() const {
    const EndoscopeArenaSettings& s = m_scan.settings;
    return s.relax_sweeps > 0 && (m_state.steps + 1) % s.relax_every == 0;
}

Status Scope::follow() {
    if (!m_tissue) return Ok{};
    if (const Status s = m_tissue->update_deformation(); !s.ok()) return s;
    const std::uint64_t version = m_tissue->deformation().version();
    if (version == m_seen_version) return Ok{};
    return attempt([&]() -> Status {
        const auto update = m_live->update();
        if (!update) return update.error();
        // After a failure here, the boxes are lost.
        const Box3i all[] = {voxel_box(m_scan.volume.grid)};
        const auto boxes =
            m_rays_are_behind ? std::span<const Box3i>(all) : std::span(update->boxes);
        m_rays_are_behind = true;
        m_rays->update(boxes);
        m_rays_are_behind = false;
        m_seen_version = version;
        return Ok{};
    });
}

/// Moves along rigid walls: at each small part of the way the sphere leaves the wall along its
/// normal, and the eye stays where it was if that leads into a wall.
void Scope::slide_along(Vec3d wanted_mm) {
    constexpr int kTurns = 4;
    const EndoscopeArenaSettings& s = m_scan.settings;
    const Vec3d h = m_scan.volume.grid.spacing_mm;
    const Vec3d way = wanted_mm - m_state.pose.eye_mm;
    const double part_mm = std::min(0.5 * std::min({h.x, h.y, h.z}), 0.5 * s.radius_mm);
    const int parts = int(std::ceil(norm(way) / part_mm));
    const auto clearance_mm = [&](Vec3d position_mm) {
        const auto wall =
            m_scan.rest.nearest_surface(position_mm, s.radius_mm, s.iso_hu, s.polarity);
        return wall ? wall->distance_mm : s.radius_mm;
    };
    for (int n = 0; n < parts; ++n) {
        const Vec3d straight = m_state.pose.eye_mm + (1.0 / parts) * way;
        Vec3d next = straight;
        bool is_clear = false;
        for (int turn = 0; turn < kTurns && !is_clear && is_free(next); ++turn) {
            const auto wall = m_scan.rest.nearest_surface(next, s.radius_mm, s.iso_hu, s.polarity);
            is_clear = !wall;
            if (!wall) break;
            const Vec3d out = next - wall->point_mm;
            const double far_mm = norm(out);
            next = next + (s.radius_mm - wall->distance_mm + 1e-3) *
                              (far_mm > 1e-6 ? (1 / far_mm) * out : wall->normal);
        }
        // In a lumen that is narrower than the tip, it may go where there is more room.
        if (!is_clear)
            is_clear = is_free(next) && clearance_mm(next) > clearance_mm(m_state.pose.eye_mm);
        const double before_mm = norm(wanted_mm - m_state.pose.eye_mm);
        if (!is_clear || norm(wanted_mm - next) > before_mm + part_mm) {
            m_state.is_stopped = true;
            return;
        }
        if (norm(next - straight) > 0.5 * part_mm) m_state.is_stopped = true;
        m_state.pose.eye_mm = next;
    }
}

void Scope::feel(Vec3d wanted_mm) {
    const EndoscopeArenaSettings& s = m_scan.settings;
    m_state.is_touching = false;
    m_state.force_n = {0, 0, 0};
    if (m_elastic) {
        m_state.is_touching = m_tissue->is_touched_by(kTip);
        m_state.force_n = m_tissue->force_n(kTip).value_or(m_state.force_n);
        return;
    }
    const Vec3d ijk = voxel_from_world(m_scan.volume.grid, wanted_mm);
    const bool is_in_wall = tissue_values(s).hold(double(sample_linear(m_scan.volume, ijk)));
    const double within_mm = is_in_wall ? kFeelWithin_mm : s.radius_mm;
    const auto wall = m_scan.rest.nearest_surface(wanted_mm, within_mm, s.iso_hu, s.polarity);
    if (!wall && !is_in_wall) return;
    const double far_mm = wall ? wall->distance_mm : kFeelWithin_mm;
    const double deep_mm = is_in_wall ? s.radius_mm + far_mm : s.radius_mm - far_mm;
    if (!(deep_mm > 0)) return;
    m_state.is_touching = true;
    const double stiff = 4.0 / 3 * s.young_modulus_pa / (1 - kPoisson * kPoisson);
    const double newtons = stiff * std::sqrt(1e-3 * s.radius_mm) * std::pow(1e-3 * deep_mm, 1.5);
    Vec3d out = wall ? wanted_mm - wall->point_mm : -m_state.pose.look;
    if (is_in_wall && wall) out = -out;
    const double length = norm(out);
    m_state.force_n =
        newtons * (length > 1e-6 ? (1 / length) * out : (wall ? wall->normal : -m_state.pose.look));
}

void Scope::measure() {
    m_state.max_displacement_mm = 0;
    if (!m_tissue) return;
    const Field& field = m_tissue->deformation().field();
    const auto square = [](Fixed u) { return double(u) * double(u); };
    double largest = 0;  // square [units²]
    field.for_each_brick([&](const FieldBrick& brick) {
        if (brick.is_unplaced) return;
        double bound = 0;
        for (int a = 0; a < 3; ++a)
            bound += std::max(square(brick.u_min[a]), square(brick.u_max[a]));
        if (!(bound > largest)) return;
        for (int n = 0; n < field.elements_per_brick(); ++n)
            largest = std::max(
                largest, square(brick.u[0][n]) + square(brick.u[1][n]) + square(brick.u[2][n]));
    });
    m_state.max_displacement_mm = std::sqrt(largest) / kUnitsPerMm;
}

Result<PushReport> Scope::push(const Push& push) {
    if (!m_tissue) return about("push", ErrorCode::InvalidArgument, "expected walls that deform");
    if (m_elastic) m_elastic->state(m_before);
    auto done = m_tissue->push(kOther, push);
    if (!done) return done;
    m_tissue->release(kOther);  // its tissue stays until the next sweep
    const std::uint64_t before = m_seen_version;
    if (const Status s = follow(); !s.ok()) return s.error();
    if (!is_free(m_state.pose.eye_mm)) {
        const Status undone = m_elastic ? m_elastic->set_state(m_before) : m_tissue->undo();
        if (!undone.ok()) return undone.error();
        m_seen_version = before;
        if (const Status s = follow(); !s.ok()) return s.error();
        return about("push", ErrorCode::InvalidArgument,
                     "expected a push that leaves the eye free");
    }
    measure();
    return done;
}

std::uint64_t Scope::hash() const {
    Hash64 hash;
    const EndoscopePose& p = m_state.pose;
    const Vec3d numbers[] = {p.eye_mm,
                             p.look,
                             p.up,
                             m_state.force_n,
                             {m_state.max_displacement_mm, double(m_state.steps), 0}};
    hash.add(std::span<const Vec3d>(numbers));
    if (m_tissue) hash.add_word(m_tissue->hash());
    return hash.value();
}

Status Scope::save(std::vector<std::byte>& bytes) const {
    Head head;
    const EndoscopePose& p = m_state.pose;
    head.steps = m_state.steps;
    head.eye = p.eye_mm, head.look = p.look, head.up = p.up, head.force = m_state.force_n;
    head.max_displacement = m_state.max_displacement_mm;
    head.flags = (m_state.is_touching ? 1U : 0U) | (m_state.is_stopped ? 2U : 0U);
    std::vector<std::byte> tissue;
    if (m_tissue) {
        const TemporaryFile file;
        if (!file.is_there())
            return Error{ErrorCode::Unwritable, "expected a folder for temporary files"};
        if (const Status s = m_tissue->save_state(file.path()); !s.ok()) return s;
        const auto read = read_small_file(file.path(), std::string::npos, "a saved state");
        if (!read.ok()) return read.error();
        const auto state = std::as_bytes(std::span(*read));
        tissue.assign(state.begin(), state.end());
    }
    head.tissue_bytes = tissue.size();
    bytes.resize(sizeof(Head));
    std::memcpy(bytes.data(), &head, sizeof(Head));
    bytes.insert(bytes.end(), tissue.begin(), tissue.end());
    return Ok{};
}

Status Scope::load(std::span<const std::byte> bytes) {
    Head head;
    const Error damaged{ErrorCode::Unreadable, "state: expected the bytes of save_state"};
    if (bytes.size() < sizeof(Head)) return damaged;
    std::memcpy(&head, bytes.data(), sizeof(Head));
    const bool has_tissue = head.tissue_bytes > 0;
    if (head.kind != kStateKind || head.tissue_bytes != bytes.size() - sizeof(Head) ||
        has_tissue != (m_tissue != nullptr) || !is_finite(head.eye) || !is_finite(head.look) ||
        !is_finite(head.up) || !(norm(head.look) > 0))
        return damaged;
    if (m_tissue) {
        const TemporaryFile file;
        if (!file.is_there())
            return Error{ErrorCode::Unwritable, "expected a folder for temporary files"};
        OutputFile state(file.path(), "a temporary file");
        state.write({reinterpret_cast<const char*>(bytes.data() + sizeof(Head)),
                     std::size_t(head.tissue_bytes)});
        if (const Status s = state.close(); !s.ok()) return s;
        if (const Status s = m_tissue->load_state(file.path()); !s.ok()) return s;
        m_seen_version = ~std::uint64_t(0);
    }
    m_state.pose = {head.eye, head.look, head.up};
    m_state.force_n = head.force;
    m_state.max_displacement_mm = head.max_displacement;
    m_state.is_touching = (head.flags & 1) != 0;
    m_state.is_stopped = (head.flags & 2) != 0;
    m_state.steps = head.steps;
    return follow();
}

}  // namespace pliant
