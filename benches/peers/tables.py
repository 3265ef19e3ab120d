#!/usr/bin/env python3
"""The peers of `cargo bench --bench table` that are not Rust: OpenCV's summed-area tables and exact distance transform.

Prints ns a pixel, the least and the median of many rounds. Needs numpy and opencv-python-headless. The maps are made as the bench makes
them. Tables are written to memory that is there already, as ours are. With TABLE (the bench's executable) as argument, runs that and
OpenCV's tables alternately, each pinned to one core, and prints the ratio of least times.

numpy asks the kernel for huge pages, which the bench's memory does not get where they are for those that ask: set
NUMPY_MADVISE_HUGEPAGE=0 to compare like with like at 4096².
"""

import os
import re
import subprocess
import sys
import time

import cv2
import numpy as np

MASK = (1 << 64) - 1


class Numbers:
    """The bench's generator of numbers in [0, 1)."""

    def __init__(self):
        self.state = 1

    def next(self):
        self.state = (self.state * 6364136223846793005 + 1442695040888963407) & MASK
        return (self.state >> 11) / (1 << 53)


def blobs(n, numbers):
    y, x = np.mgrid[0:n, 0:n]
    inside = np.zeros((n, n), bool)
    for _ in range(12):
        u, v, r = numbers.next() * n, numbers.next() * n, (0.04 + 0.12 * numbers.next()) * n
        inside |= np.hypot(x - u, y - v) < r
    return inside.astype(np.uint8)


def times(work, pixels, seconds=1.5):
    """The least and the median."""
    found, until, calls = [], time.perf_counter() + seconds, max(1, (1 << 20) // pixels)
    while time.perf_counter() < until:
        start = time.perf_counter_ns()
        for _ in range(calls):
            work()
        found.append((time.perf_counter_ns() - start) / calls / pixels)
    return min(found), float(np.median(found))


def best(work, pixels):
    return times(work, pixels)[0]


def summed_area():
    """(table type, side): (least, median)."""
    random, found = np.random.default_rng(1), {}
    for n in (256, 1024, 4096):
        image = random.random((n, n), dtype=np.float32)
        for name, depth in (("f32", cv2.CV_32F), ("f64", cv2.CV_64F)):
            out = cv2.integral(image, sdepth=depth)
            found[name, n] = times(lambda: cv2.integral(image, out, sdepth=depth), n * n)
    return found


def alternately(program, rounds=5):
    """Both in turn; the least of the rounds' least times and the median of their medians."""
    os.sched_setaffinity(0, {1})
    pattern = re.compile(r"^summed area f32 (\w+) (\d+)\s+least\s+([\d.]+) ns, median\s+([\d.]+)")
    pairs = {}
    for _ in range(rounds):
        theirs = summed_area()
        for name, n in theirs:
            # A size at a time, as OpenCV has it: others in turn would throw its image out of the cache.
            command = [program, "summed", f"f32 {name}", str(n)]
            m = pattern.match(subprocess.run(command, capture_output=True, text=True, check=True).stdout)
            pairs.setdefault((name, n), []).append(((float(m[3]), float(m[4])), theirs[name, n]))
    for (name, n), found in pairs.items():
        least = [min(round[side][0] for round in found) for side in (0, 1)]
        median = [float(np.median([round[side][1] for round in found])) for side in (0, 1)]
        print(
            f"summed area f32 -> {name} {n:5}: least {least[0]:.3f} against {least[1]:.3f} ({least[0] / least[1]:.2f}), "
            f"median {median[0]:.3f} against {median[1]:.3f}"
        )


def main():
    cv2.setNumThreads(1)
    if len(sys.argv) > 1:
        return alternately(sys.argv[1])
    for (name, n), (least, median) in summed_area().items():
        print(f"summed area f32 -> {name} {n}: least {least:.3f} ns, median {median:.3f}")
    random = np.random.default_rng(1)
    for n in (32, 64, 256, 1024):
        maps = {"blobs": blobs(n, Numbers()), "noise": (random.random((n, n)) < 0.5).astype(np.uint8)}
        for name, image in maps.items():
            other = 1 - image

            # Two transforms make a signed one; between centres, so off by a half on both sides.
            def both():
                cv2.distanceTransform(image, cv2.DIST_L2, cv2.DIST_MASK_PRECISE)
                cv2.distanceTransform(other, cv2.DIST_L2, cv2.DIST_MASK_PRECISE)

            one = best(lambda: cv2.distanceTransform(image, cv2.DIST_L2, cv2.DIST_MASK_PRECISE), n * n)
            print(f"distance {name} {n}: {one:.2f} ns one-sided, {best(both, n * n):.2f} signed")


if __name__ == "__main__":
    main()
