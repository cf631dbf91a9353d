"""infuse.client: asks a running infused over its socket. This file needs Python alone."""

import json
import socket

DEFAULT_SOCKET = "/run/infuse/infused.sock"


class ClientError(RuntimeError):
    """The daemon refused a request, or the connection ended; the sentence is the daemon's."""


class Client:
    """A connection to infused. path: its Unix socket. timeout: s to wait for a reply; None: for ever.

    Reports are dicts, as the daemon's JSON Schemas describe them (/usr/share/infuse/protocol). Use it in a `with`
    statement, or call close().
    """

    def __init__(self, path=DEFAULT_SOCKET, *, timeout=10.0):
        self._socket = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        self._socket.settimeout(timeout)
        try:
            self._socket.connect(str(path))
        except OSError as error:
            self._socket.close()
            raise ClientError(f"{path}: {error.strerror or error}; is infused running?") from error
        self._lines = self._socket.makefile("rb")
        self.version = self._read()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def close(self):
        """Ends the connection."""
        self._lines.close()
        self._socket.close()

    def status(self):
        """The last report of every class and device, as a list."""
        return self._request({"op": "poll"})

    def devices(self):
        """DEVICES: every sensor."""
        self._send({"op": "devices"})
        return self._reply()

    def watch(self, *classes):
        """Iterator over every report of these classes ("HEALTH", "ALERT", ...), or of all, as they come."""
        self._request({"op": "watch", **({"classes": list(classes)} if classes else {})})
        self._socket.settimeout(None)
        while True:
            try:
                yield self._read()
            except ClientError:
                return  # infused ended

    def recalibrate(self, device=None):
        """Starts a re-estimation of a camera, or of all. Owner only, as all that follow."""
        self._control("recalibrate", device)

    def apply(self, number=None, *, device=None, T_camera_lidar=None):
        """Uses the proposed calibration, the one of that number, or a given one: 4 x 4, or 16 numbers by row."""
        request = {}
        if number is not None:
            request["number"] = int(number)
        if T_camera_lidar is not None:
            rows = [row if hasattr(row, "__iter__") else [row] for row in T_camera_lidar]
            request["T_camera_lidar"] = [float(value) for row in rows for value in row]
        self._control("apply", device, **request)

    def rollback(self, device=None):
        """Uses the calibration before."""
        self._control("rollback", device)

    def freeze(self, on=True, *, device=None):
        """Disables automatic changes, or enables them again."""
        self._control("freeze", device, on=bool(on))

    def _control(self, op, device, **values):
        self._request({"op": op, **({} if device is None else {"device": device}), **values})

    def _request(self, request):
        """Sends a request; the reports before its ACK."""
        self._send(request)
        reports = []
        while (report := self._reply())["class"] != "ACK":
            reports.append(report)
        return reports

    def _send(self, request):
        try:
            self._socket.sendall(json.dumps(request).encode() + b"\n")
        except OSError as error:
            raise ClientError(f"infused ended the connection: {error.strerror or error}") from error

    def _reply(self):
        report = self._read()
        if report["class"] == "ERROR":
            raise ClientError(report["what"] + (f" ({report['hint']})" if "hint" in report else ""))
        return report

    def _read(self):
        try:
            line = self._lines.readline()
        except TimeoutError as error:
            raise ClientError("infused does not answer") from error
        except OSError as error:
            raise ClientError(f"infused ended the connection: {error.strerror or error}") from error
        if not line:
            raise ClientError("infused ended the connection")
        return json.loads(line)
