// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Uploads: one folder per scan, independent of the file names that a client sends.
//
//   FOLDER/upload-x7Rk2a/            created here, and removed unless it is kept
//                        NAME/       the scan's folder: opened if it has DICOM slices
//                             a.dcm  base names only
//
// The number and size of files and the free disk space are checked before writing.

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

#include "base/descriptor.h"
#include "protocol/limits.h"

namespace pliant::serve {

struct UploadSettings {
    std::filesystem::path folder{};  ///< folder of uploads; empty: that of temporary files
    bool keeps = false;              ///< opened scans stay there for the session
    std::uint64_t max_bytes = 0;     ///< total of a scan's files
};

/// HTTP status and text of a refused request.
struct Refusal {
    unsigned status = 400;
    std::string line;
};
using MayRefuse = std::optional<Refusal>;

/// Strips folders and invalid characters from a name. @returns "" if nothing is left
std::string base_name(std::string_view name);

/// Removes uploads of killed processes from a folder. Uploads of living processes are locked and
/// stay.
void sweep_uploads(const std::filesystem::path& folder) noexcept;

class Upload {
  public:
    /// Doesn't create files before the first upload. @param id  chosen by the client
    Upload(UploadSettings settings, std::string id);
    ~Upload();
    Upload(const Upload&) = delete;
    Upload& operator=(const Upload&) = delete;

    const std::string& id() const { return m_id; }
    /// @param size  if known
    MayRefuse begin_file(const std::string& name, std::optional<std::uint64_t> size);
    MayRefuse add(std::span<const char> bytes);
    MayRefuse end_file();
    /// Renames the scan's folder.
    MayRefuse rename(const std::string& name);
    /// Moves the upload to its permanent folder beside the session, if uploads are kept. @returns
    /// the scan's folder
    Result<std::filesystem::path> keep();
    /// The upload is removed with this object, even if it was kept.
    void discard() { m_is_kept = false; }

    const std::set<std::string>& names() const { return m_names; }
    std::filesystem::path scan_folder() const { return m_root / m_name; }
    const std::filesystem::path& root() const { return m_root; }

  private:
    MayRefuse make_root();
    MayRefuse check_room(std::uint64_t bytes) const;

    UploadSettings m_settings;
    std::string m_id;
    std::filesystem::path m_root;  ///< empty: not created
    std::string m_name = "scan";
    std::set<std::string> m_names;
    Descriptor m_file;
    Descriptor m_lock;  ///< lock of the folder
    std::uint64_t m_bytes = 0, m_unchecked = 0;
    bool m_is_kept = false;
};

}  // namespace pliant::serve
