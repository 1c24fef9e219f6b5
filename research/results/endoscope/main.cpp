// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Writes colours.md: results_colours FOLDER SCANS. Compares colours, highlights and falloff of the
// style Real with published figures of endoscopic pictures.

#include <pliant/render.h>
#include <pliant/scan_files.h>
#include <pliant/volume.h>

#include <algorithm>
#include <cstdio>
#include <optional>
#include <string>

#include "colours.h"
#include "page.h"
#include "value_of.h"

namespace pliant::results {
namespace {

constexpr int kWidth = 320, kHeight = 240;  // pixels of each picture

struct View {
    const char* name;
    const char* scan;  ///< a phantom's name, or a file
    Lining lining;
    std::optional<Vec3d> eye_mm;  ///< nullopt: found in the scan
    std::optional<Vec3d> look;    ///< nullopt: the longest free path
    double iso_hu = -500;
    Polarity polarity = Polarity::Rising;
};

const View kViews[] = {
    {.name = "trachea, phantom",
     .scan = "airway",
     .lining = Lining::Airway,
     .eye_mm = {},
     .look = {}},
    {.name = "trachea",
     .scan = "thorax_ct_256.nrrd",
     .lining = Lining::Airway,
     .eye_mm = Vec3d{-13.5, 116, -411},
     .look = Vec3d{0, 0.7, -0.7}},
    {.name = "main bronchus",
     .scan = "thorax_ct_airways_crop.nrrd",
     .lining = Lining::Airway,
     .eye_mm = {},
     .look = {}},
    {.name = "transverse colon",
     .scan = "abdomen_ct_3mm.nii.gz",
     .lining = Lining::Colon,
     .eye_mm = Vec3d{76, -239.3, 379.3},
     .look = {}},
    {.name = "ascending colon",
     .scan = "abdomen_ct_3mm.nii.gz",
     .lining = Lining::Colon,
     .eye_mm = Vec3d{91, -221.3, 319.3},
     .look = {}},
    {.name = "nasal septum, phantom",
     .scan = "sinus",
     .lining = Lining::Sinus,
     .eye_mm = Vec3d{5.5, -42, -3},
     .look = Vec3d{-0.344, 0.937, -0.062}},
    {.name = "turbinate, phantom",
     .scan = "sinus",
     .lining = Lining::Sinus,
     .eye_mm = Vec3d{4.5, -42.5, -8},
     .look = Vec3d{0.297, 0.807, -0.51}},
    {.name = "aorta",
     .scan = "aorta_cta_1p5mm.nii.gz",
     .lining = Lining::Vessel,
     .eye_mm = Vec3d{0.1, -144, 594},
     .look = Vec3d{0.2, 0.1, 1},
     .iso_hu = 180,
     .polarity = Polarity::Falling},
};

const char* name_of(Lining lining) {
    return lining == Lining::Airway  ? "airway"
           : lining == Lining::Colon ? "colon"
           : lining == Lining::Sinus ? "sinus"
                                     : "vessel";
}

Volume scan_of(const View& view, const std::string& scans, const TaskArena& arena) {
    const std::string name = view.scan;
    if (name.find('.') != std::string::npos) return value_of(read_volume(scans + "/" + name));
    return value_of(make_phantom({.name = name, .size = {192, 192, 192}}, arena)).volume;
}

Image picture_of(const View& view, const std::string& scans, const TaskArena& arena) {
    const Volume volume = scan_of(view, scans, arena);
    Endoscope e;
    if (!view.eye_mm) e = find_endoscope(volume, view.iso_hu, view.polarity, arena).value();
    if (view.eye_mm) e.eye_mm = *view.eye_mm;
    e.iso_hu = view.iso_hu;
    e.polarity = view.polarity;
    if (view.look) e.look = *view.look;
    if (view.eye_mm && !view.look)
        e.look = find_look(volume, e.eye_mm, e.iso_hu, e.polarity, arena).value();
    e.up = {0, 0, 0};
    e.style = Style::Real;
    e.lining = view.lining;
    return RayCaster(volume, arena).endoscope_view(e, kWidth, kHeight);
}

std::vector<std::string> cells(const Colour& c) {
    return {fixed_text(c.hue_deg, 1), fixed_text(c.saturation, 2), fixed_text(c.haemoglobin, 0),
            fixed_text(c.x, 3), fixed_text(c.y, 3)};
}

void add_published(Page& page) {
    page.heading(2, "Published figures");
    page.paragraph("Few papers give the colour of healthy mucosa as a number. These were found:");
    // Values of red, green and blue of [Sun2020].
    std::vector<std::string> stomach = cells(colour_of({160, 105, 91}));
    stomach.insert(stomach.begin(),
                   "stomach, no cancer, linked colour imaging, which enhances red: RGB 160, 105, "
                   "91 [Sun2020]");
    page.table(
        {"tissue", "hue [°]", "saturation", "IHb", "x", "y"},
        {{"nose, inferior turbinate, 60 healthy people, chromameter [AmJRhinol2002]", "", "", "",
          "0.426 ± 0.012 (0.401…0.454)", "0.320 ± 0.007 (0.307…0.338)"},
         {"stomach, upper body: best threshold for an infection [Asaki2001]", "", "", "62", "", ""},
         {"range of the colour scale for stomachs [Asaki2001]", "", "", "36.5…90", "", ""},
         stomach});
    page.paragraph(
        "IHb = 32 log₂(R/G) is the index of haemoglobin of endoscopes [Asaki2001], [Yao2005]. The "
        "chromameter's white point is not said; ours is D65, so its numbers are a guide and no "
        "bound. **Not found**: means for the mucosa of bronchi (a database of healthy airways "
        "exists, its abstract has no numbers [Suter2005]), of the healthy colon (there are "
        "differences between polyps and their surroundings only [Cheng2016]), and of the inside "
        "of vessels. Their tables are chosen by eye, within the range of IHb.");
    page.paragraph(
        "**Highlights.** Their share of the pixels is in no paper at hand. It follows from the "
        "scores of a detector on clinical pictures and CVC-ClinicSpec [Yu2021]: precision 88.76 "
        "%, F1 72.56 % and accuracy 99.60 % mean a recall of 61.4 %, and that *0.9 %* of the "
        "pixels are highlights. **Falloff**: calibrated endoscopes are modelled by the inverse "
        "square of the distance [Batlle2022], [Iranzo2025]: n = 2.");
}

void add_colours(Page& page, const std::string& scans, const TaskArena& arena) {
    page.heading(2, "Colours and highlights of the style real");
    std::vector<std::vector<std::string>> rows;
    double highlights = 0;
    Image sheet{4 * kWidth, 2 * kHeight, {}};
    sheet.pixels.resize(std::size_t(sheet.width) * std::size_t(sheet.height));
    for (const View& view : kViews) {
        const Image image = picture_of(view, scans, arena);
        const auto n = rows.size();
        for (int j = 0; j < kHeight; ++j)
            std::copy_n(image.pixels.begin() + j * kWidth, kWidth,
                        sheet.pixels.begin() + (int(n / 4) * kHeight + j) * sheet.width +
                            int(n % 4) * kWidth);
        const ColourStatistics s = measure_colours(image);
        highlights += s.highlights / double(std::size(kViews));
        std::vector<std::string> row = cells(s.median);
        row.insert(row.begin(), {view.name, name_of(view.lining)});
        row.insert(row.end(), {fixed_text(100 * s.highlights, 2), fixed_text(100 * s.clipped, 2)});
        rows.push_back(std::move(row));
    }
    page.picture("colours", "The eight views of the table, row by row", sheet);
    page.table({"view", "lining", "hue [°]", "saturation", "IHb", "x", "y", "highlights [%]",
                "clipped [%]"},
               rows);
    page.paragraph(
        "Medians over the pixels of the field that are not dark (value ≥ 0.15). *Highlights* are "
        "bright, pale and contrasted with their surroundings [Arnold2010], *clipped* pixels have "
        "a channel of 250 or more. The mean share of highlights is " +
        fixed_text(100 * highlights, 1) +
        " %; views down a tube have next to none, walls that face the lens have most. None of "
        "them reaches 250: the tone curve ends softly.");
}

void add_falloff(Page& page, const TaskArena& arena) {
    page.heading(2, "Falloff");
    const std::vector<Stair> stairs = light_on_stairs(arena);
    std::vector<std::vector<std::string>> rows;
    for (const Stair& s : stairs)
        rows.push_back({fixed_text(s.distance_mm, 1), fixed_text(s.light, 3),
                        fixed_text(s.light * s.distance_mm * s.distance_mm, 0)});
    page.paragraph(
        "Walls straight ahead at several distances in one picture; medians of the red channel "
        "before the tone curve, outside of the vignette.");
    page.table({"distance [mm]", "light", "light · distance²"}, rows);
    page.paragraph("Least squares over logarithms: light ~ distance⁻ⁿ with **n = " +
                   fixed_text(falloff_exponent(stairs), 2) +
                   "**. The lamps' size, 3 mm, makes near walls a little darker, patches of the "
                   "tissue make it uneven.");
}

}  // namespace
}  // namespace pliant::results

int main(int argc, char** argv) {
    using namespace pliant::results;
    if (argc != 3) {
        std::fprintf(stderr, "results: expected a folder to write to and that of the scans\n");
        return 2;
    }
    const pliant::TaskArena arena;
    Page page{argv[1], "colours.md"};
    page.heading(1, "Colours of the endoscope, beside published figures");
    page.paragraph(
        "Quantities of the literature on endoscopic pictures, measured in Pliant's pictures "
        "([rendering.md](../../method/rendering.md), *Plain and real*).");
    page.origin("./dev results colours");
    add_published(page);
    add_colours(page, argv[2], arena);
    add_falloff(page, arena);
    if (const pliant::Status status = page.finish(); !status.ok()) {
        std::fprintf(stderr, "results: %s\n", status.error().message.c_str());
        return 1;
    }
}
