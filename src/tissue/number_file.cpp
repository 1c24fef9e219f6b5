// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "tissue/number_file.h"

#include <pliant/files.h>

#include <bit>
#include <fstream>

#include "core/errors.h"
#include "core/hash.h"

namespace pliant {
namespace {

void write_word(std::ostream& stream, std::uint64_t word) {
    char bytes[8];
    for (int k = 0; k < 8; ++k) bytes[k] = char(word >> 8 * k & 0xff);
    stream.write(bytes, 8);
}
std::uint64_t read_word(std::istream& stream) {
    unsigned char bytes[8] = {};
    stream.read(reinterpret_cast<char*>(bytes), 8);
    std::uint64_t word = 0;
    for (int k = 0; k < 8; ++k) word |= std::uint64_t(bytes[k]) << 8 * k;
    return word;
}
std::uint64_t checksum_of(std::uint64_t magic, std::span<const double> numbers) {
    Hash64 hash;
    hash.add_word(magic);
    hash.add_word(numbers.size());
    for (const double v : numbers) hash.add_word(std::bit_cast<std::uint64_t>(v));
    return hash.value();
}

}  // namespace

Status save_numbers(const std::filesystem::path& path, std::uint64_t magic,
                    std::span<const double> numbers) {
    StagedFiles files;
    const auto staged = files.stage(path);
    if (!staged.ok()) return staged.error();
    std::ofstream stream(*staged, std::ios::binary);
    write_word(stream, magic);
    write_word(stream, numbers.size());
    for (const double v : numbers) write_word(stream, std::bit_cast<std::uint64_t>(v));
    write_word(stream, checksum_of(magic, numbers));
    stream.close();
    if (!stream)
        return Error{ErrorCode::Unwritable, path.filename().string() + ": can't be written"};
    return files.commit();
}

Result<std::vector<double>> load_numbers(const std::filesystem::path& path, std::uint64_t magic) {
    const auto wrong = [&](const char* what) { return unreadable(path.filename(), what); };
    std::error_code ignored;
    if (!std::filesystem::is_regular_file(path, ignored))
        return wrong("expected a file, found none");
    std::ifstream stream(path, std::ios::binary);
    if (!stream) return wrong("expected a file, found none");
    if (read_word(stream) != magic) return wrong("expected a state of this tissue");
    const std::uint64_t count = read_word(stream);
    std::error_code error;
    const auto bytes = std::filesystem::file_size(path, error);
    // Before the allocation.
    if (error || bytes < 24 || count != (bytes - 24) / 8 || bytes % 8 != 0)
        return wrong("damaged or cut short");
    std::vector<double> numbers(count);
    for (double& v : numbers) v = std::bit_cast<double>(read_word(stream));
    const std::uint64_t checksum = read_word(stream);
    if (!stream || checksum != checksum_of(magic, numbers)) return wrong("damaged or cut short");
    return numbers;
}

}  // namespace pliant
