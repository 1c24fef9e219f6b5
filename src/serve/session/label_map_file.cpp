// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Label maps from files.

#include <pliant/resample.h>
#include <pliant/scan_files.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <sstream>

#include "base/errors.h"
#include "organs/label_names.h"
#include "protocol/limits.h"
#include "session/label_map.h"

namespace pliant::serve {
namespace {

/// Segments of 3D Slicer by their value: Segment0_LabelValue, Segment0_Name, Segment0_Color.
std::map<int, LabelInfo> segments_of(const KeyValues& pairs) {
    std::map<std::string, LabelInfo> by_segment;
    for (const auto& [key, value] : pairs) {
        const std::size_t end = key.find('_');
        if (!key.starts_with("Segment") || end == std::string::npos) continue;
        LabelInfo& label = by_segment[key.substr(0, end)];
        const std::string field = key.substr(end + 1);
        if (field == "Name") label.name = value;
        if (field == "LabelValue")
            std::from_chars(value.data(), value.data() + value.size(), label.value);
        if (field != "Color") continue;
        std::istringstream text(value);
        text.imbue(std::locale::classic());
        std::array<double, 3> colour{};
        if (text >> colour[0] >> colour[1] >> colour[2]) label.colour = colour;
    }
    std::map<int, LabelInfo> by_value;
    for (auto& [segment, label] : by_segment) by_value.emplace(label.value, std::move(label));
    return by_value;
}

/// Counts labels, in the order of their values.
Result<std::map<int, LabelInfo>> labels_of(const Volume& volume, const std::string& name) {
    std::map<int, LabelInfo> labels = segments_of(volume.key_values);
    std::map<int, std::int64_t> counts;
    std::visit(
        [&](const auto& values) {
            for (const auto value : values) {
                if (value != 0 && counts.size() <= kMaxLabels) ++counts[int(value)];
            }
        },
        volume.voxels);
    if (counts.size() > kMaxLabels)
        return pliant::Error{ErrorCode::LimitExceeded, name + ": expected a label map of up to " +
                                                           std::to_string(kMaxLabels) +
                                                           " labels, found more"};
    std::erase_if(labels, [&](const auto& label) { return !counts.contains(label.first); });
    for (const auto& [value, count] : counts) labels[value].value = value;
    return labels;
}

}  // namespace

Result<std::shared_ptr<const LabelMap>> read_label_map(const std::filesystem::path& file,
                                                       const Grid& scan, const TaskArena& arena,
                                                       const std::function<bool()>& give_up,
                                                       const std::filesystem::path& names) {
    return attempt([&]() -> Result<std::shared_ptr<const LabelMap>> {
        const auto volume = read_labels(
            file, {.series_uid = {}, .may_map = false, .progress = {}, .give_up = give_up});
        if (!volume.ok()) return volume.error();
        const std::filesystem::path path = label_file(file);
        const std::string name = path.filename().string();
        const auto labels = labels_of(*volume, name);
        if (!labels.ok()) return labels.error();
        const auto found = find_label_names(path, volume->key_values, names);
        if (!found.ok()) return about("label_names", found.error().code, found.error().message);
        auto map = std::make_shared<LabelMap>();
        map->name = name;
        map->grid = scan;
        std::map<int, std::uint16_t> number_of;
        for (const auto& [value, label] : *labels) {
            map->labels.push_back(label);
            if (const auto named = found->find(value); named != found->end())
                map->labels.back().name = named->second;
            number_of[value] = std::uint16_t(map->labels.size());
        }
        map->numbers.resize(voxel_count(scan));
        const auto on_scan = labels_on(*volume, scan, arena);
        const pliant::Error outside{
            ErrorCode::InvalidArgument,
            name + ": expected a label map with labels inside of the scan, found none"};
        if (!on_scan.ok())
            return on_scan.error().code == ErrorCode::InvalidArgument ? outside : on_scan.error();
        std::visit(
            [&](const auto& voxels) {
                arena.for_each(scan.size.z, 4, [&](std::int64_t begin, std::int64_t end) {
                    const std::size_t slice = map->numbers.size() / std::size_t(scan.size.z);
                    for (std::size_t n = std::size_t(begin) * slice; n < std::size_t(end) * slice;
                         ++n)
                        if (voxels[n] != 0)
                            map->numbers[n] = number_of.find(int(voxels[n]))->second;
                });
            },
            on_scan->voxels);
        count_labels(*map);
        const bool has_any = std::any_of(map->labels.begin(), map->labels.end(),
                                         [](const LabelInfo& label) { return label.voxels > 0; });
        if (!has_any) return outside;
        return std::shared_ptr<const LabelMap>(std::move(map));
    });
}

}  // namespace pliant::serve
