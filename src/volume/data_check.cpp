// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "volume/data_check.h"

#include "volume/text.h"

#include <zlib.h>

#include <fstream>
#include <limits>
#include <memory>
#include <system_error>

namespace pliant {
namespace fs = std::filesystem;
namespace {

constexpr std::size_t kPieceBytes = 1 << 18;
/// A compressed byte stands for at most this many (deflate's own bound is 1032).
constexpr std::uint64_t kMaxCompressionRatio = 1040;
/// Most files that one image may be spread over.
constexpr std::int64_t kMaxDataFiles = kMaxAxisSize;

Error damaged(const fs::path& path, const std::string& message) {
    return {ErrorCode::Unreadable, path.string() + ": " + message};
}

/// Runs through gzip or zlib data, to the end, where their checksum is, if that is near: like a
/// raw file, a compressed one may hold more than its sizes say. gzip files may be chains.
Status check_deflated(const fs::path& path, std::ifstream& file, std::uint64_t expected) {
    constexpr int kGzipOrZlib = 15 + 32;
    z_stream stream{};
    if (inflateInit2(&stream, kGzipOrZlib) != Z_OK)
        return Error{ErrorCode::LimitExceeded, path.string() + ": not enough memory"};
    const std::unique_ptr<z_stream, decltype(&inflateEnd)> end_it(&stream, inflateEnd);
    std::vector<Bytef> input(kPieceBytes), output(kPieceBytes);
    std::uint64_t held = 0;
    bool ended = false;
    while (!(ended && held >= expected) && held < expected + kPieceBytes) {
        if (stream.avail_in == 0) {
            file.read(reinterpret_cast<char*>(input.data()), std::streamsize(input.size()));
            stream.next_in = input.data();
            stream.avail_in = uInt(file.gcount());
        }
        if (stream.avail_in == 0)
            return damaged(path, ended ? "ends early: its compressed data hold less than its "
                                         "sizes say"
                                       : "ends early: its compressed data are cut off");
        if (ended) inflateReset(&stream);
        stream.next_out = output.data();
        stream.avail_out = uInt(output.size());
        const int result = inflate(&stream, Z_NO_FLUSH);
        ended = result == Z_STREAM_END;
        if (result != Z_OK && !ended)
            return damaged(path, std::string("its compressed data are damaged (") +
                                     (stream.msg ? stream.msg : "no gzip or zlib") + ")");
        held += output.size() - stream.avail_out;
    }
    return Ok{};
}

Status check_text(const fs::path& path, std::ifstream& file, std::uint64_t count) {
    std::string word;
    for (std::uint64_t n = 0; n < count; ++n) {
        if (!(file >> word))
            return damaged(path, "ends early: holds " + std::to_string(n) + " numbers, expected " +
                                     std::to_string(count));
        if (word.ends_with(',')) word.pop_back();
        if (!number_from(word))
            return damaged(path, "holds '" + shown(word) + "' among its data, expected a number");
    }
    return Ok{};
}

Status check_file(const fs::path& path, const ImageHeader& header, const fs::path& name,
                  std::uint64_t count) {
    const DataPlace& data = header.data;
    const std::string what = name == path ? "the file" : "its data file " + name.string();
    std::error_code error;
    const std::uint64_t length = fs::file_size(name, error);
    std::ifstream file(name, std::ios::binary);
    if (error || !file) return damaged(path, what + " can't be opened");
    file.seekg(std::streamoff(data.start));
    for (std::int64_t line = 0; line < data.line_skip && file; ++line)
        file.ignore(std::numeric_limits<std::streamsize>::max(), '\n');
    file.seekg(std::streamoff(data.byte_skip), std::ios::cur);
    const std::uint64_t start = file ? std::uint64_t(file.tellg()) : length;
    const std::uint64_t bytes = count * size_of(header.stored);
    std::uint64_t least = bytes;
    if (data.encoding == DataEncoding::Deflated) least /= kMaxCompressionRatio;
    if (data.encoding == DataEncoding::Text) least = 2 * count - 1;
    if (length < start || length - start < least)
        return damaged(path, "ends early: " + what + " has " + std::to_string(length) +
                                 " bytes, expected at least " + std::to_string(start + least));
    if (data.encoding == DataEncoding::Text) return check_text(path, file, count);
    if (data.encoding == DataEncoding::Deflated)
        return check_deflated(path, file, data.inner_skip + bytes);
    return Ok{};
}

}  // namespace

Status check_data_files(const fs::path& path, const DataPlace& data) {
    if (data.files.empty()) return damaged(path, "names 0 data files, expected one or more");
    std::error_code error;
    for (const fs::path& file : data.files)
        if (file != path && !fs::is_regular_file(file, error))
            return Error{ErrorCode::NotFound,
                         path.string() + ": its data file " + file.string() + " is missing"};
    return Ok{};
}

Status check_data(const fs::path& path, const ImageHeader& header) {
    const std::size_t count = header.data.files.size();
    const std::uint64_t values =
        std::uint64_t(voxel_count(header.grid)) * std::uint64_t(header.components);
    if (values % count != 0)
        return damaged(path, "names " + std::to_string(count) +
                                 " data files, expected a number that divides " +
                                 text_of_sizes(header.sizes) + " voxels");
    for (const fs::path& file : header.data.files)
        if (Status status = check_file(path, header, file, values / count); !status) return status;
    return Ok{};
}

std::vector<std::string> numbered_names(std::string_view text) {
    const auto words = split(text, ' ');
    const std::size_t percent = text.find('%');
    if (words.size() < 4 || percent == text.npos || words[0].find('%') == words[0].npos) return {};
    const std::string_view before = words[0].substr(0, words[0].find('%'));
    std::string_view rest = words[0].substr(before.size() + 1);
    const std::size_t end = rest.find_first_not_of("0123456789");
    if (end == rest.npos || (rest[end] != 'd' && rest[end] != 'i' && rest[end] != 'u')) return {};
    const char fill = rest.starts_with('0') ? '0' : ' ';
    const auto width = whole_number_from(rest.substr(0, end)).value_or(0);
    const std::string_view after = rest.substr(end + 1);
    const auto first = whole_number_from(words[1]), last = whole_number_from(words[2]),
               step = whole_number_from(words[3]);
    if (!first || !last || !step || *step == 0 || width > 32 ||
        (*last - *first) / *step >= kMaxDataFiles)
        return {};
    std::vector<std::string> names;
    for (std::int64_t n = *first; *step > 0 ? n <= *last : n >= *last; n += *step) {
        std::string number = std::to_string(n);
        if (number.size() < std::size_t(width))
            number.insert(0, std::size_t(width) - number.size(), fill);
        names.push_back(std::string(before) + number + std::string(after));
    }
    return names;
}

}  // namespace pliant
