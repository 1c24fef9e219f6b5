// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Options of `pliant truth`.

#include <pliant/data/truth.h>
#include <pliant/models/elastic_scan.h>

#include "commands.h"
#include "common_options.h"
#include "setting_options.h"

namespace pliant::app {
namespace {

void add_truth_make(CLI::App* truth, TruthMakeOptions& o) {
    auto* c = truth->add_subcommand("make", "Make pairs of scans whose deformation is known");
    c->add_option("SCAN", o.file, "the fixed image: NRRD, MetaImage, NIfTI, VTI, DICOM")
        ->required();
    add_scan(c, o.scan);
    c->add_option("--out", o.out, "folder to make")->required();
    c->add_option("--cases", o.cases, "number of cases (default 1)")->check(CLI::Range(1, 100000));
    c->add_option("--seed", o.seed,
                  "of the first case; the next one has the next seed (default 1)");
    for (const auto& row : truth_rows()) add_setting(c, truth_rows(), row.name, o.given);
    c->add_option("--model", o.model,
                  "tissue: chainmail (default), or elastic: finite elements on the voxels, in "
                  "equilibrium after each motion, without the kinds cut and interface")
        ->check(CLI::IsMember({"chainmail", "elastic"}));
    c->add_option("--config", o.config, "settings of the tissue (TOML, as of pliant deform)");
    for (const char* const name : {"poisson_ratio", "held_above_hu"})
        add_setting(c, elastic_scan_rows(), name, o.tissue)->group("With --model elastic");
    c->add_option("--format", o.format, "nrrd or nifti (default nrrd)")
        ->check(CLI::IsMember({"nrrd", "nifti"}));
    c->add_flag("--raw", o.raw, "no compression of scans and fields (nrrd): faster, larger");
    add_threads(c, o.threads);
    c->footer(
        "Examples:\n"
        "  pliant truth make thorax.nrrd --cases 20 --out truth\n"
        "  pliant truth make thorax.nrrd --kinds slide,interface --motions 2 --seed 100 --out t\n"
        "  pliant truth make thorax.nrrd --model elastic --kinds contact,slide --out elastic\n"
        "docs/howto/truth.md describes the files.");
}

void add_truth_score(CLI::App* truth, TruthScoreOptions& o) {
    auto* c = truth->add_subcommand("score", "Score registrations of these pairs");
    c->add_option("DIR", o.folder, "folder that truth make has made")->required();
    const std::string pattern =
        "[NAME=]PATTERN, where {case} stands for the name of a case's folder; may be repeated";
    c->add_option("--field", o.fields,
                  "displacement fields, fixed point to moving point (NRRD, NIfTI, MetaImage; LPS "
                  "as ITK writes them): " +
                      pattern)
        ->type_name("PATTERN");
    c->add_option("--transform", o.transforms, "affine transforms in ITK's text format: " + pattern)
        ->type_name("PATTERN");
    c->add_option("--points", o.points,
                  "positions of the fixed landmarks in the moving image, one x,y,z a line [LPS, "
                  "mm]: " +
                      pattern)
        ->type_name("PATTERN");
    c->add_flag("--ras", o.ras, "the vectors of --field are RAS");
    c->add_option("--csv", o.csv, "table of all cases");
    c->add_option("--report", o.report, "the same as JSON, and over the cases");
    c->add_option("--markdown", o.markdown, "table over the cases");
    c->add_option("--page", o.page, "page with plots (.html), which needs no other file");
    add_threads(c, o.threads);
    c->footer(
        "Examples:\n"
        "  pliant truth score truth --field 'demons=out/{case}.nrrd' --page demons.html\n"
        "  pliant truth score truth --field 'a=a/{case}.nii.gz' --field 'b=b/{case}.nii.gz'\n"
        "  pliant truth score truth --points 'out/{case}.csv' --csv scores.csv\n"
        "The first row of each table is \"none\": the errors without a registration.");
}

}  // namespace

void add_truth(CLI::App& app, TruthOptions& o) {
    auto* c = app.add_subcommand("truth", "Registration truth: make it, or score registrations");
    c->require_subcommand(1);
    add_truth_make(c, o.make);
    add_truth_score(c, o.score);
}

}  // namespace pliant::app
