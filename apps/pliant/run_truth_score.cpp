// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Scores registrations of a data set of `pliant truth make`.

#include <pliant/core/files.h>
#include <pliant/data/truth.h>
#include <pliant/scan_files.h>

#include <array>
#include <cstdio>
#include <filesystem>
#include <optional>
#include <set>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "options.h"
#include "output_names.h"
#include "output_text.h"
#include "progress.h"
#include "standard_output.h"
#include "truth_files.h"
#include "truth_report.h"

namespace pliant::app {
namespace fs = std::filesystem;
namespace {

enum class Kind { Field, Transform, Points };

struct Answer {
    Kind kind;
    std::string name, pattern;

    fs::path file(const std::string& one) const {
        std::string text = pattern;
        for (std::size_t at = 0; (at = text.find("{case}", at)) != std::string::npos;
             at += one.size())
            text.replace(at, 6, one);
        return text;
    }
};

/// NAME=PATTERN, or PATTERN alone. @param fallback  name without one
Answer answer_of(Kind kind, const std::string& text, const std::string& fallback) {
    const auto equals = text.find('=');
    if (equals == std::string::npos || equals == 0) return {kind, fallback, text};
    return {kind, text.substr(0, equals), text.substr(equals + 1)};
}

Result<std::vector<Answer>> answers_of(const TruthScoreOptions& o, std::size_t cases) {
    std::vector<Answer> answers;
    std::set<std::string> names{"none"};
    const auto add = [&](Kind kind, const char* option,
                         const std::vector<std::string>& texts) -> Status {
        for (const std::string& text : texts) {
            const std::string number =
                texts.size() > 1 ? " " + std::to_string(answers.size() + 1) : std::string();
            Answer answer = answer_of(kind, text, std::string(option).substr(2) + number);
            if (cases > 1 && answer.pattern.find("{case}") == std::string::npos)
                return Error{ErrorCode::InvalidArgument,
                             std::string(option) +
                                 ": expected {case} in the pattern, for the name of the case's "
                                 "folder, found " +
                                 answer.pattern};
            if (!names.insert(answer.name).second)
                return Error{ErrorCode::InvalidArgument,
                             std::string(option) + ": expected a name of its own, found " +
                                 answer.name + " again"};
            answers.push_back(std::move(answer));
        }
        return Ok{};
    };
    for (const auto& [kind, option, texts] :
         {std::tuple{Kind::Field, "--field", &o.fields},
          std::tuple{Kind::Transform, "--transform", &o.transforms},
          std::tuple{Kind::Points, "--points", &o.points}})
        if (const Status s = add(kind, option, *texts); !s.ok()) return s.error();
    return answers;
}

/// x → matrix·(x − centre) + centre + shift [mm, LPS].
struct Affine {
    Mat3d matrix = kIdentity3;
    Vec3d centre{0, 0, 0}, shift{0, 0, 0};
};

/// Reads one affine transform or translation from ITK's text format.
Result<Affine> read_transform(const fs::path& path) {
    const auto text = read_small_file(path, kMaxSmallFileBytes, "a transform");
    if (!text.ok()) return text.error();
    const auto fail = [&](const std::string& what) {
        return Error{ErrorCode::Unsupported,
                     path.string() +
                         ": expected one affine transform or translation in ITK's "
                         "text format (.tfm, .txt), found " +
                         what + "; write another one as a displacement field"};
    };
    std::istringstream lines(*text);
    std::string line, type;
    std::vector<double> parameters, centre;
    while (std::getline(lines, line)) {
        const auto colon = line.find(':');
        if (line.empty() || line[0] == '#' || colon == std::string::npos) continue;
        const std::string key = line.substr(0, colon), rest = line.substr(colon + 1);
        if (key == "Transform") {
            if (!type.empty()) return fail("several");
            std::istringstream(rest) >> type;
            continue;
        }
        std::vector<double>& to = key == "Parameters" ? parameters : centre;
        std::istringstream numbers(rest);
        for (double number; numbers >> number;) to.push_back(number);
    }
    Affine affine;
    const bool is_translation = type.starts_with("TranslationTransform_");
    const bool is_affine =
        type.starts_with("AffineTransform_") || type.starts_with("MatrixOffsetTransformBase_");
    if ((!is_translation && !is_affine) || !type.ends_with("_3_3"))
        return fail(type.empty() ? "none" : shown(type));
    if (parameters.size() != (is_affine ? 12U : 3U))
        return fail(std::to_string(parameters.size()) + " parameters");
    if (is_affine)
        for (std::size_t n = 0; n < 9; ++n)
            affine.matrix.columns[n % 3][int(n / 3)] = parameters[n];
    const std::size_t first = is_affine ? 9 : 0;
    affine.shift = {parameters[first], parameters[first + 1], parameters[first + 2]};
    if (is_affine && centre.size() == 3) affine.centre = {centre[0], centre[1], centre[2]};
    return affine;
}

/// The transform's displacements at the voxels, between which it is linear.
VectorField field_of(const Affine& affine, const Grid& grid) {
    VectorField field{grid, FieldKind::Resampling, {}};
    field.vectors_mm.reserve(voxel_count(grid));
    for (int k = 0; k < grid.size.z; ++k)
        for (int j = 0; j < grid.size.y; ++j)
            for (int i = 0; i < grid.size.x; ++i) {
                const Vec3d x = world_from_voxel(grid, {double(i), double(j), double(k)});
                const Vec3d u =
                    affine.matrix * (x - affine.centre) + affine.centre + affine.shift - x;
                field.vectors_mm.push_back({float(u.x), float(u.y), float(u.z)});
            }
    return field;
}

Result<TruthScore> score_of(const Answer& answer, const std::string& one, const TruthData& truth,
                            const TruthScoreOptions& o, const TaskArena& arena) {
    const fs::path file = answer.file(one);
    if (answer.kind == Kind::Points) {
        const auto points = read_points(file);
        if (!points.ok()) return points.error();
        auto score = score_points(truth, *points);
        if (!score.ok())
            return Error{score.error().code, file.string() + ": " + score.error().message};
        return score;
    }
    if (answer.kind == Kind::Transform) {
        const auto affine = read_transform(file);
        if (!affine.ok()) return affine.error();
        return score_field(truth, field_of(*affine, truth.forward.grid), arena);
    }
    auto field = read_vector_field(file);
    if (!field.ok()) return field.error();
    if (o.ras)
        for (Vec3f& v : field->vectors_mm) v = {-v.x, -v.y, v.z};
    return score_field(truth, *field, arena);
}

}  // namespace

int run_truth_score(const TruthScoreOptions& o) {
    const auto index = read_truth_index(o.folder);
    if (!index.ok()) return bad_input(index.error().message);
    const auto answers = answers_of(o, index->cases.size());
    if (!answers.ok()) return bad_input(answers.error().message);
    StagedFiles files;
    fs::path csv, json, markdown, page;
    const OutputName outputs[] = {{"--csv", o.csv, csv, {".csv"}},
                                  {"--report", o.report, json, {".json"}},
                                  {"--markdown", o.markdown, markdown, {".md"}},
                                  {"--page", o.page, page, {".html"}}};
    if (const Status s = stage_names(outputs, (fs::path(o.folder) / "truth.json").string(), files);
        !s.ok())
        return bad_input(s.error().message);
    std::optional<ProgressBar> bar(std::in_place, "score");
    const auto fail = [&](const Error& error) {
        bar.reset();
        return bad_input(error.message);
    };
    const TaskArena arena(o.threads);
    TruthTable table{*index, {{"none", {}}}};
    for (const Answer& answer : *answers) table.methods.push_back({answer.name, {}});
    for (std::size_t n = 0; n < index->cases.size(); ++n) {
        const std::string& one = index->cases[n];
        const auto truth = read_truth_data(fs::path(o.folder) / one, index->ending);
        if (!truth.ok()) return fail(truth.error());
        const auto nothing = score_nothing(*truth, arena);
        if (!nothing.ok()) return fail(nothing.error());
        table.methods[0].scores.push_back(*nothing);
        for (std::size_t m = 0; m < answers->size(); ++m) {
            const auto score = score_of((*answers)[m], one, *truth, o, arena);
            if (!score.ok()) return fail(score.error());
            table.methods[m + 1].scores.push_back(*score);
        }
        bar->show(double(n + 1) / double(index->cases.size()));
    }
    for (const auto& [path, text_of] :
         {std::pair{&csv, &truth_csv}, std::pair{&json, &truth_json},
          std::pair{&markdown, &truth_markdown}, std::pair{&page, &truth_page}})
        if (!path->empty())
            if (const Status s = write_text(*path, text_of(table)); !s.ok()) return fail(s.error());
    if (const Status s = files.commit(); !s.ok()) return fail(s.error());
    bar.reset();
    for (const OutputName& output : outputs)
        if (is_standard_output(output.name)) return kExitOk;
    std::fputs(truth_markdown(table).c_str(), stdout);
    return kExitOk;
}

}  // namespace pliant::app
