#!/usr/bin/env bash
# Builds, repeats the run of test/regression, compares the stored results with the new ones, and stores the new ones
# in test/regression/expected. Commit them together with the change that caused them.
#   scripts/maintenance/update_regression.sh            CMake arguments may follow
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/../common.sh"

case ${1:-} in
  -h | --help) sed -n '2,4s/^# //p' "${BASH_SOURCE[0]}" && exit 0 ;;
esac
install_packages "${build_packages[@]}" "${test_packages[@]}"
build all -- "$@"
use_workspace
"$package_dir/scripts/fetch_samples.sh"

regression=$package_dir/test/regression
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
say "running the benchmark on the sample set"
"$regression/run.sh" "$work/run" all >"$work/log" 2>&1 || {
  tail -n 20 "$work/log" >&2
  echo "the run is not complete: the lines above are the end of its output. Nothing was replaced." >&2
  exit 1
}

# The last four columns hold times, which differ from run to run.
mkdir "$work/expected"
cp "$work/run/config.yaml" "$work/expected/"
sed -E '3,$s/(,[^,]*){4}$/,,,,/' "$work/run/pairs.csv" >"$work/expected/pairs.csv"

if [ -f "$regression/expected/pairs.csv" ]; then
  say "comparing the stored results with the new ones"
  code=0
  "$regression/compare.sh" "$regression/expected" "$work/expected" || code=$?
  [ "$code" -le 1 ] || say "the stored results cannot be compared (see above); they are replaced"
fi
mkdir -p "$regression/expected"
cp "$work/expected/config.yaml" "$work/expected/pairs.csv" "$regression/expected/"
say "replaced $regression/expected ($(du -ch --apparent-size "$regression"/expected/* | tail -n 1 | cut -f1))"
