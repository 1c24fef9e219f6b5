// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The lines of a session's file as JSON.

#include <pliant/core/version.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "protocol/messages.h"
#include "protocol/record_json.h"
#include "protocol/wire_rows.h"
#include "session/session_log.h"

namespace pliant::serve {
namespace {

constexpr int kSessionVersion = 1;

Error bad_session(const std::string& what) {
    return {ErrorCode::Unreadable, what};
}

std::optional<std::uint64_t> number_of_hex(const Json& object, const char* key) {
    const auto found = object.find(key);
    if (found == object.end() || !found->is_string()) return {};
    const auto text = found->get<std::string>();
    if (text.size() != 16 || text.find_first_not_of("0123456789abcdef") != std::string::npos)
        return {};
    return std::stoull(text, nullptr, 16);
}

std::string string_at(const Json& object, const char* key) {
    const auto found = object.find(key);
    return found != object.end() && found->is_string() ? found->get<std::string>() : "";
}

int whole_at(const Json& object, const char* key, int missing) {
    const auto found = object.find(key);
    if (found == object.end() || !found->is_number_integer()) return missing;
    const auto number = found->get<std::int64_t>();
    return number >= -1'000'000'000 && number <= 1'000'000'000 ? int(number) : missing;
}

/// Reads the tissue; ChainMail has no key.
std::optional<TissueChoice> tissue_of(const Json& json) {
    TissueChoice choice;
    const auto springs = json.find("springs");
    for (const char* model : {"vessel", "own"}) {
        const auto own = json.find(model);
        if (own == json.end()) continue;
        if (*own != true || springs != json.end()) return {};
        choice.model = model;
        return choice;
    }
    if (const auto elastic = json.find("elastic"); elastic != json.end()) {
        ElasticScanSettings read_settings;
        if (!elastic->is_object() || springs != json.end() ||
            !read(*elastic, elastic_scan_rows(), read_settings))
            return {};
        choice.model = "elastic";
        for (const Setting<ElasticScanSettings>& row : elastic_scan_rows())
            if (elastic->contains(std::string(row.name)))
                choice.elastic.emplace_back(std::string(row.name), value_of(read_settings, row));
        return choice;
    }
    if (springs == json.end()) return choice;
    if (!springs->is_object()) return {};
    choice.model = "springs";
    for (const auto& [key, axis] : {std::pair("x", 0), {"y", 1}, {"z", 2}}) {
        const auto value = springs->find(key);
        if (value == springs->end() || !value->is_number()) return {};
        choice.centre_mm[axis] = value->get<double>();
        if (!(std::abs(choice.centre_mm[axis]) <= 1e5)) return {};
    }
    if (!read(*springs, tissue_rows(), choice) || !read(*springs, spring_rows(), choice.springs))
        return {};
    set_given_of_session(*springs, choice);
    return choice;
}

Json json_of(const TissueChoice& choice) {
    const Vec3d c = choice.centre_mm;
    Json json = {{"x", c.x}, {"y", c.y}, {"z", c.z}};
    put(json, choice, tissue_rows());
    put_springs(json, choice);
    return json;
}

Result<SessionRecord> parse_checkpoint(const Json& json) {
    const auto file = number_of_hex(json, "file"), volume = number_of_hex(json, "volume"),
               tissue = number_of_hex(json, "tissue");
    const auto iso = json.find("iso_hu"), relaxing = json.find("relaxing"),
               settled = json.find("settled");
    const std::string polarity = string_at(json, "polarity");
    SessionCheckpoint point;
    point.number = whole_at(json, "number", 0);
    const int last_client = whole_at(json, "last_client", -1), steps = whole_at(json, "steps", -1);
    const bool is_whole = file && volume && tissue && iso != json.end() && iso->is_number() &&
                          relaxing != json.end() && relaxing->is_boolean() &&
                          settled != json.end() && settled->is_boolean() &&
                          (polarity == "rising" || polarity == "falling") && point.number > 0 &&
                          last_client >= 0 && steps >= 0;
    if (!is_whole || !std::isfinite(iso->get<double>()))
        return bad_session("checkpoint: expected all its fields");
    point.file = *file;
    point.mark = {*volume, *tissue};
    const auto choice = tissue_of(json);
    if (!choice) return bad_session("checkpoint: expected all fields of its tissue");
    point.memo = {iso->get<double>(),
                  polarity == "rising" ? Polarity::Rising : Polarity::Falling,
                  relaxing->get<bool>(),
                  settled->get<bool>(),
                  std::uint32_t(last_client),
                  steps,
                  *choice};
    return SessionRecord(point);
}

Json json_of(const SessionHeader& header) {
    Json source;
    if (header.source.file.empty()) {
        const Vec3i size = header.source.phantom_size;
        source = {{"phantom", header.source.phantom}, {"size", {size.x, size.y, size.z}}};
    } else {
        source = {{"file", header.source.file}, {"series", header.source.series}};
        if (header.source.frame) source["frame"] = *header.source.frame;
        if (header.source.straighten) source["straighten"] = true;
        if (const auto& mm = header.source.spacing_mm) source["spacing_mm"] = {mm->x, mm->y, mm->z};
        if (header.source.bodies) source["bodies"] = *header.source.bodies;
    }
    for (const auto& [key, file] :
         {std::pair{"config", &header.source.config}, std::pair{"labels", &header.source.labels},
          std::pair{"directions", &header.source.directions},
          std::pair{"model", &header.source.model}, std::pair{"network", &header.source.network},
          std::pair{"label_names", &header.source.label_names},
          std::pair{"units", &header.source.units}})
        if (!file->empty()) source[key] = *file;
    return {{"source", source}, {"scan", hex_text(header.scan_hash, 16)}};
}

std::string text_of_json(const Json& json) {
    return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

Result<SessionHeader> header_of(const Json& json) {
    SessionHeader header;
    const auto hash = number_of_hex(json, "scan");
    const auto source = json.find("source");
    if (!hash || source == json.end() || !source->is_object())
        return bad_session("expected the fields scan and source, found none");
    header.scan_hash = *hash;
    header.source.file = string_at(*source, "file");
    header.source.series = string_at(*source, "series");
    if (const auto frame = source->find("frame"); frame != source->end()) {
        if (!frame->is_number_integer()) return bad_session("source: frame: expected a number");
        header.source.frame = frame->get<std::int64_t>();
    }
    if (const auto option = source->find("straighten"); option != source->end())
        header.source.straighten = option->is_boolean() && option->get<bool>();
    if (const auto spacing = source->find("spacing_mm"); spacing != source->end()) {
        const bool has_three = spacing->is_array() && spacing->size() == 3;
        Vec3d mm;
        for (int a = 0; a < 3; ++a) {
            const Json number = has_three ? (*spacing)[std::size_t(a)] : Json();
            if (!number.is_number() || !(number.get<double>() > 0))
                return bad_session("source: spacing_mm: expected three numbers above 0");
            mm[a] = number.get<double>();
        }
        header.source.spacing_mm = mm;
    }
    if (const auto bodies = source->find("bodies"); bodies != source->end()) {
        if (!bodies->is_array()) return bad_session("source: bodies: expected labels");
        header.source.bodies.emplace();
        for (const Json& label : *bodies) {
            if (!label.is_number_integer())
                return bad_session("source: bodies: expected whole numbers");
            header.source.bodies->push_back(label.get<int>());
        }
    }
    header.source.config = string_at(*source, "config");
    header.source.labels = string_at(*source, "labels");
    header.source.directions = string_at(*source, "directions");
    header.source.model = string_at(*source, "model");
    header.source.network = string_at(*source, "network");
    header.source.label_names = string_at(*source, "label_names");
    header.source.units = string_at(*source, "units");
    if (!header.source.file.empty()) return header;
    header.source.phantom = string_at(*source, "phantom");
    const auto size = source->find("size");
    if (size == source->end() || !size->is_array() || size->size() != 3)
        return bad_session("source: expected size with three numbers, found none");
    for (int a = 0; a < 3; ++a) {
        const Json& n = (*size)[std::size_t(a)];
        if (!n.is_number_integer() || n.get<std::int64_t>() < 2 || n.get<std::int64_t>() > 4096)
            return bad_session("source: size: expected whole numbers 2…4096");
        header.source.phantom_size[a] = n.get<int>();
    }
    return header;
}

}  // namespace

std::string text_of(const SessionHeader& header) {
    Json json = json_of(header);
    json["pliant_session"] = kSessionVersion;
    json["program"] = "pliant " PLIANT_VERSION;
    return text_of_json(json);
}

Result<SessionHeader> parse_session_header(std::string_view text) {
    const Json json = Json::parse(text.begin(), text.end(), nullptr, false);
    if (!json.is_object() || !json.contains("pliant_session"))
        return bad_session("expected a session of pliant serve, found something else");
    if (whole_at(json, "pliant_session", 0) != kSessionVersion)
        return Error{ErrorCode::Unsupported, "pliant_session: expected version 1, found " +
                                                 json["pliant_session"].dump().substr(0, 20)};
    return header_of(json);
}

std::string text_of(const SessionRecord& record) {
    if (const auto* sweeps = std::get_if<SessionSweeps>(&record)) {
        Json json = {{"do", "sweep"}, {"count", sweeps->count}};
        if (sweeps->parts) json["parts"] = *sweeps->parts;
        return json.dump();
    }
    if (const auto* mark = std::get_if<SessionMark>(&record))
        return Json{{"do", "mark"},
                    {"volume", hex_text(mark->volume, 16)},
                    {"tissue", hex_text(mark->tissue, 16)}}
            .dump();
    if (const auto* point = std::get_if<SessionCheckpoint>(&record)) {
        Json json = {{"do", "checkpoint"},
                     {"number", point->number},
                     {"file", hex_text(point->file, 16)},
                     {"volume", hex_text(point->mark.volume, 16)},
                     {"tissue", hex_text(point->mark.tissue, 16)},
                     {"iso_hu", point->memo.iso_hu},
                     {"polarity", point->memo.polarity == Polarity::Rising ? "rising" : "falling"},
                     {"relaxing", point->memo.relaxing},
                     {"settled", point->memo.settled},
                     {"last_client", point->memo.last_client},
                     {"steps", point->memo.steps}};
        const TissueChoice& tissue = point->memo.tissue;
        if (tissue.is_springs())
            json["springs"] = json_of(tissue);
        else if (tissue.is_elastic())
            put(json["elastic"] = Json::object(), tissue.elastic);
        else if (tissue.model != TissueChoice{}.model)
            json[tissue.model] = true;
        return json.dump();
    }
    if (const auto* forget = std::get_if<SessionForget>(&record))
        return Json{{"do", "forget"}, {"steps", forget->steps}}.dump();
    if (const auto* broken = std::get_if<SessionBreak>(&record))
        return Json{{"client", broken->client}, {"do", "break"}}.dump();
    if (const auto* lost = std::get_if<SessionLost>(&record))
        return Json{{"do", "lost"}, {"steps", lost->steps}}.dump();
    if (const auto* wait = std::get_if<SessionWait>(&record))
        return Json{{"do", "wait"}, {"ms", wait->ms}}.dump();
    if (const auto* state = std::get_if<SessionState>(&record))
        return text_of_json(
            {{"do", "state"}, {"file", state->file}, {"checksum", hex_text(state->checksum, 16)}});
    if (const auto* open = std::get_if<SessionOpen>(&record)) {
        Json json = json_of(open->scan);
        json["do"] = "open";
        return text_of_json(json);
    }
    const auto& command = *std::get_if<SessionCommand>(&record);
    return "{\"client\":" + std::to_string(command.client) +
           (command.refused ? ",\"refused\":true," : ",") +
           text_of(Message{0, command.action}).substr(1);
}

Result<SessionRecord> parse_session_record(std::string_view text) {
    const Json json = Json::parse(text.begin(), text.end(), nullptr, false);
    if (!json.is_object()) return bad_session("expected a JSON object, found something else");
    const std::string name = string_at(json, "do");
    if (name == "sweep") {
        SessionSweeps sweeps{.count = whole_at(json, "count", -1)};
        if (json.contains("parts")) sweeps.parts = whole_at(json, "parts", -1);
        if (sweeps.count < (sweeps.parts ? 0 : 1) || sweeps.count > 1'000'000)
            return bad_session("sweep: count: expected 1…1000000");
        if (sweeps.parts.value_or(0) < 0) return bad_session("sweep: parts: expected 0 or more");
        return SessionRecord(sweeps);
    }
    if (name == "mark") {
        const auto volume = number_of_hex(json, "volume"), tissue = number_of_hex(json, "tissue");
        if (!volume || !tissue) return bad_session("mark: expected two hashes");
        return SessionRecord(SessionMark{*volume, *tissue});
    }
    if (name == "checkpoint") return parse_checkpoint(json);
    if (name == "forget") {
        const int steps = whole_at(json, "steps", -1);
        if (steps < 0) return bad_session("forget: steps: expected 0 or more");
        return SessionRecord(SessionForget{steps});
    }
    if (name == "lost") {
        const int steps = whole_at(json, "steps", -1);
        if (steps < 0) return bad_session("lost: steps: expected 0 or more");
        return SessionRecord(SessionLost{steps});
    }
    if (name == "wait") {
        const int ms = whole_at(json, "ms", -1);
        if (ms < 0) return bad_session("wait: ms: expected 0 or more");
        return SessionRecord(SessionWait{ms});
    }
    if (name == "break") {
        const int client = whole_at(json, "client", -1);
        if (client < 0) return bad_session("break: client: expected 0 or more");
        return SessionRecord(SessionBreak{std::uint32_t(client)});
    }
    if (name == "state") {
        const auto checksum = number_of_hex(json, "checksum");
        std::string file = string_at(json, "file");
        if (!checksum || file.empty()) return bad_session("state: expected a file and a checksum");
        return SessionRecord(SessionState{std::move(file), *checksum});
    }
    if (name == "open") {
        auto scan = header_of(json);
        if (!scan.ok()) return scan.error();
        return SessionRecord(SessionOpen{std::move(*scan)});
    }
    auto message = parse_message(text);
    if (const auto* failure = std::get_if<ParseFailure>(&message))
        return bad_session(failure->message);
    auto& action = std::get_if<Message>(&message)->action;
    if (auto* tissue = std::get_if<TissueCommand>(&action))
        if (tissue->choice.is_springs()) set_given_of_session(json, tissue->choice);
    if (!is_command(action)) return bad_session("do: expected a command, found " + name);
    const int client = whole_at(json, "client", 0);
    if (client < 0) return bad_session("client: expected 0 or more");
    const bool refused = json.contains("refused") && json["refused"] == true;
    return SessionRecord(SessionCommand{std::uint32_t(client), std::move(action), refused});
}

}  // namespace pliant::serve
