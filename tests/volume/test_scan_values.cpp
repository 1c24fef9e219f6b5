// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The kind that is inferred from a scan's values, and the defaults that follow.

#include <gtest/gtest.h>
#include <pliant/data/scan_values.h>
#include <pliant/scan_files.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <numeric>
#include <vector>

#include "support/made.h"
#include "support/random.h"

namespace pliant::test {
namespace {

namespace fs = std::filesystem;

constexpr int kSide = 20;

/// A cube whose voxel n of kSide³ has the value f(n / kSide³).
template <class T, class F>
Volume cube_of(const F& f) {
    constexpr int kCount = kSide * kSide * kSide;
    std::vector<T> values;
    for (int n = 0; n < kCount; ++n) values.push_back(T(f(double(n) / kCount)));
    return {{.size = {kSide, kSide, kSide}}, VoxelArray<T>(values), {}};
}

/// A share of low values, then a share of high ones, with noise.
template <class T>
Volume two_classes(double low, double high, double high_share, double noise = 0) {
    Random random(7);
    return cube_of<T>([&](double at) {
        return (at < 1 - high_share ? low : high) + noise * (2 * random.real(0, 1) - 1);
    });
}

ReadNotes dicom(const std::string& modality, const std::string& type, bool rescaled) {
    ReadNotes notes;
    notes.format = "DICOM";
    notes.modality = modality;
    notes.rescale_type = type;
    notes.is_rescaled = rescaled;
    return notes;
}

ValueKind kind(const Volume& volume, const ReadNotes& notes = {}) {
    return value_defaults(volume, notes).kind;
}

TEST(ScanValues, DicomsStatementDecides) {
    const Volume grey = two_classes<std::int16_t>(0, 1100, 0.5);
    EXPECT_EQ(kind(grey, dicom("CT", "HU", false)), ValueKind::Hounsfield);
    EXPECT_EQ(kind(grey, dicom("CT", "", true)), ValueKind::Hounsfield);
    EXPECT_EQ(kind(grey, dicom("CT", "", false)), ValueKind::XRay);
    EXPECT_EQ(kind(grey, dicom("CT", "US", true)), ValueKind::XRay);
    EXPECT_EQ(kind(grey, dicom("MR", "", true)), ValueKind::Magnetic);
    EXPECT_EQ(kind(grey, dicom("US", "", false)), ValueKind::Ultrasound);
    EXPECT_EQ(kind(grey, dicom("PT", "BQML", true)), ValueKind::Other);
    EXPECT_EQ(kind(grey, dicom("OT", "", false)), ValueKind::Other);
    EXPECT_EQ(value_defaults(grey, dicom("MR", "", true)).reason, "DICOM says MR");
    // An MR whose values look like CT is one nevertheless; a CT without a type is looked at.
    const Volume ct = two_classes<std::int16_t>(-1000, 40, 0.5);
    EXPECT_EQ(kind(ct, dicom("MR", "", true)), ValueKind::Magnetic);
    EXPECT_EQ(kind(ct, dicom("CT", "", false)), ValueKind::Hounsfield);
}

TEST(ScanValues, DicomsWindowIsTaken) {
    const Volume grey = two_classes<std::int16_t>(0, 1100, 0.5);
    for (const ReadNotes& own : {dicom("MR", "", true), dicom("CT", "HU", true)}) {
        ReadNotes notes = own;
        ValueDefaults expected = value_defaults(grey, own);
        notes.window = 350;
        notes.level = 40;
        expected.window = 350;
        expected.level = 40;
        EXPECT_EQ(defaults_text(value_defaults(grey, notes)), defaults_text(expected));
    }
}

TEST(ScanValues, AirAndSoftTissueAreCt) {
    EXPECT_EQ(kind(two_classes<std::int16_t>(-1000, 40, 0.5)), ValueKind::Hounsfield);
    EXPECT_EQ(kind(two_classes<float>(-1000.25, 40.5, 0.5)), ValueKind::Hounsfield);
    // The bounds of both.
    for (const double air : {-1100.0, -850.0})
        for (const double soft : {-200.0, 300.0})
            EXPECT_EQ(kind(two_classes<float>(air, soft, 0.5)), ValueKind::Hounsfield);
    for (const double air : {-1100.5, -849.5})
        EXPECT_EQ(kind(two_classes<float>(air, 40.5, 0.5)), ValueKind::Other) << air;
    for (const double soft : {-200.5, 300.5})
        EXPECT_EQ(kind(two_classes<float>(-1000, soft, 0.5)), ValueKind::Other) << soft;
    EXPECT_EQ(kind(two_classes<float>(-1000, 40.5, 0.0101)), ValueKind::Hounsfield);
    EXPECT_EQ(kind(two_classes<float>(-1000, 40.5, 0.0099)), ValueKind::Other);
    EXPECT_EQ(kind(two_classes<float>(-1000, 40.5, 0.9989)), ValueKind::Hounsfield);
    EXPECT_EQ(kind(two_classes<float>(-1000, 40.5, 0.9993)), ValueKind::Other);
    // Padding is below air; a signed 16-bit scan that uses all values is no CT.
    const auto with_lowest = [](double lowest) {
        return cube_of<std::int16_t>([=](double at) {
            return at < 0.1 ? lowest : at < 0.5 ? -1000 : 40;
        });
    };
    EXPECT_EQ(kind(with_lowest(-4096)), ValueKind::Hounsfield);
    EXPECT_EQ(kind(with_lowest(-4097)), ValueKind::Other);
    EXPECT_EQ(kind(cube_of<std::int16_t>([](double at) { return -32768 + 65535 * at; })),
              ValueKind::Other);
}

TEST(ScanValues, APartOfCtWithoutAirIsCtIfItsValuesAreWhole) {
    const auto part = [](double lowest, double soft_share, double more) {
        return cube_of<float>([=](double at) {
            return at == 0 ? lowest : at < soft_share ? 60 + more : 700;
        });
    };
    EXPECT_EQ(kind(part(-30, 0.6, 0)), ValueKind::Hounsfield);
    EXPECT_EQ(kind(part(-29, 0.6, 0)), ValueKind::Other);
    EXPECT_EQ(kind(part(-1101, 0.6, 0)), ValueKind::Other);
    EXPECT_EQ(kind(part(-30, 0.6, 0.5)), ValueKind::Other);
    EXPECT_EQ(kind(part(-30, 0.51, 0)), ValueKind::Hounsfield);
    EXPECT_EQ(kind(part(-30, 0.49, 0)), ValueKind::Other);
}

TEST(ScanValues, APhantomIsCtWhateverItHolds) {
    for (const std::string_view name : phantom_names()) {
        const Phantom phantom =
            made(make_phantom({.name = std::string(name), .size = {32, 32, 32}}, TaskArena(1)));
        const ValueDefaults values = value_defaults(phantom.volume);
        EXPECT_EQ(values.kind, ValueKind::Hounsfield) << name;
        EXPECT_EQ(values.reason, "a phantom");
    }
}

TEST(ScanValues, CtKeepsTheDefaultsThatItAlwaysHad) {
    const ValueDefaults values = value_defaults(two_classes<std::int16_t>(-1024, 40, 0.5));
    EXPECT_EQ(values.window, 1500);
    EXPECT_EQ(values.level, -200);
    EXPECT_EQ(values.iso, -500);
    EXPECT_FALSE(values.lumen_is_bright);
    EXPECT_EQ(values.range, (ValueSpan{-1000, 3095}));
    EXPECT_EQ(values.air_threshold, -500);
    EXPECT_EQ(values.bone_threshold, 300);
    EXPECT_EQ(values.background, -1000);
    EXPECT_EQ(remark_on(values, "x"), "");
}

TEST(ScanValues, CtInOtherUnitsIsScaledLikeHu) {
    // Air 100, tissue 1140: one grey value for one HU, 1100 more.
    const Volume grey = two_classes<std::int16_t>(100, 1140, 0.5);
    const ValueDefaults values = value_defaults(grey, dicom("CT", "", false));
    EXPECT_EQ(values.iso, 600);
    EXPECT_EQ(values.air_threshold, 600);
    EXPECT_EQ(values.bone_threshold, 1400);
    EXPECT_EQ(values.window, 1500);
    EXPECT_EQ(values.level, 900);
    EXPECT_EQ(values.range, (ValueSpan{100, 4200}));
    EXPECT_EQ(values.background, 100);
    EXPECT_EQ(
        remark_on(values, "this"),
        "taken as CT without HU (DICOM says CT, but not HU); defaults: window 1500, level 900, "
        "iso 600 rising, air below 600, bone above 1400, range 100 to 4200, outside 100; change "
        "with "
        "this");
}

TEST(ScanValues, NothingIsRigidInAnMrAndItsDarkBackgroundIsAir) {
    for (const double scale : {1.0, 1e-3, 20.0}) {
        const Volume head = two_classes<float>(20 * scale, 900 * scale, 0.6, 15 * scale);
        const ValueDefaults values = value_defaults(head, dicom("MR", "", false));
        EXPECT_NEAR(values.iso, 460 * scale, 10 * scale);
        EXPECT_FALSE(values.lumen_is_bright);
        EXPECT_TRUE(values.has_air);
        EXPECT_GT(values.air_threshold, 40 * scale);
        EXPECT_LT(values.air_threshold, 460 * scale);
        EXPECT_FALSE(values.has_bone);
        EXPECT_GE(values.bone_threshold, 914 * scale);
        EXPECT_GT(values.range.high, 2 * 915 * scale);
        EXPECT_NEAR(values.background, 5 * scale, scale);
        EXPECT_NEAR(values.level, 460 * scale, 20 * scale);
        EXPECT_NEAR(values.window, 910 * scale, 40 * scale);
    }
}

TEST(ScanValues, SparseBrightVesselsAreTheLumen) {
    Random random(3);
    // Background, tissue, and 2 % of contrast agent.
    const Volume angiography = cube_of<std::int16_t>([&](double at) {
        return (at < 0.3 ? 20 : at < 0.98 ? 200 : 1200) + 15 * (2 * random.real(0, 1) - 1);
    });
    const ValueDefaults values = value_defaults(angiography, dicom("MR", "", false));
    EXPECT_TRUE(values.lumen_is_bright);
    EXPECT_GT(values.iso, 400);
    EXPECT_LT(values.iso, 1000);
    EXPECT_FALSE(values.has_air);
    // Sound shows liquids dark.
    EXPECT_FALSE(value_defaults(angiography, dicom("US", "", false)).lumen_is_bright);
}

TEST(ScanValues, OutliersDoNotChangeTheWindow) {
    Volume head = two_classes<float>(0, 100, 0.6);
    std::get<1>(head.voxels)[17] = 60000;
    const ValueDefaults values = value_defaults(head);
    EXPECT_EQ(values.window, 100);
    EXPECT_EQ(values.level, 50);
    EXPECT_GT(values.range.high, 60000);  // or the outlier would be rigid
}

TEST(ScanValues, ConstantAndBrokenVolumesHaveDefaultsToo) {
    const ValueDefaults values = value_defaults(cube_of<std::int16_t>([](double) { return 5; }));
    EXPECT_EQ(values.kind, ValueKind::Other);
    EXPECT_EQ(values.background, 5);
    EXPECT_LT(values.range.low, values.range.high);
    EXPECT_GT(values.window, 0);
    EXPECT_FALSE(values.has_air);
    const float nan = std::numeric_limits<float>::quiet_NaN();
    const ValueDefaults none = value_defaults(cube_of<float>([&](double) { return nan; }));
    EXPECT_EQ(none.background, 0);
    EXPECT_LT(none.range.low, none.range.high);
    EXPECT_EQ(value_defaults(Volume{}).kind, ValueKind::Hounsfield);
}

TEST(ScanValues, PercentilesAreThoseOfTheSortedValues) {
    Random random(11);
    const Volume volume =
        cube_of<float>([&](double) { return random.real(0, 1) * random.real(0, 1); });
    std::vector<float> sorted(std::get<1>(volume.voxels).begin(), std::get<1>(volume.voxels).end());
    std::sort(sorted.begin(), sorted.end());
    const std::vector<double> percent = {0, 1, 25, 50, 99, 100};
    const std::vector<double> found = percentiles(volume, percent);
    for (std::size_t n = 0; n < percent.size(); ++n) {
        const auto rank = std::size_t(std::lround(percent[n] / 100 * double(sorted.size() - 1)));
        EXPECT_NEAR(found[n], double(sorted[rank]), 1.0 / 65535) << percent[n];
    }
    EXPECT_EQ(percentiles(cube_of<std::int16_t>([](double) { return 5; }), percent),
              std::vector<double>(6, 5.0));
}

TEST(ScanValues, LengthsShrinkWithSmallSpecimensOnly) {
    EXPECT_EQ(length_scale({.size = {512, 512, 300}, .spacing_mm = {0.8, 0.8, 1}}), 1);
    EXPECT_EQ(length_scale({.size = {100, 10, 10}}), 1);
    EXPECT_DOUBLE_EQ(length_scale({.size = {100, 200, 100}, .spacing_mm = {0.02, 0.02, 0.02}}),
                     0.04);
}

struct SharedScan {
    const char* name;
    ValueKind kind;
};

TEST(ScanValues, RealScansAreTakenForWhatTheyAre) {
    const fs::path data = PLIANT_SHARED_DATA;
    if (!fs::is_directory(data)) GTEST_SKIP() << data << " is missing";
    for (const auto& [name, expected] : {SharedScan{"thorax_ct_256.nrrd", ValueKind::Hounsfield},
                                         {"thorax_ct_airways_crop.nrrd", ValueKind::Hounsfield},
                                         {"abdomen_ct_3mm.nii.gz", ValueKind::Hounsfield},
                                         {"aorta_cta_1p5mm.nii.gz", ValueKind::Hounsfield},
                                         {"head_ct_tiny_64.nrrd", ValueKind::Hounsfield},
                                         {"dicom_thorax_10", ValueKind::Hounsfield},
                                         {"mr_head_mni152_2mm.nii.gz", ValueKind::Other},
                                         {"abdomen_ct_3mm-label.nii.gz", ValueKind::Other}}) {
        ReadNotes notes;
        const auto volume = read_volume(data / name, {}, &notes);
        ASSERT_TRUE(volume.ok()) << volume.error().message;
        EXPECT_EQ(kind(*volume, notes), expected) << name;
    }
}

}  // namespace
}  // namespace pliant::test
