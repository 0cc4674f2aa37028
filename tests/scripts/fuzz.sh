#!/usr/bin/env bash
# Fuzzes each target of tests/fuzz for a time, one after the other, and prints a table:
# executions, edges of the code that were reached at first and at last, seconds since
# the last new one, and findings.
#
#   tests/scripts/fuzz.sh [SECONDS [TARGET …]]      60 seconds of each target if not given
#
# Fails if something was found. The input is then in tests/fuzz/artifacts/TARGET; the log
# beside the corpus says what does not hold of it. Corpora stay in tests/fuzz/corpus: the
# next run goes on from there.
#
# Needs a nightly Rust, a C++ compiler, and `cargo install cargo-fuzz --locked`. Dependencies
# are those of the workspace's lock file.
set -euo pipefail
cd "$(dirname "$0")/../.."

seconds=${1:-60}
shift || true
targets=("$@")
folder=tests/fuzz
cp Cargo.lock $folder/
if [ ${#targets[@]} -eq 0 ]; then
    mapfile -t targets < <(cargo +nightly fuzz list --fuzz-dir $folder)
fi

# The code is safe Rust: a sanitizer of addresses would halve the speed for nothing.
cargo +nightly fuzz build --fuzz-dir $folder --sanitizer none

printf '%-12s %12s %10s %10s %10s %9s\n' \
    target executions 'edges at 0' 'edges now' 'last new s' findings
failed=0
for target in "${targets[@]}"; do
    corpus=$PWD/$folder/corpus/$target
    log=$corpus.log
    options=()
    words=$folder/dictionaries/$target.dict
    if [ -e "$words" ]; then options+=("-dict=$words"); fi
    mkdir -p "$corpus" "$folder/artifacts/$target"
    FUZZ_SEEDS=$corpus nice -n 19 cargo +nightly fuzz run --fuzz-dir $folder --sanitizer none \
        "$target" "$corpus" -- -max_total_time="$seconds" -rss_limit_mb=6144 -timeout=20 \
        -max_len=65536 -print_final_stats=1 "${options[@]}" >"$log" 2>&1 || failed=1
    awk -v target="$target" -v seconds="$seconds" '
        function edges() { for (i = 1; i < NF; i++) if ($i == "cov:") return $(i + 1) }
        function rate() { for (i = 1; i < NF; i++) if ($i == "exec/s:") return $(i + 1) }
        /\tINITED/ { first = edges(); now = first }
        /\tNEW/ {
            now = edges()
            split($1, count, "#")
            if (rate() > 0) last = count[2] / rate()
        }
        /number_of_executed_units/ { executions = $2 }
        /SUMMARY: libFuzzer/ { findings++ }
        END { printf "%-12s %12d %10d %10d %10d %9d\n",
              target, executions, first, now, last, findings }' "$log"
done
exit $failed
