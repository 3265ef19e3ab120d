//! A light in its forms.

use haarmonic::Error;
use haarmonic::backend::block_product::{LightForms, SampleBasis};
use haarmonic::compress::ScanOrder;
use haarmonic::nalgebra::Vector3;
use haarmonic::reference::backend::block_product as twin;
use haarmonic::scene::Sky;

use super::support::{ORDERS, constant, layout, of_sky, one_texel, sky};
use crate::support::{grid, noisy};

#[test]
fn weights_are_the_cardinal_functions_integrals() {
    for (side, block) in [(8, 8), (32, 16), (48, 8), (32, 32), (64, 32)] {
        let lights = [sky(side), noisy(side, 7), one_texel(side, 3 * side + 1), of_sky(Sky::studio(), side)];
        for (light, order) in lights.iter().zip(ORDERS.into_iter().cycle()) {
            let layout = layout(side, block, order);
            let weighted = twin::weighted(light);
            for basis in [SampleBasis::Cosine, SampleBasis::Polynomial] {
                let mut forms = LightForms::new(&layout, basis).unwrap();
                forms.set(light).unwrap();
                for b in 0..layout.blocks() {
                    let reference = twin::Block::new(side, block, b);
                    let want: Vec<Vector3<f64>> =
                        [1, 2, 4].iter().flat_map(|&l| twin::weights(&weighted, &reference, l, basis)).collect();
                    let size: Vector3<f64> = (0..block * block).map(|p| weighted[reference.texel(p)].abs()).sum();
                    for c in 0..3 {
                        let got = forms.weights(c, b);
                        assert_eq!(got.len(), 21);
                        for (node, (&got, want)) in got.iter().zip(&want).enumerate() {
                            // One rounding to f32; solid angles of the grid cancel to side · 1e-16, and cardinal
                            // functions reach 4: measured 1.3e-14.
                            let slack = 6.0e-8 * want[c].abs() + 1e-13 * size[c];
                            let off = (f64::from(got) - want[c]).abs();
                            assert!(off <= slack, "{side}/{block} {basis:?} block {b} node {node}: off by {off:e}");
                        }
                    }
                }
            }
        }
    }
}

/// Samples that are all 1 stand for 1: each level's weights add up to the block's light.
#[test]
fn weights_of_every_level_add_up_to_the_light() {
    let light = noisy(32, 3);
    let total = light.integral();
    for basis in [SampleBasis::Cosine, SampleBasis::Polynomial] {
        let mut forms = LightForms::new(&layout(32, 16, ScanOrder::Hilbert), basis).unwrap();
        forms.set(&light).unwrap();
        for c in 0..3 {
            for level in [0..1, 1..5, 5..21] {
                let sum: f64 = (0..24).flat_map(|b| &forms.weights(c, b)[level.clone()]).map(|&w| f64::from(w)).sum();
                // 384 roundings of weights that are a tenth of a block's light each.
                assert!((sum / total[c] - 1.0).abs() < 1e-7, "{basis:?} {level:?}: {sum} against {}", total[c]);
            }
        }
    }
}

#[test]
fn a_refused_light_leaves_the_one_before() {
    let layout = layout(16, 8, ScanOrder::Serpentine);
    let mut forms = LightForms::new(&layout, SampleBasis::default()).unwrap();
    let all = |forms: &LightForms| -> Vec<f32> {
        (0..3).flat_map(|c| (0..24).flat_map(move |b| forms.weights(c, b).to_vec())).collect()
    };
    assert!(all(&forms).iter().all(|&w| w == 0.0), "a new light is dark");
    assert_eq!((forms.layout(), forms.grid()), (&layout, grid(16)));
    forms.set(&noisy(16, 1)).unwrap();
    let before = all(&forms);
    assert!(before.iter().any(|&w| w != 0.0));
    for side in [8, 32] {
        let expected = Error::Length { what: "side of the light's cube map", expected: 16, got: side };
        assert_eq!(forms.set(&noisy(side, 1)), Err(expected));
        assert_eq!(all(&forms), before);
    }
    for (bad, texel) in [(f32::NAN, 0), (f32::INFINITY, 700), (f32::NEG_INFINITY, 1535)] {
        for channel in 0..3 {
            let mut light = noisy(16, 2);
            light.texels_mut()[texel][channel] = bad;
            assert_eq!(forms.set(&light), Err(Error::NotFinite { what: "texel of the light", index: texel }));
            assert_eq!(all(&forms), before);
        }
    }
    // Lights follow each other without a trace.
    forms.set(&sky(16)).unwrap();
    forms.set(&noisy(16, 1)).unwrap();
    assert_eq!(all(&forms), before);
    forms.set(&constant(16, 0.0)).unwrap();
    assert!(all(&forms).iter().all(|&w| w == 0.0));
}

/// The bytes of the module's table: 12 of texels, twice 48 and 36 of suffix sums, and 252 a block of weights.
#[test]
fn bytes_are_those_of_the_table() {
    for (side, block) in [(64, 16), (32, 32), (48, 8)] {
        let layout = layout(side, block, ScanOrder::RowMajor);
        let forms = LightForms::new(&layout, SampleBasis::default()).unwrap();
        assert_eq!(forms.bytes(), 180 * layout.grid().len() + 252 * layout.blocks());
    }
}
