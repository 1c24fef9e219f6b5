// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "formats/recorded_files.h"

#include <array>
#include <cmath>
#include <limits>

#include "base/text.h"
#include "support/random.h"

namespace pliant::test {
namespace {

MadeScan nifti_scan(const std::string& name, const NiftiFile& file, bool gzip = false) {
    return {"nifti " + name,
            {{gzip ? "scan.nii.gz" : "scan.nii", gzip ? gzipped(file.bytes()) : file.bytes()}}};
}

template <class Change>
MadeScan changed_nifti(const std::string& name, const Change& change) {
    NiftiFile file;
    change(file);
    return nifti_scan(name, file);
}

void add_nifti_types(MadeScans& scans) {
    constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
    struct Scale {
        float slope, intercept;
    };
    const Scale scales[] = {{0, 0},
                            {1, 0},
                            {1, -1024},
                            {2, 0},
                            {0.25F, -1000},
                            {-1, 0.5F},
                            {0.001F, 0},
                            {1e-20F, 1},
                            {3.0517578F, -1e4F},
                            {kNan, 0},
                            {kNan, kNan},
                            {0, kNan},
                            {1.0000001F, 1e-9F},
                            {1, 1e-17F}};
    for (const NumberType& type : number_types())
        for (const bool big_endian : {false, true}) {
            NiftiFile file;
            file.datatype = type.nifti;
            file.bitpix = std::int16_t(8 * type.size);
            file.big_endian = big_endian;
            file.data = big_endian ? big(type) : type.data;
            for (const Scale& scale : scales) {
                file.slope = scale.slope;
                file.intercept = scale.intercept;
                const std::string name = type.name + std::string(big_endian ? " big / " : " / ") +
                                         text_of(double(scale.slope)) + " " +
                                         text_of(double(scale.intercept));
                scans.push_back(nifti_scan(name, file));
                scans.push_back(nifti_scan(name + " gzip", file, true));
            }
        }
}

void add_nifti_forms(MadeScans& scans) {
    for (const std::int16_t qform_code : {-1, 0, 1, 2, 3, 4})
        for (const std::int16_t sform_code : {-1, 0, 1, 2, 3, 4, 5})
            for (const float qfac : {1.F, -1.F, 0.F})
                for (const int which : {0, 1}) {
                    NiftiFile file;
                    file.qform_code = qform_code;
                    file.sform_code = sform_code;
                    file.pixdim = {qfac, 1, 1.5F, 2, 0, 0, 0, 0};
                    if (which == 0) {  // another position than the sform's
                        file.qform = {0.5, 0.5, 0.5, 4, 5, 6};
                        file.sform = {1, 0, 0, 10, 0, 1.5F, 0, 20, 0, 0, 2, 30};
                    } else {  // the same
                        file.qform = {0, 0, 0, 10, 20, 30};
                        file.sform = {1, 0, 0, 10, 0, 1.5F, 0, 20, 0, 0, qfac < 0 ? -2.F : 2.F, 30};
                    }
                    scans.push_back(nifti_scan(
                        "forms " + std::to_string(qform_code) + " " + std::to_string(sform_code) +
                            " / " + text_of(double(qfac)) + " " + std::to_string(which),
                        file));
                }
    for (const char units : {0, 1, 2, 3, 10, 11, 19, 26})
        for (const int form : {0, 1, 2})
            scans.push_back(changed_nifti(
                "units " + std::to_string(units) + " / " + std::to_string(form), [&](NiftiFile& f) {
                    f.units = units;
                    f.qform_code = form == 1, f.sform_code = form == 2;
                    f.pixdim = {1, 0.7F, 0.3F, 1.1F, 0, 0, 0, 0};
                    f.qform = {0.1F, -0.2F, 0.3F, 1.1F, 2.2F, 3.3F};
                    f.sform = {0.7F, 0, 0, 1.1F, 0, 0.3F, 0, 2.2F, 0, 0, 1.1F, 3.3F};
                }));
    scans.push_back(changed_nifti("pixdim unlike the sform",
                                  [](NiftiFile& f) { f.pixdim = {1, 3, 4, 5, 0, 0, 0, 0}; }));
    scans.push_back(changed_nifti("quaternion of length 1.005", [](NiftiFile& f) {
        f.sform_code = 0, f.qform_code = 1, f.qform = {0.6F, 0.8F, 0.1F, 0, 0, 0};
    }));
    scans.push_back(changed_nifti("sform slightly skew", [](NiftiFile& f) {
        f.sform = {1, 0.0002F, 0, 10, 0, 1, 0.0002F, 20, 0, 0, 2, 30};
    }));
}

void add_nifti_headers(MadeScans& scans) {
    const std::array<std::int16_t, 8> shapes[] = {
        {3, 4, 3, 2, 1, 1, 1, 1}, {4, 4, 3, 2, 1, 1, 1, 1}, {5, 4, 3, 2, 1, 1, 1, 1},
        {7, 4, 3, 2, 1, 1, 1, 1}, {3, 4, 3, 2, 5, 6, 7, 8}, {3, 4, 3, 2, 0, 0, 0, 0},
        {3, 4, 3, 2, -1, 0, 9, 0}};
    int number = 0;
    for (const auto& dim : shapes)
        scans.push_back(
            changed_nifti("dim " + std::to_string(number++), [&](NiftiFile& f) { f.dim = dim; }));
    for (const float offset : {352.F, 353.F, 352.5F, 368.F, 4096.F})
        for (const bool gzip : {false, true}) {
            NiftiFile file;
            file.vox_offset = offset;
            file.data = std::string(std::size_t(offset) - 352, 'x') + file.data;
            scans.push_back(nifti_scan(
                "vox_offset / " + text_of(double(offset)) + (gzip ? " gz" : ""), file, gzip));
        }
    scans.push_back(changed_nifti("long data", [](NiftiFile& f) { f.data += "more"; }));
    for (const std::int16_t intent : {0, 1002, 1003, 1005, 1006, 1007, 2001}) {
        std::string bytes = NiftiFile().bytes();
        std::string code = packed<std::int16_t>({intent});
        bytes.replace(68, 2, code);
        scans.push_back({"nifti intent / " + std::to_string(intent), {{"scan.nii", bytes}}});
    }
    std::string bytes = NiftiFile().bytes();
    bytes.replace(148, 9, "a comment");
    bytes.replace(328, 6, "intent");
    scans.push_back({"nifti words", {{"scan.nii", bytes}}});
}

/// A random unit quaternion with a ≥ 0.
std::array<double, 4> random_turn(Random& random) {
    for (;;) {
        std::array<double, 4> q{};
        double length = 0;
        for (double& part : q) {
            part = random.real(-1, 1);
            length += part * part;
        }
        if (length < 0.01 || length > 1) continue;
        for (double& part : q) part /= (q[0] < 0 ? -1 : 1) * std::sqrt(length);
        if (q[0] < 0) q[0] = -q[0];
        return q;
    }
}

/// Columns of the rotation that a quaternion stands for.
std::array<std::array<double, 3>, 3> nifti_columns_of(const std::array<double, 4>& q) {
    const double a = q[0], b = q[1], c = q[2], d = q[3];
    return {{{a * a + b * b - c * c - d * d, 2 * (b * c + a * d), 2 * (b * d - a * c)},
             {2 * (b * c - a * d), a * a + c * c - b * b - d * d, 2 * (c * d + a * b)},
             {2 * (b * d + a * c), 2 * (c * d - a * b), a * a + d * d - c * c - b * b}}};
}

struct Family {
    const char* name;
    double max_offset_mm;
    double noise;     ///< of the sform's entries, relative
    bool same;        ///< the sform equals the qform
    bool along_axes;  ///< no turn, or a half one
    double least_mm, most_mm;
};

NiftiFile random_file(Random& random, const Family& family) {
    NiftiFile file;
    std::array<double, 4> q = random_turn(random);
    if (family.along_axes) {
        q = {};
        q[std::size_t(random.whole(0, 3))] = 1;
    }
    const float qfac = random.whole(0, 1) ? 1.F : -1.F;
    file.pixdim[0] = qfac;
    for (std::size_t a = 1; a < 4; ++a) {
        // A power instead of std::pow, whose last bit differs between machines.
        const double t = random.real(0, 1);
        file.pixdim[a] = float(family.least_mm + (family.most_mm - family.least_mm) * t * t * t);
    }
    for (std::size_t a = 0; a < 3; ++a) {
        file.qform[a] = float(q[a + 1]);
        file.qform[a + 3] = float(random.real(-family.max_offset_mm, family.max_offset_mm));
    }
    if (!family.same && random.whole(0, 1)) q = random_turn(random);
    const auto columns = nifti_columns_of(q);
    for (std::size_t a = 0; a < 3; ++a)
        for (std::size_t row = 0; row < 3; ++row) {
            const double noise = 1 + family.noise * random.real(-1, 1);
            const double sign = a == 2 && qfac < 0 ? -1 : 1;
            file.sform[4 * row + a] =
                float(sign * columns[a][row] * double(file.pixdim[a + 1]) * noise);
        }
    for (std::size_t row = 0; row < 3; ++row)
        file.sform[4 * row + 3] =
            family.same ? file.qform[row + 3]
                        : float(random.real(-family.max_offset_mm, family.max_offset_mm));
    file.qform_code = std::int16_t(random.whole(0, 2));
    file.sform_code = std::int16_t(random.whole(0, 3));
    file.units = char(random.whole(0, 3));
    return file;
}

}  // namespace

MadeScans nifti_scans() {
    MadeScans scans;
    add_nifti_types(scans);
    add_nifti_forms(scans);
    add_nifti_headers(scans);
    return scans;
}

MadeScans nifti_orientations() {
    const Family families[] = {{"near", 10, 0, true, false, 0.3, 3},
                               {"medium", 200, 0, true, false, 0.3, 3},
                               {"far", 1500, 0, true, false, 0.3, 3},
                               {"far and axial", 1500, 0, true, true, 0.3, 3},
                               {"far and fine", 1500, 0, true, false, 0.01, 0.3},
                               {"far and coarse", 500, 0, true, false, 2, 20},
                               {"noise 1e-6", 300, 1e-6, true, false, 0.3, 3},
                               {"noise 1e-5", 300, 1e-5, true, false, 0.3, 3},
                               {"noise 1e-4", 100, 1e-4, true, false, 0.3, 3},
                               {"noise 3e-4", 10, 3e-4, true, false, 0.3, 3},
                               {"unlike", 200, 0, false, false, 0.3, 3},
                               {"unlike and far", 1500, 0, false, false, 0.3, 3},
                               {"unlike and axial", 1500, 0, false, true, 0.3, 3}};
    MadeScans scans;
    std::uint64_t seed = 1;
    for (const Family& family : families) {
        Random random(seed++);
        for (int n = 0; n < 300; ++n)
            scans.push_back(
                nifti_scan(std::string("random ") + family.name, random_file(random, family)));
    }
    return scans;
}

}  // namespace pliant::test
