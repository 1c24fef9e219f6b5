// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Gmsh's meshes, versions 1 (text), 2.2, 4.0 and 4.1 (text or binary). Nodes have file-specific
// numbers, used by cells. Sections are framed by $Name and $EndName, in version 1 by $NOD and
// $ENDNOD, $ELM and $ENDELM; other sections are skipped.

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "meshes/file_numbers.h"

namespace pliant::mesh {
namespace {

/// Supported element types: Gmsh's number, VTK's number, and numbers of nodes and of corners, which
/// are the first nodes.
constexpr struct {
    int gmsh, vtk;
    std::size_t nodes, corners;
} kTypes[] = {{1, 3, 2, 2}, {2, 5, 3, 3},  {3, 9, 4, 4},    {4, 10, 4, 4}, {8, 3, 3, 2},
              {9, 5, 6, 3}, {10, 9, 9, 4}, {11, 10, 10, 4}, {15, 1, 1, 1}, {16, 9, 8, 4}};

class Msh {
  public:
    explicit Msh(std::string_view file) : m_text(file) {}
    Result<MeshData> read();

  private:
    /// Reads a number from text or bytes; −1 if it is missing or not a whole number ≥ 0.
    std::int64_t whole(NumberType type) {
        if (!m_binary) return m_text.number<std::int64_t>().value_or(-1);
        const auto bytes = m_text.bytes(size_of(type));
        return bytes ? numbers_of<std::int64_t>(*bytes, type, m_big_endian)[0] : -1;
    }
    double real() {
        if (!m_binary) return m_text.number<double>().value_or(NAN);
        const auto bytes = m_text.bytes(8);
        return bytes ? numbers_of<double>(*bytes, NumberType::Float64, m_big_endian)[0] : NAN;
    }
    std::int64_t integer() { return whole(NumberType::Int32); }
    std::int64_t size() { return whole(NumberType::UInt64); }
    /// Whether the rest of the file can contain `count` items of `bytes` bytes (two characters in
    /// text).
    bool can_follow(std::int64_t count, std::int64_t bytes) const {
        return count >= 0 &&
               count <= std::int64_t(m_text.rest().size()) / (m_binary ? bytes : 2) + 1;
    }
    Status read_format();
    Status read_position(std::int64_t node);
    Status read_nodes_2(bool parametric);
    Status read_nodes_4();
    Status read_elements_1();
    Status read_elements_2();
    Status read_elements_4();
    void add_element(std::int64_t type, NumberType number);
    Status finish();

    TextCursor m_text;
    bool m_second_order = false;
    bool m_binary = false, m_big_endian = false, m_four = false, m_is_4_0 = false;
    std::vector<std::pair<std::int64_t, std::int64_t>> m_numbers;  ///< number in the file and
                                                                   ///< index; sorted
    std::vector<double> m_positions;
    struct Element {
        int type;
        std::array<std::int64_t, 4> nodes;
        std::size_t count;
    };
    std::vector<Element> m_elements;
};

Status Msh::read_format() {
    const std::string version(m_text.word());
    m_is_4_0 = version == "4" || version == "4.0";
    m_four = m_is_4_0 || version == "4.1";
    if (!m_four && version != "2.2" && version != "2.1" && version != "2")
        return unsupported("MSH version '" + version.substr(0, 20) + "', expected 2.2, 4.0 or 4.1");
    const auto binary = m_text.number<int>(), bytes = m_text.number<int>();
    if (!binary || !bytes || *bytes != 8) return unreadable("$MeshFormat is damaged");
    m_text.line();
    m_binary = *binary == 1;
    if (m_binary) {
        const auto one = m_text.bytes(4);
        if (!one) return unreadable("$MeshFormat is damaged");
        m_big_endian = (*one)[0] == 0;
    }
    return Ok{};
}

/// Reads a position. Stops at a missing number, so that no more nodes are stored than the file has.
Status Msh::read_position(std::int64_t node) {
    for (int a = 0; a < 3; ++a) {
        m_positions.push_back(real());
        if (!std::isfinite(m_positions.back()))
            return unreadable("node " + std::to_string(node) +
                              " has a position that is not finite");
    }
    return Ok{};
}

/// @param parametric  behind each position are the dimension and the tag of the curve or surface
///                    that the node is on, and its parameters on it
Status Msh::read_nodes_2(bool parametric) {
    const auto count = m_text.number<std::int64_t>().value_or(-1);
    m_text.line();
    if (!can_follow(count, 28)) return unreadable("$Nodes is shorter than it says");
    for (std::int64_t n = 0; n < count; ++n) {
        m_numbers.emplace_back(integer(), n);
        if (const Status s = read_position(n); !s) return s;
        if (!parametric) continue;
        const std::int64_t dimension = integer();
        integer();
        for (std::int64_t p = 0; p < dimension && dimension < 3; ++p) real();
    }
    return Ok{};
}

/// In 4.0 the minimum and maximum node numbers are missing, a block has its entity before the
/// dimension, and a node's number is a 32-bit number in front of its position.
Status Msh::read_nodes_4() {
    const std::int64_t blocks = size(), count = size();
    if (!m_is_4_0) size(), size();
    if (!can_follow(count, m_is_4_0 ? 28 : 32) || !can_follow(blocks, 20))
        return unreadable("$Nodes is shorter than it says");
    for (std::int64_t b = 0; b < blocks; ++b) {
        const std::int64_t one = integer(), other = integer();
        const std::int64_t dimension = m_is_4_0 ? other : one;
        const std::int64_t parametric = integer(), own = size();
        if (dimension < 0 || dimension > 3 || parametric < 0 ||
            !can_follow(own, m_is_4_0 ? 28 : 32))
            return unreadable("$Nodes is damaged in block " + std::to_string(b));
        const auto first = std::int64_t(m_numbers.size());
        for (std::int64_t n = 0; !m_is_4_0 && n < own; ++n)
            m_numbers.emplace_back(size(), first + n);
        for (std::int64_t n = 0; n < own; ++n) {
            if (m_is_4_0) m_numbers.emplace_back(integer(), first + n);
            if (const Status s = read_position(first + n); !s) return s;
            for (int a = 0; parametric && a < dimension; ++a) real();
        }
    }
    return Ok{};
}

const auto* find_type(std::int64_t gmsh) {
    const auto* found = std::find_if(std::begin(kTypes), std::end(kTypes),
                                     [gmsh](const auto& t) { return t.gmsh == gmsh; });
    return found == std::end(kTypes) ? nullptr : found;
}

Error unknown_type(std::int64_t type) {
    return unsupported("an element of Gmsh's type " + std::to_string(type) +
                       ", expected lines, triangles, quadrilaterals or tetrahedra of first or "
                       "second order");
}

void Msh::add_element(std::int64_t type, NumberType number) {
    const auto* kind = find_type(type);
    Element e{int(type), {}, kind->corners};
    for (std::size_t n = 0; n < kind->nodes; ++n) {
        const std::int64_t node = whole(number);
        if (n < kind->corners) e.nodes[n] = node;
    }
    m_elements.push_back(e);
    m_second_order |= kind->corners < kind->nodes;
}

/// An element of version 1: its number, type, two regions, number of nodes, and nodes.
Status Msh::read_elements_1() {
    const auto count = m_text.number<std::int64_t>().value_or(-1);
    if (!can_follow(count, 8)) return unreadable("$ELM is shorter than it says");
    for (std::int64_t done = 0; done < count; ++done) {
        integer();
        const std::int64_t type = integer();
        integer();
        integer();
        const std::int64_t nodes = integer();
        const auto* kind = find_type(type);
        if (!kind) return unknown_type(type);
        if (nodes != std::int64_t(kind->nodes))
            return unreadable("$ELM is damaged at element " + std::to_string(done));
        add_element(type, NumberType::Int32);
    }
    return Ok{};
}

Status Msh::read_elements_2() {
    const auto count = m_text.number<std::int64_t>().value_or(-1);
    m_text.line();
    if (!can_follow(count, 8)) return unreadable("$Elements is shorter than it says");
    for (std::int64_t done = 0; done < count;) {
        // In binary files, consecutive elements of one type share a header.
        std::int64_t type = 0, own = 1, tags = 0;
        if (m_binary) {
            type = integer();
            own = integer();
            tags = integer();
        } else {
            integer();
            type = integer();
            tags = integer();
        }
        const auto* kind = find_type(type);
        if (!kind) return unknown_type(type);
        if (own < 1 || own > count - done || tags < 0 || tags > 1000 || !can_follow(own, 4))
            return unreadable("$Elements is damaged at element " + std::to_string(done));
        for (std::int64_t n = 0; n < own; ++n, ++done) {
            if (m_binary) integer();
            for (std::int64_t t = 0; t < tags; ++t) integer();
            add_element(type, NumberType::Int32);
        }
    }
    return Ok{};
}

Status Msh::read_elements_4() {
    const std::int64_t blocks = size(), count = size();
    if (!m_is_4_0) size(), size();
    const NumberType number = m_is_4_0 ? NumberType::Int32 : NumberType::UInt64;
    if (!can_follow(count, m_is_4_0 ? 8 : 16) || !can_follow(blocks, 20))
        return unreadable("$Elements is shorter than it says");
    for (std::int64_t b = 0; b < blocks; ++b) {
        integer();
        integer();
        const std::int64_t type = integer(), own = size();
        const auto* kind = find_type(type);
        if (!kind) return unknown_type(type);
        if (!can_follow(own, m_is_4_0 ? 8 : 16))
            return unreadable("$Elements is damaged in block " + std::to_string(b));
        for (std::int64_t n = 0; n < own; ++n) {
            whole(number);
            add_element(type, number);
        }
    }
    return Ok{};
}

Result<MeshData> Msh::read() {
    while (!m_text.at_end()) {
        const std::string name(m_text.word());
        m_text.line();
        Status s = Ok{};
        bool known = true;
        if (name == "$MeshFormat")
            s = read_format();
        else if (name == "$NOD")
            s = read_nodes_2(false);
        else if (name == "$ParametricNodes")
            s = read_nodes_2(true);
        else if (name == "$ELM")
            s = read_elements_1();
        else if (name == "$Nodes")
            s = m_four ? read_nodes_4() : read_nodes_2(false);
        else if (name == "$Elements")
            s = m_four ? read_elements_4() : read_elements_2();
        else
            known = false;
        if (!s) return s.error();
        // Skips to the section's end: an unknown section may contain any bytes.
        const bool is_first = name == "$NOD" || name == "$ELM";
        const std::string end =
            (is_first ? "$END" : "$End") + (name.empty() ? name : name.substr(1));
        const auto at = m_text.rest().find(end);
        if (!name.starts_with('$') || at == std::string_view::npos)
            return unreadable("'" + name.substr(0, 40) + "' has no end");
        if (known && !TextCursor(m_text.rest().substr(0, at)).at_end())
            return unreadable(name + " has more numbers than its rows should have");
        m_text.bytes(at + end.size());
    }
    std::sort(m_numbers.begin(), m_numbers.end());
    MeshData mesh;
    if (m_second_order) add_note(mesh, kSecondOrderNote);
    if (const Status s = set_nodes(mesh, m_positions); !s) return s.error();
    for (Element& e : m_elements) {
        for (std::size_t n = 0; n < e.count; ++n) {
            const auto at = std::lower_bound(m_numbers.begin(), m_numbers.end(),
                                             std::pair(e.nodes[n], std::int64_t(-1)));
            if (at == m_numbers.end() || at->first != e.nodes[n])
                return unreadable("an element names node " + std::to_string(e.nodes[n]) +
                                  ", which doesn't exist");
            e.nodes[n] = at->second;
        }
        if (const Status s =
                add_cell(mesh, find_type(e.type)->vtk, std::span(e.nodes).first(e.count));
            !s)
            return s.error();
    }
    return mesh;
}

}  // namespace

Result<MeshData> parse_msh(std::string_view file) {
    return Msh(file).read();
}

}  // namespace pliant::mesh
