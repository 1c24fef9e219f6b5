// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The server's text messages as JSON.

#include <pliant/core/version.h>
#include <pliant/scan_files.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "protocol/commands.h"
#include "protocol/haptic_status.h"
#include "protocol/messages.h"
#include "protocol/record_json.h"
#include "protocol/wire_rows.h"

namespace pliant::serve {
namespace {

std::string text_of_json(const Json& json) {
    // File names need not be UTF-8.
    return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

Json json_of(const ClientInfo& client) {
    return {{"client", client.number},
            {"name", client.name},
            {"role", client.view ? "view" : "control"}};
}

Json json_of(const ValueDefaults& v) {
    return {{"kind", name_of(v.kind)},
            {"unit", v.kind == ValueKind::Hounsfield ? "HU" : ""},
            {"reason", v.reason},
            {"window", v.window},
            {"level", v.level},
            {"blended_window", v.blended_window},
            {"blended_level", v.blended_level},
            {"iso", v.iso},
            {"polarity", v.lumen_is_bright ? "falling" : "rising"},
            {"background", v.background}};
}

Json json_of(const VolumeInfo& v) {
    const auto& axes = v.grid.direction.columns;
    Json json = {{"id", v.id},
                 {"name", v.name},
                 {"size", json_of(v.grid.size)},
                 {"spacing_mm", json_of(v.grid.spacing_mm)},
                 {"origin_mm", json_of(v.grid.origin_mm)},
                 {"direction", {json_of(axes[0]), json_of(axes[1]), json_of(axes[2])}},
                 {"range_hu", {v.lowest_hu, v.highest_hu}},
                 {"values", json_of(v.values)},
                 {"length_scale", length_scale(v.grid)},
                 {"start", nullptr},
                 {"landmarks", Json::array()}};
    if (v.start)
        json["start"] = {{"eye_mm", json_of(v.start->eye_mm)},
                         {"look", json_of(v.start->look)},
                         {"up", json_of(v.start->up)},
                         {"outside", v.starts_outside}};
    if (v.tool_mm) json["tool_mm"] = *v.tool_mm;
    for (const PhantomLandmark& mark : v.landmarks)
        json["landmarks"].push_back({{"name", mark.name},
                                     {"point_mm", json_of(mark.push_point_mm)},
                                     {"push_mm", json_of(mark.push_mm)},
                                     {"eye_mm", json_of(mark.eye_mm)},
                                     {"look", json_of(mark.look)}});
    return json;
}

/// Rounds to the displayed precision, so that vibrations below it cause no new state.
double rounded(double value, double parts) {
    return std::round(value * parts) / parts;
}

/// Commands that a tissue takes.
Json json_of(const TissueTraits& traits) {
    Json takes = Json::array();
    if (traits.takes_pushes) takes.push_back("push");
    if (traits.slides) takes.push_back("slide");
    if (traits.cuts) takes.push_back("cut");
    if (traits.carves) takes.push_back("carve");
    return takes;
}

/// Lists are counts along three axes.
Json json_of_figure(const SettingValue& value) {
    if (const auto* counts = std::get_if<std::vector<double>>(&value))
        return std::vector<std::int64_t>(counts->begin(), counts->end());
    return json_of_value(value);
}

Json json_of(const VesselState& v, double pace) {
    const CatheterMeasures& m = v.measures;
    return {{"insert_mm_s", v.hand.insert_mm_s},
            {"rotate_deg_s", v.hand.rotate_deg_s},
            {"bend_first_deg", v.hand.bend_first_deg},
            {"bend_second_deg", v.hand.bend_second_deg},
            {"inserted_mm", rounded(m.inserted_mm, 1e3)},
            {"rotated_deg", rounded(m.rotated_deg, 1e3)},
            {"force_n", rounded(m.force_n, 1e5)},
            {"torque_n_mm", rounded(m.torque_n_mm, 1e5)},
            {"contact_n", rounded(m.contact_n, 1e5)},
            {"depth_mm", rounded(m.depth_mm, 1e4)},
            {"wall_moved_mm", rounded(m.wall_moved_mm, 1e4)},
            {"time_s", rounded(m.time_s, 1e3)},
            {"pace", rounded(pace, 1e3)},
            {"sub_steps", m.sub_steps},
            {"radius_mm", v.radius_mm},
            {"length_mm", v.length_mm},
            {"warnings", warnings_of(m)},
            {"failure", v.failure}};
}

Json json_of(const SharedState& s) {
    Json json = {{"step", s.step},
                 {"iso_hu", s.iso_hu},
                 {"polarity", s.polarity == Polarity::Rising ? "rising" : "falling"},
                 {"materials", Json::object()},
                 {"relaxing", s.relaxing},
                 {"settled", s.settled},
                 {"holder", s.holder},
                 {"undo", {{"steps", s.undo_steps}, {"next", s.next_undo}}},
                 {"redo", {{"steps", s.redo_steps}, {"next", s.next_redo}}},
                 {"clients", Json::array()},
                 {"recorded", s.recorded},
                 {"timing",
                  {{"solve_ms", s.solve_ms},
                   {"resample_ms", s.resample_ms},
                   {"tick_ms", s.tick_ms},
                   {"overlay_ms", s.overlay_ms},
                   {"moved_elements", s.moved_elements}}}};
    put(json["materials"], s.materials, chainmail_material_rows());
    const TissueChoice& t = s.tissue;
    Json& tissue = json["tissue"] = {{"model", t.model}};
    tissue["takes"] = json_of(s.traits);
    for (const std::string& model : s.own_models) tissue["has_" + model] = true;
    if (!s.trouble.empty()) tissue["trouble"] = s.trouble;
    if (s.vessel) json["vessel"] = json_of(*s.vessel, s.pace);
    if (t.is_springs()) {
        put(tissue, t.springs, spring_rows());
        tissue["depth_by_time"] = t.depth_by_time;
        if (s.line_mb_s > 0) tissue["line_mb_s"] = s.line_mb_s;
        tissue["centre"] = json_of(t.centre_mm);
    }
    if (t.is_elastic()) put(tissue, s.elastic, elastic_scan_rows());
    for (const NamedValue& figure : s.figures) tissue[figure.name] = json_of_figure(figure.value);
    if (!s.figures.empty()) tissue["update_hz"] = s.update_hz;
    for (const ClientInfo& client : s.clients) json["clients"].push_back(json_of(client));
    return json;
}

double in_steps(double value, double per_unit) {
    return std::round(value * per_unit) / per_unit;
}

/// Rounds to micrometres or micronewtons: few digits.
nlohmann::json short_vector(Vec3d v, double per_unit) {
    return {in_steps(v.x, per_unit), in_steps(v.y, per_unit), in_steps(v.z, per_unit)};
}

}  // namespace

std::string hex_text(std::uint64_t number, int digits) {
    std::string text(std::size_t(digits), '0');
    for (int n = digits - 1; n >= 0; --n, number >>= 4)
        text[std::size_t(n)] = "0123456789abcdef"[number & 15];
    return text;
}

std::string welcome_text(const Welcome& welcome, const VolumeInfo& volume,
                         const SharedState& state) {
    const Json features = welcome.is_watched
                              ? Json{"save",  "overlay", "path",   "vessel", "rest",
                                     "state", "labels",  "follow", "replay"}
                              : Json{"save",   "open", "overlay", "path",   "tissue", "haptics",
                                     "vessel", "rest", "state",   "labels", "marks",  "follow"};
    Json json = json_of(welcome.client);
    json.update({{"t", "welcome"},
                 {"protocol", kProtocolVersion},
                 {"program", "pliant " PLIANT_VERSION},
                 {"resume", welcome.resume},
                 {"resumed", welcome.resumed},
                 {"rate_hz", welcome.rate_hz},
                 {"features", features},
                 {"haptic_devices", welcome.haptic_devices},
                 {"open_bytes", welcome.open_bytes},
                 {"spring_nodes", welcome.spring_nodes},
                 {"volume", json_of(volume)},
                 {"state", json_of(state)}});
    return text_of_json(json);
}

std::string volume_text(const VolumeInfo& volume) {
    Json json = json_of(volume);
    json["t"] = "volume";
    return text_of_json(json);
}

std::string state_text(const SharedState& state) {
    Json json = json_of(state);
    json["t"] = "state";
    return text_of_json(json);
}

std::string outcome_text(std::uint32_t id, std::string_view name, std::uint32_t step,
                         const Outcome& outcome) {
    Json json = {{"t", outcome.ok() ? "done" : "error"}, {"id", id}, {"do", name}};
    if (!outcome.message.empty()) json["message"] = outcome.message;
    if (!outcome.ok()) {
        json["code"] = outcome.error_code;
        return text_of_json(json);
    }
    json["step"] = step;
    if (outcome.status) {
        json["status"] = name_of(*outcome.status);
        json["limited_by"] = name_of(outcome.limited_by);
        json["step_fraction"] = outcome.step_fraction;
    }
    const auto put = [&](const char* key, const std::optional<std::int64_t>& number) {
        if (number) json[key] = *number;
    };
    put("grabbed_elements", outcome.grabbed_elements);
    put("moved_elements", outcome.moved_elements);
    put("cut_links", outcome.cut_links);
    put("carved_elements", outcome.carved_elements);
    if (outcome.bone_mm) json["bone"] = json_of(*outcome.bone_mm);
    json["solve_ms"] = outcome.solve_ms;
    if (outcome.force_n) json["force_n"] = json_of(*outcome.force_n);
    if (outcome.end_mm) json["end"] = json_of(*outcome.end_mm);
    if (!outcome.whose.empty()) json["whose"] = outcome.whose;
    return text_of_json(json);
}

std::string checksum_text(std::uint32_t id, const Checksums& sums) {
    return text_of_json({{"t", "checksum"},
                         {"id", id},
                         {"step", sums.step},
                         {"voxels", hex_text(sums.voxels, 8)},
                         {"volume", hex_text(sums.volume, 16)},
                         {"tissue", hex_text(sums.tissue, 16)}});
}

std::string camera_text(std::uint32_t client, const CameraMessage& camera) {
    Json text = {{"t", "camera"}, {"client", client}};
    if (camera.pose) {
        text["eye"] = json_of(camera.pose->eye_mm);
        text["look"] = json_of(camera.pose->look);
        text["up"] = json_of(camera.pose->up);
    }
    return text_of_json(text);
}

std::string replay_text(const ReplayState& state) {
    Json text = {{"t", "replay"},
                 {"at_ms", std::round(state.at_ms)},
                 {"length_ms", std::round(state.length_ms)},
                 {"speed", state.speed},
                 {"playing", state.is_playing},
                 {"seeking", state.is_seeking}};
    if (!state.failure.empty()) text["failure"] = state.failure;
    return text_of_json(text);
}

std::string replay_marks_text(std::span<const TimelineMark> marks) {
    Json list = Json::array();
    for (const TimelineMark& mark : marks)
        list.push_back(
            {{"at_ms", std::round(mark.at_ms)}, {"client", mark.client}, {"do", mark.name}});
    return text_of_json({{"t", "replay_marks"}, {"marks", list}});
}

std::string path_text(std::uint32_t id, std::uint32_t step, std::uint32_t volume,
                      const LumenPath& path) {
    // Micrometres: few digits.
    const auto short_number = [](double mm) { return std::round(mm * 1e3) / 1e3; };
    Json points = Json::array(), radii = Json::array();
    for (const Vec3d& p : path.points_mm)
        points.push_back({short_number(p.x), short_number(p.y), short_number(p.z)});
    for (const double r : path.radius_mm) radii.push_back(short_number(r));
    return text_of_json({{"t", "path"},
                         {"id", id},
                         {"step", step},
                         {"volume", volume},
                         {"length_mm", short_number(path.length_mm)},
                         {"points", points},
                         {"radii", radii}});
}

std::string labels_text(std::uint32_t volume, const std::string& name,
                        std::span<const LabelInfo> labels) {
    Json list = Json::array();
    for (const LabelInfo& label : labels) {
        Json one = {{"value", label.value},
                    {"name", label.name},
                    {"voxels", label.voxels},
                    {"centre_mm", json_of(label.centre_mm)}};
        if (label.colour) one["colour"] = *label.colour;
        if (label.body > 0) one["body"] = label.body;
        if (!label.is_shown) one["shown"] = false;
        list.push_back(std::move(one));
    }
    return text_of_json({{"t", "labels"}, {"volume", volume}, {"name", name}, {"labels", list}});
}

std::string series_text(std::span<const DicomSeries> list) {
    Json series = Json::array();
    for (const DicomSeries& one : list) {
        series.push_back({{"number", one.number},
                          {"description", one.description},
                          {"modality", one.modality},
                          {"slices", one.slices},
                          {"volumes", one.volumes},
                          {"size", json_of(one.size)},
                          {"spacing_mm", json_of(one.spacing_mm)},
                          {"uid", one.uid}});
        if (!one.fault.empty()) series.back()["fault"] = one.fault;
    }
    return text_of_json({{"series", series}});
}

std::string frames_text(std::int64_t count) {
    return text_of_json({{"frames", count}});
}

std::string pong_text(std::uint32_t id) {
    return text_of_json({{"t", "pong"}, {"id", id}});
}

std::string bye_text(int code, const std::string& message) {
    return text_of_json({{"t", "bye"}, {"code", code}, {"message", message}});
}

// State of a force-feedback device as JSON.

std::string haptics_text(const HapticStatus& s) {
    nlohmann::json json = {{"t", "haptics"}, {"on", s.on}};
    if (!s.why.empty()) json["why"] = s.why;
    if (s.on && s.holds_catheter) json["holds"] = "catheter";
    if (s.on)
        json.update({{"client", s.client},
                     {"tool", s.tool},
                     {"device", s.device},
                     {"scale", s.scale},
                     {"stopped", s.stopped},
                     {"contact", s.contact},
                     {"lost", s.lost},
                     {"place_mm", short_vector(s.position_mm, 1e3)},
                     {"proxy_mm", short_vector(s.proxy_mm, 1e3)},
                     {"force_n", short_vector(s.force_n, 1e6)},
                     {"largest_n", in_steps(s.largest_n, 1e6)},
                     {"depth_mm", in_steps(s.depth_mm, 1e3)},
                     {"largest_force_n", s.largest_force_n},
                     {"servo",
                      {{"rate_hz", s.servo.rate_hz},
                       {"period_p99_us", s.servo.period_p99_us},
                       {"period_max_us", s.servo.period_max_us},
                       {"misses_per_million", s.servo.misses_per_million},
                       {"compute_p99_us", s.servo.compute_p99_us},
                       {"age_ms", s.servo.age_ms}}},
                     {"note", s.note}});
    return json.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

}  // namespace pliant::serve
