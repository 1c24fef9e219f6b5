# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
# shellcheck shell=bash disable=SC2154  # root and called_from come from ./dev
#
# The demo: a scan is pushed at one place, and everything that Pliant writes about it lands in
# demo/; at a terminal it ends in the page. Without a file the scan is the airway phantom, pushed at
# its first landmark; with a file `pliant info --suggest-push` names the place.

# The JSON that the program writes has known keys and numbers, so no JSON reader is needed.
flat() { # FILE
    tr -d ' \n' <"$1"
}

json_number() { # FILE KEY FORMAT: printed as printf does
    local number
    number=$(flat "$1" | grep -oE "\"$2\":-?[0-9.eE+-]+" | head -n 1 | cut -d: -f2) || true
    # shellcheck disable=SC2059  # the format is the caller's
    printf "$3" "${number:-0}"
}

json_word() { # FILE KEY
    flat "$1" | grep -oE "\"$2\":\"[^\"]*\"" | head -n 1 | cut -d'"' -f4
}

demo() { # [FILE]
    (($# <= 1)) || fail "demo takes one file at most, found $# (a name with spaces needs quotes)"
    local scan='' name=airway
    if (($# == 1)); then
        scan=$(cd -- "$called_from" && readlink -f -- "$1") || true
        [[ -e $scan ]] ||
            fail "$1: expected a scan (NRRD, MetaImage, NIfTI or a folder of DICOM slices)"
        name=$(stem_of "$scan")
    fi
    build
    mkdir -p "$root/demo"
    local pliant=$root/build/release/pliant out=$root/demo/$name
    if [[ -z $scan ]]; then
        scan=$out.nrrd
        if [[ ! $scan -nt $pliant ]]; then
            say "making a phantom of an airway"
            "$pliant" phantom airway --size 192 --out "$scan" >/dev/null
        fi
    fi
    local push eye look tool=sphere:4
    choose_push "$pliant" "$scan"
    deform "$pliant" "$scan" "$out"
    tell "$pliant" "$scan" "$out"
    show_page "$pliant" "$scan"
}

# Ends in the page at a terminal, until Ctrl+C; otherwise prints the command.
show_page() { # PROGRAM SCAN
    if [[ -t 1 && ${PLIANT_BUILD_VIEWER:-ON} != OFF ]]; then
        say "the page: fly, push and cut in the browser"
        "$1" serve "$2"
    else
        printf "\nThe same in the browser:\n  %s serve '%s'\n" "$1" "$2"
    fi
}

stem_of() { # PATH
    local name
    name=$(basename -- "$1")
    shopt -s nocasematch
    [[ $name =~ ^(.+)\.(nii\.gz|nrrd|nhdr|mha|mhd|nii|dcm)$ ]] && name=${BASH_REMATCH[1]}
    shopt -u nocasematch
    printf '%s\n' "$name"
}

# Sets push, and for a phantom eye and look; the suggestion brings its own tool.
choose_push() { # PROGRAM SCAN
    local info number='-?[0-9.eE+-]+' vector
    vector="$number,$number,$number"
    info=$(mktemp)
    "$1" info "$2" --json --suggest-push >"$info" || {
        rm -f "$info"
        exit 2
    }
    eye='' look='' push=''
    if grep -qE '"landmark [^"]*"' "$info"; then
        local landmark
        landmark=$(grep -oE "push $vector:$vector eye $vector look $vector" "$info" | head -n 1) ||
            true
        read -r _ push _ eye _ look <<<"$landmark"
    else
        local vectors="\"point_mm\":\[($vector)\],\"push_mm\":\[($vector)\]"
        local radius="\"sphere_radius_mm\":($number)"
        if [[ $(flat "$info") =~ \"suggested_push\":\{$vectors,$radius ]]; then
            push=${BASH_REMATCH[1]}:${BASH_REMATCH[2]}
            tool=sphere:${BASH_REMATCH[3]}
        fi
    fi
    rm -f "$info"
    [[ -n $push ]] || fail "$2: found no wall to push by itself. Choose a point on a wall, and run
  $1 deform '$2' --push \"X,Y,Z:DX,DY,DZ\" --tool $tool --out pushed.nrrd --png pushed.png"
}

deform() { # PROGRAM SCAN OUT
    local camera=()
    [[ -z $eye ]] || camera=(--eye="$eye" --look="$look")
    say "pushing at $push (LPS mm, place:motion)"
    "$1" deform "$2" --push "$push" --tool "$tool" "${camera[@]}" \
        --out "$3_pushed.nrrd" --displacement "$3_displacement.nrrd" \
        --transform "$3_transform.nrrd" --report "$3_report.json" \
        --png "$3_before_after.png" --style real >/dev/null
}

tell() { # PROGRAM SCAN OUT
    local report=$3_report.json file
    say "done"
    printf '%s: %s of the push done, limited by %s; %s voxels moved, by up to %s mm.\n' \
        "$(json_word "$report" status)" "$(json_number "$report" step_fraction %.2f)" \
        "$(json_word "$report" limited_by)" "$(json_number "$report" moved_elements %.0f)" \
        "$(json_number "$report" max_movement_mm %.2f)"
    printf 'Solved in %s ms, written back to the grid in %s ms; worst link %s mm off.\n' \
        "$(json_number "$report" solve_ms %.1f)" "$(json_number "$report" resample_ms %.1f)" \
        "$(json_number "$report" max_violation_mm %.6f)"
    printf '\nFiles:\n'
    for file in "$2" "$3"_before_after.png "$3"_pushed.nrrd "$3"_displacement.nrrd \
        "$3"_transform.nrrd "$report"; do
        printf '  %s\n' "$file"
    done
    cat <<TEXT

What to try next:
  Look at the picture: before on the left, after on the right.
  A scan of your own (NRRD, MetaImage, NIfTI, a folder of DICOM slices):
    ./dev demo scan.nrrd
  A wider tool:
    $1 deform '$2' \\
      --push "$push" --tool sphere:8 --out '${3}_wide.nrrd' --png '${3}_wide.png' --style real
  Another view:
    $1 render '${3}_pushed.nrrd' --style real --out '${3}_view.png'
  3D Slicer: open the scan and the transform, apply the one to the other, and compare with the
  pushed scan.
TEXT
}
