// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Shared parts of the mesh file readers: text word by word, and arrays of numbers of any type and
// byte order. A reader gets the file's bytes. Its errors don't name the file.

#pragma once

#include <pliant/mesh.h>

#include <bit>
#include <charconv>
#include <cstddef>
#include <cstring>
#include <new>
#include <optional>
#include <type_traits>

#include "base/memory_budget.h"
#include "base/number_type.h"

namespace pliant::mesh {

inline Error unreadable(const std::string& what) {
    return {ErrorCode::Unreadable, what};
}
inline Error unsupported(const std::string& what) {
    return {ErrorCode::Unsupported, what};
}

/// Throws std::bad_alloc if so much memory isn't available.
inline void ask_for(std::uint64_t bytes) {
    if (!has_memory_for(bytes)) throw std::bad_alloc();
}

/// Cursor over the words and lines of a text.
class TextCursor {
  public:
    explicit TextCursor(std::string_view text) : m_text(text) {}

    bool at_end() {
        skip_blanks();
        return m_text.empty();
    }
    std::string_view rest() const { return m_text; }
    /// Takes the next word; empty at the end.
    std::string_view word() {
        skip_blanks();
        std::size_t end = 0;
        while (end < m_text.size() && !blank(m_text[end])) ++end;
        return take(end);
    }
    /// Takes the rest of the line, including its end.
    std::string_view line() {
        const std::size_t end = std::min(m_text.find('\n'), m_text.size());
        std::string_view line = take(end);
        if (!m_text.empty()) m_text.remove_prefix(1);
        if (line.ends_with('\r')) line.remove_suffix(1);
        return line;
    }
    template <class T>
    std::optional<T> number() {
        skip_blanks();
        if (m_text.starts_with('+')) m_text.remove_prefix(1);
        T value{};
        const auto [next, error] =
            std::from_chars(m_text.data(), m_text.data() + m_text.size(), value);
        if (error != std::errc{}) return std::nullopt;
        m_text.remove_prefix(std::size_t(next - m_text.data()));
        if (!m_text.empty() && !blank(m_text[0])) return std::nullopt;
        return value;
    }
    /// Takes bytes; nullopt if fewer are left.
    std::optional<std::string_view> bytes(std::size_t count) {
        if (count > m_text.size()) return std::nullopt;
        return take(count);
    }

  private:
    static bool blank(char c) { return c == ' ' || (c >= '\t' && c <= '\r'); }
    void skip_blanks() {
        std::size_t n = 0;
        while (n < m_text.size() && blank(m_text[n])) ++n;
        m_text.remove_prefix(n);
    }
    std::string_view take(std::size_t count) {
        const std::string_view taken = m_text.substr(0, count);
        m_text.remove_prefix(count);
        return taken;
    }
    std::string_view m_text;
};

/// Type by VTK's XML names (Float32, …), VTK's legacy names (float, vtktypeint64, …) and PLY's
/// (uchar, float32, …).
std::optional<NumberType> number_type(std::string_view name);

template <class T>
T value_at(const char* bytes, bool swap) {
    char copy[sizeof(T)];
    for (std::size_t b = 0; b < sizeof(T); ++b) copy[b] = bytes[swap ? sizeof(T) - 1 - b : b];
    T value;
    std::memcpy(&value, copy, sizeof value);
    return value;
}

/// @tparam To  double, or std::int64_t, for which fractions and values out of range become −1
template <class To>
To number_at(const char* bytes, NumberType type, bool swap) {
    const auto whole = [](double value) {
        return value >= 0 && value < 9e15 ? std::int64_t(value) : std::int64_t(-1);
    };
    return with_type(type, [&]<class T>(T) {
        const T value = value_at<T>(bytes, swap);
        if constexpr (std::is_integral_v<T> || std::is_same_v<To, double>)
            return To(value);
        else
            return whole(double(value));
    });
}

template <class To>
std::vector<To> numbers_of(std::string_view bytes, NumberType type, bool big_endian) {
    const bool swap = big_endian != (std::endian::native == std::endian::big);
    ask_for(bytes.size() / size_of(type) * sizeof(To));
    std::vector<To> numbers(bytes.size() / size_of(type));
    for (std::size_t n = 0; n < numbers.size(); ++n)
        numbers[n] = number_at<To>(bytes.data() + n * size_of(type), type, swap);
    return numbers;
}

/// Parses exactly count numbers. Each needs at least two characters, which is checked before memory
/// is allocated.
template <class To>
std::optional<std::vector<To>> numbers_in(TextCursor& text, std::size_t count) {
    if (count > text.rest().size() / 2 + 1) return std::nullopt;
    ask_for(count * sizeof(To));
    std::vector<To> numbers(count);
    for (To& n : numbers) {
        const auto value = text.number<To>();
        if (!value) return std::nullopt;
        n = *value;
    }
    return numbers;
}

/// Cells that wait until all nodes are known, concatenated, because small files would otherwise
/// need much memory. Empty cells are left out.
class CellList {
  public:
    void add(std::span<const std::int64_t> nodes) {
        if (nodes.empty()) return;
        m_numbers.push_back(std::int64_t(nodes.size()));
        m_numbers.insert(m_numbers.end(), nodes.begin(), nodes.end());
    }
    /// Adds all cells to a mesh. @param type  VTK's cell type
    Status add_to(MeshData& mesh, int type) const;

  private:
    std::vector<std::int64_t> m_numbers;  ///< for each cell: number of nodes, then the nodes
};

/// Adds a cell of VTK's numbering (1, 2 vertices, 3, 4 lines, 5 triangle, 6 strip, 7 polygon,
/// 8 pixel, 9 quadrilateral, 10 tetrahedron; 21…24 and 28, the same of second order, of which the
/// corners are taken, with a note). @returns Unreadable for a node that doesn't exist or
/// a wrong number of them, Unsupported for other cells
Status add_cell(MeshData& mesh, int vtk_type, std::span<const std::int64_t> nodes);

/// Largest concave polygon that add_polygon splits: the time may grow with the cube.
inline constexpr std::size_t kMaxConcaveCorners = 1024;
/// Adds a polygon's triangles: a fan around its first corner where that is right, as it is for all
/// convex polygons. @pre the nodes exist. @returns Unsupported for a large concave one
Status add_polygon(MeshData& mesh, std::span<const std::int64_t> nodes);
inline constexpr const char* kSecondOrderNote =
    "of the cells of second order, only the corners were taken";
/// Adds a remark for the user, once.
void add_note(MeshData& mesh, const std::string& note);

/// Sets the nodes from coordinates. @returns Unreadable if one isn't finite or there are more than
/// 2³¹
Status set_nodes(MeshData& mesh, std::span<const double> coordinates);

// The readers, each for the contents of a file.
Result<MeshData> parse_vtk_xml(std::string_view file);
Result<MeshData> parse_vtk_legacy(std::string_view file);
Result<MeshData> parse_msh(std::string_view file);
Result<MeshData> parse_stl(std::string_view file);
Result<MeshData> parse_obj(std::string_view file);
Result<MeshData> parse_ply(std::string_view file);
Result<MeshData> parse_off(std::string_view file);
Result<MeshData> parse_medit(std::string_view file);
/// Chooses a reader by the first bytes. @param ending  extension, for OBJ, which has no signature
Result<MeshData> parse_mesh(std::string_view file, std::string_view ending);

}  // namespace pliant::mesh
