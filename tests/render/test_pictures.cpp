// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Covers: render/canvas.cpp, render/font.cpp, render/four_up.cpp, pictures/png.cpp,
// render/section.cpp.

#include <gtest/gtest.h>
#include <pliant/render.h>
#include <pliant/view/png.h>
#include <png.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "base/hash.h"
#include "render/analytic_volumes.h"
#include "render/font.h"
#include "render/section.h"

namespace pliant {
namespace {

namespace fs = std::filesystem;
using test::make_volume;
using test::odd_grid;
using test::plain_grid;

Rgb8 pixel(const Image& image, int x, int y) {
    return image.pixels[std::size_t(y) * std::size_t(image.width) + std::size_t(x)];
}

class TemporaryFolder {
  public:
    TemporaryFolder() {
        static int counter = 0;
        m_path = fs::temp_directory_path() /
                 ("pliant-test-" + std::to_string(::getpid()) + "-" + std::to_string(counter++));
        fs::create_directories(m_path);
    }
    ~TemporaryFolder() {
        std::error_code ignored;
        fs::remove_all(m_path, ignored);
    }
    const fs::path& path() const { return m_path; }

  private:
    fs::path m_path;
};

Section section_at(Orientation orientation, Vec3d point_mm, double width_mm = 0) {
    Section s;
    s.orientation = orientation;
    s.point_mm = point_mm;
    s.width_mm = width_mm;
    s.crosshair = false;
    s.window_hu = 255;
    s.level_hu = 127.5;
    return s;
}

constexpr Orientation kAll[] = {Orientation::Axial, Orientation::Coronal, Orientation::Sagittal};

TEST(SectionView, FollowsTheRadiologicalConvention) {
    TaskArena arena(2);
    // Bright towards one side of the patient at a time; compared at a quarter and three quarters.
    const auto shows = [&](Vec3d towards, Orientation o, int x_bright, int y_bright) {
        const Volume volume = make_volume<float>(plain_grid({60, 60, 60}), [&](Vec3d p) {
            return 128 + 4 * dot(p - Vec3d{30, 30, 30}, towards);
        });
        const Image image = section_view(volume, section_at(o, {30, 30, 30}), 100, 100, arena);
        return pixel(image, 50 + 20 * x_bright, 50 + 20 * y_bright).r >
               pixel(image, 50 - 20 * x_bright, 50 - 20 * y_bright).r + 50;
    };
    const Vec3d left{1, 0, 0}, posterior{0, 1, 0}, superior{0, 0, 1};
    EXPECT_TRUE(shows(left, Orientation::Axial, 1, 0));
    EXPECT_TRUE(shows(posterior, Orientation::Axial, 0, 1));
    EXPECT_TRUE(shows(left, Orientation::Coronal, 1, 0));
    EXPECT_TRUE(shows(superior, Orientation::Coronal, 0, -1));
    EXPECT_TRUE(shows(posterior, Orientation::Sagittal, 1, 0));
    EXPECT_TRUE(shows(superior, Orientation::Sagittal, 0, -1));
}

TEST(SectionView, LettersNameTheSidesThatTheVolumeShows) {
    for (Orientation o : kAll) {
        const render::SectionStyle style = render::section_style(o);
        const std::string letters = style.letters;
        const auto letter = [](Vec3d towards) {  // of LPS directions
            if (towards.x != 0) return towards.x > 0 ? 'L' : 'R';
            if (towards.y != 0) return towards.y > 0 ? 'P' : 'A';
            return towards.z > 0 ? 'S' : 'I';
        };
        EXPECT_EQ(letters[0], letter(-style.right));
        EXPECT_EQ(letters[1], letter(style.right));
        EXPECT_EQ(letters[2], letter(style.up));
        EXPECT_EQ(letters[3], letter(-style.up));
    }
}

TEST(SectionView, DrawsTheLetterLOnTheRightAndROnTheLeft) {
    TaskArena arena(1);
    const Volume black = make_volume<float>(plain_grid({50, 50, 50}), [](Vec3d) { return -1000; });
    Section s = section_at(Orientation::Axial, {25, 25, 25});
    const Image image = section_view(black, s, 300, 300, arena);
    const int scale = render::text_scale(300), margin = 3 * scale;
    const auto reads = [&](char c, int x0, int y0) {
        for (int row = 0; row < render::kGlyphHeight; ++row)
            for (int column = 0; column < render::kGlyphColumns; ++column) {
                const bool lit = pixel(image, x0 + column * scale, y0 + row * scale).r > 128;
                if (lit != render::glyph_dot(c, column, row)) return false;
            }
        return true;
    };
    const int wide = render::kGlyphColumns * scale, high = render::kGlyphHeight * scale;
    EXPECT_TRUE(reads('R', margin, (300 - high) / 2));
    EXPECT_TRUE(reads('L', 300 - margin - wide, (300 - high) / 2));
    EXPECT_TRUE(reads('A', (300 - wide) / 2, margin));
    EXPECT_TRUE(reads('P', (300 - wide) / 2, 300 - margin - high));
    EXPECT_FALSE(reads('R', 300 - margin - wide, (300 - high) / 2));
}

TEST(SectionView, OfAnObliqueVolumeEqualsTheFieldItSamples) {
    TaskArena arena(2);
    const Grid grid = odd_grid({60, 50, 40});
    const Vec3d centre = test::centre_mm(grid), slope{2.0, -1.5, 1.0};
    const auto value = [&](Vec3d p) { return 127.5 + dot(p - centre, slope); };
    const Volume volume = make_volume<float>(grid, value);
    for (Orientation o : kAll) {
        const Section s = section_at(o, centre + Vec3d{1, 2, 3}, 30);
        const Image image = section_view(volume, s, 200, 160, arena);
        const render::SectionPlane plane(grid, s, 200, 160);
        EXPECT_NEAR(plane.mm_per_pixel(), 0.15, 1e-12);
        for (int y = 30; y < 130; y += 7)  // away from the letters
            for (int x = 30; x < 170; x += 7) {
                const Vec3d p = plane.world_from_picture(x + 0.5, y + 0.5);
                EXPECT_NEAR(pixel(image, x, y).g, value(p), 0.51);
            }
    }
}

TEST(SectionView, KeepsTheAspectInMillimetresAndIsBlackOutside) {
    TaskArena arena(1);
    const Volume volume =
        make_volume<std::int16_t>(plain_grid({40, 20, 10}, {1, 1, 4}), [](Vec3d) { return 255; });
    // 40 mm × 40 mm of 40 × 10 voxels: the coronal section fills a square picture.
    const Image coronal =
        section_view(volume, section_at(Orientation::Coronal, {20, 10, 18}), 120, 120, arena);
    EXPECT_EQ(pixel(coronal, 30, 1).r, 255);
    EXPECT_EQ(pixel(coronal, 30, 118).r, 255);
    // The axial one is 40 mm × 20 mm: a quarter of the picture above and below is empty.
    const Image axial =
        section_view(volume, section_at(Orientation::Axial, {20, 10, 18}), 120, 120, arena);
    EXPECT_EQ(pixel(axial, 30, 28).r, 0);
    EXPECT_EQ(pixel(axial, 30, 32).r, 255);
    EXPECT_EQ(pixel(axial, 30, 87).r, 255);
    EXPECT_EQ(pixel(axial, 30, 92).r, 0);
    const Image beyond =
        section_view(volume, section_at(Orientation::Axial, {20, 10, 90}), 120, 120, arena);
    EXPECT_EQ(pixel(beyond, 30, 60).r, 0);
}

TEST(SectionView, MapsTheWindowToBlackAndWhite) {
    TaskArena arena(1);
    const Volume volume = make_volume<float>(plain_grid({30, 30, 3}), [](Vec3d) { return 50; });
    Section s = section_at(Orientation::Axial, {15, 15, 1});
    const auto grey = [&](double window, double level) {
        s.window_hu = window;
        s.level_hu = level;
        return int(pixel(section_view(volume, s, 60, 60, arena), 40, 40).r);
    };
    EXPECT_EQ(grey(100, 50), 128);
    EXPECT_EQ(grey(100, 0), 255);
    EXPECT_EQ(grey(100, 100), 0);
    EXPECT_EQ(grey(400, 100), 96);
}

TEST(SectionView, PutsTheCrosshairAtThePointWithAGapInTheMiddle) {
    TaskArena arena(1);
    const Volume volume = make_volume<float>(plain_grid({50, 50, 50}), [](Vec3d) { return -1000; });
    const Vec3d point{12.2, 33.1, 40.7};
    for (Orientation o : kAll) {
        Section s = section_at(o, point);
        s.crosshair = true;
        const Image image = section_view(volume, s, 250, 250, arena);  // 5 pixels a millimetre
        const bool axial = o == Orientation::Axial, sagittal = o == Orientation::Sagittal;
        const int x = int(std::floor(((sagittal ? point.y : point.x) + 0.5) * 5));
        const int y = int(std::floor(axial ? (point.y + 0.5) * 5 : (49.5 - point.z) * 5));
        const render::SectionStyle style = render::section_style(o);
        const auto like = [](Rgb8 drawn, Rgb8 colour) {  // 3/4 of it over black
            return std::abs(drawn.r - 0.75 * colour.r) < 1 &&
                   std::abs(drawn.g - 0.75 * colour.g) < 1 &&
                   std::abs(drawn.b - 0.75 * colour.b) < 1;
        };
        EXPECT_TRUE(like(pixel(image, x, y - 30), style.vertical));
        EXPECT_TRUE(like(pixel(image, x - 30, y), style.horizontal));
        EXPECT_EQ(pixel(image, x, y), (Rgb8{0, 0, 0}));
        EXPECT_EQ(pixel(image, x + 3, y), (Rgb8{0, 0, 0}));
        EXPECT_EQ(pixel(image, x - 30, y - 3), (Rgb8{0, 0, 0}));
    }
}

TEST(FourUpView, PutsEachViewInItsQuarter) {
    TaskArena arena(2);
    const Volume volume = make_volume<std::int16_t>(plain_grid({40, 40, 40}), [](Vec3d p) {
        return test::tube_hu(p, {20, 20, 20}, {0, 0, 1}, 8);
    });
    FourUp f;
    f.endoscope.eye_mm = {20, 20, 30};
    f.endoscope.look = {0, 0.3, -1};
    f.section.point_mm = {20, 20, 20};
    const int n = 402, half = 200;
    const Image all = four_up_view(volume, f, n, n, arena);
    ASSERT_EQ(all.width, n);
    ASSERT_EQ(all.height, n);
    Section s = f.section;
    const Image alone[3] = {
        (s.orientation = Orientation::Axial, section_view(volume, s, half + 1, half, arena)),
        (s.orientation = Orientation::Coronal, section_view(volume, s, half, half + 1, arena)),
        (s.orientation = Orientation::Sagittal,
         section_view(volume, s, half + 1, half + 1, arena))};
    const Image view = RayCaster(volume, arena).endoscope_view(f.endoscope, half, half);
    for (int y = 40; y < 160; y += 3)
        for (int x = 5; x < half - 5; x += 3) {
            EXPECT_EQ(pixel(all, x, y), pixel(view, x, y));
            EXPECT_EQ(pixel(all, x + half + 1, y), pixel(alone[0], x, y));
            EXPECT_EQ(pixel(all, x, y + half + 1), pixel(alone[1], x, y));
            EXPECT_EQ(pixel(all, x + half + 1, y + half + 1), pixel(alone[2], x, y));
        }
    EXPECT_EQ(pixel(all, half, 57), pixel(all, 57, half));  // separators
    f.caption = "push 6 mm → ok";
    const Image named = four_up_view(volume, f, n, n, arena);
    EXPECT_NE(named.pixels, all.pixels);
}

TEST(FourUpView, SurvivesTinyPictures) {
    TaskArena arena(1);
    const Volume volume = make_volume<float>(plain_grid({4, 4, 4}), [](Vec3d p) { return p.x; });
    EXPECT_EQ(four_up_view(volume, {}, 16, 16, arena).pixels.size(), 256u);
    EXPECT_EQ(section_view(volume, {}, 1, 1, arena).pixels.size(), 1u);
}

TEST(SideBySide, KeepsBothPictures) {
    const Image a = render::make_image(5, 7, {1, 2, 3}), b = render::make_image(6, 7, {4, 5, 6});
    const Image both = side_by_side(a, b);
    EXPECT_EQ(both.height, 7);
    EXPECT_EQ(both.width, 5 + 2 + 6);
    EXPECT_EQ(pixel(both, 4, 6), (Rgb8{1, 2, 3}));
    EXPECT_EQ(pixel(both, 7, 0), (Rgb8{4, 5, 6}));
}

TEST(SectionView, IsTheSameForAnyThreadCount) {
    const Volume volume = make_volume<float>(odd_grid({40, 30, 20}), [](Vec3d p) {
        return 300 * std::sin(p.x * 0.4) * std::cos(p.y * 0.3 + p.z);
    });
    std::uint64_t expected = 0;
    for (int threads : {1, 2, 4}) {
        TaskArena arena(threads);
        Hash64 hash;
        const Image image = section_view(
            volume, section_at(Orientation::Coronal, test::centre_mm(volume.grid)), 201, 99, arena);
        hash.add(std::span<const Rgb8>(image.pixels));
        if (threads == 1) expected = hash.value();
        EXPECT_EQ(hash.value(), expected);
    }
}

TEST(Font, HasADifferentShapeForEveryCharacter) {
    std::vector<std::string> shapes;
    for (char c = ' '; c <= '~'; ++c) {
        std::string shape;
        for (int i = 0; i < render::kGlyphRows * render::kGlyphColumns; ++i)
            shape += render::glyph_dot(c, i % render::kGlyphColumns, i / render::kGlyphColumns)
                         ? '#'
                         : '.';
        for (const std::string& other : shapes) EXPECT_NE(shape, other) << c;
        shapes.push_back(shape);
    }
    EXPECT_EQ(shapes[0].find('#'), std::string::npos);
}

TEST(WritePng, ReadsBackEqual) {
    TemporaryFolder folder;
    Image image = render::make_image(37, 21, {0, 0, 0});
    for (std::size_t i = 0; i < image.pixels.size(); ++i)
        image.pixels[i] = {std::uint8_t(i * 7), std::uint8_t(i * 13 + 5), std::uint8_t(i / 3)};
    const fs::path path = folder.path() / "picture.png";
    ASSERT_TRUE(write_png(path, image));
    png_image png{};
    png.version = PNG_IMAGE_VERSION;
    ASSERT_TRUE(png_image_begin_read_from_file(&png, path.c_str()));
    png.format = PNG_FORMAT_RGB;
    EXPECT_EQ(png.width, 37u);
    EXPECT_EQ(png.height, 21u);
    std::vector<Rgb8> pixels(37 * 21);
    ASSERT_TRUE(png_image_finish_read(&png, nullptr, pixels.data(), 0, nullptr));
    EXPECT_EQ(pixels, image.pixels);
    EXPECT_EQ(std::distance(fs::directory_iterator(folder.path()), fs::directory_iterator()), 1);
}

TEST(WritePng, NamesTheFileThatCannotBeWrittenAndTouchesNothing) {
    TemporaryFolder folder;
    const Image image = render::make_image(4, 4, {1, 2, 3});
    const auto missing = write_png(folder.path() / "missing" / "a.png", image);
    ASSERT_FALSE(missing);
    EXPECT_EQ(missing.error().code, ErrorCode::Unwritable);
    EXPECT_NE(missing.error().message.find("a.png"), std::string::npos);
    EXPECT_EQ(missing.error().message.find('\n'), std::string::npos);

    const fs::path kept = folder.path() / "kept.png";
    std::ofstream(kept) << "before";
    const auto broken = write_png(kept, Image{4, 4, {}});
    ASSERT_FALSE(broken);
    EXPECT_EQ(broken.error().code, ErrorCode::InvalidArgument);
    std::string text;
    std::ifstream(kept) >> text;
    EXPECT_EQ(text, "before");
}

}  // namespace
}  // namespace pliant
