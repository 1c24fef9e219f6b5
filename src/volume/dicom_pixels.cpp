// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "volume/dicom_series.h"
#include "volume/itk_io.h"

#include <fstream>

namespace pliant {
namespace {

Error unusable(const DicomSlice& slice, ErrorCode code, const std::string& message) {
    return {code, slice.path.string() + ": " + message};
}

Status check_layout(const DicomSlice& slice) {
    const DicomPixels& p = slice.pixels;
    const bool whole_bytes =
        p.bits_allocated == 8 || p.bits_allocated == 16 || p.bits_allocated == 32;
    if (!whole_bytes || p.bits_stored < 1 || p.high_bit >= p.bits_allocated ||
        p.high_bit + 1 < p.bits_stored)
        return unusable(slice, ErrorCode::Unsupported,
                        "stores " + std::to_string(p.bits_stored) + " bits of " +
                            std::to_string(p.bits_allocated) + " up to bit " +
                            std::to_string(p.high_bit) + ", expected whole pixels of 8, 16 or 32");
    const std::uint64_t expected = std::uint64_t(slice.rows) * std::uint64_t(slice.columns) *
                                   std::uint64_t(p.bits_allocated / 8);
    if (!p.compressed && p.bytes < expected)
        return unusable(slice, ErrorCode::Unreadable,
                        "has " + std::to_string(p.bytes) + " bytes of pixels, expected " +
                            std::to_string(expected));
    return Ok{};
}

/// The bits of a pixel as a number; bits beside those that are stored may hold overlays.
double stored_value(const unsigned char* bytes, const DicomPixels& p) {
    const int size = p.bits_allocated / 8;
    std::uint64_t raw = 0;
    for (int n = 0; n < size; ++n)
        raw |= std::uint64_t(bytes[p.big_endian ? size - 1 - n : n]) << (8 * n);
    const std::uint64_t sign = std::uint64_t(1) << (p.bits_stored - 1);
    raw = (raw >> (p.high_bit + 1 - p.bits_stored)) & (2 * sign - 1);
    return p.is_signed && (raw & sign) ? double(raw) - 2 * double(sign) : double(raw);
}

}  // namespace

Status read_dicom_pixels(const DicomSlice& slice, VoxelBuilder& voxels) {
    const DicomPixels& p = slice.pixels;
    if (Status status = check_layout(slice); !status) return status;
    if (p.compressed) return itk_read_slice(slice.path, slice.columns, slice.rows, voxels);
    const auto count = std::size_t(slice.rows) * std::size_t(slice.columns);
    const auto size = std::size_t(p.bits_allocated / 8);
    std::vector<unsigned char> bytes(count * size);
    std::ifstream file(slice.path, std::ios::binary);
    file.seekg(std::streamoff(p.offset));
    if (!file.read(reinterpret_cast<char*>(bytes.data()), std::streamsize(bytes.size())))
        return unusable(slice, ErrorCode::Unreadable, "ends early: its pixels are incomplete");
    std::vector<float> values(count);
    for (std::size_t n = 0; n < count; ++n)
        values[n] = float(*slice.slope * stored_value(&bytes[n * size], p) + *slice.intercept);
    voxels.add(Component::Float32, values.data(), count);
    return Ok{};
}

}  // namespace pliant
