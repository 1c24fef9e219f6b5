// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// STL (text or binary), OBJ and PLY (text or binary): surfaces only.

#include <algorithm>
#include <bit>

#include "meshes/file_numbers.h"

namespace pliant::mesh {
namespace {

void turn_if_ras(MeshData& mesh, std::string_view comments) {
    if (comments.find("SPACE=RAS") == comments.npos) return;
    for (Vec3d& p : mesh.nodes_mm) p = {-p.x, -p.y, p.z};
}

/// Makes a mesh of triangles with three separate corners each.
Result<MeshData> corners_to_mesh(const std::vector<double>& positions) {
    MeshData mesh;
    if (const Status s = set_nodes(mesh, positions); !s) return s.error();
    for (std::size_t n = 0; n + 2 < mesh.nodes_mm.size(); n += 3)
        mesh.triangles.push_back({std::int32_t(n), std::int32_t(n + 1), std::int32_t(n + 2)});
    return mesh;
}

bool same_letters(std::string_view word, std::string_view lower) {
    return std::equal(word.begin(), word.end(), lower.begin(), lower.end(), [](char a, char b) {
        return (a >= 'A' && a <= 'Z' ? char(a - 'A' + 'a') : a) == b;
    });
}

Result<MeshData> parse_text_stl(std::string_view file) {
    TextCursor text(file);
    const std::string_view title = text.line();
    std::vector<double> positions;
    while (!text.at_end()) {
        const std::string_view word = text.word();
        if (same_letters(word, "endfacet") && positions.size() % 9 != 0)
            return unreadable("facet " + std::to_string(positions.size() / 9) + " has " +
                              std::to_string(positions.size() / 3 % 3) +
                              " vertices more than expected, which is 3");
        if (!same_letters(word, "vertex")) continue;
        for (int a = 0; a < 3; ++a) {
            const auto value = text.number<double>();
            if (!value)
                return unreadable("vertex " + std::to_string(positions.size() / 3) +
                                  " has something that is no number");
            positions.push_back(*value);
        }
    }
    if (positions.size() % 9 != 0)
        return unreadable("the last facet has fewer than three vertices");
    auto mesh = corners_to_mesh(positions);
    if (mesh) turn_if_ras(*mesh, title);
    return mesh;
}

/// Parses a corner of an OBJ's face, "7", "7/1" or "7//3"; negative numbers count from the last
/// node. @returns nullopt for other words, and 0
std::optional<std::int64_t> obj_node(std::string_view word, std::size_t nodes) {
    std::int64_t value = 0;
    const char* last = word.data() + word.size();
    const auto [end, error] = std::from_chars(word.data(), last, value);
    if (error != std::errc{} || value == 0 || (end != last && *end != '/')) return std::nullopt;
    return value > 0 ? value - 1 : std::int64_t(nodes) + value;
}

/// Takes a line of an OBJ, with those that it is continued by, without the comment.
/// @param[in,out] number  of the last line taken @param[out] comments  grows by the comment
/// @param[out] buffer  holds a line that is continued
std::string_view obj_line(TextCursor& text, std::size_t& number, std::string& comments,
                          std::string& buffer) {
    std::string_view line = text.line();
    ++number;
    if (line.ends_with('\\')) {
        buffer = line;
        for (bool more = true; more && !text.rest().empty(); ++number) {
            buffer.back() = ' ';
            buffer += text.line();
            more = buffer.ends_with('\\');
        }
        line = buffer;
    }
    if (const auto comment = line.find('#'); comment != line.npos) {
        comments += std::string(line.substr(comment)) + "\n";
        line = line.substr(0, comment);
    }
    return line;
}

struct PlyProperty {
    std::string name;
    NumberType type = NumberType::Float32;
    std::optional<NumberType> length;  ///< length type of a list
};
struct PlyElement {
    std::string name;
    std::int64_t count = 0;
    std::vector<PlyProperty> properties;
};

class Ply {
  public:
    explicit Ply(std::string_view file) : m_text(file) {}
    Result<MeshData> read();

  private:
    Status read_header();
    Status read_element(const PlyElement& element);
    Status read_row(const PlyElement& element, std::int64_t number);
    Status read_values(const PlyElement& element);
    Result<double> value(NumberType type);

    TextCursor m_text, m_row{{}};  ///< m_row: one element in a text file
    bool m_binary = false, m_big_endian = false;
    std::vector<PlyElement> m_elements;
    std::string m_comments;
    std::vector<double> m_positions;
    CellList m_faces;
    std::vector<std::int64_t> m_list;  ///< the current list
    MeshData m_mesh;
};

Status Ply::read_header() {
    m_text.line();
    for (;;) {
        if (m_text.rest().empty()) return unreadable("no end_header");
        const std::string_view line = m_text.line();
        TextCursor words(line);
        const std::string_view keyword = words.word();
        if (keyword == "end_header") return Ok{};
        if (keyword == "format") {
            const std::string_view format = words.word();
            m_binary = format != "ascii";
            m_big_endian = format == "binary_big_endian";
            if (m_binary && !m_big_endian && format != "binary_little_endian")
                return unsupported("format '" + std::string(format) + "'");
        } else if (keyword == "comment") {
            m_comments += std::string(line) + "\n";
        } else if (keyword == "element") {
            PlyElement element{std::string(words.word()), 0, {}};
            const auto count = words.number<std::int64_t>();
            if (!count || *count < 0) return unreadable("element without a count");
            element.count = *count;
            m_elements.push_back(std::move(element));
        } else if (keyword == "property") {
            if (m_elements.empty()) return unreadable("a property before all elements");
            PlyProperty property;
            std::string_view type = words.word();
            if (type == "list") {
                property.length = number_type(words.word());
                if (!property.length) return unreadable("a list with an unknown type of length");
                type = words.word();
            }
            const auto known = number_type(type);
            if (!known) return unreadable("a property of unknown type");
            property.type = *known;
            property.name = words.word();
            m_elements.back().properties.push_back(std::move(property));
        }
    }
}

Result<double> Ply::value(NumberType type) {
    if (!m_binary) {
        const auto number = m_row.number<double>();
        if (number) return *number;
        return unreadable(m_row.at_end() ? "its row has too few numbers"
                                         : "its row holds something that is no number");
    }
    const auto bytes = m_text.bytes(size_of(type));
    if (!bytes) return unreadable("the file ends within its numbers");
    return numbers_of<double>(*bytes, type, m_big_endian)[0];
}

Status Ply::read_values(const PlyElement& element) {
    double position[3] = {NAN, NAN, NAN};
    for (const PlyProperty& p : element.properties) {
        if (!p.length) {
            const auto number = value(p.type);
            if (!number) return number.error();
            if (p.name.size() == 1 && p.name[0] >= 'x' && p.name[0] <= 'z')
                position[p.name[0] - 'x'] = *number;
            continue;
        }
        const auto length = value(*p.length);
        if (!length) return length.error();
        if (!(*length >= 0 && *length < 1e6)) return unreadable("a list with a wrong length");
        m_list.clear();
        for (double k = 0; k < *length; ++k) {
            const auto number = value(p.type);
            if (!number) return number.error();
            m_list.push_back(*number >= 0 && *number < 3e9 ? std::int64_t(*number) : -1);
        }
        if (element.name == "face" && (p.name == "vertex_indices" || p.name == "vertex_index"))
            m_faces.add(m_list);
    }
    if (element.name == "vertex") m_positions.insert(m_positions.end(), position, position + 3);
    return Ok{};
}

/// In text, an element is a line.
Status Ply::read_row(const PlyElement& element, std::int64_t number) {
    const auto name = [&] { return "element '" + element.name.substr(0, 40) + "' "; };
    if (m_text.at_end())
        return unreadable(name() + "has " + std::to_string(number) + " rows, expected " +
                          std::to_string(element.count));
    m_row = TextCursor(m_text.line());
    if (const Status s = read_values(element); !s)
        return unreadable(name() + std::to_string(number) + ": " + s.error().message);
    if (!m_row.at_end())
        add_note(m_mesh, "rows of " + name() +
                             "have more numbers than its properties; the last ones were ignored");
    return Ok{};
}

Status Ply::read_element(const PlyElement& element) {
    if (element.properties.empty()) return Ok{};
    // Each property needs at least a byte, so that a wrong count ends soon.
    for (std::int64_t n = 0; n < element.count; ++n)
        if (const Status s = m_binary ? read_values(element) : read_row(element, n); !s) return s;
    return Ok{};
}

Result<MeshData> Ply::read() {
    if (const Status s = read_header(); !s) return s.error();
    for (const PlyElement& element : m_elements)
        if (const Status s = read_element(element); !s) return s.error();
    if (!(m_binary ? m_text.rest().empty() : m_text.at_end()))
        add_note(m_mesh, "the file is longer than its elements; the rest was ignored");
    if (const Status s = set_nodes(m_mesh, m_positions); !s) return s.error();
    if (const Status s = m_faces.add_to(m_mesh, 7); !s) return s.error();
    turn_if_ras(m_mesh, m_comments);
    return std::move(m_mesh);
}

}  // namespace

Result<MeshData> parse_stl(std::string_view file) {
    constexpr std::size_t kHead = 84, kFacet = 50;
    if (file.size() >= kHead) {
        // The count determines a binary file's length; texts that begin with "solid" don't match
        // it.
        const auto count =
            value_at<std::uint32_t>(file.data() + 80, std::endian::native == std::endian::big);
        const std::size_t expected = kHead + kFacet * std::size_t(count);
        // A text has no zero byte.
        const bool binary = file.size() == expected || file.find('\0') != file.npos;
        if (binary && file.size() < expected)
            return unreadable("the file ends at byte " + std::to_string(file.size()) +
                              ", expected " + std::to_string(expected) + " for its " +
                              std::to_string(count) + " facets");
        if (binary) {
            // Some programs don't fill in the number. A rest that is no facet is left.
            const std::size_t more = file.size() - expected;
            const std::size_t facets = count + (more % kFacet == 0 ? more / kFacet : 0);
            std::vector<double> positions;
            positions.reserve(9 * facets);
            for (std::size_t f = 0; f < facets; ++f) {
                const auto corners = numbers_of<double>(file.substr(kHead + kFacet * f + 12, 36),
                                                        NumberType::Float32, false);
                positions.insert(positions.end(), corners.begin(), corners.end());
            }
            auto mesh = corners_to_mesh(positions);
            if (!mesh) return mesh;
            turn_if_ras(*mesh, file.substr(0, 80));
            if (facets > count)
                add_note(*mesh, "the header says " + std::to_string(count) + " facets, but " +
                                    std::to_string(facets) + " are there; all were read");
            else if (more > 0)
                add_note(*mesh, "the file is " + std::to_string(more) +
                                    " bytes longer than its facets; the rest was ignored");
            return mesh;
        }
    }
    if (!same_letters(TextCursor(file).word().substr(0, 5), "solid"))
        return unreadable("neither text nor as long as its number of facets says");
    return parse_text_stl(file);
}

Result<MeshData> parse_obj(std::string_view file) {
    TextCursor text(file);
    std::vector<double> positions;
    CellList faces, lines;
    std::vector<std::int64_t> nodes;
    std::string comments, buffer;
    for (std::size_t number = 0; !text.rest().empty();) {
        const std::string_view line = obj_line(text, number, comments, buffer);
        const auto wrong = [number](const std::string& what) {
            return unreadable("line " + std::to_string(number) + ": " + what);
        };
        TextCursor words(line);
        const std::string_view keyword = words.word();
        if (keyword == "v")
            for (int a = 0; a < 3; ++a) {
                const auto value = words.number<double>();
                if (!value) return wrong("expected three numbers behind v");
                positions.push_back(*value);
            }
        if (keyword == "f" || keyword == "l") {
            nodes.clear();
            while (!words.at_end()) {
                const std::string_view word = words.word();
                const auto node = obj_node(word, positions.size() / 3);
                if (!node)
                    return wrong("expected the numbers of nodes, from 1, behind " +
                                 std::string(keyword) + ", found '" +
                                 std::string(word.substr(0, 40)) + "'");
                nodes.push_back(*node);
            }
            (keyword == "f" ? faces : lines).add(nodes);
        }
    }
    MeshData mesh;
    if (const Status s = set_nodes(mesh, positions); !s) return s.error();
    if (const Status s = faces.add_to(mesh, 7); !s) return s.error();
    if (const Status s = lines.add_to(mesh, 4); !s) return s.error();
    turn_if_ras(mesh, comments);
    return mesh;
}

Result<MeshData> parse_ply(std::string_view file) {
    return Ply(file).read();
}

}  // namespace pliant::mesh
