#!/usr/bin/env python3
"""The peer of `cargo bench --bench pca` that is not Rust: the same algorithm with numpy. Prints the best of ten rounds."""

import time

import numpy as np


def randomised(matrix, k, random):
    centred = matrix - matrix.mean(axis=0)
    omega = random.random((len(matrix), k + 10), dtype=np.float32) * 2 - 1
    q = np.linalg.qr(centred.T @ omega)[0]
    for _ in range(2):
        q = np.linalg.qr(centred.T @ (centred @ q))[0]
    y = centred @ q
    values, vectors = np.linalg.eigh(y.T @ y)
    return (q @ vectors[:, ::-1])[:, :k], values[::-1][:k] / len(matrix)


def exact(matrix, k):
    centred = matrix - matrix.mean(axis=0)
    return np.linalg.eigh(centred.T @ centred)[1][:, ::-1][:, :k]


def best(work):
    times = []
    for _ in range(10):
        start = time.perf_counter()
        work()
        times.append(time.perf_counter() - start)
    return min(times) * 1e3


def main():
    random = np.random.default_rng(1)
    matrix = random.random((10000, 1024), dtype=np.float32)
    print(f"randomised, k = 32: {best(lambda: randomised(matrix, 32, random)):.0f} ms")
    print(f"exact (f32): {best(lambda: exact(matrix, 32)):.0f} ms")


if __name__ == "__main__":
    main()
