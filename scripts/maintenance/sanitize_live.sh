#!/usr/bin/env bash
# Runs the nodelets inside test programs under a sanitizer: data races (thread) or memory errors, leaks and undefined
# behaviour (address).
#   scripts/maintenance/sanitize_live.sh thread|address [GTEST_FILTER]
# Fails if a test fails or the sanitizer reports anything. ROS and OpenCV are built without the sanitizer, so
# ThreadSanitizer sees their locks but not their memory accesses. test/ros/tsan.supp lists the false reports that follow.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/../common.sh"

case ${1:-} in
  thread) sanitizer=thread ;;
  address) sanitizer=address,undefined ;;
  *)
    echo "usage: sanitize_live.sh thread|address [GTEST_FILTER]" >&2
    exit 2
    ;;
esac
kind=$1
filter=${2:-*}

install_packages "${build_packages[@]}" "${test_packages[@]}"
build_dir=$build_dir/live_$kind
programs=(live_test live_diagnostics_test motion_source_test rig_monitor_test)
build "${programs[@]}" -- -DCMAKE_BUILD_TYPE=None -DCMAKE_CXX_FLAGS="-O1 -g1" -Dcorrsel_SANITIZE=$sanitizer
use_workspace
reports=$build_dir/reports
rm -rf "$reports"
mkdir -p "$reports"

start_master "$build_dir/master.log"

export TSAN_OPTIONS="suppressions=$package_dir/test/ros/tsan.supp ignore_noninstrumented_modules=1 exitcode=0 \
history_size=4 log_path=$reports/report"
export ASAN_OPTIONS="$ASAN_OPTIONS detect_leaks=1 log_path=$reports/report"
export UBSAN_OPTIONS="print_stacktrace=1 log_path=$reports/report"
failed=()
for name in "${programs[@]}"; do
  say "running $name under $sanitizer (log: $build_dir/$name.log)"
  program=$(find "$build_dir/devel" -name "$name" -type f)
  "$program" --gtest_filter="$filter" >"$build_dir/$name.log" 2>&1 || failed+=("$name")
  grep -aE '^\[ +(FAILED|PASSED|SKIPPED) +\]|^\[=+\].*ran' "$build_dir/$name.log" || true
done

count=$(cat "$reports"/report* 2>/dev/null | grep -acE 'WARNING: ThreadSanitizer|ERROR: (Address|Leak)Sanitizer|runtime error:' || true)
say "$count reports, ${#failed[@]} of ${#programs[@]} programs failed"
cat "$reports"/report* 2>/dev/null | grep -aE 'SUMMARY|runtime error:' | sort | uniq -c | sort -rn | head -n 20 || true
if [ "$count" -ne 0 ] || [ ${#failed[@]} -gt 0 ]; then
  echo "FAILED: reports are in $reports, the outputs of the tests in $build_dir/*_test.log" >&2
  exit 1
fi
