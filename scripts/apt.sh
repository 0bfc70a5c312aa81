# shellcheck shell=bash
# Sourced by other scripts of this folder; not run by itself.

# apt_get ARGUMENT...: runs apt-get as root. While another process holds a lock of apt or dpkg, prints that it waits and
# tries again, for at most 15 minutes. Where apt-get fails, prints the end of its output and returns its exit code.
apt_get() {
  local as_root=() log code waited=0
  if [ "$(id -u)" -ne 0 ]; then
    command -v sudo >/dev/null || {
      echo "cannot run apt-get without root: run 'apt-get $*' as root, then this script again" >&2
      return 1
    }
    as_root=(sudo)
  fi
  log=$(mktemp)
  while true; do
    code=0
    "${as_root[@]}" env LC_ALL=C.UTF-8 DEBIAN_FRONTEND=noninteractive apt-get "$@" >"$log" 2>&1 || code=$?
    # apt-get has a timeout of its own for the lock of dpkg, but none for the lock of the package lists.
    if [ "$code" -eq 0 ] || [ "$waited" -ge 900 ] || ! grep -q 'Could not get lock' "$log"; then
      break
    fi
    [ "$waited" -gt 0 ] || echo "waiting until another process releases a lock of apt: $(
      grep -om 1 'Could not get lock.*' "$log"
    )" >&2
    sleep 5
    waited=$((waited + 5))
  done
  if [ "$code" -ne 0 ]; then
    tail -n 20 "$log" >&2
    echo "apt-get $1 failed: the lines above are the end of its output" >&2
  fi
  rm -f "$log"
  return "$code"
}
