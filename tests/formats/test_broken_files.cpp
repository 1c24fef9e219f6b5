// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Files that can't be read: each gives one line that names it, and nothing else is printed.
// Covers: formats/data_check.cpp, formats/header_lines.cpp, formats/image_header.cpp.

#include "support/scan_files.h"
#include "support/temporary_folder.h"

#include <pliant/scan_files.h>
#include <pliant/volume.h>

#include <gtest/gtest.h>
#include <unistd.h>

#include <functional>
#include <limits>

namespace pliant {
namespace {

using test::gzipped;
using test::MetaFile;
using test::NiftiFile;
using test::NrrdFile;
using test::zlibbed;

void expect_one_line(const std::filesystem::path& path, const std::string& expected) {
    testing::internal::CaptureStderr();
    testing::internal::CaptureStdout();
    const auto volume = read_volume(path);
    EXPECT_EQ(testing::internal::GetCapturedStdout(), "") << path;
    EXPECT_EQ(testing::internal::GetCapturedStderr(), "") << path;
    ASSERT_FALSE(volume.ok()) << path << " was read, expected: " << expected;
    const std::string& message = volume.error().message;
    EXPECT_TRUE(message.starts_with(path.string())) << message;
    EXPECT_NE(message.find(expected), message.npos) << message << "\nexpected: " << expected;
    EXPECT_EQ(message.find('\n'), message.npos) << message;
}

/// A good file with some fields changed.
template <class File>
std::string with(const std::function<void(File&)>& change) {
    File file;
    change(file);
    return file.bytes();
}

struct Case {
    const char* name;
    std::string bytes;
    const char* expected;
};

void expect_all(const std::vector<Case>& cases) {
    const test::TemporaryFolder folder;
    for (const Case& broken : cases)
        expect_one_line(folder.write(broken.name, broken.bytes), broken.expected);
}

TEST(BrokenNrrd, HeadersThatMakeNoSenseAreRefused) {
    const auto nrrd = [](auto change) { return with<NrrdFile>(change); };
    expect_all({
        {"empty.nrrd", "", "is empty"},
        {"text.nrrd", "hello\n", "is no NRRD file"},
        {"magic.nrrd", "NRRD", "is no NRRD file"},
        {"cut.nrrd", "NRRD0004\ntype: short\n", "the header has no end"},
        {"colon.nrrd", "NRRD0004\nwhat\n\n", "has no colon"},
        {"type.nrrd", nrrd([](auto& f) { f.type = "frog"; }), "type is 'frog'"},
        {"block.nrrd", nrrd([](auto& f) { f.type = "block"; }), "type is 'block'"},
        {"bzip2.nrrd", nrrd([](auto& f) { f.encoding = "bzip2"; }), "encoding is 'bzip2'"},
        {"endian.nrrd", nrrd([](auto& f) { f.endian = ""; }), "endian is ''"},
        {"count.nrrd", nrrd([](auto& f) { f.sizes = "4 3"; }), "sizes is '4 3'"},
        {"negative.nrrd", nrrd([](auto& f) { f.sizes = "-4 3 2"; }), "size is -4 × 3 × 2"},
        {"zero.nrrd", nrrd([](auto& f) { f.sizes = "0 3 2"; }), "size is 0 × 3 × 2"},
        {"big.nrrd", nrrd([](auto& f) { f.sizes = "9999999999999999999 1 1"; }), "sizes is"},
        {"huge.nrrd", nrrd([](auto& f) { f.sizes = "60000 60000 60000"; }),
         "expected at most 65536 voxels along an axis and 4294967296 in all"},
        {"kinds.nrrd", nrrd([](auto& f) { f.kinds = "domain"; }), "kinds is 'domain'"},
        {"space.nrrd", nrrd([](auto& f) { f.space = "outer"; }), "space is 'outer'"},
        {"unit.nrrd", nrrd([](auto& f) { f.extra = "space units: \"ly\" \"ly\" \"ly\"\n"; }),
         "space units is"},
    });
}

TEST(BrokenNrrd, GeometryThatMakesNoSenseIsRefused) {
    const auto directed = [](const char* directions) {
        return with<NrrdFile>([&](auto& f) { f.directions = directions; });
    };
    const auto spaced = [](const char* spacings) {
        return with<NrrdFile>([&](auto& f) {
            f.space = f.directions = f.origin = "";
            f.extra = std::string("spacings: ") + spacings + "\n";
        });
    };
    expect_all({
        {"nan.nrrd", directed("(nan,0,0) (0,1,0) (0,0,2)"), "space directions is"},
        {"not-there.nrrd", directed("(nan,nan,nan) (0,1,0) (0,0,2)"), "space directions is"},
        {"zero.nrrd", directed("(0,0,0) (0,1,0) (0,0,2)"), "longer than zero"},
        {"few.nrrd", directed("(1,0,0) (0,1,0)"), "a vector (x,y,z) for each axis"},
        {"flat.nrrd", directed("(1,0) (0,1) (1,1)"), "a vector (x,y,z) for each axis"},
        {"time.nrrd", with<NrrdFile>([](auto& f) { f.space = "left-posterior-superior-time"; }),
         "space directions is"},
        {"skew.nrrd", directed("(1,0,0) (0.5,1,0) (0,0,2)"), "expected perpendicular"},
        {"same.nrrd", directed("(1,0,0) (1,0,0) (0,0,2)"),
         "expected directions that span the space"},
        {"absurd.nrrd", directed("(1e30,0,0) (0,1,0) (0,0,2)"), "spacing of axis 1 is 1e+30 mm"},
        {"origin.nrrd", with<NrrdFile>([](auto& f) { f.origin = "(nan,0,0)"; }),
         "space origin is '(nan,0,0)'"},
        {"far.nrrd", with<NrrdFile>([](auto& f) { f.origin = "(1e30,0,0)"; }), "origin is"},
        {"spacing-nan.nrrd", spaced("1 nan 1"), "spacing of axis 2 is nan mm"},
        {"spacing-zero.nrrd", spaced("1 0 1"), "spacing of axis 2 is 0 mm"},
        {"spacing-negative.nrrd", spaced("1 1 -1"), "spacing of axis 3 is -1 mm"},
    });
}

TEST(BrokenNrrd, DataThatEndEarlyOrAreDamagedAreNoticed) {
    const std::string data = test::packed(test::small_values());
    const auto stored = [](const char* encoding, const std::string& bytes) {
        return with<NrrdFile>([&](auto& f) { f.encoding = encoding, f.data = bytes; });
    };
    const std::string gzip = gzipped(data);
    std::string damaged = gzip;
    damaged[damaged.size() - 6] ^= 1;  // the checksum
    expect_all({
        {"raw.nrrd", stored("raw", data.substr(1)), "ends early"},
        {"none.nrrd", stored("raw", ""), "ends early"},
        {"cut.nrrd", stored("gzip", gzip.substr(0, gzip.size() / 2)), "cut off"},
        {"tail.nrrd", stored("gzip", gzip.substr(0, gzip.size() - 4)), "cut off"},
        {"short.nrrd", stored("gzip", gzipped(data.substr(2))), "hold less than"},
        {"sum.nrrd", stored("gzip", damaged), "are damaged"},
        {"plain.nrrd", stored("gzip", data), "are damaged"},
        {"words.nrrd", stored("ascii", "1 2 3"), "ends early"},
        {"letters.nrrd", stored("ascii", std::string(60, 'x')), "expected a number"},
        {"tiny.nrrd", with<NrrdFile>([&](auto& f) {
             f.encoding = "gzip", f.data = gzip, f.sizes = "1000 1000 1000";
         }),
         "ends early"},
    });
}

TEST(BrokenNrrd, MissingDataFilesAreNamed) {
    const auto beside = [](const char* lines) {
        return with<NrrdFile>([&](auto& f) { f.blank_line = false, f.extra = lines; });
    };
    const test::TemporaryFolder folder;
    folder.write("short.raw", "1234");
    expect_one_line(folder.write("a.nhdr", beside("data file: gone.raw\n")), "gone.raw is missing");
    expect_one_line(folder.write("b.nhdr", beside("data file: short.raw\n")), "has 4 bytes");
    expect_one_line(folder.write("c.nhdr", beside("data file: LIST\ngone.raw\nshort.raw\n")),
                    "gone.raw is missing");
    expect_one_line(folder.write("d.nhdr", beside("data file: LIST\n")), "names 0 data files");
    expect_one_line(folder.write("e.nhdr", beside("data file: s%d.raw 1 2 1\n")),
                    "s1.raw is missing");
    expect_one_line(folder.write("f.nhdr", beside("data file: s%n%s 1 2 1\n")),
                    "names 0 data files");
    expect_one_line(folder.write("g.nhdr", beside("data file: .\n")), "is missing");
    // Numbers whose difference or quotient overflows.
    for (const char* numbers : {"-9223372036854775808 0 -1", "-9223372036854775808 1 1",
                                "9223372036854775806 9223372036854775807 1"})
        expect_one_line(
            folder.write("h.nhdr",
                         beside(("data file: s%d.raw " + std::string(numbers) + "\n").c_str())),
            "names 0 data files");
}

TEST(BrokenNrrd, OtherDimensionsAndVectorsAreRefused) {
    const std::string data(24 * 2 * 4, '\0');
    expect_all({
        {"5d.nrrd", with<NrrdFile>([&](auto& f) {
             f.dimension = "5", f.sizes = "4 3 2 4 2", f.data = data + data;
             f.kinds = f.space = f.directions = f.origin = "";
         }),
         "holds a 5-D image (4 × 3 × 2 × 4 × 2)"},
        {"4d.nrrd", with<NrrdFile>([&](auto& f) {
             f.dimension = "4", f.sizes = "4 3 2 4", f.data = data;
             f.kinds = "domain domain domain time";
             f.directions += " (0,0,1)";
         }),
         "holds 4 images, choose one with --frame 0…3"},
        {"rgb.nrrd", with<NrrdFile>([&](auto& f) {
             f.dimension = "4", f.sizes = "3 4 3 2", f.data = data;
             f.kinds = "RGB-color domain domain domain";
             f.directions = "none " + f.directions;
         }),
         "holds 3 numbers per voxel, expected 1"},
    });
}

TEST(BrokenMetaImage, HeadersAndGeometryThatMakeNoSenseAreRefused) {
    const auto meta = [](auto change) { return with<MetaFile>(change); };
    expect_all({
        {"empty.mha", "", "is empty"},
        {"text.mha", "hello\n", "is no MetaImage file"},
        {"cut.mha", "ObjectType = Image\nNDims = 3\n", "has no ElementDataFile"},
        {"line.mha", "NDims = 3\nwhat\n", "has no '='"},
        {"tube.mha", "ObjectType = Tube\nElementDataFile = LOCAL\n", "ObjectType is 'Tube'"},
        {"type.mha", meta([](auto& f) { f.type = "MET_FROG"; }), "ElementType is 'MET_FROG'"},
        {"sizes.mha", meta([](auto& f) { f.sizes = "4 3"; }), "DimSize is '4 3'"},
        {"huge.mha", meta([](auto& f) { f.sizes = "4294967296 4294967296 2"; }), "at most 65536"},
        {"nan.mha", meta([](auto& f) { f.spacing = "nan 1 1"; }), "spacing of axis 1 is nan mm"},
        {"zero.mha", meta([](auto& f) { f.spacing = "1 0 1"; }), "spacing of axis 2 is 0 mm"},
        {"words.mha", meta([](auto& f) { f.spacing = "1 1 one"; }), "ElementSpacing is"},
        {"offset.mha", meta([](auto& f) { f.offset = "nan 0 0"; }), "origin is (nan, 0, 0) mm"},
        {"skew.mha", meta([](auto& f) { f.matrix = "1 0 0 0.5 1 0 0 0 1"; }), "perpendicular"},
        {"same.mha", meta([](auto& f) { f.matrix = "1 0 0 1 0 0 0 0 1"; }),
         "expected directions that span the space"},
        {"null.mha", meta([](auto& f) { f.matrix = "0 0 0 0 0 0 0 0 0"; }), "TransformMatrix"},
        {"rgb.mha", meta([](auto& f) { f.extra = "ElementNumberOfChannels = 3\n"; }),
         "holds 3 numbers per voxel"},
        {"2d.mha", meta([](auto& f) { f.dimension = "2", f.sizes = "4 6"; }),
         "ElementSpacing is '1 1 2', expected 2 numbers"},
        {"5d.mha", meta([](auto& f) { f.dimension = "5", f.sizes = "4 3 2 1 2"; }),
         "holds a 5-D image (4 × 3 × 2 × 1 × 2)"},
    });
}

TEST(BrokenMetaImage, DataThatAreMissingOrDamagedAreNoticed) {
    const std::string data = test::packed(test::small_values());
    const auto compressed = [](const std::string& bytes) {
        return with<MetaFile>([&](auto& f) {
            f.data = bytes;
            f.extra =
                "CompressedData = True\nCompressedDataSize = " + std::to_string(bytes.size()) +
                "\n";
        });
    };
    const std::string zlib = zlibbed(data);
    std::string damaged = zlib;
    damaged[damaged.size() - 1] ^= 1;
    expect_all({
        {"raw.mha", with<MetaFile>([&](auto& f) { f.data = data.substr(1); }), "ends early"},
        {"cut.mha", compressed(zlib.substr(0, zlib.size() / 2)), "cut off"},
        {"short.mha", compressed(zlibbed(data.substr(2))), "hold less than"},
        {"sum.mha", compressed(damaged), "are damaged"},
        {"plain.mha", compressed(data), "are damaged"},
        {"gone.mhd", with<MetaFile>([](auto& f) { f.data_file = "gone.raw"; }),
         "gone.raw is missing"},
        {"lines.mhd",
         with<MetaFile>([](auto& f) { f.data_file = "LIST\n\nraw.mha\nraw.mha", f.data = ""; }),
         "is missing"},
        {"blanks.mhd",
         with<MetaFile>([](auto& f) { f.data_file = "raw.mha%d  1  2  1", f.data = ""; }),
         "is missing"},
        {"twice.mha", "NDims = -3\n" + MetaFile().bytes(), "NDims is there twice, expected once"},
        {"numbers.mhd", with<MetaFile>([](auto& f) {
             f.data_file = "s%d.raw -9223372036854775808 0 -1", f.data = "";
         }),
         "names 0 data files"},
        {"short.mhd", with<MetaFile>([](auto& f) { f.data_file = "LIST\nraw.mha", f.data = ""; }),
         "names 1 data files, expected 2"},
        {"list.mhd", with<MetaFile>([](auto& f) { f.data_file = "LIST\nx.raw\ny.raw"; }),
         "is missing"},
    });
}

TEST(BrokenNifti, HeadersAndGeometryThatMakeNoSenseAreRefused) {
    const auto nifti = [](auto change) { return with<NiftiFile>(change); };
    constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
    expect_all({
        {"empty.nii", "", "is empty"},
        {"cut.nii", NiftiFile().bytes().substr(0, 200), "348 bytes of NIfTI header"},
        {"junk.nii", std::string(400, 'j'), "sizeof_hdr is"},
        {"two.nii", nifti([](auto& f) { f.header_size = 540; }),
         "expected 540 bytes of NIfTI header"},
        {"magic.nii", nifti([](auto& f) { f.magic = "abc"; }), "magic is 'abc'"},
        {"pair.nii", nifti([](auto& f) { f.magic = "ni1"; }), "is the header of a NIfTI pair"},
        {"rgb.nii", nifti([](auto& f) { f.datatype = 128; }), "datatype is 128 (colour)"},
        {"complex.nii", nifti([](auto& f) { f.datatype = 32; }), "datatype is 32 (complex)"},
        {"4d.nii", nifti([](auto& f) { f.dim = {4, 4, 3, 1, 2, 1, 1, 1}; }),
         "holds 2 images, choose one with --frame 0…1"},
        {"vector.nii", nifti([](auto& f) { f.dim = {5, 4, 2, 1, 1, 3, 1, 1}; }),
         "holds 3 numbers per voxel"},
        {"dim.nii", nifti([](auto& f) { f.dim[0] = 9; }), "dim[0] is 9"},
        {"negative.nii", nifti([](auto& f) { f.dim[1] = -4; }), "size is -4 × 3 × 2"},
        {"huge.nii", nifti([](auto& f) { f.dim = {3, 32000, 32000, 32000, 1, 1, 1, 1}; }),
         "at most"},
        {"start.nii", nifti([](auto& f) { f.vox_offset = 0; }), "vox_offset is 0"},
        {"offset.nii", nifti([&](auto& f) { f.vox_offset = kNan; }), "vox_offset is nan"},
        {"sform.nii", nifti([&](auto& f) { f.sform[0] = kNan; }), "sform has the axis (nan"},
        {"huge-sform.nii", nifti([](auto& f) { f.sform[4] = 1.7e38f; }), "spacing of axis 1 is"},
        {"shear.nii", nifti([](auto& f) { f.sform[1] = 0.5; }), "expected perpendicular"},
        {"origin.nii", nifti([&](auto& f) { f.sform[3] = kNan; }), "origin is (nan"},
        {"pixdim.nii",
         nifti([&](auto& f) { f.sform_code = 0, f.qform_code = 1, f.pixdim[2] = kNan; }),
         "axis 2 is nan"},
        {"plain.nii", nifti([](auto& f) { f.sform_code = 0, f.pixdim[3] = 0; }), "axis 3 is 0 mm"},
    });
}

TEST(BrokenNifti, DataThatEndEarlyOrAreDamagedAreNoticed) {
    const std::string good = NiftiFile().bytes();
    const std::string gzip = gzipped(good);
    std::string long_file = with<NiftiFile>([](auto& f) {
        f.dim = {3, 100, 100, 100, 1, 1, 1, 1};
        std::string data;
        for (unsigned n = 0; n < 2000000; ++n) data += char(n * n >> 7);
        f.data = data;
    });
    std::string cut = gzipped(long_file);
    std::string damaged = cut;
    damaged[damaged.size() - 6] ^= 1;
    cut.resize(cut.size() - 100);
    expect_all({
        {"raw.nii", good.substr(0, good.size() - 1), "ends early"},
        {"header.nii.gz", gzip.substr(0, 20), "348 bytes of NIfTI header"},
        {"cut.nii.gz", cut, "cut off"},
        {"sum.nii.gz", damaged, "are damaged"},
        {"short.nii.gz", gzipped(good.substr(0, good.size() - 1)), "hold less than"},
    });
}

TEST(BrokenPaths, AreNamedWithWhatIsWrong) {
    const test::TemporaryFolder folder;
    std::filesystem::create_directory(folder.path() / "nothing");
    expect_one_line(folder.path() / "gone.nrrd", "no such file");
    expect_one_line(folder.path() / "gone/gone.nrrd", "no such file");
    expect_one_line(folder.path() / "nothing", "holds no DICOM images");
    folder.write("text/a.txt", "a");
    expect_one_line(folder.path() / "text", "holds no DICOM images (1 file looked at)");
    expect_one_line(folder.write("a.txt", "hello"), "is no scan that can be read");
    expect_one_line(folder.write("a.dat", NrrdFile().bytes()), "a name that ends in .nrrd");
    expect_one_line("/dev/null", "neither a file nor a folder");
    const auto closed = folder.write("closed.nrrd", NrrdFile().bytes());
    std::filesystem::permissions(closed, std::filesystem::perms::none);
    if (::geteuid() == 0) GTEST_SKIP() << "root may read everything";
    expect_one_line(closed, "can't be opened");
}

}  // namespace
}  // namespace pliant
