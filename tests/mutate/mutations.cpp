// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "mutate/mutations.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cstdint>

namespace pliant::mutate {
namespace {

/// A file gets no larger by changes: the runner's memory counts in the peak of its children.
constexpr std::size_t kMaxBytes = std::size_t(1) << 20;

struct Part {
    std::size_t begin = 0, length = 0;
};

std::size_t somewhere(const std::string& text, Random& random) {
    return std::size_t(random.whole(0, int(text.size())));
}

Part some_part(const std::string& text, Random& random) {
    const std::size_t begin = somewhere(text, random);
    const int left = int(text.size() - begin);
    const int longest = random.whole(0, 3) > 0 ? std::min(left, 16) : left;
    return {begin, std::size_t(random.whole(0, longest))};
}

/// A line with its end.
Part some_line(const std::string& text, Random& random) {
    const std::size_t at = somewhere(text, random);
    const std::size_t before = at == 0 ? std::string::npos : text.rfind('\n', at - 1);
    const std::size_t begin = before == std::string::npos ? 0 : before + 1;
    const std::size_t end = std::min(text.find('\n', begin), text.size() - 1);
    return {begin, text.empty() ? 0 : end + 1 - begin};
}

bool is_number_byte(char c) {
    return std::isdigit(static_cast<unsigned char>(c)) || c == '.' || c == '-' || c == '+';
}

/// The number at or after some position; length 0: none.
Part some_number(const std::string& text, Random& random) {
    std::size_t begin = somewhere(text, random);
    const auto is_digit = [&](std::size_t at) {
        return std::isdigit(static_cast<unsigned char>(text[at])) != 0;
    };
    while (begin < text.size() && !is_digit(begin)) ++begin;
    if (begin == text.size()) return {};
    std::size_t end = begin;
    while (end < text.size() && (is_number_byte(text[end]) || text[end] == 'e')) ++end;
    while (begin > 0 && is_number_byte(text[begin - 1])) --begin;
    return {begin, end - begin};
}

std::size_t some_length(Random& random) {
    static const std::vector<int> lengths = {2,   16,  127, 128, 254,  255,  256,  257,
                                             400, 500, 511, 512, 1000, 1024, 4096, 65536};
    return std::size_t(any_of(lengths, random));
}

std::string run_of(std::size_t length, Random& random) {
    static const std::vector<std::string> units = {"A",  "A",  "A",  "0", "9",    " ",
                                                   "%s", "\"", "\\", "/", "\xff", "\xc3\xa9",
                                                   ",",  "-",  "1 ", "."};
    const std::string& unit = any_of(units, random);
    std::string run;
    run.reserve(length + unit.size());
    while (run.size() < length) run += unit;
    return run;
}

void flip_bit(std::string& text, const Words&, Random& random) {
    if (text.empty()) return;
    char& c = text[std::size_t(random.whole(0, int(text.size()) - 1))];
    c = char(c ^ (1 << random.whole(0, 7)));
}

void set_bytes(std::string& text, const Words&, Random& random) {
    const Part part = some_part(text, random);
    for (std::size_t n = 0; n < part.length; ++n) text[part.begin + n] = char(random.next());
}

/// A binary number of two, four or eight bytes, in either byte order.
void set_number(std::string& text, const Words&, Random& random) {
    static const std::vector<std::uint64_t> numbers = {0,
                                                       1,
                                                       2,
                                                       4,
                                                       0x7f,
                                                       0x80,
                                                       0xff,
                                                       0x100,
                                                       0x7fff,
                                                       0x8000,
                                                       0xffff,
                                                       0x10000,
                                                       0x7fffffff,
                                                       0x80000000,
                                                       0xffffffff,
                                                       0x100000000,
                                                       0x7fffffffffffffff,
                                                       0x8000000000000000,
                                                       0xffffffffffffffff,
                                                       0x7f800000,
                                                       0x7fc00000,
                                                       0x7ff0000000000000,
                                                       0x7ff8000000000000,
                                                       0x7fe1ccf385ebc8a0};
    const std::size_t size = std::size_t(1) << random.whole(1, 3);
    if (text.size() < size) return;
    const auto at = std::size_t(random.whole(0, int(text.size() - size)));
    const std::uint64_t value = any_of(numbers, random);
    const bool big = random.whole(0, 1) == 1;
    for (std::size_t n = 0; n < size; ++n)
        text[at + (big ? size - 1 - n : n)] = char(value >> 8 * n & 0xff);
}

void insert_bytes(std::string& text, const Words&, Random& random) {
    std::string garbage(std::size_t(random.whole(1, 24)), '\0');
    for (char& c : garbage) c = char(random.next());
    text.insert(somewhere(text, random), garbage);
}

void insert_controls(std::string& text, const Words&, Random& random) {
    static const std::vector<std::string> controls = {
        "\x1b]0;x\x07", "\x1b[2J", std::string(1, '\0'), "\r", "\x7f", "\x80\xbf", "\n",
        "\t",           "\xc2\x9b"};
    text.insert(somewhere(text, random), any_of(controls, random));
}

void remove_part(std::string& text, const Words&, Random& random) {
    const Part part = some_part(text, random);
    text.erase(part.begin, part.length);
}

void cut_off(std::string& text, const Words&, Random& random) {
    text.resize(somewhere(text, random));
}

void splice(std::string& text, const Words&, Random& random) {
    const Part part = some_part(text, random);
    const std::string copy = text.substr(part.begin, part.length);
    text.insert(somewhere(text, random), copy);
}

void repeat_line(std::string& text, const Words&, Random& random) {
    const Part line = some_line(text, random);
    const std::string copy = text.substr(line.begin, line.length);
    const int times = random.whole(0, 7) > 0 ? 1 : random.whole(2, 2000);
    std::string all;
    for (int n = 0; n < times && all.size() < kMaxBytes; ++n) all += copy;
    text.insert(line.begin, all);
}

void remove_line(std::string& text, const Words&, Random& random) {
    const Part line = some_line(text, random);
    text.erase(line.begin, line.length);
}

void move_line(std::string& text, const Words&, Random& random) {
    const Part line = some_line(text, random);
    const std::string copy = text.substr(line.begin, line.length);
    text.erase(line.begin, line.length);
    text.insert(some_line(text, random).begin, copy);
}

void replace_number(std::string& text, const Words&, Random& random) {
    const Part number = some_number(text, random);
    if (number.length > 0) text.replace(number.begin, number.length, odd_number(random));
}

void insert_word(std::string& text, const Words& words, Random& random) {
    if (words.empty()) return;
    const std::string& word = any_of(words, random);
    switch (random.whole(0, 2)) {
        case 0:
            text.insert(somewhere(text, random), word);
            break;
        case 1:
            text.insert(some_line(text, random).begin, word + "\n");
            break;
        default:
            text.insert(some_line(text, random).begin, word + odd_number(random) + "\n");
    }
}

/// A field's value, name or separator gets longer.
void lengthen_field(std::string& text, const Words&, Random& random) {
    const Part line = some_line(text, random);
    const std::size_t separator = text.find_first_of(":= ", line.begin);
    std::size_t at = line.begin + line.length;
    if (at > line.begin && text[at - 1] == '\n') --at;
    if (separator < at && random.whole(0, 2) == 0) at = separator;
    text.insert(at, run_of(some_length(random), random));
}

/// A field of the format's own with a long value.
void insert_long_field(std::string& text, const Words& words, Random& random) {
    const std::string name = words.empty() ? "" : any_of(words, random);
    text.insert(some_line(text, random).begin, name + run_of(some_length(random), random) + "\n");
}

void insert_nesting(std::string& text, const Words&, Random& random) {
    static const std::vector<std::string> units = {"[",  "{",       "a.",  "a.",
                                                   "[[", "{\"a\":", "<a>", "-"};
    static const std::vector<int> depths = {10, 1000, 10000, 50000, 100000};
    const std::string& unit = any_of(units, random);
    const int depth = any_of(depths, random);
    std::string nest;
    for (int n = 0; n < depth; ++n) nest += unit;
    const bool is_line = unit == "a." || random.whole(0, 1) == 1;
    if (unit == "a.") nest += "a = 1\n";
    text.insert(is_line ? some_line(text, random).begin : somewhere(text, random), nest);
}

using Change = void (*)(std::string&, const Words&, Random&);

/// Changes that mostly pass a reader's first checks are listed more than once.
constexpr std::array<Change, 25> kChanges = {
    flip_bit,        flip_bit,       flip_bit,          set_bytes,
    set_number,      set_number,     insert_bytes,      insert_controls,
    insert_controls, remove_part,    remove_part,       cut_off,
    splice,          repeat_line,    remove_line,       move_line,
    replace_number,  replace_number, replace_number,    insert_word,
    insert_word,     lengthen_field, insert_long_field, insert_nesting,
    insert_nesting};

}  // namespace

std::string odd_number(Random& random) {
    static const std::vector<std::string> numbers = {"0",
                                                     "-0",
                                                     "1",
                                                     "-1",
                                                     "2",
                                                     "3",
                                                     "7",
                                                     "16",
                                                     "255",
                                                     "256",
                                                     "4095",
                                                     "65535",
                                                     "65536",
                                                     "2147483647",
                                                     "2147483648",
                                                     "-2147483648",
                                                     "4294967295",
                                                     "4294967296",
                                                     "9223372036854775807",
                                                     "-9223372036854775808",
                                                     "18446744073709551615",
                                                     "18446744073709551616",
                                                     "1e308",
                                                     "-1e308",
                                                     "1e309",
                                                     "1e-308",
                                                     "1e-320",
                                                     "-1e-320",
                                                     "0.5",
                                                     "1e6",
                                                     "1e15",
                                                     "1e38",
                                                     "1e39",
                                                     "nan",
                                                     "-nan",
                                                     "inf",
                                                     "-inf",
                                                     "0x10",
                                                     "010",
                                                     "1e",
                                                     "--1",
                                                     "1.2.3",
                                                     "",
                                                     "1,5",
                                                     "99999999999999999999999999999999999999"};
    return any_of(numbers, random);
}

void mutate(std::string& bytes, std::size_t header, const Words& words, Random& random) {
    const int count = random.whole(0, 1) ? 1 : random.whole(1, 4);
    header = std::min(header, bytes.size());
    std::string front = bytes.substr(0, header), rest = bytes.substr(header);
    for (int n = 0; n < count; ++n) {
        const bool in_front = header > 0 && (rest.empty() || random.whole(0, 3) > 0);
        const Change change = kChanges[std::size_t(random.whole(0, int(kChanges.size()) - 1))];
        std::string& part = in_front ? front : rest;
        change(part, words, random);
        if (part.size() > kMaxBytes) part.resize(kMaxBytes);
    }
    bytes = front + rest;
}

}  // namespace pliant::mutate
