// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include <pliant/scan_files.h>

#include "session/save.h"

#include <stdlib.h>

#include <array>
#include <memory>
#include <string>
#include <system_error>
#include <utility>

#include "base/memory_budget.h"
#include "field/field_state.h"
#include "field/writable_field.h"
#include "resample/fields.h"
#include "resample/scatter.h"

namespace pliant::serve {
namespace {

namespace fs = std::filesystem;

constexpr std::array<std::pair<SaveKind, std::string_view>, 8> kNames = {{
    {SaveKind::Volume, "volume.nrrd"},
    {SaveKind::Displacement, "displacement.nrrd"},
    {SaveKind::Transform, "transform.nrrd"},
    {SaveKind::Session, "session.pls"},
    {SaveKind::VolumeNifti, "volume.nii.gz"},
    {SaveKind::VolumeMeta, "volume.mha"},
    {SaveKind::VolumeVti, "volume.vti"},
    {SaveKind::State, "state.plst"},
}};

/// A copy of the tissue. It owns the scan that its lattice refers to.
struct Taken {
    std::shared_ptr<const LoadedScan> scan;
    std::unique_ptr<const WritableField> field;
};

std::shared_ptr<const Taken> take(const Scene& scene) {
    auto scan = scene.loaded();
    auto field = copy_of(scene.tissue().deformation().field());
    return std::make_shared<Taken>(Taken{std::move(scan), std::move(field)});
}

/// A file in a temporary folder, which is removed with it.
class TemporaryFile {
  public:
    explicit TemporaryFile(std::string_view name) {
        std::error_code error;
        std::string folder = (fs::temp_directory_path(error) / "pliant-state-XXXXXX").string();
        if (error || !::mkdtemp(folder.data())) return;
        m_folder = folder;
        m_name = name;
    }
    ~TemporaryFile() {
        std::error_code ignored;
        if (!m_folder.empty()) fs::remove_all(m_folder, ignored);
    }
    TemporaryFile(const TemporaryFile&) = delete;
    TemporaryFile& operator=(const TemporaryFile&) = delete;
    bool is_there() const { return !m_folder.empty(); }
    fs::path path() const { return m_folder / m_name; }

  private:
    fs::path m_folder, m_name;
};

Status write_transform(const std::filesystem::path& path, const Taken& taken) {
    const Volume& scan = taken.scan->volume;
    // Worst case: the whole scan has moved.
    if (!has_memory_for(voxel_count(scan.grid) * sizeof(Vec3f)))
        return Error{ErrorCode::LimitExceeded, "transform.nrrd: not enough memory to make it"};
    const TaskArena alone(1);
    const Deformed deformed = deform_by_field(scan, *taken.field, Mapping::Cells, true, alone);
    return write_vector_field(path, scan.grid, FieldKind::Resampling, inverse_slices(deformed));
}

}  // namespace

std::optional<SaveKind> save_kind_of(std::string_view name) {
    for (const auto& [kind, own] : kNames)
        if (own == name) return kind;
    return {};
}

std::string_view name_of(SaveKind kind) {
    return kNames[std::size_t(kind)].second;
}

FileWriter save_later(SaveKind kind, const Scene& scene) {
    if (name_of(kind).starts_with("volume.")) {
        auto volume = std::make_shared<const Volume>(scene.deformed());
        return [volume](const std::filesystem::path& path) { return write_volume(path, *volume); };
    }
    if (kind == SaveKind::Transform)
        return [taken = take(scene)](const std::filesystem::path& path) {
            return write_transform(path, *taken);
        };
    return [taken = take(scene)](const std::filesystem::path& path) {
        return write_vector_field(path, taken->scan->volume.grid, FieldKind::Modeling,
                                  slices_of(*taken->field));
    };
}

Result<FileWriter> save_state_later(const Scene& scene) {
    const std::string name(name_of(SaveKind::State));
    const Error unwritable{ErrorCode::Unwritable,
                           name + ": expected room for a temporary file, found none"};
    auto file = std::make_shared<const TemporaryFile>(name);
    if (!file->is_there()) return unwritable;
    const Status saved = scene.tissue().save_state(file->path());
    if (!saved.ok())
        return saved.error().code == ErrorCode::Unwritable ? unwritable : saved.error();
    return FileWriter([file, unwritable](const fs::path& path) -> Status {
        std::error_code error;
        fs::rename(file->path(), path, error);
        return error ? Status(unwritable) : Ok{};
    });
}

FileWriter save_session_later(SessionPart part, const Scene& scene) {
    auto volume = std::make_shared<const Volume>(scene.deformed());
    // ChainMail's hash can be computed later from the elements; other models have few nodes.
    std::optional<std::uint64_t> nodes;
    if (scene.choice().model != "chainmail") nodes = scene.tissue().hash();
    return [part = std::move(part), volume, nodes,
            taken = take(scene)](const std::filesystem::path& path) {
        const std::uint64_t tissue = nodes ? *nodes : hash_state(*taken->field);
        return write_session(path, part, {hash_volume(*volume), tissue});
    };
}

}  // namespace pliant::serve
