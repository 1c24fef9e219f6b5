// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "fit_mesh_input.h"

#include <pliant/core/files.h>
#include <pliant/mesh_files.h>
#include <pliant/scan_files.h>
#include <pliant/volume.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <map>
#include <optional>
#include <string_view>
#include <utility>

#include "fit_report.h"

namespace pliant::app {
namespace {

constexpr std::size_t kMaxRegions = 64;
constexpr const char* kPlace = "X,Y,Z:X,Y,Z or NAME=VALUE";

struct ReadMesh {
    TetMesh mesh;
    MeshData data;                        ///< empty for a filled surface
    std::vector<std::int32_t> file_node;  ///< [node]: number in the file
    std::vector<std::int32_t> node_of;    ///< [node of the file]: number, −1 if unused
};

Error of_option(const char* option, const Error& error) {
    return {error.code, option + std::string(": ") + error.message};
}

Result<ReadMesh> read_organ(const FitOptions& o, const TaskArena& arena) {
    auto data = read_mesh(o.mesh, mm_of_unit(o.units));
    if (!data) return of_option("--mesh", data.error());
    const auto named = [&](const Error& error) {
        return Error{error.code, "--mesh: " + o.mesh + ": " + error.message};
    };
    ReadMesh read;
    if (data->tetrahedra.empty()) {
        if (data->triangles.empty())
            return named({ErrorCode::Unsupported,
                          "found neither tetrahedra nor triangles, expected an organ"});
        auto filled = fill_surface(cleaned({data->nodes_mm, data->triangles}),
                                   {.tetrahedra = o.tetrahedra}, arena);
        if (!filled) return named(filled.error());
        read.mesh = std::move(filled->mesh);
        return read;
    }
    read.data = std::move(*data);
    std::vector<std::int32_t>& node_of = read.node_of;
    node_of.assign(read.data.nodes_mm.size(), -1);
    for (const auto& cell : read.data.tetrahedra)
        for (const std::int32_t n : cell) node_of[std::size_t(n)] = 0;
    for (std::size_t n = 0; n < node_of.size(); ++n) {
        if (node_of[n] < 0) continue;
        node_of[n] = std::int32_t(read.mesh.nodes_mm.size());
        read.mesh.nodes_mm.push_back(read.data.nodes_mm[n]);
        read.file_node.push_back(std::int32_t(n));
    }
    for (auto cell : read.data.tetrahedra) {
        for (std::int32_t& n : cell) n = node_of[std::size_t(n)];
        read.mesh.cells.push_back(cell);
    }
    if (const Status s = check_mesh(read.mesh); !s.ok()) return named(s.error());
    return read;
}

std::vector<std::string> split_at(const std::string& text, char separator) {
    std::vector<std::string> parts{""};
    for (const char c : text)
        if (c == separator)
            parts.emplace_back();
        else
            parts.back() += c;
    return parts;
}

std::optional<Vec3d> vector_of(const std::string& text) {
    const auto numbers = numbers_of(text);
    if (numbers.size() != 3) return {};
    const Vec3d v{numbers[0], numbers[1], numbers[2]};
    if (!is_finite(v)) return {};
    return v;
}

/// Nodes with a value in an array of the file, or of tetrahedra with it.
Result<std::vector<std::int32_t>> labelled_nodes(const ReadMesh& read, const std::string& place,
                                                 const char* option) {
    const auto equals = place.find('=');
    const std::string name = place.substr(0, equals);
    const auto value = numbers_of(place.substr(equals + 1));
    if (value.size() != 1) return bad_option(option, kPlace, place);
    std::vector<std::int32_t> nodes;
    if (const auto* field = read.data.field(name); field && field->components == 1) {
        for (std::size_t n = 0; n < read.file_node.size(); ++n)
            if (field->values[std::size_t(read.file_node[n])] == value[0])
                nodes.push_back(std::int32_t(n));
        return nodes;
    }
    const auto* field = read.data.tetrahedron_field(name);
    if (!field) return bad_option(option, "an array of numbers in the mesh's file", name);
    for (std::size_t t = 0; t < read.mesh.cells.size(); ++t)
        if (field->values[t] == value[0])
            nodes.insert(nodes.end(), read.mesh.cells[t].begin(), read.mesh.cells[t].end());
    std::sort(nodes.begin(), nodes.end());
    nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
    return nodes;
}

/// Nodes in a box, or with a value. @param place  X,Y,Z:X,Y,Z or NAME=VALUE
Result<std::vector<std::int32_t>> nodes_at(const ReadMesh& read, const std::string& place,
                                           const char* option) {
    std::vector<std::int32_t> nodes;
    if (place.find('=') != place.npos) {
        auto labelled = labelled_nodes(read, place, option);
        if (!labelled) return labelled.error();
        nodes = std::move(*labelled);
    } else {
        const auto corners = split_at(place, ':');
        const auto one = vector_of(corners[0]);
        const auto other = corners.size() == 2 ? vector_of(corners[1]) : std::nullopt;
        if (!one || !other) return bad_option(option, kPlace, place);
        for (std::size_t n = 0; n < read.mesh.nodes_mm.size(); ++n) {
            bool is_in = true;
            for (int a = 0; a < 3; ++a) {
                const double x = read.mesh.nodes_mm[n][a];
                is_in &=
                    x >= std::min((*one)[a], (*other)[a]) && x <= std::max((*one)[a], (*other)[a]);
            }
            if (is_in) nodes.push_back(std::int32_t(n));
        }
    }
    if (nodes.empty()) return bad_option(option, "a place with nodes of the mesh", place);
    return nodes;
}

/// Label of each tetrahedron from a volume: that of the voxel at its centre. Background takes the
/// label of a neighbour, since a surface is half a voxel beside its labels.
Result<std::vector<int>> labels_of_volume(const std::string& file, const TetMesh& mesh) {
    const auto volume = read_labels(file);
    if (!volume.ok()) return of_option("--labels", volume.error());
    std::vector<int> labels;
    for (const auto& cell : mesh.cells) {
        Vec3d centre{0, 0, 0};
        for (const std::int32_t n : cell) centre = centre + 0.25 * mesh.nodes_mm[std::size_t(n)];
        const Vec3d ijk = voxel_from_world(volume->grid, centre);
        Vec3i nearest{0, 0, 0};
        bool is_in = true;
        for (int a = 0; a < 3; ++a) {
            is_in &= ijk[a] > -0.5 && ijk[a] < volume->grid.size[a] - 0.5;
            if (is_in) nearest[a] = int(std::lround(ijk[a]));
        }
        labels.push_back(is_in ? int(std::lround(double(volume->at(nearest)))) : 0);
    }
    std::map<std::array<std::int32_t, 3>, std::vector<std::size_t>> sides;
    for (std::size_t t = 0; t < mesh.cells.size(); ++t)
        for (std::size_t skip = 0; skip < 4; ++skip) {
            std::array<std::int32_t, 3> side{};
            for (std::size_t n = 0, k = 0; n < 4; ++n)
                if (n != skip) side[k++] = mesh.cells[t][n];
            std::sort(side.begin(), side.end());
            sides[side].push_back(t);
        }
    for (bool again = true; again;) {
        again = false;
        std::vector<int> next = labels;
        for (const auto& [side, cells] : sides)
            for (std::size_t k = 0; cells.size() == 2 && k < 2; ++k)
                if (labels[cells[k]] == 0 && labels[cells[1 - k]] > next[cells[k]]) {
                    next[cells[k]] = labels[cells[1 - k]];
                    again = true;
                }
        labels.swap(next);
    }
    return labels;
}

Result<std::vector<int>> labels_of_array(const std::string& name, const ReadMesh& read) {
    std::vector<double> values;
    if (const auto* cells = read.data.tetrahedron_field(name)) {
        values = cells->values;
    } else if (const auto* nodes = read.data.field(name); nodes && nodes->components == 1) {
        // The largest of the corners: a border belongs to the structure with the higher label.
        for (const auto& cell : read.data.tetrahedra) {
            double largest = nodes->values[std::size_t(cell[0])];
            for (const std::int32_t n : cell)
                largest = std::max(largest, nodes->values[std::size_t(n)]);
            values.push_back(largest);
        }
    } else {
        return bad_option("--regions", "an array of numbers in the mesh's file", name);
    }
    std::vector<int> labels;
    for (const double value : values) {
        if (!(std::abs(value) <= 1e6) || value != std::floor(value))
            return bad_option("--regions", "an array of whole numbers", name);
        labels.push_back(int(value));
    }
    return labels;
}

/// The regions and their materials.
Status set_regions(const FitOptions& o, const ReadMesh& read, FitMeshInput& input) {
    FitMesh& fit = input.fit;
    const FitRegion common{.young_modulus_pa = o.young_pa.value_or(FitRegion{}.young_modulus_pa),
                           .poisson_ratio = o.poisson};
    if (!o.regions.empty() && !o.labels.empty())
        return bad_option("--labels", "either --regions or --labels", o.labels);
    if (o.regions.empty() && o.labels.empty()) {
        if (!o.materials.empty())
            return bad_option("--material", "--regions or --labels too", o.materials[0]);
        fit.regions = {common};
        return Ok{};
    }
    auto labels =
        o.labels.empty() ? labels_of_array(o.regions, read) : labels_of_volume(o.labels, read.mesh);
    if (!labels) return labels.error();
    input.labels = *labels;
    std::sort(input.labels.begin(), input.labels.end());
    input.labels.erase(std::unique(input.labels.begin(), input.labels.end()), input.labels.end());
    if (input.labels.size() > kMaxRegions)
        return bad_option(o.labels.empty() ? "--regions" : "--labels",
                          "up to " + std::to_string(kMaxRegions) + " different values",
                          std::to_string(input.labels.size()));
    const auto region_of = [&](int label) {
        const auto at = std::lower_bound(input.labels.begin(), input.labels.end(), label);
        return std::int32_t(at - input.labels.begin());
    };
    for (const int label : *labels) fit.region_of.push_back(region_of(label));
    fit.regions.clear();
    for (const int label : input.labels) {
        fit.regions.push_back(common);
        fit.regions.back().name = std::to_string(label);
    }
    for (const std::string& text : o.materials) {
        const auto parts = split_at(text, ':');
        const auto label = numbers_of(parts[0]);
        const auto numbers = parts.size() == 2 ? numbers_of(parts[1]) : std::vector<double>{};
        if (label.size() != 1 || numbers.empty() || numbers.size() > 2)
            return bad_option("--material", "LABEL:YOUNG[,POISSON]", text);
        const auto region = std::find_if(fit.regions.begin(), fit.regions.end(), [&](auto& r) {
            return r.name == std::to_string(std::lround(label[0]));
        });
        if (region == fit.regions.end())
            return bad_option("--material", "a label of the mesh", text);
        region->young_modulus_pa = numbers[0];
        if (numbers.size() > 1) region->poisson_ratio = numbers[1];
    }
    return Ok{};
}

/// Lines of numbers. Empty ones, and headings that begin with a letter or #, are left out.
Result<std::vector<std::vector<double>>> read_rows(const std::string& file) {
    const auto text = read_small_file(file, kMaxSmallFileBytes, "a table of numbers (CSV)");
    if (!text) return text.error();
    std::vector<std::vector<double>> rows;
    std::string_view rest = *text;
    for (std::size_t line = 1; !rest.empty(); ++line) {
        const auto end = std::min(rest.find('\n'), rest.size());
        std::string row;
        for (const char c : rest.substr(0, end))
            if (c != ' ' && c != '\t' && c != '\r') row += c == ';' ? ',' : c;
        rest.remove_prefix(std::min(end + 1, rest.size()));
        if (row.empty() || row[0] == '#' || (row[0] >= 'A' && row[0] <= 'Z') ||
            (row[0] >= 'a' && row[0] <= 'z'))
            continue;
        rows.push_back(numbers_of(row));
        const bool is_good = !rows.back().empty() &&
                             std::all_of(rows.back().begin(), rows.back().end(),
                                         [](double x) { return std::isfinite(x); }) &&
                             rows.back().size() == rows[0].size();
        if (!is_good)
            return Error{ErrorCode::Unreadable, file + ": line " + std::to_string(line) +
                                                    ": expected finite numbers between commas, as "
                                                    "many as in the first, found '" +
                                                    shown(row) + "'"};
    }
    if (rows.empty())
        return Error{ErrorCode::Unreadable, file + ": expected lines of numbers, found none"};
    return rows;
}

Result<std::int32_t> node_in(double number, std::size_t count, const std::string& file) {
    if (!(number >= 0 && number < double(count)) || number != std::floor(number))
        return Error{ErrorCode::Unreadable, file + ": expected nodes below " +
                                                std::to_string(count) + ", found " +
                                                std::to_string(number)};
    return std::int32_t(number);
}

/// @param target  FILE[:ARRAY]
Result<std::vector<FitMeasurement>> read_target(const std::string& target,
                                                const std::vector<Vec3d>& nodes_mm) {
    const auto dot = target.rfind(".vtu");
    if (dot == target.npos) return read_measurements(target, nodes_mm);
    const std::string file = target.substr(0, dot + 4);
    const std::string name =
        target.size() > dot + 5 ? target.substr(dot + 5) : std::string("displacement_mm");
    const auto data = read_mesh(file);
    if (!data) return data.error();
    const auto* field = data->field(name);
    if (!field || field->components != 3)
        return Error{ErrorCode::Unreadable,
                     file + ": expected an array '" + shown(name) + "' of vectors, found none"};
    std::vector<FitMeasurement> measured;
    for (std::size_t n = 0; n < data->nodes_mm.size(); ++n)
        measured.push_back(
            {data->nodes_mm[n],
             {field->values[3 * n], field->values[3 * n + 1], field->values[3 * n + 2]}});
    return measured;
}

Status set_loads(const FitOptions& o, const ReadMesh& read, FitMesh& fit) {
    for (const auto& [loads, held_out] : {std::pair(&o.loads, false), std::pair(&o.held_out, true)})
        for (const std::string& text : *loads) {
            const char* const option = held_out ? "--held-out" : "--load";
            const auto colon = text.rfind(':');
            const auto force = vector_of(text.substr(colon == text.npos ? 0 : colon + 1));
            if (colon == text.npos || !force)
                return bad_option(option, "X,Y,Z:X,Y,Z:FX,FY,FZ or NAME=VALUE:FX,FY,FZ", text);
            auto nodes = nodes_at(read, text.substr(0, colon), option);
            if (!nodes) return nodes.error();
            std::erase_if(*nodes, [&](std::int32_t n) {
                return std::binary_search(fit.held.begin(), fit.held.end(), n);
            });
            if (nodes->empty()) return bad_option(option, "nodes that aren't held", text);
            fit.loads.push_back({.name = text,
                                 .nodes = std::move(*nodes),
                                 .force_n = *force,
                                 .held_out = held_out});
        }
    if (o.loads.empty())
        return Error{ErrorCode::InvalidArgument, "--load: expected one or more, found none"};
    if (o.targets.empty()) return Ok{};
    if (o.targets.size() != fit.loads.size())
        return bad_option("--target",
                          "one for each of " + std::to_string(fit.loads.size()) + " loads",
                          std::to_string(o.targets.size()));
    for (std::size_t l = 0; l < fit.loads.size(); ++l) {
        // Node numbers are those of the mesh's file.
        auto measured = read_target(
            o.targets[l], read.data.nodes_mm.empty() ? read.mesh.nodes_mm : read.data.nodes_mm);
        if (!measured) return of_option("--target", measured.error());
        fit.loads[l].measured = std::move(*measured);
    }
    return Ok{};
}

}  // namespace

Result<std::vector<FitMeasurement>> read_measurements(const std::string& file,
                                                      const std::vector<Vec3d>& nodes_mm) {
    const auto rows = read_rows(file);
    if (!rows) return rows.error();
    const std::size_t columns = (*rows)[0].size();
    if (columns != 4 && columns != 6)
        return Error{ErrorCode::Unreadable,
                     file + ": expected the columns node,dx,dy,dz or x,y,z,dx,dy,dz, found " +
                         std::to_string(columns)};
    std::vector<FitMeasurement> measured;
    for (const auto& row : *rows) {
        FitMeasurement m;
        if (columns == 4) {
            const auto node = node_in(row[0], nodes_mm.size(), file);
            if (!node) return node.error();
            m.position_mm = nodes_mm[std::size_t(*node)];
        } else {
            m.position_mm = {row[0], row[1], row[2]};
        }
        m.displacement_mm = {row[columns - 3], row[columns - 2], row[columns - 1]};
        measured.push_back(m);
    }
    return measured;
}

Result<std::vector<CreepSample>> read_creep(const std::string& file, const FitMeshInput& input) {
    const auto rows = read_rows(file);
    if (!rows) return of_option("--creep", rows.error());
    if ((*rows)[0].size() != 5)
        return Error{ErrorCode::Unreadable,
                     "--creep: " + file + ": expected the columns time_s,node,dx,dy,dz, found " +
                         std::to_string((*rows)[0].size())};
    std::vector<CreepSample> samples;
    for (const auto& row : *rows) {
        auto node = node_in(
            row[1], input.node_of.empty() ? input.fit.mesh.nodes_mm.size() : input.node_of.size(),
            "--creep: " + file);
        if (node && !input.node_of.empty()) node = input.node_of[std::size_t(*node)];
        if (!node) return node.error();
        if (*node < 0)
            return Error{ErrorCode::Unreadable, "--creep: " + file +
                                                    ": expected nodes of tetrahedra, found " +
                                                    std::to_string(row[1])};
        samples.push_back({row[0], *node, {row[2], row[3], row[4]}});
    }
    return samples;
}

Result<FitMeshInput> read_fit_mesh(const FitOptions& o, const TaskArena& arena) {
    auto read = read_organ(o, arena);
    if (!read) return read.error();
    FitMeshInput input;
    input.name = std::filesystem::path(o.mesh).filename().string();
    FitMesh& fit = input.fit;
    if (const Status s = set_regions(o, *read, input); !s) return s.error();
    for (const std::string& place : o.hold) {
        const auto nodes = nodes_at(*read, place, "--hold");
        if (!nodes) return nodes.error();
        fit.held.insert(fit.held.end(), nodes->begin(), nodes->end());
    }
    std::sort(fit.held.begin(), fit.held.end());
    fit.held.erase(std::unique(fit.held.begin(), fit.held.end()), fit.held.end());
    if (fit.held.empty())
        return Error{ErrorCode::InvalidArgument,
                     std::string("--hold: expected ") + kPlace + ", found none"};
    if (const Status s = set_loads(o, *read, fit); !s) return s.error();
    fit.density_kg_per_m3 = o.density_kg_m3.value_or(fit.density_kg_per_m3);
    fit.volume_energy = o.volume;
    fit.range = o.range;
    fit.settings = settings_of(o);
    fit.mesh = std::move(read->mesh);
    input.node_of = std::move(read->node_of);
    return input;
}

}  // namespace pliant::app
