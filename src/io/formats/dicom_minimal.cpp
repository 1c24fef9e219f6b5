// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "formats/dicom_minimal.h"

#include <algorithm>
#include <string>
#include <string_view>

namespace pliant {
namespace {

using namespace dicom_tags;

std::string u16(std::uint32_t value) {
    return {char(value & 0xff), char(value >> 8 & 0xff)};
}
std::string u32(std::uint32_t value) {
    return u16(value & 0xffff) + u16(value >> 16);
}
std::string tag_of(std::uint32_t tag) {
    return u16(tag >> 16) + u16(tag & 0xffff);
}
std::string element(std::uint32_t tag, const char* type, std::string value) {
    if (value.size() % 2) value += std::string_view(type) == "UI" ? '\0' : ' ';
    return tag_of(tag) + type + u16(std::uint32_t(value.size())) + value;
}
std::string number(std::uint32_t tag, int value) {
    return element(tag, "US", u16(std::uint32_t(value)));
}

}  // namespace

void append_minimal_dicom(const DicomSlice& slice, int bits, std::uint32_t codestream_bytes,
                          std::vector<std::uint8_t>& file) {
    constexpr std::uint32_t kMetaLength = 0x00020000, kMetaClass = 0x00020002,
                            kMetaInstance = 0x00020003, kInstance = 0x00080018;
    const std::string sop_class = "1.2.840.10008.5.1.4.1.1.7", instance = "1.2.3";
    const DicomPixels& pixels = slice.pixels;
    const int stored = std::min(pixels.bits_stored, bits);
    const std::string meta = element(kMetaClass, "UI", sop_class) +
                             element(kMetaInstance, "UI", instance) +
                             element(kTransferSyntax, "UI", std::string(pixels.syntax.uid));
    std::string text(128, '\0');
    text += "DICM" + element(kMetaLength, "UL", u32(std::uint32_t(meta.size()))) + meta;
    text += element(kSopClass, "UI", sop_class) + element(kInstance, "UI", instance);
    text += number(kSamples, 1) + element(kPhotometric, "CS", "MONOCHROME2");
    text += number(kRows, slice.rows) + number(kColumns, slice.columns);
    text += number(kBitsAllocated, bits) + number(kBitsStored, stored);
    text += number(kHighBit, stored - 1) + number(kPixelRepresentation, pixels.is_signed);
    text += tag_of(kPixelData) + "OB" + u16(0) + u32(0xffffffff);
    text += tag_of(kItem) + u32(0) + tag_of(kItem) + u32(codestream_bytes);
    file.insert(file.end(), text.begin(), text.end());
}

void append_minimal_end(std::vector<std::uint8_t>& file) {
    const std::string text = tag_of(kSequenceEnd) + u32(0);
    file.insert(file.end(), text.begin(), text.end());
}

}  // namespace pliant
