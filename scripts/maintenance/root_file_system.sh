# shellcheck shell=bash
# Sourced after common.sh by the scripts that build and test in root file systems; not run by itself.
#
# Every command in a root file system runs in mount and process namespaces of its own, which end with its first process,
# and that one ends with the script (pdeathsig), also after Ctrl-C or kill. Its mounts are seen nowhere else and disappear
# with the namespace: there is nothing to unmount.

# require_root_user: stops with an error if the script does not run as root.
require_root_user() {
  if [ "$(id -u)" -ne 0 ]; then
    echo "$(basename "$0") needs root, for debootstrap and chroot: run it with sudo" >&2
    exit 1
  fi
}

# remove_folder FOLDER: removes a root file system, and refuses where something is mounted below it.
remove_folder() {
  if findmnt --noheadings --list --output TARGET | grep -F "$1/" >&2; then
    echo "$1 is not removed, because the folders above are mounted below it: unmount them and run this script again" >&2
    exit 1
  fi
  rm -rf --one-file-system "$1"
}

# make_root FOLDER SUITE MIRROR [DEBOOTSTRAP_ARGUMENT...]: creates a minimal root file system, unless it is there. It gets
# its name only once it is complete, so that an interrupted run leaves nothing half-made.
make_root() {
  local root=$1 suite=$2 mirror=$3
  shift 3
  [ ! -d "$root" ] || return 0
  say "debootstrap of $suite in $root"
  mkdir -p "$(dirname "$root")"
  remove_folder "$root.new"
  debootstrap --variant=minbase "$@" "$suite" "$root.new" "$mirror" >"$root.debootstrap.log" 2>&1 || {
    tail -n 20 "$root.debootstrap.log" >&2
    echo "debootstrap failed: the lines above are the end of $root.debootstrap.log" >&2
    exit 1
  }
  mv "$root.new" "$root"
}

# in_root ROOT [--no-network] [--bind FOLDER PATH] [--variable NAME=VALUE]...: runs the commands of the standard input in a
# root file system with its own settings only. FOLDER appears at PATH, --no-network leaves only the loopback device, so that
# ROS nodes do not meet those of another test run.
in_root() {
  local root=$1 namespaces=(--mount --pid) binds=() variables=()
  shift
  while [ $# -gt 0 ]; do
    case $1 in
      --no-network) namespaces+=(--net) && shift ;;
      --bind) binds+=("$2" "$3") && shift 3 ;;
      --variable) variables+=("$2") && shift 2 ;;
      *) echo "in_root: unknown argument '$1'" >&2 && return 2 ;;
    esac
  done
  # In the background, because bash handles Ctrl-C at once only while it executes `wait`.
  # shellcheck disable=SC2016  # the inner bash expands its own arguments
  setpriv --pdeathsig KILL unshare "${namespaces[@]}" --fork --kill-child --propagation private bash -euo pipefail -c '
    root=$1
    shift
    mount -t proc proc "$root/proc"
    mount -t tmpfs tmpfs "$root/dev/shm"
    mount -t devpts -o newinstance,ptmxmode=0666 devpts "$root/dev/pts"
    while [ "$1" != -- ]; do
      mkdir -p "$root$2"
      mount --bind "$1" "$root$2"
      shift 2
    done
    shift
    ip link set lo up
    exec chroot "$root" /usr/bin/env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root LANG=C.UTF-8 \
      DEBIAN_FRONTEND=noninteractive "$@" bash -euo pipefail -s
  ' in_root "$root" "${binds[@]}" -- "${variables[@]}" <&0 &
  wait $!
}

# install_in ROOT NAME...: installs the Debian packages that are missing in a root file system.
install_in() {
  local root=$1
  shift
  # Without the resolver's settings of the host of today, apt finds no mirror.
  cp /etc/resolv.conf "$root/etc/resolv.conf"
  printf '127.0.0.1 localhost %s\n::1 localhost\n' "$(hostname)" >"$root/etc/hosts"
  in_root "$root" <<COMMANDS
missing=()
for name in $*; do
  [ "\$(dpkg-query -W -f='\${db:Status-Status}' "\$name" 2>/dev/null)" = installed ] || missing+=("\$name")
done
if [ \${#missing[@]} -gt 0 ]; then
  echo "installing in $root: \${missing[*]}"
  { dpkg --configure -a && apt-get update && apt-get install -y --fix-broken --no-install-recommends \
    -o Dpkg::Options::=--force-unsafe-io "\${missing[@]}"; } >/tmp/apt.log 2>&1 || {
    tail -n 20 /tmp/apt.log >&2
    echo "apt-get failed in $root: the lines above are the end of its output" >&2
    exit 1
  }
  apt-get clean
fi
COMMANDS
}

# source_files: lists the sources as git sees them, with uncommitted changes, each name ended by a zero byte.
source_files() {
  local file
  # shellcheck disable=SC2154  # package_dir is set in common.sh
  git -C "$package_dir" ls-files -z --cached --others --exclude-standard |
    while IFS= read -r -d '' file; do [ ! -e "$package_dir/$file" ] || printf '%s\0' "$file"; done
}

# copy_sources FOLDER: replaces the folder by the sources. Files whose content has not changed keep their time, so that a
# build folder beside it is brought up to date instead of being built again.
copy_sources() {
  local folder=$1 file
  rm -rf --one-file-system "$folder.new"
  mkdir -p "$folder.new"
  source_files | tar --create --directory "$package_dir" --no-recursion --null --files-from=- |
    tar --extract --touch --directory "$folder.new"
  if [ -d "$folder" ]; then
    while IFS= read -r -d '' file; do
      if cmp -s "$folder/$file" "$folder.new/$file"; then
        touch --no-dereference --reference="$folder/$file" "$folder.new/$file"
      fi
    done < <(source_files)
    rm -rf --one-file-system "$folder"
  fi
  mv "$folder.new" "$folder"
}
