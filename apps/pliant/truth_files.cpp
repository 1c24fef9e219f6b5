// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "truth_files.h"

#include <pliant/core/files.h>
#include <pliant/core/text.h>
#include <pliant/core/version.h>
#include <pliant/scan_files.h>

#include <array>
#include <cctype>
#include <charconv>
#include <functional>
#include <sstream>
#include <utility>

#include "output_text.h"

namespace pliant::app {
namespace fs = std::filesystem;
namespace {

constexpr std::size_t kMaxJsonBytes = std::size_t(256) << 20;

Json json_of(Vec3d v) {
    return {v.x, v.y, v.z};
}

std::string landmark_text(const TruthCase& made) {
    std::string text = "fixed_x,fixed_y,fixed_z,moving_x,moving_y,moving_z,type\n";
    for (const TruthLandmark& landmark : made.landmarks) {
        for (const Vec3d& point : {landmark.fixed_mm, landmark.moving_mm})
            for (int a = 0; a < 3; ++a) text += text_of(point[a]) + ",";
        text += std::string(name_of(landmark.label)) + "\n";
    }
    return text;
}

Json counts_json(const std::array<std::int64_t, 5>& voxels) {
    Json json = Json::object();
    for (std::size_t n = 0; n < voxels.size(); ++n)
        json[std::string(name_of(TruthMask(n)))] = voxels[n];
    return json;
}

Error wrong_file(const fs::path& path, const std::string& expected) {
    return {ErrorCode::Unreadable, path.string() + ": " + expected};
}

/// Numbers at the beginning of a line.
std::vector<double> numbers_in(std::string_view line) {
    std::vector<double> numbers;
    const char* at = line.data();
    const char* const end = at + line.size();
    for (;;) {
        while (at != end && (*at == ' ' || *at == '\t' || *at == ',' || *at == ';')) ++at;
        if (at != end && *at == '+') ++at;
        double number = 0;
        const auto [next, error] = std::from_chars(at, end, number);
        if (error != std::errc{}) return numbers;
        numbers.push_back(number);
        at = next;
    }
}

}  // namespace

Json truth_record(const TruthCase& made, const std::string& model, const TruthSettings& settings) {
    Json json = {{"seed", made.seed},
                 {"version", PLIANT_VERSION},
                 {"hash", hex_of(made.hash)},
                 {"model", model},
                 {"inverse_error_mm", made.inverse_error_mm},
                 {"landmark_error_mm", made.landmark_error_mm},
                 {"max_displacement_mm", made.max_displacement_mm},
                 {"folded_cells", made.folded_cells},
                 {"landmarks", made.landmarks.size()}};
    json["label_voxels"] = Json::object();
    for (std::size_t n = 0; n < made.label_voxels.size(); ++n)
        json["label_voxels"][std::string(name_of(TruthLabel(n)))] = made.label_voxels[n];
    json["fixed_voxels"] = counts_json(made.fixed_voxels);
    json["moving_voxels"] = counts_json(made.moving_voxels);
    json["motions"] = Json::array();
    for (const TruthMotion& motion : made.motions)
        json["motions"].push_back({{"kind", name_of(motion.kind)},
                                   {"point_mm", json_of(motion.point_mm)},
                                   {"motion_mm", json_of(motion.motion_mm)},
                                   {"normal", json_of(motion.normal)},
                                   {"radius_mm", motion.radius_mm},
                                   {"length_mm", motion.length_mm},
                                   {"depth_mm", motion.depth_mm},
                                   {"fraction", motion.fraction},
                                   {"moved_elements", motion.moved_elements}});
    json["settings"] = Json::object();
    for (const NamedValue& named : record_of(settings, truth_rows()))
        std::visit(
            [&](const auto& value) {
                if constexpr (std::is_arithmetic_v<std::decay_t<decltype(value)>> ||
                              std::is_same_v<std::decay_t<decltype(value)>, std::string>)
                    json["settings"][named.name] = value;
            },
            named.value);
    return json;
}

Status write_truth_case(const TruthCase& made, const Json& record, const fs::path& folder,
                        const std::string& ending, Encoding encoding, const TaskArena& arena) {
    const auto file = [&](const char* name) { return folder / (name + ending); };
    // The largest first.
    const std::function<Status()> parts[] = {
        [&] { return write_vector_field(file("forward"), made.forward, encoding); },
        [&] { return write_vector_field(file("inverse"), made.inverse, encoding); },
        [&] { return write_volume(file("moving"), made.moving, encoding); },
        [&] { return write_volume(file("labels"), made.labels); },
        [&] { return write_volume(file("fixed_mask"), made.fixed_mask); },
        [&] { return write_volume(file("moving_mask"), made.moving_mask); },
        [&] { return write_text(folder / "landmarks.csv", landmark_text(made)); },
        [&] { return write_text(folder / "case.json", record.dump(2) + "\n"); }};
    std::vector<Status> done(std::size(parts), Ok{});
    arena.for_each(std::int64_t(std::size(parts)), 1, [&](std::int64_t begin, std::int64_t end) {
        for (; begin < end; ++begin) done[std::size_t(begin)] = parts[begin]();
    });
    for (const Status& status : done)
        if (!status.ok()) return status;
    return Ok{};
}

Result<TruthIndex> read_truth_index(const fs::path& folder) {
    const fs::path path = folder / "truth.json";
    const auto text = read_small_file(path, kMaxJsonBytes, "a data set of pliant truth make");
    if (!text.ok()) return text.error();
    if (const Status s = check_nesting(*text, TextSyntax::Json); !s.ok())
        return wrong_file(path, s.error().message);
    TruthIndex index;
    index.json = Json::parse(*text, nullptr, false);
    if (!index.json.is_object()) return wrong_file(path, "is no JSON object");
    const auto format = index.json.find("format");
    if (format == index.json.end() || (*format != "nrrd" && *format != "nifti"))
        return wrong_file(path, "format: expected \"nrrd\" or \"nifti\"");
    index.ending = *format == "nrrd" ? ".nrrd" : ".nii.gz";
    const auto cases = index.json.find("cases");
    if (cases == index.json.end() || !cases->is_array() || cases->empty())
        return wrong_file(path, "cases: expected a list with a case or more");
    for (const Json& one : *cases) {
        const auto name = one.is_object() ? one.find("folder") : one.end();
        if (!one.is_object() || name == one.end() || !name->is_string())
            return wrong_file(path, "cases: expected objects with a folder");
        index.cases.push_back(name->get<std::string>());
        const fs::path plain = fs::path(index.cases.back());
        if (plain.has_parent_path() || plain == ".." || plain.empty())
            return wrong_file(path, "cases: folder: expected the name of a folder beside it");
    }
    return index;
}

Result<TruthData> read_truth_data(const fs::path& folder, const std::string& ending) {
    TruthData data;
    auto forward = read_vector_field(folder / ("forward" + ending));
    if (!forward.ok()) return forward.error();
    data.forward = std::move(*forward);
    for (const auto& [name, to] :
         {std::pair{"labels", &data.labels}, std::pair{"fixed_mask", &data.fixed_mask}}) {
        auto volume = read_volume(folder / (name + ending));
        if (!volume.ok()) return volume.error();
        // Rounded to 32-bit floats in NIfTI, alike in all files.
        *to = std::move(*volume);
    }
    const fs::path path = folder / "landmarks.csv";
    const auto text = read_small_file(path, kMaxJsonBytes, "landmarks");
    if (!text.ok()) return text.error();
    std::istringstream lines(*text);
    std::string line;
    for (int number = 1; std::getline(lines, line); ++number) {
        if (number == 1 || line.empty()) continue;
        const std::vector<double> n = numbers_in(line);
        TruthLandmark landmark;
        const std::string type = line.substr(line.rfind(',') + 1);
        int found = -1;
        for (int label = 0; label < kTruthLabels; ++label)
            if (type == name_of(TruthLabel(label))) found = label;
        if (n.size() != 6 || found < 0)
            return wrong_file(path, "line " + std::to_string(number) +
                                        ": expected six numbers and a type, found " + shown(line));
        landmark.fixed_mm = {n[0], n[1], n[2]};
        landmark.moving_mm = {n[3], n[4], n[5]};
        landmark.label = TruthLabel(found);
        data.landmarks.push_back(landmark);
    }
    return data;
}

Result<std::vector<Vec3d>> read_points(const fs::path& path) {
    const auto text = read_small_file(path, kMaxJsonBytes, "points");
    if (!text.ok()) return text.error();
    std::vector<Vec3d> points;
    std::istringstream lines(*text);
    std::string line;
    for (int number = 1; std::getline(lines, line); ++number) {
        while (!line.empty() && (line.back() == '\r' || line.back() == ' ')) line.pop_back();
        if (line.empty() || line[0] == '#' || std::isalpha(static_cast<unsigned char>(line[0])))
            continue;
        const std::vector<double> n = numbers_in(line);
        if (n.size() != 3 && n.size() != 6)
            return wrong_file(path, "line " + std::to_string(number) +
                                        ": expected three numbers x, y, z, or six, found " +
                                        shown(line));
        points.push_back({n[n.size() - 3], n[n.size() - 2], n[n.size() - 1]});
    }
    return points;
}

}  // namespace pliant::app
