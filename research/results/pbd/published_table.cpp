// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "figures.h"
#include "published.h"

namespace pliant::results {

void add_published(Page& page) {
    page.heading(2, "Cases in closed form, or with published figures");
    page.paragraph(
        "All are computed anew for this page; what is expected is a closed form, another program's "
        "figure, another method or brute force, as the case says. \"Expected 0\" is an error. The "
        "same functions are run by the tests, which fail where one doesn't hold. "
        "[pbd.md](../../method/pbd.md) says more about some of them.");
    std::vector<std::vector<std::string>> rows;
    for (const auto& cases :
         {gradient_cases, momentum_cases, spring_cases, chain_cases, cantilever_cases,
          elastica_cases, joint_cases, arc_cases, ring_cases, falling_beam_cases, tube_cases,
          drop_cases, turned_cases, hash_cases, overlap_cases})
        for (const Case& c : cases()) rows.push_back(row_of(c));
    page.table({"case", "what", "expected", "measured", "tolerance", "holds"}, rows);
}

}  // namespace pliant::results
