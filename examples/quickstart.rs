//! The mathematics in 60 lines: transform three functions on a square, keep few wavelets, integrate their product.
//!
//! `cargo run --release --example quickstart`
#![expect(clippy::print_stdout, reason = "an example talks to its user")]

use haarmonic::haar::{BitPyramid, Decomposition, Factor, Keep, Selection, TripleProduct, Weighting, forward_2d};

const SIDE: usize = 64;

fn main() -> Result<(), haarmonic::Error> {
    // One face of a cube map: a light with a small bright lamp, a smooth reflection lobe, a shadow with a hard edge.
    let at = |i: usize| ((i % SIDE) as f32 / SIDE as f32, (i / SIDE) as f32 / SIDE as f32);
    let image = |f: &dyn Fn(f32, f32) -> f32| (0..SIDE * SIDE).map(|i| f(at(i).0, at(i).1)).collect::<Vec<_>>();
    let light = image(&|x, y| 1.0 + y + if (x - 0.3).hypot(y - 0.6) < 0.05 { 200.0 } else { 0.0 });
    let lobe = image(&|x, y| (-8.0 * ((x - 0.4).powi(2) + (y - 0.5).powi(2))).exp());
    let mut visible = vec![0u64; SIDE * SIDE / 64];
    for i in (0..SIDE * SIDE).filter(|&i| at(i).0 + 0.3 * at(i).1 < 0.5) {
        visible[i / 64] |= 1 << (i % 64);
    }

    // The right answer: the mean over the texels.
    let seen = |i: usize| f64::from((visible[i / 64] >> (i % 64)) as u32 & 1);
    let exact = (0..SIDE * SIDE).map(|i| f64::from(light[i]) * f64::from(lobe[i]) * seen(i)).sum::<f64>();
    let exact = exact / (SIDE * SIDE) as f64;

    // The same integral from few wavelets of light and lobe; visibility stays whole, one bit a texel.
    let visibility = BitPyramid::from_rows(SIDE, &visible)?;
    let product = TripleProduct::new(SIDE)?;
    let light = forward_2d(&light, SIDE, SIDE, Decomposition::Nonstandard)?;
    let lobe = forward_2d(&lobe, SIDE, SIDE, Decomposition::Nonstandard)?;
    println!("integral of light x lobe x visibility over the texels: {exact:.6}\n");
    println!("terms kept    by magnitude           by integral");
    let mut last = f64::NAN;
    for keep in ["0.3%", "1%", "3%", "10%", "all"] {
        print!("{keep:>10}");
        for weighting in [Weighting::Magnitude, Weighting::Integral] {
            let rule = Selection::new(keep.parse::<Keep>()?).with_weighting(weighting);
            let (light, lobe) = (Factor::new([&rule.apply(&light)?])?, Factor::new([&rule.apply(&lobe)?])?);
            let [integral] = product.integral(&light, &lobe, (&visibility).into());
            last = integral;
            print!("    {integral:.6} ({:+7.3} %)", 100.0 * (integral / exact - 1.0));
        }
        println!();
    }
    assert!((last / exact - 1.0).abs() < 1e-5, "all terms together are the function itself");
    Ok(())
}
