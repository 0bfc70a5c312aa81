#!/usr/bin/env bash
# Proves that pip installs corrsel on releases of Debian, in root file systems that debootstrap creates. Run it as root.
#   scripts/maintenance/test_pip.sh [OPTION]... [SUITE]...
# SUITE is bullseye, bookworm or trixie; the default is all three.
#   --folder FOLDER     keeps root file systems, builds and wheels (default: ${XDG_CACHE_HOME:-~/.cache}/corrsel/pip)
#   --mirror SUITE=URL  takes a suite from this mirror, e.g. --mirror bullseye=http://archive.debian.org/debian
#   --help              prints this text
# In FOLDER/SUITE, which has a compiler and no network, the backend makes the source archive, `pip install .` runs in its
# folder, and a program uses the package from an empty folder. FOLDER/SUITE-plain is new in each run, and has neither a compiler
# nor OpenCV: the wheel is installed there, its errors name Debian's packages of OpenCV, these are installed, an example runs.
# A release takes 1.5 GB and 5 minutes of processor time; what has been compiled is kept for the next run. Debian 11 takes 10
# minutes each time, because its pip copies the sources into a new folder.
# CORRSEL_DEBIAN_MIRROR replaces http://deb.debian.org/debian.
# Exit code: 0 all releases passed, 1 a release failed, 2 usage error.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/../common.sh"
source "$(dirname "${BASH_SOURCE[0]}")/root_file_system.sh"

usage_error() {
  echo "test_pip.sh: $1" >&2
  exit 2
}

folder=$cache_dir/pip
declare -A mirrors=()
suites=()
while [ $# -gt 0 ]; do
  case $1 in
    -h | --help) sed -n '2,14s/^# \?//p' "${BASH_SOURCE[0]}" && exit 0 ;;
    --folder)
      [ $# -gt 1 ] || usage_error "--folder needs a value; --help explains it"
      folder=$2 && shift
      ;;
    --mirror)
      [[ ${2:-} == ?*=?* ]] || usage_error "--mirror is '${2:-}', but must be SUITE=URL"
      mirrors[${2%%=*}]=${2#*=} && shift
      ;;
    bullseye | bookworm | trixie) suites+=("$1") ;;
    *) usage_error "unknown argument '$1'; valid: --folder, --mirror, --help, bullseye, bookworm, trixie" ;;
  esac
  shift
done
[ ${#suites[@]} -gt 0 ] || suites=(bullseye bookworm trixie)

require_root_user
install_packages debootstrap iproute2
mkdir -p "$folder"
folder=$(cd "$folder" && pwd)
packages=$(cd "$package_dir/python/backend" && python3 -B -c 'import corrsel_backend; print(corrsel_backend.PACKAGES)')
read -ra build_tools <<<"$packages"

# compile SUITE: installs by pip in FOLDER/SUITE, and leaves the wheel in srv/wheels.
compile() {
  copy_sources "$folder/$1/srv/sources"
  in_root "$folder/$1" --no-network --variable CORRSEL_PIP_BUILD_DIR=/srv/build <<'COMMANDS'
cd /srv
rm -rf archive corrsel venv wheels
mkdir -p archive empty wheels
python3 -B -c 'import sys; sys.path.insert(0, "sources/python/backend"); import corrsel_backend
corrsel_backend.build_sdist("archive")'
tar -C archive -xf archive/corrsel-*.tar.gz
mv archive/corrsel-*/ corrsel
python3 -m venv --system-site-packages venv
cd corrsel
for command in "install" "wheel --no-build-isolation --no-deps --wheel-dir /srv/wheels"; do
  /srv/venv/bin/python -m pip $command . >/tmp/pip.log 2>&1 || { tail -n 40 /tmp/pip.log; exit 1; }
done
cd /srv/empty
ls -l /srv/archive /srv/wheels
/srv/venv/bin/python -m pip --version
/srv/venv/bin/python - <<'PROGRAM'
import time

start = time.process_time()
import corrsel

names = corrsel.selector_names(), corrsel.extractor_names()  # loads the modules in C++
print("import: %.0f ms of processor time" % (1000 * (time.process_time() - start)))
print(corrsel.__file__, corrsel.__version__, *map(len, names))
PROGRAM
COMMANDS
}

# use SUITE: installs the wheel in FOLDER/SUITE-plain, and then, one after the other, the packages that its errors name.
use() {
  local root=$folder/$1-plain output package
  rm -rf "$root/srv/wheels" "$root/srv/examples" "$root/srv/venv"
  cp -r "$folder/$1/srv/wheels" "$package_dir/examples" "$root/srv/"
  in_root "$root" --no-network <<'COMMANDS'
cd /srv
mkdir -p empty
python3 -m venv --system-site-packages venv
venv/bin/python -m pip install --no-index wheels/*.whl 2>&1 | tail -n 1
COMMANDS
  while ! output=$(in_root "$root" <<<"/srv/venv/bin/python -c 'import corrsel; corrsel.select; corrsel.match' 2>&1"); do
    tail -n 1 <<<"$output"
    package=$(sed -nE "s/.*Install Debian's package ([a-z0-9.-]+);.*/\1/p" <<<"$output" | tail -n 1)
    if [ -z "$package" ] || in_root "$root" <<<"dpkg-query -W $package >/dev/null 2>&1"; then
      echo "the error above names no package that would help" >&2
      return 1
    fi
    install_in "$root" "$package"
  done
  install_in "$root" python3-opencv
  in_root "$root" --no-network <<<"cd /srv/empty && /srv/venv/bin/python /srv/examples/05_epipolar_fisheye.py"
}

# copy_root FROM TO: copies a root file system. It gets its name only once it is complete.
copy_root() {
  remove_folder "$folder/$2.new"
  cp -a "$folder/$1" "$folder/$2.new"
  mv "$folder/$2.new" "$folder/$2"
}

# test_suite SUITE: fails where one of its steps does.
test_suite() {
  make_root "$folder/$1-base" "$1" "${mirrors[$1]:-${CORRSEL_DEBIAN_MIRROR:-http://deb.debian.org/debian}}"
  install_in "$folder/$1-base" ca-certificates python3-numpy python3-venv
  [ -d "$folder/$1" ] || copy_root "$1-base" "$1"
  install_in "$folder/$1" "${build_tools[@]}"
  remove_folder "$folder/$1-plain"
  copy_root "$1-base" "$1-plain"
  say "$1: pip install ."
  compile "$1"
  say "$1: the wheel where OpenCV is missing"
  use "$1"
}

failed=()
for suite in "${suites[@]}"; do
  # A process of its own, so that a release that fails does not keep the others from being tested.
  test_suite "$suite" &
  wait $! || failed+=("$suite")
done
say "results"
if [ ${#failed[@]} -gt 0 ]; then
  echo "FAILED: ${failed[*]}"
  exit 1
fi
echo "pip installs corrsel on ${suites[*]}"
