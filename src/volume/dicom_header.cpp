// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The only place that knows GDCM: it finds the tags; their text is read here.

#include "volume/dicom_series.h"
#include "volume/text.h"

#include <gdcmReader.h>
#include <gdcmTrace.h>

#include <array>
#include <cstring>
#include <fstream>
#include <set>

namespace pliant {
namespace fs = std::filesystem;
namespace {

const gdcm::Tag kSeriesDescription(0x0008, 0x103e), kSeriesUid(0x0020, 0x000e),
    kPosition(0x0020, 0x0032), kOrientation(0x0020, 0x0037), kSamples(0x0028, 0x0002),
    kFrames(0x0028, 0x0008), kRows(0x0028, 0x0010), kColumns(0x0028, 0x0011),
    kPixelSpacing(0x0028, 0x0030), kBitsAllocated(0x0028, 0x0100),
    kPixelRepresentation(0x0028, 0x0103);

class Tags {
  public:
    explicit Tags(const gdcm::File& file) : m_data(file.GetDataSet()) {}

    std::string text(const gdcm::Tag& tag) const {
        if (!m_data.FindDataElement(tag)) return {};
        const gdcm::ByteValue* value = m_data.GetDataElement(tag).GetByteValue();
        if (!value || value->GetLength() == 0) return {};
        std::string bytes(value->GetPointer(), value->GetLength());
        while (!bytes.empty() && (bytes.back() == '\0' || bytes.back() == ' ')) bytes.pop_back();
        return bytes;
    }
    /// An unsigned 16-bit number.
    int number(const gdcm::Tag& tag, int otherwise) const {
        if (!m_data.FindDataElement(tag)) return otherwise;
        const gdcm::ByteValue* value = m_data.GetDataElement(tag).GetByteValue();
        if (!value || value->GetLength() < 2) return otherwise;
        std::uint16_t n = 0;  // in this machine's byte order already
        std::memcpy(&n, value->GetPointer(), sizeof n);
        return n;
    }
    /// Decimal texts separated by backslashes.
    std::vector<double> decimals(const gdcm::Tag& tag, std::size_t count) const {
        auto numbers = numbers_from(text(tag), '\\');
        if (!numbers || numbers->size() != count) return {};
        return *numbers;
    }

  private:
    const gdcm::DataSet& m_data;
};

DicomSlice slice_from(const Tags& tags, const fs::path& path) {
    DicomSlice slice;
    slice.path = path;
    slice.series_uid = tags.text(kSeriesUid);
    slice.description = shown(trimmed(tags.text(kSeriesDescription)));
    slice.rows = tags.number(kRows, 0);
    slice.columns = tags.number(kColumns, 0);
    slice.samples_per_pixel = tags.number(kSamples, 1);
    slice.frames = int(whole_number_from(tags.text(kFrames)).value_or(1));
    slice.stored_type = (tags.number(kPixelRepresentation, 0) ? "int" : "uint") +
                        std::to_string(tags.number(kBitsAllocated, 16));
    if (const auto p = tags.decimals(kPosition, 3); !p.empty())
        slice.position = Vec3d{p[0], p[1], p[2]};
    if (const auto o = tags.decimals(kOrientation, 6); !o.empty()) {
        slice.row = Vec3d{o[0], o[1], o[2]};
        slice.column = Vec3d{o[3], o[4], o[5]};
    }
    // The first number is the distance between rows.
    if (const auto s = tags.decimals(kPixelSpacing, 2); !s.empty())
        slice.spacing_mm = Vec3d{s[1], s[0], 0};
    return slice;
}

}  // namespace

bool looks_like_dicom(const fs::path& path) {
    std::ifstream file(path, std::ios::binary);
    std::array<char, 132> start{};
    file.read(start.data(), std::streamsize(start.size()));
    if (file.gcount() == 132 && std::memcmp(&start[128], "DICM", 4) == 0) return true;
    // Without preamble: the first element is of group 2 or 8, little endian.
    return file.gcount() == 132 && (start[0] == 2 || start[0] == 8) && start[1] == 0 &&
           start[3] == 0;
}

std::optional<DicomSlice> read_dicom_slice(const fs::path& path) {
    if (!looks_like_dicom(path)) return std::nullopt;
    gdcm::Trace::WarningOff();
    gdcm::Trace::ErrorOff();
    try {
        gdcm::Reader reader;
        reader.SetFileName(path.c_str());
        const std::set<gdcm::Tag> wanted = {kSeriesDescription,
                                            kSeriesUid,
                                            kPosition,
                                            kOrientation,
                                            kSamples,
                                            kFrames,
                                            kRows,
                                            kColumns,
                                            kPixelSpacing,
                                            kBitsAllocated,
                                            kPixelRepresentation};
        if (!reader.ReadSelectedTags(wanted)) return std::nullopt;
        const DicomSlice slice = slice_from(Tags(reader.GetFile()), path);
        if (slice.rows < 1 || slice.columns < 1) return std::nullopt;
        return slice;
    } catch (const std::exception&) {
        return std::nullopt;
    }
}

}  // namespace pliant
