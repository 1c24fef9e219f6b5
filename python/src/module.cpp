// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include <pliant/core/version.h>

#include "arrays.h"

NB_MODULE(_core, m) {
    m.doc() = "Pliant's library. Use it as `import pliant`.";
    m.attr("version") = PLIANT_VERSION;
    pliant::python::bind_settings(m);
    pliant::python::bind_volumes(m);
    pliant::python::bind_fields(m);
    pliant::python::bind_meshes(m);
    pliant::python::bind_tissues(m);
    pliant::python::bind_render(m);
    pliant::python::bind_surfaces(m);
    pliant::python::bind_vessels(m);
    pliant::python::bind_springs(m);
    pliant::python::bind_elastic(m);
    pliant::python::bind_fits(m);
    pliant::python::bind_organs(m);
    pliant::python::bind_augment(m);
    pliant::python::bind_gym(m);
    pliant::python::bind_catheter_gym(m);
    pliant::python::bind_truth(m);
}
