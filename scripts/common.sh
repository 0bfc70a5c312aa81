# shellcheck shell=bash
# shellcheck disable=SC2034  # the lists are used by the scripts that source this file
# Sourced by the scripts of this folder, which install packages and build with the functions below; not run by itself.

source "$(dirname "${BASH_SOURCE[0]}")/apt.sh"

# Use the system's Python: another one that stands earlier in PATH breaks catkin.
export PATH=/usr/bin:/bin:$PATH
export ROS_HOSTNAME="${ROS_HOSTNAME:-localhost}"
export ROS_MASTER_URI="${ROS_MASTER_URI:-http://localhost:11311}"

package_dir=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
# The build folder lies outside the package because rosrun searches the package's folder for programs.
cache_dir=${XDG_CACHE_HOME:-$HOME/.cache}/corrsel
build_dir=${CORRSEL_BUILD_DIR:-$cache_dir/build-$(printf %s "$package_dir" | cksum | cut -d' ' -f1)}

# Debian's own ROS 1 packages.
build_packages=(
  build-essential catkin cmake git pkg-config
  libdiagnostic-updater-dev libdynamic-reconfigure-config-init-mutex-dev libeigen3-dev libimage-view-dev
  libhdf5-dev libmatio-dev libnodeletlib-tools libopencv-dev librosbag-dev libsqlite3-dev libtf2-ros-dev
  libyaml-cpp-dev nlohmann-json3-dev
  pybind11-dev python3-dev python3-diagnostic-msgs python3-dynamic-reconfigure python3-geometry-msgs python3-h5py
  python3-jinja2 python3-matplotlib python3-numpy python3-rosbag python3-roslaunch python3-rostopic python3-sensor-msgs
  python3-setuptools python3-yaml ros-image-view ros-perception-dev rosbash
)
performance_packages=(libbenchmark-dev libnanoflann-dev)
test_packages=(
  colmap imagemagick libgl1-mesa-dri libgtest-dev libimage-proc-dev librostest-dev libstereo-image-proc-dev mypy
  python3-opencv python3-rosdep2 python3-rostest python3-venv ros-image-proc ros-stereo-image-proc rviz sqlite3 xvfb
)
sanitizer_packages=(clang libclang-rt-14-dev lld)
# Up to LLVM 16 and GCC 13, LeakSanitizer takes some blocks of thread-local variables for those of glibc 2.19 to 2.24, and
# then crashes while the program ends (google/sanitizers, issue 1322). Without this interceptor it finds the blocks through
# the allocator.
export ASAN_OPTIONS=intercept_tls_get_addr=0${ASAN_OPTIONS:+:$ASAN_OPTIONS}

say() { printf '\n== %s\n' "$*"; }

# install_packages NAME...: installs the Debian packages that are missing.
install_packages() {
  if [ -d /opt/ros ] && [ ! -e /usr/share/roscpp ]; then
    say "found ROS in /opt/ros, no packages are installed: 'rosdep install --from-paths $package_dir -y' does it"
    return
  fi
  local missing=() name
  for name in "$@"; do
    [ "$(dpkg-query -W -f='${db:Status-Status}' "$name" 2>/dev/null)" = installed ] || missing+=("$name")
  done
  [ ${#missing[@]} -gt 0 ] || return 0
  say "installing ${#missing[@]} packages: ${missing[*]}"
  apt_get update
  apt_get install -y --no-install-recommends "${missing[@]}"
}

# compile_jobs: prints how many compilers run side by side: one per processor core, but no more than fit into the memory
# that is free. The largest of them takes 0.75 GB (src/selectors/st.cpp with GCC 12), most take less than 0.5 GB.
compile_jobs() {
  local cores free_mb
  cores=$(nproc)
  free_mb=$(awk '/^MemAvailable:/ { print int($2 / 1024) }' /proc/meminfo)
  local fitting=$((free_mb / 800))
  echo $((fitting < 1 ? 1 : fitting < cores ? fitting : cores))
}

# system_release: prints the name of this Debian's release, e.g. bookworm.
system_release() {
  # shellcheck disable=SC1091  # a file of the system
  (. /etc/os-release && echo "${VERSION_CODENAME:-unknown}")
}

# write_rosdep_sources FOLDER ROS_DISTRIBUTION [PACKAGE_FOLDER]: writes what rosdep and bloom read instead of files from the
# network: the rules of Debian's packages, and an index with one distribution of ROS, which has no packages of its own.
# Use them with ROSDEP_SOURCE_PATH=FOLDER and ROSDISTRO_INDEX_URL=file://FOLDER/index-v4.yaml.
write_rosdep_sources() {
  local folder=$1 distribution=$2 package=${3:-$package_dir}
  mkdir -p "$folder"
  printf 'yaml file://%s debian\n' "$package/scripts/maintenance/debian_rosdep.yaml" /usr/share/python3-rosdep2/debian.yaml \
    >"$folder/10-debian.list"
  cat >"$folder/index-v4.yaml" <<END
%YAML 1.1
---
distributions:
  $distribution:
    {distribution: [distribution.yaml], distribution_status: active, distribution_type: ros1, python_version: 3}
type: index
version: 4
END
  printf '%%YAML 1.1\n---\nrelease_platforms: {}\nrepositories: {}\ntype: distribution\nversion: 2\n' \
    >"$folder/distribution.yaml"
}

# print_progress: reads what a build prints, and shows how much of it is done: in one line of a terminal, elsewhere in one line
# for every ten percent.
print_progress() {
  local line percent shown=-1
  while IFS= read -r line; do
    [[ $line =~ ^\[\ *([0-9]+)%\]\ (.*)$ ]] || continue
    percent=${BASH_REMATCH[1]}
    if [ -t 1 ]; then
      printf '\r[%3d%%] %-70.70s' "$percent" "${BASH_REMATCH[2]##*/}"
    elif [ $((percent / 10)) -ne "$shown" ]; then
      shown=$((percent / 10))
      printf '[%3d%%] %s\n' "$percent" "${BASH_REMATCH[2]##*/}"
    fi
  done
  [ ! -t 1 ] || printf '\r%-77s\r' ''
}

# build TARGET... [-- CMAKE_ARGUMENT...]: configures and builds in $build_dir. Prints compiler output only on failure.
build() {
  local targets=() arguments=() log
  while [ $# -gt 0 ]; do
    if [ "$1" = -- ]; then
      shift
      arguments=("$@")
      break
    fi
    targets+=("$1")
    shift
  done
  mkdir -p "$build_dir"
  log=$build_dir/build.log
  say "building in $build_dir (log: $log)"
  if ! { cmake -S "$package_dir" -B "$build_dir" -DCATKIN_DEVEL_PREFIX="$build_dir/devel" -DCATKIN_ENABLE_TESTING=ON \
    "${arguments[@]}" &&
    cmake --build "$build_dir" --parallel "$(compile_jobs)" --target "${targets[@]}"; } 2>&1 | tee "$log" | print_progress; then
    grep -nE 'error|Error|warning:' "$log" | head -n 20 >&2 || true
    tail -n 20 "$log" >&2
    echo "the build failed: the lines above are from $log" >&2
    exit 1
  fi
}

# fetch_test_samples: gets the photographs of the sample dataset. Where that fails, the tests that need them are skipped.
fetch_test_samples() {
  "$package_dir/scripts/fetch_samples.sh" || say "no sample photographs: the tests that need them will be skipped"
}

# run_tests CTEST_ARGUMENT...: runs tests of $build_dir. The results stay there for summary.py.
run_tests() {
  rm -rf "$build_dir/test_results"
  say "running the tests in $build_dir (log: $build_dir/tests.log)"
  (cd "$build_dir" && ctest --verbose --parallel "$(nproc)" "$@") >"$build_dir/tests.log" 2>&1 || true
}

# train_table PROGRAM TABLE [--check]: runs a program that chooses the tests of a descriptor on the sample images, and
# replaces the table, a source file. With --check only compares: fails if the table differs.
train_table() {
  local program=$1 table=$package_dir/$2 check=${3:-} samples=$cache_dir/sample trained
  trained=$(mktemp)
  # shellcheck disable=SC2064  # the name is that of now
  trap "rm -f '$trained'" EXIT
  install_packages "${build_packages[@]}"
  "$package_dir/scripts/fetch_samples.sh" "$samples"
  build "$program" -- -DCMAKE_BUILD_TYPE=Release
  say "training"
  "$build_dir/devel/lib/corrsel/$program" "$samples" >"$trained"
  if [ "$check" != --check ]; then
    cat "$trained" >"$table"
    say "wrote $table"
  elif cmp -s "$trained" "$table"; then
    say "the table in the repository agrees with the training"
  else
    diff -u "$table" "$trained" | head -n 20 >&2
    echo "the table in the repository differs from the training: run scripts/maintenance/$program.sh" >&2
    return 1
  fi
}

# build_sanitized TARGET...: builds without ROS, by clang, under AddressSanitizer and UndefinedBehaviorSanitizer. The
# libraries also count which code has run, for the fuzzer: one build serves the tests and scripts/maintenance/fuzz.sh. Comparisons
# are not traced, because that takes twice as long as all the rest and the fuzzer's bytes are seldom compared.
# -g1 and, for the tests, -O0 shorten the compile time. lld links each test in a fifth of the time.
build_sanitized() {
  build "$@" -- -Dcorrsel_ROS=OFF -Dcorrsel_TESTS=ON -Dcorrsel_FUZZ=ON -DCMAKE_CXX_COMPILER=clang++ \
    -DCMAKE_BUILD_TYPE=None -Dcorrsel_SANITIZE=fuzzer-no-link,address,undefined \
    -DCMAKE_CXX_FLAGS="-O2 -g1 -fno-sanitize-coverage=trace-cmp" -Dcorrsel_TEST_FLAGS=-O0 \
    -DCMAKE_EXE_LINKER_FLAGS=-fuse-ld=lld -DCMAKE_SHARED_LINKER_FLAGS=-fuse-ld=lld
}

# use_workspace: sets the environment in which ROS finds the package that build() has built.
use_workspace() {
  set +u
  # shellcheck disable=SC1091
  source "$build_dir/devel/setup.bash"
  set -u
}

# start_master LOG: starts a ROS master of the script's own, because another one may be in use. When the script ends, it and the
# other background jobs whose numbers are in `processes` are ended, the last one first.
processes=()
start_master() {
  local port=$((20000 + $$ % 20000))
  export ROS_HOME=$build_dir/ros_home ROS_MASTER_URI=http://localhost:$port
  trap end_processes EXIT
  rosmaster --core -p "$port" >"$1" 2>&1 &
  processes+=($!)
  until rosparam list >/dev/null 2>&1; do sleep 0.2; done
}

end_processes() {
  local i
  for ((i = ${#processes[@]} - 1; i >= 0; --i)); do kill "${processes[i]}" 2>/dev/null || true; done
  wait
  processes=()
}
