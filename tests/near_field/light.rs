//! Lights on their own: textures on grids, extents, maps, what is refused.

use haarmonic::Error;
use haarmonic::backend::near_field::{BakeSettings, PlanarLight};
use haarmonic::nalgebra::Vector3;
use haarmonic::scene::LocalLight;
use haarmonic::sphere::TopFace;
use proptest::prelude::*;

use super::lamp;
use crate::support::cases;

/// ∫ radiance over the plane, from the pixels of the extent and from the texels.
fn powers(light: &PlanarLight, side: usize) -> [Vector3<f64>; 2] {
    let [w, h] = light.extent();
    let sum = |plane: &[f32]| plane.iter().map(|&x| f64::from(x)).sum::<f64>();
    let planes = light.pixels(side);
    let from_pixels = Vector3::from(planes.each_ref().map(|p| sum(p))) * (w * h / (side * side) as f64);
    let [width, height] = light.size();
    let texels: Vector3<f64> = (0..light.texture().len()).map(|i| light.radiance(i).cast::<f64>()).sum();
    [from_pixels, texels * (width * height / light.texture().len() as f64)]
}

proptest! {
    #![proptest_config(cases(64))]

    #[test]
    fn energy_is_kept_whatever_the_angle(
        angle in -7.0..7.0_f64,
        texels in 1..20_usize,
        side in prop::sample::select(vec![1, 2, 8, 32]),
        size in [0.1..9.0_f64, 0.1..9.0],
    ) {
        let mut light = lamp(texels, texels as u64).with_rotation(angle).unwrap();
        light.set_size(size).unwrap();
        light.set_mask(&(0..texels * texels).map(|i| (i % 3) as f32).collect::<Vec<_>>()).unwrap();
        let [got, want] = powers(&light, side);
        // Cells sum in f32.
        prop_assert!((got - want).norm() <= 1e-6 * want.norm(), "{got} {want}");
    }
}

#[test]
fn upright_and_quarter_turns_are_the_texture() {
    let light = lamp(8, 3);
    let upright = light.pixels(8);
    for (i, texel) in light.texture().iter().enumerate() {
        for c in 0..3 {
            assert_eq!(upright[c][i], texel[c]);
        }
    }
    // The tangent goes to the bitangent: column x becomes row x, row y column 7 − y.
    let turned = light.clone().with_rotation(std::f64::consts::FRAC_PI_2).unwrap();
    let [w, h] = turned.extent();
    assert!((w - light.size()[1]).abs() < 1e-15 && (h - light.size()[0]).abs() < 1e-15);
    let planes = turned.pixels(8);
    for (i, texel) in light.texture().iter().enumerate() {
        let (x, y) = (i % 8, i / 8);
        for c in 0..3 {
            let got = planes[c][x * 8 + 7 - y];
            assert!((got - texel[c]).abs() < 1e-6, "{x} {y}: {got} {}", texel[c]);
        }
    }
    // A finer texture is averaged, a coarser one repeated.
    let means = light.pixels(4);
    let texel = |x: usize, y: usize| light.texture()[y * 8 + x].x;
    assert!((means[0][1] - 0.25 * (texel(2, 0) + texel(3, 0) + texel(2, 1) + texel(3, 1))).abs() < 1e-7);
    assert_eq!(light.pixels(16)[0][17], texel(0, 0));
}

#[test]
fn a_turned_texture_is_where_a_ray_finds_it() {
    // Many points of each cell, looked up in the turned rectangle.
    let light = lamp(5, 8).with_rotation(0.6).unwrap();
    let ([w, h], [ew, eh], side, fine) = (light.size(), light.extent(), 6, 64);
    let planes = light.pixels(side);
    for cell in 0..side * side {
        let mut sum = 0.0;
        for k in 0..fine * fine {
            let place = |i: usize, k: usize| (i as f64 + (k as f64 + 0.5) / fine as f64) / side as f64 - 0.5;
            let (x, y) = (ew * place(cell % side, k % fine), eh * place(cell / side, k / fine));
            let (sin, cos) = 0.6_f64.sin_cos();
            let (u, v) = ((x * cos + y * sin) / w + 0.5, (y * cos - x * sin) / h + 0.5);
            if (0.0..1.0).contains(&u) && (0.0..1.0).contains(&v) {
                sum += f64::from(light.texture()[(v * 5.0) as usize * 5 + (u * 5.0) as usize].y);
            }
        }
        let want = sum / (fine * fine) as f64;
        assert!((f64::from(planes[1][cell]) - want).abs() < 5e-3, "cell {cell}: {} {want}", planes[1][cell]);
    }
}

#[test]
fn maps_are_where_lines_of_sight_meet_the_light() {
    let (face, frame) = (TopFace::new(4.0, 8).unwrap(), BakeSettings::default().frame);
    let light = lamp(4, 1);
    let position = Vector3::new(1.0, 0.5, -2.0);
    let maps = light.maps(&face, &frame, &position).unwrap();
    for w in [[0.2, 0.9], [0.5, 0.5], [0.0, 1.0]] {
        let direction = frame.to_world(&face.direction(&w.into()));
        let hit = position + direction * ((light.centre().y - position.y) / direction.y);
        let from_centre = frame.to_local(&(hit - light.centre()));
        for axis in 0..2 {
            let want = from_centre[axis] / light.size()[axis] + 0.5;
            assert!((maps[axis].apply(w[axis]) - want).abs() < 1e-14, "{w:?}");
        }
    }
    // In the plane, behind it, too far, nowhere.
    for y in [3.5, 4.0, -1e101, f64::NAN] {
        assert_eq!(light.maps(&face, &frame, &Vector3::new(0.0, y, 0.0)), None, "{y}");
    }
    assert!(light.maps(&face, &frame, &Vector3::new(0.0, 3.5_f64.next_down(), 0.0)).is_some());
}

#[test]
fn the_truths_light_has_the_same_corners_and_texels() {
    let frame = BakeSettings::default().frame;
    let light = lamp(3, 1).with_rotation(0.4).unwrap();
    let LocalLight::Rectangle(rectangle) = light.to_local_light(&frame).unwrap() else { panic!() };
    assert_eq!(rectangle.size(), [3, 3]);
    assert_eq!(rectangle.pixels()[6], light.texture()[0]);
    let [a, b, c, _] = rectangle.corners();
    assert!((b - a).cross(&(c - b)).y < 0.0, "it shines down");
    assert!(((b - a).norm() - 2.5).abs() < 1e-12 && ((c - b).norm() - 1.7).abs() < 1e-12);
}

#[test]
fn what_is_no_light_is_refused_and_changes_nothing() {
    let (centre, size, texture) = (Vector3::zeros(), [1.0, 2.0], vec![Vector3::repeat(1.0_f32); 6]);
    let new = |centre, size, width, texture: &[Vector3<f32>]| PlanarLight::new(centre, size, width, texture.to_vec());
    let good = new(centre, size, 3, &texture).unwrap();
    assert_eq!(good.texture_size(), [3, 2]);
    for width in [0, 4, usize::MAX] {
        assert!(new(centre, size, width, &texture).is_err(), "{width}");
    }
    assert!(matches!(new(centre, size, 1, &[]), Err(Error::Empty { .. })));
    for bad in [f32::NAN, f32::INFINITY] {
        assert!(matches!(new(centre, size, 1, &[Vector3::new(0.0, bad, 0.0)]), Err(Error::NotFinite { .. })));
    }
    assert!(new(centre, [1e-300, f64::MAX], 1, &[Vector3::repeat(f32::MAX)]).is_ok());
    let mut light = good.clone();
    for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(light.set_size([1.0, bad]).is_err() && light.set_size([bad, 1.0]).is_err(), "{bad}");
    }
    for bad in [f64::NAN, f64::INFINITY] {
        assert!(light.set_centre(Vector3::new(0.0, bad, 0.0)).is_err() && light.set_rotation(bad).is_err());
    }
    assert!(light.set_texture(&texture[..5]).is_err() && light.set_texture(&[Vector3::repeat(f32::NAN); 6]).is_err());
    assert!(light.set_mask(&[1.0; 5]).is_err() && light.set_mask(&[f32::NAN; 6]).is_err());
    assert_eq!(light, good);
    light.set_mask(&[0.5; 6]).unwrap();
    assert_eq!(light.radiance(5), Vector3::repeat(0.5));
    light.set_mask(&[]).unwrap();
    assert_eq!(light, good);
    // A profile that is not a number lets nothing out.
    light.set_profile(|d| if d.x > 0.0 { 2.0 } else { f64::NAN });
    assert_eq!([1.0, -1.0].map(|x| light.profile(&Vector3::new(x, 0.0, 0.0))), [2.0, 0.0]);
    light.clear_profile();
    assert_eq!(light.profile(&Vector3::x()), 1.0);
}
