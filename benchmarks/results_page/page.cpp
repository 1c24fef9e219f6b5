// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "page.h"

#include <charconv>
#include <chrono>
#include <fstream>
#include <thread>

namespace pliant::results {

std::string text_of(double number, int decimals) {
    char buffer[64];
    const auto end =
        std::to_chars(buffer, buffer + sizeof buffer, number, std::chars_format::fixed, decimals)
            .ptr;
    return std::string(buffer, end);
}

std::string text_of(std::int64_t count) {
    std::string digits = std::to_string(count);
    for (std::ptrdiff_t at = std::ptrdiff_t(digits.size()) - 3; at > (count < 0); at -= 3)
        digits.insert(std::size_t(at), "\u202f");
    return digits;
}

void Page::heading(int level, std::string_view text) {
    m_text += std::string(std::size_t(level), '#') + " " + std::string(text) + "\n\n";
}

void Page::paragraph(std::string_view text) {
    m_text += std::string(text) + "\n\n";
}

void Page::table(std::initializer_list<std::string> head,
                 const std::vector<std::vector<std::string>>& rows) {
    std::string rule = "|";
    m_text += "|";
    for (const std::string& cell : head) {
        m_text += " " + cell + " |";
        rule += rule.size() == 1 ? "---|" : "---:|";
    }
    m_text += "\n" + rule + "\n";
    for (const auto& row : rows) {
        m_text += "|";
        for (const std::string& cell : row) m_text += " " + cell + " |";
        m_text += "\n";
    }
    m_text += "\n";
}

void Page::picture(std::string_view name, std::string_view description, const Image& image) {
    const std::string file = std::string(name) + ".png";
    m_text += "![" + std::string(description) + "](" + file + ")\n\n";
    const auto place = m_files.stage(m_folder / file);
    const Status status = place.ok() ? write_png(*place, image) : Status(place.error());
    if (!status.ok() && m_failure.empty()) m_failure = status.error().message;
}

Status Page::finish() {
    if (!m_failure.empty()) return Error{ErrorCode::Unwritable, m_failure};
    const auto place = m_files.stage(m_folder / "README.md");
    if (!place.ok()) return place.error();
    while (m_text.ends_with("\n\n")) m_text.pop_back();
    std::ofstream file(*place, std::ios::binary);
    file << m_text;
    file.close();
    if (!file)
        return Error{ErrorCode::Unwritable,
                     (m_folder / "README.md").string() + ": can't be written"};
    return m_files.commit();
}

namespace {

/// "model name, n logical processors", as the system names them.
std::string machine_text() {
    std::ifstream file("/proc/cpuinfo");
    std::string line, model = "unknown processor";
    while (std::getline(file, line)) {
        if (!line.starts_with("model name")) continue;
        const auto colon = line.find(": ");
        if (colon != std::string::npos) model = line.substr(colon + 2);
        break;
    }
    return model + ", " + std::to_string(std::thread::hardware_concurrency()) + " cores";
}

/// ISO 8601, UTC.
std::string date_text() {
    using namespace std::chrono;
    const year_month_day day(floor<days>(system_clock::now()));
    const auto two = [](unsigned n) { return (n < 10 ? "0" : "") + std::to_string(n); };
    return std::to_string(int(day.year())) + "-" + two(unsigned(day.month())) + "-" +
           two(unsigned(day.day()));
}

}  // namespace

void Page::origin(const std::string& command) {
#ifdef __clang__
    constexpr const char* kCompiler = __VERSION__ ", release build";
#else
    constexpr const char* kCompiler = "GCC " __VERSION__ ", release build";
#endif
    table({"what", "this run"}, {{"command", "`" + command + "`"},
                                 {"date", date_text()},
                                 {"machine", machine_text()},
                                 {"compiler", kCompiler}});
}

}  // namespace pliant::results
