// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include <pliant/staged_files.h>

#include <unistd.h>

#include <atomic>
#include <string>
#include <system_error>

namespace pliant {
namespace fs = std::filesystem;

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
    const fs::path folder = parent / (".pliant-" + std::to_string(::getpid()) + "-" +
                                      std::to_string(counter.fetch_add(1)));
    if (!fs::create_directory(folder, error))
        return Error{ErrorCode::Unwritable, target.string() + ": the folder " + parent.string() +
                                                " can't be written (" + error.message() + ")"};
    m_entries.push_back({folder, target});
    return folder / target.filename();
}

Status StagedFiles::commit() {
    std::error_code error;
    const auto move = [&](const fs::path& from, const fs::path& to) {
        fs::rename(from, to, error);
        return !error;
    };
    for (const Entry& entry : m_entries) {
        for (const auto& file : fs::directory_iterator(entry.folder, error)) {
            if (file.path().filename() == entry.target.filename()) continue;
            if (!move(file.path(), entry.target.parent_path() / file.path().filename()))
                return Error{ErrorCode::Unwritable, entry.target.string() + ": " + error.message()};
        }
    }
    for (const Entry& entry : m_entries) {
        if (!move(entry.folder / entry.target.filename(), entry.target))
            return Error{ErrorCode::Unwritable, entry.target.string() + ": " + error.message()};
        fs::remove_all(entry.folder, error);
    }
    m_entries.clear();
    return Ok{};
}

}  // namespace pliant
