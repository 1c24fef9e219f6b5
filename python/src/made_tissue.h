// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Tissues of Python for other parts of the module.

#pragma once

#include <pliant/models/scan_tissue.h>
#include <pliant/own_tissue.h>
#include <pliant/tissue.h>

#include "keywords.h"
#include "volumes.h"

namespace pliant::python {

/// Settings of the elastic scan that suit a scan.
ElasticScanSettings elastic_settings_for(const Volume& scan);
/// Settings of a scan's tissue from its model and keyword arguments.
/// @param chainmail  what they change; the elastic scan's suit the scan
ScanTissueSettings scan_tissue_from(const std::string& model, const nb::dict& given,
                                    const Volume& scan, ChainMailSettings chainmail = {});
/// Keywords of all models of a scan's tissue.
Keywords scan_tissue_keywords();

/// The call of a function of the module that makes a tissue again, for pickle. Its arguments must
/// not change afterwards.
struct MakerCall {
    const char* function;  ///< a member's is "Class.function"
    nb::tuple arguments;
    nb::dict settings{};
};

/// Makes a Tissue of Python, with threads of its own. It keeps the scan.
nb::object tissue_of(const nb::object& scan, int threads, const MakeTissue& make, MakerCall maker);
/// The tissue in an object of Python, which must outlive it; null for other objects.
Tissue* find_tissue(nb::handle object);
/// Keeps it for a call. @pre find_tissue(object)
void claim_tissue(nb::handle object, Claim& claim);

/// The scan in a Volume, or as a Tissue has it now, with its owner.
struct SeenScan {
    nb::object owner;
    const Volume& volume() const { return nb::cast<const PyVolume&>(owner).volume; }
};
inline SeenScan seen_scan(nb::handle scan) {
    const nb::object owner =
        find_tissue(scan) ? nb::object(scan.attr("volume")()) : nb::borrow(scan);
    if (!nb::isinstance<PyVolume>(owner)) {
        const std::string found = nb::cast<std::string>(nb::str(scan.type()));
        raise({ErrorCode::InvalidArgument, "scan: expected a Volume or a Tissue, found " + found,
               "scan", "a Volume or a Tissue", found});
    }
    return {owner};
}

}  // namespace pliant::python
