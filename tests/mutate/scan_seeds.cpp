// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Seeds: scans in one file or two.

#include <numeric>

#include "mutate/formats.h"
#include "support/scan_files.h"

namespace pliant::mutate {
namespace {

using test::gzipped;
using test::MetaFile;
using test::NiftiFile;
using test::NrrdFile;
using test::packed;
using test::zlibbed;

const std::string kInfo = "info SCAN";
const std::string kDeform =
    "deform SCAN --push 11,21,31:1,0,0 --tool sphere:3 --threads 1 --out out.nrrd --report r.json";
const std::string kPicture = "render SCAN --size 16x16 --view axial --threads 1 --out out.png";

std::vector<std::string> commands_for(const std::string& scan) {
    std::vector<std::string> commands{kInfo + " --json", kInfo, kInfo + " --suggest-push", kDeform,
                                      kPicture};
    for (std::string& command : commands) command.replace(command.find("SCAN"), 4, scan);
    return commands;
}

/// 4 × 3 × 2 values as text.
std::string values_as_text() {
    std::string text;
    for (const std::int16_t value : test::small_values()) text += std::to_string(value) + " ";
    return text + "\n";
}

Seed single(const std::string& seed, const std::string& name, const std::string& bytes,
            std::size_t header) {
    return {.name = seed,
            .files = {{.name = name, .bytes = bytes, .header = header}},
            .commands = commands_for(name)};
}

Seed detached(const std::string& seed, const std::string& name, const std::string& header,
              const std::vector<std::string>& parts) {
    Seed made{
        .name = seed, .files = {{.name = name, .bytes = header}}, .commands = commands_for(name)};
    const std::string data = packed(test::small_values());
    const std::size_t size = data.size() / parts.size();
    for (std::size_t n = 0; n < parts.size(); ++n)
        made.files.push_back({.name = parts[n], .bytes = data.substr(n * size, size)});
    return made;
}

std::size_t header_of(const NrrdFile& file) {
    return file.bytes().size() - file.data.size();
}

std::size_t header_of(const MetaFile& file) {
    return file.bytes().size() - file.data.size();
}

const Words kNrrdWords = {"type: ",
                          "dimension: ",
                          "space: ",
                          "space dimension: ",
                          "sizes: ",
                          "space directions: ",
                          "space units: ",
                          "space origin: ",
                          "measurement frame: ",
                          "kinds: ",
                          "labels: ",
                          "units: ",
                          "spacings: ",
                          "thicknesses: ",
                          "axis mins: ",
                          "axis maxs: ",
                          "centers: ",
                          "endian: ",
                          "encoding: ",
                          "byte skip: ",
                          "line skip: ",
                          "data file: ",
                          "content: ",
                          "min: ",
                          "max: ",
                          "old min: ",
                          "number: ",
                          "block size: ",
                          "sample units: ",
                          "key:=",
                          "# ",
                          "NRRD0005\n",
                          "raw",
                          "gzip",
                          "ascii",
                          "hex",
                          "bzip2",
                          "block",
                          "double",
                          "float",
                          "uchar",
                          "ushort",
                          "int64",
                          "big",
                          "left-posterior-superior",
                          "right-anterior-superior-time",
                          "none",
                          "(1,0,0)",
                          "vector",
                          "LIST",
                          "data file: LIST 2\n",
                          "data file: x%d.raw 1 9 1\n",
                          "byte skip: -1\n",
                          "\n\n"};

const Words kMetaWords = {"ObjectType = ",
                          "ObjectSubType = ",
                          "NDims = ",
                          "Comment = ",
                          "Name = ",
                          "ID = ",
                          "ParentID = ",
                          "AcquisitionDate = ",
                          "Color = ",
                          "BinaryData = ",
                          "ElementByteOrderMSB = ",
                          "BinaryDataByteOrderMSB = ",
                          "CompressedData = ",
                          "CompressedDataSize = ",
                          "TransformMatrix = ",
                          "Rotation = ",
                          "Offset = ",
                          "Origin = ",
                          "Position = ",
                          "CenterOfRotation = ",
                          "AnatomicalOrientation = ",
                          "ElementSpacing = ",
                          "ElementSize = ",
                          "DimSize = ",
                          "HeaderSize = ",
                          "Modality = ",
                          "SequenceID = ",
                          "ElementMin = ",
                          "ElementMax = ",
                          "ElementNumberOfChannels = ",
                          "ElementType = ",
                          "ElementDataFile = ",
                          "MET_SHORT",
                          "MET_DOUBLE",
                          "MET_CHAR_ARRAY",
                          "MET_OTHER",
                          "True",
                          "False",
                          "LOCAL",
                          "LIST",
                          "LIST 3\n",
                          "x%d.raw 1 9 1",
                          "Image",
                          "MET_MOD_CT",
                          "RAI",
                          "???"};

}  // namespace

Format nrrd(const Sources&) {
    const NrrdFile raw;
    NrrdFile gzip{.encoding = "gzip"}, text{.endian = "", .encoding = "ascii"};
    NrrdFile bytes{.type = "uchar", .endian = ""};
    gzip.data = gzipped(raw.data);
    text.data = values_as_text();
    bytes.data = raw.data.substr(0, 24);
    return {.name = "nrrd",
            .words = kNrrdWords,
            .seeds = {single("raw", "a.nrrd", raw.bytes(), header_of(raw)),
                      single("gzip", "a.nrrd", gzip.bytes(), header_of(gzip)),
                      single("ascii", "a.nrrd", text.bytes(), header_of(text)),
                      single("bytes", "a.nrrd", bytes.bytes(), header_of(bytes))}};
}

Format nhdr(const Sources&) {
    NrrdFile one{.extra = "data file: a.raw\n", .data = "", .blank_line = false};
    NrrdFile list = one, pattern = one, zipped = one;
    list.extra = "data file: LIST\ns1.raw\ns2.raw\n";
    pattern.extra = "data file: s%d.raw 1 2 1\n";
    zipped.encoding = "gzip";
    zipped.extra = "data file: a.raw.gz\n";
    Seed gzip = detached("gzip", "a.nhdr", zipped.bytes(), {"a.raw.gz"});
    gzip.files.back().gzip = true;
    return {.name = "nhdr",
            .words = kNrrdWords,
            .seeds = {detached("detached", "a.nhdr", one.bytes(), {"a.raw"}),
                      detached("list", "a.nhdr", list.bytes(), {"s1.raw", "s2.raw"}),
                      detached("pattern", "a.nhdr", pattern.bytes(), {"s1.raw", "s2.raw"}),
                      std::move(gzip)}};
}

Format metaimage(const Sources&) {
    MetaFile raw, zipped, one, list;
    zipped.data = zlibbed(raw.data);
    zipped.extra =
        "CompressedData = True\nCompressedDataSize = " + std::to_string(zipped.data.size()) +
        "\nComment = a scan\n";
    one.data_file = "a.raw";
    list.data_file = "LIST\ns1.raw\ns2.raw";
    one.data = list.data = "";
    return {.name = "metaimage",
            .words = kMetaWords,
            .seeds = {single("raw", "a.mha", raw.bytes(), header_of(raw)),
                      single("zlib", "a.mha", zipped.bytes(), header_of(zipped)),
                      detached("detached", "a.mhd", one.bytes(), {"a.raw"}),
                      detached("list", "a.mhd", list.bytes(), {"s1.raw", "s2.raw"})}};
}

Format nifti(const Sources&) {
    const NiftiFile plain;
    NiftiFile scaled{.slope = 2, .intercept = -1000}, turned{.qform_code = 1, .sform_code = 0};
    turned.qform = {0, 0, 0.7071068F, 10, 20, 30};
    NiftiFile reals{.datatype = 16, .bitpix = 32};
    std::vector<float> values(24);
    std::iota(values.begin(), values.end(), -0.5F);
    reals.data = packed(values);
    Seed gzip = single("gzip", "a.nii.gz", scaled.bytes(), 352);
    gzip.files.front().gzip = true;
    return {.name = "nifti",
            .words = {"n+1", "ni1", std::string(4, '\0'), "\x5c\x01", "\x01\x5c"},
            .seeds = {single("plain", "a.nii", plain.bytes(), 352),
                      single("scaled", "a.nii", scaled.bytes(), 352),
                      single("quaternion", "a.nii", turned.bytes(), 352),
                      single("float", "a.nii", reals.bytes(), 352), std::move(gzip)}};
}

Format vtk_image(const Sources& from) {
    const auto seed = [&](const std::string& name, const std::string& file) {
        const std::string bytes = corpus_bytes(from.fuzz_corpus / "vtk" / name);
        return single(name, file, bytes, bytes.size() - 48);
    };
    return {.name = "vtk_image",
            .words = {"type=\"ImageData\"", "WholeExtent=\"0 3 0 2 0 1\"", "<Piece", "<DataArray",
                      "format=\"appended\"", "offset=\"0\"", "encoding=\"raw\"", "DIMENSIONS 4 3 2",
                      "SCALARS v short", "LOOKUP_TABLE default"},
            .seeds = {seed("appended_raw", "a.vti"), seed("appended_zlib", "a.vti"),
                      seed("inline_zlib", "a.vti"), seed("text", "a.vti"),
                      seed("points_text", "a.vtk"), seed("points_bytes", "a.vtk")}};
}

}  // namespace pliant::mutate
