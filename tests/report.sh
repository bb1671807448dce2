#!/usr/bin/env bash
# Makes pages by `cylfuse fit --report`, `cylfuse detect --report` and `cylfuse bench`, and tries them in a browser at desktop
# and phone width.
# Ends with `report: N passed, N failed`. Installs chromium and Node from Debian, the driver of the browser from npm.
# tests/report.sh [FOLDER]: leaves pages and their pictures in the folder.
set -euo pipefail
# Messages and numbers of tools as they are read here.
export LC_ALL=C.UTF-8
cd "$(dirname "$0")/.."

source packaging/debian.sh
require chromium chromium node nodejs npm npm

# The program that the tests run: with their dependencies, so that after them nothing is compiled again.
cargo test --locked --release --features bench --test command_line --no-run
cylfuse=${CARGO_TARGET_DIR:-target}/release/cylfuse
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
pages=${1:-$work/pages}
mkdir -p "$pages" "$work/frames" "$work/driver"

# Frames of the repository, one whose name is markup, and one that cannot be read.
cp -r tests/data/frames/{r40_a20_f0,w004,w022} "$work/frames"
cp -r tests/data/frames/w004 "$work/frames/<img src=x onerror=console.error(1)>"
"$cylfuse" twin --kind single --count 1 --seed 3 --out "$work/frames" >/dev/null
mkdir "$work/frames/zz_damaged"
echo '{}' >"$work/frames/zz_damaged/frame.json"
"$cylfuse" fit "$work/frames" --report "$pages/fit.html" --tolerance radius=0.0375..0.05 >"$work/table.txt" 2>&1 || true
"$cylfuse" detect tests/data/scene --report "$pages/detect.html" >>"$work/table.txt" 2>&1
"$cylfuse" fit "$work/frames/zz_damaged" --report "$pages/empty.html" >>"$work/table.txt" 2>&1 || true

"$cylfuse" bench --smallest --only compare --only weights --only pipes --out "$work/bench" >>"$work/table.txt" 2>&1
cp "$work/bench/index.html" "$pages/bench.html"

cp tests/report/check.js "$work/driver"
(cd "$work/driver" && npm install --no-audit --no-fund --no-save --loglevel=error puppeteer-core@24.43.1)
node "$work/driver/check.js" "$(command -v chromium)" "$pages"
