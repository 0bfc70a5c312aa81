#!/usr/bin/env bash
# Proves that corrsel works without ROS: builds, installs, uses and tests it in Debian 12 root file systems that
# debootstrap creates. Run it as root. The first run downloads about 900 MB, the others about 100 MB.
#   scripts/maintenance/test_without_ros.sh [FOLDER]
# FOLDER keeps the root file systems for the next run (default: ${XDG_CACHE_HOME:-~/.cache}/corrsel/without_ros):
#   FOLDER/core     has a compiler, CMake, OpenCV and Eigen. corrsel::core is built, installed and used there.
#   FOLDER/all      also has the packages of corrsel::features, corrsel::benchmark, the Python module and the tests.
#                   Everything is built, tested, installed and used there, and packed as a Debian package.
#   FOLDER/package  is new in each run. The Debian package is installed there and used by root and by another user.
# FOLDER also gets the package, and the report of the run with it as FOLDER/report.html.
# CORRSEL_DEBIAN_MIRROR replaces http://deb.debian.org/debian.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/../common.sh"
source "$(dirname "${BASH_SOURCE[0]}")/root_file_system.sh"

case ${1:-} in
  -h | --help) sed -n '2,12s/^# //p' "${BASH_SOURCE[0]}" && exit 0 ;;
  -*) echo "test_without_ros.sh: unknown argument '$1'; valid: a folder, --help" >&2 && exit 2 ;;
esac
require_root_user
folder=${1:-$cache_dir/without_ros}
mirror=${CORRSEL_DEBIAN_MIRROR:-http://deb.debian.org/debian}
core_packages=(build-essential cmake libeigen3-dev libopencv-dev)
other_packages=(
  dpkg-dev file libgtest-dev libhdf5-dev libmatio-dev libsqlite3-dev libyaml-cpp-dev nlohmann-json3-dev pkg-config
  pybind11-dev python3-dev python3-jinja2 python3-matplotlib python3-numpy python3-yaml
)

install_packages debootstrap iproute2
mkdir -p "$folder"
folder=$(cd "$folder" && pwd)

make_root "$folder/base" bookworm "$mirror"
# copy_root FROM TO: copies a root file system unless TO is there. It gets its name only once it is complete.
copy_root() {
  [ ! -d "$folder/$2" ] || return 0
  remove_folder "$folder/$2.new"
  cp -a "$folder/$1" "$folder/$2.new"
  mv "$folder/$2.new" "$folder/$2"
}
copy_root base core
install_in "$folder/core" "${core_packages[@]}"
copy_root core all
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
rm -rf run
prefix/bin/corrsel_benchmark --dataset sample --features orb+orb --max_pairs 3 --output_dir /srv/run
test -s run/report.html
printf "\n== Debian package\n"
rm -rf build/*.deb build/_CPack_Packages
(cd build && cpack -G DEB >/tmp/cpack.log 2>&1) || { tail -n 20 /tmp/cpack.log; exit 1; }
EOF
rm -f "$folder"/corrsel_*.deb
cp "$folder"/all/srv/build/corrsel_*.deb "$folder"
deb=$(compgen -G "$folder/corrsel_*.deb")
dpkg-deb --field "$deb" Package Version Architecture Depends Recommends Conflicts
dpkg-deb --contents "$deb" | awk '{ print $6 }' | sed 's/^\.//' >"$folder/contents.txt"
for path in /usr/bin/corrsel_benchmark /usr/bin/corrsel_match /usr/bin/corrsel_verify /usr/bin/compare_runs \
  /usr/include/corrsel/selection.h \
  /usr/lib/python3/dist-packages/corrsel/report/__main__.py /usr/share/corrsel/fetch_samples.sh \
  /usr/share/corrsel/apt.sh /usr/share/doc/corrsel/copyright; do
  grep -Fqx "$path" "$folder/contents.txt" || { echo "the package does not contain $path" >&2 && exit 1; }
done
if grep -vE '^/(usr/((bin|include|lib|share)/.*)?)?$' "$folder/contents.txt" ||
  grep -E '/(test|local|__pycache__)(/|$)' "$folder/contents.txt"; then
  echo "the package must not contain the files above" >&2
  exit 1
fi

# A root file system without CMake and Python shows what the package does not declare. The downloads are kept.
root=$folder/package
remove_folder "$root"
copy_root base package
cp "$deb" "$root/srv/"
cp -r "$package_dir/examples" "$package_dir/test/consumer" "$root/srv/"
cp /etc/resolv.conf "$root/etc/resolv.conf"
printf '127.0.0.1 localhost %s\n::1 localhost\n' "$(hostname)" >"$root/etc/hosts"
mkdir -p "$folder/downloads/partial"
# install_in_package NAME...: installs Debian packages, without those that are only recommended.
install_in_package() {
  in_root "$root" --bind "$folder/downloads" /var/cache/apt/archives <<COMMANDS
{ apt-get update && apt-get install -y --no-install-recommends -o Dpkg::Options::=--force-unsafe-io $*; } >/tmp/apt.log 2>&1 || {
  tail -n 20 /tmp/apt.log >&2
  echo "apt-get failed in $root: the lines above are the end of its output" >&2
  exit 1
}
COMMANDS
}

say "apt-get install ./$(basename "$deb")"
install_in_package "/srv/$(basename "$deb")"
in_root "$root" <<'COMMANDS'
dpkg-query -W -f='${Package} ${Version} ${db:Status-Status}\n' corrsel
if dpkg-query -W -f='${db:Status-Status} ${Package}\n' | grep -E '^installed (.*catkin|.*roscpp|ros-)'; then
  echo "the root file system must not contain the packages above" >&2
  exit 1
fi
for file in /usr/bin/corrsel_benchmark /usr/bin/corrsel_match /usr/bin/corrsel_verify /usr/bin/compare_runs \
  /usr/lib/libcorrsel_*.so \
  /usr/lib/python3/dist-packages/corrsel/_*.so; do
  if ldd "$file" | grep 'not found'; then exit 1; fi
done
cd /srv
python3 consumer/consumer.py
corrsel_benchmark --dataset sample --features orb+orb --max_pairs 3 --output_dir /srv/run
test -s /srv/run/report.html
COMMANDS
cp "$root/srv/run/report.html" "$folder/report.html"

say "as a user without rights, in another folder, without a network"
# The photographs are those that the run of root has fetched.
in_root "$root" --no-network <<'COMMANDS'
useradd --create-home tester
mkdir -p /home/tester/.cache/corrsel "/home/tester/some folder"
cp -r ~/.cache/corrsel/sample /home/tester/.cache/corrsel/
chown -R tester: /home/tester
runuser --login --shell /bin/bash tester <<'AS_TESTER'
set -euo pipefail
cd "some folder"
corrsel_benchmark --dataset sample --features orb+orb --max_pairs 3 >run.log || { cat run.log; exit 1; }
grep 'pairs done' run.log
report=$(ls ~/.local/share/corrsel/*/report.html)
ls -l "$report"
compare_runs "$(dirname "$report")" /srv/run | tail -n 3
python3 -m corrsel.report --no-page /srv/run >/dev/null
AS_TESTER
COMMANDS

say "the Python example, which needs OpenCV's module"
install_in_package python3-opencv
in_root "$root" --no-network <<'COMMANDS'
cd ~/.cache/corrsel/sample
python3 /srv/examples/03_camera_pipeline.py aloeL.jpg aloeR.jpg graf1.png graf3.png
COMMANDS

say "find_package(corrsel) and the examples in C++"
install_in_package cmake g++ make
in_root "$root" --no-network <<'COMMANDS'
cd /srv
for project in consumer examples; do
  cmake -S "$project" -B "use_$project" >/dev/null
  cmake --build "use_$project" >/dev/null
done
use_consumer/consumer
ldd use_consumer/consumer | grep corrsel
COMMANDS

say "apt-get remove corrsel"
in_root "$root" --no-network <<'COMMANDS'
apt-get remove -y corrsel >/tmp/apt.log 2>&1 || { cat /tmp/apt.log; exit 1; }
if find /usr -path '*corrsel*' | grep .; then
  echo "the files above are left" >&2
  exit 1
fi
COMMANDS

say "tests in $folder/all"
in_root "$folder/all" <<EOF
cd /srv
rm -rf build/test_results
(cd build && ctest --verbose --parallel $(nproc) >tests.log 2>&1) || true
python3 corrsel/test/summary.py build
EOF
