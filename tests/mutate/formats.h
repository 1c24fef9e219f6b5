// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// All formats that the program reads, and the inputs of their seeds.

#pragma once

#include <string>
#include <vector>

#include "mutate/input.h"

namespace pliant::mutate {

struct NamedFormat {
    const char* name;
    Format (*make)(const Sources&);
};
const std::vector<NamedFormat>& all_formats();

// scan_seeds.cpp
Format nrrd(const Sources&);
Format nhdr(const Sources&);
Format metaimage(const Sources&);
Format nifti(const Sources&);
Format vtk_image(const Sources&);
// dicom_seeds.cpp
Format dicom(const Sources&);
Format dicom_rle(const Sources&);
Format dicom_jpeg(const Sources&);
Format dicom_jpegls(const Sources&);
Format dicom_j2k(const Sources&);
Seed two_series();  ///< in one folder; its command lines refuse it
// tissue_seeds.cpp
Format settings(const Sources&);
Format labels(const Sources&);
Format state(const Sources&);
// session_seeds.cpp
Format session(const Sources&);
// vessel_seeds.cpp
Format scene(const Sources&);
Format hand_log(const Sources&);
Format ends(const Sources&);  ///< of a closed surface
Format path(const Sources&);
Files vessel_files();  ///< a scene in "s.toml", and its centreline
// text_seeds.cpp
Format markups(const Sources&);
Format keyframes(const Sources&);
Format network(const Sources&);
Format measured(const Sources&);
Format recording(const Sources&);
Format fit(const Sources&);
// mesh_seeds.cpp
Format surface(const Sources&);
Format vtk(const Sources&);
Format vtk_xml(const Sources&);
Format msh(const Sources&);
// formats.cpp
Format upload(const Sources&);  ///< the scans above

/// Ends this program with status 2.
[[noreturn]] void give_up(const std::string& why);
/// A file of a corpus. Ends this program where it is missing.
std::string corpus_bytes(const std::filesystem::path& path);
/// Runs the program in a new folder with some files in it. Ends this program unless it succeeds.
/// @returns the named files that it wrote
Files made_by(const Sources& sources, const Files& given, const std::string& command,
              const std::vector<std::string>& names);
/// A small phantom, uncompressed.
std::string cube(const Sources& sources, const std::string& size);

std::vector<std::string> words_of(const std::string& command);

}  // namespace pliant::mutate
