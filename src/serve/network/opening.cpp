// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "network/opening.h"

#include <pliant/models/organs.h>

#include <algorithm>
#include <new>
#include <vector>

#include "base/memory_budget.h"
#include "base/text.h"
#include "formats/image_file.h"

namespace pliant::serve {
namespace fs = std::filesystem;
namespace {

/// Finds the one file that is a scan by its name; otherwise the folder.
Result<fs::path> find_scan(const Upload& upload) {
    std::vector<std::string> scans;
    for (const std::string& name : upload.names())
        if (format_by_name(name)) scans.push_back(name);
    if (scans.size() > 1)
        return Error{ErrorCode::InvalidArgument,
                     "expected one scan, found " + scans[0] + " and " + scans[1]};
    if (scans.size() == 1) return upload.scan_folder() / scans[0];
    // For a single file of another kind, the reader's error explains the fault.
    if (upload.names().size() == 1) return upload.scan_folder() / *upload.names().begin();
    return upload.scan_folder();
}

/// Checks that a file refers to no file outside of its folder, and fits into memory.
Status check_header_of(const fs::path& path) {
    const auto format = format_by_name(path);
    // A legacy VTK file may hold a mesh.
    if (!format || is_mesh_file(path)) return Ok{};
    if (Status status = check_file(path); !status) return status;
    auto header = read_image_header(path, *format);
    if (!header) return header.error();
    // Reading a header opens no other file, so its error doesn't reveal whether one exists.
    for (const fs::path& file : header->data.files)
        if (file.lexically_normal().parent_path() != path.parent_path())
            return Error{ErrorCode::Unsupported, path.string() + ": names the data file '" +
                                                     shown(file.filename().string()) +
                                                     "', expected one without a folder"};
    if (Status status = check_header(path, 1, *header); !status) return status;
    // Mapped files need no memory.
    const bool is_mapped = header->data.encoding == DataEncoding::Raw &&
                           header->data.files.size() == 1 && !header->data.rescaled;
    if (!is_mapped && !has_memory_for(sizeof(float) * voxel_count(header->grid)))
        return Error{ErrorCode::LimitExceeded, path.string() + ": not enough memory to read it"};
    return Ok{};
}

/// Replaces server paths in a message by the client's file names.
std::string without_folders(std::string message, const Upload& upload, const fs::path& scan) {
    const bool is_folder = scan == upload.scan_folder();
    for (const std::string& folder :
         {is_folder ? std::string() : upload.scan_folder().string(), upload.root().string()}) {
        if (folder.empty()) continue;
        for (auto at = message.find(folder + "/"); at != std::string::npos;
             at = message.find(folder + "/"))
            message.erase(at, folder.size() + 1);
    }
    return message;
}

/// Name in the session: relative to it for kept files, otherwise the client's file name.
std::string recorded_name(const fs::path& root, const fs::path& file, bool is_kept) {
    if (!is_kept) return file.filename().string();
    const fs::path scans = root.parent_path();
    return file.lexically_relative(scans.parent_path()).string();
}

Result<Opened> open_files(Upload& upload, const fs::path& scan, const ScanWish& wish,
                          const TissueWish& tissue, const TaskArena& arena,
                          const std::function<bool()>& give_up) {
    if (scan == upload.scan_folder() && wish.series.empty()) {
        auto found = list_series(scan);
        if (!found.ok()) return found.error();
        // Those that can't be read are offered only if no other is there.
        const auto is_faulty = [](const DicomSeries& s) { return !s.fault.empty(); };
        if (!std::all_of(found->begin(), found->end(), is_faulty)) std::erase_if(*found, is_faulty);
        if (found->size() > 1) return Opened(std::move(*found));
    }
    // It would refer to files of this machine, not of the client.
    if (is_vessel_scene(scan))
        return Error{ErrorCode::Unsupported,
                     scan.string() +
                         ": is a vessel's scene, expected a scan; `pliant serve` opens "
                         "scenes when it starts"};
    if (Status status = check_header_of(scan); !status) return status.error();
    const TaskArena alone(1);
    const bool has_own = tissue.own_tissue || is_mesh_file(scan);
    auto scene = Scene::open({.file = scan.string(),
                              .series = wish.series,
                              .model = has_own ? std::string() : tissue.model,
                              .own_tissue = tissue.own_tissue,
                              .frame = wish.frame},
                             arena, alone, give_up);
    if (!scene.ok()) {
        const bool may_be_several = scene.error().code == ErrorCode::InvalidArgument && !wish.frame;
        const auto count = may_be_several ? count_images(scan, wish.series) : std::int64_t(1);
        if (count.ok() && *count > 1) return Opened(ImageCount{*count});
        return scene.error();
    }
    const fs::path before = upload.root();
    const auto kept = upload.keep();
    if (!kept.ok()) return kept.error();
    const fs::path stored = upload.root() / scan.lexically_relative(before);
    NewScene opened{std::move(*scene), {}};
    opened.recorded = {{.file = recorded_name(upload.root(), stored, upload.root() != before),
                        .series = wish.series,
                        .model = opened.scene->first_model().model,
                        .frame = wish.frame},
                       opened.scene->scan_hash()};
    return Opened(std::move(opened));
}

}  // namespace

std::string plain_message(const std::string& message, const Upload& upload, const fs::path& file) {
    return without_folders(message, upload, file);
}

Result<UploadedState> keep_state(Upload& upload) {
    const fs::path before = upload.root();
    const auto folder = upload.keep();
    if (!folder.ok()) return folder.error();
    const fs::path file = *folder / *upload.names().begin();
    return UploadedState{file, recorded_name(upload.root(), file, upload.root() != before)};
}

Result<std::shared_ptr<const LabelMap>> open_labels(Upload& upload, const Grid& scan,
                                                    const std::function<bool()>& give_up) {
    using Labels = Result<std::shared_ptr<const LabelMap>>;
    const auto file = find_scan(upload);
    if (!file.ok()) return file.error();
    const auto plain = [&](const std::string& message) {
        return without_folders(message, upload, *file);
    };
    try {
        if (Status status = check_header_of(*file); !status)
            return Error{status.error().code, plain(status.error().message)};
        const TaskArena alone(1);
        auto labels = read_label_map(*file, scan, alone, give_up);
        return labels.ok() ? std::move(labels)
                           : Labels(Error{labels.error().code, plain(labels.error().message)});
    } catch (const std::bad_alloc&) {
        return Error{ErrorCode::LimitExceeded, plain(file->string()) + ": not enough memory"};
    } catch (const fs::filesystem_error& error) {
        return Error{ErrorCode::Unreadable, plain(error.what())};
    }
}

Result<Opened> open_upload(Upload& upload, const ScanWish& wish, const TissueWish& tissue,
                           const TaskArena& arena, const std::function<bool()>& give_up) {
    const auto scan = find_scan(upload);
    if (!scan.ok()) return scan.error();
    const auto plain = [&](const std::string& message) {
        return without_folders(message, upload, *scan);
    };
    try {
        auto opened = open_files(upload, *scan, wish, tissue, arena, give_up);
        if (!opened.ok()) return Error{opened.error().code, plain(opened.error().message)};
        return opened;
    } catch (const std::bad_alloc&) {
        return Error{ErrorCode::LimitExceeded, plain(scan->string()) + ": not enough memory"};
    } catch (const fs::filesystem_error& error) {
        return Error{ErrorCode::Unreadable, plain(error.what())};
    }
}

}  // namespace pliant::serve
