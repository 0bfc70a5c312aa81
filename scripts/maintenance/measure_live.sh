#!/usr/bin/env bash
# Plays images into the nodelets of live.launch, and writes latency, processor time and memory to docs/data/live.csv. Run it
# on an idle machine, and scripts/generate.py after it.
#   scripts/maintenance/measure_live.sh [SECONDS]      of each row, default: 60
# With CORRSEL_TEST_DATA=FOLDER in the environment, which holds raw frames of KITTI in kitti_stereo, they are played, too.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/../common.sh"

case ${1:-} in
  -h | --help) sed -n '2,5s/^# //p' "${BASH_SOURCE[0]}" && exit 0 ;;
  *[!0-9]*) echo "measure_live.sh: unknown argument '$1'; valid: a number of seconds, --help" >&2 && exit 2 ;;
esac
seconds=${1:-60}
table=$package_dir/docs/data/live.csv
kitti=${CORRSEL_TEST_DATA:-}/kitti_stereo

install_packages "${build_packages[@]}"
"$package_dir/scripts/fetch_samples.sh" "$cache_dir/sample"
build all -- -DCMAKE_BUILD_TYPE=Release
use_workspace
commit=$(git -C "$package_dir" describe --always --dirty --exclude '*' --abbrev=12)
machine="$(nproc) x $(sed -n '/^model name/{s/.*: //p;q}' /proc/cpuinfo)"
new=$(mktemp)
echo "commit,machine,images,features,selector,rate_hz,seconds,sent,dropped,p50_ms,p95_ms,max_ms,processor_percent,memory_mib" >"$new"

# measure TITLE FEATURES SELECTOR RATE LOAD_TEST_ARGUMENT...: adds a row to the table.
measure() {
  local title=$1 features=$2 selector=$3 rate=$4 log=$build_dir/live.log output=$build_dir/load_test.log row
  shift 4
  say "$title, $features, $selector, $rate Hz (log of the nodelets: $log)"
  start_master "$log"
  roslaunch corrsel live.launch features:="$features" selector:="$selector" >>"$log" 2>&1 &
  processes+=($!)
  # There is one interval, so the table of load_test has one line.
  rosrun corrsel load_test --rate "$rate" --seconds "$seconds" --interval "$seconds" "$@" \
    left/image:=left/image_rect right/image:=right/image_rect | tee "$output"
  end_processes
  row=$(awk '/^ +[0-9]+ +[0-9]+ +[0-9]+ +[0-9.]+ /{ row = $2 "," $2 - $3 "," $4 "," $5 "," $6 "," $7 "," $8 }
    END { print row }' "$output")
  [ -n "$row" ] || { echo "measure_live.sh: load_test printed no line of its table (log: $log)" >&2 && exit 1; }
  echo "$commit,$machine,$title,$features,$selector,$rate,$seconds,$row" >>"$new"
}

measure "samples 640x480" orb+orb usac 100
measure "samples 640x480" sift+sift auto 30
if [ -d "$kitti" ]; then
  measure "KITTI 1392x512" sift+sift usac 10 --images "$kitti"
  measure "KITTI 1392x512" orb+orb usac 10 --images "$kitti"
fi
cat "$new" >"$table"
rm "$new"
say "wrote $table"
