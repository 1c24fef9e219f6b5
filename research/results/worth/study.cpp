// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "study.h"

namespace pliant::results {
namespace {

void add(Timed& timed, const Answer& answer, const Errors& errors) {
    timed.errors.add(errors);
    timed.ms += answer.solve_ms;
}

}  // namespace

Study study_of(Body& body, int loads, const std::function<Load(Body&, int)>& load_of,
               const TaskArena& arena) {
    Study study;
    study.name = body.name;
    const double share = 1.0 / loads;
    for (int n = 0; n < loads; ++n) {
        const Load load = load_of(body, n);
        const ChainBody chain(body, arena);
        const Answer fem = finite_elements(body, load, kConverged, arena);
        const auto errors = [&](const Displacements& found) {
            return errors_of(found, fem.displacement_mm, body, load);
        };
        study.prepare_fem_ms += share * fem.prepare_ms;
        study.fem_ms += share * fem.solve_ms;
        study.iterations += share * fem.iterations;
        study.still.add(errors(of_tool_alone(body, load)));
        const auto add_chain = [&](Timed& timed, const Chain& settings) {
            const Answer answer = chain.push(load, settings);
            add(timed, answer, errors(answer.displacement_mm));
            return answer;
        };
        study.default_fraction +=
            share * add_chain(study.by_default, {.offset = kDefaultOffset}).fraction;
        add_chain(study.default_relaxed, {.offset = kDefaultOffset, .sweeps = kSweeps});
        study.best.add(best_offset(chain, fem.displacement_mm, body, load));
        for (const ScanState state : {ScanState::Frame, ScanState::Settled}) {
            const Answer answer = elastic_scan(body, load, state, arena);
            add(state == ScanState::Frame ? study.scan_frame : study.scan_settled, answer,
                errors(answer.displacement_mm));
            study.scan_create_ms += share / 2 * answer.prepare_ms;
        }
        if (n % 5 != 0) continue;
        for (std::size_t t = 0; t < kStopped.size(); ++t) {
            const Answer answer = finite_elements(body, load, kStopped[t], arena);
            add(study.stopped[t], answer, errors(answer.displacement_mm));
        }
    }
    return study;
}

}  // namespace pliant::results
