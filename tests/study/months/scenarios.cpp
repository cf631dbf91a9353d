#include "tests/study/months/scenarios.hpp"

namespace infuse::study {
namespace {

/// From a fault's first second without data, an alert of silence (3 s) comes at + 2; other
/// conditions are raised 2 s after they begin and cleared 3 s after their end, which for what is
/// counted is 9 s after the last event, since it counts over 10 s.
constexpr Scenario kScenarios[] = {
    {"nothing happens", "", "", 600, "alert-only", 0},

    // --- lidars: "top" takes any sender, "rear" has one configured ---
    {"a lidar is silent for ten seconds", "60-70 top silent", "top.silent 62 70", 150, "alert-only",
     1},
    {"the other lidar is silent", "60-70 rear silent", "rear.silent 62 70"},
    {"two seconds of silence are none", "60-62 top silent", ""},
    {"a lidar comes and goes: one recording",
     "60-65 top silent; 70-75 top silent; 80-85 top silent; 90-95 top silent; 100-105 top silent",
     "top.silent 62 65; top.silent 72 75; top.silent 82 85; top.silent 92 95; top.silent 102 105",
     150, "alert-only", 1},
    {"all lidars are silent", "60-75 top silent; 60-75 rear silent",
     "top.silent 62 75; rear.silent 62 75"},
    {"the port cannot be opened", "60-80 top closed", "top.unavailable 60 80; top.silent 62 80"},
    {"a lidar sends garbage", "60-90 top garbage",
     "top.silent 62 90; top.undecodable 66..68 97..99"},
    {"one packet in a hundred is lost", "60-120 top loss 0.01", "top.loss 62..64 129..133", 180},
    {"one packet in twenty thousand is lost", "60-120 top loss 0.00005", "", 180, "alert-only", 0,
     nullptr, false},
    {"one packet in five is lost", "60-120 top loss 0.2",
     "top.heavy_loss 62..65 127..132; top.loss * *", 180},
    {"the kernel drops packets", "60-120 rear kernel_loss 0.02", "rear.loss 62..64 129..133", 180},
    {"the kernel drops a third", "60-120 rear kernel_loss 0.33",
     "rear.heavy_loss 62..65 127..132; rear.loss * *", 180},
    {"a lidar stands still", "60-80 top stopped", "top.no_sweeps 62 83"},
    {"another device sends as the lidar does", "60-90 top spoofed",
     "top.two_senders 63..66 93..96"},
    {"another device sends to a lidar with a known sender", "60-90 rear spoofed",
     "rear.wrong_sender 62 101..103"},
    {"one forged packet", "60 top forged", "top.wrong_sender 62 73"},
    {"one forged packet to a lidar with a known sender", "60 rear forged",
     "rear.wrong_sender 62 73"},
    {"a forged packet while the lidar is off", "60-70 top silent; 65 top forged",
     "top.silent 62 70; top.sender_changed * *; top.wrong_sender * *", 200},
    {"a unit is exchanged for one with another address", "57-60 top silent; 60 top swapped",
     "top.silent 59 60; top.sender_changed 60 73"},
    {"a unit with a known sender is exchanged", "57-60 rear silent; 60 rear swapped",
     "rear.silent 59 -; rear.wrong_sender 62 -", 150, "alert-only", -1, nullptr, false},
    {"a lidar of another model", "60-100 top wrong_model", "top.wrong_model 62 111..113"},
    {"two sensors behind one address", "60-100 top two_sensors", "top.two_sensors 62 103"},
    {"the receive buffer is small", "60-100 top small_buffer", "top.receive_buffer 62 103"},
    {"sweeps are dropped", "60-70 top overload", "top.overload 62 81..83"},
    {"others send to the port", "60-90 top others", "top.wrong_sender 62 101..103"},
    {"odd azimuths, repeated and late packets",
     "60-90 top stray; 70-95 top duplicates; 80-100 rear late", ""},

    // --- the lidars' clocks ---
    {"the device's clock jumps by a second", "60 top jump 1", "top.clock 62..64 66..71"},
    {"the device's clock jumps by ten minutes back", "60 top jump -600", "top.clock 62..64 66..71",
     150, "alert-only", -1, nullptr, false},
    {"a lidar restarts and has lost GNSS", "60-75 top silent; 74 top unlocked",
     "top.silent 62 75; top.clock 77..79 81..86", 150, "alert-only", -1, nullptr, false},
    {"packets are delayed by up to some ten milliseconds", "60-180 top jitter 5", "", 240},

    // --- the wall clock of the computer, which no stamp depends on ---
    {"the wall clock steps an hour ahead", "60 host step 3600", "", 150, "alert-only", 0},
    {"the wall clock steps an hour back", "60 host step -3600", "", 150, "alert-only", 0},
    {"the wall clock steps again and again",
     "60 host step 0.2; 70 host step -0.4; 80 host step 5; 90 host step -4.8; 100 host step 86400; "
     "110 host step -86400",
     ""},

    // --- camera, bus, GNSS receiver ---
    {"a camera is silent", "60-80 front silent", "front.silent 62 80"},
    {"a camera is unplugged", "60-80 front closed", "front.unavailable 60 80; front.silent 62 80"},
    {"images are lost", "60-90 front lost 0.3", "front.loss 62 102"},
    {"images cannot be read", "60-80 front unreadable", "front.unreadable 62 92"},
    {"some images cannot be read", "60-80 front torn 0.1", "front.unreadable 62 92"},
    {"a camera's stamps go back", "60 front out_of_order", "front.out_of_order 60 73"},
    {"the bus is silent, GNSS carries the odometry", "60-80 bus silent", "bus.silent 62 80"},
    {"the interface of the bus is down", "60-80 bus down",
     "bus.unavailable 60 80; bus.silent 62 80"},
    {"the CAN controller is off", "60-80 bus bus_off", "bus.bus_off 60 80; bus.silent 62 80"},
    {"the CAN controller is error-passive", "60-80 bus error_passive", "bus.bus_errors 60 83"},
    {"the bus carries none of the signals", "60-90 bus unused", "bus.unused 71..72 93"},
    {"frames are damaged", "60-80 bus torn 0.2", "bus.unreadable 62 92"},
    {"frames are lost", "60-80 bus lost 0.2", "bus.loss 62 92"},
    {"GNSS is silent", "60-80 gnss silent", "gnss.silent 62 80"},
    {"the GNSS receiver is unplugged", "60-80 gnss closed",
     "gnss.unavailable 60 80; gnss.silent 62 80"},
    {"neither bus nor GNSS", "60-80 bus silent; 60-80 gnss silent",
     "bus.silent 62 80; gnss.silent 62 80; odometry.untrusted 62..65 82..85; "
     "odometry.not_deskewed 62..65 82..85"},
    {"GNSS states a wrong speed", "60-90 gnss fast 15", "odometry.contradiction 62..64 92..100"},
    {"GNSS states a wrong course", "60-90 gnss turned 1.5",
     "odometry.contradiction 62..64 91..100"},
    {"the wheels spin", "60-90 vehicle slip 0.4", "odometry.contradiction 62..64 92..100"},
    {"the supply of all sensors fails",
     "60-90 top silent; 60-90 rear silent; 60-90 front silent; 60-90 bus silent; 60-90 gnss silent",
     "top.silent 62 90; rear.silent 62 90; front.silent 62 90; bus.silent 62 90; gnss.silent 62 "
     "90; "
     "odometry.untrusted 62..65 92..95"},

    // --- the camera's calibration ---
    {"a camera is turned by half a degree", "60 front turned 0.01",
     "front.drift_suspected 62..90 *; front.drift_confirmed 70..120 -", 400, "alert-only", -1,
     "configured", false},
    {"a camera is moved by ten centimetres", "60 front slid 0.1",
     "front.drift_suspected 62..120 *; front.drift_confirmed 70..150 -", 400, "alert-only", -1,
     "configured", false},
    {"the owner applies the new calibration", "60 front turned 0.01; 250 owner apply",
     "front.drift_suspected 62..90 *; front.drift_confirmed 70..120 250..251; "
     "front.calibration_changed 250..251 262..275",
     400, "alert-only", -1, "true"},
    {"a drift within the limits is corrected", "60 front turned 0.01",
     "front.drift_suspected 62..90 *; front.drift_confirmed 70..120 90..200; "
     "front.calibration_changed 90..200 100..220",
     400, "apply-within", -1, "true"},
    {"a drift beyond the limits is proposed", "60 front turned 0.09",
     "front.drift_suspected 62..90 *; front.drift_confirmed 62..120 -", 400, "apply-within", -1,
     "configured", false},
    {"a wrong estimate is rolled back", "60 front turned 0.01; 60-200 front misled -0.03",
     "front.drift_suspected * *; front.drift_confirmed 70..120 *; front.drift_confirmed * *; "
     "front.calibration_changed 90..200 *; front.calibration_changed * *",
     500, "apply", -1, "true"},
    {"no estimate is clear", "60 front turned 0.01; 60-400 front unclear",
     "front.drift_suspected 62..90 *; front.drift_confirmed 70..120 *; "
     "front.calibration_unusable 120..300 -",
     400, "apply", -1, "configured", false},
    {"the lens is covered", "60-90 front black", "front.camera_fault 60 90"},
    {"the camera repeats an image", "60-90 front frozen", "front.camera_fault 60 90"},
    {"the lens is dirty", "60-90 front dirty", "front.camera_fault 60 90"},
    {"the camera's stamps are late", "60-200 front late 0.25",
     "front.camera_fault 62..100 200..360; front.drift_suspected * *; front.drift_confirmed * *",
     350, "alert-only", -1, "configured"},
    {"a frozen calibration is not changed", "50 owner freeze; 60 front turned 0.01",
     "front.drift_suspected 62..90 *; front.drift_confirmed 70..120 -", 400, "apply", -1,
     "configured", false},
    {"frozen, and no longer", "50 owner freeze; 60 front turned 0.01; 250 owner unfreeze",
     "front.drift_suspected 62..90 *; front.drift_confirmed 70..120 255..300; "
     "front.calibration_changed 255..300 265..330",
     400, "apply", -1, "true"},
    {"frozen over a restart", "50 owner freeze; 60 service restart; 90 front turned 0.01",
     "front.drift_suspected 90..120 *; front.drift_confirmed 100..150 -", 400, "apply", -1,
     "configured", false},
    {"there is nothing to apply", "60 owner apply", "owner.apply_refused 60 -"},
    {"there is nothing to roll back", "60 owner rollback", "owner.rollback_refused 60 -", 150,
     "alert-only", -1, nullptr, false},
    {"the owner rolls back", "60 front turned 0.01; 250 owner apply; 320 owner rollback",
     "front.drift_suspected * *; front.drift_confirmed 70..120 250..251; "
     "front.calibration_changed 250..251 262..275; front.drift_confirmed 325..400 -",
     450, "alert-only", -1, "configured", false},
    {"a new calibration is used after a restart",
     "60 front turned 0.01; 250 owner apply; 300 service restart",
     "front.drift_suspected 62..90 *; front.drift_confirmed 70..120 250..251; "
     "front.calibration_changed 250..251 262..275",
     450, "alert-only", -1, "true"},
    {"a new calibration is used after a crash",
     "60 front turned 0.01; 250 owner apply; 252 service crash",
     "front.drift_suspected 62..90 *; front.drift_confirmed 70..120 250..251; "
     "front.calibration_changed 250..251 -; infused.restarted 253 -",
     450, "alert-only", -1, "true"},
    {"the rig is configured anew",
     "60 front turned 0.01; 250 owner apply; 300 config rig; "
     "301 service restart",
     "front.drift_suspected * *; front.drift_confirmed 70..120 250..251; "
     "front.calibration_changed 250..251 262..275; front.drift_confirmed 312..380 -",
     400, "alert-only", -1, "kept", false},
    {"the saved calibrations are damaged",
     "60 front turned 0.01; 250 owner apply; 300 calibrations damaged; 301 service restart",
     "front.drift_suspected * *; front.drift_confirmed 70..120 250..251; "
     "front.calibration_changed 250..251 262..275; infused.saved_calibrations 302 -; "
     "front.drift_confirmed 312..380 -",
     400, "alert-only", -1, "configured", false},
    {"the saved calibrations are those of a newer release",
     "50 owner freeze; 55 owner unfreeze; 60 calibrations newer; 61 service restart",
     "infused.saved_calibrations 62 -", 150, "alert-only", -1, nullptr, false},
    {"the saved calibrations are those of an older release",
     "60 front turned 0.01; 250 owner apply; 300 calibrations older; 301 service restart",
     "front.drift_suspected 62..90 *; front.drift_confirmed 70..120 250..251; "
     "front.calibration_changed 250..251 262..275",
     450, "alert-only", -1, "true"},

    // --- the process and the computer ---
    {"a restart", "60 service restart", "", 150, "alert-only", 0},
    {"a crash", "60 service crash", "infused.restarted 61 -"},
    {"the watchdog ends a stuck process", "60 service watchdog", "infused.restarted 61 -"},
    {"five crashes in a row",
     "60 service crash; 63 service crash; 66 service crash; 69 service crash; 72 service crash",
     "infused.restarted 61 -; infused.restarted 64 -; infused.restarted 67 -; infused.restarted 70 "
     "-; infused.restarted 73 -"},
    {"a reboot", "60 host reboot 45", ""},
    {"a power cut", "60 host power_cut 45", "infused.restarted 105 -"},
    {"a reboot of a computer without a battery", "60 host clockless 30", ""},
    {"alerts are recorded although the clock is not set",
     "40-50 top silent; 60 host clockless 1000; 120-130 top silent; 160-170 rear silent",
     "top.silent 42 50; top.silent 122 130; rear.silent 162 170", 250, "alert-only", 3, nullptr,
     false},
    {"a crash while a sensor is silent", "60-90 top silent; 70 service crash",
     "top.silent 62 -; infused.restarted 71 -; top.silent 74 90"},
    {"a crash within a recording", "60-70 top silent; 66 service crash",
     "top.silent 62 -; infused.restarted 67 -", 150, "alert-only", -1},

    // --- the disk ---
    {"the disk is full for forty seconds", "60-100 disk full", "infused.state 60..70 100..110"},
    {"an alert while the disk is full", "60-100 disk full; 70-80 top silent",
     "infused.state 60..70 100..110; top.silent 72 80; infused.record 72..75 -", 150, "alert-only",
     -1, nullptr, false},
    {"recordings work again after a full disk",
     "60-100 disk full; 70-80 top silent; 120-130 rear silent",
     "infused.state 60..70 100..110; top.silent 72 80; infused.record 72..75 122; "
     "rear.silent 122 130"},
    {"nothing is applied on a full disk, and what is applied later is kept",
     "60 front turned 0.01; 240-280 disk full; 250 owner apply; 290 owner apply; 330 service "
     "restart",
     "front.drift_suspected 62..90 *; front.drift_confirmed 70..120 290..291; "
     "owner.apply_refused 250 -; front.calibration_changed 290..291 302..315; "
     "infused.state 240..250 280..290; front.drift_suspected * *",
     450, "alert-only", -1, "true", false},
    {"freezing on a full disk fails and changes nothing; later it is kept",
     "60-100 disk full; 70 owner freeze; 120 owner freeze; 150 service restart; "
     "170 front turned 0.01",
     "infused.state 60..70 100..110; owner.freeze_refused 70 -; front.drift_suspected * *; "
     "front.drift_confirmed 175..250 -",
     400, "apply", -1, "configured", false},
    {"the state directory is lost for a while", "60-100 disk missing",
     "infused.state 60..70 100..110"},
    {"the saved state is damaged", "60 state damaged; 61 service restart", ""},
    {"the saved state is that of a newer release", "60 state newer; 61 service crash",
     "infused.restarted * *"},
    {"a line of the history is cut", "60 history damaged; 61 service restart", ""},

    // --- configuration and owner ---
    {"a lost drop-in", "60 config dropin; 61 service restart", "infused.missing_sensors 62 -", 150,
     "alert-only", -1, nullptr, false},
    {"all sensors are lost from the configuration", "60 config empty; 61 service restart",
     "infused.missing_sensors 62 -; infused.no_sensors 62 -", 150, "alert-only", -1, nullptr,
     false},
    {"the owner records", "60 owner record 20", "", 150, "alert-only", 1, nullptr, false},
    {"the owner records twice at once, and stops",
     "60 owner record 60; 65 owner record; 80 owner stop", "owner.record_refused 65 -", 150,
     "alert-only", 1, nullptr, false},
    {"there is no recording to stop", "60 owner stop", "owner.stop_refused 60 -"},
    {"an alert within the owner's recording", "60 owner record 60; 70-80 top silent",
     "top.silent 72 80", 200, "alert-only", 1, nullptr, false},
};

}  // namespace

std::span<const Scenario> scenarios() { return kScenarios; }

}  // namespace infuse::study
