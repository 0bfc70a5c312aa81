#!/usr/bin/env bash
# Builds the whole package with ROS and runs all tests on the platforms of the list below, in root file systems that
# debootstrap creates, and prints a table of what was used, passed, failed and skipped. Run it as root.
#   scripts/maintenance/test_platforms.sh [OPTION]... [PLATFORM]...
# PLATFORM is a name of the list or the beginning of one; the default is all of Debian.
#   --folder FOLDER     keeps root file systems, builds and results (default: ${XDG_CACHE_HOME:-~/.cache}/corrsel/platforms)
#   --ccache FOLDER     compiles with ccache, whose cache is FOLDER (default: $CCACHE_DIR; without it, ccache is not used)
#   --data FOLDER       real datasets for the tests (default: $CORRSEL_TEST_DATA); without it, tests of real data are skipped
#   --mirror SUITE=URL  takes a suite from this mirror, e.g. --mirror bullseye=http://archive.debian.org/debian
#   --again             runs the tests of these sources once more where results exist
#   --list, --help      prints the platforms, or this text
# An interrupted run is continued by the same command: root file systems, packages and compiled files are kept, and a
# platform whose tests have run with the same sources is not tested again. The root file systems take 3 GB each. The first
# run on two processor cores takes 25 minutes per platform, later ones 10.
# CORRSEL_DEBIAN_MIRROR replaces http://deb.debian.org/debian.
# Exit code: 0 no test failed, 1 a platform failed, 2 usage error.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/../common.sh"
source "$(dirname "${BASH_SOURCE[0]}")/root_file_system.sh"

# Name, suite, C++ compiler, its package, further arguments of the compiler. bullseye-as-focal stands for Ubuntu 20.04, see
# the header that it includes.
platforms=(
  "bullseye-gcc-9 bullseye g++-9 g++-9"
  "bullseye-gcc-10 bullseye g++-10 g++-10"
  "bullseye-as-focal bullseye g++-9 g++-9 -include /srv/corrsel/test/ubuntu_20_04/ubuntu_20_04.h"
  "bookworm-gcc-12 bookworm g++-12 g++-12"
  "bookworm-clang-14 bookworm clang++-14 clang-14"
  "trixie-gcc-14 trixie g++-14 g++-14"
  "focal-gcc-9 focal g++-9 g++-9"
)
names() { printf '%s\n' "${platforms[@]%% *}"; }

usage_error() {
  echo "test_platforms.sh: $1" >&2
  exit 2
}

folder=$cache_dir/platforms
ccache=${CCACHE_DIR:-}
data=${CORRSEL_TEST_DATA:-}
again=0
declare -A mirrors=()
wanted=()
while [ $# -gt 0 ]; do
  case $1 in
    -h | --help) sed -n '2,17s/^# \?//p' "${BASH_SOURCE[0]}" && exit 0 ;;
    --list) names && exit 0 ;;
    --again) again=1 && shift && continue ;;
    --folder | --ccache | --data | --mirror) [ $# -gt 1 ] || usage_error "$1 needs a value; --help explains it" ;;
    -*) usage_error "unknown option '$1'; valid: --folder, --ccache, --data, --mirror, --again, --list, --help" ;;
  esac
  case $1 in
    --folder) folder=$2 && shift ;;
    --ccache) ccache=$2 && shift ;;
    --data) data=$2 && shift ;;
    --mirror)
      [[ $2 == ?*=?* ]] || usage_error "--mirror is '$2', but must be SUITE=URL"
      mirrors[${2%%=*}]=${2#*=} && shift
      ;;
    *)
      names | grep -q "^$1" || usage_error "unknown platform '$1'; valid: $(names | paste -sd ' ')"
      wanted+=("$1")
      ;;
  esac
  shift
done
[ -z "$data" ] || [ -d "$data" ] || usage_error "the folder of real data, $data, does not exist"

require_root_user
install_packages debootstrap iproute2
mkdir -p "$folder/results"
folder=$(cd "$folder" && pwd)
# What a result depends on: sources, real data or none, the list of platforms.
sources=$(cd "$package_dir" && source_files | sort --zero-terminated | xargs -0 sha256sum | sha256sum | cut -c 1-16)
commit=$(git -C "$package_dir" describe --always --dirty --abbrev=12)

is_wanted() {
  local beginning
  if [ ${#wanted[@]} -eq 0 ]; then
    # Ubuntu's mirror differs from place to place, and must be given.
    [[ $1 != focal-* ]]
    return
  fi
  for beginning in "${wanted[@]}"; do
    [[ $1 != "$beginning"* ]] || return 0
  done
  return 1
}

# prepare NAME SUITE PACKAGE: root file system, packages, sources and sample photographs.
prepare() {
  local root=$folder/$2 mirror=${mirrors[$2]:-} arguments=()
  if [ "$2" = focal ]; then
    if [ -z "$mirror" ]; then
      echo "$1 needs a mirror of Ubuntu: give --mirror focal=URL" >&2
      return 1
    fi
    arguments=("--components=main,universe")
  fi
  make_root "$root" "$2" "${mirror:-${CORRSEL_DEBIAN_MIRROR:-http://deb.debian.org/debian}}" "${arguments[@]}"
  install_in "$root" ca-certificates "$3" ${ccache:+ccache} "${build_packages[@]}" "${test_packages[@]}" \
    "${performance_packages[@]}"
  copy_sources "$root/srv/corrsel"
  in_root "$root" <<<"/srv/corrsel/scripts/fetch_samples.sh >/dev/null"
}

# versions ROOT COMPILER: the columns of the table between the platform and the counts.
versions() {
  in_root "$1" <<COMMANDS
printf '%s %s|%s|%s|%s|%s|%s' "$2" "\$($2 -dumpfullversion -dumpversion)" \
  "\$(pkg-config --modversion opencv4)" "\$(pkg-config --modversion eigen3)" \
  "\$(cmake --version | sed -n '1s/cmake version //p')" "\$(python3 --version | cut -d' ' -f2)" \
  "\$(dpkg-query -W -f='\${Version}' libroscpp-dev | sed 's/-.*//')"
COMMANDS
}

# test_platform NAME SUITE COMPILER PACKAGE [FLAG]...: leaves the row of the table in results/NAME. Returns 1 if a test
# failed or none ran.
test_platform() {
  local name=$1 root=$folder/$2 compiler=$3 package=$4 result=$folder/results/$1 log=$folder/results/$1.log
  local arguments=(-Dcorrsel_WERROR=ON) options=(--no-network) flags="${*:5}" columns counts key
  key="$sources ${data:+data}"
  # Two runs of this script can share the work, but not one root file system at the same time.
  exec 9>"$root.lock"
  flock --nonblock 9 || {
    say "$name: waiting until another run leaves $root"
    flock 9
  }
  if [ "$again" -eq 0 ] && [ "$(head -n 1 "$result" 2>/dev/null)" = "$key" ]; then
    say "$name: the tests have run with these sources; --again runs them once more"
  else
    rm -f "$result"
    prepare "$name" "$2" "$package"
    if [ -n "$ccache" ]; then
      mkdir -p "$ccache"
      options+=(--bind "$ccache" /srv/ccache --variable "CCACHE_DIR=/srv/ccache/$2" --variable CCACHE_NOHASHDIR=1)
      options+=(--variable "CCACHE_SLOPPINESS=pch_defines,time_macros,include_file_mtime,include_file_ctime")
      arguments+=(-DCMAKE_CXX_COMPILER_LAUNCHER=ccache)
    fi
    # GCC reads a precompiled header only where no other header comes first.
    [ -z "$flags" ] || arguments+=(-DCMAKE_DISABLE_PRECOMPILE_HEADERS=ON)
    [ -z "$data" ] || options+=(--bind "$data" /srv/data --variable CORRSEL_TEST_DATA=/srv/data)
    say "$name: building and testing (log: $log)"
    in_root "$root" "${options[@]}" --variable CORRSEL_BUILD_DIR="/srv/build-$name" --variable CXX="$compiler" \
      --variable CC="$(sed 's/clang++/clang/; s/g++/gcc/' <<<"$compiler")" --variable CXXFLAGS="$flags" \
      <<<"/srv/corrsel/scripts/test.sh ${arguments[*]}" >"$log" 2>&1 || true
    grep -E '^FAILED|error|Error' "$log" | cut -c 1-300 | head -n 20 || true
    counts=$(sed -nE 's/^([0-9]+) passed, ([0-9]+) failed, ([0-9]+) skipped$/\1|\2|\3/p' "$log" | tail -n 1)
    columns=$(versions "$root" "$compiler")
    # Without counts there is no key, so that the next run tries again.
    printf '%s\n%s|%s|%s|%s\n' "${counts:+$key}" "$name" "$columns" "${counts:-not built|-|-}" "$commit" >"$result"
  fi
  [ "$(sed -n 2p "$result" | cut -d'|' -f9)" = 0 ]
}

failed=0
tested=()
running=
trap '[ -z "$running" ] || kill "$running" 2>/dev/null || true' EXIT
for platform in "${platforms[@]}"; do
  read -r -a fields <<<"$platform"
  is_wanted "${fields[0]}" || continue
  tested+=("${fields[0]}")
  # A process of its own, so that a platform that fails does not keep the others from being tested.
  test_platform "${fields[@]}" &
  running=$!
  wait "$running" || failed=1
  running=
done

say "results"
{
  echo "platform|compiler|OpenCV|Eigen|CMake|Python|ROS|passed|failed|skipped|commit"
  for name in "${tested[@]}"; do
    sed -n 2p "$folder/results/$name" 2>/dev/null || echo "$name|no root file system|-|-|-|-|-|-|-|-|-"
  done
} | awk -F'|' '
  { for (i = 1; i <= NF; ++i) { cell[NR, i] = $i; if (length($i) > width[i]) width[i] = length($i) } columns = NF }
  END {
    for (row = 1; row <= NR; ++row) {
      for (i = 1; i <= columns; ++i) printf "| %-*s ", width[i], cell[row, i]
      print "|"
      if (row > 1) continue
      for (i = 1; i <= columns; ++i) { line = "|"; for (j = -2; j < width[i]; ++j) line = line "-"; printf "%s", line }
      print "|"
    }
  }'
for name in "${tested[@]}"; do
  [ ! -e "$folder/results/$name" ] ||
    sed -nE '2s/^([^|]+).*\|([0-9]+)\|([0-9]+)\|([0-9]+)\|[^|]*$/\1: \2 passed, \3 failed, \4 skipped/p' "$folder/results/$name"
done
exit "$failed"
