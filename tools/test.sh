#!/usr/bin/env bash
# Runs every test, on the best adapter of this machine or on the CPU: installs what is missing, builds, tests.
# Arguments go to cargo test, as in `tools/test.sh --test tidy`.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
# shellcheck source=tools/prepare.sh
. tools/prepare.sh

prepare_build
say "Building squirm"
cargo build --release --locked
prepare_adapter

say "Testing"
log=$(mktemp)
status=0
cargo test --release --locked --workspace "$@" 2>&1 | tee "$log" || status=$?
awk '/^test result:/ { passed += $4; failed += $6; ignored += $8; suites += 1 }
     END { printf "==> %d suites: %d passed, %d failed, %d ignored\n", suites, passed, failed, ignored }' "$log"
rm -f "$log"
if [ "$status" -ne 0 ]; then
    fail "the tests failed"
fi
say "All tests passed"
