// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "formats/recorded_files.h"

namespace pliant::test {
namespace {

/// Collects variants of a valid file.
class MadeNrrd {
  public:
    template <class Change>
    void add(const std::string& name, const Change& change,
             std::vector<std::pair<std::string, std::string>> beside = {}, bool is_field = false) {
        NrrdFile file;
        change(file);
        const char* ending = file.blank_line ? ".nrrd" : ".nhdr";
        beside.insert(beside.begin(), {"scan" + std::string(ending), file.bytes()});
        m_scans.push_back({"nrrd " + name, std::move(beside), is_field});
    }
    MadeScans take() { return std::move(m_scans); }

  private:
    MadeScans m_scans;
};

void add_nrrd_types(MadeNrrd& made) {
    for (const NumberType& type : number_types()) {
        for (const std::string& alias : type.nrrd)
            made.add("types / " + alias, [&](NrrdFile& f) { f.type = alias, f.data = type.data; });
        const std::string name = std::string(type.name) + " / ";
        made.add(name + "big",
                 [&](NrrdFile& f) { f.type = type.nrrd[0], f.endian = "big", f.data = big(type); });
        made.add(name + "gzip", [&](NrrdFile& f) {
            f.type = type.nrrd[0], f.encoding = "gz", f.data = gzipped(type.data);
        });
        made.add(name + "gzip big", [&](NrrdFile& f) {
            f.type = type.nrrd[0], f.encoding = "gzip", f.endian = "big";
            f.data = gzipped(big(type));
        });
        for (const char* encoding : {"ascii", "text", "txt"})
            made.add(name + encoding, [&](NrrdFile& f) {
                f.type = type.nrrd[0], f.encoding = encoding, f.endian = "", f.data = type.text;
            });
    }
    made.add("zlib", [](NrrdFile& f) { f.encoding = "gzip", f.data = zlibbed(f.data); });
    made.add("chain", [](NrrdFile& f) {
        f.encoding = "gzip", f.data = gzipped(f.data.substr(0, 20)) + gzipped(f.data.substr(20));
    });
    made.add("long data", [](NrrdFile& f) { f.data += "more"; });
    made.add("text with commas", [](NrrdFile& f) {
        f.encoding = "text";
        f.data = "1, 2,\t3 4 5\r\n+6 7 8 9 10 11 12 13 14 15 16 17 18 19 20 21 22 23 -24 25 26";
    });
    made.add("1 byte without endian", [](NrrdFile& f) {
        f.type = "uchar", f.endian = "", f.data = std::string(24, '\x81');
    });
}

void add_nrrd_places(MadeNrrd& made) {
    const std::string data = packed(small_values());
    const auto beside = [&](const std::string& name, const std::string& lines,
                            std::vector<std::pair<std::string, std::string>> files,
                            const std::string& encoding = "raw") {
        made.add(
            "place " + name,
            [&](NrrdFile& f) { f.blank_line = false, f.encoding = encoding, f.extra = lines; },
            std::move(files));
    };
    beside("one", "data file: a.raw\n", {{"a.raw", data}});
    beside("alias", "datafile: a.raw\n", {{"a.raw", data}});
    beside("capitals", "Data File: a.raw\n", {{"a.raw", data}});
    beside("folder", "data file: sub/a.raw\n", {{"sub/a.raw", data}});
    beside("dot", "data file: ./a.raw\n", {{"a.raw", data}});
    beside("lines", "line skip: 2\ndata file: a.raw\n", {{"a.raw", "1\n22\n" + data}});
    beside("bytes", "byte skip: 3\ndata file: a.raw\n", {{"a.raw", "abc" + data}});
    beside("both", "lineskip: 1\nbyteskip: 2\ndata file: a.raw\n", {{"a.raw", "x\nab" + data}});
    beside("end", "byte skip: -1\ndata file: a.raw\n", {{"a.raw", "abcde" + data}});
    beside("gzip", "byte skip: 3\ndata file: a.gz\n", {{"a.gz", gzipped("abc" + data)}}, "gzip");
    beside("gzip lines", "line skip: 1\nbyte skip: 3\ndata file: a.gz\n",
           {{"a.gz", "head\n" + gzipped("abc" + data)}}, "gzip");
    beside("text", "line skip: 1\nbyte skip: 2\ndata file: a.txt\n",
           {{"a.txt", "head\nxx1 2 3 4 5 6 7 8 9 10 11 12 1 2 3 4 5 6 7 8 9 10 11 12"}}, "text");
    const std::string half1 = data.substr(0, 24), half2 = data.substr(24);
    const std::vector<std::pair<std::string, std::string>> halves = {{"s1.raw", half1},
                                                                     {"s2.raw", half2}};
    beside("list", "data file: LIST\ns1.raw\ns2.raw\n", halves);
    beside("list 2", "data file: LIST 2\ns1.raw\ns2.raw\n", halves);
    beside("list 3", "data file: LIST 3\ns1.raw\ns2.raw\n", halves);
    beside("list gzip", "data file: LIST\ns1.raw\ns2.raw\n",
           {{"s1.raw", gzipped(half1)}, {"s2.raw", gzipped(half2)}}, "gzip");
    beside("list skip", "byte skip: 1\ndata file: LIST\ns1.raw\ns2.raw\n",
           {{"s1.raw", "a" + half1}, {"s2.raw", "b" + half2}});
    beside("list end", "byte skip: -1\ndata file: LIST\ns1.raw\ns2.raw\n",
           {{"s1.raw", "a" + half1}, {"s2.raw", "bb" + half2}});
    beside("pattern", "data file: s%d.raw 1 2 1\n", halves);
    beside("pattern 2", "data file: s%d.raw 1 2 1 2\n", halves);
    beside("pattern 3", "data file: s%d.raw 1 2 1 3\n", halves);
    beside("pattern back", "data file: s%d.raw 2 1 -1\n", halves);
    beside("pattern zeros", "data file: s%03d.raw 5 10 5\n",
           {{"s005.raw", half1}, {"s010.raw", half2}});
    beside("pattern negative", "data file: s%d.raw -1 0 1\n",
           {{"s-1.raw", half1}, {"s0.raw", half2}});
    std::vector<std::pair<std::string, std::string>> rows;
    std::string list = "data file: LIST 1\n";
    for (int n = 0; n < 6; ++n) {
        rows.emplace_back("r" + std::to_string(n), data.substr(std::size_t(8 * n), 8));
        list += "r" + std::to_string(n) + "\n";
    }
    beside("rows", list, rows);
    made.add("place attached lines", [&](NrrdFile& f) {
        f.extra = "line skip: 1\nbyte skip: 2\n", f.data = "first\nab" + data;
    });
    made.add("place attached end",
             [&](NrrdFile& f) { f.extra = "byte skip: -1\n", f.data = "ab" + data; });
}

void add_nrrd_spaces(MadeNrrd& made) {
    const char* spaces[] = {"right-anterior-superior",
                            "right anterior superior",
                            "rightanteriorsuperior",
                            "RAS",
                            "ras",
                            "left-anterior-superior",
                            "left anterior superior",
                            "leftanteriorsuperior",
                            "LAS",
                            "left-posterior-superior",
                            "left posterior superior",
                            "leftposteriorsuperior",
                            "LPS",
                            "Left-Posterior-Superior",
                            "scanner-xyz",
                            "3D-right-handed",
                            "3D right handed",
                            "3Drighthanded",
                            "3D-left-handed",
                            "3D left handed",
                            "3Dlefthanded"};
    for (const char* space : spaces)
        for (const bool oblique : {false, true})
            made.add(std::string("space ") + space + (oblique ? " oblique" : ""), [&](NrrdFile& f) {
                f.space = space;
                if (!oblique) return;
                f.directions = "(0.4,0,-0.3) (0.1439,1.1,0.19187) (0.66,-0.4,0.88)";
                f.directions = "(0.6,0,-0.8) (0,1.5,0) (1.6,0,1.2)";
                f.origin = "(-12.3456789012345,1e-7,321.5)";
            });
    made.add("space dimension", [](NrrdFile& f) { f.space = "", f.extra = ""; });
    made.add("space of three", [](NrrdFile& f) {
        f.space = f.directions = f.origin = "";
        f.extra =
            "space dimension: 3\nspace directions: (1,0,0) (0,2,0) (0,0,3)\n"
            "space origin: (4,5,6)\n";
    });
    made.add("no origin", [](NrrdFile& f) { f.origin = ""; });
    made.add("blanks in vectors", [](NrrdFile& f) {
        f.directions = "( 1, 0 ,0)  (0, 1.25, 0)\t(0,0, 2e0 )", f.origin = "( 1, 2.5, -3 )";
    });
    made.add("left-handed", [](NrrdFile& f) { f.directions = "(-1,0,0) (0,1,0) (0,0,2)"; });
    made.add("signs", [](NrrdFile& f) { f.directions = "(+1,-0,0) (0,+1.5,0) (-0.0,0,.5)"; });
    made.add("permuted", [](NrrdFile& f) { f.directions = "(0,0,-0.7) (0.3,0,0) (0,1.1,0)"; });
    made.add("slightly skew",
             [](NrrdFile& f) { f.directions = "(1,0.0005,0) (0,1,0.0003) (0,0,2)"; });
    const char* units[] = {"\"mm\" \"mm\" \"mm\"",
                           "\"um\" \"um\" \"um\"",
                           "\"cm\" \"cm\" \"cm\"",
                           "\"m\" \"m\" \"m\"",
                           "\"MM\" \"MM\" \"MM\"",
                           "\"microns\" \"microns\" \"microns\"",
                           "\"millimeter\" \"millimeter\" \"millimeter\"",
                           "\"\" \"\" \"\"",
                           "\"???\" \"???\" \"???\"",
                           "\"mm\"  \"mm\" \"mm\" ",
                           "\"mm\" \"cm\" \"mm\"",
                           "\"parsec\" \"parsec\" \"parsec\"",
                           "\"mm\" \"mm\""};
    for (const char* unit : units)
        made.add(std::string("space units ") + unit,
                 [&](NrrdFile& f) { f.extra = std::string("space units: ") + unit + "\n"; });
    made.add("RAS in cm", [](NrrdFile& f) {
        f.space = "RAS", f.extra = "space units: \"cm\" \"cm\" \"cm\"\n";
        f.directions = "(0.1,0,0) (0,-0.3,0) (0,0,0.7)", f.origin = "(0.1,0.2,0.3)";
    });
    for (const char* lines :
         {"", "spacings: 1 2 3\n", "spacings: 0.1 0.7 1e-1\n",
          "spacings: 1 2 3\naxis mins: 4 5 6\n", "spacings: 1 2 3\nunits: \"mm\" \"mm\" \"mm\"\n",
          "spacings: 1 2 3\ncenters: cell cell cell\naxismins: 4 5 6\n",
          "spacings: 1 2 3\nthicknesses: 1 2 3\nlabels: \"x\" \"y \\\" :\" \"z\"\n",
          "axis mins: 0 0 0\naxis maxs: 4 6 4\n"})
        made.add(std::string("unplaced ") + lines,
                 [&](NrrdFile& f) { f.space = f.directions = f.origin = "", f.extra = lines; });
}

void add_nrrd_fields(MadeNrrd& made) {
    const char* lines[] = {"centerings: cell cell cell\n",
                           "centers: node node node\n",
                           "centerings: cell ??? none\n",
                           "thicknesses: nan 1 2\n",
                           "labels: \"a\" \"b\" \"c\"\n",
                           "content: of any kind: with := in it\n",
                           "number: 24\n",
                           "min: -100\nmax: -77\n",
                           "old min: 0.5\noldmax: 1e3\n",
                           "sample units: Hounsfield\n",
                           "measurement frame: (1,0,0) (0,1,0) (0,0,1)\n",
                           "measurement frame: (0,1,0) (-1,0,0) (0,0,1)\n",
                           "#another comment\n# and: one := more\n",
                           "block size: 0\n"};
    for (const char* each : lines)
        made.add(std::string("field ") + each, [&](NrrdFile& f) { f.extra = each; });
    for (const char* kinds :
         {"", "space space space", "domain space domain", "Domain DOMAIN domain", "??? ??? ???",
          "none none none", "domain domain time"})
        made.add(std::string("kinds ") + kinds, [&](NrrdFile& f) { f.kinds = kinds; });
    made.add("order of fields", [](NrrdFile& f) {
        f.type = f.dimension = f.space = f.sizes = f.directions = f.kinds = f.endian = "";
        f.encoding = f.origin = "";
        f.extra =
            "endian: little\nencoding: raw\ndimension: 3\nkinds: domain domain domain\n"
            "sizes: 4 3 2\ntype: short\nspace: LPS\nspace origin: (1,2,3)\n"
            "space directions: (1,0,0) (0,2,0) (0,0,3)\n";
    });
    made.add("capitals", [](NrrdFile& f) {
        f.type = f.dimension = f.space = f.sizes = f.directions = f.kinds = f.endian = "";
        f.encoding = f.origin = "";
        f.extra =
            "TYPE: SHORT\nDimension: 3\nSizes: 4 3 2\nEndian: LITTLE\nEncoding: RAW\n"
            "Space: LPS\nSpaceDirections: (1,0,0) (0,2,0) (0,0,3)\n";
    });
    for (const char* magic : {"NRRD0001", "NRRD0002", "NRRD0003", "NRRD0005", "NRRD00.01"}) {
        const std::string bytes = NrrdFile().bytes();
        made.add(std::string("magic ") + magic, [](NrrdFile&) {});
        (void)bytes;
    }
}

void add_nrrd_components(MadeNrrd& made) {
    // One number a voxel, with an axis for it.
    for (const char* kind : {"scalar", "stub", "list", "vector", "???"})
        for (int at = 0; at < 4; ++at)
            made.add("one " + std::string(kind) + " / " + std::to_string(at), [&](NrrdFile& f) {
                std::vector<std::string> sizes = {"4", "3", "2"},
                                         kinds = {"domain", "domain", "domain"},
                                         axes = {"(1,0,0)", "(0,1,0)", "(0,0,2)"};
                sizes.insert(sizes.begin() + at, "1");
                kinds.insert(kinds.begin() + at, kind);
                axes.insert(axes.begin() + at, "none");
                const auto joined = [](const std::vector<std::string>& words) {
                    return words[0] + " " + words[1] + " " + words[2] + " " + words[3];
                };
                f.dimension = "4";
                f.sizes = joined(sizes), f.kinds = joined(kinds), f.directions = joined(axes);
            });
    // Fields.
    std::vector<float> narrow;
    std::vector<double> wide;
    std::string text;
    for (int n = 0; n < 72; ++n) {
        narrow.push_back(float(n) * 0.37F - 5);
        wide.push_back(n * 0.37 - 5);
        text += std::to_string(n) + ".25" + (n % 6 == 5 ? "\n" : " ");
    }
    const char* shapes[][3] = {
        {"3 4 3 2", "vector domain domain domain", "none (1,0,0) (0,1,0) (0,0,2)"},
        {"4 3 3 2", "domain vector domain domain", "(1,0,0) none (0,1,0) (0,0,2)"},
        {"4 3 3 2", "domain domain vector domain", "(1,0,0) (0,1,0) none (0,0,2)"},
        {"4 3 2 3", "domain domain domain vector", "(1,0,0) (0,1,0) (0,0,2) none"}};
    for (int at = 0; at < 4; ++at)
        for (const char* space : {"LPS", "RAS", "LAS", "scanner-xyz"})
            for (const char* type : {"float", "double"})
                for (const char* encoding : {"raw", "gzip", "ascii"})
                    for (const char* endian : {"little", "big"})
                        made.add(
                            "field at " + std::to_string(at) + " " + space + " / " + type + " " +
                                encoding + " " + endian,
                            [&](NrrdFile& f) {
                                const bool is_float = type == std::string("float");
                                f.dimension = "4", f.sizes = shapes[at][0];
                                f.kinds = shapes[at][1], f.directions = shapes[at][2];
                                f.space = space, f.type = type, f.encoding = encoding;
                                f.endian = endian;
                                f.data = is_float ? packed(narrow) : packed(wide);
                                if (f.endian == "big") f.data = swapped(f.data, is_float ? 4 : 8);
                                if (f.encoding == "gzip") f.data = gzipped(f.data);
                                if (f.encoding == "ascii") f.data = text;
                            },
                            {}, true);
    for (const char* kind : {"vector",
                             "contravariant-vector",
                             "covariant-vector",
                             "normal",
                             "point",
                             "list",
                             "3-vector",
                             "3-gradient",
                             "3-normal",
                             "3-color",
                             "RGB-color",
                             "RGB",
                             "HSV-color",
                             "XYZ-color",
                             "2D-symmetric-matrix",
                             "quaternion",
                             "4-vector",
                             "domain",
                             "space",
                             "???"})
        made.add(
            std::string("field of ") + kind,
            [&](NrrdFile& f) {
                f.dimension = "4", f.sizes = "3 4 3 2", f.type = "float";
                f.kinds = std::string(kind) + " domain domain domain";
                f.directions = "none (1,0,0) (0,1,0) (0,0,2)", f.data = packed(narrow);
                f.extra = "displacement field type:=modeling\n";
            },
            {}, true);
}

}  // namespace

MadeScans nrrd_scans() {
    MadeNrrd made;
    add_nrrd_types(made);
    add_nrrd_places(made);
    add_nrrd_spaces(made);
    add_nrrd_fields(made);
    add_nrrd_components(made);
    MadeScans scans = made.take();
    for (const char* magic : {"NRRD0001", "NRRD0002", "NRRD0003", "NRRD0005", "NRRD00.01"}) {
        std::string bytes = NrrdFile().bytes();
        bytes.replace(0, 8, magic);
        scans.push_back({std::string("nrrd version ") + magic, {{"scan.nrrd", bytes}}});
    }
    std::string carriage;
    for (const char c : NrrdFile().bytes().substr(0, NrrdFile().bytes().find("\n\n")))
        carriage += c == '\n' ? std::string("\r\n") : std::string(1, c);
    scans.push_back(
        {"nrrd CRLF", {{"scan.nrrd", carriage + "\r\nkey:=value \r\n\r\n" + NrrdFile().data}}});
    return scans;
}

MadeScans nrrd_key_scans() {
    MadeNrrd made;
    const char* keys[] = {"b:=2\na:=1\n",
                          "key:=value\n",
                          "key:=\n",
                          "key:= value with blanks \n",
                          "key with blanks:=v\n",
                          "key: of two:=v\n",
                          "key:=a: b := c\n",
                          "key:=first\nother:=1\nkey:=second\n",
                          "key:=two\\nlines and \\\\ and \\t\n",
                          "ITK_x:=1\nNRRD_y:=2\nz:=3\n",
                          "type:=not the field\n",
                          "key:=\xc3\xa4\xff\x01\n",
                          ":=no key\n",
                          "key:=#no comment\n"};
    for (const char* each : keys)
        made.add(std::string("keys ") + each, [&](NrrdFile& f) { f.extra = each; });
    made.add("keys of Slicer", [](NrrdFile& f) {
        for (int n = 0; n < 40; ++n)
            f.extra += "Segment" + std::to_string(n) + "_Name:=" + std::string(300, 'n') + "\n";
    });
    return made.take();
}

}  // namespace pliant::test
