#!/usr/bin/env bash
# Installs what is needed, builds (Release), and times every selector beside what users would pick instead, in one run.
# Writes performance.csv and performance.md to ${XDG_CACHE_HOME:-~/.cache}/corrsel. Arguments:
#   --all            full grid of sizes and inlier ratios (25 minutes) instead of the comparisons with targets (6)
#   --filter REGEX   only some of them, e.g. '^gms' or '^usac:h/N:5000'
#   --csv FILE, --markdown FILE   write there instead; a FILE with marks, as docs/performance.md, keeps its text
#   --benchmark_list_tests        names of all comparisons
# Exit code 0 only where everything was measured, masks agree and all targets are met.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"

for argument in "$@"; do
  case $argument in -h | --help) sed -n '2,8s/^# //p' "${BASH_SOURCE[0]}" && exit 0 ;; esac
done
install_packages "${build_packages[@]}" "${performance_packages[@]}"
build performance -- -DCMAKE_BUILD_TYPE=Release
mkdir -p "$cache_dir"
say "measuring; tables go to $cache_dir/performance.csv and .md unless other files are named"
"$build_dir/devel/lib/corrsel/performance" --csv "$cache_dir/performance.csv" \
  --markdown "$cache_dir/performance.md" "$@"
