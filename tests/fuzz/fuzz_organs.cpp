// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A scene of organs: refused in one line, or with bodies, and numbers within their bounds. The
// files that it names are not read.

#include <pliant/models/organs.h>

#include <cmath>

#include "fuzz/fuzz.h"

using namespace pliant;

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const auto file = fuzz::write_anew("s.toml", fuzz::text_of(data, size));
    (void)is_organ_file(file);
    const auto scene = read_organ_file(file.string());
    if (!scene.ok()) {
        fuzz::expect_one_line(scene.error().message);
        return 0;
    }
    fuzz::expect(!scene->bodies.empty(), "one or more bodies");
    fuzz::expect(scene->time_step_s > 0 && scene->sub_steps > 0 && scene->tetrahedra > 0,
                 "numbers within their bounds");
    for (const OrganSettings& body : scene->bodies) {
        fuzz::expect(!body.mesh.empty() || !body.labels.empty(), "a mesh or labels");
        fuzz::expect(body.young_modulus_pa > 0 && body.poisson_ratio > 0 &&
                         body.poisson_ratio < 0.5 && body.density_kg_m3 > 0,
                     "a material");
        fuzz::expect(body.held_mm.size() % 2 == 0, "corners in pairs");
        for (const Vec3d p : body.held_mm) fuzz::expect(is_finite(p), "finite corners");
    }
    for (const OrganContents& c : scene->contents)
        fuzz::expect(!c.surface.empty() && std::isfinite(c.value_hu), "a surface with a value");
    return 0;
}
