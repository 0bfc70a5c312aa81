# shellcheck shell=bash
# shellcheck disable=SC2034  # the lists are used by the scripts that source this file
# Sourced by the scripts of this folder: installing what is needed, and building. Not run by itself.

# The system's Python: another one earlier in PATH breaks catkin and ament.
export PATH=/usr/bin:/bin:$PATH
export ROS_HOSTNAME="${ROS_HOSTNAME:-localhost}"
export ROS_MASTER_URI="${ROS_MASTER_URI:-http://localhost:11311}"

package_dir=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
# Outside the package: rosrun looks through the package's folder and leaves out build/ in it.
cache_dir=${XDG_CACHE_HOME:-$HOME/.cache}/corrsel
build_dir=${CORRSEL_BUILD_DIR:-$cache_dir/build-$(printf %s "$package_dir" | cksum | cut -d' ' -f1)}

# Debian's own ROS 1 packages.
build_packages=(
  build-essential catkin cmake git pkg-config
  libdiagnostic-updater-dev libdynamic-reconfigure-config-init-mutex-dev libeigen3-dev libimage-view-dev
  libmatio-dev libnodeletlib-tools libopencv-dev librosbag-dev libvlfeat-dev libyaml-cpp-dev nlohmann-json3-dev
  python3-diagnostic-msgs python3-dynamic-reconfigure python3-matplotlib python3-numpy python3-rosbag
  python3-roslaunch python3-rostopic python3-sensor-msgs python3-setuptools ros-image-view ros-perception-dev
  rosbash
)
performance_packages=(libbenchmark-dev libnanoflann-dev)
test_packages=(
  libgtest-dev libimage-publisher-dev librostest-dev python3-opencv python3-rosservice python3-rostest
  ros-image-publisher
)

say() { printf '\n== %s\n' "$*"; }

# install_packages NAME...: installs what is missing.
install_packages() {
  if [ -d /opt/ros ] && [ ! -e /usr/share/roscpp ]; then
    say "ROS from /opt/ros: dependencies are left to rosdep (rosdep install --from-paths $package_dir -y)"
    return
  fi
  local missing=() name
  for name in "$@"; do
    [ "$(dpkg-query -W -f='${db:Status-Status}' "$name" 2>/dev/null)" = installed ] || missing+=("$name")
  done
  [ ${#missing[@]} -gt 0 ] || return 0
  say "installing ${#missing[@]} packages: ${missing[*]}"
  local as_root=()
  if [ "$(id -u)" -ne 0 ]; then
    as_root=(sudo)
    command -v sudo >/dev/null || {
      echo "cannot install without root: run 'apt-get install ${missing[*]}' as root, then this script again" >&2
      exit 1
    }
  fi
  local log
  log=$(mktemp)
  if ! { "${as_root[@]}" apt-get update && "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive \
      apt-get install -y --no-install-recommends "${missing[@]}"; } >"$log" 2>&1; then
    tail -n 20 "$log" >&2
    echo "installing failed: the lines above are the end of $log" >&2
    exit 1
  fi
  rm -f "$log"
}

# build TARGET... [-- CMAKE_ARGUMENT...]: configures and builds, quietly unless it fails.
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
  if ! { cmake -S "$package_dir" -B "$build_dir" -DCATKIN_DEVEL_PREFIX="$build_dir/devel" "${arguments[@]}" &&
    cmake --build "$build_dir" --parallel "$(nproc)" --target "${targets[@]}"; } >"$log" 2>&1; then
    grep -nE 'error|Error|warning:' "$log" | head -n 20 >&2 || true
    tail -n 20 "$log" >&2
    echo "the build failed: the lines above are from $log" >&2
    exit 1
  fi
}

# use_workspace: makes ROS find the package that build() has built.
use_workspace() {
  set +u
  # shellcheck disable=SC1091
  source "$build_dir/devel/setup.bash"
  set -u
}
