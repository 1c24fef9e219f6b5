// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "formats/recorded_files.h"

namespace pliant::test {
namespace {

class MadeMeta {
  public:
    template <class Change>
    void add(const std::string& name, const Change& change,
             std::vector<std::pair<std::string, std::string>> beside = {}) {
        MetaFile file;
        change(file);
        const bool is_local = file.data_file.size() == 5;
        if (!is_local) file.data = "";
        beside.insert(beside.begin(), {is_local ? "scan.mha" : "scan.mhd", file.bytes()});
        m_scans.push_back({"meta " + name, std::move(beside)});
    }
    /// A header that is not made of a good file's fields.
    void add_lines(const std::string& name, const std::string& lines) {
        m_scans.push_back({"meta " + name,
                           {{"scan.mha", lines +
                                             "ElementType = MET_SHORT\n"
                                             "ElementDataFile = LOCAL\n" +
                                             packed(small_values())}}});
    }
    MadeScans take() { return std::move(m_scans); }

  private:
    MadeScans m_scans;
};

void add_meta_types(MadeMeta& made) {
    for (const NumberType& type : number_types()) {
        for (const std::string& alias : type.meta)
            made.add(type.name + std::string(" / ") + alias,
                     [&](MetaFile& f) { f.type = alias, f.data = type.data; });
        const std::string &name = type.meta[0], row = type.name + std::string(" / ");
        for (const char* flag : {"ElementByteOrderMSB = True\n", "ElementByteOrderMSB = true\n"})
            made.add(row + flag,
                     [&](MetaFile& f) { f.type = name, f.extra = flag, f.data = big(type); });
        made.add(row + "zlib", [&](MetaFile& f) {
            f.type = name, f.data = zlibbed(type.data);
            f.extra =
                "CompressedData = True\nCompressedDataSize = " + std::to_string(f.data.size()) +
                "\n";
        });
        made.add(row + "zlib big", [&](MetaFile& f) {
            f.type = name, f.data = zlibbed(big(type));
            f.extra = "CompressedData = True\nElementByteOrderMSB = True\nCompressedDataSize = " +
                      std::to_string(f.data.size()) + "\n";
        });
    }
    for (const char* type :
         {"MET_SHORT_ARRAY", "MET_ASCII_CHAR", "MET_STRING", "met_short", "short"})
        made.add(std::string("type ") + type, [&](MetaFile& f) { f.type = type; });
    made.add("gzip", [](MetaFile& f) {
        f.data = gzipped(f.data),
        f.extra =
            "CompressedData = True\nCompressedDataSize = " + std::to_string(f.data.size()) + "\n";
    });
}

MadeScans text_scans() {
    MadeScans scans;
    for (const NumberType& type : number_types())
        scans.push_back({"meta text " + std::string(type.name),
                         {{"scan.mha",
                           "ObjectType = Image\nNDims = 3\nBinaryData = False\nDimSize = 4 3 2\n"
                           "ElementSpacing = 1 2 3\nElementType = " +
                               type.meta[0] + "\nElementDataFile = LOCAL\n" + type.text}}});
    scans.push_back(
        {"meta text beside",
         {{"scan.mhd",
           "NDims = 3\nBinaryData = 0\nDimSize = 4 3 2\nElementType = "
           "MET_SHORT\nElementDataFile = a.txt\n"},
          {"a.txt", "1 2 3 4 5 6 7 8 9 10 11 12\n-1 -2 -3 -4 -5 -6 -7 -8 -9 1e1 11 12"}}});
    return scans;
}

MadeScans big_scans() {
    MadeScans scans;
    for (const NumberType& type : number_types())
        for (const char* flag : {"True", "true", "1", "False", "yes"})
            scans.push_back(
                {"meta MSB " + std::string(type.name) + " / " + flag,
                 {{"scan.mha", "ObjectType = Image\nNDims = 3\nBinaryDataByteOrderMSB = " +
                                   std::string(flag) + "\nDimSize = 4 3 2\nElementType = " +
                                   type.meta[0] + "\nElementDataFile = LOCAL\n" + big(type)}}});
    return scans;
}

void add_meta_places(MadeMeta& made) {
    const std::string data = packed(small_values());
    const std::string half1 = data.substr(0, 24), half2 = data.substr(24);
    const std::vector<std::pair<std::string, std::string>> halves = {{"s1.raw", half1},
                                                                     {"s2.raw", half2}};
    const auto beside = [&](const std::string& name, const std::string& place,
                            const std::string& extra,
                            std::vector<std::pair<std::string, std::string>> files) {
        made.add(
            "place " + name, [&](MetaFile& f) { f.data_file = place, f.extra = extra; },
            std::move(files));
    };
    for (const char* local : {"LOCAL", "Local", "local"})
        made.add(std::string("place ") + local, [&](MetaFile& f) { f.data_file = local; });
    beside("one", "data.raw", "", {{"data.raw", data}});
    beside("folder", "sub/data.raw", "", {{"sub/data.raw", data}});
    beside("blank", "da ta.raw", "", {{"da ta.raw", data}});
    beside("skip", "data.raw", "HeaderSize = 3\n", {{"data.raw", "abc" + data}});
    beside("end", "data.raw", "HeaderSize = -1\n", {{"data.raw", "abcd" + data}});
    beside("zlib", "data.zraw", "CompressedData = True\n", {{"data.zraw", zlibbed(data)}});
    beside("list", "LIST\ns1.raw\ns2.raw", "", halves);
    beside("list 2D", "LIST 2D\ns1.raw\ns2.raw", "", halves);
    beside("list 2", "LIST 2\ns1.raw\ns2.raw", "", halves);
    beside("list skip", "LIST\ns1.raw\ns2.raw", "HeaderSize = 1\n",
           {{"s1.raw", "a" + half1}, {"s2.raw", "b" + half2}});
    beside("list blanks", "LIST\ns1.raw  \ns2.raw\r", "", halves);
    beside("list zlib", "LIST\ns1.raw\ns2.raw", "CompressedData = True\n",
           {{"s1.raw", zlibbed(half1)}, {"s2.raw", zlibbed(half2)}});
    beside("pattern", "s%d.raw 1 2 1", "", halves);
    beside("pattern step", "s%02d.raw 3 7 4", "", {{"s03.raw", half1}, {"s07.raw", half2}});
    beside("pattern without step", "s%d.raw 1 2", "", halves);
    made.add("place HeaderSize in local", [&](MetaFile& f) {
        f.extra = "HeaderSize = 250\n";
        const std::size_t header = f.bytes().size() - f.data.size();
        f.data = std::string(250 > header ? 250 - header : 0, 'x') + data;
    });
    made.add("place end of local",
             [&](MetaFile& f) { f.extra = "HeaderSize = -1\n", f.data = "abc" + data; });
}

void add_meta_geometry(MadeMeta& made) {
    const auto with = [&](const std::string& name, const std::string& extra) {
        made.add("geometry " + name, [&](MetaFile& f) {
            f.spacing = f.offset = f.matrix = "";
            f.extra = extra;
        });
    };
    with("none", "");
    with("ElementSize", "ElementSize = 1 2 3.5\n");
    with("both sizes", "ElementSize = 1 2 3.5\nElementSpacing = 0.1 0.2 0.3\n");
    with("both sizes other way", "ElementSpacing = 0.1 0.2 0.3\nElementSize = 1 2 3.5\n");
    with("Position", "Position = 1 2 3\n");
    with("Origin", "Origin = 1 2 3\n");
    with("ImagePosition", "ImagePosition = 1 2 3\n");
    with("Offset and Position", "Offset = 1 2 3\nPosition = 4 5 6\n");
    with("Position and Origin", "Origin = 1 2 3\nPosition = 4 5 6\n");
    with("Offset and Origin", "Origin = 1 2 3\nOffset = 4 5 6\n");
    with("Offset and ImagePosition", "ImagePosition = 1 2 3\nOffset = 4 5 6\n");
    const char* turned = " = 0 1 0 0 0 -1 -1 0 0\n";
    const char* other = " = 0.6 0 0.8 0 1 0 -0.8 0 0.6\n";
    for (const char* name : {"TransformMatrix", "Rotation", "Orientation"}) {
        with(name, name + std::string(turned));
        with(std::string(name) + " oblique", name + std::string(other));
    }
    with("matrix and rotation", std::string("TransformMatrix") + turned + "Rotation" + other);
    with("rotation and matrix", std::string("Rotation") + other + "TransformMatrix" + turned);
    with("rotation and orientation", std::string("Rotation") + turned + "Orientation" + other);
    with("long axes", "TransformMatrix = 2 0 0 0 3 0 0 0 0.1\n");
    with("inexact axes",
         "TransformMatrix = 0.57735 0.57735 0.57735 0.70711 -0.70711 0 0.40825 "
         "0.40825 -0.8165\n");
    with("slightly skew", "TransformMatrix = 1 0.0004 0 0 1 0.0004 0 0 1\n");
    with("exponents", "ElementSpacing = 1e-1 2.5E0 +3\nOffset = -1e2 .5 1e-3\n");
    with("tabs", "ElementSpacing =\t1\t2\t3\nOffset\t=\t1 2  3 \n");
    for (const char* anatomy : {"RAI", "LPS", "RAS", "???", "nonsense"})
        with(std::string("anatomy ") + anatomy,
             std::string("AnatomicalOrientation = ") + anatomy + "\n");
    with("centre of rotation", "CenterOfRotation = 1 2 3\n");
    for (const char* unit : {"mm", "um", "cm", "?"})
        with(std::string("units ") + unit, std::string("DistanceUnits = ") + unit + "\n");
}

void add_meta_fields(MadeMeta& made) {
    const char* lines[] = {"Comment = a comment\n",
                           "Name = a name\n",
                           "ObjectSubType = Sub\n",
                           "TransformType = Rigid\n",
                           "ID = 1\nParentID = 2\n",
                           "Color = 1 0 0 1\n",
                           "AcquisitionDate = 2020.01.01\n",
                           "Modality = MET_MOD_CT\n",
                           "Modality = MET_MOD_MR\n",
                           "SequenceID = 1 2 3\n",
                           "ElementMin = -100\nElementMax = 5\n",
                           "ElementNBits = 16\n",
                           "ElementNumberOfChannels = 1\n",
                           "ElementToIntensityFunctionSlope = 2\n",
                           "ElementToIntensityFunctionOffset = 2\n",
                           "ElementToIntensityFunctionSlope = 1\n"
                           "ElementToIntensityFunctionOffset = 0\n",
                           "FileFormatVersion = 1\n",
                           "b = 2\na = 1\n",
                           "my key = my value  \n",
                           "my key: my value\n",
                           "my key := my value\n",
                           "my key == = my value = x: y\n",
                           "my key = first\nmy key = second\n",
                           "ITK_x = 1\nNRRD_y = 2\nz = 3\n",
                           "ndims = 7\n",
                           "Key = \xc3\xa4\xff\x01\n"};
    for (const char* each : lines)
        made.add(std::string("field ") + each, [&](MetaFile& f) { f.extra = each; });
    made.add("field long", [](MetaFile& f) {
        f.extra = "Comment = " + std::string(254, 'c') + "\nkey = " + std::string(480, 'v') + "\n";
    });
}

}  // namespace

MadeScans meta_scans() {
    MadeMeta made;
    add_meta_types(made);
    add_meta_places(made);
    add_meta_geometry(made);
    add_meta_fields(made);
    made.add_lines("least", "NDims = 3\nDimSize = 4 3 2\n");
    made.add_lines("colons", "ObjectType: Image\nNDims: 3\nDimSize: 4 3 2\n");
    made.add_lines("without blanks", "ObjectType=Image\nNDims=3\nDimSize=4 3 2\n");
    made.add_lines("CRLF", "ObjectType = Image\r\nNDims = 3\r\nDimSize = 4 3 2\r\nkey = v \r\n");
    made.add_lines("empty lines", "\nObjectType = Image\n\nNDims = 3\n  DimSize = 4 3 2\n\n");
    made.add_lines("DimSize first", "DimSize = 4 3 2\nNDims = 3\n");
    MadeScans scans = made.take();
    for (MadeScan& scan : text_scans()) scans.push_back(std::move(scan));
    for (MadeScan& scan : big_scans()) scans.push_back(std::move(scan));
    return scans;
}

}  // namespace pliant::test
