// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The file of an identified network. Its numbers are columns: one array per property, in the order
// of the nodes, links or cells, since objects per link would be ten times as long.

#include <pliant/core/output_file.h>
#include <pliant/models/network_file.h>
#include <pliant/models/scene_files.h>

#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "base/errors.h"

namespace pliant {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kFormat = "pliant spring network";
constexpr int kVersion = 1;
constexpr std::size_t kMaxNodes = 1'000'000, kMaxLinks = 10'000'000, kMaxGroups = 1000;
constexpr std::size_t kMaxNameBytes = 200;
constexpr double kMaxCoordinate_mm = 1e5, kMaxNumber = 1e30;
// Columns of links; a file without branches has neither.
constexpr const char *kBranchStiffness = "branch_stiffness_mn_m", *kBranchTime = "branch_time_s";

std::string found_text(const Json& json) {
    // Only scalars: the text of a long array would be long.
    if (json.is_null()) return "none";
    if (json.is_structured()) return json.is_array() ? "an array" : "an object";
    return shown(json.dump(-1, ' ', false, Json::error_handler_t::replace));
}

/// Reads the columns of one table. Keeps the first fault; later values are then empty.
class Table {
  public:
    Table(const Json& file, const char* name, std::size_t max_rows)
        : m_table(member(file, name)), m_name(name), m_max_rows(max_rows) {}

    const std::string& fault() const { return m_fault; }
    bool has(const char* key) const { return m_table.is_object() && m_table.contains(key); }

    void fail(const std::string& key, const std::string& expected, const std::string& found) {
        if (m_fault.empty())
            m_fault = m_name + "." + key + ": expected " + expected + ", found " + found;
    }
    /// @param rows  expected number; no value: any up to the maximum
    std::vector<double> numbers(const char* key, std::optional<std::size_t> rows, double low,
                                double high) {
        std::vector<double> numbers;
        const Json* const array = column(key, rows);
        for (std::size_t n = 0; array && n < array->size(); ++n) {
            const Json& json = (*array)[n];
            const double x = json.is_number() ? json.get<double>() : std::nan("");
            if (!(x >= low && x <= high)) {
                fail(key, low == 0 ? "numbers of 0 or more" : "numbers", found_text(json));
                return {};
            }
            numbers.push_back(x);
        }
        return numbers;
    }
    std::vector<std::int32_t> indices(const char* key, std::optional<std::size_t> rows,
                                      std::int64_t low, std::size_t count) {
        std::vector<std::int32_t> indices;
        const Json* const array = column(key, rows);
        for (std::size_t n = 0; array && n < array->size(); ++n) {
            const auto index = index_of((*array)[n], key, low, count);
            if (!index) return {};
            indices.push_back(*index);
        }
        return indices;
    }
    std::vector<Vec3d> points(const char* key) {
        std::vector<Vec3d> points;
        const Json* const array = column(key, {});
        for (std::size_t n = 0; array && n < array->size(); ++n) {
            const Json& row = (*array)[n];
            Vec3d p{0, 0, 0};
            bool is_good = row.is_array() && row.size() == 3;
            for (int a = 0; is_good && a < 3; ++a) {
                const Json& x = row[std::size_t(a)];
                is_good = x.is_number() && std::abs(x.get<double>()) <= kMaxCoordinate_mm;
                if (is_good) p[a] = x.get<double>();
            }
            if (!is_good) {
                fail(key, "three numbers within 100000 for node " + std::to_string(n),
                     found_text(row));
                return {};
            }
            points.push_back(p);
        }
        return points;
    }
    /// Lists of node numbers. @param counts  permitted lengths
    std::vector<std::vector<std::int32_t>> lists(const char* key, std::array<std::size_t, 2> counts,
                                                 std::size_t nodes) {
        std::vector<std::vector<std::int32_t>> lists;
        const Json* const array = column(key, {});
        for (std::size_t n = 0; array && n < array->size(); ++n) {
            const Json& row = (*array)[n];
            if (!row.is_array() || (row.size() != counts[0] && row.size() != counts[1])) {
                fail(key, "lists of node numbers", found_text(row));
                return {};
            }
            auto& list = lists.emplace_back();
            for (const Json& number : row) {
                const auto index = index_of(number, key, 0, nodes);
                if (!index) return {};
                list.push_back(*index);
            }
        }
        return lists;
    }

  private:
    static const Json& member(const Json& file, const char* name) {
        static const Json kNone;
        const auto found = file.find(name);
        return found == file.end() ? kNone : *found;
    }
    const Json* column(const char* key, std::optional<std::size_t> rows) {
        if (!m_fault.empty()) return nullptr;
        const Json* found = nullptr;
        if (m_table.is_object())
            if (const auto at = m_table.find(key); at != m_table.end()) found = &*at;
        if (!found || !found->is_array()) {
            fail(key, "an array", found ? found_text(*found) : "none");
            return nullptr;
        }
        if (rows ? found->size() != *rows : found->size() > m_max_rows) {
            fail(key, (rows ? "" : "up to ") + std::to_string(rows.value_or(m_max_rows)) + " rows",
                 std::to_string(found->size()));
            return nullptr;
        }
        return found;
    }
    std::optional<std::int32_t> index_of(const Json& json, const char* key, std::int64_t low,
                                         std::size_t count) {
        if (json.is_number_integer()) {
            const auto index = json.get<std::int64_t>();
            if (index >= low && index < std::int64_t(count)) return std::int32_t(index);
        }
        fail(key, "whole numbers from " + std::to_string(low) + " below " + std::to_string(count),
             found_text(json));
        return {};
    }

    const Json& m_table;
    std::string m_name, m_fault;
    std::size_t m_max_rows;
};

std::optional<std::string> text_at(const Json& object, const char* key) {
    const auto found = object.find(key);
    if (found == object.end()) return std::string();
    if (!found->is_string()) return {};
    auto text = found->get<std::string>();
    if (text.size() > kMaxNameBytes) return {};
    return printable(text);
}

std::optional<double> number_at(const Json& object, const char* key) {
    const auto found = object.find(key);
    if (found == object.end()) return 0;
    if (!found->is_number() || !(std::abs(found->get<double>()) <= kMaxNumber)) return {};
    return found->get<double>();
}

/// @returns the fault; empty: none
std::string read_groups(const Json& file, std::vector<NetworkGroup>& groups) {
    const auto found = file.find("groups");
    if (found == file.end()) return {};
    if (!found->is_array() || found->size() > kMaxGroups)
        return "groups: expected an array of up to 1000, found " +
               (found->is_array() ? std::to_string(found->size()) : found_text(*found));
    for (std::size_t g = 0; g < found->size(); ++g) {
        const Json& json = (*found)[g];
        const auto fault = [&](const char* key) {
            return "groups[" + std::to_string(g) + "]." + key +
                   ": expected a name of up to 200 bytes, or a finite number";
        };
        if (!json.is_object())
            return "groups[" + std::to_string(g) + "]: expected an object, found " +
                   found_text(json);
        NetworkGroup group;
        for (const auto& [key, member] :
             {std::pair{"name", &NetworkGroup::name}, std::pair{"unit", &NetworkGroup::unit},
              std::pair{"note", &NetworkGroup::note}}) {
            auto text = text_at(json, key);
            if (!text) return fault(key);
            group.*member = std::move(*text);
        }
        for (const auto& [key, member] :
             {std::pair{"value", &NetworkGroup::value}, std::pair{"low", &NetworkGroup::low},
              std::pair{"high", &NetworkGroup::high}}) {
            const auto number = number_at(json, key);
            if (!number) return fault(key);
            group.*member = *number;
        }
        groups.push_back(std::move(group));
    }
    return {};
}

/// @returns the fault; empty: none
std::string read_nodes(Table table, NetworkFile& network) {
    const auto positions = table.points("position_mm");
    const auto masses = table.numbers("mass_g", positions.size(), 0, kMaxNumber);
    const auto damping = table.numbers("damping_g_s", positions.size(), 0, kMaxNumber);
    const auto fixed = table.indices("fixed", {}, 0, positions.size());
    network.node_groups = table.indices("group", positions.size(), -1, network.groups.size());
    if (!table.fault().empty()) return table.fault();
    for (std::size_t n = 0; n < positions.size(); ++n)
        network.parts.nodes.push_back(
            {.rest = positions[n], .mass = masses[n], .damping = damping[n]});
    for (const std::int32_t n : fixed) network.parts.nodes[std::size_t(n)].fixed = true;
    return {};
}

std::string read_links(Table table, NetworkFile& network) {
    const auto ends = table.lists("nodes", {2, 2}, network.parts.nodes.size());
    const auto stiffness = table.numbers("stiffness_mn_m", ends.size(), 0, kMaxNumber);
    const auto damping = table.numbers("damping_g_s", ends.size(), 0, kMaxNumber);
    const auto lengths = table.numbers("rest_length_mm", ends.size(), 0, kMaxNumber);
    network.link_groups = table.indices("group", ends.size(), -1, network.groups.size());
    const bool has_branches = table.has(kBranchStiffness) || table.has(kBranchTime);
    std::vector<double> branches(ends.size(), 0.0), times = branches;
    if (has_branches) {
        branches = table.numbers(kBranchStiffness, ends.size(), 0, kMaxNumber);
        times = table.numbers(kBranchTime, ends.size(), 0, kMaxNumber);
    }
    if (!table.fault().empty()) return table.fault();
    for (std::size_t l = 0; l < ends.size(); ++l)
        network.parts.links.push_back({.a = ends[l][0],
                                       .b = ends[l][1],
                                       .stiffness = stiffness[l],
                                       .damping = damping[l],
                                       .rest_length = lengths[l],
                                       .branch_stiffness = branches[l],
                                       .branch_time = times[l]});
    return {};
}

std::string read_cells(Table table, NetworkFile& network) {
    const auto corners = table.lists("nodes", {4, 8}, network.parts.nodes.size());
    const auto bulk = table.numbers("bulk_pa", corners.size(), 0, kMaxNumber);
    network.cell_groups = table.indices("group", corners.size(), -1, network.groups.size());
    if (!table.fault().empty()) return table.fault();
    for (std::size_t c = 0; c < corners.size(); ++c) {
        SpringCell cell{.node_count = std::int32_t(corners[c].size()), .bulk = bulk[c]};
        std::copy(corners[c].begin(), corners[c].end(), cell.nodes.begin());
        network.parts.cells.push_back(cell);
    }
    return {};
}

/// @returns NotFound or Unreadable, without the file's name, for a fault of the contents
Result<NetworkFile> parse(const std::string& text) {
    const auto wrong = [](std::string what) {
        return Error{ErrorCode::Unreadable, std::move(what)};
    };
    if (const Status s = check_nesting(text, TextSyntax::Json); !s.ok()) return s.error();
    const Json file = Json::parse(text.begin(), text.end(), nullptr, false);
    if (!file.is_object()) return wrong("expected a JSON object, found something else");
    if (const auto format = file.find("format"); format == file.end() || *format != kFormat)
        return wrong(std::string("format: expected \"") + kFormat + "\", found " +
                     (format == file.end() ? "none" : found_text(*format)));
    const auto version = file.find("version");
    if (version == file.end() || *version != kVersion)
        return Error{ErrorCode::Unsupported,
                     "version: expected 1, found " +
                         (version == file.end() ? "none" : found_text(*version))};
    NetworkFile network;
    const auto mesh = text_at(file, "mesh");
    if (!mesh) return wrong("mesh: expected a name of up to 200 bytes");
    network.mesh = *mesh;
    std::string fault = read_groups(file, network.groups);
    if (fault.empty()) fault = read_nodes(Table(file, "nodes", kMaxNodes), network);
    if (fault.empty()) fault = read_links(Table(file, "links", kMaxLinks), network);
    if (fault.empty()) fault = read_cells(Table(file, "cells", kMaxLinks), network);
    if (!fault.empty()) return wrong(std::move(fault));
    const auto made = SpringNetwork::create(network.parts);
    if (!made.ok()) return wrong(made.error().message);
    return network;
}

Json columns_of_nodes(const NetworkFile& network) {
    Json positions = Json::array(), masses = Json::array(), damping = Json::array(),
         fixed = Json::array();
    for (std::size_t n = 0; n < network.parts.nodes.size(); ++n) {
        const SpringNode& node = network.parts.nodes[n];
        positions.push_back({node.rest.x, node.rest.y, node.rest.z});
        masses.push_back(node.mass);
        damping.push_back(node.damping);
        if (node.fixed) fixed.push_back(n);
    }
    return {{"position_mm", std::move(positions)},
            {"mass_g", std::move(masses)},
            {"damping_g_s", std::move(damping)},
            {"fixed", std::move(fixed)},
            {"group", network.node_groups}};
}

Json columns_of_links(const NetworkFile& network) {
    Json ends = Json::array(), stiffness = Json::array(), damping = Json::array(),
         lengths = Json::array(), branches = Json::array(), times = Json::array();
    bool has_branches = false;
    for (const SpringLink& link : network.parts.links) {
        ends.push_back({link.a, link.b});
        stiffness.push_back(link.stiffness);
        damping.push_back(link.damping);
        lengths.push_back(link.rest_length);
        branches.push_back(link.branch_stiffness);
        times.push_back(link.branch_stiffness > 0 ? link.branch_time : 0);
        has_branches |= link.branch_stiffness != 0;
    }
    Json columns = {{"nodes", std::move(ends)},
                    {"stiffness_mn_m", std::move(stiffness)},
                    {"damping_g_s", std::move(damping)},
                    {"rest_length_mm", std::move(lengths)},
                    {"group", network.link_groups}};
    if (has_branches) {
        columns[kBranchStiffness] = std::move(branches);
        columns[kBranchTime] = std::move(times);
    }
    return columns;
}

Json columns_of_cells(const NetworkFile& network) {
    Json corners = Json::array(), bulk = Json::array();
    for (const SpringCell& cell : network.parts.cells) {
        Json list = Json::array();
        for (int n = 0; n < cell.node_count; ++n) list.push_back(cell.nodes[std::size_t(n)]);
        corners.push_back(std::move(list));
        bulk.push_back(cell.bulk);
    }
    return {{"nodes", std::move(corners)},
            {"bulk_pa", std::move(bulk)},
            {"group", network.cell_groups}};
}

std::string text_of(const NetworkFile& network) {
    Json groups = Json::array();
    for (const NetworkGroup& g : network.groups) {
        Json group = {{"name", g.name}, {"value", g.value}, {"unit", g.unit}};
        if (g.low != 0 || g.high != 0) {
            group["low"] = g.low;
            group["high"] = g.high;
        }
        if (!g.note.empty()) group["note"] = g.note;
        groups.push_back(std::move(group));
    }
    Json file = {{"format", kFormat}, {"version", kVersion}, {"mesh", network.mesh}};
    file["groups"] = std::move(groups);
    // A line per column.
    std::string text = file.dump(1, ' ', false, Json::error_handler_t::replace);
    text.resize(text.rfind('\n'));
    for (const auto& [name, columns] : {std::pair{"nodes", columns_of_nodes(network)},
                                        std::pair{"links", columns_of_links(network)},
                                        std::pair{"cells", columns_of_cells(network)}}) {
        text += ",\n \"" + std::string(name) + "\": {";
        const char* comma = "\n  \"";
        for (const auto& [key, column] : columns.items()) {
            text += comma + key + "\": " + column.dump();
            comma = ",\n  \"";
        }
        text += "\n }";
    }
    return text + "\n}\n";
}

/// Checks the lists of groups, and fills in empty ones.
Status complete(NetworkFile& network) {
    const auto list = [&](const char* name, std::vector<std::int32_t>& groups,
                          std::size_t count) -> Status {
        if (groups.empty()) groups.assign(count, -1);
        if (groups.size() != count)
            return expected_error(name, std::to_string(count) + " numbers",
                                  std::to_string(groups.size()));
        for (const std::int32_t g : groups)
            if (g < -1 || g >= std::int32_t(network.groups.size()))
                return expected_error(name, "groups below " + std::to_string(network.groups.size()),
                                      std::to_string(g));
        return Ok{};
    };
    const SpringParts& parts = network.parts;
    if (parts.nodes.size() > kMaxNodes)
        return expected_error("nodes", "up to " + std::to_string(kMaxNodes),
                              std::to_string(parts.nodes.size()));
    for (const Status& s : {list("link_groups", network.link_groups, parts.links.size()),
                            list("cell_groups", network.cell_groups, parts.cells.size()),
                            list("node_groups", network.node_groups, parts.nodes.size())})
        if (!s.ok()) return s;
    for (const NetworkGroup& g : network.groups)
        for (const double number : {g.value, g.low, g.high})
            if (!(std::abs(number) <= kMaxNumber))
                return expected_error("groups", "finite numbers", g.name);
    return Ok{};
}

}  // namespace

Result<NetworkFile> read_network(const std::filesystem::path& path) noexcept {
    return attempt([&]() -> Result<NetworkFile> {
        const auto text = read_small_file(path, kMaxNetworkBytes, "a network of pliant fit");
        if (!text.ok()) return text.error();
        auto network = parse(*text);
        if (!network.ok())
            return Error{network.error().code,
                         path.string() + ": " + one_line(network.error().message)};
        return network;
    });
}

Status write_network(const std::filesystem::path& path, const NetworkFile& network) noexcept {
    return attempt([&]() -> Status {
        NetworkFile whole = network;
        if (const Status s = complete(whole); !s.ok()) return s;
        const auto made = SpringNetwork::create(whole.parts);
        if (!made.ok()) return made.error();
        whole.parts.links.assign(made->links().begin(), made->links().end());
        const std::string text = text_of(whole);
        if (text.size() > kMaxNetworkBytes)
            return expected_error("network", "a file of up to 64 MiB",
                                  std::to_string(text.size()) + " bytes", ErrorCode::LimitExceeded);
        StagedFiles files;
        const auto staged = files.stage(path);
        if (!staged.ok()) return staged.error();
        OutputFile file(*staged, path.string());
        file.write(text);
        if (const Status s = file.close(); !s.ok()) return s;
        return files.commit();
    });
}

}  // namespace pliant
