// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "common_options.h"

#include <algorithm>
#include <charconv>
#include <cmath>

namespace pliant::app {

std::vector<double> parse_numbers(std::string_view text, char separator, std::size_t count,
                                  const std::string& option) {
    std::vector<double> numbers;
    const auto fail = [&] {
        throw CLI::ValidationError(option, "expected " + std::to_string(count) +
                                               " numbers separated by '" + separator +
                                               "', found '" + std::string(text) + "'");
    };
    const char* at = text.data();
    const char* const end = at + text.size();
    for (;;) {
        while (at != end && *at == ' ') ++at;
        if (at != end && *at == '+') ++at;
        double number = 0;
        const auto [next, error] = std::from_chars(at, end, number);
        if (error != std::errc{} || !std::isfinite(number)) fail();
        numbers.push_back(number);
        at = next;
        while (at != end && *at == ' ') ++at;
        if (at == end) break;
        if (*at++ != separator) fail();
    }
    if (numbers.size() != count) fail();
    return numbers;
}

Vec3d parse_vector(std::string_view text, const std::string& option) {
    const auto n = parse_numbers(text, ',', 3, option);
    return {n[0], n[1], n[2]};
}

CLI::Option* add_vector(CLI::App* command, const std::string& name, std::optional<Vec3d>& target,
                        const std::string& help) {
    return command
        ->add_option_function<std::string>(
            name, [&target, name](const std::string& text) { target = parse_vector(text, name); },
            help)
        ->type_name("X,Y,Z");
}

void add_scan(CLI::App* command, ScanChoice& scan, const std::string& spacing) {
    command->add_option("--series", scan.series,
                        "DICOM series, where a folder has several: its number, a part of its "
                        "description, or its UID");
    command
        ->add_option("--frame", scan.frame,
                     "image of a 4-D file, or volume of a DICOM file, from 0")
        ->check(CLI::Range(0, 65535));
    command->add_flag("--straighten", scan.straighten,
                      "resample tilted, sheared or unequally spaced slices to a regular grid");
    command
        ->add_option_function<std::string>(
            spacing,
            [&scan, spacing](const std::string& text) {
                const Vec3d mm = parse_vector(text, spacing);
                if (!(std::min({mm.x, mm.y, mm.z}) > 0))
                    throw CLI::ValidationError(spacing,
                                               "expected millimetres > 0, found '" + text + "'");
                scan.spacing_mm = mm;
            },
            "of DICOM slices without positions, stacked in the order of their numbers [mm]")
        ->type_name("X,Y,Z");
}

CLI::Option* add_units(CLI::App* command, std::string& units) {
    return command
        ->add_option("--units", units, "of lengths in a mesh's file: mm, cm or m (default mm)")
        ->check(CLI::IsMember({"mm", "cm", "m"}));
}

void add_body_labels(CLI::App* command, std::optional<std::vector<int>>& bodies) {
    // Without a value CLI11 calls with an empty text, which it would convert to 0.
    const auto take = [&bodies](const std::vector<std::string>& texts) {
        bodies.emplace();
        for (const std::string& text : texts) {
            if (text.empty()) continue;
            int label = 0;
            const auto [end, error] =
                std::from_chars(text.data(), text.data() + text.size(), label);
            if (error != std::errc() || end != text.data() + text.size() || label < 1)
                throw CLI::ValidationError("--bodies",
                                           "expected whole numbers above 0, found '" + text + "'");
            bodies->push_back(label);
        }
    };
    command
        ->add_option_function<std::vector<std::string>>(
            "--bodies", take,
            "make a body of each of these labels (without a number: of each organ of --labels); "
            "they slide on each other and on a body of what is around them (docs/howto/organs.md)")
        ->type_name("LABEL,…")
        ->delimiter(',')
        ->expected(0, 256);
}

void add_label_names(CLI::App* command, std::string& file) {
    command->add_option(
        "--label-names", file,
        "names of --labels: JSON, 3D Slicer's .ctbl, ITK-SNAP's label descriptions, "
        "or .csv lines of a value and a name (default: the label map's own, or "
        "such a file beside it with its name)");
}

void add_threads(CLI::App* command, int& threads) {
    command->add_option("--threads", threads, "threads to use; 0: all")->check(CLI::Range(0, 256));
}

void add_surface(CLI::App* command, std::optional<double>& iso,
                 std::optional<std::string>& polarity, const std::string& meaning) {
    command->add_option("--iso", iso, meaning + " (default: CT -500 HU, others by their values)");
    command
        ->add_option("--polarity", polarity,
                     "rising (air lumen) or falling (contrast lumen) (default: CT rising)")
        ->check(CLI::IsMember({"rising", "falling"}));
}

void add_window(CLI::App* command, std::optional<double>& window, std::optional<double>& level,
                const std::string& more_window, const std::string& more_level) {
    command
        ->add_option("--window", window,
                     "of the sections (default: that of DICOM; else CT 1500 HU" + more_window +
                         "; others by their values)")
        ->check(CLI::PositiveNumber);
    command->add_option("--level", level,
                        "of the sections (default: that of DICOM; else CT -200 HU" + more_level +
                            "; others by their values)");
}

void add_look(CLI::App* command, LookOptions& look) {
    command->add_option("--style", look.style, "plain (shape alone) or real (as endoscopes record)")
        ->check(CLI::IsMember({"plain", "real"}));
    command
        ->add_option("--lining", look.lining,
                     "style real: auto (by the polarity), airway, colon, sinus or vessel")
        ->check(CLI::IsMember({"auto", "airway", "colon", "sinus", "vessel"}));
    command
        ->add_option("--field", look.field_stop,
                     "style real, fluoroscopy: round, octagon or full picture")
        ->check(CLI::IsMember({"round", "octagon", "full"}));
}

void add_picture(CLI::App* command, PictureOptions& picture, const std::string& look) {
    command->add_option("--png", picture.png, "before and after, four views each");
    add_vector(command, "--eye", picture.eye_mm,
               "of the picture's endoscope (default: chosen in the lumen)");
    add_vector(command, "--look", picture.look,
               "of the picture's endoscope (default: " + look + ")");
    add_surface(command, picture.iso_hu, picture.polarity, "threshold of the picture's surface");
    add_window(command, picture.window_hu, picture.level_hu);
    add_look(command, picture.look_of);
}

}  // namespace pliant::app
