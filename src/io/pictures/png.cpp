// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// PNG files; the only user of libpng. Its simplified interface handles the long jumps internally
// and returns errors as text.

#include <pliant/core/files.h>
#include <pliant/view/png.h>
#include <png.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <memory>

namespace pliant {
namespace {

struct CloseFile {
    void operator()(std::FILE* file) const { std::fclose(file); }
};

Error unwritable(const std::filesystem::path& path, const std::string& why) {
    return {ErrorCode::Unwritable, path.string() + ": " + why};
}

}  // namespace

Status write_png(const std::filesystem::path& path, const Image& image) {
    const bool whole = image.width > 0 && image.height > 0 &&
                       image.pixels.size() == std::size_t(image.width) * std::size_t(image.height);
    if (!whole)
        return Error{ErrorCode::InvalidArgument,
                     path.string() + ": the picture has " + std::to_string(image.pixels.size()) +
                         " pixels, expected " + std::to_string(image.width) + "×" +
                         std::to_string(image.height)};
    StagedFiles staged;
    const auto temporary = staged.stage(path);
    if (!temporary) return temporary.error();
    std::unique_ptr<std::FILE, CloseFile> file(std::fopen(temporary->c_str(), "wb"));
    if (!file) return unwritable(path, std::string("can't be opened: ") + std::strerror(errno));

    png_image png{};
    png.version = PNG_IMAGE_VERSION;
    png.width = png_uint_32(image.width);
    png.height = png_uint_32(image.height);
    png.format = PNG_FORMAT_RGB;
    static_assert(sizeof(Rgb8) == 3);
    if (!png_image_write_to_stdio(&png, file.get(), 0, image.pixels.data(), 0, nullptr))
        return unwritable(path, std::string("can't be written: ") + png.message);
    if (std::fclose(file.release()) != 0)
        return unwritable(path, std::string("can't be written: ") + std::strerror(errno));
    return staged.commit();
}

}  // namespace pliant
