"""infuse.Replay: the reports of a drive, as infused makes them."""

import json
import os
import shutil
import subprocess
import tempfile


class Replay:
    """Iterator over the reports of a replayed drive: dicts, as the daemon's protocol has them.

    It runs `infused --replay`, so that the lines are the daemon's, byte for byte. drive: a drive or a capture. config:
    path of a configuration. program: infused, if it is not found on the path. `lines` are the reports as bytes.
    Error: infused fails; the sentence is its own.
    """

    def __init__(self, drive, *, config=None, program="infused"):
        from . import Error
        if shutil.which(program) is None:
            raise Error(f"{program}: not found; install the package infused")
        with tempfile.TemporaryDirectory(prefix="infuse-") as folder:
            reports = os.path.join(folder, "reports.jsonl")
            command = [program, "--replay", os.fspath(drive), "--reports", reports,
                       "--socket", os.path.join(folder, "infused.sock")]
            if config is not None:
                command += ["--config", os.fspath(config)]
            ran = subprocess.run(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, check=False)
            if ran.returncode != 0:
                said = ran.stderr.decode(errors="replace").strip().splitlines()
                raise Error(said[-1] if said else f"{program} ended with status {ran.returncode}")
            with open(reports, "rb") as file:
                self.lines = file.read().splitlines()

    def __iter__(self):
        return (json.loads(line) for line in self.lines)

    def __len__(self):
        return len(self.lines)
