"""infuse.results: every command with --json has a schema, and what it prints is read."""

import json
import os
import pathlib
import re
import subprocess
import unittest

import numpy as np

import common
import infuse
from common import program

INFUSE = program("infuse")
# They print reports of the daemon, whose schemas are in daemon/protocol.
REPORTS = {"calibration", "record", "status", "watch"}


def subcommands(words):
    """Every command below these words whose help has --json."""
    text = subprocess.run([INFUSE, *words, "--help"], capture_output=True, text=True, check=True).stdout
    if re.search(r"^ +--json", text, re.M):
        yield " ".join(words)
    below = text.partition("\nSubcommands:")[2].partition("\nExamples:")[0]  # Tools: is one of its parts
    for name in re.findall(r"^  ([a-z-]+)  ", below, re.M):
        yield from subcommands([*words, name])


class Results(common.OnAStreet):
    def at(self, name):
        return os.path.join(self.folder.name, name)

    def run_command(self, command, *arguments):
        return infuse.results.run(command, *arguments, program=INFUSE)

    def test_every_command_has_a_schema(self):
        commands = set(subcommands([])) - REPORTS
        self.assertGreater(len(commands), 15)
        named = {name if (name := c.replace(" ", "-")) in infuse.results.names() else c.split()[0] for c in commands}
        self.assertEqual(named, set(infuse.results.names()) - {"replay"})
        for name in infuse.results.names():
            self.assertEqual(infuse.results.schema(name)["title"], name)

    def test_a_calibration_has_arrays(self):
        found = self.run_command("calibrate", self.drive, "--scenes", 4, "--measure", "mi")
        self.assertEqual(found["T_camera_lidar"].shape, (4, 4))
        np.testing.assert_allclose(found["T_camera_lidar"][3], [0, 0, 0, 1])
        expected = infuse.calibration.calibrate(infuse.calibration.read_pairs([self.drive], max_scenes=4), measure="mi")
        np.testing.assert_allclose(found["T_camera_lidar"], expected.T_camera_lidar, atol=1e-12)
        self.assertEqual(found["usable"], expected.usable)

    def test_each_command_is_read(self):
        run = self.run_command
        self.assertGreater(run("odometry", self.drive, "-o", self.at("way.tum"))["length"], 1)
        self.assertGreater(run("evaluate", self.at("way.tum"), self.drive)["paired"], 10)
        self.assertEqual(run("inspect", self.drive)["odometry"]["usable"], True)
        bag = self.at("a.mcap")
        self.assertIn("/tf_static", run("export mcap", self.drive, "-o", bag)["topics"])
        self.assertGreater(run("import rosbag", bag, "--topic", "/vehicle/imu", "-o", self.at("again"))["images"], 10)
        config = pathlib.Path(self.at("infused.toml"))
        config.write_text("[health]\nstale_after_s = 5\n", encoding="utf-8")
        self.assertTrue(run("config check", config)["valid"])
        config.write_text("[health]\nstale = 5\n", encoding="utf-8")
        self.assertIn("unknown key", run("config check", config)["error"]["what"])
        lines = subprocess.run([program("infused"), "--replay", self.drive, "--socket", self.at("s"), "--json"],
                               capture_output=True, check=True).stdout.splitlines()
        self.assertGreater(infuse.results.read("replay", lines[-1])["sweeps"], 10)

    def test_what_is_no_result_is_refused(self):
        with self.assertRaisesRegex(infuse.Error, "nowhere"):
            self.run_command("inspect", "/nowhere")
        with self.assertRaisesRegex(infuse.Error, "no-program"):
            infuse.results.run("inspect", self.drive, program="no-program")
        with self.assertRaisesRegex(ValueError, "none of align"):
            infuse.results.run("telepathy")
        right = {"sweeps": 2, "returns": 3, "not_deskewed": 0}
        path = pathlib.Path(self.at("decode.json"))
        path.write_text(json.dumps(right), encoding="utf-8")
        self.assertEqual(infuse.results.read("decode", path), right)
        for wrong, said in (({"returns": -1}, "returns: below 0"), ({"sweeps": "2"}, "sweeps: not of type integer"),
                            ({"sweeps": True}, "sweeps: not of type integer"), ({"more": 1}, "'more' is not known")):
            with self.assertRaisesRegex(infuse.Error, said):
                infuse.results.read("decode", json.dumps({**right, **wrong}))
        for text in ("{}", "[]", "", "{"):
            with self.assertRaises(infuse.Error):
                infuse.results.read("decode", text)


if __name__ == "__main__":
    unittest.main()
