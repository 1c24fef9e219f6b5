// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Cost of a cut through a block of tetrahedra: the first one, a second one across it, and one step
// of a stroke, a twentieth of the way. One item is a tetrahedron of the block.

#include <benchmark/benchmark.h>
#include <pliant/models/cut_mesh.h>

namespace pliant::bench {
namespace {

enum Kind { First, Second, Step };

/// Arguments: cubes along each side, six tetrahedra each; kind.
void mesh_cut(benchmark::State& state) {
    const int cubes = int(state.range(0));
    const double side = cubes;
    const TetMesh mesh = tet_mesh({.size = {cubes + 1, cubes + 1, cubes + 1}});
    const CutSurface first{{{-1, 0.43 * side, -1}, {side + 1, 0.52 * side, -1}},
                           {0, 0.1 * side, side + 2}};
    const CutSurface second{{{0.37 * side, -1, -1}, {0.55 * side, side + 1, -1}},
                            {0.1 * side, 0, side + 2}};
    const Vec3d a = first.line_mm[0], way = first.line_mm[1] - a;
    const CutSurface half{{a, a + 0.5 * way}, first.depth_mm};
    const CutSurface step{{a + 0.5 * way, a + 0.55 * way}, first.depth_mm};
    const auto before = cut_tetrahedra(mesh, mesh.nodes_mm, state.range(1) == Step ? half : first);
    if (!before.ok()) {
        state.SkipWithError(before.error().message.c_str());
        return;
    }
    std::int64_t split = 0, pieces = 0;
    for (auto _ : state) {
        const auto cut = state.range(1) == First
                             ? cut_tetrahedra(mesh, mesh.nodes_mm, first)
                             : cut_tetrahedra(*before, before->mesh.nodes_mm,
                                              state.range(1) == Second ? second : step);
        split = cut->split_cells;
        pieces = cut->pieces;
    }
    state.counters["tetrahedra"] = double(mesh.cells.size());
    state.counters["split"] = double(split);
    state.counters["pieces"] = double(pieces);
}

BENCHMARK(mesh_cut)
    ->Name("mesh_cut")
    ->ArgNames({"cubes", "kind"})
    ->Args({15, First})
    ->Args({15, Second})
    ->Args({15, Step})
    ->Args({32, First})
    ->Args({32, Second})
    ->Args({32, Step})
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace pliant::bench
