"""The type stubs declare what the module has, and every public name has a docstring."""

import ast
import inspect
import os
import re
import unittest

import infuse
from common import SOURCES

STUBS = os.path.join(SOURCES, "packaging/python/infuse")


def public(names):
    return {name for name in names if not name.startswith("_")}


def names_of(module):
    return set(getattr(module, "__all__", public(dir(module))))


def declared(path):
    """(functions {name: arguments}, classes {name: {member: arguments or None}}) of a stub."""
    with open(path, encoding="utf-8") as file:
        tree = ast.parse(file.read())

    def arguments(node):
        several = [node.args.vararg] if node.args.vararg else []
        given = node.args.posonlyargs + node.args.args + several + node.args.kwonlyargs
        return [a.arg for a in given if a.arg != "self"]

    functions = {n.name: arguments(n) for n in tree.body if isinstance(n, ast.FunctionDef)}
    classes = {n.name: {m.name: arguments(m) for m in n.body if isinstance(m, ast.FunctionDef)}
               | {m.target.id: None for m in n.body if isinstance(m, ast.AnnAssign)}
               for n in tree.body if isinstance(n, ast.ClassDef)}
    return functions, classes


def actual_arguments(function):
    """Of pybind11's first line: "name(self: X, points: object, *, voxel_size: float = 0.25) -> Y"."""
    text = inspect.getdoc(function) or ""
    line = next((line for line in text.splitlines() if re.match(r"(\d+\. )?\w+\(", line)), "")
    return [name for name in re.findall(r"(\w+): [\w\[]", line.split(" -> ")[0]) if name not in ("self", "arg0")]


class Stubs(unittest.TestCase):
    def modules(self):
        for name in ("calibration", "dependence", "motion", "plot", "registration", "results", "streetmap",
                     "study"):
            yield name, getattr(infuse, name)

    def test_stubs_have_the_names_and_arguments_of_the_module(self):
        for name, module in [*self.modules(), ("__init__", infuse)]:
            functions, classes = declared(os.path.join(STUBS, name + ".pyi"))
            members = names_of(module)
            kinds = {member: getattr(module, member) for member in members}
            with self.subTest(module=name):
                self.assertEqual({m for m, v in kinds.items() if inspect.isclass(v)} - {"Replay"}, set(classes))
                self.assertEqual({m for m, v in kinds.items() if inspect.isroutine(v)}, set(functions))
            for function, arguments in functions.items():
                with self.subTest(function=f"{name}.{function}"):
                    actual = kinds[function]
                    self.assertEqual(list(inspect.signature(actual).parameters) if inspect.isfunction(actual)
                                     else actual_arguments(actual), arguments)
            for cls, stubbed in classes.items():
                if cls == "Error":
                    continue
                with self.subTest(cls=f"{name}.{cls}"):
                    inherited = public(m for base in kinds[cls].__mro__[1:] for m in vars(base))
                    self.assertEqual(public(vars(kinds[cls])) - inherited, public(stubbed))
                    if "__init__" in stubbed:
                        self.assertEqual(actual_arguments(kinds[cls].__init__), stubbed["__init__"])

    def test_public_names_are_documented(self):
        for name, module in [*self.modules(), ("infuse", infuse)]:
            for member in names_of(module):
                with self.subTest(name=f"{name}.{member}"):
                    self.assertTrue(inspect.getdoc(getattr(module, member)))


if __name__ == "__main__":
    unittest.main()
