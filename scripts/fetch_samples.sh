#!/usr/bin/env bash
# Collects the images of the built-in sample dataset from Debian's package opencv-doc in one folder.
#
# Usage: fetch_samples.sh [FOLDER]
#   FOLDER  default: ${XDG_CACHE_HOME:-$HOME/.cache}/corrsel/sample
#
# Uses the installed package if there is one. Otherwise downloads the package without installing it.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/apt.sh"
export PATH=/usr/bin:/bin:$PATH

readonly examples=usr/share/doc/opencv-doc/examples
readonly files=(
  data/graf1.png
  data/graf3.png
  data/H1to3p.xml
  data/aloeL.jpg
  data/aloeR.jpg
  data/aloeGT.png
  data/building.jpg
  text/scenetext04.jpg
  data/baboon.jpg
  text/scenetext_segmented_word01.jpg
  data/board.jpg
  text/scenetext01.jpg
  data/leuvenA.jpg
  data/home.jpg
  text/scenetext03.jpg
  data/aero1.jpg
)

fail() {
  echo "fetch_samples.sh: $1" >&2
  exit 1
}

# complete FOLDER FILE...: succeeds if every file exists below the folder and is not empty.
complete() {
  local file
  for file in "${@:2}"; do
    [[ -s "$1/$file" ]] || return 1
  done
}

if [[ $# -gt 1 || ${1:-} == -* ]]; then
  fail "usage: fetch_samples.sh [FOLDER]"
fi
folder=${1:-${XDG_CACHE_HOME:-$HOME/.cache}/corrsel/sample}

if complete "$folder" "${files[@]##*/}"; then
  echo "All ${#files[@]} sample files are already in $folder"
  exit 0
fi

work=
staging=
trap 'rm -rf ${work:+"$work"} ${staging:+"$staging"}' EXIT

other_folder="give another folder as the argument"
mkdir -p "$folder" || fail "cannot create $folder; $other_folder"
staging=$(mktemp -d "$folder/.fetch.XXXXXX") || fail "cannot write to $folder; $other_folder"

source_root=/$examples
if ! complete "$source_root" "${files[@]}"; then
  command -v apt-get >/dev/null ||
    fail "opencv-doc is not installed and there is no apt-get; copy its files by hand into $folder"
  work=$(mktemp -d)
  # apt downloads as the user _apt, who needs to write to the folder.
  chmod 755 "$work"
  mkdir -m 777 "$work/download"
  echo "Downloading opencv-doc ..."
  if ! (cd "$work/download" && apt-get download -q opencv-doc); then
    [[ $EUID -eq 0 ]] || fail "apt cannot download opencv-doc; run 'sudo apt-get update' and try again"
    (apt_get update && cd "$work/download" && apt-get download -q opencv-doc) ||
      fail "apt cannot download opencv-doc; check the network and the package sources"
  fi
  packages=("$work"/download/opencv-doc_*.deb)
  dpkg-deb -x "${packages[0]}" "$work/unpacked" ||
    fail "the downloaded package cannot be unpacked; free some space for temporary files and try again"
  source_root=$work/unpacked/$examples
  complete "$source_root" "${files[@]}" ||
    fail "${packages[0]##*/} lacks some of the sample images; take them from Debian 12's opencv-doc"
fi

# Files get their names in the folder only once they are complete.
for file in "${files[@]}"; do
  cp "$source_root/$file" "$staging/"
done
mv -f "$staging"/* "$folder/"
echo "Put ${#files[@]} sample files into $folder"
