// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "session/save.h"

#include <array>
#include <memory>
#include <string>
#include <utility>

#include "core/memory_budget.h"
#include "field/field_state.h"
#include "field/writable_field.h"
#include "resample/fields.h"
#include "resample/scatter.h"

namespace pliant::serve {
namespace {

constexpr std::array<std::pair<SaveKind, std::string_view>, 7> kNames = {{
    {SaveKind::Volume, "volume.nrrd"},
    {SaveKind::Displacement, "displacement.nrrd"},
    {SaveKind::Transform, "transform.nrrd"},
    {SaveKind::Session, "session.pls"},
    {SaveKind::VolumeNifti, "volume.nii.gz"},
    {SaveKind::VolumeMeta, "volume.mha"},
    {SaveKind::VolumeVti, "volume.vti"},
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

FileWriter save_session_later(SessionPart part, const Scene& scene) {
    auto volume = std::make_shared<const Volume>(scene.deformed());
    // ChainMail's hash can be computed later from the elements; other models have few nodes.
    std::optional<std::uint64_t> nodes;
    if (scene.choice().model != TissueModel::ChainMail) nodes = scene.tissue().hash();
    return [part = std::move(part), volume, nodes,
            taken = take(scene)](const std::filesystem::path& path) {
        const std::uint64_t tissue = nodes ? *nodes : hash_state(*taken->field);
        return write_session(path, part, {hash_volume(*volume), tissue});
    };
}

}  // namespace pliant::serve
