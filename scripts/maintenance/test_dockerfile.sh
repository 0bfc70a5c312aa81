#!/usr/bin/env bash
# Runs the steps of docker/noetic.Dockerfile in a Debian 11 root file system, which is the closest to Ubuntu 20.04 whose
# packages Debian's archive has. Run it as root.
#   scripts/maintenance/test_dockerfile.sh [FOLDER]
# FOLDER keeps the root file system (default: ${XDG_CACHE_HOME:-~/.cache}/corrsel/docker). It contains a compiler, catkin and
# rosdep, as the base image does. What else is needed, the step `rosdep install` installs, so the run also proves that
# package.xml is complete. Instead of ROS in /opt/ros there is Debian's own, and rosdep uses the rules of Debian's packages.
# CORRSEL_DEBIAN_MIRROR replaces http://deb.debian.org/debian.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/../common.sh"
source "$(dirname "${BASH_SOURCE[0]}")/root_file_system.sh"

case ${1:-} in
  -h | --help) sed -n '2,8s/^# //p' "${BASH_SOURCE[0]}" && exit 0 ;;
  -*) echo "test_dockerfile.sh: unknown argument '$1'; valid: a folder, --help" >&2 && exit 2 ;;
esac
require_root_user
folder=${1:-$cache_dir/docker}
root=$folder/root
mkdir -p "$folder"

install_packages debootstrap python3-rosdep2
make_root "$root" bullseye "${CORRSEL_DEBIAN_MIRROR:-http://deb.debian.org/debian}"
install_in "$root" build-essential catkin cmake python3-rosdep2
# Of Debian 11's package cmake-extras, which ROS's image does not have. With it, catkin finds GoogleTest only the first time that
# CMake runs in a workspace.
rm -rf "$root/usr/share/cmake/GMock"

say "COPY . src/corrsel"
mkdir -p "$root/workspace/src" "$root/opt/ros/noetic"
rm -rf "$root/workspace/src/corrsel"
copy_sources "$root/workspace/src/corrsel"
: >"$root/opt/ros/noetic/setup.bash"
write_rosdep_sources "$root/opt/rosdep" noetic /workspace/src/corrsel
# Debian 11's rosdep comes without Debian's rules. Those of a newer release name the same packages.
rules=/usr/share/python3-rosdep2/debian.yaml
[ -e "$root$rules" ] || install -D -m 644 "$rules" "$root$rules"

mapfile -t steps < <(sed -n 's/^RUN //p' "$package_dir/docker/noetic.Dockerfile")
for step in "${steps[@]}"; do
  say "RUN $step"
  in_root "$root" --variable ROS_HOSTNAME=localhost --variable ROS_DISTRO=Debian \
    --variable ROSDEP_SOURCE_PATH=/opt/rosdep --variable ROSDISTRO_INDEX_URL=file:///opt/rosdep/index-v4.yaml <<COMMANDS
set +u  # the Dockerfile's SHELL allows variables that are not set, and setup.bash needs that
cd /workspace
{
$step
} >/tmp/step.log 2>&1 || { tail -n 30 /tmp/step.log; exit 1; }
tail -n 3 /tmp/step.log
COMMANDS
done

say "the command of the image"
in_root "$root" <<<'set +u; source /opt/corrsel/setup.bash -- && rosrun corrsel benchmark --list | sed -n 1,4p'
say "the steps of the Dockerfile and the command of the image work"
