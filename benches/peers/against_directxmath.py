#!/usr/bin/env python3
"""Our single calls and batches against DirectXMath: both programs in turn, ROUNDS times, each pinned to one core.

Run: python benches/peers/against_directxmath.py SH DIRECTXMATH, the executables of `cargo bench --bench sh --no-run` and
of directxmath.cpp (README.md). Prints the median over the rounds of each one's least time, and of the ratio within a round.
"""

import re
import statistics
import subprocess
import sys

ROUNDS = 9
LINE = re.compile(r"^(?P<what>.*\S)\s+(?P<bands>\d+)\s+least\s+(?P<ns>[\d.]+) ns")
PEER = re.compile(r"^(?P<what>\w+)\s+bands (?P<bands>\d+)\s+(?P<ns>[\d.]+) ns")


def times(program, pattern):
    """Nanoseconds by (what, bands)."""
    text = subprocess.run(["taskset", "-c", "1", program], capture_output=True, text=True, check=True).stdout
    found = (pattern.match(line) for line in text.splitlines())
    return {(m["what"], int(m["bands"])): float(m["ns"]) for m in found if m}


def main():
    ours, peer = sys.argv[1:]
    rounds = [(times(ours, LINE), times(peer, PEER)) for _ in range(ROUNDS)]
    middle = statistics.median
    print(f"{'what':36} {'bands':>5} {'ns':>10} {'DirectXMath':>12} {'ratio':>6}")
    for what, bands in rounds[0][0]:
        ns = middle(mine[what, bands] for mine, _ in rounds)
        # What DirectXMath has for it, one vector at a time.
        name = {"a rotation each": "rotate"}.get(what, what.split(" ")[0])
        if name.startswith("square"):
            name = "product"
        if (name, bands) in rounds[0][1] and not what.startswith(("eval rows", "one rotation")):
            theirs = middle(peer[name, bands] for _, peer in rounds)
            ratio = middle(peer[name, bands] / mine[what, bands] for mine, peer in rounds)
            print(f"{what:36} {bands:5} {ns:10.2f} {theirs:12.2f} {ratio:6.2f}")
        else:
            print(f"{what:36} {bands:5} {ns:10.2f}")


if __name__ == "__main__":
    main()
