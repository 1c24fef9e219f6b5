// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "truth_report.h"

#include <pliant/core/text.h>
#include <pliant/core/version.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <optional>

namespace pliant::app {
namespace {

/// A field of a CSV line, in quotes if it needs them.
std::string csv_field(const std::string& text) {
    if (text.find_first_of(",\"\n\r") == std::string::npos) return text;
    std::string quoted = "\"";
    for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
    return quoted + "\"";
}

std::string escaped(const std::string& text) {
    std::string safe;
    for (const char c : text)
        safe += c == '<'   ? std::string("&lt;")
                : c == '>' ? std::string("&gt;")
                : c == '&' ? std::string("&amp;")
                : c == '"' ? std::string("&quot;")
                           : std::string(1, c);
    return safe;
}

std::string markdown_cell(const std::string& text) {
    std::string safe;
    for (const char c : text) safe += c == '|' ? std::string("\\|") : std::string(1, c);
    return safe;
}

Json errors_json(const TruthErrors& e) {
    return {{"count", e.count},
            {"mean_mm", e.mean_mm},
            {"median_mm", e.median_mm},
            {"p95_mm", e.p95_mm},
            {"max_mm", e.max_mm}};
}

Json rows_json(const std::array<TruthErrors, kTruthRows>& rows) {
    Json json = Json::object();
    for (std::size_t r = 0; r < rows.size(); ++r)
        if (rows[r].count > 0) json[std::string(name_of(TruthRow(r)))] = errors_json(rows[r]);
    return json;
}

std::array<TruthErrors, kTruthRows> all_errors(const TruthMethod& method) {
    std::array<TruthErrors, kTruthRows> rows;
    for (std::size_t r = 0; r < rows.size(); ++r) rows[r] = errors_over_cases(method, TruthRow(r));
    return rows;
}

constexpr std::array<TruthRow, 8> kShown = {
    TruthRow::Moved, TruthRow::Interior, TruthRow::Wall, TruthRow::Interface,
    TruthRow::Cut,   TruthRow::Still,    TruthRow::Bone, TruthRow::Landmarks};
constexpr std::array<const char*, 7> kColours = {"#8a8f98", "#2b6cb0", "#c05621", "#2f855a",
                                                 "#805ad5", "#b83280", "#975a16"};

double top_of(const TruthTable& table) {
    double top = 0.1;
    for (const TruthMethod& method : table.methods)
        for (const TruthRow row : kShown)
            top = std::max(top, errors_over_cases(method, row).p95_mm);
    return top;
}

std::string text_at(double x, double y, const std::string& anchor, const std::string& text) {
    return "<text x=\"" + fixed_text(x, 1) + "\" y=\"" + fixed_text(y, 1) + "\" text-anchor=\"" +
           anchor + "\">" + escaped(text) + "</text>\n";
}
std::string line_of(double x1, double y1, double x2, double y2, const std::string& style) {
    return "<line x1=\"" + fixed_text(x1, 1) + "\" y1=\"" + fixed_text(y1, 1) + "\" x2=\"" +
           fixed_text(x2, 1) + "\" y2=\"" + fixed_text(y2, 1) + "\" " + style + "/>\n";
}

/// Bars of the mean with a whisker to the 95th percentile, by type and method.
std::string bars_of(const TruthTable& table) {
    constexpr double kWidth = 920, kHeight = 320, kLeft = 48, kBottom = 40, kTop = 12;
    const double top = top_of(table), scale = (kHeight - kBottom - kTop) / top;
    const auto y_of = [&](double mm) { return kHeight - kBottom - mm * scale; };
    std::string svg = "<svg viewBox=\"0 0 920 320\" role=\"img\" aria-label=\"errors by type\">\n";
    for (int tick = 0; tick <= 4; ++tick) {
        const double mm = top * tick / 4;
        svg += line_of(kLeft, y_of(mm), kWidth, y_of(mm), "class=\"grid\"");
        svg += text_at(kLeft - 6, y_of(mm) + 4, "end", fixed_text(mm, top < 2 ? 2 : 1));
    }
    const double group = (kWidth - kLeft) / double(kShown.size());
    const double bar = 0.8 * group / double(table.methods.size());
    for (std::size_t r = 0; r < kShown.size(); ++r) {
        const double x = kLeft + group * (double(r) + 0.1);
        svg += text_at(kLeft + group * (double(r) + 0.5), kHeight - 20, "middle",
                       std::string(name_of(kShown[r])));
        for (std::size_t m = 0; m < table.methods.size(); ++m) {
            const TruthErrors e = errors_over_cases(table.methods[m], kShown[r]);
            if (e.count == 0) continue;
            const double at = x + bar * double(m), middle = at + 0.5 * bar;
            svg += "<rect x=\"" + fixed_text(at, 1) + "\" y=\"" + fixed_text(y_of(e.mean_mm), 1) +
                   "\" width=\"" + fixed_text(0.9 * bar, 1) + "\" height=\"" +
                   fixed_text(e.mean_mm * scale, 1) + "\" fill=\"" + kColours[m % kColours.size()] +
                   "\"><title>" + escaped(table.methods[m].name) + ", " +
                   std::string(name_of(kShown[r])) + ": mean " + fixed_text(e.mean_mm, 3) +
                   " mm, 95 % " + fixed_text(e.p95_mm, 3) + " mm, max " + fixed_text(e.max_mm, 3) +
                   " mm</title></rect>\n";
            svg += line_of(middle, y_of(e.mean_mm), middle, y_of(e.p95_mm), "class=\"whisker\"");
        }
    }
    return svg + "</svg>\n";
}

/// One dot for each case and method: mean error of the moved tissue over that without registration.
std::string dots_of(const TruthTable& table) {
    constexpr double kWidth = 920, kHeight = 300, kLeft = 48, kBottom = 40, kTop = 12;
    double right = 0.1, top = 0.1;
    const auto error = [](const TruthScore& score) {
        const TruthErrors& moved = score.rows[std::size_t(TruthRow::Moved)];
        return moved.count ? moved : score.rows[std::size_t(TruthRow::Landmarks)];
    };
    for (const TruthMethod& method : table.methods)
        for (std::size_t n = 0; n < method.scores.size(); ++n) {
            right = std::max(right, error(table.methods[0].scores[n]).mean_mm);
            top = std::max(top, error(method.scores[n]).mean_mm);
        }
    const auto x_of = [&](double mm) { return kLeft + (kWidth - kLeft - 12) * mm / right; };
    const auto y_of = [&](double mm) {
        return kHeight - kBottom - (kHeight - kBottom - kTop) * mm / top;
    };
    std::string svg = "<svg viewBox=\"0 0 920 300\" role=\"img\" aria-label=\"errors by case\">\n";
    for (int tick = 0; tick <= 4; ++tick) {
        svg += line_of(kLeft, y_of(top * tick / 4), kWidth, y_of(top * tick / 4), "class=\"grid\"");
        svg += text_at(kLeft - 6, y_of(top * tick / 4) + 4, "end",
                       fixed_text(top * tick / 4, top < 2 ? 2 : 1));
        svg += text_at(x_of(right * tick / 4), kHeight - 20, "middle",
                       fixed_text(right * tick / 4, right < 2 ? 2 : 1));
    }
    svg += text_at(kWidth - 4, kHeight - 4, "end", "mean error without registration [mm]");
    for (std::size_t m = 0; m < table.methods.size(); ++m)
        for (std::size_t n = 0; n < table.methods[m].scores.size(); ++n) {
            const double before = error(table.methods[0].scores[n]).mean_mm;
            const double after = error(table.methods[m].scores[n]).mean_mm;
            svg += "<circle cx=\"" + fixed_text(x_of(before), 1) + "\" cy=\"" +
                   fixed_text(y_of(after), 1) + "\" r=\"4\" fill=\"" +
                   kColours[m % kColours.size()] + "\"><title>" + escaped(table.methods[m].name) +
                   ", " + escaped(table.index.cases[n]) + ": " + fixed_text(before, 3) + " → " +
                   fixed_text(after, 3) + " mm</title></circle>\n";
        }
    return svg + "</svg>\n";
}

/// The table's cells by rows; name and folded share stand in a method's first row.
std::vector<std::array<std::string, 8>> rows_of(const TruthTable& table) {
    std::vector<std::array<std::string, 8>> rows;
    for (const TruthMethod& method : table.methods) {
        const auto folded = folded_share(method);
        bool is_first = true;
        for (const TruthRow row : kShown) {
            const TruthErrors e = errors_over_cases(method, row);
            if (e.count == 0) continue;
            rows.push_back(
                {is_first ? method.name : std::string(), std::string(name_of(row)),
                 std::to_string(e.count), fixed_text(e.mean_mm, 3), fixed_text(e.median_mm, 3),
                 fixed_text(e.p95_mm, 3), fixed_text(e.max_mm, 3),
                 is_first && folded ? fixed_text(100 * *folded, 3) + " %" : std::string()});
            is_first = false;
        }
    }
    return rows;
}

std::string table_of(const TruthTable& table) {
    std::string html =
        "<table><tr><th>method<th>type<th>points<th>mean<th>median<th>95&nbsp;%<th>"
        "max<th>folded</tr>\n";
    for (const auto& row : rows_of(table)) {
        html += "<tr>";
        for (const std::string& cell : row) html += "<td>" + escaped(cell);
        html += "</tr>\n";
    }
    return html + "</table>\n";
}

constexpr const char* kStyle =
    "body{font:15px/1.5 system-ui,sans-serif;max-width:960px;margin:2em auto;padding:0 1em;"
    "color:#1a202c;background:#fff}svg{width:100%;height:auto}svg text{font:11px system-ui,"
    "sans-serif;fill:#4a5568}.grid{stroke:#e2e8f0}.whisker{stroke:#1a202c}table{border-collapse:"
    "collapse;width:100%}td,th{padding:.2em .6em;border-bottom:1px solid #e2e8f0;text-align:right}"
    "td:nth-child(-n+2),th:nth-child(-n+2){text-align:left}.key{display:inline-block;width:.8em;"
    "height:.8em;margin:0 .3em 0 1em}";

}  // namespace

TruthErrors errors_over_cases(const TruthMethod& method, TruthRow row) {
    TruthErrors sum;
    int cases = 0;
    for (const TruthScore& score : method.scores) {
        const TruthErrors& e = score.rows[std::size_t(row)];
        if (e.count == 0) continue;
        ++cases;
        sum.count += e.count;
        sum.mean_mm += e.mean_mm;
        sum.median_mm += e.median_mm;
        sum.p95_mm += e.p95_mm;
        sum.max_mm = std::max(sum.max_mm, e.max_mm);
    }
    if (cases == 0) return sum;
    sum.mean_mm /= cases;
    sum.median_mm /= cases;
    sum.p95_mm /= cases;
    return sum;
}

std::optional<double> folded_share(const TruthMethod& method) {
    double sum = 0;
    for (const TruthScore& score : method.scores) {
        if (!score.folded_share) return {};
        sum += *score.folded_share;
    }
    return method.scores.empty() ? sum : sum / double(method.scores.size());
}

std::string truth_csv(const TruthTable& table) {
    std::string csv = "method,case,type,count,mean_mm,median_mm,p95_mm,max_mm,folded_share\n";
    for (const TruthMethod& method : table.methods)
        for (std::size_t n = 0; n < method.scores.size(); ++n)
            for (int r = 0; r < kTruthRows; ++r) {
                const TruthErrors& e = method.scores[n].rows[std::size_t(r)];
                if (e.count == 0) continue;
                const auto& folded = method.scores[n].folded_share;
                csv += csv_field(method.name) + "," + table.index.cases[n] + "," +
                       std::string(name_of(TruthRow(r))) + "," + std::to_string(e.count) + "," +
                       text_of(e.mean_mm) + "," + text_of(e.median_mm) + "," + text_of(e.p95_mm) +
                       "," + text_of(e.max_mm) + "," + (folded ? text_of(*folded) : "") + "\n";
            }
    return csv;
}

std::string truth_json(const TruthTable& table) {
    Json json = {{"version", PLIANT_VERSION},
                 {"data", table.index.json},
                 {"moved_from_mm", kTruthMovedMm},
                 {"methods", Json::array()}};
    for (const TruthMethod& method : table.methods) {
        Json one = {{"name", method.name}, {"over_cases", rows_json(all_errors(method))}};
        const auto folded = folded_share(method);
        one["folded_share"] = folded ? Json(*folded) : Json(nullptr);
        one["cases"] = Json::array();
        for (std::size_t n = 0; n < method.scores.size(); ++n) {
            const TruthScore& score = method.scores[n];
            one["cases"].push_back(
                {{"case", table.index.cases[n]},
                 {"rows", rows_json(score.rows)},
                 {"folded_share", score.folded_share ? Json(*score.folded_share) : Json(nullptr)},
                 {"folded_voxels", score.folded_voxels}});
        }
        json["methods"].push_back(std::move(one));
    }
    return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string truth_markdown(const TruthTable& table) {
    std::string text =
        "| method | type | points | mean | median | 95 % | max [mm] | folded |\n"
        "|---|---|---|---|---|---|---|---|\n";
    for (const auto& row : rows_of(table)) {
        text += "|";
        for (const std::string& cell : row) text += " " + markdown_cell(cell) + " |";
        text += "\n";
    }
    return text;
}

std::string truth_page(const TruthTable& table) {
    const Json& data = table.index.json;
    const std::string scan = data.contains("scan") && data["scan"].is_string()
                                 ? data["scan"].get<std::string>()
                                 : std::string("a scan");
    std::string html =
        "<!doctype html>\n<html lang=\"en\"><meta charset=\"utf-8\">\n<title>"
        "Registration truth: " +
        escaped(scan) + "</title>\n<style>" + kStyle +
        "</style>\n<h1>Registration "
        "truth</h1>\n<p>" +
        std::to_string(table.index.cases.size()) + " cases of " + escaped(scan) +
        ", made and scored by Pliant " PLIANT_VERSION
        ". Errors are distances to the true points in mm, at voxels whose "
        "counterpart is exact; <i>moved</i> tissue was displaced by " +
        fixed_text(kTruthMovedMm, 1) +
        " mm or more. Mean, median and 95&nbsp;% are averaged over the cases.</p>\n"
        "<p>";
    for (std::size_t m = 0; m < table.methods.size(); ++m)
        html +=
            "<span class=\"key\" style=\"background:" + std::string(kColours[m % kColours.size()]) +
            "\"></span>" + escaped(table.methods[m].name);
    html += "</p>\n<h2>By type</h2>\n<p>Bar: mean. Line: 95&nbsp;%. [mm]</p>\n" + bars_of(table) +
            "<h2>By case</h2>\n<p>Mean error of the moved tissue [mm].</p>\n" + dots_of(table) +
            "<h2>Table</h2>\n" + table_of(table) + "</html>\n";
    return html;
}

}  // namespace pliant::app
