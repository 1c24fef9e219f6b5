// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include <pliant/core/version.h>

#include "arrays.h"
#include "morphs.h"

NB_MODULE(_core, m) {
    m.doc() = "Pliant's library. Use it as `import pliant`.";
    m.attr("version") = PLIANT_VERSION;
    // Values of other types than a call expects, where it doesn't name them.
    nb::register_exception_translator([](const std::exception_ptr& thrown, void*) {
        try {
            std::rethrow_exception(thrown);
        } catch (const std::bad_cast&) {
            const nb::object kind = nb::module_::import_("pliant._error").attr("Error");
            PyErr_SetString(kind.ptr(),
                            "arguments: expected the types of the signature, found "
                            "another type in one of them");
        }
    });
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
    pliant::python::bind_morph(m);
    pliant::python::finish_functions(m);
}
