// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The only place that knows ITK. Each format's ImageIO is made by name, so no factory has to be
// registered, and fills our own memory, so nothing is held twice.

#include "volume/itk_io.h"

#include <itkGDCMImageIO.h>
#include <itkMetaDataObject.h>
#include <itkMetaImageIO.h>
#include <itkNiftiImageIO.h>
#include <itkNrrdImageIO.h>

#include <iostream>
#include <mutex>
#include <new>

namespace pliant {
namespace fs = std::filesystem;
namespace {

/// Fast: on scans and on sparse fields higher levels cost three times the time for a few percent.
constexpr int kGzipLevel = 1;

/// ITK and the libraries below it print warnings to the C++ error stream. While one of these lives
/// they don't. They also keep state that is not safe to share, so one thread reads at a time.
class QuietItk {
  public:
    QuietItk() : m_lock(mutex()), m_warnings(itk::Object::GetGlobalWarningDisplay()) {
        itk::Object::GlobalWarningDisplayOff();
        m_stream = std::cerr.rdbuf(nullptr);
    }
    ~QuietItk() {
        std::cerr.rdbuf(m_stream);
        itk::Object::SetGlobalWarningDisplay(m_warnings);
    }
    QuietItk(const QuietItk&) = delete;
    QuietItk& operator=(const QuietItk&) = delete;

  private:
    static std::mutex& mutex() {
        static std::mutex one;
        return one;
    }
    std::lock_guard<std::mutex> m_lock;
    bool m_warnings;
    std::streambuf* m_stream;
};

Error damaged(const fs::path& path, const std::string& message) {
    return {ErrorCode::Unreadable, path.string() + ": " + message};
}

/// Runs work that may throw whatever ITK throws.
template <class Work>
Status guarded(const fs::path& path, ErrorCode code, const char* failure, Work&& work) {
    const QuietItk quiet;
    try {
        return work();
    } catch (const std::bad_alloc&) {
        return Error{ErrorCode::LimitExceeded, path.string() + ": not enough memory"};
    } catch (const itk::ExceptionObject&) {
        return Error{code, path.string() + ": " + failure};
    } catch (const std::exception& other) {
        return Error{code, path.string() + ": " + failure + " (" + other.what() + ")"};
    }
}

itk::ImageIOBase::Pointer image_io(ImageFormat format) {
    switch (format) {
        case ImageFormat::Nrrd:
            return itk::NrrdImageIO::New().GetPointer();
        case ImageFormat::MetaImage:
            return itk::MetaImageIO::New().GetPointer();
        case ImageFormat::Nifti: {
            auto io = itk::NiftiImageIO::New();
            io->SetLegacyAnalyze75Mode(itk::NiftiImageIOEnums::Analyze75Flavor::AnalyzeReject);
            return io.GetPointer();
        }
    }
    return nullptr;
}

std::optional<Component> component_of(const itk::ImageIOBase& io) {
    using Type = itk::IOComponentEnum;
    const bool wide_long = sizeof(long) == 8;
    switch (io.GetComponentType()) {
        case Type::CHAR:
            return Component::Int8;
        case Type::UCHAR:
            return Component::UInt8;
        case Type::SHORT:
            return Component::Int16;
        case Type::USHORT:
            return Component::UInt16;
        case Type::INT:
            return Component::Int32;
        case Type::UINT:
            return Component::UInt32;
        case Type::LONG:
            return wide_long ? Component::Int64 : Component::Int32;
        case Type::ULONG:
            return wide_long ? Component::UInt64 : Component::UInt32;
        case Type::LONGLONG:
            return Component::Int64;
        case Type::ULONGLONG:
            return Component::UInt64;
        case Type::FLOAT:
            return Component::Float32;
        case Type::DOUBLE:
            return Component::Float64;
        default:
            return std::nullopt;
    }
}

itk::IOComponentEnum itk_type(Component component) {
    using Type = itk::IOComponentEnum;
    constexpr Type kTypes[] = {Type::CHAR,  Type::UCHAR, Type::SHORT,    Type::USHORT,
                               Type::INT,   Type::UINT,  Type::LONGLONG, Type::ULONGLONG,
                               Type::FLOAT, Type::DOUBLE};
    return kTypes[int(component)];
}

/// Whether ITK sees the same image as we do; asks for all of it.
Status expect_image(const fs::path& path, itk::ImageIOBase& io, Vec3i size, unsigned components) {
    io.SetFileName(path.string());
    io.ReadImageInformation();
    const unsigned dimension = io.GetNumberOfDimensions();
    bool same = dimension >= 2 && io.GetNumberOfComponents() == components;
    itk::ImageIORegion region(dimension);
    for (unsigned a = 0; a < dimension; ++a) {
        same = same && std::int64_t(io.GetDimensions(a)) == (a < 3 ? size[int(a)] : 1);
        region.SetSize(a, io.GetDimensions(a));
    }
    if (!same || (dimension < 3 && size.z != 1) || !component_of(io))
        return damaged(path, "can't be decoded: its data aren't what its header says");
    io.SetIORegion(region);
    return Ok{};
}

/// Reads all numbers into a vector of their type and hands it over; or by way of plain bytes.
Status read_into(const fs::path& path, itk::ImageIOBase& io, VoxelBuilder& voxels,
                 std::size_t count) {
    const auto component = component_of(io);
    if (!component) return damaged(path, "has voxels of an unknown type");
    if (*component == Component::Int16) {
        std::vector<std::int16_t> values(count);
        io.Read(values.data());
        if (voxels.size() == 0 && voxels.capacity() == count)
            voxels.take(std::move(values));
        else
            voxels.add(*component, values.data(), count);
    } else if (*component == Component::Float32) {
        std::vector<float> values(count);
        io.Read(values.data());
        if (voxels.size() == 0 && voxels.capacity() == count)
            voxels.take(std::move(values));
        else
            voxels.add(*component, values.data(), count);
    } else {
        std::vector<double> aligned((count * size_of(*component) + 7) / 8);
        io.Read(aligned.data());
        voxels.add(*component, aligned.data(), count);
    }
    return Ok{};
}

}  // namespace

Status itk_read_voxels(const fs::path& path, const ImageHeader& header, VoxelBuilder& voxels) {
    return guarded(path, ErrorCode::Unreadable, "its data are damaged or end early", [&]() {
        const auto io = image_io(header.format);
        if (Status status = expect_image(path, *io, header.grid.size, 1); !status) return status;
        return read_into(path, *io, voxels, voxel_count(header.grid));
    });
}

Status itk_read_vectors(const fs::path& path, const ImageHeader& header,
                        std::vector<Vec3f>& vectors) {
    return guarded(path, ErrorCode::Unreadable, "its data are damaged or end early", [&]() {
        const auto io = image_io(header.format);
        if (Status status = expect_image(path, *io, header.grid.size, 3); !status) return status;
        vectors.resize(voxel_count(header.grid));
        if (header.component == Component::Float32) {
            io->Read(vectors.data());
            return Status(Ok{});
        }
        std::vector<Vec3d> wide(vectors.size());
        io->Read(wide.data());
        for (std::size_t n = 0; n < wide.size(); ++n)
            vectors[n] = {float(wide[n].x), float(wide[n].y), float(wide[n].z)};
        return Status(Ok{});
    });
}

Status itk_read_slice(const fs::path& path, int columns, int rows, VoxelBuilder& voxels) {
    return guarded(path, ErrorCode::Unreadable, "its pixels can't be decoded", [&]() {
        const itk::ImageIOBase::Pointer io = itk::GDCMImageIO::New().GetPointer();
        if (Status status = expect_image(path, *io, {columns, rows, 1}, 1); !status) return status;
        return read_into(path, *io, voxels, std::size_t(columns) * std::size_t(rows));
    });
}

Result<Grid> itk_read_grid(const fs::path& path, ImageFormat format) {
    Grid grid;
    Status status = guarded(path, ErrorCode::Unreadable, "can't be read", [&]() {
        const auto io = image_io(format);
        io->SetFileName(path.string());
        io->ReadImageInformation();
        for (unsigned a = 0; a < 3; ++a) {
            grid.size[int(a)] = std::int32_t(io->GetDimensions(a));
            grid.spacing_mm[int(a)] = io->GetSpacing(a);
            grid.origin_mm[int(a)] = io->GetOrigin(a);
            const std::vector<double> axis = io->GetDirection(a);
            grid.direction.columns[a] = {axis[0], axis[1], axis[2]};
        }
        return Status(Ok{});
    });
    if (!status) return status.error();
    return grid;
}

Status itk_write_nrrd(const fs::path& path, const NrrdImage& image, Encoding encoding) {
    return guarded(path, ErrorCode::Unwritable, "can't be written", [&]() {
        const auto io = itk::NrrdImageIO::New();
        io->SetFileName(path.string());
        io->SetNumberOfDimensions(3);
        io->SetComponentType(itk_type(image.component));
        io->SetNumberOfComponents(unsigned(image.components));
        io->SetPixelType(image.components == 1 ? itk::IOPixelEnum::SCALAR
                                               : itk::IOPixelEnum::VECTOR);
        io->SetByteOrderToLittleEndian();
        itk::ImageIORegion region(3);
        for (unsigned a = 0; a < 3; ++a) {
            const auto size = itk::SizeValueType(image.grid.size[int(a)]);
            const Vec3d axis = image.grid.direction.columns[a];
            io->SetDimensions(a, size);
            region.SetSize(a, size);
            io->SetSpacing(a, image.grid.spacing_mm[int(a)]);
            io->SetOrigin(a, image.grid.origin_mm[int(a)]);
            io->SetDirection(a, std::vector<double>{axis.x, axis.y, axis.z});
        }
        io->SetIORegion(region);
        for (const auto& [key, value] : image.key_values)
            itk::EncapsulateMetaData<std::string>(io->GetMetaDataDictionary(), key, value);
        io->SetUseCompression(encoding == Encoding::Gzip);
        io->SetCompressionLevel(kGzipLevel);
        io->Write(image.values);
        return Status(Ok{});
    });
}

}  // namespace pliant
