// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "mutate/formats.h"

#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <sstream>

#include "mutate/child.h"
#include "support/temporary_folder.h"

namespace pliant::mutate {

void give_up(const std::string& why) {
    std::fprintf(stderr, "mutate: %s\n", why.c_str());
    std::exit(2);
}

const std::vector<NamedFormat>& all_formats() {
    static const std::vector<NamedFormat> formats = {
        {"nrrd", nrrd},
        {"nhdr", nhdr},
        {"metaimage", metaimage},
        {"nifti", nifti},
        {"vtk_image", vtk_image},
        {"dicom", dicom},
        {"dicom_rle", dicom_rle},
        {"dicom_jpeg", dicom_jpeg},
        {"dicom_jpegls", dicom_jpegls},
        {"dicom_j2k", dicom_j2k},
        {"settings", settings},
        {"labels", labels},
        {"state", state},
        {"session", session},
        {"scene", scene},
        {"hand_log", hand_log},
        {"ends", ends},
        {"path", path},
        {"markups", markups},
        {"keyframes", keyframes},
        {"network", network},
        {"measured", measured},
        {"recording", recording},
        {"fit", fit},
        {"surface", surface},
        {"vtk", vtk},
        {"vtk_xml", vtk_xml},
        {"msh", msh},
        {"upload", upload},
    };
    return formats;
}

std::vector<std::string> words_of(const std::string& command) {
    std::istringstream stream(command);
    return {std::istream_iterator<std::string>(stream), {}};
}

std::string corpus_bytes(const std::filesystem::path& path) {
    if (!std::filesystem::is_regular_file(path))
        give_up(path.string() + ": expected a file, found none");
    return test::bytes_of(path);
}

Format upload(const Sources& sources) {
    Format all{.name = "upload", .words = {}, .seeds = {}, .is_uploaded = true};
    for (const auto make : {nrrd, nhdr, metaimage, nifti, vtk_image, dicom, dicom_rle, dicom_jpeg,
                            dicom_jpegls, dicom_j2k}) {
        const Format format = make(sources);
        for (Seed seed : format.seeds) {
            seed.damaged = [seed, words = format.words](Random& random) {
                return damaged_files(seed, words, random);
            };
            seed.name = format.name + " " + seed.name;
            seed.commands = {kUpload, kUploadFirstSeries};
            all.seeds.push_back(std::move(seed));
        }
    }
    all.seeds.push_back(two_series());
    all.seeds.back().commands = {kUploadFirstSeries, kUpload};
    return all;
}

Files made_by(const Sources& sources, const Files& given, const std::string& command,
              const std::vector<std::string>& names) {
    const test::TemporaryFolder folder;
    for (const File& file : given) folder.write(file.name, file.bytes);
    folder.write(".tmp/.here", "");
    const Limits limits{.memory = 0};
    const Ended run = run_child(sources.program, words_of(command), folder.path(), limits);
    if (run.status != 0) give_up("can't make a seed: pliant " + command + ": " + run.err);
    Files made;
    for (const std::string& name : names)
        made.push_back({.name = name, .bytes = corpus_bytes(folder / name)});
    return made;
}

std::string cube(const Sources& sources, const std::string& size) {
    return made_by(sources, {}, "phantom cube --raw --out c.nrrd --size " + size, {"c.nrrd"})
        .front()
        .bytes;
}

}  // namespace pliant::mutate
