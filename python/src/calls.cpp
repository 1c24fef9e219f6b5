// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Common to all functions of the module: a signature for inspect, and a pliant.Error that
// names the argument which doesn't fit it. nanobind's own error is a list of signatures.
//
//   call ── explained() ── nanobind's function ── TypeError? ── pliant._signatures.argument_error

#include <unordered_map>

#include "volumes.h"

namespace pliant::python {
namespace {

/// nanobind's entry point of each function, which lives as long as the module.
std::unordered_map<PyObject*, vectorcallfunc>& entries() {
    static auto* const all = new std::unordered_map<PyObject*, vectorcallfunc>;
    return *all;
}

nb::object signatures(const char* name) {
    return nb::module_::import_("pliant._signatures").attr(name);
}

PyObject* explained(PyObject* function, PyObject* const* given, std::size_t flags,
                    PyObject* names) {
    PyObject* const result = entries().find(function)->second(function, given, flags, names);
    if (result || !PyErr_ExceptionMatches(PyExc_TypeError)) return result;
    const std::size_t count = flags & 0xffff;  // nanobind has a flag of its own above
    nb::python_error raised;
    try {
        nb::list values;
        const std::size_t all = count + (names ? std::size_t(PyTuple_GET_SIZE(names)) : 0);
        for (std::size_t n = 0; n < all; ++n) values.append(nb::handle(given[n]));
        const nb::object error = signatures("argument_error")(
            nb::handle(function), values,
            names ? nb::borrow<nb::object>(names) : nb::object(nb::tuple()), raised.value());
        PyErr_SetObject(error.type().ptr(), error.ptr());
    } catch (nb::python_error& failed) {
        failed.restore();
    } catch (const std::exception&) {
        raised.restore();
    }
    return nullptr;
}

void explain(nb::handle function) {
    const Py_ssize_t offset = Py_TYPE(function.ptr())->tp_vectorcall_offset;
    if (offset <= 0 || !nb::hasattr(function, "__nb_signature__")) return;
    void* const at = reinterpret_cast<char*>(function.ptr()) + offset;
    auto& entry = *static_cast<vectorcallfunc*>(at);
    if (entry == &explained) return;
    entries()[function.ptr()] = entry;
    entry = &explained;
}

/// Adds the attribute that inspect asks for. nanobind's types are immutable for Python.
void add_signature(PyTypeObject* type) {
    const nb::object property =
        nb::module_::import_("builtins").attr("property")(nb::cpp_function([](nb::handle function) {
            return signatures("signature_of")(function);
        }));
    if (PyDict_SetItemString(type->tp_dict, "__signature__", property.ptr()) != 0)
        throw nb::python_error();
    PyType_Modified(type);
}

}  // namespace

void finish_functions(nb::module_& m) {
    const nb::dict names = nb::borrow<nb::dict>(m.attr("__dict__"));
    for (const auto& [name, object] : names) {
        explain(object);
        if (!PyType_Check(object.ptr())) continue;
        const nb::object members = nb::module_::import_("builtins").attr("vars")(object);
        for (const nb::handle member : members.attr("values")()) {
            explain(member);
            for (const char* part : {"fget", "fset"})
                if (nb::hasattr(member, part)) explain(member.attr(part));
        }
    }
    PyObject* const method = nb::type<PyVolume>().attr("save").ptr();
    const nb::object bound =
        nb::steal(Py_TYPE(method)->tp_descr_get(method, m.ptr(), nb::type<PyVolume>().ptr()));
    for (PyObject* each : {nb::object(m.attr("settings_of")).ptr(), method, bound.ptr()})
        add_signature(Py_TYPE(each));
}

}  // namespace pliant::python
