// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "formats/dicom_syntax.h"

#include "base/text.h"

#include <algorithm>
#include <iterator>

namespace pliant {
namespace {

constexpr TransferSyntax kKnown[] = {
    {"1.2.840.10008.1.2", PixelCodec::None, false, false},
    {"1.2.840.10008.1.2.1", PixelCodec::None, true, false},
    {"1.2.840.10008.1.2.1.99", PixelCodec::None, true, false, true},
    {"1.2.840.10008.1.2.2", PixelCodec::None, true, true},
    {"1.2.840.10008.1.2.5", PixelCodec::Rle, true, false},
    {"1.2.840.10008.1.2.4.50", PixelCodec::Jpeg, true, false},  // baseline
    {"1.2.840.10008.1.2.4.51", PixelCodec::Jpeg, true, false},  // extended
    {"1.2.840.10008.1.2.4.57", PixelCodec::Jpeg, true, false},  // lossless
    {"1.2.840.10008.1.2.4.70", PixelCodec::Jpeg, true, false},  // lossless, first predictor
    {"1.2.840.10008.1.2.4.80", PixelCodec::JpegLs, true, false},
    {"1.2.840.10008.1.2.4.81", PixelCodec::JpegLs, true, false},  // near-lossless
    {"1.2.840.10008.1.2.4.90", PixelCodec::Jpeg2000, true, false},
    {"1.2.840.10008.1.2.4.91", PixelCodec::Jpeg2000, true, false},
};

struct Name {
    std::string_view uid, name;
};
/// Unsupported syntaxes. A row also covers UIDs with one digit more.
constexpr Name kRefused[] = {
    {"1.2.840.10008.1.2.1.98", "uncompressed frames in fragments"},
    {"1.2.840.10008.1.2.8.1", "deflated frames"},
    {"1.2.840.10008.1.2.4.92", "JPEG 2000 part 2"},
    {"1.2.840.10008.1.2.4.93", "JPEG 2000 part 2"},
    {"1.2.840.10008.1.2.4.94", "JPIP"},
    {"1.2.840.10008.1.2.4.95", "JPIP"},
    {"1.2.840.10008.1.2.4.110", "JPEG XL"},
    {"1.2.840.10008.1.2.4.111", "JPEG XL"},
    {"1.2.840.10008.1.2.4.112", "JPEG XL"},
    {"1.2.840.10008.1.2.4.201", "High-Throughput JPEG 2000"},
    {"1.2.840.10008.1.2.4.202", "High-Throughput JPEG 2000"},
    {"1.2.840.10008.1.2.4.203", "High-Throughput JPEG 2000"},
    {"1.2.840.10008.1.2.4.204", "JPIP"},
    {"1.2.840.10008.1.2.4.205", "JPIP"},
    {"1.2.840.10008.1.2.4.10", "video"},
    {"1.2.840.10008.1.2.4.5", "a retired process of JPEG"},
    {"1.2.840.10008.1.2.4.6", "a retired process of JPEG"},
};

}  // namespace

const TransferSyntax* find_transfer_syntax(std::string_view uid) {
    const auto found = std::find_if(std::begin(kKnown), std::end(kKnown),
                                    [&](const TransferSyntax& known) { return known.uid == uid; });
    return found == std::end(kKnown) ? nullptr : &*found;
}

std::string describe_transfer_syntax(std::string_view uid) {
    const auto named = std::find_if(std::begin(kRefused), std::end(kRefused), [&](const Name& row) {
        return uid == row.uid || (uid.starts_with(row.uid) && uid.size() == row.uid.size() + 1);
    });
    const std::string syntax = "transfer syntax " + shown(uid);
    if (named == std::end(kRefused)) return syntax;
    return std::string(named->name) + " (" + syntax + ")";
}

bool has_plain_elements(std::string_view uid) {
    constexpr std::string_view kFragments = "1.2.840.10008.1.2.4.";
    return find_transfer_syntax(uid) || uid.starts_with(kFragments) ||
           uid == "1.2.840.10008.1.2.1.98" || uid == "1.2.840.10008.1.2.8.1";
}

}  // namespace pliant
