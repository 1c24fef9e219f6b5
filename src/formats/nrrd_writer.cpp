// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "formats/nrrd_writer.h"

#include "core/descriptor.h"
#include "core/text.h"

#include <fcntl.h>
#include <unistd.h>
#include <zlib.h>

#include <algorithm>
#include <bit>
#include <cerrno>
#include <cstring>
#include <limits>
#include <new>
#include <string>
#include <vector>

namespace pliant {
namespace fs = std::filesystem;
namespace {

constexpr std::size_t kPieceBytes = 1 << 18;
constexpr std::size_t kAlignment = 64;
/// Fastest level: on scans and on sparse fields, higher levels cost three times the time for a few
/// percent.
constexpr int kGzipLevel = 1;

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

/// A file, with optional compression by zlib.
class NrrdWriter::Sink {
  public:
    explicit Sink(const fs::path& path) : m_path(path) { open(path); }
    ~Sink() {
        close();
        if (m_gzip) deflateEnd(&m_zlib);
    }
    Sink(const Sink&) = delete;
    Sink& operator=(const Sink&) = delete;

    void write(const void* bytes, std::size_t count) {
        if (m_error == 0) m_error = write_all(m_file.number(), bytes, count);
    }
    /// Continues in another file.
    void open(const fs::path& path) {
        close();
        if (m_error) return;
        m_file = open_file(path, O_WRONLY | O_CREAT | O_TRUNC, 0666);
        if (!m_file.is_open()) m_error = errno;
    }
    void start_gzip() {
        constexpr int kGzip = 15 + 16, kDefaultMemory = 8;
        if (deflateInit2(&m_zlib, kGzipLevel, Z_DEFLATED, kGzip, kDefaultMemory,
                         Z_DEFAULT_STRATEGY) != Z_OK)
            throw std::bad_alloc();
        m_gzip = true;
        m_output.resize(kPieceBytes);
    }
    void add(std::span<const std::byte> numbers) {
        if (!m_gzip) return write(numbers.data(), numbers.size());
        while (!numbers.empty() && m_error == 0) {
            const auto piece = numbers.first(std::min(numbers.size(), kMaxAtOnce));
            m_zlib.next_in = const_cast<Bytef*>(reinterpret_cast<const Bytef*>(piece.data()));
            m_zlib.avail_in = uInt(piece.size());
            deflate_all(Z_NO_FLUSH);
            numbers = numbers.subspan(piece.size());
        }
    }
    Status finish() {
        if (m_gzip && m_error == 0) {
            m_zlib.next_in = nullptr;
            m_zlib.avail_in = 0;
            deflate_all(Z_FINISH);
        }
        close();
        if (m_error == 0) return Ok{};
        return Error{ErrorCode::Unwritable,
                     m_path.string() + ": can't be written (" + std::strerror(m_error) + ")"};
    }

  private:
    static constexpr std::size_t kMaxAtOnce = std::size_t(1) << 30;

    void deflate_all(int flush) {
        do {
            m_zlib.next_out = m_output.data();
            m_zlib.avail_out = uInt(m_output.size());
            deflate(&m_zlib, flush);
            write(m_output.data(), m_output.size() - m_zlib.avail_out);
        } while (m_zlib.avail_out == 0 && m_error == 0);
    }
    void close() {
        const int error = m_file.close();
        if (m_error == 0) m_error = error;
    }

    fs::path m_path;
    Descriptor m_file;
    int m_error = 0;  ///< errno of the first failure
    bool m_gzip = false;
    std::vector<Bytef> m_output;
    z_stream m_zlib{};
};

NrrdWriter::NrrdWriter(const fs::path& path, const NrrdLayout& layout, Encoding encoding)
    : m_sink(std::make_unique<Sink>(path)) {
    std::string header = header_text(layout, encoding);
    const bool detached = is_detached(path);
    fs::path data = path;
    if (detached) {
        data.replace_extension(encoding == Encoding::Gzip ? ".raw.gz" : ".raw");
        header += "data file: " + data.filename().string() + "\n";
    } else {
        finish_attached(header);
    }
    m_sink->write(header.data(), header.size());
    if (detached) m_sink->open(data);
    if (encoding == Encoding::Gzip) m_sink->start_gzip();
}

NrrdWriter::~NrrdWriter() = default;

void NrrdWriter::add(std::span<const std::byte> numbers) {
    m_sink->add(numbers);
}

Status NrrdWriter::finish() {
    return m_sink->finish();
}

}  // namespace pliant
