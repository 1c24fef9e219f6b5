// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Scene files of organs, and the scenes that follow from a mesh or from labels alone.

#include <pliant/core/files.h>
#include <pliant/models/organs.h>
#include <pliant/scan_files.h>

#include <algorithm>
#include <array>
#include <map>
#include <string>

#include "base/errors.h"
#include "base/input_file.h"
#include "base/record_toml.h"
#include "base/text.h"
#include "formats/image_file.h"

namespace pliant {
namespace {

constexpr double kHeldShare = 0.05;
constexpr std::size_t kHeaderBytes = 1024;
constexpr double kLeastOrgan_mm3 = 1000;
/// Labels whose mean value lies beyond are air, or bone.
constexpr double kLowestOrgan_hu = -300, kHighestOrgan_hu = 150;

/// Whether a legacy VTK file holds a scan. The reader of a mesh refuses a file that can't be read.
bool holds_image(const std::filesystem::path& file) {
    std::string start(kHeaderBytes, '\0');
    start.resize(InputFile(file).read(start.data(), start.size()));
    return start.find("STRUCTURED_POINTS") != std::string::npos;
}

Status check_body(const TomlTable& table, const OrganSettings& body, const OrganFile& file) {
    const std::string title = title_of(table);
    if (body.mesh.empty() && body.labels.empty())
        return expected_error(title, "a mesh, or labels of the label volume", "neither");
    if (!body.labels.empty() && file.label_volume.empty())
        return expected_error(title + " labels", "a label_volume in [organs]", "none");
    if (body.held_mm.size() % 2 != 0)
        return expected_error(title + " held_mm", "two opposite corners for each box",
                              std::to_string(body.held_mm.size()) + " points");
    return Ok{};
}

Result<OrganFile> read_scene(const std::string& name) {
    const auto content = read_small_file(name, kMaxSmallFileBytes, "a scene file");
    if (!content) return content.error();
    const auto tables = parse_toml(*content);
    if (!tables) return within(name, tables.error());
    OrganFile file;
    file.file = name;
    for (const TomlTable& table : *tables) {
        const bool is_list = table.number > 0;
        if (is_list ? table.name != "body" && table.name != "contents" : table.name != "organs")
            return within(name,
                          expected_error(title_of(table), "[organs], [[body]] and [[contents]]",
                                         "another table"));
        if (is_list) continue;
        if (const Status s = read_table(table, organ_file_rows(), file); !s)
            return within(name, s.error());
    }
    if (file.surroundings && (file.scan.empty() || file.label_volume.empty()))
        return within(name, expected_error("[organs] surroundings", "a scan and a label_volume",
                                           file.scan.empty() ? "no scan" : "no label_volume"));
    if (!file.label_names.empty() && file.label_volume.empty())
        return within(name, expected_error("[organs] label_names", "a label_volume", "none"));
    if (!file.label_volume.empty() && file.scan.empty())
        return within(name, expected_error("[organs] label_volume", "a scan beside it", "none"));
    const auto folder = std::filesystem::path(name).parent_path();
    for (const TomlTable& table : *tables) {
        if (table.name == "contents") {
            OrganContents contents;
            if (const Status s = read_table(table, organ_contents_rows(), contents); !s)
                return within(name, s.error());
            if (contents.surface.empty() || !file.scan.empty())
                return within(
                    name, expected_error(title_of(table), "a surface, in a scene without a scan",
                                         contents.surface.empty() ? "no surface" : "a scan"));
            contents.surface = (folder / contents.surface).string();
            file.contents.push_back(std::move(contents));
        }
        if (table.name != "body") continue;
        OrganSettings body;
        if (const Status s = read_table(table, organ_rows(), body); !s)
            return within(name, s.error());
        if (const Status s = check_body(table, body, file); !s) return within(name, s.error());
        if (body.name.empty() && body.labels.size() != 1)
            body.name = "body " + std::to_string(table.number);
        if (!body.mesh.empty()) body.mesh = (folder / body.mesh).string();
        file.bodies.push_back(std::move(body));
    }
    if (file.bodies.empty())
        return within(name, expected_error("[[body]]", "one or more of these tables", "none"));
    for (std::string* path : {&file.scan, &file.label_volume, &file.label_names})
        if (!path->empty()) *path = (folder / *path).string();
    return file;
}

struct LabelSum {
    double voxels = 0, values = 0;
};

Result<OrganFile> file_of_labels(const std::string& scan, const std::string& label_volume,
                                 std::vector<int> labels, const std::string& label_names,
                                 const ReadOptions& reading) {
    OrganFile file{.file = scan,
                   .scan = scan,
                   .reading = reading,
                   .label_volume = label_volume,
                   .label_names = label_names};
    file.surroundings = true;
    file.tetrahedra = 30'000;
    // Connective tissue holds organs in place. Without any of that, a pushed liver slides along its
    // surroundings into the lung, by several times the push.
    file.friction = 0.5;
    if (labels.empty()) {
        const auto values = read_volume(scan, reading);
        if (!values) return values.error();
        const auto map = read_labels(label_volume);
        if (!map) return map.error();
        const Grid& grid = map->grid;
        std::map<int, LabelSum> sums;
        for (int k = 0; k < grid.size.z; ++k)
            for (int j = 0; j < grid.size.y; ++j)
                for (int i = 0; i < grid.size.x; ++i) {
                    const auto label = int(map->at({i, j, k}));
                    if (label == 0) continue;
                    const Vec3d at = voxel_from_world(
                        values->grid, world_from_voxel(grid, {double(i), double(j), double(k)}));
                    LabelSum& sum = sums[label];
                    ++sum.voxels;
                    sum.values += double(sample_linear(*values, at));
                }
        const double voxel_mm3 = grid.spacing_mm.x * grid.spacing_mm.y * grid.spacing_mm.z;
        for (const auto& [label, sum] : sums) {
            const double mean = sum.values / sum.voxels;
            if (sum.voxels * voxel_mm3 >= kLeastOrgan_mm3 && mean > kLowestOrgan_hu &&
                mean < kHighestOrgan_hu)
                labels.push_back(label);
        }
        if (labels.empty())
            return within(label_volume,
                          expected_error("labels", "an organ of 1 ml or more, neither air nor bone",
                                         std::to_string(sums.size()) + " other labels"));
    }
    for (const int label : labels) file.bodies.push_back({.labels = {label}});
    return file;
}

}  // namespace

bool is_mesh_file(const std::filesystem::path& file) {
    std::string ending = file.extension().string();
    for (char& c : ending)
        if (c >= 'A' && c <= 'Z') c = char(c - 'A' + 'a');
    constexpr std::array kEndings = {".vtp", ".vtu", ".msh", ".stl",
                                     ".obj", ".ply", ".off", ".mesh"};
    if (ending == ".vtk") return !holds_image(file);
    return std::find(kEndings.begin(), kEndings.end(), ending) != kEndings.end();
}

Status check_mesh_or_scan(const std::filesystem::path& file) {
    if (is_mesh_file(file)) return Ok{};
    const auto type = type_of(file);
    if (!type) return type.error();
    if (*type == std::filesystem::file_type::not_found)
        return Error{ErrorCode::NotFound, file.string() + ": no such file or folder"};
    const std::string ending = lower_case(file.extension().string());
    // The numbers of a UID are no ending of a DICOM file's name.
    const bool is_name =
        std::any_of(ending.begin(), ending.end(), [](char c) { return c >= 'a' && c <= 'z'; });
    if (*type != std::filesystem::file_type::regular || !is_name || ending == ".toml" ||
        format_by_name(file))
        return Ok{};
    constexpr std::size_t kPreamble = 128;
    std::string start(kPreamble + 4, ' ');
    InputFile content(file);
    const std::size_t count = content.read(start.data(), start.size());
    if (const Status s = content.status(); !s) return s;
    constexpr std::array kDicom = {".dcm", ".dicom", ".ima", ".img"};
    if ((count == start.size() && start.ends_with("DICM")) ||
        std::find(kDicom.begin(), kDicom.end(), ending) != kDicom.end())
        return Ok{};
    return Error{
        ErrorCode::Unsupported,
        file.string() + ": '" + shown(ending) +
            "' is an ending of neither a mesh nor a scan, expected .vtp, .vtu, .vtk, .msh, "
            ".stl, .obj, .ply, .off or .mesh, or a scan"};
}

bool is_organ_file(const std::filesystem::path& file) {
    if (file.extension() != ".toml") return false;
    const auto content = read_small_file(file.string(), kMaxSmallFileBytes, "a scene file");
    if (!content) return false;
    const auto tables = parse_toml(*content);
    return tables.ok() && std::any_of(tables->begin(), tables->end(), [](const TomlTable& table) {
               return table.name == "body" || table.name == "organs";
           });
}

Result<OrganFile> read_organ_file(const std::string& file) noexcept {
    return attempt([&] {
        Result<OrganFile> read = read_scene(file);
        return read.ok() ? std::move(read) : in_one_line(read.error());
    });
}

OrganFile organ_file_of_mesh(const std::string& file) {
    OrganFile scene{.file = file};
    scene.bodies.push_back({.name = std::filesystem::path(file).stem().string(),
                            .mesh = file,
                            .held_back = kHeldShare});
    return scene;
}

Result<OrganFile> organ_file_of_labels(const std::string& scan, const std::string& label_volume,
                                       const std::vector<int>& labels,
                                       const std::string& label_names,
                                       const ReadOptions& reading) noexcept {
    return attempt(
        [&] { return file_of_labels(scan, label_volume, labels, label_names, reading); });
}

}  // namespace pliant
