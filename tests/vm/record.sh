# In the guest: recordings of live sensors. Sourced by service.sh. The wheels turn: while they rest the lidar's sweeps are
# registered, which takes seconds on an emulated processor.
cat >/etc/infuse/test.dbc <<'DBC'
VERSION ""
BO_ 256 MOTION: 8 X
 SG_ YAW_RATE : 0|16@1- (0.0001,0) [0|0] "rad/s" X
BO_ 257 WHEELS: 8 X
 SG_ REAR_LEFT : 0|16@1+ (0.01,5) [0|0] "m/s" X
 SG_ REAR_RIGHT : 16|16@1+ (0.01,5) [0|0] "m/s" X
DBC
cat >/etc/infuse/rig.toml <<'TOML'
[[lidar]]
name = "top"
T_vehicle_lidar = [1, 0, 0, 0,  0, 1, 0, 0,  0, 0, 1, 1.8,  0, 0, 0, 1]
[[camera]]
name = "front"
width = 320
height = 240
fx = 300
fy = 300
cx = 160
cy = 120
lidar = "top"
T_camera_lidar = [0, -1, 0, 0,  0, 0, -1, 0,  1, 0, 0, -0.3,  0, 0, 0, 1]
TOML
cat >/etc/infuse/infused.toml.d/whole.toml <<'TOML'
rig = "rig.toml"
[[can]]
name = "bus"
dbc = "test.dbc"
[can.signals]
yaw_rate = "MOTION.YAW_RATE"
wheel_speed_rear_left = "WHEELS.REAR_LEFT"
wheel_speed_rear_right = "WHEELS.REAR_RIGHT"
[record]
min_free_mb = 0
max_size_mb = 500
flight_recorder_s = 5
memory_mb = 32
after_alert_s = 1
TOML
drives=/var/lib/infuse/drives
check "the configuration with a rig is valid" infused --check-config --config /etc/infuse/infused.toml
systemctl restart infused.service
within 10 infuse wait-ready --timeout 5
check "a recording of 4 s" infuse record -o whole --for 4s
infuse status | sed -n '/RECORD/s/^/        /p'
check "it has the lidar, the bus and the camera" sh -c "test \$(stat -c %s $drives/whole/lidar.pcap) -gt 1000000 &&
  test \$(grep -c ' vcan0 10[01]#' $drives/whole/can.log) -gt 40 && test \$(ls $drives/whole/camera_0 | grep -c png) -gt 20"
check "it is readable for the group, not for others" sh -c "test \$(stat -c %a $drives/whole) = 750 && test \$(stat -c %a $drives/whole/lidar.pcap) = 640"
check "it replays" sh -c "infused --replay $drives/whole --socket /tmp/replay.sock --json >/tmp/replay.json && grep -q '\"sweeps\":3[0-9]\|\"sweeps\":4' /tmp/replay.json"
grep -o '"\(packets\|sweeps\|packets_lost\)":[0-9]*' /tmp/replay.json | tr '\n' ' ' | sed 's/^/        /'; echo
check "a second recording of that name is refused" sh -c '! infuse record -o whole --for 1s'
# The flight recorder: an alert is recorded with the data before it.
ip link set vcan0 down
recorded() { journalctl -u infused -o cat | grep -q 'alert-.*bus_unavailable: .* s, .* MB'; }
check "an alert is recorded" within 15 recorded || journalctl -u infused -o short-monotonic --no-pager | tail -n 25
check "by the process that raised it" test "$(ls -d $drives/alert-*bus_unavailable | wc -l)" = 1
ip link set vcan0 up
hush_bus; play_bus
flight=$(ls -d $drives/alert-*bus_unavailable)
first=$(sed -n '1s/^(\([0-9]*\).*/\1/p' "$flight/can.log") last=$(sed -n '$s/^(\([0-9]*\).*/\1/p' "$flight/can.log")
check "with $((last - first)) s of CAN frames" test $((last - first)) -ge 2 || {
  ls -l "$flight"; sed -n '1p;$p' "$flight/can.log"; sed -n 1,20p "$flight/drive.toml"
  journalctl -u infused -o short-unix --no-pager | tail -n 25
}
check "and it replays" sh -c "infused --replay $flight --socket /tmp/replay.sock --json >/tmp/replay.json && grep -q '\"sweeps\":[1-9][0-9]' /tmp/replay.json"
mount -t tmpfs -o size=2m,uid=infuse,gid=infuse,mode=750 none $drives
systemctl restart infused.service  # it sees mounts made before its start only
within 10 infuse wait-ready --timeout 5
check "a full disk ends a recording" sh -c '! infuse record -o full --for 30s'
check "an alert is raised" within 3 alert "No space left"
check "the partial recording is a valid drive" infused --replay $drives/full --socket /tmp/replay.sock
systemctl stop infused.service
umount $drives
rm /etc/infuse/infused.toml.d/whole.toml /etc/infuse/rig.toml /etc/infuse/test.dbc
systemctl start infused.service
check "without the rig again: OK" within 8 all_ok
