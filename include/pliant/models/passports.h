// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Material passports: measured elasticity of tissues and phantom silicones, with sources, and the
// error of the library's laws of bodies on the measured curves.
//
// @code
//   BodySettings settings;
//   if (const MaterialPassport* liver = find_material("liver")) {
//       settings.young_modulus_pa = 1e3 * liver->young_modulus_kpa;
//       settings.poisson_ratio = liver->poisson_ratio;
//       settings.density_kg_m3 = liver->density_kg_m3;
//   }
// @endcode
//
// docs/reference/materials.md has the table.

#pragma once

#include <pliant/core/record.h>

#include <span>
#include <string_view>

#pragma GCC visibility push(default)
namespace pliant {

enum class LoadCase { Tension, Compression, Shear };

struct StressPoint {
    LoadCase load = LoadCase::Tension;
    double strain = 0;      ///< stretch − 1; for shear, displacement over height
    double stress_kpa = 0;  ///< nominal: force per area at rest; below 0 in compression
};

/// Measured properties of an isotropic material. Texts are one line each.
struct MaterialPassport {
    std::string_view name{};       ///< in lower case, without blanks
    std::string_view sample{};     ///< the material, and how it was measured
    std::string_view source{};     ///< key in docs/references.bib, of modulus and curve
    std::string_view licence{};    ///< of the data
    double young_modulus_kpa = 0;  ///< at small strain
    double deviation_kpa = 0;      ///< standard deviation of the modulus; 0: not published
    double poisson_ratio = 0;      ///< 0.49 where the source takes it as incompressible
    double density_kg_m3 = 0;      ///< typical, from density_source
    std::string_view density_source{};
    std::span<const StressPoint> curve{};  ///< empty: none is available
    /// Parameters of Ogden's law that fit the curve best; 0: there is no curve.
    double ogden_young_modulus_kpa = 0, ogden_alpha = 0;
    std::string_view limits{};  ///< where the law fails, or further measured values; may be empty
};

/// All passports: tissues, then silicones from stiff to soft. Static data.
std::span<const MaterialPassport> material_passports() noexcept;
/// The passport with a name, or null.
const MaterialPassport* find_material(std::string_view name) noexcept;

/// Nominal stress of the stable neo-Hookean law of bodies [Smith2018, Macklin2021], in the unit of
/// the modulus. With Lamé's λ and µ, stretch s = 1 + strain and sides free of stress,
///
///   P = µ (s − J/s²),   J = 1 + µ (1 − 1/s)/(λ + µ);   in shear P = µ · strain.
///
/// @pre young_modulus > 0, 0 ≤ poisson_ratio < 0.5, strain > −1 in tension and compression
double neo_hookean_stress(double young_modulus, double poisson_ratio, LoadCase load,
                          double strain) noexcept;

/// Nominal stress of the one-term Ogden law of bodies [Ogden1972], in the unit of the modulus. With
/// Lamé's λ and µ, and stretches λᵢ of the product J, the energy per volume is
///
///   ψ = 2µ/α² (λ₁^α + λ₂^α + λ₃^α − 3) − 2µ/α (J − 1) + (λ/2 + µ/α) (J − 1)².
///
/// Sides are free of stress. α = 2 is the neo-Hookean law.
/// @pre as neo_hookean_stress(); alpha 2 to 40, or −40 to −1 and λ + 2µ/alpha > 0
double ogden_stress(double young_modulus, double poisson_ratio, double alpha, LoadCase load,
                    double strain) noexcept;

/// A law on a measured curve.
struct LawError {
    double young_modulus_kpa = 0;
    /// Root mean square of law minus measurement, in percent of that of the measurement; over all
    /// points, and by load case. 0 without points.
    double percent = 0, tension_percent = 0, compression_percent = 0, shear_percent = 0;
    double ogden_alpha = 2;  ///< 2: neo-Hookean
};

/// Error of Ogden's law with a modulus and an exponent; by default the neo-Hookean law.
LawError law_error(const MaterialPassport& passport, double young_modulus_kpa,
                   double ogden_alpha = 2) noexcept;
/// Error of the neo-Hookean law with the modulus of least squares over the points up to a strain;
/// shear counts half. Its percentages are of all points. All 0 without such points.
LawError fit_law(const MaterialPassport& passport, double max_strain = 1) noexcept;
/// Error of Ogden's law with the modulus and the negative exponent of least squares over all
/// points. All 0 without points.
LawError fit_ogden(const MaterialPassport& passport) noexcept;

/// Members of a passport by their names, with the curve and the fitted laws' curves as lists, and
/// errors, for JSON and Python. Without a curve the lists are empty, and the errors have no value.
Record record_of(const MaterialPassport& passport);

}  // namespace pliant
#pragma GCC visibility pop
