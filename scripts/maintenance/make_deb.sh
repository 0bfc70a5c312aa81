#!/usr/bin/env bash
# Builds Debian packages of corrsel for the Debian that it runs on, whose ROS comes from Debian's own archive.
#   scripts/maintenance/make_deb.sh [FOLDER]
# The result, ros-corrsel_VERSION_ARCHITECTURE.deb and its debug symbols, is placed in FOLDER (default: the current folder).
# bloom writes the folder debian/ from package.xml, CHANGELOG.rst and LICENSE. rosdep finds the names of the packages in
# Debian's database and in scripts/maintenance/debian_rosdep.yaml. Tests are not built: run scripts/test.sh.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/../common.sh"
source "$(dirname "${BASH_SOURCE[0]}")/root_file_system.sh"

case ${1:-} in
  -h | --help) sed -n '2,6s/^# //p' "${BASH_SOURCE[0]}" && exit 0 ;;
  -*) echo "make_deb.sh: unknown argument '$1'; valid: a folder, --help" >&2 && exit 2 ;;
esac
mkdir -p "${1:-.}"
folder=$(cd "${1:-.}" && pwd)

install_packages build-essential debhelper dh-python dpkg-dev git python3-bloom python3-rosdep2

work=$build_dir/make_deb
source_dir=$work/package/corrsel
rm -rf "$work/package"
mkdir -p "$work/package"
copy_sources "$source_dir"

say "writing debian/ (log: $work/bloom.log)"
export ROS_HOME=$work/ros_home ROSDEP_SOURCE_PATH=$work/rosdep ROSDISTRO_INDEX_URL=file://$work/rosdep/index-v4.yaml
write_rosdep_sources "$work/rosdep" debian
(
  cd "$source_dir"
  rosdep update --rosdistro debian
  bloom-generate debian --ros-distro debian --os-name debian --os-version "$(system_release)"
) >"$work/bloom.log" 2>&1 || {
  tail -n 20 "$work/bloom.log" >&2
  echo "bloom failed: the lines above are the end of $work/bloom.log" >&2
  exit 1
}

# What bloom's templates lack: they know neither the Python modules nor the rules of a current Debian.
cd "$source_dir/debian"
rm compat
# shellcheck disable=SC2016  # dpkg expands the variable
sed -i -e 's/debhelper (>= 9.0.0)/debhelper-compat (= 13), dh-python/' -e 's/^\(Depends: \)/\1${python3:Depends}, /' \
  -e 's/^Standards-Version:.*/Standards-Version: 4.6.2/' -e '/^Homepage: *$/d' control
sed -i -e 's/dh $@ -v/dh $@ --with python3/' -e '/^export LDFLAGS=$/d' rules
cd ..

say "building (log: $work/build.log)"
export DEB_BUILD_OPTIONS=nocheck DEB_BUILD_PROFILES=nocheck
apt_get build-dep -y --no-install-recommends "$source_dir"
dpkg-buildpackage -us -uc -b >"$work/build.log" 2>&1 || {
  grep -nE 'error|Error' "$work/build.log" | head -n 20 >&2 || true
  tail -n 20 "$work/build.log" >&2
  echo "dpkg-buildpackage failed: the lines above are from $work/build.log" >&2
  exit 1
}
mv "$work"/package/*.deb "$folder"  # dpkg-buildpackage writes them beside the sources
say "built:"
ls -l "$folder"/ros-corrsel*.deb
