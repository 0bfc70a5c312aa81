#!/usr/bin/env bash
# Proves that the libraries work without ROS: builds, installs, uses and tests them in Debian 12 root file systems that
# debootstrap creates. Run it as root. The first run downloads about 500 MB and takes some minutes longer than the others.
#   scripts/maintenance/test_without_ros.sh [FOLDER]
# FOLDER keeps the root file systems for the next run (default: ${XDG_CACHE_HOME:-~/.cache}/corrsel/without_ros):
#   FOLDER/core  has a compiler, CMake, OpenCV and Eigen. corrsel::core is built, installed and used there.
#   FOLDER/all   also has the packages of corrsel::features, corrsel::benchmark, the Python module and the tests.
#                Everything is built, tested, installed and used there.
# CORRSEL_DEBIAN_MIRROR replaces http://deb.debian.org/debian.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/../common.sh"
source "$(dirname "${BASH_SOURCE[0]}")/root_file_system.sh"

case ${1:-} in
  -h | --help) sed -n '2,9s/^# //p' "${BASH_SOURCE[0]}" && exit 0 ;;
  -*) echo "test_without_ros.sh: unknown argument '$1'; valid: a folder, --help" >&2 && exit 2 ;;
esac
require_root_user
folder=${1:-$cache_dir/without_ros}
mirror=${CORRSEL_DEBIAN_MIRROR:-http://deb.debian.org/debian}
core_packages=(build-essential cmake libeigen3-dev libopencv-dev)
other_packages=(
  libgtest-dev libmatio-dev libyaml-cpp-dev nlohmann-json3-dev pkg-config
  pybind11-dev python3-dev python3-jinja2 python3-matplotlib python3-numpy python3-yaml
)

install_packages debootstrap iproute2
mkdir -p "$folder"
folder=$(cd "$folder" && pwd)

make_root "$folder/core" bookworm "$mirror"
install_in "$folder/core" "${core_packages[@]}"
if [ ! -d "$folder/all" ]; then
  remove_folder "$folder/all.new"
  cp -a "$folder/core" "$folder/all.new"
  mv "$folder/all.new" "$folder/all"
fi
install_in "$folder/all" "${core_packages[@]}" "${other_packages[@]}"

for root in "$folder/core" "$folder/all"; do
  if [ -e "$root/opt/ros" ] || [ -e "$root/usr/share/catkin" ]; then
    echo "$root contains ROS: remove the folder and run this script again" >&2
    exit 1
  fi
  rm -rf "$root/srv/prefix" "$root/srv/use"
  copy_sources "$root/srv/corrsel"
done

use='cmake -S corrsel/test/consumer -B use -DCMAKE_PREFIX_PATH=/srv/prefix >/dev/null
cmake --build use >/dev/null
cat corrsel/test/consumer/CMakeLists.txt
use/consumer'

say "corrsel::core in $folder/core"
in_root "$folder/core" <<EOF
cd /srv
cmake -S corrsel -B build_core -Dcorrsel_FEATURES=OFF | grep -- '-- corrsel'
cmake --build build_core --parallel $(nproc) >/tmp/build.log 2>&1 || { tail -n 20 /tmp/build.log; exit 1; }
cmake --install build_core --prefix /srv/prefix >/dev/null
$use
EOF

say "corrsel::core, corrsel::features, corrsel::benchmark, Python and tests in $folder/all"
in_root "$folder/all" <<EOF
cd /srv
cmake -S corrsel -B build -Dcorrsel_TESTS=ON | grep -- '-- corrsel'
cmake --build build --parallel $(nproc) >/tmp/build.log 2>&1 || { tail -n 20 /tmp/build.log; exit 1; }
cmake --install build --prefix /srv/prefix >/dev/null
$use
printf "\n== Python\n"
PYTHONPATH=\$(dirname "\$(find prefix -name corrsel -path '*python3*' -type d)")
export PYTHONPATH
python3 -c 'import corrsel; print(corrsel.__file__, corrsel.selector_names())'
python3 corrsel/test/consumer/consumer.py
unset PYTHONPATH
printf "\n== corrsel_benchmark\n"
prefix/bin/corrsel_benchmark --dataset sample --features orb+orb --max_pairs 3 --output_dir /srv/run
test -s run/report.html
printf "\n== tests\n"
rm -rf build/test_results
(cd build && ctest --verbose --parallel $(nproc) >tests.log 2>&1) || true
python3 corrsel/test/summary.py build
EOF
