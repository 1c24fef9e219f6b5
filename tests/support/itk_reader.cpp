// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "support/itk_reader.h"

#include <itkMetaImageIO.h>
#include <itkNiftiImageIO.h>
#include <itkNrrdImageIO.h>

namespace pliant::test {
namespace {

itk::ImageIOBase::Pointer io_for(const std::string& extension) {
    if (extension == ".mha" || extension == ".mhd") return itk::MetaImageIO::New().GetPointer();
    if (extension == ".nii" || extension == ".gz") return itk::NiftiImageIO::New().GetPointer();
    return itk::NrrdImageIO::New().GetPointer();
}

template <class T>
std::vector<double> values_of(itk::ImageIOBase& io, std::size_t count) {
    std::vector<T> values(count);
    io.Read(values.data());
    return {values.begin(), values.end()};
}

std::vector<double> read_values(itk::ImageIOBase& io) {
    const auto count = std::size_t(io.GetImageSizeInComponents());
    using Type = itk::IOComponentEnum;
    switch (io.GetComponentType()) {
        case Type::CHAR:
            return values_of<signed char>(io, count);
        case Type::UCHAR:
            return values_of<unsigned char>(io, count);
        case Type::SHORT:
            return values_of<short>(io, count);
        case Type::USHORT:
            return values_of<unsigned short>(io, count);
        case Type::INT:
            return values_of<int>(io, count);
        case Type::UINT:
            return values_of<unsigned>(io, count);
        case Type::LONG:
            return values_of<long>(io, count);
        case Type::ULONG:
            return values_of<unsigned long>(io, count);
        case Type::LONGLONG:
            return values_of<long long>(io, count);
        case Type::ULONGLONG:
            return values_of<unsigned long long>(io, count);
        case Type::FLOAT:
            return values_of<float>(io, count);
        case Type::DOUBLE:
            return values_of<double>(io, count);
        default:
            return {};
    }
}

}  // namespace

ItkImage read_with_itk(const std::filesystem::path& path) {
    ItkImage image;
    try {
        const auto io = io_for(path.extension().string());
        io->SetFileName(path.string());
        io->ReadImageInformation();
        itk::ImageIORegion region(io->GetNumberOfDimensions());
        for (unsigned a = 0; a < io->GetNumberOfDimensions(); ++a)
            region.SetSize(a, io->GetDimensions(a));
        io->SetIORegion(region);
        image.components = int(io->GetNumberOfComponents());
        for (unsigned a = 0; a < 3; ++a) {
            image.grid.size[int(a)] = std::int32_t(io->GetDimensions(a));
            image.grid.spacing_mm[int(a)] = io->GetSpacing(a);
            image.grid.origin_mm[int(a)] = io->GetOrigin(a);
            const std::vector<double> axis = io->GetDirection(a);
            image.grid.direction.columns[a] = {axis[0], axis[1], axis[2]};
        }
        image.values = read_values(*io);
    } catch (const itk::ExceptionObject& error) {
        image.error = error.GetDescription();
    }
    return image;
}

}  // namespace pliant::test
