// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Settings from a file: the only place that knows toml++.

#include <toml++/toml.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <fstream>
#include <sstream>
#include <string_view>
#include <utility>

#include "chainmail/settings.h"
#include "core/errors.h"
#include "core/read_file.h"

namespace pliant {
namespace {

std::string enclosed(char before, std::string_view text, char after) {
    std::string result(1, before);
    result.append(text).push_back(after);
    return result;
}

std::string quoted(std::string_view text) {
    return enclosed('\'', shown(text), '\'');
}

struct Reader {
    std::string file;

    Error wrong(const std::string& key, const std::string& expected,
                const std::string& found) const {
        return {ErrorCode::InvalidArgument,
                file + ": " + key + ": expected " + expected + ", found " + found};
    }
    Status read(const toml::node& node, const std::string& key, double& out) const {
        const auto number = node.value<double>();
        if (!node.is_number() || !number) return wrong(key, "a number", found(node));
        out = *number;
        return Ok{};
    }
    template <class Integer>
    requires std::integral<Integer> Status read(const toml::node& node, const std::string& key,
                                                Integer& out)
    const {
        const auto number = node.value_exact<std::int64_t>();
        if (!number || !std::in_range<Integer>(*number))
            return wrong(key, "a whole number", found(node));
        out = Integer(*number);
        return Ok{};
    }
    Status read(const toml::node& node, const std::string& key, bool& out) const {
        if (!node.is_boolean()) return wrong(key, "true or false", found(node));
        out = node.value_or(false);
        return Ok{};
    }
    Status read(const toml::node& node, const std::string& key, std::string& out) const {
        if (!node.is_string()) return wrong(key, "a text in quotes", found(node));
        out = node.value_or(std::string());
        return Ok{};
    }
    Status read(const toml::node& node, const std::string& key, LinkLimits& out) const {
        const std::string name = node.value_or(std::string());
        if (name != "box" && name != "rounded")
            return wrong(key, "\"box\" or \"rounded\"", found(node));
        out = name == "box" ? LinkLimits::Box : LinkLimits::Rounded;
        return Ok{};
    }
    Status read(const toml::node& node, const std::string& key, LabelLaw& out) const {
        const std::string name = node.value_or(std::string());
        if (name != "draeger" && name != "constant" && name != "fixed")
            return wrong(key, "\"draeger\", \"constant\" or \"fixed\"", found(node));
        out = name == "draeger"    ? LabelLaw::ByValue
              : name == "constant" ? LabelLaw::Constant
                                   : LabelLaw::Immobile;
        return Ok{};
    }
    Status read(const toml::node& node, const std::string& key, std::optional<double>& out) const {
        return read(node, key, out.emplace());
    }
    /// One number for all axes, or three.
    Status read(const toml::node& node, const std::string& key, Vec3d& out) const {
        const toml::array* numbers = node.as_array();
        if (numbers && numbers->size() != 3)
            return wrong(key, "one number or three", std::to_string(numbers->size()));
        for (int b = 0; b < 3; ++b) {
            const toml::node& number = numbers ? *numbers->get(std::size_t(b)) : node;
            if (Status s = read(number, key, out[b]); !s.ok()) return s;
        }
        return Ok{};
    }
    /// One whole number, or several.
    Status read(const toml::node& node, const std::string& key, std::vector<int>& out) const {
        const toml::array* numbers = node.as_array();
        for (std::size_t n = 0; n < (numbers ? numbers->size() : 1); ++n)
            if (Status s = read(numbers ? *numbers->get(n) : node, key, out.emplace_back());
                !s.ok())
                return s;
        return Ok{};
    }
    static std::string found(const toml::node& node) {
        std::ostringstream text;
        if (const auto words = node.value_exact<std::string>())
            text << '"' << shown(*words) << '"';
        else
            text << node.type();
        return text.str();
    }
};

Status read_key(const Reader& r, const std::string& key, const toml::node& node,
                ChainMailSettings& s) {
    if (key == "[material] law") return r.read(node, key, s.law);
    if (key == "[material] offset") return r.read(node, key, s.offset);
    if (key == "[material] bone_threshold_hu") return r.read(node, key, s.bone_threshold_hu);
    if (key == "[material] max_movement_mm") return r.read(node, key, s.max_movement_mm);
    if (key == "[material] limits") return r.read(node, key, s.limits);
    if (key == "[material] yield") return r.read(node, key, s.yield);
    if (key == "[push] scale") return r.read(node, key, s.scale);
    if (key == "[lattice] brick_size") return r.read(node, key, s.brick_size);
    if (key == "[lattice] max_elements") return r.read(node, key, s.max_elements);
    if (key == "[lattice] bounded") return r.read(node, key, s.bounded);
    if (key == "[history] max_steps") return r.read(node, key, s.history_max_steps);
    if (key == "[history] max_mb") return r.read(node, key, s.history_max_mb);
    if (key == "[air] enabled") return r.read(node, key, s.air_enabled);
    if (key == "[air] threshold_hu") return r.read(node, key, s.air_threshold_hu);
    if (key == "[air] compress") return r.read(node, key, s.air_compress);
    if (key == "[air] stretch") return r.read(node, key, s.air_stretch);
    if (key == "[air] shear") return r.read(node, key, s.air_shear);
    return r.wrong(key,
                   "one of [material] law, offset, bone_threshold_hu, max_movement_mm, yield, "
                   "limits; [push] scale; [lattice] brick_size, max_elements, bounded; [history] "
                   "max_steps, max_mb; [air] enabled, threshold_hu, compress, stretch, shear; or "
                   "[[label]] tables",
                   "a key that has no meaning here");
}

Status read_label_key(const Reader& r, const std::string& table, const std::string& name,
                      const toml::node& node, LabelMaterial& m) {
    const std::string key = table + " " + shown(name);
    if (name == "values") return r.read(node, key, m.values);
    if (name == "law") return r.read(node, key, m.law);
    if (name == "offset") return r.read(node, key, m.offset);
    if (name == "bone_threshold_hu") return r.read(node, key, m.bone_threshold_hu);
    if (name == "max_movement_mm") return r.read(node, key, m.max_movement_mm);
    if (name == "yield") return r.read(node, key, m.yield);
    if (name == "factor") return r.read(node, key, m.factor);
    if (name == "compress") return r.read(node, key, m.compress);
    if (name == "stretch") return r.read(node, key, m.stretch);
    if (name == "shear") return r.read(node, key, m.shear);
    if (name == "frame") {
        const std::string frame = node.value_or(std::string());
        if (frame != "lattice" && frame != "direction")
            return r.wrong(key, "\"lattice\" or \"direction\"", Reader::found(node));
        m.along_direction = frame == "direction";
        return Ok{};
    }
    return r.wrong(key,
                   "one of values, law, offset, bone_threshold_hu, max_movement_mm, yield, factor, "
                   "compress, stretch, shear, frame",
                   "a key that has no meaning here");
}

Status read_labels(const Reader& r, const toml::node& node, ChainMailSettings& settings) {
    const toml::array* tables = node.as_array();
    if (!tables) return r.wrong("[label]", "[[label]], one for each material", Reader::found(node));
    for (const toml::node& element : *tables) {
        const toml::table* table = element.as_table();
        const std::string name = "[[label]] " + std::to_string(settings.label_materials.size() + 1);
        if (!table) return r.wrong(name, "a table", Reader::found(element));
        LabelMaterial& material = settings.label_materials.emplace_back();
        for (const auto& [key, value] : *table)
            if (Status s = read_label_key(r, name, std::string(key.str()), value, material);
                !s.ok())
                return s;
    }
    return Ok{};
}

Status read_toml(const Reader& reader, const std::string& text, ChainMailSettings& settings) {
    if (const Status s = check_nesting(text, TextSyntax::Toml); !s)
        return Error{s.error().code, reader.file + ": " + s.error().message};
    toml::table root;
    try {
        get_memory_for_tables(text.size());
        root = toml::parse(text);
    } catch (const toml::parse_error& error) {
        std::ostringstream where;
        where << reader.file << ": line " << error.source().begin.line << ": expected TOML, "
              << error.description();
        return Error{ErrorCode::Unreadable, where.str()};
    }
    for (const auto& [table_key, table_node] : root) {
        const std::string table_name{table_key.str()};
        if (table_name == "label") {
            if (Status s = read_labels(reader, table_node, settings); !s.ok()) return s;
            continue;
        }
        const toml::table* table = table_node.as_table();
        if (!table)
            return reader.wrong(shown(table_name), "a table such as [material]",
                                Reader::found(table_node));
        for (const auto& [key, node] : *table) {
            const Status status =
                read_key(reader, enclosed('[', shown(table_name), ']') + " " + shown(key.str()),
                         node, settings);
            if (!status.ok()) return status;
        }
    }
    return Ok{};
}

/// A number, true, false, or a text in quotes. @returns NotFound where it is none of these
Status read_plain_value(const Reader& reader, const std::string& key, std::string_view text,
                        ChainMailSettings& settings) {
    const char *begin = text.data(), *end = begin + text.size();
    if (text.size() >= 2 && text.front() == '"' && text.back() == '"' &&
        text.find_first_of("\"\\", 1) == text.size() - 1)
        return read_key(reader, key, toml::value<std::string>(text.substr(1, text.size() - 2)),
                        settings);
    if (text == "true" || text == "false")
        return read_key(reader, key, toml::value<bool>(text == "true"), settings);
    std::int64_t whole = 0;
    if (const auto read = std::from_chars(begin, end, whole); read.ptr == end)
        return read_key(reader, key, toml::value<std::int64_t>(whole), settings);
    double number = 0;
    if (const auto read = std::from_chars(begin, end, number); read.ptr == end)
        return read_key(reader, key, toml::value<double>(number), settings);
    return Error{ErrorCode::NotFound, {}};
}

/// Reads the text of settings_text. Where memory is short it throws std::bad_alloc, for which
/// toml::parse ends the process.
/// @returns whether the text was understood
bool read_plain(const Reader& reader, std::string_view text, ChainMailSettings& settings) {
    std::string table;
    while (!text.empty()) {
        const std::string_view line = text.substr(0, text.find('\n'));
        text.remove_prefix(std::min(text.size(), line.size() + 1));
        if (line.empty()) continue;
        if (line.front() == '[' && line.back() == ']') {
            table = line;
            continue;
        }
        const std::size_t equals = line.find(" = ");
        if (equals == std::string_view::npos) return false;
        const std::string key = table + " " + std::string(line.substr(0, equals));
        if (!read_plain_value(reader, key, line.substr(equals + 3), settings).ok()) return false;
    }
    return true;
}

std::string_view trimmed(std::string_view text) {
    while (!text.empty() && std::isspace(static_cast<unsigned char>(text.front())))
        text.remove_prefix(1);
    while (!text.empty() && std::isspace(static_cast<unsigned char>(text.back())))
        text.remove_suffix(1);
    return text;
}

/// Lower case, letters and digits only: the thesis names its keys in words.
std::string plain_key(std::string_view key) {
    std::string plain;
    for (const char c : key)
        if (std::isalnum(static_cast<unsigned char>(c)))
            plain += char(std::tolower(static_cast<unsigned char>(c)));
    return plain;
}

Status read_divod_key(const Reader& r, std::string_view key, std::string_view value,
                      ChainMailSettings& s, std::vector<std::string>& notes) {
    const std::string plain = plain_key(key);
    const std::string name = shown(key);
    if (plain == "maxtries" || plain == "stepscale") {
        notes.push_back(name + ": not needed, the largest valid step is found exactly");
        return Ok{};
    }
    if (plain == "adaptregionstozscale" || plain == "zscale") {
        notes.push_back(name + ": always on, the lattice works in millimetres");
        return Ok{};
    }
    double number = 0;
    const auto [end, error] = std::from_chars(value.data(), value.data() + value.size(), number);
    if (error != std::errc{} || end != value.data() + value.size() || !std::isfinite(number))
        return r.wrong(name, "a number", quoted(value));
    if (plain == "cubiclesize") {
        if (number != std::floor(number) || std::abs(number) > 1000)
            return r.wrong(name, "a whole number", quoted(value));
        s.brick_size = int(number);
    } else if (plain == "scalefactor" || plain == "scale") {
        s.scale = number;
    } else if (plain == "offset") {
        s.offset = number;
    } else if (plain == "bonethreshold") {
        s.bone_threshold_hu = number - 1000;
        notes.push_back(name + ": read on the scale 0 to 4095, bone_threshold_hu = value - 1000");
    } else if (plain.starts_with("max") && plain.find("movement") != std::string::npos) {
        s.max_movement_mm = number;
        notes.push_back(name + ": voxels are taken as millimetres");
    } else {
        return r.wrong(name,
                       "cubicle size, scale factor, offset, maximum allowed movement, bone "
                       "threshold, adapt regions to z-scale, max tries or step scale",
                       "a key that has no meaning here");
    }
    return Ok{};
}

Status read_divod(const Reader& reader, const std::string& text, ChainMailSettings& settings,
                  std::vector<std::string>& notes) {
    std::istringstream lines(text);
    for (std::string line; std::getline(lines, line);) {
        const std::string_view content = trimmed(line);
        if (content.empty() || content.front() == '#') continue;
        const auto equals = content.find('=');
        if (equals == std::string_view::npos)
            return reader.wrong(quoted(content), "key=value", "no '='");
        const Status status = read_divod_key(reader, trimmed(content.substr(0, equals)),
                                             trimmed(content.substr(equals + 1)), settings, notes);
        if (!status.ok()) return status;
    }
    return Ok{};
}

/// TOML has tables, or keys with a dot before the '='; Divod's lines have neither.
bool looks_like_toml(const std::string& text) {
    std::istringstream lines(text);
    for (std::string line; std::getline(lines, line);) {
        const std::string_view content = trimmed(line);
        if (content.empty() || content.front() == '#') continue;
        if (content.front() == '[') return true;
        const auto equals = content.find('=');
        return equals != std::string_view::npos &&
               content.substr(0, equals).find('.') != std::string_view::npos;
    }
    return true;
}

}  // namespace

Result<ChainMailSettings> parse_settings(const std::string& name, const std::string& toml) {
    ChainMailSettings settings;
    if (!read_plain({name}, toml, settings)) {
        settings = {};
        if (const Status read = read_toml({name}, toml, settings); !read.ok())
            return in_one_line(read.error());
    }
    if (const Status valid = check_settings(settings); !valid.ok())
        return Error{valid.error().code, name + ": " + valid.error().message};
    return settings;
}

namespace {

Result<ChainMailSettings> read_file(const std::filesystem::path& path,
                                    std::vector<std::string>* notes) {
    const Result<std::string> text = read_small_file(path, kMaxSmallFileBytes, "a settings file");
    if (!text.ok()) return text.error();
    const Reader reader{path.string()};
    ChainMailSettings settings;
    std::vector<std::string> own_notes;
    const Status read = looks_like_toml(*text) ? read_toml(reader, *text, settings)
                                               : read_divod(reader, *text, settings, own_notes);
    if (!read.ok()) return in_one_line(read.error());
    if (const Status valid = check_settings(settings); !valid.ok())
        return Error{valid.error().code, reader.file + ": " + valid.error().message};
    if (notes) notes->insert(notes->end(), own_notes.begin(), own_notes.end());
    return settings;
}

}  // namespace

Result<ChainMailSettings> read_chainmail_settings(const std::filesystem::path& path,
                                                  std::vector<std::string>* notes) {
    return attempt([&] { return read_file(path, notes); });
}

}  // namespace pliant
