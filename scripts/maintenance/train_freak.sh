#!/usr/bin/env bash
# Chooses the 512 tests of the FREAK descriptor by the paper's procedure on the sample images and writes them to
# src/features/descriptors/freak_pairs.cpp. The same images always give the same table. Training takes a few seconds.
#   scripts/maintenance/train_freak.sh           train and replace the table
#   scripts/maintenance/train_freak.sh --check   train and compare: exit code 1 if the table in the repository differs
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/../common.sh"

case ${1:-} in
  '' | --check) train_table train_freak src/features/descriptors/freak_pairs.cpp "${1:-}" ;;
  *) sed -n '2,5s/^# //p' "${BASH_SOURCE[0]}" && exit 2 ;;
esac
