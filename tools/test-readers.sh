#!/usr/bin/env bash
# Exports a tiny run to every format and reads each back with its own community's reader (tests/readers). Needs python3.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
# shellcheck source=tools/prepare.sh
. tools/prepare.sh
# shellcheck source=tools/python-env.sh
. tools/python-env.sh

prepare_build
cargo build --release --locked
prepare_adapter
python_env numpy==2.2.6 mcap==1.6.0 gsd==4.0.0 ase==3.25.0 vtk==9.5.0

work=${CARGO_TARGET_DIR:-target}/readers
rm -rf "$work"
"$squirm" run tests/readers/run.toml --out "$work" --quiet
for to in csv vtk gsd xyz npz; do
    "$squirm" export "$work" --to "$to" --every 1
done
"$squirm" info "$work" --json >"$work/info.json"
"$python" tests/readers/test_exports.py "$work"
