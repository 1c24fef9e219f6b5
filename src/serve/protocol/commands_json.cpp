// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Clients' messages from and to JSON. The type of every field is checked before its use (a wrong
// type is rubbish), then its range.

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

#include "protocol/commands.h"
#include "protocol/limits.h"
#include "protocol/record_json.h"
#include "protocol/wire_rows.h"

namespace pliant::serve {
namespace {

constexpr int kMaxNesting = 4;
constexpr std::size_t kMaxLinePoints = 1000;
constexpr double kMaxPositionMm = 1e5;

/// @returns whether brackets are nested too deep; checks nothing else
bool is_too_deep(std::string_view text) {
    int depth = 0;
    bool in_string = false;
    for (std::size_t n = 0; n < text.size(); ++n) {
        const char c = text[n];
        if (in_string) {
            if (c == '\\') ++n;
            if (c == '"') in_string = false;
        } else if (c == '"') {
            in_string = true;
        } else if (c == '{' || c == '[') {
            if (++depth > kMaxNesting) return true;
        } else if (c == '}' || c == ']') {
            --depth;
        }
    }
    return false;
}

std::string short_text(const Json& value) {
    std::string text = value.dump(-1, ' ', true, Json::error_handler_t::replace);
    if (text.size() > 40) text = text.substr(0, 37) + "...";
    return text;
}

/// The fields of one message. Keeps the first failure; values read after it are meaningless.
class Fields {
  public:
    Fields(const Json& object, std::string name) : m_object(object), m_name(std::move(name)) {}

    const std::optional<ParseFailure>& failure() const { return m_failure; }
    const Json& object() const { return m_object; }
    bool has(const char* key) {
        know(key);
        return m_object.contains(key);
    }

    double number(const char* key, double low, double high, std::optional<double> missing = {}) {
        const Json* value = find(key, missing.has_value());
        if (!value) return missing.value_or(0);
        if (!value->is_number()) return wrong_type(key, "a number", *value), 0;
        const double number = value->get<double>();
        if (!std::isfinite(number)) return wrong_type(key, "a finite number", *value), 0;
        if (!(number >= low && number <= high))
            out_of_range(key, short_text(Json(low)) + "…" + short_text(Json(high)), *value);
        return number;
    }
    std::uint32_t whole(const char* key, std::uint32_t low, std::optional<std::uint32_t> missing) {
        const Json* value = find(key, missing.has_value());
        if (!value) return missing.value_or(0);
        if (!value->is_number_unsigned() || value->get<std::uint64_t>() > 0xffffffffU)
            return wrong_type(key, "a whole number 0…4294967295", *value), 0;
        const auto number = value->get<std::uint32_t>();
        if (number < low) out_of_range(key, std::to_string(low) + " or more", *value);
        return number;
    }
    bool flag(const char* key, std::optional<bool> missing) {
        const Json* value = find(key, missing.has_value());
        if (!value) return missing.value_or(false);
        if (!value->is_boolean()) return wrong_type(key, "true or false", *value), false;
        return value->get<bool>();
    }
    std::string text(const char* key, std::size_t max_size, std::optional<std::string> missing) {
        const Json* value = find(key, missing.has_value());
        if (!value) return missing.value_or("");
        if (!value->is_string()) return wrong_type(key, "a text", *value), "";
        auto text = value->get<std::string>();
        if (text.size() > max_size)
            wrong_type(key, "a text of up to " + std::to_string(max_size) + " bytes", *value);
        return text;
    }
    Vec3d vector(const char* key, double longest, std::optional<Vec3d> missing = {}) {
        const Json* value = find(key, missing.has_value());
        if (!value) return missing.value_or(Vec3d{0, 0, 0});
        return vector_of(key, *value, longest);
    }
    Vec3d direction(const char* key) {
        const Vec3d v = vector(key, kMaxPositionMm);
        if (!m_failure && !(norm(v) > 1e-6)) out_of_range(key, "a direction", m_object[key]);
        return v;
    }
    std::vector<Vec3d> line(const char* key, std::size_t least = 2,
                            std::size_t most = kMaxLinePoints) {
        std::vector<Vec3d> points;
        const Json* value = find(key, false);
        if (!value) return points;
        if (!value->is_array()) return wrong_type(key, "a list of points", *value), points;
        if (value->size() < least || value->size() > most)
            return out_of_range(key, std::to_string(least) + "…" + std::to_string(most) + " points",
                                *value),
                   points;
        for (const Json& point : *value) points.push_back(vector_of(key, point, kMaxPositionMm));
        return points;
    }
    /// @returns index of the text in the list
    std::size_t choice(const char* key, std::initializer_list<const char*> names) {
        const std::string found = text(key, 40, {});
        std::string expected;
        for (std::size_t n = 0; n < names.size(); ++n) {
            if (found == names.begin()[n]) return n;
            expected += std::string(n ? ", " : "") + names.begin()[n];
        }
        if (!m_failure) wrong_type(key, expected, Json(found));
        return 0;
    }
    /// Reads and checks the value of a setting; nullopt if absent.
    std::optional<SettingValue> setting(const SettingInfo& row) {
        know(std::string(row.name));
        const auto found = m_object.find(std::string(row.name));
        if (found == m_object.end()) return {};
        auto value = value_of_kind(row, value_of_json(*found));
        const Status range = value ? check_range(row, *value) : Status(Ok{});
        const std::string key(row.name);
        if (!value)
            wrong_type(key.c_str(), value.error().expected, *found);
        else if (!range)
            out_of_range(key.c_str(), range.error().expected, *found);
        if (m_failure) return {};
        return std::move(*value);
    }
    void require(const char* key) { find(key, false); }
    template <class T>
    void settings(SettingRows<T> rows, T& object) {
        for (const Setting<T>& row : rows)
            if (const auto value = setting(row)) row.set(object, *value);
    }
    /// The settings that are given, by name.
    template <class T>
    Record record(SettingRows<T> rows) {
        Record record;
        for (const Setting<T>& row : rows)
            if (auto value = setting(row))
                record.emplace_back(std::string(row.name), shown_value(row, std::move(*value)));
        return record;
    }
    void refuse(const std::string& message) { fail(false, message); }
    /// Declares fields that are allowed and have no effect.
    void allow(std::initializer_list<const char*> keys) {
        for (const char* key : keys) know(key);
    }
    template <class T>
    void allow(SettingRows<T> rows) {
        for (const Setting<T>& row : rows) know(std::string(row.name));
    }
    /// Fails for a field that was neither read nor allowed, except "do", "id" and those of a
    /// session's lines.
    void refuse_others() {
        for (const auto& field : m_object.items()) {
            const std::string& key = field.key();
            if (key == "do" || key == "id" || key == "client" || key == "refused" || knows(key))
                continue;
            std::string expected;
            for (const std::string& known : m_known)
                expected.append(expected.empty() ? "" : ", ").append(known);
            fail(false, short_text(Json(key)) + ": found an unknown field, expected " +
                            (expected.empty() ? "none" : "one of " + expected));
        }
    }

  private:
    bool knows(const std::string& key) const {
        return std::find(m_known.begin(), m_known.end(), key) != m_known.end();
    }
    void know(std::string key) {
        if (!knows(key)) m_known.push_back(std::move(key));
    }
    const Json* find(const char* key, bool optional) {
        know(key);
        const auto found = m_object.find(key);
        if (found != m_object.end()) return &*found;
        if (!optional) fail(true, std::string(key) + ": expected this field, found none");
        return nullptr;
    }
    Vec3d vector_of(const char* key, const Json& value, double longest) {
        Vec3d v{0, 0, 0};
        if (!value.is_array() || value.size() != 3)
            return wrong_type(key, "three numbers", value), v;
        for (int a = 0; a < 3; ++a) {
            const Json& number = value[std::size_t(a)];
            if (!number.is_number() || !std::isfinite(number.get<double>()))
                return wrong_type(key, "three finite numbers", value), v;
            v[a] = number.get<double>();
        }
        if (!(norm(v) <= longest))
            out_of_range(key, "a length of up to " + short_text(Json(longest)), value);
        return v;
    }
    void wrong_type(const char* key, const std::string& expected, const Json& found) {
        fail(true, std::string(key) + ": expected " + expected + ", found " + short_text(found));
    }
    void out_of_range(const char* key, const std::string& expected, const Json& found) {
        fail(false, std::string(key) + ": expected " + expected + ", found " + short_text(found));
    }
    void fail(bool rubbish, const std::string& message) {
        // A type failure overrides a range failure.
        if (m_failure && (m_failure->rubbish || !rubbish)) return;
        m_failure = {.rubbish = rubbish, .message = m_name + ": " + message, .name = m_name};
    }

    const Json& m_object;
    std::string m_name;
    std::vector<std::string> m_known;  ///< fields that were read or looked for
    std::optional<ParseFailure> m_failure;
};

/// @param least_mm  minimum radius; 0 allows the cell around the point
Action read_push(Fields& f, bool slide, double least_mm) {
    return PushCommand{.push = {.point_mm = f.vector("point", kMaxPositionMm),
                                .push_mm = f.vector("push", 500),
                                .sphere_radius_mm = f.number("radius", least_mm, 100)},
                       .slide = slide,
                       .stroke = f.whole("stroke", 1, 0)};
}
Action read_grab(Fields& f) {
    return GrabCommand{.position = {.point_mm = f.vector("point", kMaxPositionMm),
                                    .sphere_radius_mm = f.number("radius", 0, 100)},
                       .reach_mm = f.number("reach", 0, 500, 20)};
}
Action read_carve(Fields& f) {
    return CarveCommand{.tool = {.from_mm = f.vector("from", kMaxPositionMm),
                                 .to_mm = f.vector("to", kMaxPositionMm),
                                 .radius_mm = f.number("radius", 0.1, 100),
                                 .spare_fixed = f.flag("spare_fixed", false)},
                        .stroke = f.whole("stroke", 1, 0)};
}
Action read_materials(Fields& f) {
    if (f.has("elastic"))
        f.refuse(
            "elastic: expected a tissue command with the model elastic, which replaces it, found "
            "a setting that ChainMail no longer has");
    MaterialsCommand materials{f.record(chainmail_material_rows())};
    // Key of older sessions.
    if (f.has("rounded"))
        materials.values.emplace_back("limits", f.flag("rounded", {}) ? "rounded" : "box");
    return materials;
}
Action read_iso(Fields& f) {
    IsoCommand iso;
    f.settings(iso_rows(), iso);
    iso.stroke = f.whole("stroke", 1, 0);
    return iso;
}
Action read_tissue(Fields& f) {
    TissueCommand tissue;
    TissueChoice& choice = tissue.choice;
    choice.model = f.text("model", 40, {});
    if (choice.is_elastic()) choice.elastic = f.record(elastic_scan_rows());
    if (!choice.is_springs()) {
        f.allow({"centre", kExplicit});
        f.allow(tissue_rows());
        f.allow(spring_rows());
        f.allow(elastic_scan_rows());
        return tissue;
    }
    tissue.is_centred = f.has("centre");
    if (tissue.is_centred) choice.centre_mm = f.vector("centre", kMaxPositionMm);
    f.settings(tissue_rows(), choice);
    f.settings(spring_rows(), choice.springs);
    f.flag(kExplicit, false);
    set_given(f.object(), choice);
    return tissue;
}
Action read_depth(Fields& f) {
    DepthCommand depth;
    if (!f.has("within_mm") && !f.has("by_time")) f.require("layers");
    f.settings(depth_rows(), depth);
    return depth;
}
Action read_drive(Fields& f) {
    DriveCommand drive;
    f.settings(drive_rows(), drive);
    return drive;
}
Action read_hello(Fields& f) {
    HelloMessage hello;
    hello.protocol = int(f.number("protocol", -1e9, 1e9));
    if (f.has("role")) hello.view = f.choice("role", {"control", "view"}) == 1;
    hello.name = f.text("name", 160, "");
    hello.lz4 = f.flag("lz4", false);
    hello.coarse = f.flag("coarse", false);
    hello.resume = f.text("resume", 64, "");
    if (f.has("step")) hello.step = f.whole("step", 0, {});
    return hello;
}
Vec3f float_vector(Vec3d v) {
    return {float(v.x), float(v.y), float(v.z)};
}
Action read_tool(Fields& f) {
    ToolMessage tool;
    tool.pose.kind = ToolKind(f.choice("kind", {"none", "endoscope", "sphere"}));
    f.allow({"position", "direction", "up", "radius"});
    if (tool.pose.kind == ToolKind::None) return tool;
    tool.pose.position_mm = float_vector(f.vector("position", kMaxPositionMm));
    tool.pose.direction = float_vector(f.vector("direction", kMaxPositionMm));
    tool.pose.up = float_vector(f.vector("up", kMaxPositionMm, Vec3d{0, 0, 0}));
    tool.pose.radius_mm = float(f.number("radius", 0, 100, 0));
    return tool;
}

Action read_seen(Fields& f) {
    SeenMessage seen;
    seen.step = f.whole("step", 0, {});
    seen.format = f.whole("format", 1, kFormatVoxels);
    return seen;
}
Action read_camera(Fields& f) {
    f.allow({"look", "up"});
    if (!f.has("eye")) return CameraMessage{};
    return CameraMessage{CameraMessage::Pose{.eye_mm = f.vector("eye", kMaxPositionMm),
                                             .look = f.direction("look"),
                                             .up = f.direction("up")}};
}
Action read_replay(Fields& f) {
    ReplayMessage replay;
    if (f.has("playing")) replay.is_playing = f.flag("playing", {});
    if (f.has("speed")) replay.speed = f.number("speed", kMinReplaySpeed, kMaxReplaySpeed);
    if (f.has("at_ms")) replay.at_ms = f.number("at_ms", 0, 1e12);
    return replay;
}
Action read_overlay(Fields& f) {
    return OverlayMessage{OverlayKind(f.choice("kind", {"none", "displacement", "jacobian"}))};
}
Action read_path(Fields& f) {
    PathMessage path{.from_mm = f.vector("from", kMaxPositionMm),
                     .to_mm = f.vector("to", kMaxPositionMm),
                     .reach_mm = f.number("reach", 0, 50, 5)};
    const Action wall = read_iso(f);
    path.iso_hu = std::get_if<IsoCommand>(&wall)->iso_hu;
    path.polarity = std::get_if<IsoCommand>(&wall)->polarity;
    return path;
}
Action read_haptics(Fields& f) {
    HapticsMessage haptics;
    haptics.wish = HapticWish(f.choice("wish", {"start", "stop", "go", "end"}));
    f.allow({"device", "position", "look", "up", "scale", "radius"});
    if (haptics.wish != HapticWish::Start) return haptics;
    haptics.device = f.text("device", 200, {});
    haptics.position_mm = f.vector("position", kMaxPositionMm);
    haptics.look = f.direction("look");
    haptics.up = f.direction("up");
    haptics.scale = f.number("scale", 0.05, 20, haptics.scale);
    haptics.radius_mm = f.number("radius", 0.5, 20, haptics.radius_mm);
    return haptics;
}

constexpr const char* kMarkKinds[] = {"none", "point", "ruler", "angle", "curve"};

Action read_mark(Fields& f) {
    constexpr std::pair<std::size_t, std::size_t> kCounts[] = {
        {0, 0}, {1, 1}, {2, 2}, {3, 3}, {2, kMaxMarkPoints}};
    MarkMessage mark;
    mark.key = f.text("key", 64, {});
    const std::size_t kind = f.choice("kind", {"none", "point", "ruler", "angle", "curve"});
    mark.kind = MarkKind(kind);
    f.allow({"name", "points", "shown"});
    if (mark.kind == MarkKind::None) return mark;
    mark.name = f.text("name", 320, "");
    mark.rest_mm = f.line("points", kCounts[kind].first, kCounts[kind].second);
    mark.shown = f.flag("shown", true);
    return mark;
}

using Reader = Action (*)(Fields&);
template <class T>
Action nothing(Fields&) {
    return T{};
}

/// Readers in the order of Action's alternatives, plus slide, which is a push.
const std::array<std::pair<const char*, Reader>, 35> kReaders = {{
    {"push", [](Fields& f) { return read_push(f, false, 0); }},
    {"grab", read_grab},
    {"drag", [](Fields& f) -> Action { return DragCommand{f.vector("offset", kMaxPositionMm)}; }},
    {"let_go", nothing<LetGoCommand>},
    {"cut",
     [](Fields& f) -> Action {
         return CutCommand{{.line_mm = f.line("line"), .depth_mm = f.vector("depth", 1000)}};
     }},
    {"carve", read_carve},
    {"relax", [](Fields& f) -> Action { return RelaxCommand{f.flag("on", {})}; }},
    {"release", nothing<ReleaseCommand>},
    {"eye",
     [](Fields& f) -> Action {
         return EyeCommand{f.vector("position", kMaxPositionMm), f.number("radius", 0, 100)};
     }},
    {"reset", nothing<ResetCommand>},
    {"materials", read_materials},
    {"iso", read_iso},
    {"undo", nothing<UndoCommand>},
    {"redo", nothing<RedoCommand>},
    {"tissue", read_tissue},
    {"depth", read_depth},
    {"catheter", read_drive},
    {"hello", read_hello},
    {"tool", read_tool},
    {"checksum", nothing<ChecksumMessage>},
    {"seen", read_seen},
    {"ping", nothing<PingMessage>},
    {"overlay", read_overlay},
    {"path", read_path},
    {"haptics", read_haptics},
    {"haptic_pose",
     [](Fields& f) -> Action {
         return HapticPoseMessage{f.vector("position", 10'000), f.number("roll_deg", -1e6, 1e6, 0)};
     }},
    {"vessel", [](Fields& f) -> Action { return VesselMessage{f.flag("on", {})}; }},
    {"rest", [](Fields& f) -> Action { return RestMessage{f.flag("on", {})}; }},
    {"camera", read_camera},
    {"follow", [](Fields& f) -> Action { return FollowMessage{f.whole("client", 0, {})}; }},
    {"replay", read_replay},
    {"labels", [](Fields& f) -> Action { return LabelsMessage{f.flag("on", {})}; }},
    {"marks", [](Fields& f) -> Action { return MarksMessage{f.flag("on", {})}; }},
    {"mark", read_mark},
    {"slide", [](Fields& f) { return read_push(f, true, 0.01); }},
}};

Json json_of_mark(const MarkMessage& mark) {
    Json o = {{"key", mark.key}, {"kind", kMarkKinds[std::size_t(mark.kind)]}};
    if (mark.kind == MarkKind::None) return o;
    o["name"] = mark.name;
    o["points"] = Json::array();
    for (const Vec3d& point : mark.rest_mm) o["points"].push_back(json_of(point));
    o["shown"] = mark.shown;
    return o;
}

void write(Json& o, const PushCommand& c) {
    o["point"] = json_of(c.push.point_mm);
    o["push"] = json_of(c.push.push_mm);
    o["radius"] = c.push.sphere_radius_mm;
    if (c.stroke) o["stroke"] = c.stroke;
}
void write(Json& o, const GrabCommand& c) {
    o["point"] = json_of(c.position.point_mm);
    o["radius"] = c.position.sphere_radius_mm;
    o["reach"] = c.reach_mm;
}
void write(Json& o, const DragCommand& c) {
    o["offset"] = json_of(c.offset_mm);
}
void write(Json& o, const CutCommand& c) {
    o["line"] = Json::array();
    for (const Vec3d& point : c.surface.line_mm) o["line"].push_back(json_of(point));
    o["depth"] = json_of(c.surface.depth_mm);
}
void write(Json& o, const CarveCommand& c) {
    o["from"] = json_of(c.tool.from_mm);
    o["to"] = json_of(c.tool.to_mm);
    o["radius"] = c.tool.radius_mm;
    o["spare_fixed"] = c.tool.spare_fixed;
    if (c.stroke) o["stroke"] = c.stroke;
}
void write(Json& o, const EyeCommand& c) {
    o["position"] = json_of(c.position_mm);
    o["radius"] = c.radius_mm;
}
void write(Json& o, const RelaxCommand& c) {
    o["on"] = c.on;
}
void write(Json& o, const MaterialsCommand& c) {
    put(o, c.values);
}
void write(Json& o, const IsoCommand& c) {
    put(o, c, iso_rows());
    if (c.stroke) o["stroke"] = c.stroke;
}
void write(Json& o, const TissueCommand& c) {
    o["model"] = c.choice.model;
    put(o, c.choice.elastic);
    if (!c.choice.is_springs()) return;
    if (c.is_centred) o["centre"] = json_of(c.choice.centre_mm);
    put(o, c.choice, tissue_rows());
    put_springs(o, c.choice);
}
void write(Json& o, const DepthCommand& c) {
    put(o, c, depth_rows());
}
void write(Json& o, const DriveCommand& c) {
    put(o, c, drive_rows());
}
void write(Json& o, const VesselMessage& c) {
    o["on"] = c.on;
}
void write(Json& o, const RestMessage& c) {
    o["on"] = c.on;
}
void write(Json& o, const CameraMessage& c) {
    if (!c.pose) return;
    o["eye"] = json_of(c.pose->eye_mm);
    o["look"] = json_of(c.pose->look);
    o["up"] = json_of(c.pose->up);
}
void write(Json& o, const FollowMessage& c) {
    o["client"] = c.client;
}
void write(Json& o, const ReplayMessage& c) {
    if (c.is_playing) o["playing"] = *c.is_playing;
    if (c.speed) o["speed"] = *c.speed;
    if (c.at_ms) o["at_ms"] = *c.at_ms;
}
void write(Json& o, const LabelsMessage& c) {
    o["on"] = c.on;
}
void write(Json& o, const MarksMessage& c) {
    o["on"] = c.on;
}
void write(Json& o, const MarkMessage& c) {
    o.update(json_of_mark(c));
}
void write(Json& o, const HelloMessage& c) {
    o["protocol"] = c.protocol;
    o["role"] = c.view ? "view" : "control";
    o["name"] = c.name;
    o["lz4"] = c.lz4;
    if (c.coarse) o["coarse"] = true;
    if (!c.resume.empty()) o["resume"] = c.resume;
    if (c.step) o["step"] = *c.step;
}
void write(Json& o, const ToolMessage& c) {
    constexpr const char* kKinds[] = {"none", "endoscope", "sphere"};
    o["kind"] = kKinds[std::size_t(c.pose.kind)];
    o["position"] = json_of(c.pose.position_mm);
    o["direction"] = json_of(c.pose.direction);
    o["up"] = json_of(c.pose.up);
    o["radius"] = c.pose.radius_mm;
}
void write(Json& o, const SeenMessage& c) {
    o["step"] = c.step;
    if (c.format != kFormatVoxels) o["format"] = c.format;
}
void write(Json& o, const OverlayMessage& c) {
    constexpr const char* kKinds[] = {"none", "displacement", "jacobian"};
    o["kind"] = kKinds[std::size_t(c.kind)];
}
void write(Json& o, const PathMessage& c) {
    o["from"] = json_of(c.from_mm);
    o["to"] = json_of(c.to_mm);
    o["reach"] = c.reach_mm;
    write(o, IsoCommand{.iso_hu = c.iso_hu, .polarity = c.polarity});
}
void write(Json& o, const HapticsMessage& c) {
    constexpr const char* kWishes[] = {"start", "stop", "go", "end"};
    o["wish"] = kWishes[std::size_t(c.wish)];
    if (c.wish != HapticWish::Start) return;
    o["device"] = c.device;
    o["position"] = json_of(c.position_mm);
    o["look"] = json_of(c.look);
    o["up"] = json_of(c.up);
    o["scale"] = c.scale;
    o["radius"] = c.radius_mm;
}
void write(Json& o, const HapticPoseMessage& c) {
    o["position"] = json_of(c.position_mm);
    o["roll_deg"] = c.roll_deg;
}
template <class T>
void write(Json&, const T&) {}

}  // namespace

std::string_view name_of(const Action& action) {
    const auto* push = std::get_if<PushCommand>(&action);
    return push && push->slide ? "slide" : kReaders[action.index()].first;
}

bool is_command(const Action& action) {
    return action.index() < Action(HelloMessage{}).index();
}

std::variant<Message, ParseFailure> parse_message(std::string_view text) {
    if (is_too_deep(text))
        return ParseFailure{.message = "message: expected nesting of up to 4, found more"};
    const Json json = Json::parse(text.begin(), text.end(), nullptr, false);
    if (!json.is_object())
        return ParseFailure{.message = "message: expected a JSON object, found something else"};
    Fields head(json, "message");
    const std::string name = head.text("do", 40, {});
    const std::uint32_t id = head.whole("id", 0, 0);
    if (head.failure()) return *head.failure();
    for (const auto& [known, read] : kReaders) {
        if (name != known) continue;
        Fields fields(json, name);
        Message message{.id = id, .action = read(fields)};
        // A newer client's hello may have more fields.
        if (name != "hello") fields.refuse_others();
        if (!fields.failure()) return message;
        ParseFailure failure = *fields.failure();
        failure.id = id;
        return failure;
    }
    return ParseFailure{.message = "message: do: expected a command that is known, found " +
                                   short_text(Json(name))};
}

std::string text_of(const Message& message) {
    Json json = {{"do", name_of(message.action)}};
    if (message.id) json["id"] = message.id;
    std::visit([&](const auto& action) { write(json, action); }, message.action);
    return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

std::string mark_text(const MarkMessage& mark) {
    Json json = json_of_mark(mark);
    json["t"] = "mark";
    return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

std::string marks_text(std::span<const MarkMessage> marks) {
    Json list = Json::array();
    for (const MarkMessage& mark : marks) list.push_back(json_of_mark(mark));
    return Json{{"t", "marks"}, {"marks", list}}.dump(-1, ' ', false,
                                                      Json::error_handler_t::replace);
}

}  // namespace pliant::serve
