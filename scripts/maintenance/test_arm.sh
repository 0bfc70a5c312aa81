#!/usr/bin/env bash
# Compiles the libraries and their tests for 64-bit ARM on another processor, runs the tests in an emulator (qemu-user), and
# ends with "N passed, N failed, N skipped". The first run downloads about 300 MB of Debian's packages for ARM, which it
# extracts without running anything of them.
#   scripts/maintenance/test_arm.sh [--short] [CMAKE_ARGUMENT...]
# --short runs the tests of the kernels, of what differs between processors, and of the masks of all selectors. It is a
# job of its own in .github/workflows.
# CORRSEL_ARM_ROOT names another folder with the root file system of an ARM machine (default:
# below ${XDG_CACHE_HOME:-~/.cache}/corrsel), CORRSEL_DEBIAN_MIRROR replaces http://deb.debian.org/debian.
# All tests together take hours. GTEST_TOTAL_SHARDS and GTEST_SHARD_INDEX, which GoogleTest reads, choose a part of them.
# The tests that are Python programs are left out, because they start programs of the build without the emulator.
# Exit code 0 only if no test failed.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/../common.sh"

short=0
case ${1:-} in
  -h | --help) sed -n '2,12s/^# //p' "${BASH_SOURCE[0]}" && exit 0 ;;
  --short) short=1 && shift ;;
esac
mirror=${CORRSEL_DEBIAN_MIRROR:-http://deb.debian.org/debian}
# What the tests need of ARM: the C and C++ libraries, and what the libraries link.
arm_packages=(
  libc6-dev libeigen3-dev libgtest-dev libhdf5-dev libmatio-dev libopencv-dev libsqlite3-dev libstdc++-12-dev
  libyaml-cpp-dev nlohmann-json3-dev
)
# Another list of packages needs another folder.
root=${CORRSEL_ARM_ROOT:-$cache_dir/arm64-$(cksum <<<"${arm_packages[*]}" | cut -d' ' -f1)}
# Tests whose results depend most on the processor, and which do not take long in the emulator.
short_tests=(
  checksum degenerate_input fundamental generator homography kernels neighbours nnsr occupied_cells parallel random ransac
  saturated scene stored_answers
)

install_packages cmake g++-aarch64-linux-gnu gcc-aarch64-linux-gnu make mmdebstrap pkg-config python3 qemu-user-static

# The folder gets its name only once it is complete, so that an interrupted run leaves nothing half-made.
if [ ! -d "$root" ]; then
  say "Debian's packages for ARM in $root"
  mkdir -p "$(dirname "$root")"
  rm -rf "$root.new"
  # No package is configured, so two links that update-alternatives would make are made here.
  # shellcheck disable=SC2016  # mmdebstrap passes the folder to each hook as $1
  mmdebstrap --variant=extract --architectures=arm64 --include="$(IFS=, && echo "${arm_packages[*]}")" \
    --extract-hook='for name in blas lapack; do
      ln -s "$name/lib$name.so.3" "$1/usr/lib/aarch64-linux-gnu/lib$name.so.3"
    done' --extract-hook='rm -r "$1/usr/share/doc" "$1/usr/share/locale" "$1/usr/share/man"' \
    bookworm "$root.new" "$mirror" >"$root.log" 2>&1 || {
    tail -n 20 "$root.log" >&2
    echo "mmdebstrap failed: the lines above are the end of $root.log" >&2
    exit 1
  }
  # The emulator looks up absolute paths here first. The temporary files of tests belong to this machine's /tmp, because
  # users without the rights of root cannot enter the cache of root.
  rmdir "$root.new/tmp"
  mv "$root.new" "$root"
fi

fetch_test_samples
# The tests' own code need not be fast, and optimizing it takes longer than running it.
arguments=(
  -DCMAKE_TOOLCHAIN_FILE="$package_dir/cmake/aarch64.cmake" -DCMAKE_SYSROOT="$root" -Dcorrsel_ROS=OFF
  -Dcorrsel_PYTHON=OFF -Dcorrsel_TESTS=ON -Dcorrsel_WERROR=ON -Dcorrsel_TEST_FLAGS=-O0 "$@"
)
if [ "$short" -eq 1 ]; then
  build_dir=$build_dir/arm_short
  build "${short_tests[@]/#/test_}" -- "${arguments[@]}"
  run_tests -R "^($(IFS='|' && echo "${short_tests[*]}"))\$"
else
  build_dir=$build_dir/arm
  build all -- "${arguments[@]}"
  run_tests
fi
say "left out: the Python tests consumer, cmake_options, generate and readme, which start programs without the emulator"
python3 "$package_dir/test/summary.py" "$build_dir"
