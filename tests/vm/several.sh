# In the guest: three lidars, one of them by multicast, two CAN buses, and a GNSS receiver on a serial line.
# Sourced by service.sh.
cat >/etc/infuse/infused.toml.d/test.toml <<'TOML'
[[lidar]]
name = "left"
model = "VLP-16"
sender = "10.77.0.1"
[[lidar]]
name = "right"
model = "VLP-16"
sender = "10.77.0.3"
[[lidar]]
name = "roof"
model = "VLP-16"
port = 2370
position_port = 2371
multicast = "239.77.0.1"
interface = "lidar0"
[[can]]
name = "bus"
interface = "vcan0"
dbc = "test.dbc"
[can.signals]
yaw_rate = "MOTION.YAW_RATE"
[[can]]
name = "second"
interface = "vcan1"
[gnss]
device = "/dev/receiver"
TOML
printf 'VERSION ""\nBO_ 256 MOTION: 8 X\n SG_ YAW_RATE : 0|16@1- (0.0001,0) [0|0] "rad/s" X\n' >/etc/infuse/test.dbc
# The second lidar has its own address and sends to a second address of this host; the third sends to a group.
lay_more_cable() {
  ip addr add 10.77.0.4/24 dev lidar0
  ip -n car addr add 10.77.0.3/24 dev car0
  ip -n car route add 10.77.0.4 dev car0 src 10.77.0.3
  ip -n car route add 239.77.0.1 dev car0 src 10.77.0.1
}
more=()
also_send() {
  setsid ip netns exec car bash -c "while /proof/infuse-send-capture /proof/street.pcap $*; do sleep 0.1; done" >/dev/null 2>&1 &
  more+=($!)
}
lay_more_cable
also_send --to 10.77.0.4
also_send --to 239.77.0.1 --port 2370
canplayer -l i -I /proof/can.log vcan1=vcan0 >/dev/null 2>&1 & second=$!
# Readable for the group dialout, as serial devices are.
plug_receiver() {
  /proof/vm-clients gnss-receiver /dev/receiver & receiver=$!
  within 2 test -c /dev/receiver
  chown root:dialout /dev/receiver && chmod 660 /dev/receiver
}
plug_receiver
systemctl restart infused.service
pid=$(systemctl show -P MainPID infused)
all_six() { well left right roof bus second gnss; }
check "three lidars, one of them by multicast, two buses and a GNSS receiver deliver" within 15 all_six
infuse status | sed 's/^/      /'
{ kill $receiver; wait $receiver; } 2>/dev/null
check "the receiver is unplugged: unavailable" within 5 sh -c 'infuse status | grep -qE "(ERROR|STALE) +gnss"'
plug_receiver
check "plugged in: it delivers, without a restart" within 8 well gnss
ip link set vcan1 down
check "one bus down: unavailable" within 5 sh -c 'infuse status | grep -q "vcan1: the interface is down"'
check "and the other delivers" well bus
ip link set vcan1 up
{ kill $second; wait $second; } 2>/dev/null
canplayer -l i -I /proof/can.log vcan1=vcan0 >/dev/null 2>&1 & second=$!
ip link del lidar0
check "the lidars' interface is deleted: ERROR or STALE" within 8 sh -c 'infuse status | grep -qE "(ERROR|STALE) +roof" && infuse status | grep -qE "(ERROR|STALE) +left"'
lay_cable; lay_more_cable
check "recreated: all deliver, the group too, without a restart" within 30 all_six || infuse status
check "by the same process" test "$pid" = "$(systemctl show -P MainPID infused)"
check "a recording of 2 s" infuse record -o several --for 2s
check "it has the frames of both buses and the packets of the group" sh -c "cd /var/lib/infuse/drives/several &&
  test \$(grep -c ' vcan0 ' can.log) -gt 10 && test \$(grep -c ' vcan1 ' can.log) -gt 20 && infuse inspect . | grep -q 2370"
{ for one in "${more[@]}"; do kill -- -"$one"; done; kill $second $receiver; wait $second $receiver "${more[@]}"; } 2>/dev/null
ip addr del 10.77.0.4/24 dev lidar0
rm -rf /var/lib/infuse/drives/several /etc/infuse/test.dbc
use_three_sensors
systemctl restart infused.service
check "with three sensors again: OK" within 8 all_ok
