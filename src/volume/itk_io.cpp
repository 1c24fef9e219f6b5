// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The only place that knows ITK. Each format's ImageIO is made by name, so no factory has to be
// registered.

#include "volume/itk_io.h"

#include <itkMetaDataObject.h>
#include <itkMetaImageIO.h>
#include <itkNiftiImageIO.h>
#include <itkNrrdImageIO.h>
#include <locale.h>

#include <iostream>
#include <mutex>
#include <new>

#include "core/errors.h"

namespace pliant {
namespace fs = std::filesystem;
namespace {

/// ITK and the libraries below it print warnings to the C++ error stream. While one of these lives
/// they don't. They also keep state that is not safe to share, so one thread reads at a time, and
/// read numbers as the locale says, so it is C's on this thread.
class QuietItk {
  public:
    QuietItk()
        : m_lock(mutex()),
          m_warnings(itk::Object::GetGlobalWarningDisplay()),
          m_plain_locale(newlocale(LC_NUMERIC_MASK, "C", nullptr)),
          m_locale(uselocale(m_plain_locale)) {
        itk::Object::GlobalWarningDisplayOff();
        m_stream = std::cerr.rdbuf(nullptr);
    }
    ~QuietItk() {
        std::cerr.rdbuf(m_stream);
        itk::Object::SetGlobalWarningDisplay(m_warnings);
        uselocale(m_locale);
        freelocale(m_plain_locale);
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
    locale_t m_plain_locale, m_locale;
    std::streambuf* m_stream;
};

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

/// @param[out] oriented  false where ITK took none of NIfTI's orientations. It looks for one last,
/// so all else can be read.
itk::ImageIOBase::Pointer new_io(const fs::path& path, ImageFormat format, bool& oriented) {
    itk::ImageIOBase::Pointer io;
    if (format == ImageFormat::Nrrd) io = itk::NrrdImageIO::New();
    if (format == ImageFormat::MetaImage) io = itk::MetaImageIO::New();
    if (format == ImageFormat::Nifti) io = itk::NiftiImageIO::New();
    io->SetFileName(path.string());
    oriented = true;
    try {
        io->ReadImageInformation();
    } catch (const itk::ExceptionObject& error) {
        const std::string_view description = error.GetDescription();
        oriented = description.find("No orthonormal definition") == description.npos;
        if (oriented) throw;
    }
    return io;
}

/// Reads all of an image.
void read_all(itk::ImageIOBase& io, void* values) {
    itk::ImageIORegion region(io.GetNumberOfDimensions());
    for (unsigned a = 0; a < io.GetNumberOfDimensions(); ++a)
        region.SetSize(a, io.GetDimensions(a));
    io.SetIORegion(region);
    io.Read(values);
}

void take_grid(const itk::ImageIOBase& io, Grid& grid) {
    for (unsigned a = 0; a < 3; ++a) {
        grid.spacing_mm[int(a)] = io.GetSpacing(a);
        grid.origin_mm[int(a)] = io.GetOrigin(a);
        const std::vector<double> axis = io.GetDirection(a);
        grid.direction.columns[a] = {axis[0], axis[1], axis[2]};
    }
}

KeyValues key_values_of(itk::ImageIOBase& io) {
    KeyValues pairs;
    for (const std::string& key : io.GetMetaDataDictionary().GetKeys())
        if (std::string value;
            !is_itk_key(key) && itk::ExposeMetaData(io.GetMetaDataDictionary(), key, value))
            pairs.emplace_back(key, value);
    return pairs;
}

}  // namespace

Status itk_read_header(const fs::path& path, ImageHeader& header) {
    return guarded(path, ErrorCode::Unreadable, "its header can't be read", [&]() -> Status {
        itk::ImageIOBase::Pointer io;
        try {
            io = new_io(path, header.format, header.oriented);
        } catch (const itk::ExceptionObject& error) {
            return Error{ErrorCode::Unreadable, error.GetDescription()};
        }
        const auto component = component_of(*io);
        if (!component)
            return Error{ErrorCode::Unsupported, path.string() + ": has an unknown type"};
        header.component = *component;
        header.components = std::int64_t(io->GetNumberOfComponents());
        header.sizes.clear();
        for (unsigned a = 0; a < io->GetNumberOfDimensions(); ++a)
            header.sizes.push_back(std::int64_t(io->GetDimensions(a)));
        if (header.sizes.size() == 3) take_grid(*io, header.grid);
        if (header.format != ImageFormat::Nifti) header.key_values = key_values_of(*io);
        return Ok{};
    });
}

Status itk_read_values(const fs::path& path, const ImageHeader& header, void* values) {
    return guarded(path, ErrorCode::Unreadable, "its data can't be read", [&]() -> Status {
        bool known = true;
        const auto io = new_io(path, header.format, known);
        const auto count = voxel_count(header.grid) * std::size_t(header.components);
        if (std::size_t(io->GetImageSizeInBytes()) != count * size_of(header.component))
            return unreadable(path, "changed while it was read");
        read_all(*io, values);
        return Ok{};
    });
}

}  // namespace pliant
