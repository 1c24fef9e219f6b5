// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "hub/haptic_session.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <numbers>
#include <utility>

#include "haptics/pace.h"
#include "protocol/limits.h"

namespace pliant::serve {
namespace {

constexpr std::array<const char*, 4> kVirtual = {"virtual:tap", "virtual:spring", "virtual:active",
                                                 "virtual:free"};
constexpr const char* kBrowser = "browser";
constexpr const char* kSpaceMouse = "spacemouse";
constexpr std::size_t kWindow = 4096;  ///< periods in the statistics
constexpr std::chrono::milliseconds kMeasure{250};
constexpr std::chrono::milliseconds kEnd{200};  ///< twice the ramp of the servo
constexpr double kRadians = std::numbers::pi / 180;
constexpr double kStill_mm = 0.02;  ///< shorter ways cause no command

/// File name only; server paths are not sent to clients.
std::string name_of_given(const std::string& given) {
    const auto last_of = [](const std::string& path) {
        return std::filesystem::path(path).filename().string();
    };
    const auto colon = given.find(':');
    if (colon == std::string::npos) return last_of(given);
    return last_of(given.substr(0, colon)) + ":" + last_of(given.substr(colon + 1));
}

/// Frame of a device: x to the right, y up, z towards the user.
Mat3d frame_of(Vec3d look, Vec3d up) {
    const Vec3d back = -1.0 * normalized(look);
    Vec3d right = cross(up, back);
    if (norm(right) < 1e-6) right = cross(Vec3d{0.3, 0.5, 0.8}, back);
    right = normalized(right);
    return {{right, cross(back, right), back}};
}

double percentile_us(std::vector<std::int64_t> values, double share) {
    if (values.empty()) return 0;
    const auto at = values.begin() + std::ptrdiff_t(share * double(values.size() - 1));
    std::nth_element(values.begin(), at, values.end());
    return 1e-3 * double(*at);
}

bool same_materials(const ChainMailSettings& a, const ChainMailSettings& b) {
    return a.offset == b.offset && a.max_movement_mm == b.max_movement_mm &&
           a.bone_threshold_hu == b.bone_threshold_hu &&
           a.smallest_bone_mm3 == b.smallest_bone_mm3 && a.air_threshold_hu == b.air_threshold_hu &&
           a.air_enabled == b.air_enabled && a.yield == b.yield && a.limits == b.limits;
}

constexpr double kCoupling_n_m = 300;  ///< at the device
// Smaller changes of speed cause no command.
constexpr double kSame_mm_s = 0.2, kSame_deg_s = 1;

/// Rounds to hundredths, for short records.
double in_hundredths(double value) {
    return std::round(100 * value) / 100;
}
bool differs(double a, double b, double same) {
    return (a == 0) != (b == 0) || std::abs(a - b) > same;
}

}  // namespace

std::vector<std::string> HapticDevices::names() const {
    std::vector<std::string> names(kVirtual.begin(), kVirtual.end());
    names.push_back(kBrowser);
    names.push_back(kSpaceMouse);
    for (const std::string& given : m_given) names.push_back(name_of_given(given));
    return names;
}

Result<OpenedDevice> HapticDevices::open(const std::string& name) const {
    const auto opened = [](Result<std::unique_ptr<HapticDevice>> device) -> Result<OpenedDevice> {
        if (!device.ok()) return device.error();
        return OpenedDevice{std::move(*device), nullptr};
    };
    if (name == kSpaceMouse || std::find(kVirtual.begin(), kVirtual.end(), name) != kVirtual.end())
        return opened(open_haptic_device(name));
    if (name == kBrowser) {
        auto positions = std::make_shared<PosedPositions>();
        return OpenedDevice{make_posed_device(positions), positions};
    }
    for (const std::string& given : m_given)
        if (name == name_of_given(given)) return opened(open_haptic_device(given));
    std::string expected;
    for (const std::string& known : names()) expected += (expected.empty() ? "" : ", ") + known;
    return Error{ErrorCode::InvalidArgument, "device: expected " + expected + ", found '" + name +
                                                 "'; others are named by pliant serve --haptics"};
}

Result<std::unique_ptr<HapticSession>> HapticSession::start(const HapticsMessage& wish,
                                                            OpenedDevice opened, Scene& scene,
                                                            std::uint32_t client,
                                                            std::uint32_t tool) {
    auto session = std::unique_ptr<HapticSession>(new HapticSession);
    session->m_client = client;
    session->m_tool = tool;
    session->m_wish = wish;
    session->m_device = wish.device;
    session->m_positions = std::move(opened.positions);
    const HapticLimits limits = opened.device->limits();
    session->m_largest_force_n = limits.max_force_n;
    HapticWorkspace workspace{.rotation = frame_of(wish.look, wish.up),
                              .scale = wish.scale,
                              .origin_mm = wish.position_mm};
    if (const Drivable* const catheter = scene.tissue().drivable()) {
        auto grip = CatheterGrip::create(*catheter, tool, wish.scale);
        if (!grip.ok()) return grip.error();
        session->m_grip.emplace(std::move(*grip));
        // Forward is into the vessel, for every viewing direction.
        workspace.rotation = frame_of(catheter->entry().direction, wish.up);
        workspace.origin_mm = catheter->entry().position_mm;
    } else {
        auto feel = session->make_feel(scene);
        if (!feel.ok()) return feel.error();
        session->m_feel = std::move(*feel);
        SharedState state;
        scene.describe(state);
        session->m_materials = state.materials;
    }
    HapticServoSettings settings;
    settings.step.max_force_n = limits.max_force_n;
    settings.step.max_stiffness_n_m = limits.max_stiffness_n_m;
    settings.step.workspace = workspace;
    auto servo = HapticServo::start(std::move(opened.device), settings);
    if (!servo.ok()) return servo.error();
    session->m_servo = std::move(*servo);
    session->m_records.resize(1024);
    return session;
}

Result<std::unique_ptr<LiveFeel>> HapticSession::make_feel(Scene& scene) const {
    SharedState state;
    scene.describe(state);
    ChainMailFeelSettings settings;
    settings.tool_radius_mm = m_wish.radius_mm;
    settings.iso_hu = state.iso_hu;
    settings.polarity = state.polarity;
    return LiveFeel::create(scene.loaded()->volume, scene.deformed(), state.materials, settings,
                            m_tool, scene.tissue().arena());
}

/// Reads the servo's records since the last call.
void HapticSession::read_records() {
    std::uint64_t lost = 0;
    for (;;) {
        const std::size_t count = m_servo->read(m_next_record, m_records, lost);
        for (std::size_t n = 0; n < count; ++n) {
            const HapticRecord& r = m_records[n];
            m_now = r;
            m_has_position = m_has_position || !(r.flags & kHapticDeviceLost);
            m_largest_n = std::max(m_largest_n, norm(r.force_n));
            m_age_ms = std::max(m_age_ms, 1e-6 * double(r.age_ns));
            if (r.period == 0) continue;
            if (m_periods_ns.size() < kWindow) {
                m_periods_ns.push_back(r.period_ns);
                m_computes_ns.push_back(r.compute_ns);
            } else {
                m_periods_ns[m_at] = r.period_ns;
                m_computes_ns[m_at] = r.compute_ns;
                m_at = (m_at + 1) % kWindow;
            }
        }
        if (count < m_records.size()) return;
    }
}

std::optional<Action> HapticSession::next_push(Scene& scene) {
    read_records();
    if (is_ending() || !m_has_position) return {};
    const bool is_free = m_is_stopped || (m_now.flags & kHapticDeviceLost);
    return m_grip ? m_grip->next(m_now, is_free, scene) : next_push_of(scene, is_free);
}

/// Next push of a scan's tissue.
std::optional<Action> HapticSession::next_push_of(Scene& scene, bool is_free) {
    const bool touches = !is_free && m_feel->follow(m_now.position_mm, m_now.proxy_mm);
    if (!touches) {
        m_pushed_mm = m_now.position_mm;
        m_pushes = false;
        if (scene.has_contact(m_tool)) return ReleaseCommand{};
        return {};
    }
    const bool slides = scene.tissue().traits().slides;
    if (!m_pushes) {
        m_pushes = true;
        m_is_refused = false;
        ++m_stroke;
        m_pushed_mm = m_tried_mm = m_feel->contact().entry_mm;
    }
    const Vec3d to = m_now.position_mm;
    if (m_is_refused) return {};
    if (norm(to - m_tried_mm) < kStill_mm || norm(to - m_pushed_mm) < kStill_mm) return {};
    SharedState state;
    scene.describe(state);
    m_tried_mm = to;
    m_way_mm = to - m_pushed_mm;
    const double scale = scene.choice().model == "chainmail" ? state.materials.scale : 1;
    return PushCommand{.push = {.point_mm = m_pushed_mm,
                                .push_mm = (1 / scale) * m_way_mm,
                                .sphere_radius_mm = m_wish.radius_mm},
                       .slide = slides,
                       .stroke = m_stroke};
}

void HapticSession::pushed(const Outcome& outcome) {
    if (outcome.end_mm)
        m_pushed_mm = *outcome.end_mm;
    else if (outcome.status)
        m_pushed_mm = m_pushed_mm + outcome.step_fraction * m_way_mm;
    m_is_refused = m_is_refused || !outcome.ok();
}

void HapticSession::changed(std::span<const Box3i> boxes) {
    if (m_feel) m_feel->changed(boxes);
}

void HapticSession::feel(Scene& scene) {
    if (is_ending() || !m_has_position || m_is_stopped) return;
    const auto found = model_of(scene);
    if (!found) return;  // the servo then ramps the force down by itself
    const auto model = checked_model(*found, m_servo->largest_stiffness_n_m());
    if (!model.ok()) return;
    HapticModel numbered = *model;
    numbered.number = ++m_models;
    m_servo->post(numbered);
}

std::optional<HapticModel> HapticSession::model_of(Scene& scene) {
    if (m_grip) return m_grip->model(m_now, *scene.tissue().drivable());
    SharedState state;
    scene.describe(state);
    m_feel->set_wall(state.iso_hu, state.polarity);
    if (!m_pushes && !same_materials(state.materials, m_materials)) {
        auto feel = make_feel(scene);
        if (!feel.ok()) return {};
        m_feel = std::move(*feel);
        m_materials = state.materials;
        m_feel->follow(m_now.position_mm, m_now.proxy_mm);
    }
    return m_feel->model(scene.tissue(), m_pushed_mm);
}

void HapticSession::pose(const HapticPoseMessage& pose) {
    if (m_positions)
        m_positions->write({steady_now_ns(), pose.position_mm, pose.roll_deg * kRadians, 0});
}

void HapticSession::set_stop(bool stop) {
    m_is_stopped = stop;
    m_servo->set_stop(stop);
}

void HapticSession::end(Clock::time_point now) {
    if (is_ending()) return;
    set_stop(true);
    m_is_ending = true;
    m_feel.reset();
    m_over_at = now + kEnd;
}

void HapticSession::measure() {
    const auto now = Clock::now();
    if (now - m_measured_at < kMeasure) return;
    m_measured_at = now;
    double sum_us = 0, misses = 0;
    for (const std::int64_t period : m_periods_ns) {
        sum_us += 1e-3 * double(period);
        misses += period > 1'500'000;
    }
    const double count = std::max(1.0, double(m_periods_ns.size()));
    m_statistics = {.rate_hz = sum_us > 0 ? std::round(1e6 * count / sum_us) : 0,
                    .period_p99_us = std::round(percentile_us(m_periods_ns, 0.99)),
                    .period_max_us = std::round(percentile_us(m_periods_ns, 1)),
                    .misses_per_million = std::round(1e6 * misses / count),
                    .compute_p99_us = std::round(10 * percentile_us(m_computes_ns, 0.99)) / 10,
                    .age_ms = std::round(10 * std::exchange(m_age_ms, 0)) / 10};
}

HapticStatus HapticSession::state(const Scene& scene) {
    measure();
    HapticStatus state{.on = true,
                       .client = m_client,
                       .tool = m_tool,
                       .device = m_device,
                       .scale = m_wish.scale,
                       .stopped = m_is_stopped,
                       .contact = (m_now.flags & kHapticContact) != 0,
                       .lost = (m_now.flags & kHapticDeviceLost) != 0,
                       .position_mm = m_now.position_mm,
                       .proxy_mm = m_now.proxy_mm,
                       .force_n = m_now.force_n,
                       .largest_n = std::exchange(m_largest_n, 0),
                       .largest_force_n = m_largest_force_n,
                       .servo = m_statistics,
                       .note = m_servo->note()};
    state.holds_catheter = m_grip.has_value();
    if (m_grip && !is_ending() && suits(scene))
        state.depth_mm = m_grip->ahead_mm(m_now, *scene.tissue().drivable());
    if (m_feel && m_feel->touches()) state.depth_mm = m_feel->contact().depth_mm;
    return state;
}

ToolPose HapticSession::pose_of_tool() const {
    const auto floats = [](Vec3d v) { return Vec3f{float(v.x), float(v.y), float(v.z)}; };
    return {.client = m_tool,
            // A catheter has its own picture.
            .kind = m_has_position && !m_grip ? ToolKind::Sphere : ToolKind::None,
            .touches = (m_now.flags & kHapticContact) != 0,
            .position_mm = floats(m_now.position_mm),
            .direction = floats(m_wish.look),
            .up = floats(m_wish.up),
            .radius_mm = float(m_wish.radius_mm),
            .force_n = floats(m_now.force_n)};
}

Result<CatheterGrip> CatheterGrip::create(const Drivable& catheter, std::uint32_t tool,
                                          double scale) {
    auto feel = CatheterFeel::create({.forward = normalized(catheter.entry().direction),
                                      .coupling_n_m = kCoupling_n_m / scale,
                                      .length_mm = catheter.length_mm(),
                                      .max_mm_s = kMaxInsert_mm_s,
                                      .max_deg_s = kMaxRotate_deg_s});
    if (!feel.ok()) return feel.error();
    return CatheterGrip(std::move(*feel), tool);
}

std::optional<Action> CatheterGrip::next(const HapticRecord& now, bool lets_go,
                                         const Scene& scene) {
    const Drivable& catheter = *scene.tissue().drivable();
    if (lets_go || (now.buttons & 1) || !catheter.failure().empty()) {
        m_feel.let_go();
        if (scene.has_contact(m_tool)) return ReleaseCommand{};
        return {};
    }
    const CatheterMeasures measures = catheter.measures();
    // After a reset the wire's position has changed, so the hand takes a new hold.
    if (!m_feel.holds() || measures.time_s < m_time_s)
        m_feel.take_hold(now.position_mm, now.roll_rad, measures);
    m_time_s = measures.time_s;
    m_turns = m_turns || now.roll_rad != 0;
    const CatheterCommand hand = catheter.hand();
    const CatheterFeel::Motion motion = m_feel.follow(now.position_mm, now.roll_rad, measures);
    const double insert = in_hundredths(motion.insert_mm_s);
    const double rotate = in_hundredths(motion.rotate_deg_s);
    DriveCommand drive;
    if (differs(insert, hand.insert_mm_s, kSame_mm_s)) drive.insert_mm_s = insert;
    // Without a device that measures rotation, the keys rotate the wire.
    if (m_turns && differs(rotate, hand.rotate_deg_s, kSame_deg_s)) drive.rotate_deg_s = rotate;
    if (!drive.insert_mm_s && !drive.rotate_deg_s) return {};
    return drive;
}

std::optional<HapticModel> CatheterGrip::model(const HapticRecord& now,
                                               const Drivable& catheter) const {
    if (!catheter.failure().empty()) return {};
    return m_feel.model(now.position_mm, catheter.measures());
}

double CatheterGrip::ahead_mm(const HapticRecord& now, const Drivable& catheter) const {
    return m_feel.holds() ? m_feel.ahead_mm(now.position_mm, catheter.measures()) : 0;
}

}  // namespace pliant::serve
