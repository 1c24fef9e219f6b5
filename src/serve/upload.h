// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Files that come in: one folder for one scan, whatever they say they are called.
//
//   FOLDER/upload-x7Rk2a/            made here, and removed unless it is kept
//                        NAME/       the scan's folder: what is opened where it is DICOM slices
//                             a.dcm  base names only
//
// Their number, their sizes and the room on the disk are looked at before they are written.

#pragma once

#include <pliant/result.h>

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>

#include "serve/limits.h"

namespace pliant::serve {

struct UploadSettings {
    std::filesystem::path folder{};  ///< where uploads lie; empty: where temporary files do
    bool keeps = false;              ///< what was opened stays there: a session needs it
    std::uint64_t max_bytes = 0;     ///< of all files of a scan
};

/// Why a request isn't carried out, as HTTP says it.
struct Refusal {
    unsigned status = 400;
    std::string line;
};
using MayRefuse = std::optional<Refusal>;

/// A name without folders and without what can't be part of one. @returns "" where nothing is left
std::string base_name(std::string_view name);

/// Removes uploads that a process left in a folder when it was killed. Those of living processes
/// are locked and stay.
void sweep_uploads(const std::filesystem::path& folder) noexcept;

class Upload {
  public:
    /// Nothing is made before the first file. @param id  what the client calls it
    Upload(UploadSettings settings, std::string id);
    ~Upload();
    Upload(const Upload&) = delete;
    Upload& operator=(const Upload&) = delete;

    const std::string& id() const { return m_id; }
    /// @param size  if it is known
    MayRefuse begin_file(const std::string& name, std::optional<std::uint64_t> size);
    MayRefuse add(std::span<const char> bytes);
    MayRefuse end_file();
    /// Another name for the scan's folder.
    MayRefuse rename(const std::string& name);
    /// Gives it a name to stay under, if uploads are kept. @returns the scan's folder, beside the
    /// session where it is kept
    Result<std::filesystem::path> keep();

    const std::set<std::string>& names() const { return m_names; }
    std::filesystem::path scan_folder() const { return m_root / m_name; }
    const std::filesystem::path& root() const { return m_root; }

  private:
    MayRefuse make_root();
    MayRefuse check_room(std::uint64_t bytes) const;

    UploadSettings m_settings;
    std::string m_id;
    std::filesystem::path m_root;  ///< empty: not made
    std::string m_name = "scan";
    std::set<std::string> m_names;
    int m_file = -1;
    int m_lock = -1;  ///< of the folder, while this process lives
    std::uint64_t m_bytes = 0, m_unchecked = 0;
    bool m_is_kept = false;
};

}  // namespace pliant::serve
