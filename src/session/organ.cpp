// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "session/organ.h"

#include <pliant/mesh.h>
#include <pliant/tissues.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <string>
#include <utility>

#include "core/errors.h"
#include "core/hash.h"

namespace pliant::serve {
namespace {

constexpr double kHeldShare = 0.05;
constexpr std::size_t kHeaderBytes = 1024;

/// Whether a legacy VTK file holds a scan.
bool holds_image(const std::filesystem::path& file) {
    std::string start(kHeaderBytes, '\0');
    std::ifstream in(file, std::ios::binary);
    in.read(start.data(), std::streamsize(start.size()));
    start.resize(std::size_t(std::max<std::streamsize>(0, in.gcount())));
    return start.find("STRUCTURED_POINTS") != std::string::npos;
}

Result<TetMesh> tetrahedra_of(const std::filesystem::path& file, const TaskArena& arena) {
    const auto mesh = read_mesh(file);
    if (!mesh) return mesh.error();
    const auto named = [&](const Error& error) {
        return Error{error.code, file.string() + ": " + error.message};
    };
    if (!mesh->tetrahedra.empty()) {
        TetMesh tetrahedra = with_used_nodes({mesh->nodes_mm, mesh->tetrahedra});
        if (const Status s = check_quality(tet_quality(tetrahedra)); !s.ok())
            return named(s.error());
        return tetrahedra;
    }
    if (mesh->triangles.empty())
        return named(
            {ErrorCode::Unsupported, "found neither tetrahedra nor triangles, expected an organ"});
    auto filled = fill_surface(joined({mesh->nodes_mm, mesh->triangles}), {}, arena);
    if (!filled) return named(filled.error());
    return std::move(filled->mesh);
}

}  // namespace

bool is_mesh(const std::filesystem::path& file) {
    std::string ending = file.extension().string();
    for (char& c : ending)
        if (c >= 'A' && c <= 'Z') c = char(c - 'A' + 'a');
    constexpr std::array kEndings = {".vtp", ".vtu", ".msh", ".stl", ".obj", ".ply"};
    if (ending == ".vtk") return !holds_image(file);
    return std::find(kEndings.begin(), kEndings.end(), ending) != kEndings.end();
}

Result<Organ> load_organ(const std::filesystem::path& file, const TaskArena& arena) {
    auto mesh = tetrahedra_of(file, arena);
    if (!mesh) return mesh.error();
    auto scan = scan_of_solid(*mesh, arena);
    if (!scan.ok()) return Error{scan.error().code, file.string() + ": " + scan.error().message};
    Hash64 hash;
    hash.add(std::span<const Vec3d>(mesh->nodes_mm));
    hash.add(std::span<const std::array<std::int32_t, 4>>(mesh->cells));
    Organ organ{.scan = std::move(*scan), .tissue = {}, .hash = hash.value()};
    organ.tissue = std::make_shared<const MakeTissue>(
        [solid = std::make_shared<const TetMesh>(std::move(*mesh))](
            const Volume& volume, const TaskArena& own) -> Result<std::unique_ptr<Tissue>> {
            return make_body(volume, *solid, {.held_back = kHeldShare}, own);
        });
    return organ;
}

}  // namespace pliant::serve
