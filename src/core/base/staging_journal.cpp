// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "base/staging_journal.h"

#include <fcntl.h>
#include <pliant/core/files.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <optional>
#include <span>
#include <string_view>
#include <utility>

#include "base/descriptor.h"
#include "base/errors.h"
#include "base/input_file.h"

namespace pliant::staging {
namespace fs = std::filesystem;
namespace {

// The journal of a commit as a file: words terminated by a zero byte, which file names can't
// contain.

struct Journal {
    std::vector<std::string> parts{};  ///< temporary folders of the other folders with outputs
    std::string first{};               ///< in a part: the folder with the deciding journal
    std::vector<Move> moves{};
};

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

namespace fs = std::filesystem;

/// @returns nullopt unless the file is complete, and all its names lie in one folder
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

/// Writes to a temporary name, syncs and renames.
std::error_code write_journal(const fs::path& folder, const char* name, const Journal& journal) {
    const std::string text = text_of(journal);
    const fs::path unfinished = folder / kUnfinished;
    before_step();
    Descriptor file = open_file(unfinished, O_WRONLY | O_CREAT | O_TRUNC, 0600);
    if (!file.is_open()) return {errno, std::generic_category()};
    before_step();
    if (const int error = write_all(file.number(), text.data(), text.size()))
        return {error, std::generic_category()};
    if (const int error = file.close()) return {error, std::generic_category()};
    if (const auto error = sync_to_disk(unfinished)) return error;
    before_step();
    if (std::rename(unfinished.c_str(), (folder / name).c_str()) != 0)
        return {errno, std::generic_category()};
    if (const auto error = sync_to_disk(folder)) return error;
    return sync_to_disk(folder.has_parent_path() ? folder.parent_path() : fs::path("."));
}

// The first folder's journal is `redo`, renamed to `undo` after a failed move. The others have
// `part`, which names the first one.
constexpr const char* kRedo = "redo";
constexpr const char* kUndo = "undo";
constexpr const char* kPart = "part";

/// Paths of a move, allocated before the commit: nothing is allocated later.
struct Paths {
    fs::path from, to, backup;
    bool replaces;
};

fs::path beside(const fs::path& folder, const std::string& name) {
    return folder.has_parent_path() ? folder.parent_path() / name : fs::path(name);
}

Paths paths_of(const fs::path& folder, const Move& move) {
    return {folder / move.slot / move.name, beside(folder, move.name),
            folder / ("before-" + move.slot) / move.name, move.replaces};
}

/// @param[out] is_there  whether there is a file @returns an error if the system can't tell
std::error_code look_for(const fs::path& path, bool& is_there) noexcept {
    struct stat status {};
    is_there = ::lstat(path.c_str(), &status) == 0;
    if (is_there || errno == ENOENT || errno == ENOTDIR) return {};
    return {errno, std::generic_category()};
}

std::error_code rename_file(const fs::path& from, const fs::path& to) noexcept {
    before_step();
    if (::rename(from.c_str(), to.c_str()) == 0) return {};
    return {errno, std::generic_category()};
}

/// Idempotent: a file that no longer exists is already at its target.
std::error_code redo(const Paths& p) noexcept {
    bool is_there = false;
    const auto error = look_for(p.from, is_there);
    return is_there ? rename_file(p.from, p.to) : error;
}

/// Idempotent.
std::error_code undo(const Paths& p) noexcept {
    bool is_there = false;
    std::error_code error = look_for(p.replaces ? p.backup : p.from, is_there);
    if (p.replaces) return is_there ? rename_file(p.backup, p.to) : error;
    if (error || is_there) return error;
    error = look_for(p.to, is_there);
    return is_there ? rename_file(p.to, p.from) : error;
}

/// Links the old file to a backup name, so that the target always exists. On file systems without
/// hard links, the old file is moved.
std::error_code keep_old(const Paths& p) noexcept {
    if (!p.replaces) return {};
    before_step();
    if (::link(p.to.c_str(), p.backup.c_str()) == 0) return {};
    const int why = errno;
    struct stat status {};
    if (::lstat(p.to.c_str(), &status) != 0 || !S_ISREG(status.st_mode))
        return {why, std::generic_category()};  // it was a file when it was staged
    return rename_file(p.to, p.backup);
}

void remove_file(const fs::path& file) noexcept {
    before_step();
    ::unlink(file.c_str());
}

// Leftovers of ended processes

void tell(const std::string& line) noexcept {
    try {
        if (const RecoveryListener listener = recovery_listener()) listener(line.c_str());
    } catch (...) {  // thrown by a listener
    }
}

std::error_code carry_out(const fs::path& folder, const Journal& journal, bool forwards) {
    std::vector<Paths> all;
    for (const Move& move : journal.moves) all.push_back(paths_of(folder, move));
    if (!forwards) std::reverse(all.begin(), all.end());
    for (const Paths& paths : all)
        if (const auto error = forwards ? redo(paths) : undo(paths)) return error;
    return sync_to_disk(folder.has_parent_path() ? folder.parent_path() : fs::path("."));
}

/// Another folder of the same commit, locked.
struct Part {
    fs::path folder;
    Descriptor lock;
    Journal journal;
};

Result<std::vector<Part>> parts_of(const fs::path& folder, const Journal& journal) {
    std::vector<Part> parts;
    for (const std::string& part : journal.parts) {
        if (!fs::path(part).filename().native().starts_with(kPrefix)) continue;
        Lock lock{};
        auto opened = open_and_lock(part, true, lock);
        if (lock == Lock::Gone) continue;
        if (!opened) return unreadable(part, "can't be opened");
        auto own = read_journal(fs::path(part) / kPart);
        if (!own) return own.error();
        // It must refer to this folder: a name alone isn't sufficient.
        std::error_code ignored;
        if (*own && fs::equivalent((*own)->first, folder, ignored))
            parts.push_back({part, std::move(*opened), std::move(**own)});
    }
    return parts;
}

/// Carries out the parts first, as commit does.
std::error_code carry_out(const fs::path& folder, const Journal& journal,
                          const std::vector<Part>& parts, bool forwards) {
    std::error_code error;
    for (const Part& part : parts)
        if (!error) error = carry_out(part.folder, part.journal, forwards);
    return error ? error : carry_out(folder, journal, forwards);
}

/// Finishes a locked folder with a journal. @param forwards  it is `redo`, else `undo`
/// @returns false if that isn't possible now
bool finish(const fs::path& folder, bool forwards) {
    fs::path file = folder / (forwards ? kRedo : kUndo);
    const std::string parent = folder.has_parent_path() ? folder.parent_path().string() : ".";
    const auto fail = [&](const std::string& why) {
        tell(parent +
             ": outputs of an earlier run, which was ended, can't be put in their places (" + why +
             "); they are in " + folder.filename().string());
        return false;
    };
    const auto journal = read_journal(file);
    if (!journal) return fail(journal.error().message);
    if (!*journal) {
        tell(folder.string() + ": the journal of an earlier run is damaged; its files are there");
        return false;
    }
    const auto parts = parts_of(folder, **journal);
    if (!parts) return fail(parts.error().message);
    std::error_code error = carry_out(folder, **journal, *parts, forwards);
    if (error && forwards && !rename_file(file, folder / kUndo)) {
        forwards = false;
        file = folder / kUndo;
        error = carry_out(folder, **journal, *parts, forwards);
    }
    if (error) return fail(error.message());
    // The journal is removed last: until then everything is repeatable.
    for (const Part& part : *parts) remove_tree(part.folder.c_str());
    remove_file(file);
    remove_tree(folder.c_str());
    tell(parent + (forwards
                       ? ": an earlier run was ended while it put its outputs in their places; "
                         "all are there now"
                       : ": an earlier run was ended while it took its outputs back; the old "
                         "files are there again"));
    return true;
}

void sweep_folder(const fs::path& folder) {
    Lock lock{};
    auto opened = open_and_lock(folder, false, lock);
    if (!opened || lock != Lock::Taken) return;
    // A folder about which the system can't tell is left to a later run.
    bool redo = false, undo = false;
    if (look_for(folder / kRedo, redo) || look_for(folder / kUndo, undo)) return;
    if (redo || undo) {
        finish(folder, redo);
        return;
    }
    const auto part = read_journal(folder / kPart);
    if (!part) return;
    const fs::path first = *part ? (*part)->first : std::string();
    if (first.filename().native().starts_with(kPrefix)) {
        if (look_for(first / kRedo, redo) || look_for(first / kUndo, undo)) return;
        if (redo || undo) {
            opened.reset();  // the first folder's turn locks it again
            auto lead = open_and_lock(first, false, lock);
            if (!lead || lock != Lock::Taken) return;
            if (look_for(first / kRedo, redo) || look_for(first / kUndo, undo)) return;
            if (redo || undo) finish(first, redo);
            return;
        }
    }
    remove_tree(folder.c_str());
}

}  // namespace

void sweep(const fs::path& parent) {
    const auto names = names_in(parent);
    if (!names) return;  // the next run retries
    for (const std::string& name : *names)
        if (name.starts_with(kPrefix)) sweep_folder(parent == "." ? fs::path(name) : parent / name);
}

namespace {

/// @returns the first error; `failed` is the index of the failed move
std::error_code carry_out(std::span<Paths> all, std::size_t& failed) noexcept {
    for (failed = 0; failed < all.size(); ++failed) {
        auto error = keep_old(all[failed]);
        if (!error) error = rename_file(all[failed].from, all[failed].to);
        if (error) return error;
    }
    return {};
}

Error failed_at(const Paths& paths, const std::error_code& error) {
    return {ErrorCode::Unwritable,
            paths.to.string() + ": can't be written (" + error.message() + ")"};
}

/// Backup names lie in separate folders, because a name may already have the maximum length.
/// @param keeps  backs up old files; a single rename is atomic without a backup
Status prepare(std::vector<Moves>& all, bool keeps) {
    for (Moves& of : all)
        for (Move& move : of.moves) {
            const Paths paths = paths_of(of.folder->path(), move);
            struct stat status {};
            const bool is_there = ::lstat(paths.to.c_str(), &status) == 0;
            if (!is_there && errno != ENOENT)
                return failed_at(paths, {errno, std::generic_category()});
            move.replaces = keeps && is_there;
            if (!move.replaces) continue;
            if (S_ISDIR(status.st_mode))
                return failed_at(paths, std::make_error_code(std::errc::is_a_directory));
            before_step();
            if (::mkdir(paths.backup.parent_path().c_str(), 0700) != 0 && errno != EEXIST)
                return failed_at(paths, {errno, std::generic_category()});
        }
    return Ok{};
}

/// All is in place, but not the folder on the disk.
void tell_unsynced(const Moves& of, const std::error_code& error) noexcept {
    try {
        tell((of.folder->parent() / of.moves.front().name).string() +
             ": is written, but may be lost if the power fails now (" + error.message() + ")");
    } catch (...) {  // out of memory
    }
}

Status write_journals(const std::vector<Moves>& all) {
    std::error_code error;
    const auto whole = [&](const Folder* folder) {
        return fs::absolute(folder->path(), error).string();
    };
    Journal first{.moves = all.front().moves};
    for (std::size_t n = 1; n < all.size() && !error; ++n) {
        first.parts.push_back(whole(all[n].folder));
        error = write_journal(all[n].folder->path(), kPart,
                              {.first = whole(all.front().folder), .moves = all[n].moves});
    }
    if (!error) error = write_journal(all.front().folder->path(), kRedo, first);
    if (!error) return Ok{};
    return failed_at(paths_of(all.front().folder->path(), all.front().moves.front()), error);
}

}  // namespace

Status commit(std::vector<Moves>& all) {
    std::size_t count = 0;
    for (const Moves& of : all) count += of.moves.size();
    const bool has_journal = count > 1;
    if (Status s = prepare(all, has_journal); !s) return s;
    std::vector<Paths> paths;
    // The other folders' files first, in the same order as in a recovery.
    for (auto of = all.rbegin(); of != all.rend(); ++of)
        for (const Move& move : of->moves) paths.push_back(paths_of(of->folder->path(), move));
    const fs::path &folder = all.front().folder->path(), redo_file = folder / kRedo,
                   undo_file = folder / kUndo;

    const Commit under_way;
    if (has_journal)
        if (Status s = write_journals(all); !s) {
            remove_file(redo_file);
            return s;
        }
    std::size_t failed = 0;
    if (const auto error = carry_out(paths, failed)) {
        Error fault = failed_at(paths[failed], error);
        if (!has_journal) return fault;  // a rename that fails changes nothing
        // Without `undo` the next run would go forwards, so nothing is undone.
        bool is_undone = !rename_file(redo_file, undo_file);
        if (is_undone)
            for (std::size_t n = failed + 1; n-- > 0;) is_undone = !undo(paths[n]) && is_undone;
        if (is_undone) {
            remove_file(undo_file);
            return fault;
        }
        // The journal and the files are needed by the next run.
        for (const Moves& of : all) of.folder->keep();
        fault.message += "; old and new files are in " + folder.filename().string() +
                         ", and the next run that writes beside it puts them in order";
        return fault;
    }
    for (const Moves& of : all)
        if (const auto error = sync_to_disk(of.folder->parent())) tell_unsynced(of, error);
    if (has_journal) remove_file(redo_file);
    return Ok{};
}

}  // namespace pliant::staging
