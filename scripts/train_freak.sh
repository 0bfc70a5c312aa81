#!/usr/bin/env bash
# Chooses the 512 tests of the FREAK descriptor by the paper's procedure on the sample images and writes them to
# src/features/descriptors/freak_pairs.cpp. The same images always give the same table. Training takes a few seconds.
#   scripts/train_freak.sh           train and replace the table
#   scripts/train_freak.sh --check   train and compare: exit code 1 if the table in the repository differs
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"

check=0
case ${1:-} in
  '') ;;
  --check) check=1 ;;
  *) sed -n '2,5s/^# //p' "${BASH_SOURCE[0]}" && exit 2 ;;
esac

table=$package_dir/src/features/descriptors/freak_pairs.cpp
samples=$cache_dir/sample
trained=$(mktemp)
trap 'rm -f "$trained"' EXIT

install_packages "${build_packages[@]}"
"$package_dir/scripts/fetch_samples.sh" "$samples"
build train_freak -- -DCMAKE_BUILD_TYPE=Release
say "training"
"$build_dir/devel/lib/corrsel/train_freak" "$samples" >"$trained"
if [ $check -eq 0 ]; then
  cat "$trained" >"$table"
  say "wrote $table"
elif cmp -s "$trained" "$table"; then
  say "the table in the repository agrees with the training"
else
  diff -u "$table" "$trained" | head -n 20 >&2
  echo "the table in the repository differs from the training: run scripts/train_freak.sh" >&2
  exit 1
fi
