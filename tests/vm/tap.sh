# In the guest: a lidar whose datagrams are addressed to another host. Sourced by service.sh.
hush
rm -rf /etc/infuse/infused.toml.d && mkdir /etc/infuse/infused.toml.d
cat >/etc/infuse/infused.toml.d/tap.toml <<'TOML'
[[lidar]]
name = "top"
model = "VLP-16"
tap = true
interface = "lidar0"
[odometry]
use_lidar = false
TOML
# 10.77.0.9 is another host's address, its frames have another host's Ethernet address.
ip -n car neigh replace 10.77.0.9 lladdr 02:00:00:00:00:09 dev car0
setsid ip netns exec car bash -c 'while /proof/infuse-send-capture /proof/street.pcap --to 10.77.0.9; do :; done' >/tmp/sender.log 2>&1 & sender=$!
systemctl restart infused.service 2>/dev/null
check "a tap without the drop-in: the reason is in the journal" within 10 sh -c 'journalctl -u infused -o cat | grep -q "CAP_NET_RAW"'
install -D /usr/share/doc/infused/examples/tap.conf /etc/systemd/system/infused.service.d/tap.conf
systemctl daemon-reload && systemctl restart infused.service
check "with it, the tapped lidar delivers" within 20 well top
check "it runs without root" sh -c 'test "$(ps -o user= -p "$(systemctl show -P MainPID infused)")" = infuse'
check "with CAP_NET_RAW alone" sh -c 'grep -qi "^CapEff:\s*0*2000$" /proc/$(systemctl show -P MainPID infused)/status'
rm -r /etc/systemd/system/infused.service.d
systemctl daemon-reload
hush
use_three_sensors
rm /etc/infuse/infused.toml.d/tap.toml
send_lidar
play_bus
systemctl restart infused.service
check "all three deliver again" within 20 well top front bus
