// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "formats/data_stream.h"

#include "base/errors.h"
#include "base/text.h"
#include "formats/data_check.h"
#include "formats/inflated_file.h"
#include "formats/vtk_array_source.h"

#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstring>
#include <limits>
#include <vector>

namespace pliant {
namespace fs = std::filesystem;
namespace {

constexpr std::size_t kPieceBytes = InflatedFile::kPieceBytes;

template <class Word>
void swap_words(std::span<std::byte> numbers, Word (*swapped)(Word)) {
    for (std::size_t at = 0; at + sizeof(Word) <= numbers.size(); at += sizeof(Word)) {
        Word word;
        std::memcpy(&word, &numbers[at], sizeof word);
        word = swapped(word);
        std::memcpy(&numbers[at], &word, sizeof word);
    }
}

void swap_bytes(std::span<std::byte> numbers, std::size_t size) {
    if (size == 2)
        swap_words<std::uint16_t>(numbers, [](std::uint16_t w) { return __builtin_bswap16(w); });
    if (size == 4)
        swap_words<std::uint32_t>(numbers, [](std::uint32_t w) { return __builtin_bswap32(w); });
    if (size == 8)
        swap_words<std::uint64_t>(
            numbers, [](std::uint64_t w) { return std::uint64_t(__builtin_bswap64(w)); });
}

/// Parses a whole number; some writers print 1e+06. @returns whether it is one in range
template <class T>
bool parse_whole(std::string_view text, T& value) {
    const char* const end = text.data() + text.size();
    if (const auto [next, error] = std::from_chars(text.data(), end, value);
        error == std::errc{} && next == end)
        return true;
    const auto number = number_from(text);
    using Limits = std::numeric_limits<T>;
    if (!number || *number != std::trunc(*number) || !(*number >= double(Limits::lowest())) ||
        !(*number < std::ldexp(1.0, Limits::digits)))
        return false;
    value = T(*number);
    return true;
}

template <class T>
bool parse_real(std::string_view text, T& value) {
    const char* const end = text.data() + text.size();
    if (const auto [next, error] = std::from_chars(text.data(), end, value);
        error == std::errc{} && next == end)
        return true;
    const auto number = number_from(text);  // infinite or zero outside of a float's range
    if (!number) return false;
    value = T(*number);
    return true;
}

template <class T>
bool parse_as(std::string_view text, std::byte* out) {
    T value{};
    const bool is_parsed =
        std::is_integral_v<T> ? parse_whole(text, value) : parse_real(text, value);
    std::memcpy(out, &value, sizeof value);
    return is_parsed;
}

bool parse_number(Component type, std::string_view text, std::byte* out) {
    if (text.starts_with('+')) text.remove_prefix(1);
    return with_type(type, [&]<class T>(T) { return parse_as<T>(text, out); });
}

}  // namespace

/// Reader of one data file.
class DataStream::Source {
  public:
    virtual ~Source() = default;
    virtual Status read(std::span<std::byte> out) = 0;
    /// Skips bytes without reading them. @returns false if they must be read
    virtual bool jump(std::uint64_t) { return false; }
    virtual Status finish() { return Ok{}; }
    /// Whether data follow those that were read. @pre finish() succeeded
    virtual bool is_longer() { return false; }
};

/// An array of VTK's XML files.
class DataStream::VtkSource final : public DataStream::Source {
  public:
    VtkSource(const fs::path& path, std::uint64_t start, const DataLocation& data,
              std::uint64_t expected)
        : m_array(path, start, data.vtk, data.swapped != (std::endian::native == std::endian::big),
                  expected) {}
    Status read(std::span<std::byte> out) override { return m_array.read(out); }

  private:
    VtkArraySource m_array;
};

/// Numbers in text, separated by blanks and optional commas. In XML a tag ends them.
class DataStream::TextSource final : public DataStream::Source {
  public:
    TextSource(const fs::path& path, const fs::path& name, std::uint64_t start,
               const ImageHeader& header, std::uint64_t count)
        : m_path(path),
          m_file(name),
          m_type(header.stored),
          m_count(count),
          m_in_xml(header.format == ImageFormat::Vti) {
        m_file.seek(start);
    }
    Status read(std::span<std::byte> out) override {
        const std::size_t size = size_of(m_type);
        for (std::size_t at = 0; at < out.size(); at += size, ++m_done) {
            const std::string_view word = next_word();
            if (word.empty()) {
                if (Status status = m_file.status(); !status) return status;
                return unreadable(m_path, "ends early: holds " + std::to_string(m_done) +
                                              " numbers, expected " + std::to_string(m_count));
            }
            if (!parse_number(m_type, word, &out[at]))
                return unreadable(m_path, "holds '" + shown(word) +
                                              "' among its data, expected a number of type " +
                                              std::string(name_of(m_type)));
        }
        return m_file.status();
    }
    bool is_longer() override { return !next_word().empty(); }

  private:
    /// Maximum length of a number's text [bytes].
    static constexpr std::size_t kMaxWord = 1200;

    std::string_view next_word() {
        const auto is_blank = [](int c) { return c == ' ' || (c >= '\t' && c <= '\r'); };
        m_word.clear();
        if (m_tag_follows) return m_word;
        int c = m_file.get();
        while (is_blank(c)) c = m_file.get();
        for (; c != InputFile::kEnd && !is_blank(c) && m_word.size() < kMaxWord; c = m_file.get()) {
            m_tag_follows = m_in_xml && c == '<';
            if (m_tag_follows) break;
            m_word += char(c);
        }
        std::string_view word = m_word;
        if (word.size() > 1 && word.ends_with(',')) word.remove_suffix(1);
        return word;
    }

    const fs::path& m_path;
    InputFile m_file;
    Component m_type;
    std::uint64_t m_count, m_done = 0;
    bool m_in_xml, m_tag_follows = false;
    std::string m_word;
};

/// Raw numbers.
class DataStream::BytesSource final : public DataStream::Source {
  public:
    BytesSource(const fs::path& path, const fs::path& name, std::uint64_t start)
        : m_path(path), m_file(name) {
        m_file.seek(start);
    }
    Status read(std::span<std::byte> out) override {
        if (m_file.read(out.data(), out.size()) == out.size()) return Ok{};
        if (Status status = m_file.status(); !status) return status;
        return unreadable(m_path, "ends early: it was cut short while it was read");
    }
    bool jump(std::uint64_t bytes) override {
        m_file.seek(m_file.at() + bytes);
        return true;
    }

  private:
    const fs::path& m_path;
    InputFile m_file;
};

/// Compressed numbers.
class DataStream::InflatedSource final : public DataStream::Source {
  public:
    InflatedSource(const fs::path& path, const fs::path& name, std::uint64_t start)
        : m_file(path, name, start) {}
    Status read(std::span<std::byte> out) override {
        while (!out.empty()) {
            const auto count = m_file.read_some(out);
            if (!count) return count.error();
            out = out.subspan(*count);
        }
        return Ok{};
    }
    Status finish() override {
        std::byte rest[4096];
        while (!m_file.ended() && m_beyond < kPieceBytes) {
            const auto count = m_file.read_some(rest);
            if (!count) return count.error();
            m_beyond += *count;
        }
        return Ok{};
    }
    bool is_longer() override { return m_beyond > 0; }

  private:
    InflatedFile m_file;
    std::size_t m_beyond = 0;
};

/// Counts the decompressed bytes of a file. @param most  stops there
Result<std::uint64_t> inflated_size(const fs::path& path, const fs::path& name, std::uint64_t start,
                                    std::uint64_t most) {
    InflatedFile file(path, name, start);
    std::vector<std::byte> piece(kPieceBytes);
    std::uint64_t size = 0;
    while (size <= most) {
        const bool ended = file.ended();
        const auto count = file.read_some(piece);
        if (Status status = file.status(); !status) return status.error();
        if (!count && ended) break;
        if (!count) return count.error();
        size += *count;
    }
    return size;
}

DataStream::DataStream(const fs::path& path, const ImageHeader& header)
    : m_path(path), m_header(header) {
    const std::uint64_t values =
        std::uint64_t(voxel_count(header.grid)) * std::uint64_t(header.components);
    m_bytes_per_file = values / header.data.files.size() * size_of(header.stored);
}

DataStream::~DataStream() = default;

Status DataStream::open_next() {
    const DataLocation& data = m_header.data;
    const auto start = find_data_start(m_path, m_header, data.files[m_next]);
    if (!start) return start.error();
    const bool deflated = data.encoding == DataEncoding::Deflated;
    const fs::path& name = data.files[m_next++];
    if (data.encoding == DataEncoding::Text)
        m_source = std::make_unique<TextSource>(m_path, name, *start, m_header,
                                                m_bytes_per_file / size_of(m_header.stored));
    else if (data.encoding == DataEncoding::VtkArray)
        m_source = std::make_unique<VtkSource>(name, *start, data, m_bytes_per_file);
    else if (deflated)
        m_source = std::make_unique<InflatedSource>(m_path, name, *start);
    else
        m_source = std::make_unique<BytesSource>(m_path, name, *start);
    m_left = m_bytes_per_file;
    std::uint64_t before = deflated ? data.inner_skip : 0;
    if (deflated && data.at_end) {
        const std::uint64_t most = m_bytes_per_file + kMaxInnerSkip;
        const auto size = inflated_size(m_path, name, *start, most);
        if (!size) return size.error();
        if (*size < m_bytes_per_file || *size > most)
            return unreadable(m_path, "byte skip is -1, but its compressed data hold " +
                                          std::to_string(*size) + " bytes or more, expected " +
                                          std::to_string(m_bytes_per_file) + " to " +
                                          std::to_string(most));
        before = *size - m_bytes_per_file;
    }
    std::vector<std::byte> skipped;
    for (std::uint64_t left = before; left > 0; left -= skipped.size()) {
        skipped.resize(std::size_t(std::min<std::uint64_t>(left, kPieceBytes)));
        if (Status status = m_source->read(skipped); !status) return status;
    }
    return Ok{};
}

Status DataStream::read(std::span<std::byte> out) {
    for (std::span<std::byte> rest = out; !rest.empty();) {
        if (m_left == 0) {
            if (Status status = finish(); !status) return status;
            if (Status status = open_next(); !status) return status;
        }
        const auto count = std::size_t(std::min<std::uint64_t>(m_left, rest.size()));
        if (Status status = m_source->read(rest.first(count)); !status) return status;
        m_left -= count;
        rest = rest.subspan(count);
    }
    if (m_header.data.swapped && m_header.data.encoding != DataEncoding::Text)
        swap_bytes(out, size_of(m_header.stored));
    return Ok{};
}

Status DataStream::skip(std::uint64_t bytes) {
    std::vector<std::byte> skipped;
    while (bytes > 0) {
        if (m_left == 0)
            if (Status status = open_next(); !status) return status;
        std::uint64_t count = std::min(m_left, bytes);
        if (!m_source->jump(count)) {
            count = std::min<std::uint64_t>(count, kPieceBytes);
            skipped.resize(std::size_t(count));
            if (Status status = m_source->read(skipped); !status) return status;
        }
        m_left -= count;
        bytes -= count;
    }
    return Ok{};
}

Status DataStream::finish() {
    return m_source ? m_source->finish() : Status(Ok{});
}

bool DataStream::is_longer() const {
    return m_source && m_left == 0 && m_source->is_longer();
}

}  // namespace pliant
