#!/usr/bin/env bash
# Runs the live nodelets for a long time at 30 Hz: one calibrated camera, masks that come late, poses, tracks, and a random
# change of the parameters every second. Prints what load_test measures.
#   scripts/maintenance/soak.sh [SECONDS]      default: 1800
# Fails if the memory grows by more than 2 %, if a result comes twice or out of order, or if a process ends.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/../common.sh"

case ${1:-} in
  -h | --help) sed -n '2,5s/^# //p' "${BASH_SOURCE[0]}" && exit 0 ;;
  *[!0-9]*) echo "soak.sh: unknown argument '$1'; valid: a number of seconds, --help" >&2 && exit 2 ;;
esac
seconds=${1:-1800}

install_packages "${build_packages[@]}"
"$package_dir/scripts/fetch_samples.sh" "$cache_dir/sample"
build all -- -DCMAKE_BUILD_TYPE=Release
use_workspace
log=$build_dir/soak.log
start_master "$log"
roslaunch corrsel sequence.launch image:=/image selector:=pose use_mask:=true mask_mode:=stamped tracks:=true >>"$log" 2>&1 &
processes+=($!)
# Nothing is computed that nobody subscribes to.
for topic in relative_pose tracks; do
  rostopic hz "/$topic" >/dev/null 2>&1 &
  processes+=($!)
done

say "$seconds s at 30 Hz (log of the nodelets: $log)"
rosrun corrsel load_test --sequence --calibrated --mask-period 3 --rate 30 --seconds "$seconds" --reconfigure 1 \
  --selectors pose,auto,usac --max-memory-growth 0.02
