// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Seeds: DICOM series of three slices. Damaged are the same element of every slice, the pixel data
// of one slice, the transfer syntax, or any bytes of one file.

#include <array>

#include "mutate/formats.h"
#include "support/scan_files.h"

namespace pliant::mutate {
namespace {

using test::packed;

constexpr int kSlices = 3;
const std::string kImplicit = "1.2.840.10008.1.2", kExplicit = "1.2.840.10008.1.2.1",
                  kBigEndian = "1.2.840.10008.1.2.2", kRle = "1.2.840.10008.1.2.5",
                  kJpeg = "1.2.840.10008.1.2.4.70", kJpegLs = "1.2.840.10008.1.2.4.80",
                  kJpeg2000 = "1.2.840.10008.1.2.4.90";

struct Element {
    std::uint16_t group, number;
    std::string vr, value;  ///< numbers little-endian
};

struct Slice {
    std::string syntax;  ///< transfer syntax
    std::vector<Element> elements;
    std::string pixels;  ///< little-endian words, or one fragment
};

bool is_encapsulated(const std::string& syntax) {
    return syntax != kImplicit && syntax != kExplicit && syntax != kBigEndian;
}

std::string encoded(const Element& e, bool implicit, bool big, bool endless = false) {
    std::string value = e.value;
    if (value.size() % 2) value += e.vr == "UI" ? '\0' : ' ';
    if (big && (e.vr == "US" || e.vr == "OW")) value = test::swapped(value, 2);
    const auto word = [&](std::uint16_t number) {
        const std::string bytes = packed<std::uint16_t>({number});
        return big ? test::swapped(bytes, 2) : bytes;
    };
    const auto long_word = [&](std::uint32_t number) {
        const std::string bytes = packed<std::uint32_t>({number});
        return big ? test::swapped(bytes, 4) : bytes;
    };
    const std::uint32_t length = endless ? 0xffffffff : std::uint32_t(value.size());
    const std::string tag = word(e.group) + word(e.number);
    if (implicit) return tag + long_word(length) + value;
    if (e.vr == "OW" || e.vr == "OB") return tag + e.vr + word(0) + long_word(length) + value;
    return tag + e.vr + word(std::uint16_t(value.size())) + value;
}

std::string item(std::uint16_t number, const std::string& bytes) {
    return packed<std::uint16_t>({0xfffe, number}) +
           packed<std::uint32_t>({std::uint32_t(bytes.size())}) + bytes;
}

std::string bytes_of(const Slice& slice) {
    const bool implicit = slice.syntax == kImplicit, big = slice.syntax == kBigEndian;
    std::string meta, bytes(128, '\0');
    meta += encoded({2, 0x0002, "UI", "1.2.840.10008.5.1.4.1.1.2"}, false, false);
    meta += encoded({2, 0x0003, "UI", "1.2.3.4"}, false, false);
    meta += encoded({2, 0x0010, "UI", slice.syntax}, false, false);
    const std::string length = packed<std::uint32_t>({std::uint32_t(meta.size())});
    bytes += "DICM" + encoded({2, 0, "UL", length}, false, false) + meta;
    for (const Element& e : slice.elements) bytes += encoded(e, implicit, big);
    if (!is_encapsulated(slice.syntax))
        return bytes + encoded({0x7fe0, 0x0010, "OW", slice.pixels}, implicit, big);
    std::string fragment = slice.pixels;
    if (fragment.size() % 2) fragment += '\0';
    return bytes + encoded({0x7fe0, 0x0010, "OB", ""}, false, false, true) + item(0xe000, "") +
           item(0xe000, fragment) + item(0xe0dd, "");
}

std::vector<Slice> series(const std::string& syntax, const std::string& pixels, int side) {
    const auto number = [](int value) { return packed<std::uint16_t>({std::uint16_t(value)}); };
    std::vector<Slice> slices;
    for (int n = 0; n < kSlices; ++n) {
        const std::string at = std::to_string(2 * n);
        slices.push_back({.syntax = syntax,
                          .elements = {{0x08, 0x0016, "UI", "1.2.840.10008.5.1.4.1.1.2"},
                                       {0x08, 0x0018, "UI", "1.2.3.4." + std::to_string(n + 1)},
                                       {0x08, 0x0060, "CS", "CT"},
                                       {0x08, 0x103e, "LO", "a series"},
                                       {0x18, 0x0050, "DS", "2"},
                                       {0x20, 0x000d, "UI", "1.2.3"},
                                       {0x20, 0x000e, "UI", "1.2.3.4"},
                                       {0x20, 0x0013, "IS", std::to_string(n)},
                                       {0x20, 0x0032, "DS", "-6\\-6\\" + at},
                                       {0x20, 0x0037, "DS", "1\\0\\0\\0\\1\\0"},
                                       {0x28, 0x0002, "US", number(1)},
                                       {0x28, 0x0004, "CS", "MONOCHROME2"},
                                       {0x28, 0x0010, "US", number(side)},
                                       {0x28, 0x0011, "US", number(side)},
                                       {0x28, 0x0030, "DS", "1\\1"},
                                       {0x28, 0x0100, "US", number(16)},
                                       {0x28, 0x0101, "US", number(16)},
                                       {0x28, 0x0102, "US", number(15)},
                                       {0x28, 0x0103, "US", number(1)},
                                       {0x28, 0x1052, "DS", "-1000"},
                                       {0x28, 0x1053, "DS", "1"}},
                          .pixels = pixels});
    }
    return slices;
}

Files files_of(const std::vector<Slice>& slices) {
    Files files;
    for (std::size_t n = 0; n < slices.size(); ++n)
        files.push_back({.name = "s/" + std::to_string(n) + ".dcm", .bytes = bytes_of(slices[n])});
    return files;
}

const Words kDicomWords = {"MONOCHROME1",
                           "PALETTE COLOR",
                           "RGB",
                           "YBR_FULL",
                           "ARGB",
                           "CT",
                           "MR",
                           "1.2.840.10008.5.1.4.1.1.2.1",
                           "1\\0\\0\\0\\1\\0",
                           "\\",
                           "SQ",
                           "UN",
                           "OB"};

void change_value(Element& e, Random& random) {
    static const std::vector<int> sizes = {0,   1,   2,   3,    4,    7,     8,     11,
                                           12,  13,  15,  16,   17,   24,    32,    64,
                                           128, 255, 256, 1000, 4096, 32767, 32768, 65535};
    if (e.vr == "US")
        e.value = packed<std::uint16_t>({std::uint16_t(any_of(sizes, random))});
    else if (e.vr == "CS" || random.whole(0, 2) == 0)
        e.value = any_of(kDicomWords, random);
    else
        mutate(e.value, 0, kDicomWords, random);
}

/// Mostly one of the image, which is where readers and decoders differ.
std::size_t some_element(const std::vector<Element>& all, Random& random) {
    std::size_t at = 0;
    do at = std::size_t(random.whole(0, int(all.size()) - 1));
    while (all[at].group != 0x28 && random.whole(0, 3) > 0);
    return at;
}

/// The same in all slices, so that they still make a series.
void change_headers(std::vector<Slice>& slices, Random& random) {
    const std::size_t at = some_element(slices[0].elements, random);
    const int what = random.whole(0, 9);
    Element changed = slices[0].elements[at];
    change_value(changed, random);
    static const std::vector<Element> more = {{0x28, 0x0006, "US", {}}, {0x28, 0x0008, "IS", {}},
                                              {0x28, 0x0009, "IS", {}}, {0x28, 0x0120, "US", {}},
                                              {0x28, 0x0034, "IS", {}}, {0x28, 0x1101, "US", {}}};
    Element added = any_of(more, random);
    change_value(added, random);
    static const std::vector<std::string> syntaxes = {kImplicit,
                                                      kExplicit,
                                                      kBigEndian,
                                                      kRle,
                                                      kJpeg,
                                                      kJpegLs,
                                                      kJpeg2000,
                                                      "1.2.840.10008.1.2.1.99",
                                                      "1.2.840.10008.1.2.4.50",
                                                      "1.2.840.10008.1.2.4.91",
                                                      "1.2",
                                                      ""};
    const std::string& syntax = any_of(syntaxes, random);
    for (Slice& slice : slices) {
        std::vector<Element>& all = slice.elements;
        if (what == 0)
            all.erase(all.begin() + std::ptrdiff_t(at));
        else if (what == 1)
            all.insert(all.begin() + std::ptrdiff_t(at), all[at]);
        else if (what == 2)
            slice.syntax = syntax;
        else if (what == 3)
            all.insert(all.begin() + 11, added);
        else
            all[at].value = changed.value;
    }
}

Files damaged_series(std::vector<Slice> slices, Random& random) {
    const int what = random.whole(0, 5);
    const auto one = std::size_t(random.whole(0, kSlices - 1));
    if (what < 3) {
        for (int n = random.whole(1, 2); n > 0; --n) change_headers(slices, random);
    } else if (what < 5 && is_encapsulated(slices[0].syntax)) {
        mutate(slices[one].pixels, 0, {}, random);
    }
    Files files = files_of(slices);
    if (what == 5 || (what > 2 && !is_encapsulated(slices[0].syntax)))
        mutate(files[one].bytes, files[one].bytes.size() - slices[one].pixels.size(), kDicomWords,
               random);
    return files;
}

Seed seed_of(const std::string& name, const std::vector<Slice>& slices) {
    return {.name = name,
            .files = files_of(slices),
            .commands = {"info s --json", "info s",
                         "deform s --push 0,0,2:1,0,0 --tool sphere:3 --threads 1 --out out.nrrd"},
            .damaged = [slices](Random& random) { return damaged_series(slices, random); }};
}

Format compressed(const Sources& from, const std::string& name, const std::string& syntax) {
    const std::string pixels = corpus_bytes(from.corpus / name);
    return {.name = name, .words = {}, .seeds = {seed_of(name, series(syntax, pixels, 12))}};
}

}  // namespace

Seed two_series() {
    std::vector<Slice> slices = series(kExplicit, packed(std::vector<std::int16_t>(36, 1000)), 6);
    for (Element& e : slices.back().elements)
        if (e.group == 0x20 && e.number == 0x000e) e.value = "1.2.3.5";
    return seed_of("two_series", slices);
}

Format dicom(const Sources&) {
    const std::string pixels = packed(std::vector<std::int16_t>(36, 1000));
    return {.name = "dicom",
            .words = {},
            .seeds = {seed_of("explicit", series(kExplicit, pixels, 6)),
                      seed_of("implicit", series(kImplicit, pixels, 6)),
                      seed_of("big_endian", series(kBigEndian, pixels, 6))}};
}

Format dicom_rle(const Sources& from) {
    return compressed(from, "dicom_rle", kRle);
}

Format dicom_jpeg(const Sources& from) {
    return compressed(from, "dicom_jpeg", kJpeg);
}

Format dicom_jpegls(const Sources& from) {
    return compressed(from, "dicom_jpegls", kJpegLs);
}

Format dicom_j2k(const Sources& from) {
    return compressed(from, "dicom_j2k", kJpeg2000);
}

}  // namespace pliant::mutate
