// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Meshes of all formats; the bytes select the format, except for OBJ and STL. A mesh that was read
// has nodes for all cells, and round-trips through a file.

#include <pliant/mesh.h>
#include <pliant/mesh_files.h>

#include "fuzz/fuzz.h"
#include "meshes/file_numbers.h"

using namespace pliant;

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    for (const char* ending : {".obj", ".stl"}) {
        const auto mesh = mesh::parse_mesh(fuzz::text_of(data, size), ending);
        if (!mesh.ok()) {
            fuzz::expect_one_line(mesh.error().message);
            continue;
        }
        for (const Vec3d& p : mesh->nodes_mm) fuzz::expect(is_finite(p), "finite positions");
        const auto count = std::int64_t(mesh->nodes_mm.size());
        const auto expect_inside = [count](const auto& cells) {
            for (const auto& cell : cells)
                for (const std::int32_t n : cell)
                    fuzz::expect(n >= 0 && n < count, "nodes that exist");
        };
        expect_inside(mesh->tetrahedra);
        expect_inside(mesh->triangles);
        expect_inside(mesh->lines);
        for (const auto& field : mesh->node_fields)
            fuzz::expect(field.values.size() == field.components * mesh->nodes_mm.size(),
                         "as many values as nodes", field.name);
        const auto path = fuzz::folder() / "again.vtp";
        const TriangleMesh surface{mesh->nodes_mm, mesh->triangles};
        fuzz::expect(write_surface(path, surface).ok(), "a file");
        const auto again = read_mesh(path);
        fuzz::expect(again.ok() && again->triangles == surface.cells, "the same triangles again");
    }
    return 0;
}
