"""The ledger's files: claims are read, checked, and written back with comments and order kept."""
import json
import math
import re
import tomllib

KEYS = {  # of an entry: type, whether it must be there
    'what': (str, True), 'unit': (str, True), 'figure': (float, False), 'bound': (str, True),
    'like': (str, False), 'command': (str, True), 'targets': (list, False), 'figure_at': (str, False), 'take': (str, False),
    'folders': (list, True), 'digests': (list, False), 'data': (str, True),
    'chosen_on': (str, True), 'published_on': (str, True),
    'commit': (str, False), 'date': (str, False), 'seconds': (float, False), 'machine': (str, False),
}
SHARED = ('command', 'targets', 'folders', 'data', 'chosen_on', 'published_on')  # of the entry that "like" names
TAKES = {
    'one': None, 'largest': max, 'smallest': min, 'sum': sum, 'count': len,
    'mean': lambda x: sum(x) / len(x), 'median': lambda x: sorted(x)[len(x) // 2],
}
NUMBER = r'[-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?'
BOUND = re.compile(rf'(<=|>=) ({NUMBER})|({NUMBER}) \.\. ({NUMBER})')


class Broken(Exception):
    """An entry or its command cannot be used; the text says which and what to do."""


class Claim:
    """One entry of one file: `id` is FILE.TABLE, `values` its keys."""

    def __init__(self, path, name, values):
        self.path, self.name, self.values = path, name, values
        self.id = f'{path.stem}.{name}'
        self.check()

    def __getitem__(self, key):
        return self.values.get(key)

    def fail(self, text):
        raise Broken(f'{self.path.name}: [{self.name}]: {text}')

    def check(self):
        for key, value in self.values.items():
            if key not in KEYS:
                self.fail(f'unknown key "{key}"; the keys are {", ".join(KEYS)}')
            kind = KEYS[key][0]
            if kind is float and isinstance(value, int) and not isinstance(value, bool):
                self.values[key] = value = float(value)
            if not isinstance(value, kind):
                self.fail(f'"{key}" must be a {"number" if kind is float else kind.__name__}')
            if kind is list and not all(isinstance(x, str) for x in value):
                self.fail(f'"{key}" must hold texts')
        for key, (_, required) in KEYS.items():
            if required and key not in self.values:
                self.fail(f'"{key}" is missing')
        if self['take'] not in (None, *TAKES):
            self.fail(f'"take" must be one of {", ".join(TAKES)}')
        if self['figure_at'] is None:
            if self['figure'] is not None:
                self.fail('"figure" without "figure_at": state where the command prints it')
            return
        if not BOUND.fullmatch(self['bound']):
            self.fail(f'"bound" is "{self["bound"]}"; write "<= X", ">= X" or "A .. B"')
        if not self['figure_at'].startswith('/'):
            try:
                groups = re.compile(self['figure_at']).groups
            except re.error as error:
                self.fail(f'"figure_at" is no regular expression: {error}')
            if groups != 1:
                self.fail('"figure_at" needs exactly one group, which is the number')

    def holds(self, figure):
        """Whether a figure is within the bound."""
        match = BOUND.fullmatch(self['bound'])
        if match[1]:
            limit = float(match[2])
            return figure <= limit if match[1] == '<=' else figure >= limit
        return float(match[3]) <= figure <= float(match[4])

    def figure_in(self, output):
        """The figure in what the command printed."""
        where, take = self['figure_at'], self['take'] or 'one'
        found = [at_pointer(output, where)] if where.startswith('/') else \
            [m[1] for m in re.finditer(where, output, re.MULTILINE)]
        if take == 'count':
            return float(len(found))
        if not found:
            self.fail(f'the command printed nothing that matches {where}')
        if take == 'one' and len(found) > 1:
            self.fail(f'{where} matches {len(found)} times; make it narrower, or say which with "take"')
        try:
            numbers = [float(str(x).replace('\u2212', '-')) for x in found]
        except ValueError as error:
            self.fail(f'{where} found no number: {error}')
        figure = numbers[0] if take == 'one' else float(TAKES[take](numbers))
        if not math.isfinite(figure):
            self.fail(f'the figure is {figure}')
        return figure


def at_pointer(output, pointer):
    """The value at a JSON pointer (RFC 6901) of the last line that is JSON, or of the whole output."""
    for text in (output, *reversed(output.strip().splitlines())):
        try:
            value = json.loads(text)
            break
        except ValueError:
            continue
    else:
        raise Broken(f'the command printed no JSON, and "figure_at" is the pointer {pointer}')
    for step in pointer.split('/')[1:]:
        step = step.replace('~1', '/').replace('~0', '~')
        try:
            value = value[int(step) if isinstance(value, list) else step]
        except (KeyError, IndexError, ValueError, TypeError):
            raise Broken(f'the JSON that the command printed has nothing at {pointer}') from None
    return value


def read(folder):
    """All claims of a folder's *.toml, in order."""
    claims = []
    for path in sorted(folder.glob('*.toml')):
        try:
            entries = tomllib.loads(path.read_text())
        except tomllib.TOMLDecodeError as error:
            raise Broken(f'{path.name}: {error}') from None
        claims += [Claim(path, name, with_shared(path, name, entries)) for name in entries]
    return claims


def with_shared(path, name, entries):
    """An entry's values with those of the entry that it is like."""
    values = entries[name]
    if not isinstance(values, dict):
        raise Broken(f'{path.name}: "{name}" is no table; write each claim as [name] with its keys below')
    like = values.get('like')
    if like is None:
        return values
    other = entries.get(like)
    if not isinstance(other, dict) or 'like' in other:
        raise Broken(f'{path.name}: [{name}]: "like" must name an entry of this file that is like no other')
    return {key: other[key] for key in SHARED if key in other} | values


def in_toml(value):
    if isinstance(value, float):
        return f'{value:.10g}'
    return json.dumps(value, ensure_ascii=False)  # of texts and lists of texts, as TOML has them


def write(claim, changes):
    """Replaces keys of the claim in its file, or adds them at the end of its table."""
    lines = claim.path.read_text().splitlines()
    begin = lines.index(f'[{claim.name}]') + 1
    end = next((i for i in range(begin, len(lines)) if lines[i].startswith('[')), len(lines))
    while end > begin and (not lines[end - 1].strip() or lines[end - 1].startswith('#')):
        end -= 1  # what stands before the next table belongs to that
    for key, value in changes.items():
        text = f'{key} = {in_toml(value)}'
        at = next((i for i in range(begin, end) if re.match(rf'{key}\s*=', lines[i])), None)
        if at is None:
            lines.insert(end, text)
            end += 1
        else:
            lines[at] = text
    claim.path.write_text('\n'.join(lines) + '\n')
