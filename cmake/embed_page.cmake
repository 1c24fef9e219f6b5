# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
#
# Writes a C++ file that holds the files of a folder, byte for byte, by the assembler's .incbin.
#   cmake -DFOLDER=… -DOUTPUT=… -P embed_page.cmake    no FOLDER, or an empty one: no files

set(files)
if(FOLDER)
    file(GLOB_RECURSE files RELATIVE "${FOLDER}" "${FOLDER}/*")
    list(SORT files)
endif()
set(data "")
set(declarations "")
set(entries "")
set(number 0)
foreach(file IN LISTS files)
    if(file MATCHES "[^A-Za-z0-9_./-]")
        message(FATAL_ERROR "${FOLDER}/${file}: expected letters, digits and _./- in its name")
    endif()
    string(APPEND data
        "    \"pliant_page_${number}: .incbin \\\"${FOLDER}/${file}\\\"\\n\"\n"
        "    \"pliant_page_end_${number}: .byte 0\\n\"\n")
    string(APPEND declarations
        "extern const char pliant_page_${number}[], pliant_page_end_${number}[];\n")
    string(APPEND entries
        "    {\"${file}\", {pliant_page_${number}, "
        "std::size_t(pliant_page_end_${number} - pliant_page_${number})}},\n")
    math(EXPR number "${number} + 1")
endforeach()
if(number EQUAL 0)
    set(body "std::span<const PageFile> built_in_page() { return {}; }\n")
else()
    string(CONCAT body
        "std::span<const PageFile> built_in_page() {\n"
        "    static const PageFile files[] = {\n${entries}    };\n    return files;\n}\n")
    set(symbols "")
    math(EXPR last "${number} - 1")
    foreach(n RANGE ${last})
        string(APPEND symbols "    \".global pliant_page_${n}\\n.global pliant_page_end_${n}\\n\"\n"
            "    \".hidden pliant_page_${n}\\n.hidden pliant_page_end_${n}\\n\"\n")
    endforeach()
    string(CONCAT declarations
        "__asm__(\n    \".pushsection .rodata\\n\"\n${symbols}${data}    \".popsection\\n\");\n"
        "extern \"C\" {\n${declarations}}\n")
endif()
file(WRITE "${OUTPUT}.new"
    "// Made by cmake/embed_page.cmake.\n#include <cstddef>\n\n#include \"network/page.h\"\n\n"
    "${declarations}\nnamespace pliant::serve {\n\n${body}\n}  // namespace pliant::serve\n")
file(COPY_FILE "${OUTPUT}.new" "${OUTPUT}")
file(REMOVE "${OUTPUT}.new")
