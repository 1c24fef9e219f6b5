// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Material passports: a table of all, or one with its curve beside the law's; or as JSON.

#include <pliant/core/text.h>
#include <pliant/models/passports.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <string>

#include "commands.h"
#include "json.h"

namespace pliant::app {
namespace {

constexpr const char* kLoads[] = {"tension", "compression", "shear"};

int width_of(std::string_view text) {
    return int(text.size());
}

std::string modulus_text(const MaterialPassport& passport) {
    const std::string value = short_text(passport.young_modulus_kpa);
    return passport.deviation_kpa > 0 ? value + " ± " + short_text(passport.deviation_kpa) : value;
}

Json passport_json(const MaterialPassport& passport) {
    Json json;
    for (const NamedValue& named : record_of(passport)) json[named.name] = value_json(named.value);
    return json;
}

void print_materials() {
    std::printf("%-20s %8s %6s %9s  %s\n", "name", "E [kPa]", "nu", "[kg/m3]", "source");
    for (const MaterialPassport& passport : material_passports())
        std::printf("%-20.*s %8s %6s %9s  %.*s\n", width_of(passport.name), passport.name.data(),
                    short_text(passport.young_modulus_kpa).c_str(),
                    short_text(passport.poisson_ratio).c_str(),
                    short_text(passport.density_kg_m3).c_str(), width_of(passport.source),
                    passport.source.data());
}

void print_property(const char* name, const std::string& text) {
    if (!text.empty()) std::printf("%-12s %s\n", name, text.c_str());
}

std::string law_error_text(const LawError& error) {
    const std::string exponent =
        error.ogden_alpha == 2 ? "" : ", exponent " + fixed_text(error.ogden_alpha, 1);
    return short_text(error.young_modulus_kpa, 3) + " kPa" + exponent + ": " +
           fixed_text(error.percent, 0) + " % RMS (tension " +
           fixed_text(error.tension_percent, 0) + " %, compression " +
           fixed_text(error.compression_percent, 0) + " %, shear " +
           fixed_text(error.shear_percent, 0) + " %)";
}

void print_passport(const MaterialPassport& passport) {
    print_property("name", std::string(passport.name));
    print_property("sample", std::string(passport.sample));
    print_property("source",
                   std::string(passport.source) + " (" + std::string(passport.licence) + ")");
    print_property("modulus", modulus_text(passport) + " kPa at small strain");
    print_property("Poisson", short_text(passport.poisson_ratio));
    print_property("density", short_text(passport.density_kg_m3) + " kg/m3 (" +
                                  std::string(passport.density_source) + ")");
    print_property("limits", std::string(passport.limits));
    if (passport.curve.empty()) return print_property("curve", "none is available");
    const LawError fit = fit_law(passport);
    print_property("law's error", law_error_text(law_error(passport, passport.young_modulus_kpa)));
    print_property("best fit", law_error_text(fit));
    print_property("Ogden's law",
                   law_error_text(law_error(passport, passport.ogden_young_modulus_kpa,
                                            passport.ogden_alpha)));
    std::printf("\n%-12s %9s %9s %9s %9s %9s   [kPa]\n", "load", "strain", "measured", "law", "fit",
                "Ogden");
    for (const StressPoint& point : passport.curve) {
        const auto law = [&](double modulus_kpa, double alpha) {
            return fixed_text(
                ogden_stress(modulus_kpa, passport.poisson_ratio, alpha, point.load, point.strain),
                4);
        };
        std::printf("%-12s %9s %9s %9s %9s %9s\n", kLoads[std::size_t(point.load)],
                    fixed_text(point.strain, 5).c_str(), fixed_text(point.stress_kpa, 4).c_str(),
                    law(passport.young_modulus_kpa, 2).c_str(),
                    law(fit.young_modulus_kpa, 2).c_str(),
                    law(passport.ogden_young_modulus_kpa, passport.ogden_alpha).c_str());
    }
}

}  // namespace

void add_materials(CLI::App& app, MaterialsOptions& o) {
    auto* c = app.add_subcommand("materials", "List measured tissues and phantom silicones");
    c->add_option("NAME", o.name,
                  "one of them, with its curve and the errors of the laws of bodies");
    c->add_flag("--json", o.json, "one JSON array, or one object");
    c->footer("Example:\n  pliant materials cortex");
}

int run_materials(const MaterialsOptions& options) {
    const MaterialPassport* const one =
        options.name.empty() ? nullptr : find_material(options.name);
    if (!options.name.empty() && !one)
        return bad_input("NAME: expected a name of the table of pliant materials, found '" +
                         options.name + "'");
    if (!options.json) {
        one ? print_passport(*one) : print_materials();
        return kExitOk;
    }
    Json json = Json::array();
    if (one)
        json = passport_json(*one);
    else
        for (const MaterialPassport& passport : material_passports())
            json.push_back(passport_json(passport));
    std::printf("%s\n", json.dump(2).c_str());
    return kExitOk;
}

}  // namespace pliant::app
