// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "support/scan_files.h"

#include "base/text.h"

#include <zlib.h>

#include <algorithm>
#include <cstring>
#include <numeric>

namespace pliant::test {
namespace {

std::string deflated(const std::string& bytes, int window_bits) {
    z_stream stream{};
    deflateInit2(&stream, 6, Z_DEFLATED, window_bits, 8, Z_DEFAULT_STRATEGY);
    std::string out(deflateBound(&stream, uLong(bytes.size())) + 64, '\0');
    stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
    stream.avail_in = uInt(bytes.size());
    stream.next_out = reinterpret_cast<Bytef*>(out.data());
    stream.avail_out = uInt(out.size());
    deflate(&stream, Z_FINISH);
    out.resize(stream.total_out);
    deflateEnd(&stream);
    return out;
}

std::string line(const char* name, const char* separator, const std::string& value) {
    return value.empty() ? std::string() : name + std::string(separator) + value + "\n";
}

template <class T>
void put(std::string& header, std::size_t at, T value, bool big_endian) {
    value = little_endian(value);
    char* const bytes = &header[at];
    std::memcpy(bytes, &value, sizeof value);
    if (big_endian) std::reverse(bytes, bytes + sizeof value);
}

/// How the elements of a DICOM file are written.
struct DicomSyntax {
    bool implicit = false, big_endian = false;

    template <class T>
    std::string number(T value) const {
        const std::string bytes = packed<T>({value});
        return big_endian ? swapped(bytes, sizeof(T)) : bytes;
    }
    /// A data element; values have even length.
    std::string element(std::uint16_t group, std::uint16_t name, const std::string& vr,
                        std::string value) const {
        if (value.size() % 2) value += vr == "UI" ? '\0' : ' ';
        return start(group, name, vr, std::uint32_t(value.size())) + value;
    }
    std::string start(std::uint16_t group, std::uint16_t name, const std::string& vr,
                      std::uint32_t length) const {
        const std::string tag = number(group) + number(name);
        if (implicit || group == 0xfffe) return tag + number(length);
        if (std::string("OW OB OF OD SQ UN").find(vr) != std::string::npos)
            return tag + vr + std::string(2, '\0') + number(length);
        return tag + vr + number(std::uint16_t(length));
    }
    /// Pixel Data: an empty table of offsets, and an item for each fragment.
    std::string fragments(const std::vector<std::string>& parts) const {
        std::string bytes = start(0x7fe0, 0x0010, "OB", 0xffffffff);
        bytes += start(0xfffe, 0xe000, "", 0);
        for (const std::string& part : parts) {
            bytes += start(0xfffe, 0xe000, "", std::uint32_t(part.size() + part.size() % 2));
            bytes += part + std::string(part.size() % 2, '\0');
        }
        return bytes + start(0xfffe, 0xe0dd, "", 0);
    }
};

template <class Numbers>
std::string decimals(const Numbers& numbers) {
    std::string text;
    for (const double number : numbers) text += (text.empty() ? "" : "\\") + text_of(number);
    return text;
}

}  // namespace

std::string swapped(std::string bytes, std::size_t size) {
    for (std::size_t at = 0; at + size <= bytes.size(); at += size)
        std::reverse(&bytes[at], &bytes[at] + size);
    return bytes;
}

std::string gzipped(const std::string& bytes) {
    return deflated(bytes, 15 + 16);
}

std::string zlibbed(const std::string& bytes) {
    return deflated(bytes, 15);
}

std::vector<std::int16_t> small_values() {
    std::vector<std::int16_t> values(24);
    std::iota(values.begin(), values.end(), std::int16_t(-100));
    return values;
}

std::string NrrdFile::bytes() const {
    return "NRRD0004\n# a comment\n" + line("type", ": ", type) +
           line("dimension", ": ", dimension) + line("space", ": ", space) +
           line("sizes", ": ", sizes) + line("space directions", ": ", directions) +
           line("kinds", ": ", kinds) + line("endian", ": ", endian) +
           line("encoding", ": ", encoding) + line("space origin", ": ", origin) + extra +
           (blank_line ? "\n" + data : "");
}

std::string MetaFile::bytes() const {
    return "ObjectType = Image\nNDims = " + dimension +
           "\nBinaryData = True\nBinaryDataByteOrderMSB = False\n" +
           line("TransformMatrix", " = ", matrix) + line("Offset", " = ", offset) +
           line("ElementSpacing", " = ", spacing) + line("DimSize", " = ", sizes) + extra +
           line("ElementType", " = ", type) + line("ElementDataFile", " = ", data_file) + data;
}

std::string NiftiFile::bytes() const {
    std::string header(352, '\0');
    put(header, 0, header_size, big_endian);
    for (std::size_t n = 0; n < 8; ++n) {
        put(header, 40 + 2 * n, dim[n], big_endian);
        put(header, 76 + 4 * n, pixdim[n], big_endian);
    }
    put(header, 70, datatype, big_endian);
    put(header, 72, bitpix, big_endian);
    put(header, 108, vox_offset, big_endian);
    put(header, 112, slope, big_endian);
    put(header, 116, intercept, big_endian);
    header[123] = units;
    put(header, 252, qform_code, big_endian);
    put(header, 254, sform_code, big_endian);
    for (std::size_t n = 0; n < 6; ++n) put(header, 256 + 4 * n, qform[n], big_endian);
    for (std::size_t n = 0; n < 12; ++n) put(header, 280 + 4 * n, sform[n], big_endian);
    header.replace(344, magic.size(), magic);
    return header + data;
}

std::string DicomFile::bytes() const {
    const std::string written = !syntax.empty() ? syntax
                                : implicit      ? "1.2.840.10008.1.2"
                                                : "1.2.840.10008.1.2.1";
    const std::string own = series + "." + std::to_string(long(10000 + 100 * position[2]));
    const std::string uid = instance.empty() ? own : instance;
    const DicomSyntax plain, body{written == "1.2.840.10008.1.2", written == "1.2.840.10008.1.2.2"};
    const std::string meta = plain.element(2, 0x0002, "UI", sop_class) +
                             plain.element(2, 0x0003, "UI", uid) +
                             plain.element(2, 0x0010, "UI", written);
    std::string bytes(128, '\0');
    bytes += "DICM" +
             plain.element(2, 0, "UL", packed<std::uint32_t>({std::uint32_t(meta.size())})) + meta;
    const auto add = [&](std::uint16_t group, std::uint16_t number, const char* vr,
                         const std::string& value) {
        bytes += body.element(group, number, unknown_types && group < 0x7fe0 ? "UN" : vr, value);
    };
    const auto add_number = [&](std::uint16_t number, std::uint16_t value) {
        add(0x28, number, "US", body.number(value));
    };
    if (!image_type.empty()) add(0x08, 0x0008, "CS", image_type);
    add(0x08, 0x0016, "UI", sop_class);
    add(0x08, 0x0018, "UI", uid);
    if (!modality.empty()) add(0x08, 0x0060, "CS", modality);
    add(0x08, 0x103e, "LO", description);
    add(0x18, 0x0050, "DS", "17");  // slice thickness: not to be trusted
    add(0x20, 0x000e, "UI", series);
    if (!series_number.empty()) add(0x20, 0x0011, "IS", series_number);
    if (!instance_number.empty()) add(0x20, 0x0013, "IS", instance_number);
    if (with_position) add(0x20, 0x0032, "DS", decimals(position));
    if (with_orientation) add(0x20, 0x0037, "DS", decimals(orientation));
    if (!time.empty()) add(0x20, 0x0100, "IS", time);
    add_number(0x0002, samples);
    add(0x28, 0x0004, "CS",
        !photometric.empty() ? photometric
        : samples == 3       ? "RGB"
                             : "MONOCHROME2");
    if (!frames.empty()) add(0x28, 0x0008, "IS", frames);
    add_number(0x0010, rows);
    add_number(0x0011, columns);
    add(0x28, 0x0030, "DS", decimals(spacing));
    add_number(0x0100, bits_allocated);
    add_number(0x0101, bits_stored);
    add_number(0x0102, high_bit);
    if (with_sign) add_number(0x0103, is_signed);
    if (!level.empty()) add(0x28, 0x1050, "DS", level);
    if (!window.empty()) add(0x28, 0x1051, "DS", window);
    add(0x28, 0x1052, "DS", intercept);
    add(0x28, 0x1053, "DS", slope);
    if (!rescale_type.empty()) add(0x28, 0x1054, "LO", rescale_type);
    bytes += more;
    if (!fragments.empty())
        bytes += body.fragments(fragments);
    else
        add(0x7fe0, pixel_element, pixel_type.c_str(), !raw.empty() ? raw : packed(pixels));
    return bytes;
}

}  // namespace pliant::test
