// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The rule is in scan_values.h. Thresholds come from histograms of up to 2¹⁸ values, in runs spread
// evenly over the scan; lowest and highest values from all. Classes of values are separated by
// Otsu's threshold, the one of the largest variance between its two sides.

#include <pliant/data/scan_values.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <type_traits>
#include <vector>

#include "base/text.h"

namespace pliant {
namespace {

constexpr std::size_t kRun = 512, kRuns = 512;
constexpr int kBins = 256;

/// Calls visit(value) for the values of the sample.
template <class Visit>
void visit_sample(const Volume& volume, const Visit& visit) {
    std::visit(
        [&](const auto& voxels) {
            const std::size_t count = voxels.size();
            const std::size_t runs = count <= kRun * kRuns ? 1 : kRuns;
            const std::size_t length = runs == 1 ? count : kRun;
            for (std::size_t r = 0; r < runs; ++r) {
                const std::size_t first = runs == 1 ? 0 : (count - length) * r / (runs - 1);
                for (std::size_t n = first; n < first + length; ++n)
                    if (const float value = float(voxels[n]); !std::isnan(value)) visit(value);
            }
        },
        volume.voxels);
}

/// Lowest and highest value; zeros if there is none.
ValueSpan extremes(const Volume& volume) {
    return std::visit(
        [](const auto& voxels) {
            using T = typename std::decay_t<decltype(voxels)>::value_type;
            T low = std::numeric_limits<T>::max(), high = std::numeric_limits<T>::lowest();
            voxels.for_each_piece([&](std::span<const T> piece) {
                for (const T value : piece) {
                    low = value < low ? value : low;
                    high = value > high ? value : high;
                }
            });
            return low <= high ? ValueSpan{double(low), double(high)} : ValueSpan{};
        },
        volume.voxels);
}

bool looks_like_ct(const Volume& volume) {
    double lowest = 0;
    std::size_t count = 0, air = 0, soft = 0;
    bool whole = true;
    visit_sample(volume, [&](float v) {
        lowest = count == 0 ? double(v) : std::min(lowest, double(v));
        ++count;
        air += v >= -1100 && v <= -850;
        soft += v >= -200 && v <= 300;
        whole = whole && v == std::floor(v);
    });
    const auto share = [&](std::size_t n) {
        return double(n) / double(std::max<std::size_t>(count, 1));
    };
    if (lowest >= -4096 && share(air) >= 0.001 && share(soft) >= 0.01) return true;
    return whole && lowest >= -1100 && lowest <= -30 && share(soft) >= 0.5;
}

bool is_phantom(const KeyValues& pairs) {
    return std::any_of(pairs.begin(), pairs.end(),
                       [](const auto& pair) { return pair.first == "phantom"; });
}

ValueKind kind_of(const Volume& volume, const ReadNotes& notes, std::string& reason) {
    const std::string& m = notes.modality;
    reason = "DICOM says " + m;
    if (m == "MR") return ValueKind::Magnetic;
    if (m == "US" || m == "IVUS") return ValueKind::Ultrasound;
    const bool says_hu = notes.rescale_type == "HU";
    const bool may_be_hu = says_hu || (notes.rescale_type.empty() && notes.is_rescaled);
    if (m == "CT" && may_be_hu) {
        if (says_hu) reason += " and HU";
        return ValueKind::Hounsfield;
    }
    if (m == "PT" || m == "NM") return ValueKind::Other;
    if (m == "CT") {
        const bool ct = looks_like_ct(volume);
        reason += ct ? ", HU by the histogram" : ", but not HU";
        return ct ? ValueKind::Hounsfield : ValueKind::XRay;
    }
    if (is_phantom(volume.key_values)) {
        reason = "a phantom";
        return ValueKind::Hounsfield;
    }
    reason = "by the histogram";
    return looks_like_ct(volume) ? ValueKind::Hounsfield : ValueKind::Other;
}

/// Sorted values.
class Sample {
  public:
    explicit Sample(std::vector<float> sorted) : m_values(std::move(sorted)) {}

    std::size_t size() const { return m_values.size(); }
    /// Value at a fraction 0…1 of the ranks.
    double at(double fraction) const {
        return double(m_values[std::size_t(std::lround(fraction * double(size() - 1)))]);
    }
    /// Number of values up to a threshold.
    std::size_t up_to(double threshold) const {
        return std::size_t(std::upper_bound(m_values.begin(), m_values.end(), float(threshold)) -
                           m_values.begin());
    }
    /// Median of the ranks begin…end.
    double median(std::size_t begin, std::size_t end) const {
        return double(m_values[begin + (end - begin) / 2]);
    }
    /// The values above a threshold, or the others.
    Sample part(double threshold, bool above) const {
        const auto split = m_values.begin() + std::ptrdiff_t(up_to(threshold));
        return above ? Sample({split, m_values.end()}) : Sample({m_values.begin(), split});
    }

  private:
    std::vector<float> m_values;
};

Sample sample_of(const Volume& volume) {
    std::vector<float> values;
    visit_sample(volume, [&](float v) { values.push_back(v); });
    if (values.empty()) values.push_back(0);  // all were NaN
    std::sort(values.begin(), values.end());
    return Sample(std::move(values));
}

/// Two classes of values, on both sides of a threshold.
struct Classes {
    double threshold = 0;
    double low_median = 0, high_median = 0;
    double high_share = 0;  ///< part of the values above the threshold

    double middle() const { return 0.5 * (low_median + high_median); }
};

/// @returns nullopt if all values are equal
std::optional<Classes> classes_of(const Sample& sample) {
    if (sample.size() < 2) return std::nullopt;
    const double low = sample.at(0.001), high = sample.at(0.999);
    if (!(high > low)) return std::nullopt;
    Classes best;
    double largest = 0;
    std::vector<double> sums(kBins + 1), counts(kBins + 1);
    for (int b = 1; b <= kBins; ++b) {
        const double edge = low + (high - low) * b / kBins;
        counts[std::size_t(b)] = double(sample.up_to(edge));
        const double middle = edge - 0.5 * (high - low) / kBins;
        sums[std::size_t(b)] = sums[std::size_t(b - 1)] +
                               middle * (counts[std::size_t(b)] - counts[std::size_t(b - 1)]);
    }
    const double count = counts.back(), sum = sums.back();
    for (int b = 1; b < kBins; ++b) {
        const double below = counts[std::size_t(b)], above = count - below;
        if (below == 0 || above == 0) continue;
        const double apart = sums[std::size_t(b)] / below - (sum - sums[std::size_t(b)]) / above;
        const double between = below * above * apart * apart;
        if (between <= largest) continue;
        largest = between;
        best.threshold = low + (high - low) * b / kBins;
    }
    const std::size_t split = sample.up_to(best.threshold);
    if (split == 0 || split == sample.size()) return std::nullopt;
    best.low_median = sample.median(0, split);
    best.high_median = sample.median(split, sample.size());
    best.high_share = double(sample.size() - split) / double(sample.size());
    return best;
}

/// Rounds to about three digits of a span, for typing.
double rounded(double value, double span) {
    const double step = std::pow(10, std::floor(std::log10(span)) - 2);
    const double multiple = std::round(value / step);
    // A power of ten below one has no exact double: dividing gives the nearest one.
    return step < 1 ? multiple / std::round(1 / step) : multiple * step;
}

void set_xray(const Classes& classes, double span, ValueDefaults& d) {
    // Maps air to −1000 HU and the other values' median to 40 HU.
    const double air = classes.low_median, unit = (classes.high_median - air) / 1040;
    const auto at = [&](double hu) { return rounded(air + unit * (hu + 1000), span); };
    const auto width = [&](double hu) { return rounded(unit * hu, span); };
    d.window = width(1500);
    d.level = at(-200);
    d.blended_window = width(500);
    d.blended_level = at(150);
    d.iso = at(-500);
    d.range = {at(-1000), at(3095)};
    d.air_threshold = at(-500);
    d.bone_threshold = at(300);
}

/// Threshold around bright, sparse lumens, as of MR angiographies, far above the tissue around
/// them; nullopt if there are none. @param bright  median of the sparse class
std::optional<double> bright_lumens(const Classes& tissue, double bright) {
    constexpr double kApart = 2;
    const double contrast = tissue.high_median - tissue.low_median;
    if (bright - tissue.high_median < kApart * contrast) return std::nullopt;
    return 0.5 * (tissue.high_median + bright);
}

void set_other(const Sample& sample, Classes classes, ValueSpan whole, ValueDefaults& d) {
    constexpr double kSparse = 0.08;
    // A sparse bright class is vessels, or bone in dark and less dark tissue.
    std::optional<double> lumens;
    const bool is_sparse = classes.high_share < kSparse;
    const auto inner = classes_of(is_sparse ? sample.part(classes.threshold, false)
                                            : sample.part(classes.threshold, true));
    if (is_sparse) {
        if (inner) lumens = bright_lumens(*inner, classes.high_median);
        if (inner) classes = *inner;
    } else if (inner && inner->high_share * classes.high_share < kSparse) {
        Classes tissue = classes;
        tissue.high_median = inner->low_median;
        lumens = bright_lumens(tissue, inner->high_median);
    }
    const double span = whole.high - whole.low;
    const double dark = sample.at(0.01), bright = sample.at(0.995);
    const double shown = bright > dark ? bright - dark : span;
    d.window = rounded(shown, shown);
    d.level =
        rounded(bright > dark ? 0.5 * (dark + bright) : 0.5 * (whole.low + whole.high), shown);
    d.iso = rounded(classes.middle(), shown);
    if (lumens && d.kind != ValueKind::Ultrasound) {
        d.iso = rounded(*lumens, shown);
        d.lumen_is_bright = true;
    }
    d.blended_window = d.window;
    d.blended_level = rounded(classes.middle() + 0.5 * d.window, shown);
    // The brightest tissue is as soft as 365 HU; only far outliers may become rigid.
    const double most = std::max(3 * (sample.at(0.999) - whole.low), 1.05 * span);
    d.range = {rounded(whole.low, span), rounded(whole.low + most, most)};
    // Air is a class of its own, dark against tissue.
    constexpr double kLeastShare = 0.1, kEdge = 0.2;
    d.has_air = d.kind != ValueKind::Ultrasound && !d.lumen_is_bright &&
                1 - classes.high_share >= kLeastShare;
    const double tissue = classes.high_median - classes.low_median;
    d.air_threshold = d.has_air ? rounded(classes.low_median + kEdge * tissue, shown) : d.range.low;
    d.has_bone = false;
    d.bone_threshold = whole.high;
}

/// Sets the defaults of a scan that isn't in HU.
void set_values(const Volume& volume, ValueDefaults& d) {
    const ValueSpan whole = extremes(volume);
    d.background = whole.low;
    const Sample sample = sample_of(volume);
    const auto classes = classes_of(sample);
    // Constant values: any threshold does, and all are tissue.
    const double span = whole.high > whole.low ? whole.high - whole.low : 1;
    const Classes found =
        classes.value_or(Classes{whole.low + 0.5 * span, whole.low, whole.low + span, 1});
    if (d.kind == ValueKind::XRay)
        set_xray(found, span, d);
    else
        set_other(sample, found, {whole.low, whole.low + span}, d);
}

}  // namespace

std::string name_of(ValueKind kind) {
    switch (kind) {
        case ValueKind::Hounsfield:
            return "CT in HU";
        case ValueKind::XRay:
            return "CT without HU";
        case ValueKind::Magnetic:
            return "MR";
        case ValueKind::Ultrasound:
            return "ultrasound";
        case ValueKind::Other:
            break;
    }
    return "values without a unit";
}

std::string unit_of(ValueKind kind) {
    return kind == ValueKind::Hounsfield ? " HU" : "";
}

std::string kind_text(const ValueDefaults& values) {
    return name_of(values.kind) + " (" + values.reason + ")";
}

std::string defaults_text(const ValueDefaults& v) {
    return "window " + short_text(v.window) + ", level " + short_text(v.level) + ", iso " +
           short_text(v.iso) + (v.lumen_is_bright ? " falling" : " rising") +
           (v.has_air ? ", air below " + short_text(v.air_threshold) : ", no air") +
           (v.has_bone ? ", bone above " + short_text(v.bone_threshold) : ", no bone") +
           ", range " + short_text(v.range.low) + " to " + short_text(v.range.high) + ", outside " +
           short_text(v.background);
}

std::string remark_on(const ValueDefaults& values, const std::string& how) {
    if (values.kind == ValueKind::Hounsfield) return {};
    return "taken as " + kind_text(values) + "; defaults: " + defaults_text(values) +
           "; change with " + how;
}

ValueDefaults value_defaults(const Volume& volume, const ReadNotes& notes) {
    ValueDefaults d;
    if (!check_volume(volume).ok()) return d;
    d.kind = kind_of(volume, notes, d.reason);
    if (d.kind != ValueKind::Hounsfield) set_values(volume, d);
    if (notes.window > 0) {
        d.window = notes.window;
        d.level = notes.level;
    }
    return d;
}

double length_scale(const Grid& grid) {
    constexpr double kBodyMm = 100;
    double longest_mm = 0;
    for (int a = 0; a < 3; ++a)
        longest_mm = std::max(longest_mm, grid.size[a] * grid.spacing_mm[a]);
    return std::min(1.0, longest_mm / kBodyMm);
}

std::vector<double> percentiles(const Volume& volume, std::span<const double> percent) {
    constexpr int kSteps = 65536;
    const ValueSpan whole = extremes(volume);
    std::vector<std::uint64_t> counts(kSteps);
    const double scale = whole.high > whole.low ? (kSteps - 1) / (whole.high - whole.low) : 0;
    std::uint64_t count = 0;
    std::visit(
        [&](const auto& voxels) {
            count = voxels.size();
            voxels.for_each_piece([&](auto piece) {
                for (const auto value : piece)
                    if (!std::isnan(float(value)))
                        ++counts[std::size_t((double(value) - whole.low) * scale + 0.5)];
            });
        },
        volume.voxels);
    std::vector<double> values;
    for (const double p : percent) {
        auto rank = std::uint64_t(std::llround(p / 100 * double(count - 1)));
        int step = 0;
        while (step < kSteps - 1 && rank >= counts[std::size_t(step)])
            rank -= counts[std::size_t(step++)];
        values.push_back(scale > 0 ? whole.low + step / scale : whole.low);
    }
    return values;
}

}  // namespace pliant
