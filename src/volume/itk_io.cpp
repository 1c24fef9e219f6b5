// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The only place that knows ITK. Its ImageIO is made by name, so no factory has to be registered.

#include "volume/itk_io.h"

#include <itkGDCMImageIO.h>
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

/// Reads all of an image.
void read_all(itk::ImageIOBase& io, void* values) {
    itk::ImageIORegion region(io.GetNumberOfDimensions());
    for (unsigned a = 0; a < io.GetNumberOfDimensions(); ++a)
        region.SetSize(a, io.GetDimensions(a));
    io.SetIORegion(region);
    io.Read(values);
}

}  // namespace

Status itk_read_slice(const fs::path& path, int columns, int rows, VoxelBuilder& voxels) {
    return guarded(path, ErrorCode::Unreadable, "its pixels can't be decoded", [&]() -> Status {
        const auto io = itk::GDCMImageIO::New();
        io->SetFileName(path.string());
        io->ReadImageInformation();
        const auto component = component_of(*io);
        const auto count = std::size_t(columns) * std::size_t(rows);
        if (!component || io->GetNumberOfComponents() != 1 ||
            std::size_t(io->GetImageSizeInPixels()) != count ||
            io->GetDimensions(0) != itk::SizeValueType(columns))
            return unreadable(path, "its pixels aren't what its header says");
        std::vector<double> values((count * size_of(*component) + 7) / 8);  // aligned for all
        read_all(*io, values.data());
        voxels.add(*component, values.data(), count);
        return Ok{};
    });
}

}  // namespace pliant
