//! Would a fast Fourier transform in azimuth pay in the product of many bands? A pair of circles ±z of the quadrature:
//! the product of two trigonometric polynomials of degree n − 1, orders below n kept, by direct sums (eight pairs side
//! by side, as the library does it) and by rustfft (both factors of a circle in one transform, both circles' products
//! in one transform back); and the whole product over its pairs, for scale.
//!
//! Run with: cargo bench -p haarmonic-benches --bench sh_azimuth. Nanoseconds a pair of circles.

use std::hint::black_box;

use haarmonic::sh::Product;
use haarmonic_benches::{Jobs, numbers};
use rustfft::{FftPlanner, num_complex::Complex};

const LANES: usize = 8;

/// Cosines and sines of the orders of a factor on a circle, LANES circles side by side.
type Orders = Vec<[[f32; LANES]; 2]>;

fn orders(n: usize) -> Orders {
    let x = numbers(2 * n * LANES);
    x.chunks_exact(2 * LANES).map(|x| [0, LANES].map(|at| std::array::from_fn(|i| x[at + i]))).collect()
}

/// sum += a b, of a and b conjugated if `signs` says −1.
#[inline(always)]
fn add(sum: &mut [[f32; LANES]; 2], a: &[[f32; LANES]; 2], b: &[[f32; LANES]; 2], signs: [f32; 2]) {
    for i in 0..LANES {
        let (x, y) = ([a[0][i], signs[0] * a[1][i]], [b[0][i], signs[1] * b[1][i]]);
        sum[0][i] += x[0] * y[0] - x[1] * y[1];
        sum[1][i] += x[0] * y[1] + x[1] * y[0];
    }
}

struct Direct<'a> {
    a: &'a Orders,
    b: &'a Orders,
    out: &'a mut Orders,
}

impl pulp::WithSimd for Direct<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) {
        let (a, b, n) = (self.a, self.b, self.a.len());
        for (m, out) in self.out.iter_mut().enumerate() {
            let mut sum = [[0.0; LANES]; 2];
            for (a, b) in a[..=m].iter().zip(b[..=m].iter().rev()) {
                add(&mut sum, a, b, [1.0, 1.0]);
            }
            // Orders above m meet negative ones.
            for (a, b) in a[m + 1..].iter().zip(&b[1..n - m]) {
                add(&mut sum, a, b, [1.0, -1.0]);
            }
            for (a, b) in a[1..n - m].iter().zip(&b[m + 1..]) {
                add(&mut sum, a, b, [-1.0, 1.0]);
            }
            *out = sum;
        }
    }
}

/// The next length that is a product of 2, 3 and 5.
fn smooth(least: usize) -> usize {
    let rough = |mut n: usize| {
        for p in [2, 3, 5] {
            while n % p == 0 {
                n /= p;
            }
        }
        n
    };
    (least..).find(|&n| rough(n) == 1).expect("there are many")
}

fn main() {
    let mut jobs = Jobs::default();
    for n in [16, 32, 64, 128] {
        let (a, b, mut out) = (orders(n), orders(n), orders(n));
        let arch = pulp::Arch::new();
        jobs.add(format!("direct {n}"), LANES / 2, move || {
            arch.dispatch(Direct { a: black_box(&a), b: &b, out: black_box(&mut out) });
        });
        let length = smooth(3 * n - 2);
        let mut planner = FftPlanner::<f32>::new();
        let (there, back) = (planner.plan_fft_inverse(length), planner.plan_fft_forward(length));
        let zero = Complex::new(0.0f32, 0.0);
        let (x, mut scratch) = (numbers(4 * n), vec![zero; there.get_inplace_scratch_len()]);
        let (mut circles, mut both, mut kept) =
            ([vec![zero; length], vec![zero; length]], vec![zero; length], vec![zero; 2 * n]);
        jobs.add(format!("fft of {length}, {n}"), 1, move || {
            for circle in &mut circles {
                // a + i b: α_m + i β_m at m, conj(α_m) + i conj(β_m) at −m.
                circle.fill(zero);
                for m in 0..n {
                    let (a, b) = (Complex::new(x[4 * m], x[4 * m + 1]), Complex::new(x[4 * m + 2], x[4 * m + 3]));
                    circle[(length - m) % length] = a.conj() + Complex::new(b.im, b.re);
                    circle[m] = a + Complex::new(-b.im, b.re);
                }
                there.process_with_scratch(circle, &mut scratch);
            }
            for ((both, up), down) in both.iter_mut().zip(&circles[0]).zip(&circles[1]) {
                *both = Complex::new(up.re * up.im, down.re * down.im);
            }
            back.process_with_scratch(&mut both, &mut scratch);
            for m in 0..n {
                let (p, q) = (both[m], both[(length - m) % length].conj());
                (kept[2 * m], kept[2 * m + 1]) = (p + q, p - q);
            }
            black_box(&mut kept);
        });
        let product = Product::<f32>::new(n, n, n).expect("bands in range");
        let (a, b, mut out) = (numbers(n * n), numbers(n * n), numbers(n * n));
        let pairs = (3 * (n - 1) / 2 + 1).div_ceil(2);
        jobs.add(format!("whole product, one vector {n}"), pairs, move || {
            product.apply(black_box(&a), &b, black_box(&mut out));
        });
    }
    jobs.run();
}
