//! The gradient of a loss in a light, against differences of frames in `f64`-sized steps.

use haarmonic::Error;
use haarmonic::backend::near_field::{PlanarLight, Relighter, Route, Settings, TargetSelection};
use haarmonic::haar::Keep;
use haarmonic::nalgebra::Vector3;
use haarmonic::scene::View;

use super::{bake, exact, lamp, materials, model};
use crate::support::Stream;

fn cotangent(vertices: usize) -> Vec<Vector3<f32>> {
    let mut stream = Stream::new(77);
    (0..vertices).map(|_| Vector3::from_fn(|_, _| stream.signed() as f32)).collect()
}

fn check(light: &PlanarLight, keep: Keep) {
    let model = model();
    let view = View::eye(model.camera.eye().cast()).unwrap();
    let transport = bake(&model.mesh, &view, &materials(&model, true), exact());
    let settings = Settings {
        source_side: 16,
        source_terms: keep,
        route: Route::Pixels,
        targets: TargetSelection::All,
        ..Settings::default()
    };
    let mut relighter = Relighter::new(&transport, settings).unwrap();
    let weights = cotangent(transport.vertices());
    let mut out = vec![Vector3::zeros(); transport.vertices()];
    let mut loss = |light: &PlanarLight| -> f64 {
        relighter.set_lights(std::slice::from_ref(light)).unwrap();
        relighter.relight(&mut out);
        out.iter().zip(&weights).map(|(l, g)| l.cast::<f64>().dot(&g.cast())).sum()
    };
    // Steps that are long against the rounding of sums in f32 and short against the cells.
    let mut difference = |step: f64, change: &dyn Fn(&mut PlanarLight, f64)| {
        let [before, after] = [-step, step].map(|d| {
            let mut changed = light.clone();
            change(&mut changed, d);
            loss(&changed)
        });
        (after - before) / (2.0 * step)
    };
    let moved =
        [0, 1, 2].map(|k| difference(1e-3, &|light, d| light.set_centre(light.centre() + Vector3::ith(k, d)).unwrap()));
    let grown = [0, 1].map(|k| {
        difference(1e-3, &|light, d| {
            let mut size = light.size();
            size[k] += d;
            light.set_size(size).unwrap();
        })
    });
    let turned = difference(1e-3, &|light, d| light.set_rotation(light.rotation() + d).unwrap());
    let painted = difference(0.25, &|light, d| {
        let mut texture = light.texture().to_vec();
        texture[7].y += d as f32;
        light.set_texture(&texture).unwrap();
    });
    relighter.set_lights(std::slice::from_ref(light)).unwrap();
    let gradient = relighter.gradient(0, light, &weights).unwrap();
    let scale = gradient.centre.norm();
    let pairs = [
        ("x", gradient.centre.x, moved[0]),
        ("y", gradient.centre.y, moved[1]),
        ("z", gradient.centre.z, moved[2]),
        ("width", gradient.size[0], grown[0]),
        ("height", gradient.size[1], grown[1]),
        ("angle", gradient.rotation, turned),
    ];
    for (what, got, want) in pairs {
        assert!((got - want).abs() < 5e-3 * scale, "{what}: {got} {want}, of {scale}");
    }
    let texel = gradient.texture[7].y;
    if keep == Keep::Fraction(1.0) {
        assert!((texel - painted).abs() < 1e-3 * painted.abs(), "texel: {texel} {painted}");
        // J is linear in the texture.
        let along: f64 = light.texture().iter().zip(&gradient.texture).map(|(t, g)| t.cast::<f64>().dot(g)).sum();
        let whole = loss_of(&mut relighter, light, &weights);
        assert!((along - whole).abs() < 1e-5 * whole.abs(), "{along} {whole}");
    }
    assert!(matches!(relighter.gradient(1, light, &weights), Err(Error::OutOfRange { .. })));
}

fn loss_of(relighter: &mut Relighter<'_>, light: &PlanarLight, weights: &[Vector3<f32>]) -> f64 {
    let mut out = vec![Vector3::zeros(); weights.len()];
    relighter.set_lights(std::slice::from_ref(light)).unwrap();
    relighter.relight(&mut out);
    out.iter().zip(weights).map(|(l, g)| l.cast::<f64>().dot(&g.cast())).sum()
}

#[test]
fn of_a_turned_light() {
    check(&lamp(6, 3).with_rotation(0.4).unwrap(), Keep::Fraction(1.0));
}

#[test]
fn of_a_masked_light_in_another_quadrant() {
    let mut light = lamp(4, 4).with_rotation(2.2).unwrap();
    let mask: Vec<f32> = (0..16).map(|i| if i == 7 { 1.0 } else { 0.5 + 0.5 * (i % 2) as f32 }).collect();
    light.set_mask(&mask).unwrap();
    let texture: Vec<Vector3<f32>> = (0..16).map(|i| light.radiance(i)).collect();
    // The same without a mask, so that the loss is linear in what is painted.
    light.set_mask(&[]).unwrap();
    light.set_texture(&texture).unwrap();
    check(&light, Keep::Fraction(1.0));
}

#[test]
fn the_mask_scales_the_gradient_of_its_texels() {
    let model = model();
    let view = View::eye(model.camera.eye().cast()).unwrap();
    let transport = bake(&model.mesh, &view, &materials(&model, false), exact());
    let mut relighter = Relighter::new(&transport, Settings { source_side: 16, ..Settings::default() }).unwrap();
    let weights = cotangent(transport.vertices());
    let mut light = lamp(4, 4);
    relighter.set_lights(std::slice::from_ref(&light)).unwrap();
    let bare = relighter.gradient(0, &light, &weights).unwrap();
    light.set_mask(&(0..16).map(|i| i as f32).collect::<Vec<_>>()).unwrap();
    relighter.set_lights(std::slice::from_ref(&light)).unwrap();
    let masked = relighter.gradient(0, &light, &weights).unwrap();
    for (i, (bare, masked)) in bare.texture.iter().zip(&masked.texture).enumerate() {
        assert!((bare * i as f64 - masked).norm() <= 1e-6 * (1.0 + masked.norm()), "{i}: {bare} {masked}");
    }
}
