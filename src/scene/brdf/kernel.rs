//! The sweep over all directions that the models' kernels run in, and the elementary functions that they need.
//!
//! Kernels are plain `f32` loops inside `pulp`'s dispatch, which compiles them once per instruction set. No fused
//! multiply-add: every instruction set gives the same bits.

use nalgebra::Vector3;

use super::{Axes, Brdf, DirectionTable, plane_count, split_colour};

/// N values (1 = the scalar s, 3 = RGB) of a lobe: f · cos θ_i but for a constant factor.
pub(crate) trait Kernel<const N: usize>: Copy {
    /// Whether the lobe does not end at the horizon: `up` then is not read.
    #[allow(dead_code, reason = "for those back ends that sample lobes across the horizon")]
    const SMOOTH: bool = false;
    /// Whether a reflectance that is nearly constant is to be told apart from the cosine.
    #[allow(dead_code, reason = "for those back ends that sample lobes across the horizon")]
    const APART: bool = false;

    /// f at cosine `up`, times `z`.
    ///
    /// `d` is the direction in world coordinates. With n·d for both this is f · cos θ_i, and anything below the
    /// horizon. With `up` = max(n·d, 0) the reflectance at the horizon goes on below it, so that neither value nor
    /// slope jumps; with z = 1 it is f without the cosine.
    fn at(&self, d: [f32; 3], up: f32, z: f32) -> [f32; N];
}

#[inline(always)]
pub(crate) fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(crate) fn narrow(v: &Vector3<f64>) -> [f32; 3] {
    [v.x as f32, v.y as f32, v.z as f32]
}

/// A shading frame and a direction to the viewer in it, narrowed for a kernel that works in local coordinates.
#[derive(Debug, Clone, Copy)]
pub(super) struct Local {
    tangent: [f32; 3],
    bitangent: [f32; 3],
    pub(super) wo: [f32; 3],
}

impl Local {
    /// `None` if the viewer is below the horizon.
    pub(super) fn new(axes: &Axes, wo: &Vector3<f64>) -> Option<Self> {
        let local = axes.to_local(wo);
        (local.z > 0.0).then(|| Self {
            tangent: narrow(&axes.tangent),
            bitangent: narrow(&axes.bitangent),
            // A cosine that is denormal in f32 would be flushed: hold it above.
            wo: [local.x as f32, local.y as f32, (local.z as f32).max(1e-9)],
        })
    }

    /// wi + wo in local coordinates, given the cosine of wi. Its z component is at least 1e-8, so that z⁴ is a normal
    /// number.
    #[inline(always)]
    pub(super) fn half(&self, d: [f32; 3], z: f32) -> [f32; 3] {
        [dot(self.tangent, d) + self.wo[0], dot(self.bitangent, d) + self.wo[1], (z + self.wo[2]).max(1e-8)]
    }
}

/// Adds a kernel times a colour and its strength over a table of directions, into one plane or three.
pub(super) fn add<const N: usize, K: Kernel<N>>(
    kernel: K,
    axes: &Axes,
    directions: &DirectionTable,
    (colour, strength): (Vector3<f64>, f64),
    out: &mut [f32],
) {
    let normal = narrow(&axes.normal);
    if plane_count(N == 1, directions.len(), out.len()) == 1 {
        directions.arch.dispatch(One::<N, K> { kernel, normal, directions, weight: strength as f32, out });
    } else {
        let weights = narrow(&(colour * strength));
        directions.arch.dispatch(Three::<N, K> { kernel, normal, directions, weights, out });
    }
}

/// Whether no direction of a row of the grid is above the horizon.
///
/// A row is an arc of a great circle shorter than π: if both its ends are below the horizon, all of it is.
#[inline(always)]
fn row_is_below(normal: [f32; 3], [x, y, z]: [&[f32]; 3]) -> bool {
    let end = |i: usize| dot(normal, [x[i], y[i], z[i]]) > 0.0;
    let last = x.len() - 1;
    !(end(0) || end(last))
}

// The jobs are types and not closures on purpose: `pulp` compiles for an instruction set what is inlined into its
// dispatch, and a closure with a large body is not, whatever is inlined into the closure.

struct One<'a, const N: usize, K> {
    kernel: K,
    normal: [f32; 3],
    directions: &'a DirectionTable,
    weight: f32,
    out: &'a mut [f32],
}

impl<const N: usize, K: Kernel<N>> pulp::WithSimd for One<'_, N, K> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) {
        sweep_one(self.kernel, self.normal, self.directions, self.weight, self.out);
    }
}

struct Three<'a, const N: usize, K> {
    kernel: K,
    normal: [f32; 3],
    directions: &'a DirectionTable,
    weights: [f32; 3],
    out: &'a mut [f32],
}

impl<const N: usize, K: Kernel<N>> pulp::WithSimd for Three<'_, N, K> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) {
        sweep_three(self.kernel, self.normal, self.directions, self.weights, self.out);
    }
}

#[inline(always)]
fn sweep_one<const N: usize, K: Kernel<N>>(
    kernel: K,
    normal: [f32; 3],
    table: &DirectionTable,
    weight: f32,
    out: &mut [f32],
) {
    let len = table.row();
    for row in table.rows_above(normal) {
        let first = row * len;
        let d = table.slices(first, len);
        if !row_is_below(normal, d) {
            row_one(kernel, normal, weight, d, &mut out[first..first + len]);
        }
    }
}

#[inline(always)]
fn row_one<const N: usize, K: Kernel<N>>(
    kernel: K,
    normal: [f32; 3],
    weight: f32,
    [x, y, z]: [&[f32]; 3],
    out: &mut [f32],
) {
    for (((&x, &y), &z), out) in x.iter().zip(y).zip(z).zip(out) {
        let cos = dot(normal, [x, y, z]);
        let value = kernel.at([x, y, z], cos, cos)[0];
        *out += if cos > 0.0 { weight * value } else { 0.0 };
    }
}

/// N = 1: the scalar times each weight; N = 3: each channel times its weight.
#[inline(always)]
fn sweep_three<const N: usize, K: Kernel<N>>(
    kernel: K,
    normal: [f32; 3],
    table: &DirectionTable,
    weights: [f32; 3],
    out: &mut [f32],
) {
    let len = table.row();
    let (red, rest) = out.split_at_mut(table.len());
    let (green, blue) = rest.split_at_mut(table.len());
    for row in table.rows_above(normal) {
        let range = row * len..(row + 1) * len;
        let d = table.slices(range.start, len);
        if !row_is_below(normal, d) {
            let planes = [&mut red[range.clone()], &mut green[range.clone()], &mut blue[range]];
            row_three(kernel, normal, weights, d, planes);
        }
    }
}

/// Values go through a buffer on the stack, block by block: a loop over six slices at once is not vectorised.
#[inline(always)]
fn row_three<const N: usize, K: Kernel<N>>(
    kernel: K,
    normal: [f32; 3],
    weights: [f32; 3],
    [x, y, z]: [&[f32]; 3],
    [red, green, blue]: [&mut [f32]; 3],
) {
    const BLOCK: usize = 64;
    let mut buffer = [[0.0_f32; BLOCK]; 3];
    for start in (0..x.len()).step_by(BLOCK) {
        let end = x.len().min(start + BLOCK);
        let n = end - start;
        let d = [&x[start..end], &y[start..end], &z[start..end]];
        if N == 1 {
            fill_one(kernel, normal, d, &mut buffer[0][..n]);
        } else {
            let [red, green, blue] = &mut buffer;
            fill_three(kernel, normal, d, [&mut red[..n], &mut green[..n], &mut blue[..n]]);
        }
        add_scaled(weights[0], &buffer[0], &mut red[start..end]);
        add_scaled(weights[1], &buffer[1 % N], &mut green[start..end]);
        add_scaled(weights[2], &buffer[2 % N], &mut blue[start..end]);
    }
}

#[inline(always)]
fn fill_one<const N: usize, K: Kernel<N>>(kernel: K, normal: [f32; 3], [x, y, z]: [&[f32]; 3], out: &mut [f32]) {
    for (((&x, &y), &z), out) in x.iter().zip(y).zip(z).zip(out) {
        let cos = dot(normal, [x, y, z]);
        let value = kernel.at([x, y, z], cos, cos)[0];
        *out = if cos > 0.0 { value } else { 0.0 };
    }
}

#[inline(always)]
fn fill_three<const N: usize, K: Kernel<N>>(
    kernel: K,
    normal: [f32; 3],
    [x, y, z]: [&[f32]; 3],
    [red, green, blue]: [&mut [f32]; 3],
) {
    let planes = red.iter_mut().zip(green).zip(blue);
    for (((&x, &y), &z), ((red, green), blue)) in x.iter().zip(y).zip(z).zip(planes) {
        let cos = dot(normal, [x, y, z]);
        let value = kernel.at([x, y, z], cos, cos);
        *red = if cos > 0.0 { value[0] } else { 0.0 };
        *green = if cos > 0.0 { value[1 % N] } else { 0.0 };
        *blue = if cos > 0.0 { value[2 % N] } else { 0.0 };
    }
}

#[inline(always)]
fn add_scaled(weight: f32, values: &[f32], out: &mut [f32]) {
    for (out, value) in out.iter_mut().zip(values) {
        *out += weight * value;
    }
}

/// [`Brdf::add_cos`] through [`Brdf::eval`], in `f64`.
pub(super) fn add_by_eval<B: Brdf + ?Sized>(
    brdf: &B,
    axes: &Axes,
    wo: &Vector3<f64>,
    directions: &DirectionTable,
    scale: f64,
    out: &mut [f32],
) {
    let n = directions.len();
    let colour = brdf.colour();
    let planes = plane_count(colour.is_some(), n, out.len());
    let wo = axes.to_local(wo);
    if wo.z <= 0.0 {
        return;
    }
    // f = c s and the largest component of c is 1: s is that component of f.
    let leading = colour.map_or(0, |c| c.imax());
    for i in 0..n {
        let d = Vector3::new(directions.x()[i], directions.y()[i], directions.z()[i]).cast::<f64>();
        let wi = axes.to_local(&d);
        if wi.z <= 0.0 {
            continue;
        }
        let value = brdf.eval(&wi, &wo) * (scale * wi.z);
        if planes == 1 {
            out[i] += value[leading] as f32;
        } else {
            for k in 0..3 {
                out[k * n + i] += value[k] as f32;
            }
        }
    }
}

/// The colour and the scalar factor of an RGB factor times `scale` times `constant`.
pub(super) fn scaled(rgb: &Vector3<f64>, scale: f64, constant: f64) -> (Vector3<f64>, f64) {
    let (colour, strength) = split_colour(rgb);
    (colour, strength * scale * constant)
}

/// log₂(1 + t) for t ∈ (−1, ∞), normal numbers; t = −1 gives −127, not −∞.
///
/// ```math
/// 1 + t = 2^k (1 + u), √½ ≤ 1 + u < √2;  log₂(1 + u) = (2/ln 2) artanh(u/(2 + u))
/// ```
///
/// The series of artanh breaks off after s⁹/9, s ≤ 0.172: 2e-9 relative. For k = 0, u is t itself, so that small t keep
/// their relative precision. Accuracy: relative error ≤ 3 ε (measured in the tests).
#[inline(always)]
pub(super) fn log2_1p(t: f32) -> f32 {
    const SCALE: f32 = 2.0 * std::f32::consts::LOG2_E;
    const SQRT_HALF: u32 = 0x3f35_04f3;
    let bits = (1.0 + t).to_bits();
    let k = (bits.wrapping_sub(SQRT_HALF) as i32) >> 23;
    let reduced = f32::from_bits(bits.wrapping_sub((k as u32) << 23)) - 1.0;
    let u = if k == 0 { t } else { reduced };
    let s = u / (2.0 + u);
    let s2 = s * s;
    let s4 = s2 * s2;
    let series = (1.0 + s2 * (1.0 / 3.0)) + s4 * ((1.0 / 5.0 + s2 * (1.0 / 7.0)) + s4 * (1.0 / 9.0));
    k as f32 + (SCALE * s) * series
}

/// 2^y for y ≤ 127; 0 for y ≤ −126.
///
/// ```math
/// y = k + r, |r| ≤ ½;  2^r = Σ_{j ≤ 7} (r ln 2)^j / j!
/// ```
///
/// The series' remainder is 5e-9. Accuracy: relative error ≤ 2 ε (measured in the tests).
#[inline(always)]
pub(super) fn exp2(y: f32) -> f32 {
    // Adding 1.5 · 2²³ rounds to the nearest integer and leaves it in the low bits.
    const ROUND: f32 = 12_582_912.0;
    const LN_2: f64 = std::f64::consts::LN_2;
    const C1: f32 = LN_2 as f32;
    const C2: f32 = (LN_2 * LN_2 / 2.0) as f32;
    const C3: f32 = (LN_2 * LN_2 * LN_2 / 6.0) as f32;
    const C4: f32 = (LN_2 * LN_2 * LN_2 * LN_2 / 24.0) as f32;
    const C5: f32 = (LN_2 * LN_2 * LN_2 * LN_2 * LN_2 / 120.0) as f32;
    const C6: f32 = (LN_2 * LN_2 * LN_2 * LN_2 * LN_2 * LN_2 / 720.0) as f32;
    const C7: f32 = (LN_2 * LN_2 * LN_2 * LN_2 * LN_2 * LN_2 * LN_2 / 5040.0) as f32;
    let clamped = if y > -126.0 { y } else { -126.0 };
    let shifted = clamped + ROUND;
    let r = clamped - (shifted - ROUND);
    let power = f32::from_bits((shifted.to_bits() << 23).wrapping_add(0x3f80_0000));
    let r2 = r * r;
    let low = (1.0 + r * C1) + r2 * (C2 + r * C3);
    let high = (C4 + r * C5) + r2 * (C6 + r * C7);
    let value = power * (low + r2 * r2 * high);
    if y > -126.0 { value } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{CookTorrance, LocalFrame, Phong};
    use crate::sphere::CubeGrid;

    const EPS: f64 = f32::EPSILON as f64;

    #[test]
    fn log2_1p_is_good_to_three_ulps() {
        let mut worst = 0.0_f64;
        let mut check = |t: f32| {
            let exact = f64::from(t).ln_1p() / std::f64::consts::LN_2;
            worst = worst.max((f64::from(log2_1p(t)) - exact).abs() / exact.abs());
        };
        for i in 0..200_000 {
            let x = i as f32 / 200_000.0;
            check((x - 1.0).max(-1.0 + 1e-6));
            check(x.max(1e-38));
            check((x * 87.0).exp());
            check((-x * 87.0).exp());
            check(-(-x * 87.0).exp().min(0.999_999));
        }
        assert!(worst <= 3.0 * EPS, "{}", worst / EPS);
        assert_eq!(log2_1p(0.0), 0.0);
        assert_eq!(log2_1p(-1.0), -127.0);
    }

    #[test]
    fn exp2_is_good_to_two_ulps() {
        let mut worst = 0.0_f64;
        for i in 0..=1_000_000 {
            let y = -126.0 + 253.0 * i as f32 / 1_000_000.0;
            if y > -126.0 {
                worst = worst.max((f64::from(exp2(y)) / f64::from(y).exp2() - 1.0).abs());
            }
        }
        assert!(worst <= 2.0 * EPS, "{}", worst / EPS);
        assert_eq!([exp2(0.0), exp2(1.0), exp2(-3.0), exp2(127.0)], [1.0, 2.0, 0.125, 2.0_f32.powi(127)]);
        assert_eq!([exp2(-126.0), exp2(-1e30), exp2(f32::NEG_INFINITY), exp2(f32::NAN)], [0.0; 4]);
    }

    #[test]
    fn powers_equal_f64() {
        for n in [0.5_f32, 1.0, 7.3, 100.0, 1e4, 1e6] {
            for i in 1..2000 {
                let q = (i as f32 / 2000.0).powi(4);
                let exact = (1.0 - f64::from(q)).powf(f64::from(n));
                let got = f64::from(exp2(n * log2_1p(-q)));
                // The product's rounding and log2's error are multiplied with the exponent of 2.
                let tolerance = EPS * (2.0 + 3.0 * exact.log2().abs()) * exact;
                assert!((got - exact).abs() <= tolerance.max(2e-38), "{q}^{n}: {got:e} against {exact:e}");
            }
        }
    }

    #[test]
    fn every_instruction_set_gives_the_same_bits() {
        let frame = LocalFrame { tangent: Vector3::z(), bitangent: Vector3::x(), normal: Vector3::y() };
        let wo = Vector3::new(0.3, 0.8, -0.2).normalize();
        for side in [1, 7, 32] {
            let fast = DirectionTable::new(CubeGrid::new(side).unwrap());
            let mut scalar = fast.clone();
            scalar.arch = pulp::Arch::Scalar;
            let models: [&dyn Brdf; 3] = [
                &Phong::new([0.5, 0.2, 0.1], 33.0).unwrap(),
                &CookTorrance::new([0.5, 0.2, 0.1], 0.2, 0.3).unwrap(),
                &crate::scene::Ward::new([0.5; 3], 0.2, 0.3).unwrap(),
            ];
            for model in models {
                let sample = |table: &DirectionTable| {
                    let mut out = vec![0.0; 3 * table.len()];
                    model.sample_cos(&frame, &wo, table, &mut out);
                    out
                };
                assert_eq!(sample(&fast), sample(&scalar), "{model:?}");
            }
        }
    }
}
