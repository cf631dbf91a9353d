"""infuse.results: what the commands of infuse print with --json, checked by its JSON Schema, with arrays."""

import json as _json
import os as _os
import subprocess as _subprocess

import numpy as _np

_FOLDER = _os.path.join(_os.path.dirname(__file__), "schemas")
_SUFFIX = ".schema.json"
_TYPES = {"object": dict, "array": list, "string": str, "boolean": bool, "integer": int, "number": (int, float)}

__all__ = ["names", "read", "run", "schema"]


def names():
    """Names of the results: "calibrate", "map-locate" of `infuse map locate`, "replay" of `infused --replay`, ..."""
    return sorted(name[:-len(_SUFFIX)] for name in _os.listdir(_FOLDER) if name.endswith(_SUFFIX))


def schema(name):
    """The JSON Schema (draft 7) of a result, a dict: what each key means, and its unit. ValueError: there is none."""
    if name not in names():
        raise ValueError(f"name: '{name}' is none of {', '.join(names())}")
    with open(_os.path.join(_FOLDER, name + _SUFFIX), encoding="utf-8") as file:
        return _json.load(file)


def read(name, text):
    """A result as a dict. text: what the command printed, str or bytes, or its path (os.PathLike).

    Poses and covariances are arrays, (4, 4) and (6, 6). Error: the text is not such a result, and where not.
    """
    from . import Error
    of = schema(name)
    if isinstance(text, _os.PathLike):
        with open(text, "rb") as file:
            text = file.read()
    if not isinstance(text, (str, bytes)):
        raise TypeError("text: not a str, bytes or a path")
    try:
        value = _json.loads(text)
    except ValueError as error:
        raise Error(f"{name}: no JSON: {error}") from error
    wrong = _wrong(value, of, of, name)
    if wrong:
        raise Error(wrong)
    return _with_arrays(value, of, of)


def run(command, *arguments, program="infuse"):
    """Runs a command with --json and reads its result, usable or not.

    run("calibrate", drive, "--scenes", 20). command: its words, "map locate". program: infuse, where it is not on the
    path.
    Error: the command fails, with its own sentence.
    """
    from . import Error
    if not isinstance(command, str):
        raise TypeError("command: not a str")
    words = command.split()
    name = "-".join(words)
    if name not in names() and words:
        name = words[0]  # infuse import kitti: every format has the same
    schema(name)
    line = [program, *words, *map(str, arguments), "--json"]
    try:
        ran = _subprocess.run(line, capture_output=True, check=False)
    except OSError as error:
        raise Error(f"{program}: {error.strerror}; install the package infuse") from error
    if not ran.stdout.lstrip().startswith(b"{"):
        said = ran.stderr.decode(errors="replace").strip().splitlines()
        raise Error(said[-1] if said else f"infuse {command} ended with status {ran.returncode}")
    return read(name, ran.stdout)


def _of(part, root):
    return root if part.get("$ref") == "#" else part


def _wrong(value, part, root, at):
    """What in a value is not as a part of a schema says, or nothing; for the keywords of the results' schemas."""
    part = _of(part, root)
    expected = _TYPES.get(part.get("type"), object)
    if not isinstance(value, expected) or (isinstance(value, bool) and expected is not bool and expected is not object):
        return f"{at}: not of type {part['type']}"
    if ("const" in part and value != part["const"]) or ("enum" in part and value not in part["enum"]):
        return f"{at}: '{value}' is not known"
    if "minimum" in part and not value >= part["minimum"]:
        return f"{at}: below {part['minimum']}"
    if isinstance(value, list):
        if not part.get("minItems", 0) <= len(value) <= part.get("maxItems", len(value)):
            return f"{at}: {len(value)} elements, not {part.get('minItems')}"
        if "items" in part:
            return next(filter(None, (_wrong(v, part["items"], root, f"{at}[{k}]") for k, v in enumerate(value))), None)
    if isinstance(value, dict):
        missing = [key for key in part.get("required", ()) if key not in value]
        if missing:
            return f"{at}: no '{missing[0]}'"
        if len(value) > part.get("maxProperties", len(value)):
            return f"{at}: too many keys"
        for key, inner in value.items():
            of = part.get("properties", {}).get(key, part.get("additionalProperties", {}))
            if of is False:
                return f"{at}: '{key}' is not known"
            if isinstance(of, dict) and (wrong := _wrong(inner, of, root, f"{at}.{key}")):
                return wrong
    if "oneOf" in part and sum(_wrong(value, one, root, at) is None for one in part["oneOf"]) != 1:
        return f"{at}: keys of different kinds of result"
    return None


def _shape(part):
    """(4, 4) or (6, 6) of a pose or covariance, by row or by rows; nothing for other arrays."""
    size = part.get("maxItems")
    items = part.get("items", {})
    if items.get("type") == "number" and size in (16, 36):
        return (4, 4) if size == 16 else (6, 6)
    return (6, 6) if size == 6 and items.get("maxItems") == 6 else None


def _with_arrays(value, part, root):
    part = _of(part, root)
    if isinstance(value, list):
        if shape := _shape(part):
            return _np.array(value, dtype=float).reshape(shape)
        return [_with_arrays(v, part.get("items", {}), root) for v in value]
    if isinstance(value, dict):
        inner, other = part.get("properties", {}), part.get("additionalProperties")
        return {key: _with_arrays(v, inner.get(key, other if isinstance(other, dict) else {}), root)
                for key, v in value.items()}
    return value
