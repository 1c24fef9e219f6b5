// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// PNG files; the only user of libpng. Its simplified interface handles the long jumps internally
// and returns errors as text.

#include <pliant/core/files.h>
#include <pliant/core/output_file.h>
#include <pliant/view/png.h>
#include <png.h>

#include <string>
#include <string_view>

namespace pliant {
namespace {

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
    return attempt([&]() -> Status {
        StagedFiles staged;
        const auto temporary = staged.stage(path);
        if (!temporary) return temporary.error();

        png_image png{};
        png.version = PNG_IMAGE_VERSION;
        png.width = png_uint_32(image.width);
        png.height = png_uint_32(image.height);
        png.format = PNG_FORMAT_RGB;
        static_assert(sizeof(Rgb8) == 3);
        // In memory, because libpng doesn't tell why a file can't be written.
        png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(png);
        std::string bytes(size, '\0');
        if (!png_image_write_to_memory(&png, bytes.data(), &size, 0, image.pixels.data(), 0,
                                       nullptr))
            return unwritable(path, std::string("can't be written: ") + png.message);
        OutputFile file(*temporary, path.string());
        file.write(std::string_view(bytes).substr(0, size));
        if (Status s = file.close(); !s) return s;
        return staged.commit();
    });
}

}  // namespace pliant
