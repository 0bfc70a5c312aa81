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
  data/left01.jpg
  data/right01.jpg
  data/left02.jpg
  data/right02.jpg
  data/left03.jpg
  data/right03.jpg
  data/left04.jpg
  data/right04.jpg
  data/left06.jpg
  data/right06.jpg
  data/left07.jpg
  data/right07.jpg
  data/left08.jpg
  data/right08.jpg
  data/left09.jpg
  data/right09.jpg
  data/left11.jpg
  data/right11.jpg
  data/left12.jpg
  data/right12.jpg
  data/left13.jpg
  data/right13.jpg
  data/left14.jpg
  data/right14.jpg
  data/box.png
  data/box_in_scene.png
  reg/LR_05.png
  reg/LR_06.png
)

fail() {
  echo "fetch_samples.sh: $1" >&2
  exit 1
}

# missing FOLDER FILE...: prints the files that do not exist below the folder, or are empty.
missing() {
  local file
  for file in "${@:2}"; do
    [[ -s "$1/$file" ]] || echo "$file"
  done
}

if [[ $# -gt 1 || ${1:-} == -* ]]; then
  fail "usage: fetch_samples.sh [FOLDER]"
fi
folder=${1:-${XDG_CACHE_HOME:-$HOME/.cache}/corrsel/sample}

# Files that are there stay as they are, with their times, by which runs recognise a dataset.
wanted=()
for file in "${files[@]}"; do
  [[ -s "$folder/${file##*/}" ]] || wanted+=("$file")
done
if [[ ${#wanted[@]} -eq 0 ]]; then
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
if [[ -n "$(missing "$source_root" "${wanted[@]}")" ]]; then
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
  lacking=$(missing "$source_root" "${wanted[@]}" | paste -sd ' ')
  [[ -z "$lacking" ]] ||
    fail "${packages[0]##*/} lacks $lacking; copy that from Debian 12's opencv-doc into $folder and try again"
fi

# Files get their names in the folder only once they are complete.
for file in "${wanted[@]}"; do
  cp "$source_root/$file" "$staging/"
done
mv -f "$staging"/* "$folder/"
echo "Put ${#wanted[@]} sample files into $folder"
