#!/usr/bin/env bash
# Installs what is needed, builds, and runs the benchmark. The arguments are passed to benchmark.launch, e.g.
#   scripts/benchmark.sh dataset:=vgg data_root:=/data selectors:=gms,lpm:v2
# Without arguments, all selectors run on the built-in sample set. Exit code 0 only if the run is complete.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"

output_dir=
for argument in "$@"; do
  case $argument in
    output_dir:=*) output_dir=${argument#output_dir:=} ;;
    -h | --help) sed -n '2,4s/^# //p' "${BASH_SOURCE[0]}" && exit 0 ;;
    *:=*) ;;
    *) echo "benchmark.sh: '$argument' is not of the form name:=value, e.g. dataset:=vgg" >&2 && exit 2 ;;
  esac
done
if [ -z "$output_dir" ]; then
  output_dir=${ROS_HOME:-$HOME/.ros}/corrsel/benchmark_$(date +%Y%m%d_%H%M%S)
  set -- "$@" "output_dir:=$output_dir"
fi

install_packages "${build_packages[@]}"
build benchmark_run -- -DCATKIN_ENABLE_TESTING=OFF
use_workspace
say "roslaunch corrsel benchmark.launch $*"
echo "(When the run ends, roslaunch reports in red that a required process has died. This is how it stops, not an error.)"
roslaunch corrsel benchmark.launch "$@"

# roslaunch returns 0 even if its nodes fail, so the completeness is read from the summary of the run.
summary=$output_dir/summary.json
if ! python3 -c 'import json, sys; sys.exit(not json.load(open(sys.argv[1]))["state"]["complete"])' "$summary" 2>/dev/null; then
  echo "the run is not complete: see the messages above and $output_dir/failures.csv" >&2
  exit 1
fi
[ ! -f "$output_dir/report.html" ] || say "report: $output_dir/report.html"
