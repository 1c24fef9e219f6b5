// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// One function per command that adds its options. Those of fit are in fit_options.h, because they
// may also come from files.

#pragma once

#include "options.h"

namespace CLI {
class App;
}

namespace pliant::app {

void add_info(CLI::App& app, InfoOptions& options);
void add_convert(CLI::App& app, ConvertOptions& options);
void add_phantom(CLI::App& app, PhantomOptions& options);
void add_deform(CLI::App& app, DeformOptions& options);
void add_body(CLI::App& app, BodyOptions& options);
void add_render(CLI::App& app, RenderOptions& options);
void add_path(CLI::App& app, PathOptions& options);
void add_mesh(CLI::App& app, MeshOptions& options);
void add_serve(CLI::App& app, ServeOptions& options);
void add_replay(CLI::App& app, ReplayOptions& options);
void add_bench(CLI::App& app, BenchOptions& options);
void add_vessel(CLI::App& app, VesselOptions& options);
void add_haptics(CLI::App& app, HapticsOptions& options);
void add_truth(CLI::App& app, TruthOptions& options);
void add_morph(CLI::App& app, MorphOptions& options);
void add_materials(CLI::App& app, MaterialsOptions& options);
void add_conformance(CLI::App& app, ConformanceOptions& options);

}  // namespace pliant::app
