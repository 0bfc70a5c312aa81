#!/usr/bin/env bash
# Runs the tests of the libraries as on x86-64 processors without AVX2: on this one, but with the baseline kernels, and then
# on each emulated processor (qemu-user), where an instruction that it lacks ends the program. Each run ends with
# "N passed, N failed, N skipped". Needs an x86-64 processor, and no ROS.
#   scripts/maintenance/test_without_avx2.sh [--core] [PROCESSOR...]      default: Nehalem, which has SSE4.2 but no AVX
#   scripts/maintenance/test_without_avx2.sh --core qemu64                the least that x86-64 offers: SSE2 (and SSE3)
# --core tests corrsel::core alone. `qemu-x86_64-static -cpu help` lists the processors.
# All tests together take hours. GTEST_TOTAL_SHARDS and GTEST_SHARD_INDEX, which GoogleTest reads, choose a part of them.
# Exit code 0 only if no test failed.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/../common.sh"

build_dir=$build_dir/without_avx2
arguments=()
case ${1:-} in
  -h | --help) sed -n '2,9s/^# //p' "${BASH_SOURCE[0]}" && exit 0 ;;
  --core) build_dir=${build_dir}_core && arguments=(-Dcorrsel_FEATURES=OFF) && shift ;;
esac
processors=("$@")
[ $# -gt 0 ] || processors=(Nehalem)

install_packages "${build_packages[@]}" "${test_packages[@]}" qemu-user-static
fetch_test_samples
# With the name of the system, CMake prepares for another machine than this one: it runs the tests in the emulator.
arguments+=(
  -DCMAKE_SYSTEM_NAME=Linux -DCMAKE_SYSTEM_PROCESSOR=x86_64 -Dcorrsel_ROS=OFF -Dcorrsel_PYTHON=OFF
  -Dcorrsel_TESTS=ON
)
code=0
# run EMULATOR: all tests, in the emulator unless it is empty.
run() {
  build all -- "${arguments[@]}" -DCMAKE_CROSSCOMPILING_EMULATOR="$1"
  # shellcheck disable=SC2119  # all tests
  run_tests
  python3 "$package_dir/test/summary.py" "$build_dir" || code=1
}

say "this processor, baseline kernels"
CORRSEL_KERNELS=baseline run ""
for processor in "${processors[@]}"; do
  say "emulated processor $processor"
  run "qemu-x86_64-static;-cpu;$processor"
done
exit "$code"
