#!/usr/bin/env bash
# Installs what is needed, builds, runs all tests, and ends with "N passed, N failed, N skipped".
#   scripts/test.sh [--sanitize] [CMAKE_ARGUMENT...]     e.g. scripts/test.sh -Dcorrsel_WERROR=ON
# Two configurations are tested: the whole package with ROS, and one without ROS. The latter is corrsel::core alone,
# where only the test that installs and uses the package runs, because the other tests have run with ROS. With
# --sanitize it is all libraries under AddressSanitizer and UndefinedBehaviorSanitizer, where all their tests run.
# Exit code 0 only if no test failed.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"

sanitize=0
case ${1:-} in
  -h | --help) sed -n '2,8s/^# //p' "${BASH_SOURCE[0]}" && exit 0 ;;
  --sanitize) sanitize=1 && shift ;;
esac

install_packages "${build_packages[@]}" "${test_packages[@]}" "${performance_packages[@]}"
fetch_test_samples
build all tests -- "$@"
(
  use_workspace
  export ROS_HOME=$build_dir/ros_home
  run_tests
)
with_ros=$build_dir
if [ "$sanitize" -eq 1 ]; then
  install_packages "${sanitizer_packages[@]}"
  build_dir=$build_dir/sanitized
  build_sanitized all
  run_tests
else
  build_dir=$build_dir/core_alone
  # What is installed of the core alone; all would also build the tests.
  build corrsel_core -- -Dcorrsel_REFERENCE=OFF -Dcorrsel_FEATURES=OFF -Dcorrsel_PYTHON=OFF -Dcorrsel_TESTS=ON "$@"
  run_tests -R '^consumer$'
fi
python3 "$package_dir/test/summary.py" "$with_ros" "$build_dir"
