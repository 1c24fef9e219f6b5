// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "meshes/vtk_document.h"

#include <pliant/core/files.h>
#include <pliant/core/output_file.h>

#include <algorithm>
#include <bit>
#include <cstring>
#include <vector>

namespace pliant::mesh {
namespace {

void append_base64(std::string& text, std::span<const std::byte> bytes) {
    constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    for (std::size_t n = 0; n < bytes.size(); n += 3) {
        const std::size_t count = std::min<std::size_t>(3, bytes.size() - n);
        std::uint32_t word = 0;
        for (std::size_t b = 0; b < 3; ++b)
            word = word << 8 | (b < count ? std::to_integer<std::uint32_t>(bytes[n + b]) : 0u);
        for (std::size_t d = 0; d < 4; ++d)
            text += d <= count ? kDigits[word >> (18 - 6 * d) & 63] : '=';
    }
}

/// Escapes XML metacharacters, because names come from callers.
std::string escaped(const std::string& name) {
    std::string text;
    for (const char c : name)
        text += c == '&'   ? "&amp;"
                : c == '<' ? "&lt;"
                : c == '>' ? "&gt;"
                : c == '"' ? "&quot;"
                           : std::string(1, c);
    return text;
}

}  // namespace

VtkDocument::VtkDocument(const std::string& type) : m_type(type) {
    const char* order = std::endian::native == std::endian::big ? "BigEndian" : "LittleEndian";
    add("<?xml version=\"1.0\"?>");
    add("<VTKFile type=\"" + type + "\" version=\"1.0\" byte_order=\"" + order +
        "\" header_type=\"UInt64\">");
    add("<" + type + ">");
    // Character codes of "LPS" and a zero. Grids don't have this array: 3D Slicer assumes LPS for
    // them, and meshio refuses files with text.
    if (type == "PolyData")
        add("<FieldData>\n<Array type=\"String\" Name=\"SPACE\" NumberOfTuples=\"1\" "
            "format=\"ascii\">76 80 83 0</Array>\n</FieldData>");
}

void VtkDocument::add_bytes(const char* type, const std::string& name, int components,
                            std::span<const std::byte> bytes) {
    add("<DataArray type=\"" + std::string(type) + "\" Name=\"" + escaped(name) +
        "\" NumberOfComponents=\"" + std::to_string(components) +
        "\" format=\"appended\" offset=\"" + std::to_string(m_data.size()) + "\"/>");
    const std::uint64_t length = bytes.size();
    std::vector<std::byte> block(sizeof length + bytes.size());
    std::memcpy(block.data(), &length, sizeof length);
    std::copy(bytes.begin(), bytes.end(), block.begin() + sizeof length);
    append_base64(m_data, block);
}

Status VtkDocument::write(const std::filesystem::path& target) const {
    return write_file(target, m_header + "</" + m_type +
                                  ">\n<AppendedData encoding=\"base64\">\n_" + m_data +
                                  "\n</AppendedData>\n</VTKFile>\n");
}

Status check_length(const std::filesystem::path& path, const std::string& name, std::size_t found,
                    std::size_t expected, const char* of) {
    if (found == expected) return Ok{};
    return Error{ErrorCode::InvalidArgument, path.string() + ": field '" + name + "' has " +
                                                 std::to_string(found) + " values, expected " +
                                                 std::to_string(expected) + ", one for each " + of};
}

Status write_file(const std::filesystem::path& target, std::string_view bytes) {
    StagedFiles staged;
    const auto path = staged.stage(target);
    if (!path) return path.error();
    OutputFile file(*path, target.string());
    file.write(bytes);
    if (Status s = file.close(); !s) return s;
    return staged.commit();
}

}  // namespace pliant::mesh
