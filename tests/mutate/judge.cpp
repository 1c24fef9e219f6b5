// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "mutate/judge.h"

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <nlohmann/json.hpp>
#include <regex>

#include "support/temporary_folder.h"

namespace pliant::mutate {
namespace {

namespace fs = std::filesystem;

/// Control characters other than line ends (on standard output: and tabs), and invalid UTF-8.
bool has_raw_bytes(const std::string& text, bool tabs) {
    for (const char c : text) {
        if (c == '\n' || (tabs && c == '\t')) continue;
        if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) return true;
    }
    // The parser's look at a string is a look at its UTF-8.
    std::string quoted = "\"";
    for (const char c : text)
        if (static_cast<unsigned char>(c) >= 0x80) quoted += c;
    return !nlohmann::json::accept(quoted + "\"");
}

std::size_t longest_line(const std::string& text) {
    std::size_t longest = 0, begin = 0;
    while (begin <= text.size()) {
        const std::size_t end = std::min(text.find('\n', begin), text.size());
        longest = std::max(longest, end - begin);
        begin = end + 1;
    }
    return longest;
}

/// Removes progress lines of long runs: "pliant: deform: 40 % after 7 s".
std::string without_progress(const std::string& text) {
    static const std::regex progress("^pliant: [a-z -]+: [0-9]+ % after [0-9]+ s$");
    std::string rest;
    for (std::size_t begin = 0; begin < text.size();) {
        const std::size_t end = std::min(text.find('\n', begin), text.size() - 1) + 1;
        const std::string line = text.substr(begin, end - begin);
        const bool is_short = line.size() < 80 && line.back() == '\n';
        if (!is_short || !std::regex_match(line.substr(0, line.size() - 1), progress)) rest += line;
        begin = end;
    }
    return rest;
}

/// Whether it is one line, perhaps with a table of series below.
bool is_one_line(const std::string& text) {
    const std::string_view below = std::string_view(text).substr(text.find('\n') + 1);
    return text.starts_with("pliant: ") && (below.empty() || below.starts_with("number  "));
}

void judge_files(const Ended& run, const Contents& before, const Contents& after,
                 std::vector<std::string>& faults) {
    for (const auto& [name, bytes] : before) {
        const auto now = after.find(name);
        if (now == after.end())
            faults.push_back("the input " + name + " is gone");
        else if (now->second != bytes)
            faults.push_back("the input " + name + " has changed");
    }
    for (const auto& [name, bytes] : after) {
        if (before.contains(name)) continue;
        const bool temporary = name.starts_with(".tmp/") || name.find(".pliant-") != name.npos;
        if (run.status == kRefused || temporary)
            faults.push_back("left behind: " + printable(name, 60));
    }
}

}  // namespace

Contents contents_of(const fs::path& folder) {
    Contents contents;
    std::error_code error;
    for (fs::recursive_directory_iterator at(folder, error), end; !error && at != end;
         at.increment(error)) {
        const std::string name = at->path().lexically_relative(folder).string();
        std::error_code none;
        if (at->is_symlink(none))
            contents[name] = fs::read_symlink(at->path(), none).string();
        else if (at->is_directory(none))
            contents[name + "/"];
        else
            contents[name] = test::bytes_of(at->path());
    }
    return contents;
}

std::vector<std::string> faults_of(const Answer& answer, const std::vector<std::string>& expected,
                                   double max_seconds) {
    std::vector<std::string> faults;
    const std::string& body = answer.body;
    if (answer.status.empty())
        faults.push_back("no answer");
    else if (std::find(expected.begin(), expected.end(), answer.status) == expected.end())
        faults.push_back("status " + answer.status);
    if (answer.seconds > max_seconds)
        faults.push_back("an answer after " + std::to_string(int(answer.seconds)) + " s");
    if (answer.status.empty()) return faults;
    if (body.empty() || body.find('\n') != body.size() - 1)
        faults.push_back("expected one line, found " +
                         std::to_string(std::count(body.begin(), body.end(), '\n')));
    if (answer.status != "300" && longest_line(body) > kMaxAnswerBytes)
        faults.push_back("an answer of " + std::to_string(body.size()) + " bytes");
    if (has_raw_bytes(body, false)) faults.push_back("raw bytes in the answer");
    return faults;
}

std::string printable(std::string_view text, std::size_t max_length) {
    std::string shown;
    for (const char c : text) {
        if (shown.size() >= max_length) return shown + "…";
        char escaped[8];
        std::snprintf(escaped, sizeof escaped, "\\x%02x", unsigned(static_cast<unsigned char>(c)));
        shown += c < 0x20 || c == 0x7f ? std::string(escaped) : std::string(1, c);
    }
    return shown;
}

std::vector<std::string> faults_of(const Ended& run, const Contents& before, const Contents& after,
                                   const Rules& rules) {
    std::vector<std::string> faults;
    const std::string err = without_progress(run.err);
    if (rules.judge_memory && run.peak_mb > kMaxPeakMb)
        faults.push_back(std::to_string(int(run.peak_mb)) + " MB of memory");
    if (run.too_long) {
        if (!rules.may_be_long) faults.push_back("ran until its time was up");
        return faults;
    }
    if (run.signal != 0) {
        faults.push_back("signal " + std::to_string(run.signal) + " (" + ::strsignal(run.signal) +
                         ")");
        return faults;
    }
    if (run.status != kTaken && run.status != kRefused)
        faults.push_back("exit status " + std::to_string(run.status));
    if (run.status == kRefused && !is_one_line(err))
        faults.push_back("expected one line on standard error, found " +
                         std::to_string(std::count(err.begin(), err.end(), '\n')));
    if (run.status == kTaken && !err.empty())
        faults.push_back("status 0, yet something on standard error");
    if (const std::size_t length = longest_line(err); length > kMaxLineBytes)
        faults.push_back("a message of " + std::to_string(length) + " bytes");
    if (has_raw_bytes(err, false)) faults.push_back("raw bytes in the message");
    // Valid JSON has none but 7f, which it may have.
    if (!rules.expects_json && has_raw_bytes(run.out, true))
        faults.push_back("raw bytes on standard output");
    if (run.status == kTaken && rules.expects_json && !nlohmann::json::accept(run.out))
        faults.push_back("expected JSON on standard output");
    judge_files(run, before, after, faults);
    return faults;
}

}  // namespace pliant::mutate
