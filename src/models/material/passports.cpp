// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include <pliant/models/passports.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "pbd/ogden.h"

namespace pliant {
namespace {

/// Nominal stresses [kPa] at one step of strain.
struct Stresses {
    double tension, compression, shear;
};
constexpr std::size_t kSteps = 16;
/// Steps of stretch in the curves of [Budday2017]; shear has twice as large ones. The published
/// file rounds stretches to four digits.
constexpr double kStrainStep = 0.1 / kSteps;

constexpr std::array<StressPoint, 3 * kSteps> curve_of(const Stresses (&rows)[kSteps]) {
    std::array<StressPoint, 3 * kSteps> points{};
    for (std::size_t n = 0; n < kSteps; ++n) {
        const double strain = double(n + 1) * kStrainStep;
        points[n] = {LoadCase::Tension, strain, rows[n].tension};
        points[kSteps + n] = {LoadCase::Compression, -strain, rows[n].compression};
        points[2 * kSteps + n] = {LoadCase::Shear, 2 * strain, rows[n].shear};
    }
    return points;
}

constexpr auto kCortex = curve_of({{0.0251, -0.0308, 0.0147},
                                   {0.0462, -0.0659, 0.0294},
                                   {0.0666, -0.1040, 0.0486},
                                   {0.0838, -0.1479, 0.0633},
                                   {0.1010, -0.1908, 0.0814},
                                   {0.1175, -0.2375, 0.0983},
                                   {0.1324, -0.2920, 0.1186},
                                   {0.1488, -0.3504, 0.1412},
                                   {0.1661, -0.4127, 0.1649},
                                   {0.1856, -0.4866, 0.1942},
                                   {0.2091, -0.5684, 0.2292},
                                   {0.2366, -0.6579, 0.2698},
                                   {0.2710, -0.7630, 0.3227},
                                   {0.3125, -0.8837, 0.3791},
                                   {0.3650, -1.0005, 0.4557},
                                   {0.4151, -1.1484, 0.5435}});
constexpr auto kCoronaRadiata = curve_of({{0.0157, -0.0193, 0.0079},
                                          {0.0235, -0.0387, 0.0159},
                                          {0.0345, -0.0543, 0.0238},
                                          {0.0423, -0.0800, 0.0318},
                                          {0.0509, -0.1040, 0.0409},
                                          {0.0572, -0.1305, 0.0488},
                                          {0.0642, -0.1674, 0.0601},
                                          {0.0721, -0.2024, 0.0681},
                                          {0.0791, -0.2453, 0.0817},
                                          {0.0869, -0.2959, 0.0964},
                                          {0.0940, -0.3543, 0.1133},
                                          {0.1050, -0.4127, 0.1347},
                                          {0.1151, -0.4827, 0.1596},
                                          {0.1292, -0.5723, 0.1878},
                                          {0.1418, -0.6657, 0.2227},
                                          {0.1582, -0.7591, 0.2611}});

/// Bisections of the sideways stretch: to rounding.
constexpr int kHalvings = 64;
constexpr double kAnyStrain = 1, kLargestExponent = 40, kExponentTolerance = 1e-3;

/// Nearly incompressible: tetrahedra of linear shape lock closer to 0.5.
constexpr double kIncompressible = 0.49;
constexpr const char* kFigures = "published values, quoted as facts";

constexpr MaterialPassport silicone(std::string_view name, std::string_view sample, double kpa,
                                    double deviation_kpa, double density_kg_m3) {
    return {.name = name,
            .sample = sample,
            .source = "Dawood2024",
            .licence = "CC BY 4.0",
            .young_modulus_kpa = kpa,
            .deviation_kpa = deviation_kpa,
            .poisson_ratio = kIncompressible,
            .density_kg_m3 = density_kg_m3,
            .density_source = "Ecoflex2024",
            .limits = sample.find("thinner") == sample.npos
                          ? std::string_view()
                          : "the density is that of the rubber without thinner"};
}
constexpr double kEcoflex = 1070, kEcoflex10 = 1040;

constexpr MaterialPassport kPassports[] = {
    {.name = "cortex",
     .sample = "human brain, grey matter, ex vivo: tension, compression and shear",
     .source = "Budday2017",
     .licence = kFigures,
     .young_modulus_kpa = 4.45,
     .poisson_ratio = kIncompressible,
     .density_kg_m3 = 1040,
     .density_source = "Cardoso2012",
     .curve = kCortex,
     .ogden_young_modulus_kpa = 4.54,
     .ogden_alpha = -17.9,
     .limits = "at 10 % strain it is 2.8 times as stiff in compression as in tension; a "
               "neo-Hookean law has a ratio of 1.2, Ogden's law one of 3.6"},
    {.name = "corona-radiata",
     .sample = "human brain, white matter, ex vivo: tension, compression and shear",
     .source = "Budday2017",
     .licence = kFigures,
     .young_modulus_kpa = 2.35,
     .poisson_ratio = kIncompressible,
     .density_kg_m3 = 1040,
     .density_source = "Cardoso2012",
     .curve = kCoronaRadiata,
     .ogden_young_modulus_kpa = 2.13,
     .ogden_alpha = -23.4,
     .limits = "at 10 % strain it is 4.8 times as stiff in compression as in tension; a "
               "neo-Hookean law has a ratio of 1.2, Ogden's law one of 5"},
    {.name = "liver",
     .sample = "human, 50 donors with normal histology, in vivo: transient elastography",
     .source = "Alsebaey2015",
     .licence = kFigures,
     .young_modulus_kpa = 4.3,
     .deviation_kpa = 1.2,
     .poisson_ratio = kIncompressible,
     .density_kg_m3 = 1060,
     .density_source = "Cardoso2012",
     .limits = "small strain at 50 Hz; slow or large strains were not measured"},
    {.name = "kidney",
     .sample = "human renal cortex, 127 volunteers, in vivo: shear-wave elastography",
     .source = "Arda2011",
     .licence = kFigures,
     .young_modulus_kpa = 5.0,
     .deviation_kpa = 2.9,
     .poisson_ratio = kIncompressible,
     .density_kg_m3 = 1050,
     .density_source = "Cardoso2012",
     .limits = "the renal pelvis has 23.6 ± 5.4 kPa"},
    {.name = "lung",
     .sample = "dog, inflated lobes at a transpulmonary pressure of 1 kPa: uniaxial loading",
     .source = "LaiFook1976",
     .licence = kFigures,
     .young_modulus_kpa = 1.5,
     .poisson_ratio = 0.43,
     .density_kg_m3 = 288,
     .density_source = "Kaye1995",
     .limits = "the modulus is 1.5 times the transpulmonary pressure, 2 times by indentation"},
    {.name = "fat",
     .sample = "human breast, ex vivo: indentation",
     .source = "Samani2007",
     .licence = kFigures,
     .young_modulus_kpa = 3.25,
     .deviation_kpa = 0.91,
     .poisson_ratio = kIncompressible,
     .density_kg_m3 = 950,
     .density_source = "Cardoso2012",
     .limits = "small strain; fat stiffens when it is compressed"},
    {.name = "muscle",
     .sample = "human gastrocnemius at rest, 127 volunteers, in vivo: shear-wave elastography",
     .source = "Arda2011",
     .licence = kFigures,
     .young_modulus_kpa = 11.1,
     .deviation_kpa = 4.1,
     .poisson_ratio = kIncompressible,
     .density_kg_m3 = 1050,
     .density_source = "Cardoso2012",
     .limits = "muscle is anisotropic, and stiffer when it is stretched or active"},
    {.name = "airway",
     .sample = "pig, trachea and bronchi, circumferential strips: tension",
     .source = "Eskandari2018",
     .licence = kFigures,
     .young_modulus_kpa = 8.4,
     .deviation_kpa = 1.1,
     .poisson_ratio = kIncompressible,
     .density_kg_m3 = 1050,
     .density_source = "Mancia2019",
     .limits = "axially 30.5 ± 3.1 kPa, which an isotropic law can't show; tracheal cartilage has "
               "16.9 MPa [Safshekan2016]; the density is that of an artery"},
    {.name = "vessel",
     .sample = "pig, carotid arteries: biaxial tension, fitted by a neo-Hookean law",
     .source = "Boekhoven2016",
     .licence = kFigures,
     .young_modulus_kpa = 69,
     .deviation_kpa = 16,
     .poisson_ratio = kIncompressible,
     .density_kg_m3 = 1050,
     .density_source = "Mancia2019",
     .limits = "three times the published shear modulus; under blood pressure human carotids have "
               "a tangent modulus of 400 kPa in diastole and 1500 kPa in systole [Kamenskiy2012]"},
    silicone("ecoflex-00-50", "Ecoflex 00-50: compression", 152.7, 4.8, kEcoflex),
    silicone("ecoflex-00-50-12.5", "Ecoflex 00-50, 12.5 % thinner: compression", 111.1, 6.44,
             kEcoflex),
    silicone("ecoflex-00-30", "Ecoflex 00-30: compression", 97.26, 4.16, kEcoflex),
    silicone("ecoflex-00-30-12.5", "Ecoflex 00-30, 12.5 % thinner: compression", 73.18, 1.17,
             kEcoflex),
    silicone("ecoflex-00-10", "Ecoflex 00-10: compression", 54.21, 2.38, kEcoflex10),
    silicone("ecoflex-00-10-12.5", "Ecoflex 00-10, 12.5 % thinner: compression", 37.3, 1.28,
             kEcoflex10),
    silicone("ecoflex-00-10-25", "Ecoflex 00-10, 25 % thinner: compression", 27.39, 0.79,
             kEcoflex10),
    silicone("ecoflex-00-10-37.5", "Ecoflex 00-10, 37.5 % thinner: compression", 19.37, 0.83,
             kEcoflex10),
    silicone("ecoflex-00-10-50", "Ecoflex 00-10, 50 % thinner: compression", 15.52, 0.4,
             kEcoflex10),
    silicone("ecoflex-00-10-62.5", "Ecoflex 00-10, 62.5 % thinner: compression", 12.17, 0.52,
             kEcoflex10),
    silicone("ecoflex-00-10-75", "Ecoflex 00-10, 75 % thinner: compression", 8.81, 0.12,
             kEcoflex10),
    silicone("ecoflex-00-10-87.5", "Ecoflex 00-10, 87.5 % thinner: compression", 7.92, 0.26,
             kEcoflex10),
    silicone("ecoflex-00-10-100", "Ecoflex 00-10, 100 % thinner: compression", 5.42, 0.77,
             kEcoflex10),
};

}  // namespace

std::span<const MaterialPassport> material_passports() noexcept {
    return kPassports;
}

const MaterialPassport* find_material(std::string_view name) noexcept {
    const auto* const found = std::find_if(std::begin(kPassports), std::end(kPassports),
                                           [&](const auto& each) { return each.name == name; });
    return found == std::end(kPassports) ? nullptr : found;
}

double neo_hookean_stress(double young_modulus, double poisson_ratio, LoadCase load,
                          double strain) noexcept {
    const double mu = young_modulus / (2 * (1 + poisson_ratio));
    if (load == LoadCase::Shear) return mu * strain;
    const double s = 1 + strain;
    // µ/(λ + µ) = 1 − 2ν, since λ = 2µν/(1 − 2ν).
    const double j = 1 + (1 - 2 * poisson_ratio) * (1 - 1 / s);
    return mu * (s - j / (s * s));
}

double ogden_stress(double young_modulus, double poisson_ratio, double alpha, LoadCase load,
                    double strain) noexcept {
    if (alpha == 2) return neo_hookean_stress(young_modulus, poisson_ratio, load, strain);
    const double mu = young_modulus / (2 * (1 + poisson_ratio));
    const auto slope = [&](double stretch) { return pbd::ogden_term(alpha, stretch).slope; };
    if (load == LoadCase::Shear) {
        // Stretches s, 1/s and 1 with s − 1/s = γ; dλ/dγ = ± λ/(s + 1/s).
        const double s = 0.5 * strain + std::sqrt(1 + 0.25 * strain * strain);
        return mu * (slope(s) * s - slope(1 / s) / s) / (s + 1 / s);
    }
    const double s = 1 + strain;
    const double bulk = 2 * poisson_ratio / (1 - 2 * poisson_ratio) + 2 / alpha;
    const auto pressure = [&](double sideways) {
        return bulk * (s * sideways * sideways - 1) - 2 / alpha;
    };
    double low = 1e-3, high = 1e3;
    for (int n = 0; n < kHalvings; ++n) {
        const double middle = std::sqrt(low * high);
        (slope(middle) + pressure(middle) * s * middle > 0 ? high : low) = middle;
    }
    const double sideways = std::sqrt(low * high);
    return mu * (slope(s) + pressure(sideways) * sideways * sideways);
}

LawError law_error(const MaterialPassport& passport, double young_modulus_kpa,
                   double ogden_alpha) noexcept {
    double errors[3] = {}, squares[3] = {};
    for (const StressPoint& point : passport.curve) {
        const double law = ogden_stress(young_modulus_kpa, passport.poisson_ratio, ogden_alpha,
                                        point.load, point.strain);
        errors[std::size_t(point.load)] += (law - point.stress_kpa) * (law - point.stress_kpa);
        squares[std::size_t(point.load)] += point.stress_kpa * point.stress_kpa;
    }
    const auto percent = [](double error, double square) {
        return square > 0 ? 100 * std::sqrt(error / square) : 0;
    };
    return {young_modulus_kpa,
            percent(errors[0] + errors[1] + errors[2], squares[0] + squares[1] + squares[2]),
            percent(errors[0], squares[0]),
            percent(errors[1], squares[1]),
            percent(errors[2], squares[2]),
            ogden_alpha};
}

namespace {

/// The modulus of least squares: laws are proportional to it. 0 without points.
double best_modulus(const MaterialPassport& passport, double alpha, double max_strain) {
    double products = 0, squares = 0;
    for (const StressPoint& point : passport.curve) {
        const double size = std::abs(point.strain) * (point.load == LoadCase::Shear ? 0.5 : 1);
        if (size > max_strain) continue;
        const double unit =
            ogden_stress(1, passport.poisson_ratio, alpha, point.load, point.strain);
        products += unit * point.stress_kpa;
        squares += unit * unit;
    }
    return squares > 0 ? products / squares : 0;
}

}  // namespace

LawError fit_law(const MaterialPassport& passport, double max_strain) noexcept {
    const double modulus = best_modulus(passport, 2, max_strain);
    return modulus > 0 ? law_error(passport, modulus) : LawError{};
}

LawError fit_ogden(const MaterialPassport& passport) noexcept {
    const auto with = [&](double alpha) {
        return law_error(passport, best_modulus(passport, alpha, kAnyStrain), alpha);
    };
    if (passport.curve.empty()) return {};
    // The error has one minimum, which golden sections enclose.
    constexpr double kGolden = 0.6180339887498949;
    double low = -kLargestExponent, high = -std::max(1.0, 1 / passport.poisson_ratio - 2);
    while (high - low > kExponentTolerance) {
        const double a = high - kGolden * (high - low), b = low + kGolden * (high - low);
        if (with(a).percent < with(b).percent)
            high = b;
        else
            low = a;
    }
    return with(0.5 * (low + high));
}

Record record_of(const MaterialPassport& passport) {
    static constexpr const char* kLoads[] = {"tension", "compression", "shear"};
    std::vector<std::string> loads;
    const auto number_or_none = [](double number) {
        return number > 0 ? SettingValue(number) : SettingValue();
    };
    const LawError small = law_error(passport, passport.young_modulus_kpa);
    const LawError fit = fit_law(passport);
    const LawError ogden =
        passport.curve.empty()
            ? LawError{}
            : law_error(passport, passport.ogden_young_modulus_kpa, passport.ogden_alpha);
    std::vector<double> strains, stresses, fitted, ogdens;
    for (const StressPoint& point : passport.curve) {
        const auto stress = [&](const LawError& law) {
            return ogden_stress(law.young_modulus_kpa, passport.poisson_ratio, law.ogden_alpha,
                                point.load, point.strain);
        };
        loads.push_back(kLoads[std::size_t(point.load)]);
        strains.push_back(point.strain);
        stresses.push_back(point.stress_kpa);
        fitted.push_back(stress(fit));
        ogdens.push_back(stress(ogden));
    }
    return {{"name", std::string(passport.name)},
            {"sample", std::string(passport.sample)},
            {"source", std::string(passport.source)},
            {"licence", std::string(passport.licence)},
            {"young_modulus_kpa", passport.young_modulus_kpa},
            {"deviation_kpa", number_or_none(passport.deviation_kpa)},
            {"poisson_ratio", passport.poisson_ratio},
            {"density_kg_m3", passport.density_kg_m3},
            {"density_source", std::string(passport.density_source)},
            {"limits", std::string(passport.limits)},
            {"load", std::move(loads)},
            {"strain", std::move(strains)},
            {"stress_kpa", std::move(stresses)},
            {"fitted_stress_kpa", std::move(fitted)},
            {"ogden_stress_kpa", std::move(ogdens)},
            {"error_percent", number_or_none(small.percent)},
            {"fitted_young_modulus_kpa", number_or_none(fit.young_modulus_kpa)},
            {"fitted_error_percent", number_or_none(fit.percent)},
            {"ogden_young_modulus_kpa", number_or_none(passport.ogden_young_modulus_kpa)},
            {"ogden_alpha",
             passport.curve.empty() ? SettingValue() : SettingValue(passport.ogden_alpha)},
            {"ogden_error_percent", number_or_none(ogden.percent)}};
}

}  // namespace pliant
