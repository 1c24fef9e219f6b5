// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "page.h"

#include <pliant/view/png.h>

#include <algorithm>
#include <chrono>
#include <ctime>
#include <fstream>
#include <thread>

namespace pliant::results {

std::string grouped_text(std::int64_t count) {
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

namespace {

/// "model name, n logical processors", with the system's name.
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

double now_s() {
    const auto now = std::chrono::steady_clock::now().time_since_epoch();
    return std::chrono::duration<double>(now).count();
}

/// Busy time of all processors without this process [s].
double busy_with_others_s() {
    std::ifstream file("/proc/stat");
    std::string name;
    double user = 0, nice = 0, system = 0, idle = 0, waiting = 0, irq = 0, soft = 0, stolen = 0;
    if (!(file >> name >> user >> nice >> system >> idle >> waiting >> irq >> soft >> stolen))
        return 0;
    constexpr double kTicksPerSecond = 100;  // of this file, on all machines
    return (user + nice + system + irq + soft + stolen) / kTicksPerSecond -
           double(std::clock()) / CLOCKS_PER_SEC;
}

constexpr const char* kLoadPlace = "@load@";  ///< placeholder until finish()

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
                                 {"compiler", kCompiler},
                                 {"load", kLoadPlace}});
    m_start_s = now_s();
    m_busy_s = busy_with_others_s();
}

Status Page::finish() {
    if (!m_failure.empty()) return Error{ErrorCode::Unwritable, m_failure};
    if (const auto at = m_text.find(kLoadPlace); at != std::string::npos) {
        const double seconds = std::max(1e-3, now_s() - m_start_s);
        const double cores = std::max(0.0, busy_with_others_s() - m_busy_s) / seconds;
        m_text.replace(at, std::string_view(kLoadPlace).size(),
                       "a run of " + fixed_text(seconds, 0) + " s; other work on " +
                           fixed_text(cores, 2) + " cores, on the average");
    }
    const auto place = m_files.stage(m_folder / m_name);
    if (!place.ok()) return place.error();
    while (m_text.ends_with("\n\n")) m_text.pop_back();
    std::ofstream file(*place, std::ios::binary);
    file << m_text;
    file.close();
    if (!file)
        return Error{ErrorCode::Unwritable, (m_folder / m_name).string() + ": can't be written"};
    return m_files.commit();
}

}  // namespace pliant::results
