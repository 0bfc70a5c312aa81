#!/usr/bin/env bash
# Installs what is needed, builds (Release), and measures in one run the time of features, matching and every selector beside
# that of their alternatives.
# Writes performance.csv and performance.md to ${XDG_CACHE_HOME:-~/.cache}/corrsel. Arguments:
#   --all            full grid of sizes and inlier ratios (25 minutes) instead of the comparisons with targets (6)
#   --filter REGEX   only the comparisons that match, e.g. '^gms' or '^usac:h/N:5000'
#   --data_root FOLDER   time features on images of its datasets vgg and kitti_stereo instead of the sample photographs
#   --csv FILE, --markdown FILE   other output files, e.g. docs/data/performance.csv, from which scripts/generate.py makes tables
#   --benchmark_list_tests        prints the names of all comparisons
# With POSELIB_DIR=FOLDER in the environment, which holds the sources of PoseLib, `pose` is timed beside it, too.
# Exit code 0 only if everything was measured, the masks agree and all targets are met.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/../common.sh"

for argument in "$@"; do
  case $argument in -h | --help) sed -n '2,11s/^# //p' "${BASH_SOURCE[0]}" && exit 0 ;; esac
done
install_packages "${build_packages[@]}" "${performance_packages[@]}"
build performance -- -DCMAKE_BUILD_TYPE=Release "-Dcorrsel_POSELIB_DIR=${POSELIB_DIR:-}"
mkdir -p "$cache_dir"
"$package_dir/scripts/fetch_samples.sh" "$cache_dir/sample"
say "measuring (tables: $cache_dir/performance.csv and .md, unless other files are given)"
arguments=("$@")
for default in "--csv=$cache_dir/performance.csv" "--markdown=$cache_dir/performance.md" "--samples=$cache_dir/sample"; do
  case " $* " in *" ${default%%=*}"[\ =]*) ;; *) arguments+=("$default") ;; esac
done
"$build_dir/devel/lib/corrsel/performance" "${arguments[@]}"
