// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Settings of `pliant fit`: refused by an exception of the command line's reader, or within bounds.

#include <CLI/CLI.hpp>

#include "../../apps/pliant/fit_options.h"
#include "fuzz/fuzz.h"

using namespace pliant;

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const auto file = fuzz::write_anew("f.toml", fuzz::text_of(data, size));
    CLI::App app;
    app::FitOptions options;
    app::add_fit(app, options);
    try {
        app.parse("fit " + file.string());
    } catch (const CLI::Error& error) {
        fuzz::expect(error.what() != std::string(), "a message");
        return 0;
    }
    fuzz::expect(options.evaluations >= 1 && options.depth >= 0 && options.duration_s > 0,
                 "numbers within their bounds");
    for (const std::string& method : options.methods)
        fuzz::expect(method != "none", "known methods", method);
    return 0;
}
