#!/usr/bin/env bash
# Proves that the Debian package works: builds it (scripts/maintenance/make_deb.sh), installs it with apt-get into a fresh root file system
# of this Debian, and runs the benchmark, the live nodelets, the Python package and a CMake project there. Run it as root.
#   scripts/maintenance/test_deb.sh [FOLDER]
# FOLDER gets the packages and the root file system (default: ${XDG_CACHE_HOME:-~/.cache}/corrsel/deb). A package that is
# there already is not built again. CORRSEL_DEBIAN_MIRROR replaces http://deb.debian.org/debian.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/../common.sh"
source "$(dirname "${BASH_SOURCE[0]}")/root_file_system.sh"

case ${1:-} in
  -h | --help) sed -n '2,6s/^# //p' "${BASH_SOURCE[0]}" && exit 0 ;;
  -*) echo "test_deb.sh: unknown argument '$1'; valid: a folder, --help" >&2 && exit 2 ;;
esac
require_root_user
folder=${1:-$cache_dir/deb}
mkdir -p "$folder"
folder=$(cd "$folder" && pwd)

compgen -G "$folder/ros-corrsel_*.deb" >/dev/null || "$package_dir/scripts/maintenance/make_deb.sh" "$folder"
deb=$(compgen -G "$folder/ros-corrsel_*.deb")

say "contents of $deb"
dpkg-deb --info "$deb" | grep -E '^ (Package|Version|Installed-Size):'
dpkg-deb --contents "$deb" | awk '{ print $6 }' | sed 's/^\.//' >"$folder/contents.txt"
for path in /usr/lib/python3/dist-packages/corrsel/__init__.py /usr/share/corrsel/nodelet_plugins.xml \
  /usr/share/corrsel/cmake/corrsel-core.cmake /usr/share/doc/ros-corrsel/copyright; do
  grep -Fqx "$path" "$folder/contents.txt" || { echo "the package does not contain $path" >&2 && exit 1; }
done
if grep -E '^/etc/|^/usr/(_setup|setup|local_setup|env|\.)|^/usr/lib/corrsel/test_|/devel/' "$folder/contents.txt"; then
  echo "the package must not contain the files above" >&2
  exit 1
fi
rm -rf "$folder/unpacked"
dpkg-deb --extract "$deb" "$folder/unpacked"
if grep -rlF -e "$package_dir/" -e "$build_dir" "$folder/unpacked"; then
  echo "the files above contain paths of the machine that built the package" >&2
  exit 1
fi
rm -rf "$folder/unpacked"

install_packages debootstrap
root=$folder/root
make_root "$folder/base" "$(system_release)" "${CORRSEL_DEBIAN_MIRROR:-http://deb.debian.org/debian}"
remove_folder "$root"
cp -a "$folder/base" "$root"
cp "$deb" "$root/srv/"
cp -r "$package_dir/test/consumer" "$root/srv/"

say "apt-get install ./$(basename "$deb")"
install_in "$root" "/srv/$(basename "$deb")"
in_root "$root" <<'COMMANDS'
dpkg-query -W -f='${Package} ${Version} ${db:Status-Status}\n' ros-corrsel
rosrun corrsel fetch_samples.sh
COMMANDS

say "Python, programs, and the benchmark with the sample photographs"
in_root "$root" --no-network --variable ROS_HOSTNAME=localhost <<'COMMANDS'
cd /srv
python3 -c 'import corrsel; print("corrsel", corrsel.__version__, "in", corrsel.__file__)'
python3 consumer/consumer.py
rosrun corrsel benchmark --list | sed -n 1,4p
roslaunch corrsel benchmark.launch selectors:=ransac,lpm,gms features:=orb+orb preselection:=none output_dir:=/srv/run \
  >benchmark.log 2>&1 || true
python3 -c 'import json; assert json.load(open("/srv/run/summary.json"))["state"]["complete"]' || { cat benchmark.log; exit 1; }
grep -E 'selector  |pairs done' benchmark.log
ls -l /srv/run/report.html
COMMANDS

say "live.launch"
in_root "$root" --no-network --variable ROS_HOSTNAME=localhost <<'COMMANDS'
roslaunch corrsel live.launch selector:=gms >/srv/live.log 2>&1 &
for _ in $(seq 60); do
  sleep 1
  if python3 -c '
import rosgraph
published = {topic for topic, _ in rosgraph.Master("/test").getSystemState()[0]}
raise SystemExit(not {"/matches", "/selection", "/diagnostics"} <= published)' 2>/dev/null; then
    echo "live.launch publishes /matches, /selection and /diagnostics"
    exit 0
  fi
done
cat /srv/live.log
echo "live.launch does not publish its topics" >&2
exit 1
COMMANDS

say "find_package(corrsel)"
install_in "$root" build-essential cmake
in_root "$root" --no-network <<'COMMANDS'
cd /srv
rm -rf use
cmake -S consumer -B use >/dev/null
cmake --build use >/dev/null
use/consumer
ldd use/consumer | grep corrsel
COMMANDS
say "the Debian package works"
