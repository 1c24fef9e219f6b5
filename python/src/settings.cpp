// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Settings by keyword: the rows of the library's tables are the names, ranges and texts.

#include <pliant/data/morph.h>
#include <pliant/data/truth.h>
#include <pliant/models/catheter.h>
#include <pliant/models/fem.h>
#include <pliant/models/fit.h>
#include <pliant/models/material.h>
#include <pliant/models/organs.h>
#include <pliant/models/passports.h>
#include <pliant/tissues.h>

#include "arrays.h"
#include "keywords.h"
#include "made_tissue.h"

namespace pliant::python {
namespace {

SettingValue value_from(const std::string& name, nb::handle value) {
    if (value.is_none()) raise_value(name, "a value", value);
    if (nb::isinstance<nb::bool_>(value)) return nb::cast<bool>(value);
    if (nb::isinstance<nb::str>(value)) return nb::cast<std::string>(value);
    // Arrays have __index__, too; one without axes is a number.
    const bool has_axes = nb::hasattr(value, "ndim") && nb::cast<int>(value.attr("ndim")) > 0;
    if (!has_axes && PyIndex_Check(value.ptr())) {
        std::int64_t number = 0;
        if (nb::try_cast(nb::int_(nb::borrow(value)), number)) return number;
        raise_value(name, "a whole number of 64 bits", value);
    }
    if (PyFloat_Check(value.ptr()) || !PySequence_Check(value.ptr())) {
        const double number = PyFloat_AsDouble(value.ptr());
        if (!PyErr_Occurred()) return number;
        PyErr_Clear();
    } else {
        std::vector<double> numbers;
        std::vector<NumberPair> pairs;
        std::vector<Vec3d> points;
        std::vector<std::string> texts;
        for (const nb::handle each : value) {
            Vec3d point;
            NumberPair pair;
            if (nb::isinstance<nb::str>(each)) {
                texts.push_back(nb::cast<std::string>(each));
                continue;
            }
            if (vector_from(each, point)) {
                points.push_back(point);
                continue;
            }
            if (numbers_from(each, pair)) {
                pairs.push_back(pair);
                continue;
            }
            numbers.push_back(PyFloat_AsDouble(each.ptr()));
            if (PyErr_Occurred()) {
                PyErr_Clear();
                raise_value(name, "numbers, pairs, points or texts", value);
            }
        }
        const std::size_t count = numbers.size() + pairs.size() + points.size() + texts.size();
        if (numbers.size() == count) return numbers;
        if (pairs.size() == count) return pairs;
        if (points.size() == count) return points;
        if (texts.size() == count) return texts;
    }
    raise({ErrorCode::InvalidArgument,
           name +
               ": expected a flag, a number, a text, or a list of numbers, pairs, points or texts, "
               "found " +
               nb::cast<std::string>(nb::repr(value)),
           name});
}

}  // namespace

nb::object object_of(const SettingValue& value) {
    return std::visit(
        [](const auto& v) -> nb::object {
            using V = std::decay_t<decltype(v)>;
            if constexpr (std::is_same_v<V, std::monostate>)
                return nb::none();
            else if constexpr (std::is_same_v<V, bool>)
                return nb::bool_(v);
            else
                return nb::cast(v);
        },
        value);
}

namespace {

/// The table of a settings struct: a row for each name.
template <class T>
nb::list rows_of(SettingRows<T> rows) {
    const T defaults;
    nb::list list;
    for (const Setting<T>& row : rows) {
        nb::dict entry;
        entry["name"] = nb::cast(std::string(row.name));
        entry["default"] = object_of(value_of(defaults, row));
        entry["unit"] = nb::cast(std::string(row.unit));
        entry["range"] = nb::cast(expected_of(row));
        entry["text"] = nb::cast(std::string(row.text));
        list.append(entry);
    }
    return list;
}

nb::list settings_of(const std::string& model) {
    if (model == "chainmail") return rows_of(chainmail_rows());
    if (model == "springs") return rows_of(spring_rows());
    if (model == "body") return rows_of(body_rows());
    if (model == "network") return rows_of(network_rows());
    if (model == "catheter") return rows_of(catheter_rows());
    if (model == "wall") return rows_of(wall_rows());
    if (model == "spring_solver") return rows_of(spring_solver_rows());
    if (model == "elastic_scan") return rows_of(elastic_scan_rows());
    if (model == "elastic") return rows_of(elastic_rows());
    if (model == "fit") return rows_of(fit_rows());
    if (model == "gauss_newton") return rows_of(gauss_newton_rows());
    if (model == "annealing") return rows_of(annealing_rows());
    if (model == "organs") return rows_of(organ_file_rows());
    if (model == "organ") return rows_of(organ_rows());
    if (model == "truth") return rows_of(truth_rows());
    if (model == "morph") return rows_of(morph_rows());
    const std::string names =
        "chainmail, elastic_scan, springs, body, network, catheter, wall, spring_solver, elastic, "
        "fit, "
        "gauss_newton, annealing, organs, organ, truth or morph";
    raise({ErrorCode::InvalidArgument, "model: expected " + names + ", found " + model, "model",
           names, model});
}

}  // namespace

ElasticScanSettings elastic_settings_for(const Volume& scan) {
    const nb::gil_scoped_release without_lock;
    ElasticScanSettings settings;
    suit_elastic(value_defaults(scan), settings);
    return settings;
}

ScanTissueSettings scan_tissue_from(const std::string& model, const nb::dict& given,
                                    const Volume& scan, ChainMailSettings chainmail) {
    if (model == "chainmail") {
        change(chainmail, given, chainmail_rows());
        return chainmail;
    }
    if (model == "elastic") {
        ElasticScanSettings elastic = elastic_settings_for(scan);
        change(elastic, given, elastic_scan_rows());
        return elastic;
    }
    raise({ErrorCode::InvalidArgument, "model: expected chainmail or elastic, found " + model,
           "model", "chainmail or elastic", model});
}

Keywords scan_tissue_keywords() {
    return together({keywords_of(chainmail_rows()),
                     unset(keywords_of(elastic_scan_rows()), {"held_above_hu"})});
}

Record record_of(const nb::dict& arguments) {
    Record record;
    for (const auto& [key, value] : arguments) {
        const std::string name = name_of_keyword(nb::cast<std::string>(key));
        record.emplace_back(name, value_from(name, value));
    }
    return record;
}

nb::dict dict_of(const Record& record) {
    nb::dict dict;
    for (const NamedValue& named : record) dict[named.name.c_str()] = object_of(named.value);
    return dict;
}

void bind_settings(nb::module_& m) {
    m.def("settings_of", &settings_of, nb::arg("model"),
          nb::sig("def settings_of(model: str) -> list[dict[str, typing.Any]]"),
          "Settings that a model takes as keyword arguments.\n\n"
          "Args:\n"
          "    model: \"chainmail\", \"elastic_scan\", \"springs\", \"body\" or \"network\" for "
          "tissues; \"organs\", "
          "\"organ\"; \"catheter\", \"wall\"; \"spring_solver\"; \"elastic\"; \"fit\", "
          "\"gauss_newton\", \"annealing\"; \"truth\"; \"morph\".\n\n"
          "Returns:\n"
          "    One dictionary for each: name, default, unit, range and text.");
    m.def(
        "materials",
        [] {
            nb::list list;
            for (const MaterialPassport& passport : material_passports())
                list.append(dict_of(pliant::record_of(passport)));
            return list;
        },
        nb::sig("def materials() -> list[dict[str, typing.Any]]"),
        "Measured tissues and phantom silicones: docs/reference/materials.md.\n\n"
        "Returns:\n"
        "    One dictionary for each: name, sample, source, licence, young_modulus_kpa, "
        "deviation_kpa, poisson_ratio, density_kg_m3, density_source and limits; the measured "
        "curve as load, strain and stress_kpa, which are empty without one; error_percent of the "
        "law of bodies, fitted_young_modulus_kpa and fitted_error_percent, None without a curve.");
}

}  // namespace pliant::python
