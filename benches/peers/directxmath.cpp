// Nanoseconds a call of DirectXMath's spherical harmonics: product, rotation, turn about z, evaluation, dot product.
//
// One call after the other on 64 different inputs that stay in the cache; the least of 40 rounds. README.md says how to build it.

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <vector>

#include "DirectXSH.h"

namespace {

constexpr std::size_t INPUTS = 64;
constexpr std::size_t MOST = DirectX::XM_SH_MAXORDER * DirectX::XM_SH_MAXORDER;

float uniform() {
    static unsigned state = 1;
    state = state * 1664525u + 1013904223u;
    return static_cast<float>(state >> 8) / static_cast<float>(1 << 23) - 1.0f;
}

float sink = 0.0f;

/// The least time of a call, `call(v)` for the inputs v in turn.
template <typename Call>
void report(const char* what, std::size_t bands, Call call) {
    double least = 1e30;
    for (int round = 0; round < 40; round++) {
        constexpr int REPEATS = 100;
        const auto start = std::chrono::steady_clock::now();
        for (int repeat = 0; repeat < REPEATS; repeat++) {
            for (std::size_t v = 0; v < INPUTS; v++) {
                call(v);
            }
        }
        const std::chrono::duration<double, std::nano> time = std::chrono::steady_clock::now() - start;
        least = std::min(least, time.count() / (REPEATS * static_cast<double>(INPUTS)));
    }
    std::printf("%-10s bands %zu %8.1f ns\n", what, bands, least);
}

}  // namespace

int main() {
    using namespace DirectX;
    std::vector<float> a(INPUTS * MOST), b(INPUTS * MOST), out(INPUTS * MOST);
    std::generate(a.begin(), a.end(), uniform);
    std::generate(b.begin(), b.end(), uniform);
    std::vector<XMFLOAT4> directions(INPUTS);
    std::vector<XMFLOAT4X4> matrices(INPUTS);
    for (std::size_t v = 0; v < INPUTS; v++) {
        const XMVECTOR axis = XMVector3Normalize(XMVectorSet(uniform(), uniform(), uniform() + 1.5f, 0.0f));
        XMStoreFloat4(&directions[v], axis);
        XMStoreFloat4x4(&matrices[v], XMMatrixRotationAxis(axis, 3.0f * uniform()));
    }
    for (std::size_t n = 2; n <= 6; n++) {
        report("product", n, [&](std::size_t v) { XMSHMultiply(&out[v * MOST], n, &a[v * MOST], &b[v * MOST]); });
    }
    for (std::size_t n = 2; n <= 6; n++) {
        report("rotate", n, [&](std::size_t v) {
            XMSHRotate(&out[v * MOST], n, XMLoadFloat4x4(&matrices[v]), &a[v * MOST]);
        });
    }
    for (std::size_t n = 3; n <= 6; n++) {
        report("rotate_z", n, [&](std::size_t v) { XMSHRotateZ(&out[v * MOST], n, b[v], &a[v * MOST]); });
    }
    for (std::size_t n = 2; n <= 6; n++) {
        report("dot", n, [&](std::size_t v) { out[v] = XMSHDot(n, &a[v * MOST], &b[v * MOST]); });
    }
    for (std::size_t n = 2; n <= 6; n++) {
        report("eval", n, [&](std::size_t v) { XMSHEvalDirection(&out[v * MOST], n, XMLoadFloat4(&directions[v])); });
    }
    for (const float x : out) {
        sink += x;
    }
    return sink == 12345.0f;
}
