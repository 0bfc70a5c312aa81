#!/usr/bin/env bash
# Chooses the 256 tests of the ORB descriptor by the paper's procedure on the sample images and writes them to
# src/features/descriptors/orb_pattern.cpp. The same images always give the same table. Training takes about a minute.
#   scripts/maintenance/train_orb.sh           train and replace the table
#   scripts/maintenance/train_orb.sh --check   train and compare: exit code 1 if the table in the repository differs
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/../common.sh"

case ${1:-} in
  '' | --check) train_table train_orb src/features/descriptors/orb_pattern.cpp "${1:-}" ;;
  *) sed -n '2,5s/^# //p' "${BASH_SOURCE[0]}" && exit 2 ;;
esac
