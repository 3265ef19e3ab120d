//! Transforms by inner products with the basis functions.

/// ψ: +1 on [0, ½), −1 on [½, 1), 0 elsewhere.
fn mother(v: f64) -> f64 {
    if (0.0..0.5).contains(&v) {
        1.0
    } else if (0.5..1.0).contains(&v) {
        -1.0
    } else {
        0.0
    }
}

/// φ: 1 on [0, 1), 0 elsewhere.
fn father(v: f64) -> f64 {
    if (0.0..1.0).contains(&v) { 1.0 } else { 0.0 }
}

/// The 1D basis function of flat index `flat` at v: φ(v) for 0, 2^{l/2} ψ(2^l v − t) for 2^l + t.
pub fn basis_1d(flat: usize, v: f64) -> f64 {
    if flat == 0 {
        return father(v);
    }
    let mut level = 0;
    while 2 << level <= flat {
        level += 1;
    }
    let (scale, offset) = ((1u64 << level) as f64, (flat - (1 << level)) as f64);
    scale.sqrt() * mother(scale * v - offset)
}

/// The 2D nonstandard basis function of flat index `flat` at (x, y): 1 for 0, and 2^l times ψφ, φψ or ψψ (first factor
/// in x) of (2^l x − t_x, 2^l y − t_y) for 4^l·{1, 2, 3} + t_y·2^l + t_x.
pub fn basis_nonstandard(flat: usize, x: f64, y: f64) -> f64 {
    if flat == 0 {
        return father(x) * father(y);
    }
    let mut level = 0;
    while 4usize << (2 * level) <= flat {
        level += 1;
    }
    let side = 1usize << level;
    let (kind, within) = (flat / (side * side), flat % (side * side));
    let (u, v) = (side as f64 * x - (within % side) as f64, side as f64 * y - (within / side) as f64);
    side as f64
        * match kind {
            1 => mother(u) * father(v),
            2 => father(u) * mother(v),
            _ => mother(u) * mother(v),
        }
}

/// The 2D standard basis function of flat index k_y·width + k_x at (x, y).
pub fn basis_standard(width: usize, flat: usize, x: f64, y: f64) -> f64 {
    basis_1d(flat % width, x) * basis_1d(flat / width, y)
}

/// The centre of cell `k` of `count`; a basis function is constant over the cell.
fn centre(k: usize, count: usize) -> f64 {
    (k as f64 + 0.5) / count as f64
}

/// Compensated sum [Neumaier 1974]: right to an ε of the largest term, so that the twin is the better of the two.
fn sum(terms: impl Iterator<Item = f64>) -> f64 {
    let (mut sum, mut lost) = (0.0_f64, 0.0);
    for x in terms {
        let next = sum + x;
        lost += if sum.abs() >= x.abs() { (sum - next) + x } else { (x - next) + sum };
        sum = next;
    }
    sum + lost
}

/// ∫ f b for every function b(i, ·) of `len`, f given by its samples at `points`.
fn project<P: Copy>(samples: &[f64], points: &[P], b: impl Fn(usize, P) -> f64) -> Vec<f64> {
    assert_eq!(samples.len(), points.len(), "one point a sample");
    let product = |i| sum(samples.iter().zip(points).map(|(&f, &p)| f * b(i, p)));
    (0..samples.len()).map(|i| product(i) / samples.len() as f64).collect()
}

/// Σ_i c_i b(i, p) at every point p.
fn expand<P: Copy>(coefs: &[f64], points: &[P], b: impl Fn(usize, P) -> f64) -> Vec<f64> {
    assert_eq!(coefs.len(), points.len(), "one point a coefficient");
    points.iter().map(|&p| sum(coefs.iter().enumerate().map(|(i, &c)| c * b(i, p)))).collect()
}

fn line(len: usize) -> Vec<f64> {
    (0..len).map(|k| centre(k, len)).collect()
}

fn grid(width: usize, len: usize) -> Vec<(f64, f64)> {
    (0..len).map(|k| (centre(k % width, width), centre(k / width, len / width))).collect()
}

/// The side of a square image of `len` pixels.
fn side(len: usize) -> usize {
    let side = len.isqrt();
    assert_eq!(side * side, len, "a square image");
    side
}

/// Coefficients of a signal. O(len²).
pub fn forward_1d(samples: &[f64]) -> Vec<f64> {
    project(samples, &line(samples.len()), basis_1d)
}

/// Samples of 1D coefficients. O(len²).
pub fn inverse_1d(coefs: &[f64]) -> Vec<f64> {
    expand(coefs, &line(coefs.len()), basis_1d)
}

/// Nonstandard coefficients of a square image. O(len²).
pub fn forward_nonstandard(samples: &[f64]) -> Vec<f64> {
    project(samples, &grid(side(samples.len()), samples.len()), |i, (x, y)| basis_nonstandard(i, x, y))
}

/// The square image of nonstandard coefficients. O(len²).
pub fn inverse_nonstandard(coefs: &[f64]) -> Vec<f64> {
    expand(coefs, &grid(side(coefs.len()), coefs.len()), |i, (x, y)| basis_nonstandard(i, x, y))
}

/// Standard coefficients of an image `width` wide. O(len²).
pub fn forward_standard(width: usize, samples: &[f64]) -> Vec<f64> {
    project(samples, &grid(width, samples.len()), |i, (x, y)| basis_standard(width, i, x, y))
}

/// The image of standard coefficients, `width` wide. O(len²).
pub fn inverse_standard(width: usize, coefs: &[f64]) -> Vec<f64> {
    expand(coefs, &grid(width, coefs.len()), |i, (x, y)| basis_standard(width, i, x, y))
}

/// The means of a square image over the nodes of one level, row-major: each the plain mean of its pixels.
pub fn means(level: u32, samples: &[f64]) -> Vec<f64> {
    let (size, nodes) = (side(samples.len()), 1usize << level);
    let cell = size / nodes;
    let node = |k: usize| {
        let pixels =
            (0..cell * cell).map(|p| samples[((k / nodes) * cell + p / cell) * size + (k % nodes) * cell + p % cell]);
        sum(pixels) / (cell * cell) as f64
    };
    (0..nodes * nodes).map(node).collect()
}

/// The indices of the `terms` largest keys, ascending; of equal keys the lower index; keys of 0 never. By a full sort.
pub fn select_indices(keys: &[f64], terms: usize) -> Vec<usize> {
    let mut order: Vec<usize> = (0..keys.len()).filter(|&i| keys[i] > 0.0).collect();
    order.sort_by(|&i, &j| keys[j].total_cmp(&keys[i]).then(i.cmp(&j)));
    order.truncate(terms);
    order.sort_unstable();
    order
}
