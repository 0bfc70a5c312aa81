#!/usr/bin/env bash
# Feeds the selectors with generated input under AddressSanitizer, UndefinedBehaviorSanitizer and LeakSanitizer
# (test/fuzz/fuzz_select.cpp says what is checked). Fails where one crashes, hangs, leaks or breaks its contract.
#   scripts/fuzz.sh [SECONDS_EACH [SELECTOR...]]      60 s of each selector, presets included, unless told otherwise
#   scripts/fuzz.sh 600 lpm ransac:f
# Inputs that reached new code are kept in the build folder, and the next run goes on from them.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"

seconds=${1:-60}
shift || true
install_packages "${build_packages[@]}" "${test_packages[@]}" clang libclang-rt-14-dev

build_dir=$build_dir/fuzz
# Without tracing of comparisons, which takes twice as long as all the rest: the bytes are drawn from, seldom compared.
build fuzz_select -- -DCMAKE_CXX_COMPILER=clang++ -DCMAKE_BUILD_TYPE=None -Dcorrsel_FUZZ=ON \
  -Dcorrsel_SANITIZE=fuzzer-no-link,address,undefined -DCMAKE_CXX_FLAGS="-O2 -g1 -fno-sanitize-coverage=trace-cmp"
program=$(find "$build_dir/devel" -name fuzz_select)
names=("$@")
[ $# -gt 0 ] || mapfile -t names < <("$program" --list)

say "fuzzing, $seconds s each"
failed=()
for name in "${names[@]}"; do
  kept=$build_dir/inputs/$name log=$build_dir/$name.log
  mkdir -p "$kept"
  # Beyond -max_total_time by far: a hang that -timeout missed.
  if CORRSEL_FUZZ_SELECTOR=$name timeout $((seconds * 2 + 120)) "$program" -timeout=10 -rss_limit_mb=2048 \
    -max_total_time="$seconds" -max_len=4096 -len_control=0 -print_final_stats=1 \
    -artifact_prefix="$build_dir/$name-" "$kept" >"$log" 2>&1; then
    echo "$name: $(sed -n 's/^stat::number_of_executed_units: *//p' "$log") executions"
  else
    failed+=("$name")
    echo "$name: FAILED (log: $log)"
    grep -aE '^SUMMARY|runtime error|ERROR|^'"${name%%:*}"'.* with|Test unit written' "$log" | head -n 8 || true
    echo "  again: CORRSEL_FUZZ_SELECTOR=$name $program FILE"
  fi
done
[ ${#failed[@]} -eq 0 ] || {
  echo "FAILED: ${failed[*]}"
  exit 1
}
