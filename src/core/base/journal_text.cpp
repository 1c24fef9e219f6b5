// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "base/journal_text.h"

#include <fcntl.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <string_view>
#include <utility>

#include "base/errors.h"
#include "base/input_file.h"

namespace pliant::staging {
namespace fs = std::filesystem;
namespace {

constexpr const char* kUnfinished = "unfinished";
constexpr std::string_view kFirstWord = "pliant outputs 1";
constexpr std::size_t kMaxBytes = std::size_t(64) << 20;

std::string text_of(const Journal& journal) {
    std::string text;
    const auto add = [&](std::string_view word) { text.append(word).push_back('\0'); };
    add(kFirstWord);
    for (const std::string& part : journal.parts) {
        add("part");
        add(part);
    }
    if (!journal.first.empty()) {
        add("first");
        add(journal.first);
    }
    for (const Move& move : journal.moves) {
        add(move.replaces ? "replace" : "new");
        add(move.slot);
        add(move.name);
    }
    add("end");
    return text;
}

bool is_name(const std::string& name) {
    return !name.empty() && name != "." && name != ".." && name.find('/') == name.npos;
}

bool is_number(const std::string& slot) {
    return !slot.empty() && slot.find_first_not_of("0123456789") == slot.npos;
}

/// @returns nullopt unless the text is complete, and all its names lie in one folder
std::optional<Journal> parse(std::string_view text) {
    Journal journal;
    const auto word = [&] {
        const auto end = std::min(text.find('\0'), text.size());
        std::string read(text.substr(0, end));
        text.remove_prefix(std::min(text.size(), end + 1));
        return read;
    };
    if (word() != kFirstWord) return std::nullopt;
    while (!text.empty()) {
        const std::string kind = word();
        if (kind == "end") return journal;
        if (kind == "part") {
            journal.parts.push_back(word());
        } else if (kind == "first") {
            journal.first = word();
        } else if (kind == "replace" || kind == "new") {
            Move move;
            move.replaces = kind == "replace";
            move.slot = word();
            move.name = word();
            if (!is_number(move.slot) || !is_name(move.name)) return std::nullopt;
            journal.moves.push_back(std::move(move));
        } else {
            return std::nullopt;
        }
    }
    return std::nullopt;
}

}  // namespace

Result<std::optional<Journal>> read_journal(const fs::path& file) {
    std::error_code error;
    const fs::file_type type = fs::symlink_status(file, error).type();
    if (type == fs::file_type::none) return unreadable(file, error.message());
    if (type != fs::file_type::regular) return std::optional<Journal>();
    InputFile opened(file);
    if (opened.status() && opened.size() > kMaxBytes) return std::optional<Journal>();
    const auto text = opened.read_rest();
    if (!text) return text.error();
    return parse(*text);
}

std::error_code write_journal(const fs::path& folder, const char* name, const Journal& journal) {
    const std::string text = text_of(journal);
    const fs::path unfinished = folder / kUnfinished;
    before_step();
    const Descriptor file = open_file(unfinished, O_WRONLY | O_CREAT | O_TRUNC, 0600);
    if (!file.is_open()) return {errno, std::generic_category()};
    before_step();
    if (const int error = write_all(file.number(), text.data(), text.size()))
        return {error, std::generic_category()};
    if (const auto error = sync_to_disk(unfinished)) return error;
    before_step();
    if (std::rename(unfinished.c_str(), (folder / name).c_str()) != 0)
        return {errno, std::generic_category()};
    if (const auto error = sync_to_disk(folder)) return error;
    return sync_to_disk(folder.has_parent_path() ? folder.parent_path() : fs::path("."));
}

}  // namespace pliant::staging
