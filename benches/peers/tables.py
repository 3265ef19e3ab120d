#!/usr/bin/env python3
"""The peers of `cargo bench --bench table` that are not Rust: OpenCV's summed-area tables and exact distance transform.

Prints ns a pixel, the best of many rounds. Needs numpy and opencv-python-headless. The maps are made as the bench makes them.
"""

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


def best(work, pixels):
    least, until = np.inf, time.perf_counter() + 1.5
    while time.perf_counter() < until:
        start = time.process_time_ns()
        for _ in range(max(1, (1 << 20) // pixels)):
            work()
        least = min(least, (time.process_time_ns() - start) / max(1, (1 << 20) // pixels) / pixels)
    return least


def main():
    cv2.setNumThreads(1)
    random = np.random.default_rng(1)
    for n in (256, 1024, 4096):
        image = random.random((n, n), dtype=np.float32)
        for name, depth in (("f32", cv2.CV_32F), ("f64", cv2.CV_64F)):
            out = cv2.integral(image, sdepth=depth)
            print(f"summed area f32 -> {name} {n}: {best(lambda: cv2.integral(image, out, sdepth=depth), n * n):.3f} ns")
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
