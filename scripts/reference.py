#!/usr/bin/env python3
"""Writes docs/reference/ from the program itself: every command, option, pipeline stage and attribute.

Commands and stages are what the binary prints (`gable help`, `gable stages`), attributes are the table in
src/sink/attributes.rs. With --check nothing is written: the exit status is 1 if a page is not what would be written, if
the documentation shows an option that does not exist, or if it does not explain an attribute.
"""

import argparse
import difflib
import os
import re
import subprocess
import sys
from dataclasses import dataclass, field
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
REFERENCE = ROOT / "docs" / "reference"
ATTRIBUTES = ROOT / "src" / "sink" / "attributes.rs"
# The page that explains the attributes at length.
OUTPUT = ROOT / "docs" / "output.md"
NOTE = "<!-- Written by scripts/reference.py; do not edit. -->"


@dataclass
class Option:
    """An option or argument: `-f, --footprints <FILE>`, its help in paragraphs, its values and its default."""

    spelling: str
    help: list[str] = field(default_factory=list)
    values: list[tuple[str, str]] = field(default_factory=list)
    default: str = ""

    @property
    def name(self):
        """The long name, `--footprints`; of an argument its spelling."""
        found = re.search(r"--[a-z0-9-]+", self.spelling)
        return found.group() if found else self.spelling


@dataclass
class Command:
    """A command with its options by group and with what follows them, as sections of lines."""

    name: str
    about: str
    usage: str
    groups: dict[str, list[Option]]
    sections: list[tuple[str, list[str]]]


class Program:
    """The binary that is asked."""

    def __init__(self, path):
        self.path = str(path)

    def says(self, *arguments):
        """What it prints, in lines that are not wrapped; nothing of this shell's settings gets in."""
        answer = subprocess.run(
            ["gable", *arguments],
            executable=self.path,
            env={"COLUMNS": "100000"},
            stdin=subprocess.DEVNULL,
            capture_output=True,
            encoding="utf-8",
        )
        if answer.returncode != 0:
            sys.exit(f"gable {' '.join(arguments)}: exit status {answer.returncode}: {answer.stderr.strip()}")
        return answer.stdout.splitlines()

    def commands(self):
        """Names and summaries of all commands but `help`."""
        lines = self.says("help")
        start = lines.index("Commands:") + 1
        rows = []
        for line in lines[start:]:
            if not line.strip():
                break
            name, summary = line.split(maxsplit=1)
            if name != "help":
                rows.append((name, summary))
        return rows

    def stages(self):
        """Stages by role: (heading, [(name, summary)])."""
        roles = []
        for line in self.says("stages"):
            if re.fullmatch(r"[A-Z][a-z]+:", line):
                roles.append((line[:-1], []))
            elif line.startswith("  ") and roles:
                roles[-1][1].append(tuple(line.split(maxsplit=1)))
        return roles


def read_command(name, lines):
    """The command whose help these lines are."""
    about = lines[0]
    usage = next(line for line in lines if line.startswith("Usage: ")).removeprefix("Usage: ")
    groups, sections, at = {}, [], None
    for line in lines[lines.index("Usage: " + usage) + 1 :]:
        heading = re.fullmatch(r"([A-Z][^:]*):", line)
        if heading:
            sections.append((heading.group(1), []))
        elif not line.startswith(" ") and line.strip():
            # Text between the sections.
            if not sections or sections[-1][0]:
                sections.append(("", []))
            sections[-1][1].append(line)
        elif sections:
            sections[-1][1].append(line)
    rest = []
    for heading, body in sections:
        if any(re.match(r" {2,6}(-|<|\[[A-Z])", line) for line in body) and heading not in ("Examples", "The output"):
            groups[heading] = read_options(body)
        else:
            rest.append((heading, body))
    return Command(name, about, usage, groups, rest)


def read_options(lines):
    """The options in one group. Short help stands beside an option, long help below it."""
    options = []
    for line in lines:
        start = re.match(r"( {2}| {6})((?:-|<|\[[A-Z]).*)", line)
        if start and not line.startswith(" " * 7):
            spelling, _, beside = start.group(2).partition("  ")
            options.append(Option(spelling))
            line = beside.strip()
        else:
            line = line.strip()
        if not line or line == "Possible values:":
            continue
        option = options[-1]
        default = re.search(r"\s*\[default: ([^\]]*)\]$", line)
        if default:
            option.default = default.group(1)
            line = line[: default.start()]
        names = re.search(r"\s*\[possible values: ([^\]]*)\]", line)
        if names:
            option.values += [(value, "") for value in names.group(1).split(", ")]
            line = line.replace(names.group(), "")
        value = re.match(r"- ([\w.-]+)(?::\s+(.*))?$", line)
        if value:
            option.values.append((value.group(1), value.group(2) or ""))
        elif line:
            option.help.append(line)
    return options


def text(words):
    """Plain text as Markdown: nothing but what stands between backticks has a meaning."""
    parts = words.split("`")
    if len(parts) % 2 == 0:
        parts = [words.replace("`", "\\`")]
    parts[0::2] = [re.sub(r"([*_<>|\[\]\\])", r"\\\1", part) for part in parts[0::2]]
    parts[1::2] = [part.replace("|", "\\|") for part in parts[1::2]]
    return "`".join(parts)


def cell(option):
    """What an option means, in one cell of a table."""
    pieces = [text(" ".join(option.help))]
    for value, meaning in option.values:
        pieces.append(f"• `{value}`: {text(meaning)}" if meaning else f"• `{value}`")
    return "<br>".join(piece for piece in pieces if piece)


def table(options, heading):
    """A table of options, each with an anchor of its name."""
    has_defaults = any(option.default for option in options)
    rows = [f"| {heading} | meaning | default |", "|---|---|---|"] if has_defaults else [f"| {heading} | meaning |", "|---|---|"]
    for option in options:
        anchor = option.name.lstrip("-").strip("<>[].").lower()
        default = option.default if " " in option.default or not option.default else f"`{option.default}`"
        spelling = option.spelling.replace("|", "\\|")
        row = f'| <a id="{anchor}"></a>`{spelling}` | {cell(option)} |'
        rows.append(f"{row} {default} |" if has_defaults else row)
    return rows


def paragraphs(lines):
    """Lines joined to paragraphs, which blank lines part."""
    joined = [[]]
    for line in lines:
        if line.strip():
            joined[-1].append(line.strip())
        elif joined[-1]:
            joined.append([])
    return [" ".join(paragraph) for paragraph in joined if paragraph]


def section(heading, lines):
    """A section that follows the options: examples, exit codes or text."""
    out = [f"## {heading}", ""] if heading else []
    if heading == "Examples":
        code = []
        for line in [*lines, ""]:
            if line.startswith("    "):
                code.append(line[4:])
                continue
            if code:
                out += ["```sh", *code, "```", ""]
                code = []
            if line.strip():
                out += [text(line.strip()), ""]
        return out
    if heading == "Exit codes":
        rows = []
        for line in lines:
            found = re.match(r"  (\d+)  (.*)", line)
            if found:
                rows.append([found.group(1), found.group(2)])
            elif line.strip():
                rows[-1][1] += " " + line.strip()
        return out + ["| code | meaning |", "|---|---|", *(f"| {code} | {text(words)} |" for code, words in rows), ""]
    for paragraph in paragraphs(lines):
        out += [text(paragraph), ""]
    return out


def command_page(command):
    """The page of a command."""
    out = [f"# gable {command.name}", "", NOTE, "", text(command.about) + ".", "", "```text", command.usage, "```", ""]
    for heading, options in command.groups.items():
        out += [f"## {heading.rstrip('.')}", ""]
        out += table(options, "argument" if heading == "Arguments" else "option") + [""]
    for heading, lines in command.sections:
        out += section(heading, lines)
    return "\n".join(out).rstrip() + "\n"


def stage_section(name, lines):
    """A stage with its options, from what `gable stages NAME` prints."""
    start = lines.index("Options:")
    out = [f"## {name}", ""]
    # The options are parted from what stands before them by an empty line.
    out += [text(line) for line in lines[2:start]]
    out += ["| option | kind | meaning | limits |", "|---|---|---|---|"]
    rows, tail = [], []
    for line in lines[start + 1 :]:
        option = re.match(r"  (\w+) ([A-Z]+.*)$", line)
        if tail or not line.startswith("  ") and line.strip():
            tail.append(line.strip())
        elif option:
            rows.append((option.group(1), option.group(2), [], []))
        elif line.strip():
            line = line.strip()
            if re.fullmatch(r"\[.*\]", line):
                rows[-1][3].append(line[1:-1])
            elif line.startswith("- ") or not rows[-1][2]:
                rows[-1][2].append(line)
            else:
                rows[-1][2][-1] += " " + line
    for option, kind, help, limits in rows:
        meaning = []
        for line in help:
            value = re.match(r"- ([\w.-]+)(?:: (.*))?$", line)
            if value:
                meaning.append(f"• `{value.group(1)}`" + (f": {text(value.group(2))}" if value.group(2) else ""))
            else:
                meaning.append(text(line))
        limits = "; ".join(text(limit) for limit in limits)
        out.append(f"| `{option}` | {kind.lower()} | {'<br>'.join(meaning)} | {limits} |")
    if tail:
        out += ["", text(" ".join(line for line in tail if line))]
    return out + [""]


def stages_page(program):
    """The page of all stages."""
    out = ["# Pipeline stages", "", NOTE, ""]
    out += ["What `gable stages` says. How pipelines work: [Run PDAL pipelines](../howto/pipelines.md).", ""]
    for role, stages in program.stages():
        out += [f"| {role.lower()} | |", "|---|---|"]
        out += [f"| [`{name}`](#{name.replace('.', '')}) | {text(summary)} |" for name, summary in stages] + [""]
    for _, stages in program.stages():
        for name, _ in stages:
            out += stage_section(name, program.says("stages", name))
    return "\n".join(out).rstrip() + "\n"


def attributes():
    """Name, unit and meaning of every attribute, from the table in the source."""
    literal = r'"((?:[^"\\]|\\.)*)"'
    source = ATTRIBUTES.read_text(encoding="utf-8")
    source = source[source.index("pub const ATTRIBUTES") :]
    rows = re.findall(rf"row\(\s*{literal},\s*{literal},\s*{literal}", source, re.DOTALL)
    if len(rows) != len(re.findall(r"\brow\(", source)):
        sys.exit(f"{ATTRIBUTES}: a row of the table of attributes is not understood")
    return [tuple(re.sub(r"\\\n\s*", "", part) for part in row) for row in rows]


def attributes_page():
    """The page of all attributes."""
    out = ["# Attributes", "", NOTE, ""]
    out += ["What gable says of a building, in the order in which it stands in the model. Attributes that do not apply are left"]
    out += ["out. `CRS` is the vertical unit of the coordinate reference system. [What comes out](../output.md#attributes) tells"]
    out += ["more of them, and of the attributes of surfaces.", "", "| attribute | unit | meaning |", "|---|---|---|"]
    out += [f"| `{name}` | {unit} | {text(meaning)} |" for name, unit, meaning in attributes()]
    return "\n".join(out) + "\n"


def index_page(commands):
    """The first page of the reference."""
    out = ["# Reference", "", NOTE, "", "Every option, stage and attribute, as the program itself tells them.", ""]
    out += ["| command | |", "|---|---|"]
    out += [f"| [`gable {name}`](commands/{name}.md) | {text(summary)} |" for name, summary in commands]
    out += ["", "- [Pipeline stages](stages.md): what `gable pipeline` can do, with the options of every stage"]
    out += ["- [Attributes](attributes.md): what gable says of every building"]
    return "\n".join(out) + "\n"


def shown_options(commands):
    """Options that the documentation shows behind a command that has none of that name."""
    known = {c.name: {o.name for group in c.groups.values() for o in group} for c in commands}
    faults = []
    for page in sorted([ROOT / "README.md", *(ROOT / "docs").rglob("*.md")]):
        for block in re.findall(r"```(?:sh|bash)\n(.*?)```", page.read_text(encoding="utf-8"), re.DOTALL):
            lines = block.replace("\\\n", " ").splitlines()
            for call in [call for line in lines for call in re.split(r"[|;]|&&", re.sub(r"'[^']*'|\"[^\"]*\"|#.*", "", line))]:
                words = call.split()
                if len(words) < 2 or words[0] != "gable" or words[1] not in known:
                    continue
                for word in words[2:]:
                    name = word.partition("=")[0]
                    # `--readers.las.filename=…` sets an option of a stage.
                    if name.startswith("--") and "." not in name and name not in known[words[1]]:
                        faults.append(f"{page.relative_to(ROOT)}: gable {words[1]} has no {name}")
    return faults


def unexplained():
    """Attributes that docs/output.md does not name."""
    page = OUTPUT.read_text(encoding="utf-8")
    return [f"{OUTPUT.relative_to(ROOT)} does not name {name}" for name, _, _ in attributes() if f"`{name}`" not in page]


def main():
    """See the head of this file."""
    target = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target"))
    parser = argparse.ArgumentParser(description="Write docs/reference/ from the program itself.")
    parser.add_argument("--check", action="store_true", help="write nothing, say what differs")
    parser.add_argument("--gable", type=Path, default=os.environ.get("GABLE") or target / "release" / "gable", help="the binary")
    arguments = parser.parse_args()
    if not Path(arguments.gable).is_file():
        sys.exit(f"{arguments.gable} is not there: cargo build --release")

    program = Program(Path(arguments.gable).resolve())
    commands = [read_command(name, program.says("help", name)) for name, _ in program.commands()]
    pages = {f"commands/{command.name}.md": command_page(command) for command in commands}
    pages |= {"stages.md": stages_page(program), "attributes.md": attributes_page()}
    pages["index.md"] = index_page(program.commands())
    there = {str(page.relative_to(REFERENCE)) for page in REFERENCE.rglob("*.md")}

    faults = []
    for name in sorted(there | set(pages)):
        path, new = REFERENCE / name, pages.get(name)
        old = path.read_text(encoding="utf-8") if name in there else None
        if new == old:
            continue
        if arguments.check:
            lines = difflib.unified_diff((old or "").splitlines(), (new or "").splitlines(), "is", "should be", lineterm="", n=0)
            faults.append("\n".join([f"docs/reference/{name} is not what the program says", *list(lines)[2:12]]))
        elif new is None:
            path.unlink()
            print(f"docs/reference/{name} removed")
        else:
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(new, encoding="utf-8")
            print(f"docs/reference/{name}")
    if faults:
        faults.append("python3 scripts/reference.py writes these pages anew")
    faults += shown_options(commands) + unexplained()
    if faults:
        sys.exit("\n".join(faults))
    options = sum(len(group) for command in commands for group in command.groups.values())
    print(f"reference: {len(commands)} commands with {options} options, {len(attributes())} attributes")


if __name__ == "__main__":
    main()
