// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Choice of a series by its UID, its number or a part of its description, and the table of series
// to choose from.

#include "base/errors.h"
#include "base/input_file.h"
#include "base/text.h"
#include "formats/dicom_folder.h"
#include "formats/dicom_series.h"

#include <pliant/scan_files.h>

#include <algorithm>
#include <array>
#include <iterator>
#include <new>
#include <span>
#include <utility>

namespace pliant {
namespace fs = std::filesystem;
namespace {

/// Maximum length of an UID; longer ones are cut off in tables.
constexpr std::size_t kMaxUidBytes = 64;

/// First non-empty text of the series' slices.
std::string first_of(const SeriesFiles& series, std::string DicomSlice::*text) {
    for (const DicomSlice& slice : series.slices)
        if (!(slice.*text).empty()) return slice.*text;
    return {};
}

/// Sets the number of volumes, and the first one's size and spacing.
void measure(const fs::path& folder, const SeriesFiles& files, DicomSeries& series) {
    std::vector<std::string> ignored;
    auto volumes = split_volumes(files.slices, ignored);
    series.volumes = std::int64_t(volumes.size());
    const auto stack = stack_slices(folder, volumes.front(), true, ignored);
    if (!stack) return;
    series.size = stack->grid.size;
    series.spacing_mm = stack->grid.spacing_mm;
    if (stack->irregular) series.spacing_mm.z = stack->irregular->gap_mm;
}

std::vector<DicomSeries> series_of(const fs::path& folder, const DicomFolder& found) {
    std::vector<DicomSeries> list;
    for (const auto& [uid, files] : found.series) {
        DicomSeries& series = list.emplace_back();
        series.uid = uid;
        series.number = first_of(files, &DicomSlice::series_number);
        series.description = first_of(files, &DicomSlice::description);
        series.modality = first_of(files, &DicomSlice::modality);
        series.slices = int(files.slices.size());
        if (files.fault)
            series.fault = files.fault->message;
        else
            measure(folder, files, series);
    }
    std::stable_sort(list.begin(), list.end(), [](const DicomSeries& a, const DicomSeries& b) {
        const auto rank = [](const DicomSeries& s) {
            const auto number = whole_number_from(s.number);
            return std::pair(!number, number.value_or(0));
        };
        return rank(a) < rank(b);
    });
    return list;
}

/// Series that fit a choice.
std::vector<DicomSeries> matches(const std::vector<DicomSeries>& list, const std::string& wanted) {
    const auto some = [&](const auto& fits) {
        std::vector<DicomSeries> found;
        std::copy_if(list.begin(), list.end(), std::back_inserter(found), fits);
        return found;
    };
    auto found = some([&](const DicomSeries& s) { return s.uid == wanted; });
    if (!found.empty()) return found;
    if (const auto number = whole_number_from(wanted))
        return some([&](const DicomSeries& s) { return whole_number_from(s.number) == number; });
    const std::string part = lower_case(wanted);
    found = some([&](const DicomSeries& s) { return lower_case(s.description) == part; });
    if (!found.empty()) return found;
    return some([&](const DicomSeries& s) {
        return lower_case(s.description).find(part) != std::string::npos;
    });
}

/// Adds the table, which programs print below the message.
Error with_choices(Error error, const std::vector<DicomSeries>& list) {
    error.field = "series";
    error.expected = table_of_series(list);
    return error;
}

/// UID of the series that fits the choice.
/// @returns an error with a table if there isn't exactly one
Result<std::string> matching_series(const fs::path& folder, const std::vector<DicomSeries>& list,
                                    const std::string& wanted) {
    if (wanted.empty())
        return with_choices({ErrorCode::InvalidArgument,
                             folder.string() + ": holds " + std::to_string(list.size()) +
                                 " series, choose one with --series and its number or a part of "
                                 "its description"},
                            list);
    const std::vector<DicomSeries> found = matches(list, wanted);
    if (found.size() == 1) return found.front().uid;
    if (found.empty())
        return with_choices(
            {ErrorCode::NotFound, folder.string() + ": has no series " + shown(wanted) +
                                      ", expected --series with the number, a part "
                                      "of the description or the UID of one"},
            list);
    return with_choices(
        {ErrorCode::InvalidArgument,
         folder.string() + ": " + std::to_string(found.size()) + " series fit --series " +
             shown(wanted) + ", expected one: a longer part of the description, or the UID"},
        found);
}

void note_left_out(const DicomFolder& folder, const std::string& chosen,
                   std::vector<std::string>& notes) {
    if (folder.went_deeper)
        notes.push_back("the folder has no slices itself; found in folders below it");
    if (folder.others)
        notes.push_back(counted(folder.others, "file", "files") +
                        " of the folder left out: no DICOM image");
    if (folder.linked_folders && folder.went_deeper)
        notes.push_back(counted(folder.linked_folders, "link", "links") +
                        " to folders not followed");
    for (const auto& [uid, series] : folder.series)
        if (uid != chosen && series.fault)
            notes.push_back("the series " + shown(uid) + " left out: " + series.fault->message);
    if (!folder.strays.empty())
        notes.push_back(counted(folder.strays.size(), "file", "files") +
                        " of the folder left out: " + folder.strays.front().fault->message);
}

std::string text_of_spacing(Vec3d mm) {
    return short_text(mm.x, 4) + " × " + short_text(mm.y, 4) + " × " + short_text(mm.z, 4);
}

/// Number of characters of an UTF-8 text.
std::size_t width_of(const std::string& text) {
    return std::size_t(std::count_if(text.begin(), text.end(),
                                     [](char c) { return (std::uint8_t(c) & 0xc0) != 0x80; }));
}

}  // namespace

std::string table_of_series(std::span<const DicomSeries> series) {
    constexpr std::size_t kColumns = 7;
    using Row = std::array<std::string, kColumns>;
    std::vector<Row> rows = {
        {"number", "description", "modality", "slices", "size", "spacing [mm]", "UID"}};
    for (const DicomSeries& s : series) {
        std::string size = s.size.x ? text_of_size(s.size) : "";
        if (!s.fault.empty()) size = "can't be read";
        if (s.volumes > 1) size += " (" + std::to_string(s.volumes) + " volumes)";
        rows.push_back({printable(s.number), printable(s.description), printable(s.modality),
                        std::to_string(s.slices), size,
                        s.size.x ? text_of_spacing(s.spacing_mm) : "",
                        printable(s.uid, kMaxUidBytes)});
    }
    std::array<std::size_t, kColumns> widths{};
    for (std::size_t c = 0; c < kColumns; ++c)
        for (const Row& row : rows) widths[c] = std::max(widths[c], width_of(row[c]));
    std::string table;
    for (const Row& row : rows) {
        for (std::size_t c = 0; c + 1 < kColumns; ++c)
            table += row[c] + std::string(widths[c] - width_of(row[c]) + 2, ' ');
        table += row.back() + "\n";
    }
    return table;
}

Result<std::vector<DicomSeries>> list_series(const fs::path& folder) {
    try {
        const auto type = type_of(folder);
        if (type && *type == fs::file_type::regular && is_dicomdir(folder))
            return list_series(folder_of_dicomdir(folder));
        const auto found = read_dicom_headers(folder);
        if (!found) return found.error();
        return series_of(folder, *found);
    } catch (const std::bad_alloc&) {
        return Error{ErrorCode::LimitExceeded, folder.string() + ": not enough memory to read it"};
    }
}

Result<std::vector<DicomSlice>> choose_series(const fs::path& folder, DicomFolder found,
                                              const std::string& wanted,
                                              std::vector<std::string>& notes) {
    const auto is_usable = [](const auto& one) { return !one.second.fault; };
    const auto usable = std::find_if(found.series.begin(), found.series.end(), is_usable);
    const bool is_only =
        wanted.empty() && (found.series.size() == 1 ||
                           std::count_if(found.series.begin(), found.series.end(), is_usable) == 1);
    // A damaged file of an unknown series may be a slice of the only series.
    if (!found.strays.empty() && (is_only || found.series.empty()))
        return *found.strays.front().fault;
    std::string uid = wanted;
    if (is_only) {
        uid = (usable == found.series.end() ? found.series.begin() : usable)->first;
    } else if (!found.series.contains(uid)) {
        const auto chosen = matching_series(folder, series_of(folder, found), wanted);
        if (!chosen) return chosen.error();
        uid = *chosen;
    }
    SeriesFiles& series = found.series.at(uid);
    if (series.fault) return *series.fault;
    note_left_out(found, uid, notes);
    return std::move(series.slices);
}

}  // namespace pliant
