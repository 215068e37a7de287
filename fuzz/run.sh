#!/usr/bin/env bash
# Fuzzes pipeline files, recordings and snapshots with libFuzzer, 300 s each or as many as the first argument says. Needs a nightly
# compiler and `cargo install cargo-fuzz`. Starts from the files that ship and from a small run.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

seconds=${1:-300}
corpus=fuzz/corpus
mkdir -p $corpus/pipeline $corpus/recording $corpus/snapshot
find pipelines -name '*.toml' | while read -r file; do
    cp "$file" "$corpus/pipeline/$(echo "$file" | tr / -)"
done
if ! ls $corpus/recording/*.mcap >/dev/null 2>&1; then
    run=$(mktemp -d)
    trap 'rm -rf "$run"' EXIT
    target/release/squirm run pipelines/quickstart.toml --quiet --out "$run/run" --set box.size=[12,8,12] --set run.steps=8 --set fluid.density=2 \
        --set squirmers.puller.count=1 --set output.0.every=4 --set output.1.every=4
    cp "$run"/run/*.mcap $corpus/recording/
fi
for target in pipeline recording snapshot; do
    cargo +nightly fuzz run "$target" -- -max_total_time="$seconds" -max_len=65536 -timeout=10 -rss_limit_mb=2048 -print_final_stats=1
done
