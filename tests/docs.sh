#!/usr/bin/env bash
# Builds the site and runs the programs on its pages. Ends with `docs: N passed, N failed`.
# tests/docs.sh [FOLDER]: leaves the site in the folder (target/site); FOLDER/index.html is its first page.
set -uo pipefail
# Messages and numbers of tools as they are read here.
export LC_ALL=C.UTF-8
cd "$(dirname "$0")/.."
source packaging/debian.sh
root=$PWD
target=${CARGO_TARGET_DIR:-$root/target}
site=$(realpath -m "${1:-$target/site}")
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
passed=0 failed=0

# check NAME COMMAND...: counts whether the command succeeds, and shows what it printed when it does not.
check() {
    local name=$1 start=$SECONDS
    shift
    if "$@" > "$work/log" 2>&1; then
        passed=$((passed + 1))
        printf 'ok      %s (%s s)\n' "$name" $((SECONDS - start))
    else
        failed=$((failed + 1))
        printf 'FAILED  %s\n' "$name"
        tail -n 60 "$work/log" | sed 's/^/        /'
    fi
}
# block FILE LANGUAGE NUMBER: a block of code of a page.
block() { awk -v open="\`\`\`$2" -v number="$3" '$0 == open { count++; inside = 1; next } /^```$/ { inside = 0 } inside && count == number' "$1"; }
# blocks FILE LANGUAGE FIRST: from that one on, all of them.
blocks() { awk -v open="\`\`\`$2" -v number="$3" '$0 == open { count++; inside = 1; next } /^```$/ { inside = 0 } inside && count >= number' "$1"; }

printf '\n-- set-up\n'
environment=$target/docs-environment
set_up() {
    python3 -c 'import ensurepip, venv' 2>/dev/null || install python3-venv || return 1
    tests/packages.sh || return 1
    # An environment that was moved does not run.
    "$environment/bin/sphinx-build" --version > /dev/null 2>&1 &&
        cmp -s docs/site/requirements.txt "$environment/requirements.txt" && return
    rm -rf "$environment"
    python3 -m venv "$environment" && "$environment/bin/pip" install -q -r docs/site/requirements.txt &&
        cp docs/site/requirements.txt "$environment"
}
check "Sphinx" set_up
# Those that the tests run: with their dependencies, so that after them nothing is compiled again.
check "library and program" cargo test --locked --release --features bench --test command_line --no-run
check "installation" make --no-print-directory PROFILE=release install PREFIX="$work/home/.local"
export CYLFUSE_LIBRARY=$target/release/libcylfuse.so

printf '\n-- site\n'
drawings() {
    mkdir -p "$work/images"
    python3 docs/drawings/draw.py "$work/images" || return 1
    for file in "$work"/images/*.svg; do cmp "$file" "docs/images/${file##*/}" || return 1; done
}
check "drawings are what docs/drawings/draw.py makes" drawings
every_name() { # every_name PREFIX PAGE: the page explains each of these constants, in a table or under a heading
    local name missing=0
    for name in $(grep -oE "^#define CYLFUSE_$1_[A-Z0-9_]+ " include/cylfuse/cylfuse.h | sed "s/^#define CYLFUSE_$1_//"); do
        grep -qE "^(\| \`$name\` \||#### $name$)" "$2" || { echo "$2 does not have $name"; missing=1; }
    done
    return $missing
}
check "every warning is explained" every_name RESULT_FLAGS docs/warnings.md
every_text() { # the page of warnings quotes what the command line prints about each
    local text missing=0
    while read -r text; do
        grep -qF "$text" docs/warnings.md || { echo "docs/warnings.md does not quote: $text"; missing=1; }
    done < <(sed -n '/^fn explain(/,/^}/p; /^fn disagreement(/,/^}/p; /^fn poor(/,/^}/p' src/bin/cylfuse/report/mod.rs |
        grep -oE '"(\{\} )?[a-z][^"{]+' | sed 's/^"\({} \)\?//' | grep -v '^flag ')
    return $missing
}
every_number() { # the page of warnings has the number of each
    local name number missing=0
    while read -r _ name number; do
        grep -qF "$number | [$name](#" docs/warnings.md || { echo "docs/warnings.md does not have $number for $name"; missing=1; }
    done < <(sed -n 's/^#define CYLFUSE_RESULT_FLAGS_/flag /p' include/cylfuse/cylfuse.h)
    return $missing
}
check "every warning has its number" every_number
check "every warning is quoted" every_text
check "every status is explained" every_name STATUS docs/warnings.md
check "every state of an end is explained" every_name END_STATE docs/concepts.md
rm -rf "$site"
mkdir -p "$site"
check "pages" "$environment/bin/sphinx-build" -q -W --keep-going -d "$work/doctrees" -c docs/site . "$site"
check "reference of C and C++" env OUTPUT="$work/doxygen" doxygen docs/Doxyfile
check "reference of Rust" env RUSTDOCFLAGS="-D warnings" cargo doc --locked --release --features bench --no-deps --lib
mkdir -p "$site/reference"
cp -r "$work/doxygen/html" "$site/reference/cpp"
mkdir -p "$site/reference/rust"
cp -r "$target/doc/." "$site/reference/rust"
check "links" "$environment/bin/python" tests/docs/links.py "$site"

printf '\n-- programs of the first pages, as they stand there\n'
frame=$root/tests/data/frames/r40_a20_f0
home() { env HOME="$work/home" CARGO_HOME="${CARGO_HOME:-$HOME/.cargo}" RUSTUP_HOME="${RUSTUP_HOME:-$HOME/.rustup}" PKG_CONFIG_PATH="$work/home/.local/lib/pkgconfig" "$@"; }
radius_is() { # radius_is REGEX FOLDER COMMANDS: run there, they print a radius like this
    local output
    output=$(cd "$2" && home bash -euc "$3" 2>&1) || { printf '%s\n' "$output"; return 1; }
    grep -Eq "$1" <<< "$output" || { printf 'no "%s" in:\n%s\n' "$1" "$output"; return 1; }
}
project() { # project PAGE LANGUAGE FILE: the program, and CMakeLists.txt where the page has one
    folder=$work/$(basename "$1" .md)
    mkdir -p "$folder"
    block "$1" "$2" 1 > "$folder/$3"
    block "$1" cmake 1 > "$folder/CMakeLists.txt"
}
command_line() (
    mkdir -p "$work/command_line/my-frame"
    cd "$work/command_line" || return 1
    ln -s "$root/tests" tests
    cp "$frame"/{image,depth,mask}.png my-frame
    block "$root/docs/start/command-line.md" json 1 | sed 's/0\.001/0.0001/' > my-frame/frame.json
    # The first block builds, the last but one needs a cloud, which the one before it has written.
    blocks "$root/docs/start/command-line.md" sh 2 | sed 's|cloud.ply|results/completed.ply|' > page.sh
    PATH=$target/release:$PATH bash -eu page.sh || return 1
    for file in results/overlay.png results/completed.ply batch.jsonl report.html; do test -s "$file" || return 1; done
    [ "$(wc -l < batch.jsonl)" = 3 ]
)
check "command line" command_line
project docs/start/python.md python fit_frame.py
check "Python" env PYTHONPATH="$root/bindings/python/src" bash -c "
    '$environment/bin/python' '$folder/fit_frame.py' '$frame' | grep -E '^radius 37\\.[6-9]'"
project docs/start/c.md c fit_frame.c
check "C" radius_is '^radius (39\.9|40\.0)' "$folder" "$(block docs/start/c.md sh 2)"
project docs/start/cpp.md cpp fit_frame.cpp
check "C++" radius_is '^radius (39\.9|40\.0)' "$folder" "$(block docs/start/cpp.md sh 2)"
check "C++ by pkg-config" radius_is '^radius (39\.9|40\.0)' "$folder" "$(block docs/start/cpp.md sh 3)"
project docs/start/opencv.md cpp fit_frame.cpp
check "OpenCV" radius_is '^radius 37\.[6-9]' "$folder" "$(block docs/start/opencv.md sh 1 | sed "s|path/to/cylfuse|$root|")"
check "OpenCV's overlay" test -s "$folder/overlay.png"
project docs/start/other-languages.md rust main.rs
check "Rust" radius_is '^radius 0\.500000' "$folder" "rustc --edition 2021 -L dependency='$target/release/deps' \
    --extern cylfuse='$target/release/libcylfuse.rlib' main.rs && ./main"

printf '\ndocs: %s passed, %s failed\n' $passed $failed
[ $failed = 0 ]
