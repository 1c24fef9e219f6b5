// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include <pliant/scan_files.h>

#include "writers/stream_writers.h"

#include "base/text.h"

#include <bit>
#include <string>

namespace pliant {
namespace fs = std::filesystem;
namespace {

constexpr std::size_t kAlignment = 64;

bool is_detached(const fs::path& path) {
    return lower_case(path.extension().string()) == ".nhdr";
}

std::string_view type_of(Component component) {
    constexpr std::string_view kTypes[] = {
        "signed char",  "unsigned char", "short",  "unsigned short", "int",
        "unsigned int", "int64",         "uint64", "float",          "double"};
    return kTypes[int(component)];
}

std::string vector_text(Vec3d v) {
    return "(" + text_of(v.x) + "," + text_of(v.y) + "," + text_of(v.z) + ")";
}

std::string escaped(std::string_view text) {
    std::string result;
    for (const char c : text) {
        if (c == '\n')
            result += "\\n";
        else if (c == '\\')
            result += "\\\\";
        else
            result += c;
    }
    return result;
}

/// The header, without the location of the data.
std::string header_text(const NrrdLayout& layout, Encoding encoding) {
    const Grid& grid = layout.grid;
    const bool vectors = layout.components > 1;
    std::string text = "NRRD0004\n";
    const auto line = [&](const char* field, const std::string& value) {
        text += std::string(field) + ": " + value + "\n";
    };
    line("type", std::string(type_of(layout.component)));
    line("dimension", vectors ? "4" : "3");
    line("space", "left-posterior-superior");
    line("sizes", (vectors ? std::to_string(layout.components) + " " : "") +
                      std::to_string(grid.size.x) + " " + std::to_string(grid.size.y) + " " +
                      std::to_string(grid.size.z));
    std::string directions = vectors ? "none" : "";
    for (std::size_t a = 0; a < 3; ++a)
        directions += (directions.empty() ? "" : " ") +
                      vector_text(grid.spacing_mm[int(a)] * grid.direction.columns[a]);
    line("space directions", directions);
    line("kinds", std::string(vectors ? "vector " : "") + "domain domain domain");
    line("endian", std::endian::native == std::endian::big ? "big" : "little");
    line("encoding", encoding == Encoding::Gzip ? "gzip" : "raw");
    line("space origin", vector_text(grid.origin_mm));
    for (const auto& [key, value] : layout.key_values)
        if (!is_itk_key(key) && !key.empty() && key[0] != '#' && key.find(':') == key.npos)
            text += escaped(key) + ":=" + escaped(value) + "\n";
    return text;
}

/// Completes the header of a file with attached data.
void finish_attached(std::string& header) {
    const std::size_t used = (header.size() + 3) % kAlignment;  // with "#" and two line ends
    header += "#" + std::string((kAlignment - used) % kAlignment, ' ') + "\n\n";
}

}  // namespace

NrrdWriter::NrrdWriter(const fs::path& path, const NrrdLayout& layout, Encoding encoding)
    : m_sink(path) {
    std::string header = header_text(layout, encoding);
    const bool detached = is_detached(path);
    fs::path data = path;
    if (detached) {
        data.replace_extension(encoding == Encoding::Gzip ? ".raw.gz" : ".raw");
        header += "data file: " + data.filename().string() + "\n";
    } else {
        finish_attached(header);
    }
    m_sink.write(header.data(), header.size());
    if (detached) m_sink.open(data);
    if (encoding == Encoding::Gzip) m_sink.start(Compression::Gzip);
}

void NrrdWriter::add(std::span<const std::byte> numbers) {
    m_sink.add(numbers);
}

Status NrrdWriter::finish() {
    m_sink.end_numbers();
    return m_sink.finish();
}

}  // namespace pliant
