#!/usr/bin/python3
"""Breaks the sources at random, one place at a time, and prints which breaks no test notices.

    scripts/break_code.py --work FOLDER [--number 150] [--seed 1] [--folders physics,runtime]
    scripts/break_code.py --work FOLDER --tests --only 3,17

A test suite is worth what it notices. This script draws lines of the sources at random, breaks one
expression or statement of each, compiles all breaks into one build, each behind its number, and runs,
for every number, the tests that reach the place, quickest first, until one fails:

    compare     < becomes <=, == becomes !=, and so on; a loop's condition leaves out its last round
    logic       && becomes ||, a condition or a returned bool is negated
    arithmetic  + becomes -, * becomes /, and so on, of numbers
    literal     a number is doubled (0 becomes 1), true becomes false
    drop        a statement is left out

The work's folder keeps the copy of the sources, its build and all that was found; running again goes
on from there (delete it to draw anew). FOLDER/breaks.txt lists the breaks, FOLDER/verdicts.txt what
became of each:

    noticed     the test that failed, crashed or ran out of time
    SURVIVED    every test that reaches the place passed
    UNREACHED   no test reaches the place

A survivor is no proof of a missing test: a break may change nothing but speed, or nothing at all.
Judge each; where the break changes what a user sees, write the test, and judge the break again with
--tests, which takes the tests from the checkout. 150 breaks take an hour on two cores: ten minutes to
draw them, fifteen to build, four for all tests once, and half an hour for the breaks. Needs libclang for Python
(Debian: python3-clang-14). The method is mutation analysis with schemata (Untch, Offutt, Harrold 1993).
"""
import argparse
import concurrent.futures
import json
import mmap
import os
import pathlib
import random
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time

try:
    from clang import cindex
except ImportError:
    sys.exit("break_code.py: Python does not find libclang: install python3-clang-14, "
             "and run this script with Debian's own /usr/bin/python3")

root = pathlib.Path(__file__).resolve().parent.parent
FOLDERS = ["geometry", "physics", "graph", "nodes", "runtime", "render"]
FLAGS = ["-std=c++20", "-DBT_USE_DOUBLE_PRECISION", "-DFMT_SHARED", "-DHWY_SHARED_DEFINE",
         "-isystem", "/usr/include/eigen3", "-isystem", "/usr/include/bullet"]
MOST = 4096  # numbers that fit the record of what was reached

# Read once by every file of the build: number() is the break that is switched on, and the record of
# what was reached is a file shared by all processes, so that a killed one leaves its marks too.
SWITCH = """#pragma once
#include <cstdlib>
#include <fcntl.h>
#include <sys/mman.h>
namespace aspic_break {
inline int switched_on = 0;
inline char* reached = nullptr;
__attribute__((constructor(101))) inline void read_switch() {
    if (const char* text = std::getenv("ASPIC_BREAK")) switched_on = std::atoi(text);
    const char* const record = std::getenv("ASPIC_BREAK_REACHED");
    const int file = record ? ::open(record, O_RDWR) : -1;
    if (file < 0) return;
    void* const mapped = ::mmap(nullptr, %d, PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
    if (mapped != MAP_FAILED) reached = static_cast<char*>(mapped);
}
inline bool is(int number) {
    if (reached) reached[number] = 1;
    return number == switched_on;
}
}  // namespace aspic_break
""" % MOST

COMPARISONS = {"<": "<=", "<=": "<", ">": ">=", ">=": ">", "==": "!=", "!=": "=="}
LOGIC = {"&&": "||", "||": "&&"}
ARITHMETIC = {"+": "-", "-": "+", "*": "/", "/": "*", "%": "/"}
Kind = cindex.CursorKind
FUNCTIONS = {Kind.FUNCTION_DECL, Kind.CXX_METHOD, Kind.CONSTRUCTOR, Kind.DESTRUCTOR,
             Kind.CONVERSION_FUNCTION, Kind.FUNCTION_TEMPLATE, Kind.LAMBDA_EXPR}
STATEMENTS = {Kind.CALL_EXPR, Kind.BINARY_OPERATOR, Kind.COMPOUND_ASSIGNMENT_OPERATOR,
              Kind.UNARY_OPERATOR, Kind.UNEXPOSED_EXPR, Kind.CONTINUE_STMT}
NUMBERS = {cindex.TypeKind.INT, cindex.TypeKind.UINT, cindex.TypeKind.LONG, cindex.TypeKind.ULONG,
           cindex.TypeKind.LONGLONG, cindex.TypeKind.ULONGLONG, cindex.TypeKind.FLOAT,
           cindex.TypeKind.DOUBLE}
LITERALS_IN = {Kind.BINARY_OPERATOR, Kind.COMPOUND_ASSIGNMENT_OPERATOR, Kind.CALL_EXPR, Kind.RETURN_STMT,
               Kind.UNEXPOSED_EXPR, Kind.CONDITIONAL_OPERATOR, Kind.PAREN_EXPR, Kind.UNARY_OPERATOR,
               Kind.INIT_LIST_EXPR}


class Site:
    """One place that can be broken: text[start:end] becomes `broken` with @ for its number."""

    def __init__(self, start, end, kind, broken):
        self.start, self.end, self.kind, self.broken = start, end, kind, broken


def sites_of(path):
    """All sites of one file. A site lies in the body of a function that is not constexpr."""
    name = str(root / path)
    data = (root / path).read_bytes()
    unit = cindex.Index.create().parse(name, FLAGS + [f"-I{root}", f"-I{root}/build/release/generated"])
    found = []

    def text(start, end):
        return data[start:end].decode()

    def span(cursor):
        return cursor.extent.start.offset, cursor.extent.end.offset

    def binary(cursor, loop):
        parts = list(cursor.get_children())
        if len(parts) != 2:
            return
        (a, b), (c, d) = span(parts[0]), span(parts[1])
        between = re.sub(r"//[^\n]*|\s", "", text(b, c))
        left, right = text(a, b), text(c, d)
        whole = text(a, d)
        if between in COMPARISONS:
            other = f"{left} {COMPARISONS[between]} {right}"
            if loop:
                if between != "<":
                    return
                other = f"{left} + 1 < {right}"
            found.append(Site(a, d, "compare", f"(aspic_break::is(@) ? {other} : {whole})"))
        elif between in LOGIC and not loop:
            found.append(Site(a, d, "logic", f"(aspic_break::is(@) ? (({left}) {LOGIC[between]} ({right})) : ({whole}))"))
        elif between in ARITHMETIC and cursor.type.get_canonical().kind in NUMBERS:
            other = f"({left}) {ARITHMETIC[between]} ({right})"
            found.append(Site(a, d, "arithmetic", f"(aspic_break::is(@) ? ({other}) : ({whole}))"))

    def condition(cursor):
        a, b = span(cursor)
        found.append(Site(a, b, "logic", f"(aspic_break::is(@) != static_cast<bool>({text(a, b)}))"))

    def visit(cursor, parent, inside, loop):
        kind = cursor.kind
        if cursor.location.file is None or cursor.location.file.name != name:
            if kind != Kind.TRANSLATION_UNIT:
                return
        a, b = span(cursor)
        if kind in FUNCTIONS:
            head = text(a, b).split("{")[0]
            inside = not re.search(r"\b(constexpr|consteval)\b", head)
        elif kind == Kind.VAR_DECL and "constexpr" in text(a, b).split("=")[0]:
            return
        if inside:
            if kind == Kind.BINARY_OPERATOR:
                binary(cursor, loop)
            elif kind in (Kind.INTEGER_LITERAL, Kind.FLOATING_LITERAL, Kind.CXX_BOOL_LITERAL_EXPR):
                assigned = parent.kind == Kind.VAR_DECL and re.search(r"=\s*$", text(max(0, a - 8), a))
                of_template = text(b, b + 1) == ">"  # std::array<int, 8>()
                if (parent.kind in LITERALS_IN or assigned) and not of_template:
                    literal = text(a, b)
                    if re.fullmatch(r"true|false", literal):
                        other = "false" if literal == "true" else "true"
                        found.append(Site(a, b, "literal", f"(aspic_break::is(@) ? {other} : {literal})"))
                    elif re.fullmatch(r"[0-9.e+-]+f?u?", literal):
                        zero = not re.search(r"[1-9]", literal)
                        other = re.sub("0", "1", literal, count=1) if zero else f"2 * {literal}"
                        found.append(Site(a, b, "literal", f"(aspic_break::is(@) ? {other} : {literal})"))
            children = list(cursor.get_children())
            if kind == Kind.IF_STMT and children and re.fullmatch(
                    r"if\s*\(\s*", text(a, span(children[0])[0])):
                if children[0].kind.is_expression():
                    condition(children[0])
            if kind == Kind.RETURN_STMT and children:
                if children[0].type.get_canonical().kind == cindex.TypeKind.BOOL:
                    condition(children[0])
            if parent is not None and parent.kind == Kind.COMPOUND_STMT and kind in STATEMENTS:
                found.append(Site(a, b, "drop", f"if (!aspic_break::is(@)) {text(a, b)}"))
        children = list(cursor.get_children())
        for child in children:
            in_head = kind == Kind.FOR_STMT and child != children[-1] and child.kind == Kind.BINARY_OPERATOR
            visit(child, cursor, inside, in_head)

    visit(unit.cursor, None, False, False)
    return [(s.start, s.end, s.kind, s.broken) for s in found if s.end > s.start]


def line_of(data, offset):
    return data.count(b"\n", 0, offset) + 1


def draw(number, seed, folders):
    """Draws lines at random and of each a site; no two overlap. The breaks, numbered from 1."""
    listed = subprocess.run(["git", "ls-files", *folders], cwd=root, capture_output=True, text=True,
                            check=True).stdout.split()
    lines = []
    for path in listed:
        if re.search(r"\.(cpp|hpp)$", path):
            for at, line in enumerate((root / path).read_text().splitlines(), 1):
                if re.search(r"\w", line) and not re.match(r"\s*(//|#|namespace|using|\*)", line):
                    lines.append((path, at))
    chance = random.Random(seed)
    chance.shuffle(lines)
    breaks, known, at = [], {}, 0
    with concurrent.futures.ProcessPoolExecutor(os.cpu_count()) as pool:
        while len(breaks) < number and at < len(lines):
            batch = lines[at:at + 40]
            at += len(batch)
            unknown = sorted({path for path, _ in batch} - known.keys())
            known.update(zip(unknown, pool.map(sites_of, unknown)))
            for path, line in batch:
                data = (root / path).read_bytes()
                taken = [b for b in breaks if b["path"] == path]
                here = [s for s in known[path] if line_of(data, s[0]) == line
                        and all(s[1] <= b["start"] or b["end"] <= s[0] for b in taken)]
                if here and len(breaks) < number:
                    start, end, kind, broken = chance.choice(here)
                    breaks.append({"number": len(breaks) + 1, "path": path, "line": line, "kind": kind,
                                   "start": start, "end": end, "broken": broken,
                                   "was": data[start:end].decode()})
    return breaks


def write_if_other(path, data):
    """Leaves alone what is there already: whatever includes it would be compiled again."""
    if not path.exists() or path.read_bytes() != data:
        path.write_bytes(data)


def write_sources(work, breaks, dropped):
    """The copy of the sources, each file with its breaks compiled in."""
    write_if_other(work / "switch.hpp", SWITCH.encode())
    for path in sorted({b["path"] for b in breaks}):
        data = (root / path).read_bytes()
        for b in sorted((b for b in breaks if b["path"] == path), key=lambda b: -b["start"]):
            if b["number"] not in dropped:
                broken = b["broken"].replace("@", str(b["number"])).encode()
                data = data[:b["start"]] + broken + data[b["end"]:]
        write_if_other(work / "source" / path, data)


def build(work, breaks):
    """Compiles; breaks that do not compile are dropped, which the set returned says."""
    source, place = work / "source", work / "build"
    kept = work / "dropped.txt"
    dropped = set(map(int, kept.read_text().split())) if kept.exists() else set()
    flags = f"-w -Wno-narrowing -include {work}/switch.hpp"
    while True:
        write_sources(work, breaks, dropped)
        subprocess.run(["cmake", "-G", "Ninja", "-S", source, "-B", place, "-DCMAKE_BUILD_TYPE=Release",
                        "-DASPIC_UNITY=ON", f"-DCMAKE_CXX_FLAGS={flags}"], check=True, stdout=subprocess.DEVNULL)
        made = subprocess.run(["ninja", "-k", "0", "-C", place], capture_output=True, text=True)
        (work / "build.log").write_text(made.stdout + made.stderr)
        if made.returncode == 0:
            return dropped
        wrong = set()
        for path, line in re.findall(r"source/(\S+?):(\d+):\d+: error", made.stdout):
            wrong |= {b["number"] for b in breaks if b["path"] == path and b["line"] <= int(line)
                      <= b["line"] + b["broken"].count("\n")}
        if wrong <= dropped:
            sys.exit(f"break_code.py: the copy does not compile: see {work}/build.log")
        dropped |= wrong
        kept.write_text(" ".join(map(str, sorted(dropped))))


def run_test(test, place, limit, number=0, record=None):
    """Runs one test in a temporary folder of its own: what ended it ('' if it passed), and its seconds."""
    with tempfile.TemporaryDirectory(dir=place) as folder:
        env = dict(os.environ, TMPDIR=folder, XDG_CACHE_HOME=f"{folder}/cache", ASPIC_BREAK=str(number))
        if record:
            env["ASPIC_BREAK_REACHED"] = str(record)
        began = time.monotonic()
        process = subprocess.Popen(test["command"], cwd=test["folder"], env=env, start_new_session=True,
                                   stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
        try:
            output, _ = process.communicate(timeout=limit)
            end = "" if process.returncode == 0 else f"exit code {process.returncode}"
            if not end and b"[  SKIPPED ]" in output:
                end = "skipped"
        except subprocess.TimeoutExpired:
            end = "ran out of time"
        finally:
            try:
                os.killpg(process.pid, signal.SIGKILL)
            except ProcessLookupError:
                pass
            process.wait()
        return end, time.monotonic() - began


def reach(work, numbers):
    """Runs every test once without a break: its seconds, and the numbers of the places it reaches."""
    kept = work / "reached.json"
    if kept.exists():
        return json.loads(kept.read_text())
    listed = json.loads(subprocess.run(["ctest", "--test-dir", work / "build", "--show-only=json-v1"],
                                       capture_output=True, text=True, check=True).stdout)
    tests = []
    for t in listed["tests"]:
        properties = {p["name"]: p["value"] for p in t["properties"]}
        if t["command"][0].endswith("_tests"):  # not those that read the sources themselves
            tests.append({"name": t["name"], "command": t["command"],
                          "folder": properties["WORKING_DIRECTORY"]})

    def one(test):
        with tempfile.NamedTemporaryFile(dir=work) as record:
            record.truncate(MOST)
            end, seconds = run_test(test, work, 600, record=record.name)
            marks = pathlib.Path(record.name).read_bytes()
        return dict(test, end=end, seconds=seconds, reaches=[n for n in numbers if marks[n]])

    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        done = list(pool.map(one, tests))
    for test in done:
        if test["end"]:
            print(f"left out: {test['name']}: {test['end']} without a break", flush=True)
    done = [t for t in done if not t["end"]]
    kept.write_text(json.dumps(done))
    return done


def verdict(b, tests, work):
    """Runs the tests that reach one break, quickest first, until one fails twice."""
    reaching = sorted((t for t in tests if b["number"] in t["reaches"]), key=lambda t: t["seconds"])
    if not reaching:
        return "UNREACHED"
    for test in reaching:
        limit = 5 * test["seconds"] + 10
        end, _ = run_test(test, work, limit, b["number"])
        if end and run_test(test, work, limit, b["number"])[0]:
            return f"noticed    {test['name']}: {end}"
    return f"SURVIVED   {len(reaching)} tests"


def main():
    options = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    options.add_argument("--work", required=True, type=pathlib.Path, help="a folder for the copy and what is found")
    options.add_argument("--number", type=int, default=150, help="how many breaks (150)")
    options.add_argument("--seed", type=int, default=1, help="another seed draws other breaks (1)")
    options.add_argument("--folders", default=",".join(FOLDERS), help="of the sources, by commas (all)")
    options.add_argument("--tests", action="store_true", help="take the tests from the checkout again")
    options.add_argument("--only", help="numbers of breaks by commas: judged again")
    options = options.parse_args()
    work = options.work.resolve()
    if options.number >= MOST:
        sys.exit(f"break_code.py: expected fewer than {MOST} breaks, got {options.number}")

    listed = work / "breaks.json"
    if not listed.exists():
        work.mkdir(parents=True, exist_ok=True)
        archive = subprocess.Popen(["git", "archive", "HEAD"], cwd=root, stdout=subprocess.PIPE)
        shutil.rmtree(work / "source", ignore_errors=True)
        (work / "source").mkdir()
        subprocess.run(["tar", "-x", "-C", work / "source"], stdin=archive.stdout, check=True)
        breaks = draw(options.number, options.seed, options.folders.split(","))
        listed.write_text(json.dumps(breaks))
    breaks = json.loads(listed.read_text())
    if options.tests:
        for path in (p for p in (root / "tests").rglob("*") if p.is_file()):
            to = work / "source" / path.relative_to(root)
            to.parent.mkdir(parents=True, exist_ok=True)
            write_if_other(to, path.read_bytes())
        (work / "reached.json").unlink(missing_ok=True)
    (work / "breaks.txt").write_text("".join(
        f"{b['number']:4} {b['path']}:{b['line']} {b['kind']}: {' '.join(b['was'].split())}\n" for b in breaks))
    print(f"{len(breaks)} breaks: {work}/breaks.txt", flush=True)
    dropped = build(work, breaks)
    print(f"{len(dropped)} do not compile and are left out", flush=True)
    breaks = [b for b in breaks if b["number"] not in dropped]
    tests = reach(work, [b["number"] for b in breaks])
    print(f"{len(tests)} tests", flush=True)

    kept = work / "verdicts.txt"
    known = {}
    if kept.exists():
        for line in kept.read_text().splitlines():
            known[int(line.split()[0])] = line.split(None, 1)[1]
    again = set(map(int, options.only.split(","))) if options.only else set()
    waiting = [b for b in breaks if (b["number"] in again if again else b["number"] not in known)]
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        runs = {pool.submit(verdict, b, tests, work): b for b in waiting}
        for run in concurrent.futures.as_completed(runs):
            b = runs[run]
            known[b["number"]] = run.result()
            print(f"{b['number']:4} {known[b['number']]:60} {b['path']}:{b['line']}", flush=True)
            kept.write_text("".join(f"{n:4} {known[n]}\n" for n in sorted(known)))
    noticed = sum(v.startswith("noticed") for v in known.values())
    print(f"{noticed} of {len(known)} noticed")


if __name__ == "__main__":
    main()
