# What the scripts in the guest share. Sourced.
export PATH=/usr/sbin:/usr/bin:/sbin:/bin
failures=0
pass() { echo "ok      $*"; }
miss() { echo "NOT OK  $*"; failures=$((failures + 1)); }
# check NAME COMMAND...: the command must succeed.
check() {
  local name=$1; shift
  if "$@" >/tmp/check.log 2>&1; then pass "$name"; else miss "$name"; tail -n 12 /tmp/check.log; return 1; fi
}
# within SECONDS COMMAND...: until it succeeds. Where `patience` is 10, ten times as long.
patience=1
steady_s() { awk '{print $1}' /proc/uptime; }
within() {
  local deadline=$((SECONDS + patience * $1)); shift
  until "$@" >/dev/null 2>&1; do ((SECONDS < deadline)) || return 1; sleep 0.2; done
}
finish() { echo "$failures failures"; exit $((failures > 0)); }
# well DEVICE...: each delivers: OK or WARN, and its rate is not 0. An emulated processor that gets little time
# loses packets and pictures, and the daemon says so (WARN): that is not what is tested here.
well() {
  local report device
  report=$(infuse status 2>/dev/null)
  for device; do grep -qE "^  (OK|WARN) +$device: [0-9.]*[1-9]" <<<"$report" || return 1; done
}
all_ok() {
  if ((patience > 1)); then infuse wait-ready --timeout 2; else well top front bus; fi
}
alert() { journalctl -u infused -o cat 2>/dev/null | grep -q "$1"; }
# moment WHAT: of the service's life, by systemd, ms of the monotonic clock.
moment() { echo $(($(systemctl show -P "$1TimestampMonotonic" infused) / 1000)); }
# kill_daemon: the daemon is killed and the next one asked. Sets, ms of the monotonic clock: `killed`, `answered`,
# and `still`, for how long the machine stood still meanwhile because its host did not run it.
kill_daemon() {
  read -r killed answered still < <(/proof/vm-clients kill "$(systemctl show -P MainPID infused)" \
    /run/infuse/infused.sock /run/vm/waited)
}
