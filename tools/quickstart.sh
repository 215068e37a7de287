#!/usr/bin/env bash
# From a fresh clone to a first run: installs what is missing, builds squirm, runs pipelines/quickstart.toml.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
# shellcheck source=tools/prepare.sh
. tools/prepare.sh

prepare_build
say "Building squirm (the first time 5 to 10 minutes on two cores)"
cargo build --release --locked
prepare_adapter

say "Running pipelines/quickstart.toml (a second on a GPU, up to a minute on two cores)"
"$squirm" run pipelines/quickstart.toml

newest=$(find runs -mindepth 2 -maxdepth 2 -path 'runs/quickstart*/run.mcap' -printf '%T@ %p\n' 2>/dev/null | sort -n | tail -n 1 | cut -d ' ' -f 2- || true)
say "Next: $squirm-analyze swim ${newest:-runs/quickstart/run.mcap}, and README.md"
