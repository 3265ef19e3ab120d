"""Nanoseconds a point of sphericart's basis, one thread: least of many rounds.

Needs numpy and sphericart (2.0.4 was measured). Run: OMP_NUM_THREADS=1 python benches/peers/sphericart_basis.py
Its compute() allocates its result, a row for each point; the library's counterpart is Basis::eval_points.
"""

import time

import numpy as np
import sphericart


def points(count, dtype):
    z = 1 - (2 * np.arange(count) + 1) / count
    phi = np.arange(count) * (np.pi * (3 - np.sqrt(5)))
    across = np.sqrt(1 - z * z)
    return np.stack([across * np.cos(phi), across * np.sin(phi), z], axis=1).astype(dtype)


def least(work, seconds=0.5):
    work()
    best, end = float("inf"), time.perf_counter() + seconds
    while time.perf_counter() < end:
        start = time.perf_counter()
        work()
        best = min(best, time.perf_counter() - start)
    return best


def main():
    print("bands  scalar   points  ns/point")
    for bands in [3, 4, 6, 10, 21, 51]:
        basis = sphericart.SphericalHarmonics(bands - 1)
        for dtype in [np.float32, np.float64]:
            for count in [1000, 100_000]:
                if count * bands**2 > 4e7:
                    continue
                xyz = points(count, dtype)
                ns = least(lambda: basis.compute(xyz)) / count * 1e9
                print(f"{bands:5}  {np.dtype(dtype).name}  {count:6}  {ns:8.1f}")


if __name__ == "__main__":
    main()
