// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Small scan files, written byte by byte without a library; valid unless a field is changed.

#pragma once

#include "base/byte_order.h"

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace pliant::test {

/// Little-endian bytes of numbers.
template <class T>
std::string packed(const std::vector<T>& values) {
    std::vector<T> ordered;
    for (const T value : values) ordered.push_back(little_endian(value));
    return {reinterpret_cast<const char*>(ordered.data()), ordered.size() * sizeof(T)};
}
/// The same in the other byte order.
std::string swapped(std::string bytes, std::size_t size);
std::string gzipped(const std::string& bytes);
std::string zlibbed(const std::string& bytes);

/// 4 × 3 × 2 voxels: −100, −99, …
std::vector<std::int16_t> small_values();

struct NrrdFile {
    std::string type = "short", dimension = "3", space = "left-posterior-superior";
    std::string sizes = "4 3 2", directions = "(1,0,0) (0,1,0) (0,0,2)";
    std::string kinds = "domain domain domain", endian = "little", encoding = "raw";
    std::string origin = "(10,20,30)";
    std::string extra = {};  ///< whole lines
    std::string data = packed(small_values());
    bool blank_line = true;

    std::string bytes() const;
};

struct MetaFile {
    std::string dimension = "3", sizes = "4 3 2", spacing = "1 1 2", offset = "10 20 30";
    std::string matrix = "1 0 0 0 1 0 0 0 1", type = "MET_SHORT", data_file = "LOCAL";
    std::string extra = {};  ///< whole lines
    std::string data = packed(small_values());

    std::string bytes() const;
};

struct NiftiFile {
    std::array<std::int16_t, 8> dim = {3, 4, 3, 2, 1, 1, 1, 1};
    std::int16_t datatype = 4, bitpix = 16;
    std::array<float, 8> pixdim = {1, 1, 1, 2, 0, 0, 0, 0};
    float vox_offset = 352, slope = 0, intercept = 0;
    char units = 2;
    std::int16_t qform_code = 0, sform_code = 1;
    std::array<float, 6> qform = {0, 0, 0, 0, 0, 0};  ///< quaternion b, c, d; offset
    std::array<float, 12> sform = {1, 0, 0, 10, 0, 1, 0, 20, 0, 0, 2, 30};  ///< by rows
    std::int32_t header_size = 348;
    std::string magic = "n+1";
    std::string data = packed(small_values());
    bool big_endian = false;  ///< the header; the data are as given

    std::string bytes() const;
};

/// One slice: explicit or implicit VR, little or big endian, or a codestream.
struct DicomFile {
    std::string series = "1.2.3", description = "a series";
    std::string instance = {};  ///< SOP Instance UID; empty: by series and position
    // Empty: no such element.
    std::string series_number = {}, instance_number = {}, time = {}, image_type = {};
    std::array<double, 3> position = {0, 0, 0};
    std::array<double, 6> orientation = {1, 0, 0, 0, 1, 0};
    std::array<double, 2> spacing = {0.5, 0.25};  ///< between rows, between columns
    std::uint16_t rows = 3, columns = 4, samples = 1;
    std::string frames = {}, slope = "1", intercept = "-1000";
    std::string modality = "CT", rescale_type = {};  ///< empty: no such element
    std::string window = {}, level = {};             ///< Window Width and Center; the same
    std::uint16_t bits_allocated = 16, bits_stored = 16, high_bit = 15, is_signed = 1;
    bool with_position = true, with_orientation = true, with_sign = true;
    bool implicit = false;
    std::uint16_t pixel_element = 0x0010;  ///< 8: floats, 9: doubles
    bool unknown_types = false;  ///< VR UN, as converters write elements of implicit files
    std::string sop_class = "1.2.840.10008.5.1.4.1.1.2";  ///< CT
    std::string photometric = {};   ///< empty: as the number of samples suggests
    std::string syntax = {};        ///< UID of the transfer syntax; empty: as `implicit` says
    std::string more = {};          ///< elements between those of group 28 and the pixels
    std::string pixel_type = "OW";  ///< VR of the pixels
    std::vector<std::int16_t> pixels = std::vector<std::int16_t>(12, 1000);
    std::string raw = {};                     ///< bytes of the pixels in place of `pixels`
    std::vector<std::string> fragments = {};  ///< of a codestream, in place of pixels

    std::string bytes() const;
};

}  // namespace pliant::test
