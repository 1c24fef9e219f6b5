# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
# shellcheck shell=bash disable=SC2154  # root comes from ./dev
#
# `./dev docs`: the documents as a static site with a search, from docs/, the public headers and the
# Python module. A link that leads nowhere fails. `./dev pictures` makes those of docs/images/*.webp
# that show phantoms.

docs() {
    local bin=$root/build/python-docs/bin
    need_packages build test
    compile_with_gcc --target pliant_python_stub
    environment docs
    "$bin/python" "$root/tools/site/make_site.py" "$root" "$root/build/gcc/python/_core.pyi" \
        "$root/build/site-pages"
    NO_MKDOCS_2_WARNING=1 "$bin/mkdocs" build --quiet --strict -f "$root/build/mkdocs.yml"
    say "done: build/site/index.html; to search it: python3 -m http.server -d build/site"
}

pictures() { # [NAME…]
    need_packages build test wheel
    compile_with_gcc --target pliant_app pliant_decoder pliant_python pliant_python_stub \
        pliant_python_settings
    environment pictures
    local module=$root/build/python-module
    rm -rf "$module"
    cmake --install "$root/build/gcc" --prefix "$module" --component python >/dev/null
    cp -r "$root"/python/pliant/. "$module/pliant/"
    PYTHONPATH=$module PYTHONDONTWRITEBYTECODE=1 "$root/build/python-pictures/bin/python" \
        "$root/tools/site/make_pictures.py" "$root/build/gcc/pliant" "$root" \
        "$root/docs/images" "$@"
    say "done: look at them before they are committed"
}
