// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "formats/data_check.h"

#include "base/errors.h"
#include "base/input_file.h"
#include "base/text.h"

#include <limits>
#include <optional>

namespace pliant {
namespace fs = std::filesystem;
namespace {

/// Maximum ratio of decompressed to compressed bytes (deflate's own bound is 1032).
constexpr std::uint64_t kMaxCompressionRatio = 1040;
/// Maximum number of files of one image.
constexpr std::int64_t kMaxDataFiles = kMaxAxisSize;
/// Bound on numbers in their names that avoids overflow of differences.
constexpr std::int64_t kMaxFileNumber = 1'000'000'000'000;

/// Makes the name of a data file safe for messages, because a header may contain any text.
std::string shown_name(const fs::path& file) {
    return printable(file.string(), 200);
}

/// Error that starts with the data file's name, which is long in some headers.
Error about_data_file(const fs::path& path, const fs::path& file, const Error& error) {
    return unreadable(
        path, "its data file " + shown_name(file) + error.message.substr(file.string().size()));
}

/// Uncompressed bytes of the image in each data file.
std::uint64_t bytes_per_file(const ImageHeader& header) {
    const std::uint64_t values =
        std::uint64_t(voxel_count(header.grid)) * std::uint64_t(header.components);
    return values / header.data.files.size() * size_of(header.stored);
}

}  // namespace

Status check_data_files(const fs::path& path, const DataLocation& data) {
    const auto count = std::int64_t(data.files.size());
    if (count == 0) return unreadable(path, "names 0 data files, expected one or more");
    for (const fs::path& file : data.files) {
        const auto type = type_of(file);
        if (!type) return about_data_file(path, file, type.error());
        if (file != path && *type != fs::file_type::regular)
            return Error{ErrorCode::NotFound,
                         path.string() + ": its data file " + shown_name(file) + " is missing"};
    }
    if (data.expected_files != 0 && count != data.expected_files)
        return unreadable(path, "names " + std::to_string(count) + " data files, expected " +
                                    std::to_string(data.expected_files));
    return Ok{};
}

Result<std::uint64_t> find_data_start(const fs::path& path, const ImageHeader& header,
                                      const fs::path& name) {
    const DataLocation& data = header.data;
    const std::string what = name == path ? "the file" : "its data file " + shown_name(name);
    InputFile file(name);
    const std::uint64_t length = file.size();
    file.seek(data.start);
    int c = 0;
    for (std::int64_t line = 0; line < data.line_skip && c != InputFile::kEnd; ++line) do
            c = file.get();
        while (c != '\n' && c != InputFile::kEnd);
    if (Status status = file.status(); !status)
        return name == path ? status.error() : about_data_file(path, name, status.error());
    // A header may skip any number of bytes.
    constexpr auto kMax = std::numeric_limits<std::uint64_t>::max();
    const bool is_beyond = c == InputFile::kEnd || data.byte_skip > kMax - file.at();
    const std::uint64_t start = is_beyond ? length : file.at() + data.byte_skip;
    const std::uint64_t bytes = bytes_per_file(header);
    std::uint64_t least = bytes;
    if (data.encoding == DataEncoding::Deflated)
        least = (least + data.inner_skip) / kMaxCompressionRatio;
    if (data.encoding == DataEncoding::VtkArray && data.vtk.codec != VtkArray::Codec::None)
        least /= kMaxCompressionRatio;
    if (data.encoding == DataEncoding::Text) least = 2 * (bytes / size_of(header.stored)) - 1;
    if (length < start || length - start < least)
        return unreadable(path, "ends early: " + what + " has " + std::to_string(length) +
                                    " bytes, expected at least " + std::to_string(start + least));
    return data.at_end && data.encoding == DataEncoding::Raw ? length - bytes : start;
}

Status check_data(const fs::path& path, const ImageHeader& header) {
    const std::size_t count = header.data.files.size();
    const std::uint64_t values =
        std::uint64_t(voxel_count(header.grid)) * std::uint64_t(header.components);
    if (values % count != 0)
        return unreadable(path, "names " + std::to_string(count) +
                                    " data files, expected a number that divides " +
                                    text_of_sizes(header.sizes) + " voxels");
    if (header.data.inner_skip > kMaxInnerSkip)
        return unreadable(path, "skips " + std::to_string(header.data.inner_skip) +
                                    " bytes of its compressed data, expected at most " +
                                    std::to_string(kMaxInnerSkip));
    for (const fs::path& file : header.data.files)
        if (const auto start = find_data_start(path, header, file); !start) return start.error();
    return Ok{};
}

Result<std::uint64_t> bytes_beyond(const fs::path& path, const ImageHeader& header) {
    if (header.data.encoding != DataEncoding::Raw) return std::uint64_t(0);
    std::uint64_t beyond = 0;
    for (const fs::path& file : header.data.files) {
        const auto start = find_data_start(path, header, file);
        if (!start) return start.error();
        const InputFile opened(file);
        if (Status status = opened.status(); !status)
            return file == path ? status.error() : about_data_file(path, file, status.error());
        beyond += opened.size() - *start - bytes_per_file(header);
    }
    return beyond;
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
    const auto is_small = [](const std::optional<std::int64_t>& number) {
        return number && *number >= -kMaxFileNumber && *number <= kMaxFileNumber;
    };
    if (!is_small(first) || !is_small(last) || !is_small(step) || *step == 0 || width < 0 ||
        width > 32 || (*last - *first) / *step >= kMaxDataFiles)
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
