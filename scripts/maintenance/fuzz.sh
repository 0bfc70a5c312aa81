#!/usr/bin/env bash
# Feeds selectors and cameras with generated input under AddressSanitizer, UndefinedBehaviorSanitizer and LeakSanitizer,
# and fails if one crashes, hangs, leaks or violates its contract. The programs in test/fuzz/ describe the checks.
#   scripts/maintenance/fuzz.sh [SECONDS_EACH [NAME...]]      default: 60 s for "camera" and for each selector, with its presets
#   scripts/maintenance/fuzz.sh 600 lpm ransac:f
# One selector per processor core is tested at a time. Inputs that reached new code are kept in the build folder, and
# the next run continues from them. GTEST_TOTAL_SHARDS and GTEST_SHARD_INDEX, which divide GoogleTest's tests, divide the
# selectors, too.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/../common.sh"

case ${1:-} in
  -h | --help) sed -n '2,8s/^# //p' "${BASH_SOURCE[0]}" && exit 0 ;;
  *[!0-9]*) echo "fuzz.sh: unknown argument '$1'; valid: a number of seconds, then names of selectors or camera, --help" >&2 && exit 2 ;;
esac
seconds=${1:-60}
shift || true
install_packages "${build_packages[@]}" "${test_packages[@]}" "${sanitizer_packages[@]}"
build_dir=$build_dir/sanitized
build_sanitized fuzz_camera fuzz_select
camera_program=$(find "$build_dir" -name fuzz_camera -type f)
select_program=$(find "$build_dir" -name fuzz_select -type f)
names=("$@")
[ $# -gt 0 ] || mapfile -t names < <(echo camera && "$select_program" --list)
for i in "${!names[@]}"; do
  ((i % ${GTEST_TOTAL_SHARDS:-1} == ${GTEST_SHARD_INDEX:-0})) || unset "names[i]"
done
names=("${names[@]}")
if [ ${#names[@]} -eq 0 ]; then
  echo "fuzz.sh: part ${GTEST_SHARD_INDEX:-0} of ${GTEST_TOTAL_SHARDS:-1} has no selector; GTEST_SHARD_INDEX begins at 0" >&2
  exit 2
fi

# fuzz NAME: runs the fuzzer on one selector, or on cameras, and prints one line, or more if it failed.
fuzz() {
  local name=$1 inputs=$build_dir/inputs/$1 log=$build_dir/$1.log program=$select_program
  [ "$name" != camera ] || program=$camera_program
  mkdir -p "$inputs"
  # The outer limit is far beyond -max_total_time. It ends hangs that -timeout does not detect.
  if CORRSEL_FUZZ_SELECTOR=$name timeout $((seconds * 2 + 120)) "$program" -timeout=30 -rss_limit_mb=2048 \
    -max_total_time="$seconds" -max_len=4096 -len_control=0 -print_final_stats=1 \
    -artifact_prefix="$build_dir/$name-" "$inputs" >"$log" 2>&1; then
    echo "$name: $(sed -n 's/^stat::number_of_executed_units: *//p' "$log") executions"
  else
    echo "$name: FAILED (log: $log)"
    grep -aE '^SUMMARY|runtime error|ERROR|^'"${name%%:*}"'.* with|Test unit written' "$log" | head -n 8 || true
    echo "  to repeat: CORRSEL_FUZZ_SELECTOR=$name $program FILE"
    return 1
  fi
}

say "fuzzing, $seconds s each"
# Each background job handles every nproc-th selector.
jobs=()
for ((first = 0; first < $(nproc); ++first)); do
  (
    code=0
    for ((i = first; i < ${#names[@]}; i += $(nproc))); do fuzz "${names[i]}" || code=1; done
    exit "$code"
  ) &
  jobs+=($!)
done
code=0
for job in "${jobs[@]}"; do wait "$job" || code=1; done
[ "$code" -eq 0 ] || { echo "FAILED: see above" >&2 && exit 1; }
echo "no fault was found in $seconds s for each of ${#names[@]} targets"
