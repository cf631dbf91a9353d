#!/bin/bash
# In the guest: tests the installed package, live sensors and the watchdog; with "faults" also failures. /proof
# holds the package, captures, and the helper programs.
. /proof/guest_lib.sh
# The quick part also runs on busy hosts, with ten times the timeouts.
[[ ${1-} == faults ]] || timeout_factor=10
export DEBIAN_FRONTEND=noninteractive

# Indexing the host's manual pages would take minutes.
rm -f /var/lib/man-db/auto-update
# A host that is a container may forbid packages to start services.
rm -f /usr/sbin/policy-rc.d
check "packages install" dpkg -i /proof/infused.deb /proof/infuse.deb
check "the service is enabled" systemctl is-enabled infused.service infused.socket
check "without sensors it runs" within 20 systemctl is-active infused.service
check "user, state and socket are there" sh -c 'id infuse && test -d /var/lib/infuse && test -S /run/infuse/infused.sock'
check "net.core.rmem_max was raised" sh -c 'test "$(sysctl -n net.core.rmem_max)" = 16777216'

use_three_sensors() {
  cat >/etc/infuse/infused.toml.d/test.toml <<'TOML'
[[lidar]]
name = "top"
model = "VLP-16"
[[camera]]
name = "front"
device = "/dev/video0"
width = 320
height = 240
format = "GREY"
[[can]]
name = "bus"
interface = "vcan0"
[odometry]
use_lidar = false  # on an emulated processor a registration takes seconds
[record]
memory_mb = 8  # small, so that all of it is used soon
TOML
}
use_three_sensors
check "the configuration is valid" infused --check-config --config /etc/infuse/infused.toml

# The lidar is in its own network namespace, at the other end of a veth pair.
ip netns add car
lay_cable() {
  ip link add lidar0 type veth peer name car0 netns car
  ip addr add 10.77.0.2/24 dev lidar0 && ip link set lidar0 up
  ip -n car addr add 10.77.0.1/24 dev car0 && ip -n car link set car0 up
}
lay_cable
play_bus() { canplayer -l i -I /proof/can.log vcan0=vcan0 >/tmp/canplayer.log 2>&1 & player=$!; }
send_lidar() { setsid ip netns exec car bash -c 'while /proof/infuse-send-capture /proof/street.pcap --to 10.77.0.2; do :; done' >/tmp/sender.log 2>&1 & sender=$!; }
hush_bus() { kill $player; wait $player; } 2>/dev/null
hush() { hush_bus; kill -- -$sender; wait $sender; } 2>/dev/null
# The senders start before the clock: the first read of a host file is slow.
send_lidar
play_bus
sleep 1
started=$(date +%s%N)
systemctl restart infused.service
check "all three deliver within $((5 * timeout_factor)) s of start" infuse wait-ready --timeout $((5 * timeout_factor))
echo "        after $((($(date +%s%N) - started) / 1000000)) ms"
check "and are OK" within 5 all_ok
infuse status
systemctl status infused --no-pager -n 0 | sed -n 's/^ *Status/        status/p'
check "it runs without root" sh -c 'test "$(ps -o user= -p "$(systemctl show -P MainPID infused)")" = infuse'
check "it has no capability" sh -c 'grep -q "^CapEff:\s*0*$" /proc/$(systemctl show -P MainPID infused)/status'
check "the io thread has real-time priority" sh -c 'chrt -p $(ps -L -o tid=,comm= -p $(systemctl show -P MainPID infused) | awk "\$2 == \"io\" {print \$1}") | grep -q FIFO'
check "io and fusion have a core each, and memory is locked" sh -c 'cd /proc/$(systemctl show -P MainPID infused) &&
  core() { grep -l "^$1\$" task/*/comm | xargs dirname | xargs -I{} sed -n "s/^Cpus_allowed_list:\s*//p" {}/status; }
  test "$(core io)" = 0 && test "$(core fusion)" = 1 && awk "/^VmLck/ {exit !(\$2 > 1000)}" status'
check "security: at most 1.9" systemd-analyze security --threshold=19 --no-pager infused.service
check "a reload keeps the process" sh -c 'p=$(systemctl show -P MainPID infused); systemctl reload infused && sleep 1 && test "$p" = "$(systemctl show -P MainPID infused)"'
check "and the sensors" within 3 all_ok

# --- a configuration that is tried ---
{ echo 'version = "tried"'; cat /etc/infuse/infused.toml; } >/tmp/tried.toml
check "a configuration that is ready in time stays" infuse config apply /tmp/tried.toml --wait $((20 * timeout_factor))
check "its version is reported" sh -c 'infuse status | grep -q "^configuration .* tried"'
echo "1 1" >/etc/infuse/infused.toml.trying  # as a machine leaves it that was switched off meanwhile
systemctl restart infused.service
check "what was not confirmed goes back at the next start" sh -c '! grep -q tried /etc/infuse/infused.toml'
check "and all are OK" within 20 all_ok

# Failures that the same process must survive.
if [[ ${1-} == faults ]]; then . /proof/faults.sh; fi

# --- restarts ---
kill_daemon
check "SIGKILL: back within $((3 * timeout_factor)) s" test $((answered - killed - stalled)) -lt $((3000 * timeout_factor))
echo "        after $((answered - killed)) ms; the machine was stalled for $stalled ms"
check "an alert is raised" within 5 alert "did not end by itself"
check "and all are OK" within 6 all_ok
if [[ ${1-} == faults ]]; then
. /proof/kills.sh
. /proof/record.sh
. /proof/several.sh

mount -t tmpfs -o size=16k,uid=infuse,gid=infuse,mode=750 none /var/lib/infuse
systemctl restart infused.service
head -c 16k /dev/zero >/var/lib/infuse/fill 2>/dev/null
check "disk full: it is logged, and the daemon continues" within 25 sh -c 'journalctl -u infused -o cat | grep -q "No space left" && systemctl is-active infused'
check "infuse status says so" within 15 sh -c 'infuse status | grep -q "WARN  state on disk"'
printf '[mqtt]\nhost = "127.0.0.1"\nvehicle = "car"\n' >/etc/infuse/infused.toml.d/broker.toml
systemctl restart infused.service
check "and it starts on the full disk, with [mqtt]" within 8 all_ok
mount -o remount,ro /var/lib/infuse
systemctl restart infused.service
check "and on a read-only one" within 8 all_ok
rm /etc/infuse/infused.toml.d/broker.toml
systemctl stop infused.service; umount /var/lib/infuse; systemctl start infused.service
within 10 back
. /proof/others.sh
. /proof/load.sh
. /proof/tap.sh
check "all are OK" within 8 all_ok
fi
tid=$(ps -L -o tid=,comm= -p "$(systemctl show -P MainPID infused)" | awk '$2 == "fusion" {print $1}')
before=$(systemctl show -P NRestarts infused)
starts() { sed -n 's/.*"starts": *\([0-9]*\).*/\1/p' /var/lib/infuse/state.json; }
starts_before=$(starts)
/proof/vm-wedge "$tid" 20 & wedge=$!
check "fusion thread wedged: the watchdog restarts it" within 15 sh -c "test \$(systemctl show -P NRestarts infused) -gt $before"
kill $wedge 2>/dev/null
check "an alert is raised" within 10 sh -c 'infuse status --json | grep "\"class\":\"ALERT\"" | grep -q "the watchdog ended the previous run"'
check "it continues from the saved state" test "$(starts)" = $((starts_before + 1))
check "and all are OK" within 8 all_ok
check "a clean stop" systemctl stop infused.service
took=$(($(moment InactiveEnter) - $(moment ActiveExit)))
check "within $((2 * timeout_factor)) s ($took ms)" test $took -lt $((2000 * timeout_factor))
check "the saved state records a clean exit" grep -q '"running": false' /var/lib/infuse/state.json

# --- a wrong configuration ---
echo 'log_level = "loud"' >/etc/infuse/infused.toml.d/wrong.toml
systemctl start infused.service 2>/dev/null
sleep 10
wrong_starts=$(systemctl show -P NRestarts infused)
check "a wrong configuration: restarts slowly ($wrong_starts)" test "$wrong_starts" -le 4
check "its reason is in the journal" sh -c 'journalctl -u infused -o cat | grep -q "wrong.toml:1: log_level is none of"'
rm /etc/infuse/infused.toml.d/wrong.toml
check "mended, it starts by itself" within 8 systemctl is-active infused.service
systemctl stop infused.service

if [[ ${1-} == faults ]]; then
# --- recordings of alerts leave the vehicle; what support asks for ---
install -d -o infuse -g infuse -m 750 /var/lib/infuse/spool
printf '#!/bin/sh\nls "$1" >/tmp/taken\n' >/etc/infuse/upload; chmod +x /etc/infuse/upload
sed 's|PrivateTmp=yes||; s|ProtectSystem=strict||' /lib/systemd/system/infuse-upload.service >/run/systemd/system/infuse-upload.service
systemctl daemon-reload
systemctl start infuse-upload.path
mkdir -p /var/lib/infuse/drives/alert-x; echo /var/lib/infuse/drives/alert-x >/var/lib/infuse/spool/alert-x
check "a recording of an alert is given to the hook" within 10 sh -c 'test -e /tmp/taken && ! test -e /var/lib/infuse/spool/alert-x'
systemctl stop infuse-upload.path
check "support gets an archive" sh -c 'infuse diagnose -o /tmp/car.tar.zst && test -s /tmp/car.tar.zst'
fi

# --- package ---
check "a client starts the daemon through the socket" within 5 sh -c 'infuse status --json | grep -q DEVICES && systemctl is-active infused'
check "the self-test passes as the service's user" sh -c 'STATE_DIRECTORY=/var/lib/infuse setpriv --reuid=infuse --regid=infuse --init-groups infused --config /etc/infuse/infused.toml --self-test'
if [[ ${1-} == faults ]]; then
# An upgrade that is killed at any moment is finished by another one.
upgrades=20 unfinished=0
for round in $(seq $upgrades); do
  setsid dpkg -i /proof/infused.deb >/tmp/upgrade.log 2>&1 & upgrade=$!
  sleep "$((RANDOM % 3)).$((RANDOM % 10))"
  { kill -9 -- -$upgrade; wait $upgrade; } 2>/dev/null
  { dpkg --configure -a; dpkg -i /proof/infused.deb && within 10 systemctl is-active infused; } >/tmp/upgrade.log 2>&1 ||
    { unfinished=$((unfinished + 1)); tail -n 5 /tmp/upgrade.log; }
done
check "$upgrades killed upgrades: $unfinished cannot be finished" test $unfinished = 0
fi
check "upgrade keeps it running" sh -c 'dpkg -i /proof/infused.deb && systemctl is-active infused'
check "remove stops it" sh -c 'dpkg -r infused && ! systemctl is-active infused && ! test -e /usr/bin/infused'
check "and keeps the configuration" test -e /etc/infuse/infused.toml
check "purge leaves nothing" sh -c 'dpkg -P infused infuse && ! test -e /var/lib/infuse && ! test -e /etc/infuse/infused.toml && ! test -e /run/infuse'
hush
((failures == 0)) || journalctl -u infused -o short-monotonic --no-pager | tail -n 60
finish
