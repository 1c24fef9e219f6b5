# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
# shellcheck shell=bash disable=SC2154  # root comes from ./dev
#
# `./dev docs`: the documents as a static site with a search, from docs/, the public headers and the
# Python module. A link that leads nowhere fails.

docs() {
    local bin=$root/build/python-docs/bin
    need_packages build test
    compile_with_gcc --target pliant_python_stub
    environment docs
    "$bin/python" "$root/tools/site/make_site.py" "$root" "$root/build/gcc/python/_core.pyi" \
        "$root/build/site-pages"
    NO_MKDOCS_2_WARNING=1 "$bin/mkdocs" build --quiet --strict -f "$root/build/mkdocs.yml"
    say "done: build/site/index.html"
}
