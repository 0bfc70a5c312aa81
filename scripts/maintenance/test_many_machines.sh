#!/usr/bin/env bash
# Runs the commands of docs/evaluation.md, section "Many machines", as they are printed there, and compares their merged
# results with those of an undivided run: with GNU parallel, and with a Slurm cluster of two nodes that this script starts on
# this machine. Then a part of the Slurm job is requeued while it runs, another one is cancelled and submitted again, and a
# merge is tried without one of its parts.
#   scripts/maintenance/test_many_machines.sh [--short]
# --short leaves out what comes after the first run with Slurm. It is part of .ci/run.
# Slurm and munge have a configuration, a key, ports and folders of their own. They listen on the loopback device only, and
# they end with the script. Services of these packages that run already are not touched.
# Exit code 0 only if all results are the same.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/../common.sh"

short=0
case ${1:-} in
  -h | --help) sed -n '2,11s/^# //p' "${BASH_SOURCE[0]}" && exit 0 ;;
  --short) short=1 ;;
  ?*) echo "test_many_machines.sh: unknown argument '$1'; valid: --short, --help" >&2 && exit 2 ;;
esac
# They replace those of the documentation, whose run takes hours.
grid=(dataset:=sample data_root:="$cache_dir" max_pairs:=12 features:=orb+orb "selectors:=ransac,lpm,gms,usac")
parts=3

work=$(mktemp -d)
daemons=()
# Ends what this script has started, also after an error.
end() {
  local code=$?
  trap '' INT TERM
  if [ ${#daemons[@]} -gt 0 ]; then
    # Jobs end within KillWait. The daemons must run until then.
    scancel --user "$(id -un)" 2>/dev/null || true
    # shellcheck disable=SC2016  # the inner bash expands it
    timeout 30 bash -c 'while [ -n "$(squeue --noheader 2>/dev/null)" ]; do sleep 0.2; done' || true
  fi
  for daemon in "${daemons[@]}"; do
    kill "$daemon" 2>/dev/null || true
  done
  wait
  if [ "$code" -ne 0 ]; then
    tail -n 5 "$work"/*.log "$work"/runs/*.log "$work"/slurm-*.out >&2 2>/dev/null || true
    echo "the test failed: the lines above are the ends of the log files" >&2
  fi
  rm -rf "$work"
  exit "$code"
}
trap end EXIT
trap 'exit 130' INT TERM

# documented WORD [FILE]: the commands of a file of the documentation, evaluation.md by default, that contain the word. They
# write below $work, have the arguments above, and make $parts parts.
documented() {
  local commands
  commands=$(awk -v word="$1" '
    /^```/ { if (inside && index(block, word)) printf "%s", block; inside = !inside; block = ""; next }
    inside { block = block $0 "\n" }' "$package_dir/docs/${2:-evaluation.md}")
  commands=$(sed "s|^N=.*|N=$parts|; s|experiment:=paper data_root:=/data|${grid[*]}|; s|/runs|$work/runs|g
    s|/data/house.db|$work/house.db|g; s|corrsel_verify|rosrun corrsel corrsel_verify|" <<<"$commands")
  if [ -z "$commands" ] || grep -qE 'experiment:=paper|[ =%f]/(data|runs)' <<<"$commands"; then
    echo "docs/${2:-evaluation.md}, Many machines: these commands are not understood any more: $commands" >&2
    return 1
  fi
  printf '%s\n' "$commands"
}

# checksums FOLDER: the checksums of the files of a run, without columns of times. Remarks stand in the order of the parts.
checksums() {
  local file
  for file in $(cd "$1" && ls ./*.csv images/*.csv); do
    case $file in */remarks.csv | */stages.csv) continue ;; esac
    # The first line that is no comment names the columns.
    awk -F, '/^#/ { next } !named++ { for (i = 1; i <= NF; ++i) timed[i] = $i ~ /_s(_|$)/ }
      { line = ""; for (i = 1; i <= NF; ++i) if (!timed[i]) line = line "," $i; print line }' "$1/$file" |
      sha256sum | sed "s|-|$file|"
  done
  sort "$1/remarks.csv" | sha256sum | sed "s|-|remarks.csv|"
  (cd "$1" && sha256sum config.yaml && find images -name '*.jpg' -exec sha256sum {} + | sort -k 2 | sha256sum) |
    sed 's|-|images/*.jpg|'
}

# compare NAME: fails unless the merged run is complete and has the checksums of the undivided one.
compare() {
  checksums "$work/runs/whole" >"$work/$1.sums"
  if ! diff "$work/uncut.sums" "$work/$1.sums" >&2 || ! grep -q '"complete": true' "$work/runs/whole/summary.json"; then
    echo "$1: the merged run is not the undivided one" >&2
    return 1
  fi
  echo "$1: $(wc -l <"$work/runs/whole/pairs.csv") lines in pairs.csv, all checksums are those of the undivided run"
}

# Every job finds an empty cache.
forget() {
  rm -rf "$work/cache" "$work/runs" "$work"/slurm-*.out
  mkdir -p "$work/runs"
}

# start_slurm: starts munged, slurmctld and one slurmd per node, and waits until the nodes are idle.
start_slurm() {
  local ports port node user
  user=$(id -un)
  mapfile -t ports < <(python3 -c '
import socket
sockets = [socket.socket() for _ in range(3)]
for one in sockets:
    one.bind(("127.0.0.1", 0))
    print(one.getsockname()[1])')
  mkdir -p "$work/slurm/state"
  (umask 077 && head -c 128 /dev/urandom >"$work/slurm/munge.key")
  cat >"$work/slurm/slurm.conf" <<CONFIGURATION
ClusterName=corrsel
SlurmctldHost=localhost(127.0.0.1)
SlurmctldPort=${ports[0]}
SlurmUser=$user
SlurmdUser=$user
AuthType=auth/munge
AuthInfo=socket=$work/slurm/munge.socket
CommunicationParameters=NoCtldInAddrAny,NoInAddrAny
StateSaveLocation=$work/slurm/state
SlurmdSpoolDir=$work/slurm/spool_%n
SlurmctldPidFile=$work/slurm/slurmctld.pid
SlurmdPidFile=$work/slurm/slurmd_%n.pid
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
MpiDefault=none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
SlurmdParameters=config_overrides
ReturnToService=2
KillWait=10
SchedulerParameters=sched_interval=1
NodeName=machine1 NodeHostname=localhost NodeAddr=127.0.0.1 Port=${ports[1]} CPUs=2
NodeName=machine2 NodeHostname=localhost NodeAddr=127.0.0.1 Port=${ports[2]} CPUs=2
PartitionName=all Nodes=ALL Default=YES MaxTime=INFINITE State=UP
CONFIGURATION
  # From this version on, Slurm can be told not to look for control groups, which a container need not have.
  if dpkg --compare-versions "$(slurmd -V | cut -d' ' -f2)" ge 23.11; then
    echo CgroupPlugin=disabled >"$work/slurm/cgroup.conf"
  fi
  export SLURM_CONF=$work/slurm/slurm.conf
  munged --foreground --force --socket="$work/slurm/munge.socket" --key-file="$work/slurm/munge.key" \
    --pid-file="$work/slurm/munge.pid" --seed-file="$work/slurm/munge.seed" >"$work/munged.log" 2>&1 &
  daemons+=($!)
  wait_for "munged does not answer" test -S "$work/slurm/munge.socket"
  slurmctld -D >"$work/slurmctld.log" 2>&1 &
  daemons+=($!)
  for node in machine1 machine2; do
    slurmd -D -N "$node" >"$work/slurmd_$node.log" 2>&1 &
    daemons+=($!)
  done
  wait_for "the nodes of Slurm do not become idle" nodes_are_idle
  for port in "${ports[@]}"; do
    awk -v port="$(printf ':%04X' "$port")" '$4 == "0A" && index($2, port) { ++found; if ($2 != "0100007F" port) ++other }
      END { exit !(found && !other) }' /proc/net/tcp /proc/net/tcp6 || {
      echo "the port $port of Slurm is open for other machines" >&2
      return 1
    }
  done
  sinfo --version
  sinfo --Node
}

nodes_are_idle() { [ "$(sinfo --noheader --Node --states=idle 2>/dev/null | wc -l)" -eq 2 ]; }
queue_is_empty() { [ -z "$(squeue --noheader)" ]; }
# has_pairs FOLDER: a run has finished a pair.
has_pairs() { [ -e "$1/pairs.csv" ] && [ "$(wc -l <"$1/pairs.csv")" -gt 2 ]; }

daemons_run() {
  local daemon
  for daemon in "${daemons[@]}"; do
    kill -0 "$daemon" 2>/dev/null || return 1
  done
}

# wait_for MESSAGE COMMAND...: waits until a command succeeds, for at most ten minutes and while the daemons run.
wait_for() {
  local message=$1 end=$((SECONDS + 600))
  shift
  while [ "$SECONDS" -lt "$end" ] && daemons_run; do
    ! "$@" || return 0
    sleep 0.2
  done
  echo "$message" >&2
  return 1
}

# merge_by_hand FOLDER: the merge as documented, into another folder.
merge_by_hand() {
  rosrun corrsel benchmark "${grid[@]}" threads:=1 output_dir:="$1" merge:="$(seq -s , -f "$work/runs/part%g" $parts)"
}

install_packages "${build_packages[@]}" munge parallel slurm-client slurmctld slurmd
"$package_dir/scripts/fetch_samples.sh" "$cache_dir/sample"
build benchmark corrsel_verify
use_workspace
export XDG_CACHE_HOME=$work/cache ROS_HOME=$work/ros
cd "$work"

say "the undivided run"
rosrun corrsel benchmark "${grid[@]}" threads:=1 output_dir:="$work/uncut" >uncut.log
checksums "$work/uncut" | tee uncut.sums

say "GNU parallel"
forget
documented parallel
bash -euo pipefail -c "$(documented parallel)" >parallel.log
compare parallel

say "Slurm"
forget
start_slurm
documented sbatch
bash -euo pipefail -c "$(documented sbatch)"
wait_for "the jobs of Slurm do not end" queue_is_empty
compare Slurm

say "Slurm: the verification of a database"
forget
"$package_dir/scripts/maintenance/generate_database.py" --pairs 150 --matches 60 --images-of-place 8 house.db
checksum_of() { grep 'checksum of the rows' | grep -o '[0-9a-f]\{16\}$'; }
rosrun corrsel corrsel_verify house.db --output verified.db | tee verify.log
documented sbatch verification.md
bash -euo pipefail -c "$(documented sbatch verification.md)"
wait_for "the jobs of Slurm do not end" queue_is_empty
rosrun corrsel corrsel_verify "$work/runs/whole.db" | tee merged.log
if ! grep -q 'verified by this run *0$' merged.log || [ "$(checksum_of <merged.log)" != "$(checksum_of <verify.log)" ]; then
  echo "the merged database is not that of the undivided run" >&2
  exit 1
fi
[ "$short" -eq 0 ] || exit 0

say "Slurm: part 1 is requeued while it runs, part 2 is cancelled"
forget
bash -euo pipefail -c "$(documented sbatch)"
job=$(squeue --noheader --array --format=%F | sort -n | head -n 1)
wait_for "part 1 finishes no pair" has_pairs "$work/runs/part1"
scontrol requeue "${job}_1"
wait_for "part 2 finishes no pair" has_pairs "$work/runs/part2"
scancel "${job}_2"
# Slurm waits for two minutes before it starts a requeued job again.
wait_for "part 1 is not requeued" scontrol update "JobId=${job}_1" StartTime=now 2>/dev/null
wait_for "the jobs of Slurm do not end" queue_is_empty
scontrol show job "${job}_1" | grep -o 'Restarts=1'
compare "requeued and cancelled"

say "Slurm: the same commands again, without the merged run"
rm -r "$work/runs/whole"
bash -euo pipefail -c "$(documented sbatch)"
wait_for "the jobs of Slurm do not end" queue_is_empty
compare "submitted again"

say "a merge without part 2"
rm -r "$work/runs/part2"
code=0
merge_by_hand "$work/runs/without" 2>without.log || code=$?
cat without.log
if [ "$code" -ne 2 ] || ! grep -q "part2: it holds no run" without.log || [ -e "$work/runs/without" ]; then
  echo "exit code $code: a merge must refuse a folder that is not there" >&2
  exit 1
fi
say "the parts of a run give the results of the whole run"
