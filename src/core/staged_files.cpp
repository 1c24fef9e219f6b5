// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include <pliant/staged_files.h>

#include <unistd.h>

#include <atomic>
#include <string>
#include <system_error>

namespace pliant {
namespace fs = std::filesystem;
namespace {

constexpr const char* kBackupSuffix = ".before";

/// A file that was put in its place.
struct Move {
    fs::path from, to;
    bool replaced;  ///< what was there before is kept beside `from`
};

fs::path backup_of(const fs::path& staged) {
    return staged.string() + kBackupSuffix;
}

bool move(const fs::path& from, const fs::path& to, std::vector<Move>& done,
          std::error_code& error) {
    const bool replaces = fs::exists(to, error);
    if (replaces) {
        // A second name, so that the place is never empty; where that can't be, the first one.
        fs::create_hard_link(to, backup_of(from), error);
        if (error) fs::rename(to, backup_of(from), error);
        if (error) return false;
    }
    done.push_back({from, to, replaces});
    fs::rename(from, to, error);
    if (!error) return true;
    done.pop_back();
    std::error_code ignored;
    if (replaces) fs::rename(backup_of(from), to, ignored);
    return false;
}

void undo(const std::vector<Move>& done) {
    std::error_code ignored;
    for (auto at = done.rbegin(); at != done.rend(); ++at) {
        if (at->replaced)
            fs::rename(backup_of(at->from), at->to, ignored);
        else
            fs::remove(at->to, ignored);
    }
}

}  // namespace

StagedFiles::~StagedFiles() {
    std::error_code ignored;
    for (const Entry& entry : m_entries) fs::remove_all(entry.folder, ignored);
}

Result<fs::path> StagedFiles::stage(const fs::path& target) {
    static std::atomic<unsigned> counter{0};
    std::error_code error;
    const fs::path parent = target.has_parent_path() ? target.parent_path() : fs::path(".");
    if (!target.has_filename())
        return Error{ErrorCode::Unwritable, target.string() + ": expected a file name"};
    if (!fs::is_directory(parent, error))
        return Error{ErrorCode::Unwritable,
                     target.string() + ": the folder " + parent.string() + " does not exist"};
    if (fs::is_directory(target, error))
        return Error{ErrorCode::Unwritable, target.string() + ": is a folder, expected a file"};
    if (fs::exists(target, error) && !fs::is_regular_file(target, error))
        return Error{ErrorCode::Unwritable,
                     target.string() + ": is no regular file, expected one to replace"};
    const fs::path folder = parent / (".pliant-" + std::to_string(::getpid()) + "-" +
                                      std::to_string(counter.fetch_add(1)));
    if (!fs::create_directory(folder, error))
        return Error{ErrorCode::Unwritable, target.string() + ": the folder " + parent.string() +
                                                " can't be written (" + error.message() + ")"};
    m_entries.push_back({folder, target});
    return folder / target.filename();
}

Status StagedFiles::commit() {
    std::vector<Move> done;
    std::error_code error;
    const auto fail = [&](const fs::path& target) -> Status {
        const std::string why = error.message();
        undo(done);
        return Error{ErrorCode::Unwritable, target.string() + ": " + why};
    };
    for (const Entry& entry : m_entries) {  // data files first, then the headers that name them
        std::vector<fs::path> beside;
        for (fs::directory_iterator at(entry.folder, error), end; !error && at != end;
             at.increment(error))
            if (at->path().filename() != entry.target.filename()) beside.push_back(at->path());
        if (error) return fail(entry.target);
        for (const fs::path& file : beside)
            if (!move(file, entry.target.parent_path() / file.filename(), done, error))
                return fail(entry.target);
    }
    for (const Entry& entry : m_entries)
        if (!move(entry.folder / entry.target.filename(), entry.target, done, error))
            return fail(entry.target);
    for (const Entry& entry : m_entries) fs::remove_all(entry.folder, error);
    m_entries.clear();
    return Ok{};
}

}  // namespace pliant
