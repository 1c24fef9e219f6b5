// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include <pliant/staged_files.h>

#include <dirent.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstring>
#include <memory>
#include <span>
#include <string>
#include <system_error>
#include <utility>

namespace pliant {
namespace fs = std::filesystem;
namespace {

constexpr const char* kBackupSuffix = ".before";

/// A file to be put in its place, with the paths that this and its undoing need.
struct Move {
    fs::path from, to;
    fs::path backup;        ///< of the previous file, beside `from`
    bool replaced = false;  ///< something was
};

Move move_of(const fs::path& from, fs::path to) {
    return {from, std::move(to), from.string() + kBackupSuffix};
}

// Everything from here on goes without an allocation, so that a commit is undone as a whole.

bool carry_out(Move& move, std::error_code& error) noexcept {
    move.replaced = fs::exists(move.to, error);
    if (move.replaced) {
        // A second name, so that the place is never empty; where that can't be, the first one.
        fs::create_hard_link(move.to, move.backup, error);
        if (error) fs::rename(move.to, move.backup, error);
        if (error) return false;
    }
    fs::rename(move.from, move.to, error);
    if (!error) return true;
    std::error_code ignored;
    if (move.replaced) fs::rename(move.backup, move.to, ignored);
    return false;
}

void undo(std::span<const Move> done) noexcept {
    std::error_code ignored;
    for (auto at = done.rbegin(); at != done.rend(); ++at) {
        if (at->replaced)
            fs::rename(at->backup, at->to, ignored);
        else
            fs::remove(at->to, ignored);
    }
}

struct CloseListing {
    void operator()(DIR* listing) const { ::closedir(listing); }
};

/// Calls visit(listing, name) for each file of a folder. Unlike a directory_iterator it doesn't end
/// the process where memory is short.
template <class Visit>
std::error_code for_each_file(const fs::path& folder, const Visit& visit) {
    const std::unique_ptr<DIR, CloseListing> listing(::opendir(folder.c_str()));
    if (!listing) return {errno, std::generic_category()};
    while (const dirent* file = ::readdir(listing.get()))
        if (std::strcmp(file->d_name, ".") != 0 && std::strcmp(file->d_name, "..") != 0)
            visit(listing.get(), file->d_name);
    return {};
}

/// Removes a folder that has no folders in it.
void remove_folder(const fs::path& folder) noexcept {
    static_cast<void>(for_each_file(
        folder, [](DIR* listing, const char* name) { ::unlinkat(::dirfd(listing), name, 0); }));
    ::rmdir(folder.c_str());
}

}  // namespace

StagedFiles::~StagedFiles() {
    for (const Entry& entry : m_entries) remove_folder(entry.folder);
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
    // A name that is too long, or a link to itself.
    if (fs::status(target, error).type() == fs::file_type::none)
        return Error{ErrorCode::Unwritable,
                     target.string() + ": can't be written (" + error.message() + ")"};
    if (fs::is_directory(target, error))
        return Error{ErrorCode::Unwritable, target.string() + ": is a folder, expected a file"};
    if (fs::exists(target, error) && !fs::is_regular_file(target, error))
        return Error{ErrorCode::Unwritable,
                     target.string() + ": is no regular file, expected one to replace"};
    const fs::path folder = parent / (".pliant-" + std::to_string(::getpid()) + "-" +
                                      std::to_string(counter.fetch_add(1)));
    fs::path staged = folder / target.filename();
    m_entries.push_back({folder, target});
    if (!fs::create_directory(folder, error)) {
        m_entries.pop_back();
        return Error{ErrorCode::Unwritable, target.string() + ": the folder " + parent.string() +
                                                " can't be written (" + error.message() + ")"};
    }
    return staged;
}

Status StagedFiles::commit() {
    std::vector<Move> moves;
    std::error_code error;
    // Data files first, then the headers that name them.
    for (const Entry& entry : m_entries) {
        error = for_each_file(entry.folder, [&](DIR*, const char* name) {
            if (name != entry.target.filename())
                moves.push_back(move_of(entry.folder / name, entry.target.parent_path() / name));
        });
        if (error)
            return Error{ErrorCode::Unwritable, entry.target.string() + ": " + error.message()};
    }
    for (const Entry& entry : m_entries)
        moves.push_back(move_of(entry.folder / entry.target.filename(), entry.target));
    for (std::size_t n = 0; n < moves.size(); ++n) {
        if (carry_out(moves[n], error)) continue;
        undo(std::span(moves).first(n));
        return Error{ErrorCode::Unwritable, moves[n].to.string() + ": " + error.message()};
    }
    for (const Entry& entry : m_entries) remove_folder(entry.folder);
    m_entries.clear();
    return Ok{};
}

}  // namespace pliant
