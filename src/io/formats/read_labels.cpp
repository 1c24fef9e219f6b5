// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Label maps, and the layers of 3D Slicer's segmentations: a 4-D file whose segments name their
// layer and value, Segment0_Layer and Segment0_LabelValue.

#include "base/errors.h"
#include "base/input_file.h"
#include "base/text.h"
#include "formats/image_file.h"
#include "formats/segment_layers.h"

#include <pliant/scan_files.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <string>

namespace pliant {
namespace fs = std::filesystem;
namespace {

/// "Segment12" of "Segment12_Layer"; empty for other keys.
std::string segment_of(std::string_view key) {
    const auto end = key.find('_');
    if (!key.starts_with("Segment") || end == key.npos) return {};
    const auto number = key.substr(7, end - 7);
    return number.empty() || !whole_number_from(number) ? std::string()
                                                        : std::string(key.substr(0, end));
}

std::map<std::string, std::int64_t> layers_of(const KeyValues& keys) {
    std::map<std::string, std::int64_t> layers;
    for (const auto& [key, value] : keys)
        if (const std::string segment = segment_of(key); key == segment + "_Layer")
            layers[segment] = whole_number_from(value).value_or(0);
    return layers;
}

struct LabelPath {
    fs::path file;
    std::optional<std::int64_t> layer;
};

/// Splits "organs.seg.nrrd#1", unless a file has that name.
LabelPath split_path(const fs::path& path) {
    const std::string text = path.string();
    const auto at = text.rfind('#');
    if (at == text.npos) return {path, {}};
    const auto layer = whole_number_from(text.substr(at + 1));
    if (!layer || *layer < 0) return {path, {}};
    const auto type = type_of(path);
    if (!type || *type == fs::file_type::regular) return {path, {}};
    return {text.substr(0, at), layer};
}

/// "over.seg.nrrd#0 (liver, spleen), over.seg.nrrd#1 (tumour)"
std::string choices(const fs::path& file, std::int64_t count, const KeyValues& keys) {
    constexpr std::int64_t kMost = 8;
    const auto layers = layers_of(keys);
    std::map<std::int64_t, std::string> names;
    for (const auto& [key, value] : keys) {
        const auto found = layers.find(segment_of(key));
        if (found == layers.end() || key != found->first + "_Name") continue;
        std::string& all = names[found->second];
        all += (all.empty() ? "" : ", ") + shown(value);
    }
    std::string text;
    for (std::int64_t n = 0; n < std::min(count, kMost); ++n) {
        text += (n > 0 ? ", " : "") + file.filename().string() + "#" + std::to_string(n);
        if (names.contains(n)) text += " (" + names[n] + ")";
    }
    return count > kMost ? text + ", …" : text;
}

/// Checks the properties that a scan need not have, before the map is read.
Status check_map(const LabelPath& path) {
    const auto format = format_by_name(path.file);
    if (!format) return Ok{};
    if (Status status = check_file(path.file); !status) return status;
    auto header = read_image_header(path.file, *format);
    if (!header) return header.error();
    if (Status status = check_header(path.file, 1, *header, true); !status) return status;
    const std::int64_t count = header->components;
    if (count > 1 && !path.layer)
        return Error{
            ErrorCode::InvalidArgument,
            path.file.string() + ": holds " + std::to_string(count) +
                " layers of labels, choose one: " + choices(path.file, count, header->key_values)};
    if (path.layer && *path.layer >= count)
        return Error{ErrorCode::InvalidArgument,
                     path.file.string() + ": found layer " + std::to_string(*path.layer) +
                         ", expected " + (count == 1 ? "0" : "0…" + std::to_string(count - 1))};
    if (!is_perpendicular(header->grid.direction))
        return unsupported(path.file,
                           "its axes are sheared, expected a label map with perpendicular ones, "
                           "such as one resampled to the scan's grid");
    return Ok{};
}

/// Finds the first value that isn't whole, or that a label can't have.
std::optional<float> odd_value(const Volume& map) {
    constexpr float kMost = 1 << 24;  // whole numbers of a float
    const auto* values = std::get_if<1>(&map.voxels);
    if (!values) return {};
    for (const float value : *values)
        if (!(value == std::floor(value) && std::abs(value) <= kMost)) return value;
    return {};
}

}  // namespace

void keep_layer(KeyValues& keys, std::int64_t layer) {
    const auto layers = layers_of(keys);
    std::erase_if(keys, [&](const auto& pair) {
        const auto found = layers.find(segment_of(pair.first));
        return found != layers.end() && found->second != layer;
    });
    for (auto& [key, value] : keys)
        if (const auto found = layers.find(segment_of(key));
            found != layers.end() && key == found->first + "_Layer")
            value = "0";
}

Result<Volume> read_labels(const fs::path& path, const ReadOptions& options, ReadNotes* notes) {
    const LabelPath label = split_path(path);
    const auto type = type_of(label.file);
    if (!type) return type.error();
    if (*type == fs::file_type::regular)
        if (Status status = check_map(label); !status) return status.error();
    ReadOptions of_layer = options;
    if (label.layer) of_layer.frame = label.layer;
    auto map = read_volume(label.file, of_layer, notes);
    if (!map) return map;
    if (const auto odd = odd_value(*map))
        return Error{ErrorCode::InvalidArgument,
                     path.string() + ": expected a label map of whole numbers, found " +
                         short_text(double(*odd))};
    map->background = 0;
    return map;
}

fs::path label_file(const fs::path& path) {
    return split_path(path).file;
}

}  // namespace pliant
