//! Sums of reflectance × weights over directions.

use crate::scene::Kernel;

/// Directions and RGB weights, structure of arrays.
#[derive(Debug, Clone)]
pub(super) struct Samples {
    /// x, y, z, R, G, B.
    planes: [Vec<f32>; 6],
    len: usize,
}

/// Borrowed planes: x, y, z and R, G, B.
pub(super) type Planes<'a> = [&'a [f32]; 6];

/// Samples that a list holds before it is summed up.
const CAPACITY: usize = 1024;
const LANES: usize = 8;

impl Samples {
    pub(super) fn new() -> Self {
        // Directions of lanes past the end are summed with weight 0: any finite numbers do.
        Self { planes: [(); 6].map(|()| vec![0.0; CAPACITY + LANES]), len: 0 }
    }

    /// Whether `more` samples fit; if not, sum up first.
    #[inline(always)]
    pub(super) fn has_room(&self, more: usize) -> bool {
        self.len + more <= CAPACITY
    }

    /// Appends N samples.
    #[inline(always)]
    pub(super) fn push<const N: usize>(&mut self, from: [&[f32; N]; 6]) {
        for (plane, from) in self.planes.iter_mut().zip(from) {
            plane[self.len..self.len + N].copy_from_slice(from);
        }
        self.len += N;
    }

    /// Appends any number of samples that fit, their weights times `level`.
    #[inline(always)]
    pub(super) fn extend(&mut self, from: Planes<'_>, level: f32) {
        let n = from[0].len();
        for (k, (plane, from)) in self.planes.iter_mut().zip(from).enumerate() {
            let plane = &mut plane[self.len..self.len + n];
            if k < 3 {
                plane.iter_mut().zip(from).for_each(|(a, b)| *a = *b);
            } else {
                plane.iter_mut().zip(from).for_each(|(a, b)| *a = level * b);
            }
        }
        self.len += n;
    }

    /// Σ reflectance × weights of the list, which is empty then.
    #[inline(always)]
    pub(super) fn drain<const N: usize, K: Kernel<N>>(&mut self, kernel: K, normal: [f32; 3]) -> [f64; 3] {
        let len = self.len.next_multiple_of(LANES);
        for plane in &mut self.planes[3..] {
            plane[self.len..len].fill(0.0);
        }
        self.len = 0;
        sum(kernel, normal, self.planes.each_ref().map(|plane| &plane[..len]))
    }
}

/// Places whose reflectance is taken before it is summed: two loops over planes vectorise, one over both does not.
const STRIP: usize = 256;

/// Σ reflectance(d) × weight over planes of any length.
///
/// Eight running sums in `f32` over at most some hundred terms each, then `f64`.
#[inline(always)]
pub(super) fn sum<const N: usize, K: Kernel<N>>(kernel: K, normal: [f32; 3], planes: Planes<'_>) -> [f64; 3] {
    let mut total = [0.0; 3];
    let mut values = [[0.0_f32; STRIP]; N];
    let len = planes[0].len();
    for start in (0..len).step_by(STRIP) {
        let end = len.min(start + STRIP);
        let n = end - start;
        let [x, y, z, r, g, b] = planes.map(|plane| &plane[start..end]);
        reflect(kernel, normal, [x, y, z], values.each_mut().map(|values| &mut values[..n]));
        for (c, weights) in [r, g, b].into_iter().enumerate() {
            total[c] += dot(&values[c % N][..n], weights);
        }
    }
    total
}

/// Reflectance × cosine of every direction; 0 below the horizon unless it goes on smoothly.
#[inline(always)]
fn reflect<const N: usize, K: Kernel<N>>(
    kernel: K,
    normal: [f32; 3],
    [x, y, z]: [&[f32]; 3],
    mut out: [&mut [f32]; N],
) {
    let one = |d: [f32; 3]| {
        let cosine = normal[0] * d[0] + normal[1] * d[1] + normal[2] * d[2];
        let value = kernel.value(d, cosine);
        if K::SMOOTH { value } else { value.map(|v| if cosine > 0.0 { v } else { 0.0 }) }
    };
    if let [out] = &mut out[..] {
        for (((&x, &y), &z), out) in x.iter().zip(y).zip(z).zip(out.iter_mut()) {
            *out = one([x, y, z])[0];
        }
    } else {
        for (i, ((&x, &y), &z)) in x.iter().zip(y).zip(z).enumerate() {
            let value = one([x, y, z]);
            for c in 0..N {
                out[c][i] = value[c];
            }
        }
    }
}

#[inline(always)]
fn dot(a: &[f32], b: &[f32]) -> f64 {
    let ((a, rest), (b, rest_b)) = (a.as_chunks::<LANES>(), b.as_chunks::<LANES>());
    let mut sums = [0.0_f32; LANES];
    for (a, b) in a.iter().zip(b) {
        for lane in 0..LANES {
            sums[lane] += a[lane] * b[lane];
        }
    }
    let rest: f32 = rest.iter().zip(rest_b).map(|(a, b)| a * b).sum();
    sums.iter().map(|&x| f64::from(x)).sum::<f64>() + f64::from(rest)
}
