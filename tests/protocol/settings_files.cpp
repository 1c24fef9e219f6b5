// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "protocol/settings_files.h"

#include <pliant/chainmail.h>
#include <pliant/data/morph.h>
#include <pliant/data/truth.h>
#include <pliant/mesh.h>
#include <pliant/models/body_contact.h>
#include <pliant/models/catheter.h>
#include <pliant/models/fem.h>
#include <pliant/models/fit.h>
#include <pliant/models/organs.h>
#include <pliant/models/passports.h>
#include <pliant/models/pbd.h>
#include <pliant/models/vessel.h>
#include <pliant/serve.h>
#include <pliant/tissues.h>
#include <pliant/view/haptics.h>
#include <pliant/volume.h>

#include <cmath>

#include "base/text.h"
#include "protocol/wire_rows.h"

namespace pliant::test {
namespace {

using serve::DriveCommand;
using serve::IsoCommand;
using serve::TissueChoice;

bool is_unset(const SettingValue& value) {
    const auto* text = std::get_if<std::string>(&value);
    const auto* points = std::get_if<std::vector<Vec3d>>(&value);
    const auto* pairs = std::get_if<std::vector<NumberPair>>(&value);
    return std::holds_alternative<std::monostate>(value) || (text && text->empty()) ||
           (points && points->empty()) || (pairs && pairs->empty());
}

std::string range_of(const SettingInfo& row) {
    if (!row.choices.empty()) return expected_of(row);
    const bool is_free = !std::isfinite(row.range.low) && !std::isfinite(row.range.high);
    if (is_free) return std::string(row.unit);
    // Labels are any whole number.
    return row.kind == SettingKind::Wholes && row.range.high > 1e9 ? "" : expected_of(row);
}

template <class T>
void add_rows(std::string& text, std::string& table, bool has_tables, SettingRows<T> rows,
              std::string_view only = {}) {
    for (const Setting<T>& row : rows) {
        if (!only.empty() && row.table != only) continue;
        const SettingValue missing = value_of(T{}, row);
        if (has_tables) {
            text += table == row.table ? "| " : "| `[" + std::string(row.table) + "]` ";
            table = row.table;
        }
        text.append("| `").append(has_tables ? row.key_in_file() : row.name).append("` | ");
        text.append(range_of(row)).append(" | ");
        if (!is_unset(missing)) text.append("`").append(toml_text(missing)).append("` ");
        text.append("| ").append(row.text).append(" |\n");
    }
}

constexpr const char* kHead = "| setting | range | default | meaning |\n|---|---|---|---|\n";
constexpr const char* kFileHead =
    "| table | key | range | default | meaning |\n|---|---|---|---|---|\n";

template <class... T>
std::string table_of(SettingRows<T>... rows) {
    std::string text = kHead, table;
    (add_rows(text, table, false, rows), ...);
    return text;
}

std::string settings_table() {
    std::string text = kFileHead, table;
    add_rows(text, table, true, chainmail_rows());
    table.clear();
    std::string labels;
    add_rows(labels, table, true, label_rows());
    return text + labels.replace(labels.find("[label]"), 7, "[[label]]");
}

std::string elastic_scan_table() {
    std::string text = kFileHead, table;
    add_rows(text, table, true, elastic_scan_rows());
    return text;
}

std::string vessel_table() {
    std::string text = kFileHead, table;
    for (const char* name : {"vessel", "wall", "catheter", "entry", "way", "simulation"}) {
        add_rows(text, table, true, vessel_file_rows(), name);
        add_rows(text, table, true, catheter_rows(), name);
    }
    std::string script;
    add_rows(script, table, true, vessel_act_rows());
    return text + script.replace(script.find("[script]"), 8, "[[script]]");
}

std::string organs_table() {
    std::string text = kFileHead, table;
    add_rows(text, table, true, organ_file_rows());
    for (const char* name : {"body", "contents"}) {
        std::string list;
        table.clear();
        if (name == std::string("body"))
            add_rows(list, table, true, organ_rows());
        else
            add_rows(list, table, true, organ_contents_rows());
        const std::string title = "[" + std::string(name) + "]";
        text += list.replace(list.find(title), title.size(), "[" + title + "]");
    }
    return text;
}

std::string type_of(const SettingInfo& row) {
    switch (row.kind) {
        case SettingKind::Flag:
            return "boolean";
        case SettingKind::Whole:
        case SettingKind::Number:
            return "number";
        case SettingKind::Text:
        case SettingKind::Choice:
            break;
        case SettingKind::Numbers:
        case SettingKind::Wholes:
            return "number[]";
        case SettingKind::Points:
            return "number[][]";
        case SettingKind::Pairs:
            return "[number, number][]";
        case SettingKind::Texts:
            return "string[]";
    }
    if (row.choices.empty()) return "string";
    std::string type = "'";
    for (const char c : row.choices) type += c == '|' ? std::string("' | '") : std::string(1, c);
    return type + "'";
}

template <class T>
void add_type(std::string& text, const char* name, const char* constant, SettingRows<T> rows) {
    text += std::string("\nexport interface ") + name + " {\n";
    for (const Setting<T>& row : rows) {
        text.append("    ").append(row.name).append(": ").append(type_of(row)).append(";");
        text.append(row.unit.empty() ? "" : " ///< [").append(row.unit);
        text.append(row.unit.empty() ? "\n" : "]\n");
    }
    text += std::string("}\n\nexport const ") + constant + ": Record<keyof " + name +
            ", SettingRow> = {\n";
    for (const Setting<T>& row : rows) {
        text.append("    ").append(row.name).append(": {\n");
        text.append("        unit: '").append(row.unit).append("',\n");
        if (std::isfinite(row.range.low)) text += "        low: " + text_of(row.range.low) + ",\n";
        if (std::isfinite(row.range.high))
            text += "        high: " + text_of(row.range.high) + ",\n";
        text.append("        text: '");
        for (const char c : row.text) text += c == '\'' ? std::string("\\'") : std::string(1, c);
        text.append("',\n    },\n");
    }
    text += "};\n";
}

std::string with_source(double value, double deviation, std::string_view source) {
    return short_text(value) + (deviation > 0 ? " ± " + short_text(deviation) : "") + " [" +
           std::string(source) + "]";
}

/// Material passports as rows of Markdown.
std::string passport_table() {
    std::string text =
        "| name | sample | E [kPa] | ν | density [kg/m³] | errors of the laws | limits |\n"
        "|---|---|---|---|---|---|---|\n";
    for (const MaterialPassport& passport : material_passports()) {
        std::string error;
        if (!passport.curve.empty()) {
            const LawError fit = fit_law(passport);
            error = fixed_text(law_error(passport, passport.young_modulus_kpa).percent, 0) +
                    " %; best fit, " + fixed_text(fit.young_modulus_kpa, 1) +
                    " kPa: " + fixed_text(fit.percent, 0) + " %; Ogden, " +
                    fixed_text(passport.ogden_young_modulus_kpa, 2) + " kPa, α " +
                    short_text(passport.ogden_alpha) + ": " +
                    fixed_text(
                        law_error(passport, passport.ogden_young_modulus_kpa, passport.ogden_alpha)
                            .percent,
                        0) +
                    " %";
        }
        const auto cell = [&](const std::string& value) { text += " " + value + " |"; };
        text += "|";
        cell("`" + std::string(passport.name) + "`");
        cell(std::string(passport.sample));
        cell(with_source(passport.young_modulus_kpa, passport.deviation_kpa, passport.source));
        cell(short_text(passport.poisson_ratio));
        cell(with_source(passport.density_kg_m3, 0, passport.density_source));
        cell(error);
        cell(std::string(passport.limits));
        text += "\n";
    }
    return text;
}

}  // namespace

std::map<std::string, std::string> settings_tables() {
    return {{"chainmail", settings_table()},
            {"springs", table_of(spring_rows())},
            {"elastic scan", elastic_scan_table()},
            {"vessel", vessel_table()},
            {"materials", table_of(chainmail_material_rows())},
            {"tissue", table_of(serve::tissue_rows(), spring_rows())},
            {"elastic tissue", table_of(elastic_scan_rows())},
            {"iso", table_of(serve::iso_rows())},
            {"catheter", table_of(serve::drive_rows())},
            {"pbd", table_of(pbd_rows())},
            {"boxes", table_of(pbd_box_rows())},
            {"body contact", table_of(body_contact_rows())},
            {"body", table_of(body_rows())},
            {"organs", organs_table()},
            {"fill", table_of(fill_rows())},
            {"spring solver", table_of(spring_solver_rows())},
            {"fem", table_of(elastic_rows())},
            {"fit", table_of(fit_rows())},
            {"network", table_of(network_rows())},
            {"gauss newton", table_of(gauss_newton_rows())},
            {"annealing", table_of(annealing_rows())},
            {"wall", table_of(wall_rows())},
            {"phantom", table_of(phantom_rows())},
            {"feel", table_of(chainmail_feel_rows())},
            {"servo", table_of(haptic_servo_rows())},
            {"server", table_of(server_rows())},
            {"depth", table_of(serve::depth_rows())},
            {"truth", table_of(truth_rows())},
            {"morph", table_of(morph_rows())},
            {"relax", table_of(relax_rows())}};
}

std::string settings_types() {
    std::string text =
        "// SPDX-FileCopyrightText: 2026 The Pliant authors\n"
        "// SPDX-License-Identifier: Apache-2.0\n\n"
        "// Settings that messages carry. Made from the library's tables by `./dev settings`; a\n"
        "// test compares.\n\n"
        "export interface SettingRow {\n    unit: string;\n    low?: number;\n"
        "    high?: number;\n    text: string;\n}\n";
    add_type(text, "Materials", "materialRows", chainmail_material_rows());
    add_type(text, "SpringSettings", "springRows", spring_rows());
    add_type(text, "ElasticSettings", "elasticRows", elastic_scan_rows());
    add_type(text, "Drive", "driveRows", serve::drive_rows());
    return text;
}

std::string with_tables(const std::string& document) {
    const std::string kBegin = "<!-- settings: ", kEnd = "<!-- end -->";
    auto tables = settings_tables();
    tables["passports"] = passport_table();
    std::string text = document;
    for (std::size_t at = 0; (at = text.find(kBegin, at)) != text.npos; ++at) {
        const std::size_t name = at + kBegin.size(), line = text.find(" -->\n", name);
        const std::size_t end = text.find(kEnd, at);
        if (line == text.npos || end == text.npos) break;
        const auto table = tables.find(text.substr(name, line - name));
        const std::size_t first = line + 5;
        if (table != tables.end()) text.replace(first, end - first, "\n" + table->second + "\n");
    }
    return text;
}

}  // namespace pliant::test
