#!/usr/bin/env bash
# Installs what is needed, builds, runs all tests, and ends with "N passed, N failed, N skipped".
# Arguments go to CMake, e.g. -Dcorrsel_WERROR=ON. Exit code 0 only where no test failed.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"

install_packages "${build_packages[@]}" "${test_packages[@]}" "${performance_packages[@]}"
build all tests -- "$@"
use_workspace
export ROS_HOME=$build_dir/ros_home
"$package_dir/scripts/fetch_samples.sh" || say "no sample photographs: their tests will be skipped"
results=$build_dir/test_results
rm -rf "$results"
say "running the tests (log: $build_dir/tests.log)"
(cd "$build_dir" && ctest --verbose --parallel "$(nproc)") >"$build_dir/tests.log" 2>&1 || true
python3 "$package_dir/test/summary.py" "$results" "$build_dir/tests.log"
