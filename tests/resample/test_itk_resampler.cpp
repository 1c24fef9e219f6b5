// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The written inverse transform in an independent resampler: ITK reads the transform and the
// original scan, and must reproduce the deformed scan that Pliant wrote.

#include <gtest/gtest.h>
#include <itkDisplacementFieldTransform.h>
#include <itkImage.h>
#include <itkImageFileReader.h>
#include <itkLinearInterpolateImageFunction.h>
#include <itkNrrdImageIO.h>
#include <itkResampleImageFilter.h>
#include <pliant/chainmail.h>
#include <pliant/resample.h>
#include <pliant/scan_files.h>
#include <pliant/volume.h>

#include <cmath>

#include "support/random.h"
#include "support/temporary_folder.h"

namespace pliant::test {
namespace {

using ScalarImage = itk::Image<float, 3>;
using VectorImage = itk::Image<itk::Vector<double, 3>, 3>;

template <class Image>
typename Image::Pointer read_with_itk(const std::filesystem::path& path) {
    auto reader = itk::ImageFileReader<Image>::New();
    reader->SetImageIO(itk::NrrdImageIO::New());
    reader->SetFileName(path.string());
    reader->Update();
    return reader->GetOutput();
}

ScalarImage::Pointer resample_with_itk(const std::filesystem::path& original,
                                       const std::filesystem::path& transform_file) {
    const auto image = read_with_itk<ScalarImage>(original);
    const auto field = read_with_itk<VectorImage>(transform_file);
    auto transform = itk::DisplacementFieldTransform<double, 3>::New();
    transform->SetDisplacementField(field);
    auto filter = itk::ResampleImageFilter<ScalarImage, ScalarImage, double, double>::New();
    filter->SetInput(image);
    filter->SetTransform(transform);
    filter->SetInterpolator(itk::LinearInterpolateImageFunction<ScalarImage, double>::New());
    filter->SetOutputParametersFromImage(image);
    filter->SetDefaultPixelValue(kAirHu);
    // One thread: ThreadSanitizer can't see the synchronisation of ITK's threads.
    filter->GetMultiThreader()->SetMaximumNumberOfThreads(1);
    filter->SetNumberOfWorkUnits(1);
    filter->Update();
    return filter->GetOutput();
}

struct Agreement {
    std::int64_t changed = 0, within_3_hu = 0;
};

/// Writes a user's files, and lets ITK repeat the deformation.
Agreement compare_with_itk(const Volume& volume, std::span<const Push> pushes) {
    const TaskArena arena(2);
    ChainMail tissue = std::move(ChainMail::create(volume, {}, arena)).value();
    for (const Push& push : pushes) EXPECT_TRUE(tissue.push(push).ok());
    const Deformed deformed = deform_volume(tissue, Mapping::Cells, true).value();
    const TemporaryFolder folder;
    EXPECT_TRUE(write_volume(folder / "original.nrrd", volume).ok());
    EXPECT_TRUE(
        write_vector_field(folder / "transform.nrrd", inverse_field(deformed).value()).ok());
    const auto expected = resample_with_itk(folder / "original.nrrd", folder / "transform.nrrd");
    Agreement agreement;
    const float* itk_value = expected->GetBufferPointer();
    for (int z = 0; z < volume.grid.size.z; ++z)
        for (int y = 0; y < volume.grid.size.y; ++y)
            for (int x = 0; x < volume.grid.size.x; ++x, ++itk_value) {
                const float value = deformed.volume.at({x, y, z});
                if (value == volume.at({x, y, z})) continue;
                ++agreement.changed;
                agreement.within_3_hu += std::abs(value - *itk_value) <= 3;
            }
    return agreement;
}

TEST(ItkResampler, TransformGivesTheDeformedPhantomOnAnObliqueLeftHandedGrid) {
    const TaskArena arena(2);
    Random random(11);
    PhantomSettings settings{.name = "airway", .size = {64, 60, 56}};
    settings.direction = random.rotation(true);
    const auto phantom = make_phantom(settings, arena);
    ASSERT_TRUE(phantom.ok());
    const PhantomLandmark& carina = phantom->landmarks.at(0);
    const Push pushes[] = {{carina.push_point_mm, carina.push_mm, 5},
                           {carina.push_point_mm, {3, 2, 0}, 0}};
    const Agreement agreement = compare_with_itk(phantom->volume, pushes);
    EXPECT_GT(agreement.changed, 500);
    EXPECT_GE(double(agreement.within_3_hu), 0.99 * double(agreement.changed));
}

TEST(ItkResampler, TransformGivesTheDeformedThorax) {
    const std::filesystem::path file =
        std::filesystem::path(PLIANT_SHARED_DATA) / "thorax_ct_airways_crop.nrrd";
    if (!std::filesystem::exists(file)) GTEST_SKIP() << "no " << file.filename() << " here";
    const auto volume = read_volume(file);
    ASSERT_TRUE(volume.ok());
    const Push pushes[] = {{{-22.5, 172.3, -493}, {0, 0, -6}, 4}};  // the carina
    const Agreement agreement = compare_with_itk(*volume, pushes);
    EXPECT_GT(agreement.changed, 50000);
    EXPECT_GE(double(agreement.within_3_hu), 0.99 * double(agreement.changed));
}

}  // namespace
}  // namespace pliant::test
