//! Nanoseconds a cap of sums over caps, the inner loop of soft shadows by harmonics: logarithms of discs about
//! directions and of spheres seen from receivers, in turn with the naive way (evaluate the basis, look the logarithm
//! up, multiply, add) and the naive twin.
//!
//! Run with: cargo bench -p haarmonic-benches --bench sh_cap_sum [-- WORDS]: jobs whose name holds all the words.

use std::hint::black_box;

use haarmonic::Real;
use haarmonic::nalgebra::{UnitVector3, Vector3};
use haarmonic::reference::sh as naive;
use haarmonic::sh::{Basis, CapFit, CapLog, CapSum, Zonal};
use haarmonic::sphere::fibonacci_directions;
use haarmonic_benches::Jobs;

/// Receivers of a batch, and caps of each.
const RECEIVERS: usize = 256;
const CAPS: usize = 64;
const CELLS: usize = 512;

/// Where caps are and how large: 0.05 to 0.8.
fn caps<T: Real>(count: usize) -> ([Vec<T>; 3], Vec<T>) {
    let directions = fibonacci_directions(count);
    let shuffled = || (0..count).map(move |j| j * 7919 % count);
    let angles = (0..count).map(|j| T::of(0.05 + 0.75 * ((j * 104_729) % 1009) as f64 / 1009.0)).collect();
    ([0, 1, 2].map(|axis| shuffled().map(|j| T::of(directions[j][axis])).collect()), angles)
}

fn add<T: Real>(jobs: &mut Jobs, bands: usize, scalar: &str) {
    let log = CapLog::new(bands, CapFit::default()).expect("bands in range");
    let sum = CapSum::<T>::of_logarithms(&log, CELLS).expect("cells in range");
    let size = bands * bands;

    let (([x, y, z], angles), plan) = (caps::<T>(CAPS), sum.clone());
    let mut out = vec![T::zero(); size];
    jobs.add(format!("{scalar} caps {bands}"), CAPS, move || {
        out.fill(T::zero());
        plan.accumulate([black_box(&x), &y, &z], &angles, black_box(&mut out));
    });
    let (([x, y, z], angles), plan) = (caps::<T>(CAPS * RECEIVERS), sum.clone());
    let mut out = vec![T::zero(); size * RECEIVERS];
    jobs.add(format!("{scalar} caps batch {bands}"), CAPS * RECEIVERS, move || {
        out.fill(T::zero());
        plan.accumulate_batch(RECEIVERS, [black_box(&x), &y, &z], &angles, black_box(&mut out));
    });
    // Spheres around receivers near the origin.
    let ((centres, angles), plan) = (caps::<T>(CAPS), sum.clone());
    let radii: Vec<T> = angles.iter().map(|angle| angle.sin()).collect();
    let mut out = vec![T::zero(); size];
    jobs.add(format!("{scalar} spheres {bands}"), CAPS, move || {
        out.fill(T::zero());
        let centres = [&centres[0][..], &centres[1], &centres[2]];
        plan.accumulate_spheres(black_box(&Vector3::zeros()), centres, &radii, black_box(&mut out));
    });
    let ((centres, angles), plan) = (caps::<T>(CAPS), sum);
    let radii: Vec<T> = angles.iter().map(|angle| angle.sin()).collect();
    let (receivers, _) = caps::<T>(RECEIVERS);
    let receivers = receivers.map(|c| c.into_iter().map(|c| c * T::of(0.1)).collect::<Vec<T>>());
    let mut out = vec![T::zero(); size * RECEIVERS];
    jobs.add(format!("{scalar} spheres batch {bands}"), CAPS * RECEIVERS, move || {
        out.fill(T::zero());
        let (centres, receivers) = (centres.each_ref().map(|c| &c[..]), receivers.each_ref().map(|c| &c[..]));
        plan.accumulate_spheres_batch(receivers, centres, black_box(&radii), black_box(&mut out));
    });

    let ([x, y, z], angles) = caps::<T>(CAPS);
    let basis = Basis::<T>::new(bands).expect("bands in range");
    let scales: Vec<T> = Zonal::<T>::from_coefficients(vec![T::one(); bands]).expect("bands").factors().to_vec();
    let (mut out, mut values, mut zonal) = (vec![T::zero(); size], vec![T::zero(); size], vec![T::zero(); bands]);
    jobs.add(format!("{scalar} step by step {bands}"), CAPS, move || {
        out.fill(T::zero());
        for j in 0..CAPS {
            basis.eval(&Vector3::new(x[j], y[j], z[j]), black_box(&mut values));
            log.eval(angles[j], &mut zonal);
            for (l, (f, scale)) in zonal.iter().zip(&scales).enumerate() {
                let factor = *f * *scale;
                let range = l * l..(l + 1) * (l + 1);
                out[range.clone()].iter_mut().zip(&values[range]).for_each(|(out, y)| *out += factor * *y);
            }
        }
        black_box(&mut out);
    });
}

fn twin(jobs: &mut Jobs, bands: usize) {
    let log = CapLog::new(bands, CapFit::default()).expect("bands in range");
    let ([x, y, z], angles) = caps::<f64>(CAPS);
    let direction = |j: usize| UnitVector3::new_normalize(Vector3::new(x[j], y[j], z[j]));
    let caps: Vec<_> = (0..CAPS).map(|j| (direction(j), angles[j])).collect();
    let f = move |theta: f64| {
        let mut out = vec![0.0; bands];
        log.eval(theta, &mut out);
        out
    };
    jobs.add(format!("twin {bands}"), CAPS, move || {
        black_box(naive::cap_sum(bands, &f, black_box(&caps)));
    });
}

fn main() {
    let mut jobs = Jobs::default();
    for bands in [3, 4, 6, 8] {
        add::<f32>(&mut jobs, bands, "f32");
        add::<f64>(&mut jobs, bands, "f64");
        twin(&mut jobs, bands);
    }
    jobs.run();
}
