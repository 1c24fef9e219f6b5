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

/// Digits of the compressed data's length.
constexpr std::size_t kSizeDigits = 20;

/// Whether reading returns the same key and value.
bool fits_meta_line(const std::string& key, const std::string& value) {
    const auto is_plain = [](const std::string& text) {
        return trimmed(text) == text && text.find_first_of(std::string("\r\n\0", 3)) == text.npos;
    };
    return !key.empty() && is_plain(key) && is_plain(value) &&
           key.find_first_of("=:") == key.npos && !value.starts_with('=') &&
           !value.starts_with(':') && !is_meta_field(key) && !is_itk_key(key);
}

/// The fields in front of the data's location, without the length of compressed data.
std::string meta_geometry(const NrrdLayout& layout) {
    const Grid& grid = layout.grid;
    std::string text;
    const auto line = [&](const char* field, const std::string& value) {
        text += std::string(field) + " = " + value + "\n";
    };
    const auto three = [](auto v) {
        return text_of(double(v.x)) + " " + text_of(double(v.y)) + " " + text_of(double(v.z));
    };
    const auto& axes = grid.direction.columns;
    line("TransformMatrix", three(axes[0]) + " " + three(axes[1]) + " " + three(axes[2]));
    line("Offset", three(grid.origin_mm));
    line("CenterOfRotation", "0 0 0");
    line("ElementSpacing", three(grid.spacing_mm));
    line("DimSize", std::to_string(grid.size.x) + " " + std::to_string(grid.size.y) + " " +
                        std::to_string(grid.size.z));
    for (const auto& [key, value] : layout.key_values)
        if (fits_meta_line(key, value)) line(key.c_str(), value);
    line("ElementType", layout.component == Component::Int16 ? "MET_SHORT" : "MET_FLOAT");
    return text;
}

}  // namespace

MetaWriter::MetaWriter(const fs::path& path, const NrrdLayout& layout, Encoding encoding)
    : m_sink(path) {
    const bool compressed = encoding == Encoding::Gzip;
    const bool detached = lower_case(path.extension().string()) == ".mhd";
    const bool big = std::endian::native == std::endian::big;
    std::string header = "ObjectType = Image\nNDims = 3\nBinaryData = True\n";
    header += std::string("BinaryDataByteOrderMSB = ") + (big ? "True" : "False") + "\n";
    header += std::string("CompressedData = ") + (compressed ? "True" : "False") + "\n";
    if (compressed && !detached) {
        header += "CompressedDataSize = ";
        m_size_offset = header.size();
        header += std::string(kSizeDigits, '0') + "\n";
    }
    header += meta_geometry(layout);
    fs::path data = path;
    std::string last = "ElementDataFile = LOCAL\n";
    if (detached) {
        data.replace_extension(compressed ? ".zraw" : ".raw");
        last = "ElementDataFile = " + data.filename().string() + "\n";
    } else if (!compressed) {
        // Raw data start at a multiple of 64 bytes, so that they can be mapped.
        constexpr std::size_t kAlignment = 64;
        const std::string comment = "Comment = ";
        const std::size_t used = (header.size() + comment.size() + 1 + last.size()) % kAlignment;
        last = comment + std::string((kAlignment - used) % kAlignment, '.') + "\n" + last;
    }
    header += last;
    m_sink.write(header.data(), header.size());
    m_header_bytes = header.size();
    if (detached) m_sink.open(data);
    if (compressed) m_sink.start(Compression::Zlib);
}

Status MetaWriter::finish() {
    m_sink.end_numbers();
    if (m_size_offset) {
        const std::string size = std::to_string(m_sink.bytes_written() - m_header_bytes);
        m_sink.write_at(m_size_offset, std::string(kSizeDigits - size.size(), '0') + size);
    }
    return m_sink.finish();
}

}  // namespace pliant
