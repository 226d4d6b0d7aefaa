"""Plants the faults of tests/laws/faults in a copy of the tree, one by one: which law finds each?"""
import shutil
import subprocess
import sys

# Laws in the order in which they are asked, cheap ones first, with as many scenes as find what is coarse.
ASKED = ((8, 30), (6, 40), (3, 40), (17, 20), (11, 40), (7, 20), (4, 60), (9, 20), (2, 60), (5, 10), (1, 20), (10, 4),
         (15, 10), (18, 40))


def copy_tree(root, copy):
    """The files that git knows, as they are here. Files alike keep their time, so that little is built again."""
    listed = subprocess.run(["git", "ls-files", "-z"], cwd=root, capture_output=True, check=True).stdout
    for name in listed.decode().split("\0"):
        source, target = root / name, copy / name
        if not name or not source.is_file():
            continue
        if target.is_file() and target.read_bytes() == source.read_bytes():
            continue
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(source, target)


def build(copy):
    return subprocess.run([copy / "scripts/build", "release", "laws"], cwd=copy, check=False,
                          stdout=subprocess.DEVNULL).returncode == 0


def violations_of(copy):
    """Law by law: (law, what was violated, seed by seed), as they are found."""
    program = copy / "build/release/tests/laws"
    for law, scenes in ASKED:
        done = subprocess.run(["nice", program, "--law", str(law), "--seeds", f"1:{scenes + 1}"], cwd=copy,
                              capture_output=True, text=True, check=False)
        if done.returncode not in (0, 3):
            yield law, {0: (done.stderr.strip().splitlines() or [f"status {done.returncode}"])[-1]}
        lines = [line for line in done.stdout.splitlines() if " violated, seed" in line]
        yield law, {int(line.split("seed ")[1].split(":")[0]): line for line in lines}


def finder_of(copy, before):
    """The first law that is violated in a scene where it was not before, and its line."""
    for law, violated in violations_of(copy):
        for seed, line in violated.items():
            if seed not in before[law]:
                return law, line
    return None, "no law found it"


def try_fault(copy, patch, before):
    changed = subprocess.run(["patch", "-p1", "--no-backup-if-mismatch", "--input", patch], cwd=copy,
                             capture_output=True, text=True, check=False)
    try:
        if changed.returncode:
            return None, f"the patch does not apply: {changed.stdout.strip().splitlines()[-1]}"
        if not build(copy):
            return None, "does not build"
        return finder_of(copy, before)
    finally:
        subprocess.run(["patch", "-p1", "-R", "--no-backup-if-mismatch", "--input", patch], cwd=copy,
                       capture_output=True, check=False)


def run(root, out):
    copy = (out / "faults").resolve()
    copy.mkdir(parents=True, exist_ok=True)
    copy_tree(root, copy)
    if not build(copy):
        print("laws: the tree does not build", file=sys.stderr)
        return 2
    before = dict(violations_of(copy))
    patches = sorted((root / "tests/laws/faults").glob("*.patch"))
    found = 0
    for patch in patches:
        law, line = try_fault(copy, patch, before)
        what = patch.read_text().splitlines()[0]
        found += law is not None
        print(f"{patch.stem}: {what} {'law ' + str(law) if law else 'NOT FOUND'}: {line}", flush=True)
    print(f"{found} passed, {len(patches) - found} failed")
    return 0 if 10 * found >= 9 * len(patches) else 1
