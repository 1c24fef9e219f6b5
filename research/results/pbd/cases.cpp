// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Case 5 on several grids: locking of linear tetrahedra, and elements without locking.

#include "cantilever.h"
#include "figures.h"

namespace pliant::results {

void add_cantilever(Page& page, const TaskArena& arena) {
    page.heading(2, "Case 5: a cantilever under its weight");
    page.paragraph(
        "20 × 20 × 200 mm, 1100 kg/m³, E 10 MPa, ν 0.3, held at one end. The tip of a beam sags by "
        "6.541 mm, with shear; 2 % are allowed on 5 × 5 × 30 nodes with elements that don't lock. "
        "The solids here are linear tetrahedra, which do: a vessel's wall of few of them across is "
        "too stiff in bending, whatever the solver.");
    std::vector<std::vector<std::string>> rows;
    const auto add = [&](const char* what, const char* nodes, double sag) {
        rows.push_back({what, nodes, fixed_text(sag, 3),
                        fixed_text(100 * (sag / kCantilever.exact_mm - 1), 1)});
    };
    add("neo-Hookean tetrahedra, position-based", "3 × 3 × 16", sag_of_solids(15, 2, arena));
    add("the same", "5 × 5 × 30", sag_of_solids(29, 4, arena));
    add("trilinear hexahedra, finite elements", "5 × 5 × 30",
        sag_of_hexahedra(HexElement::Trilinear, arena));
    add("hexahedra with inner modes, finite elements", "5 × 5 × 30",
        sag_of_hexahedra(HexElement::IncompatibleModes, arena));
    page.table({"elements", "nodes", "sag [mm]", "against 6.541 mm [%]"}, rows);
}

}  // namespace pliant::results
