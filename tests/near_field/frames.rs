//! Frames: every route against the twin, the truth of the real lamp, views, several lights, threads, allocations.

use std::sync::Arc;

use haarmonic::affine::{Heuristic, PropagationScratch, Targets};
use haarmonic::backend::near_field::{
    BakeSettings, IncidentLight, PlanarLight, Precision, Ranking, Relighter, Route, Settings, TargetSelection,
    Transport, ViewFactors,
};
use haarmonic::haar::{Decomposition, Keep, inverse_2d};
use haarmonic::nalgebra::Vector3;
use haarmonic::reference::backend::near_field as naive;
use haarmonic::scene::{
    Brdf, FactoredBrdf, Lambert, LocalFrame, LocalLight, LocalTruth, Materials, Mesh, Occluders, Phong, Procedural,
    View, psnr_db, rel_l2,
};
use haarmonic::sphere::TopFace;
use haarmonic::{Error, Real};

use super::{bake, exact, lamp, materials, model};

fn relit(transport: &Transport, settings: Settings<'_>, lights: &[PlanarLight]) -> Vec<Vector3<f32>> {
    let mut relighter = Relighter::new(transport, settings).unwrap();
    relighter.set_lights(lights).unwrap();
    let mut out = vec![Vector3::repeat(f32::NAN); transport.vertices()];
    relighter.relight(&mut out);
    out
}

fn settings(route: Route, targets: TargetSelection<'_>) -> Settings<'_> {
    Settings { source_side: 16, route, targets, ..Settings::default() }
}

/// A light's pixels as the twin wants them.
fn pixels(light: &PlanarLight, side: usize) -> Vec<Vector3<f64>> {
    let planes = light.pixels(side);
    (0..side * side).map(|i| Vector3::new(planes[0][i], planes[1][i], planes[2][i]).cast()).collect()
}

#[test]
fn with_everything_kept_all_exact_routes_are_brute_force() {
    let model = model();
    let view = View::eye(model.camera.eye().cast()).unwrap();
    for (mixed, samples) in [(false, 1), (true, 2)] {
        let materials = materials(&model, mixed);
        let settings_of_bake = BakeSettings { samples, ..exact() };
        let transport = bake(&model.mesh, &view, &materials, settings_of_bake);
        let (face, frame) = (transport.face(), *transport.frame());
        // One whose texels are the source's, one finer and turned, one large and flat above the spheres.
        let turned = lamp(48, 3).with_rotation(0.7).unwrap();
        let mut wide = lamp(5, 4);
        wide.set_size([30.0, 20.0]).unwrap();
        let lights = [lamp(16, 2), turned, wide];
        let want: Vec<Vector3<f64>> = (0..model.mesh.positions().len())
            .step_by(9)
            .map(|vertex| {
                let brdf = materials.brdf(vertex);
                let position = &model.mesh.positions()[vertex];
                let wo = view.outgoing(brdf, position, &model.mesh.local_frame(vertex));
                let transport = naive::transport(&model.mesh, vertex, (brdf, &wo), &frame, &face, samples);
                let one = |light: &PlanarLight| {
                    let to = frame.to_local(&(light.centre() - position.cast::<f64>()));
                    let incident = naive::incident((&pixels(light, 16), 16), light.extent(), &to, &face);
                    naive::radiance(&incident, &transport)
                };
                lights.iter().map(one).sum()
            })
            .collect();
        assert!(want.iter().filter(|l| l.norm() > 0.0).count() > want.len() / 2);
        for route in [Route::Automatic, Route::Couplings, Route::SummedArea, Route::Pixels] {
            for targets in [TargetSelection::All, TargetSelection::Transport] {
                let got = relit(&transport, settings(route, targets), &lights);
                let got: Vec<_> = got.into_iter().step_by(9).collect();
                let off = rel_l2(&want, &got).unwrap();
                // Worst seen: 4.1e-7.
                assert!(off < 8e-7, "{route:?} {targets:?}, mixed {mixed}: {off:e}");
            }
        }
    }
}

#[test]
fn the_thesis_tables_come_near() {
    let model = model();
    let view = View::eye(model.camera.eye().cast()).unwrap();
    let transport = bake(&model.mesh, &view, &materials(&model, false), exact());
    let lights = [lamp(16, 2)];
    let want = relit(&transport, settings(Route::Pixels, TargetSelection::All), &lights);
    for (route, least, most) in [(Route::StoredCouplings, 1e-4, 2e-2), (Route::CanonicalTable, 1e-9, 2e-3)] {
        let off = rel_l2(&want, &relit(&transport, settings(route, TargetSelection::All), &lights)).unwrap();
        assert!((least..most).contains(&off), "{route:?}: {off:e}");
        let other = Settings { source_side: 32, ..settings(route, TargetSelection::All) };
        assert!(matches!(Relighter::new(&transport, other), Err(Error::Length { .. })));
    }
}

#[test]
fn more_terms_and_targets_are_nearer() {
    let model = model();
    let view = View::eye(model.camera.eye().cast()).unwrap();
    let transport = bake(&model.mesh, &view, &materials(&model, false), exact());
    let lights = [lamp(16, 2)];
    let want = relit(&transport, settings(Route::Couplings, TargetSelection::All), &lights);
    for ranking in [Ranking::Magnitude, Ranking::Integral] {
        let error = |fraction: f64, route: Route| {
            let kept =
                Settings { source_terms: Keep::Fraction(fraction), ranking, ..settings(route, TargetSelection::All) };
            rel_l2(&want, &relit(&transport, kept, &lights)).unwrap()
        };
        let errors = [0.01, 0.05, 0.2, 0.5, 1.0].map(|fraction| error(fraction, Route::Couplings));
        assert!(errors.is_sorted_by(|a, b| a > b), "{ranking:?}: {errors:?}");
        assert!(errors[0] < 0.2 && errors[4] < 1e-6, "{ranking:?}: {errors:?}");
        // What is kept does not depend on the route.
        assert!((error(0.05, Route::Pixels) / errors[1] - 1.0).abs() < 1e-4);
    }
    let targets = |keep: f64, union: usize, heuristic| TargetSelection::Predicted {
        heuristic,
        keep: Keep::Fraction(keep),
        union,
        samples: 1,
    };
    let error = |selection| rel_l2(&want, &relit(&transport, settings(Route::Couplings, selection), &lights)).unwrap();
    let narrow = error(targets(0.2, 0, Heuristic::Constant));
    let joined = error(targets(0.2, 1, Heuristic::Constant));
    assert!(joined < narrow && joined > 1e-4, "{joined} {narrow}");
    assert_eq!(error(TargetSelection::constant_light(Keep::Fraction(0.2))), joined);
    // Everything that may matter is everything.
    let power = vec![1.0; 256];
    assert!(error(targets(1.0, 1, Heuristic::Power(&power))) < 1e-3);
}

#[test]
fn a_large_fine_face_is_the_truth_of_the_real_lamp() {
    let model = model();
    let view = View::eye(model.camera.eye().cast()).unwrap();
    let materials = materials(&model, false);
    let occluders = Arc::new(Occluders::of_mesh(&model.mesh));
    let light = lamp(4, 6).with_rotation(0.3).unwrap();
    let mut spread = light.clone();
    spread.set_profile(|direction| (-direction.y).powi(2));
    for light in [light, spread] {
        let frame = BakeSettings::default().frame;
        let lights = [light.to_local_light(&frame).unwrap()];
        let truth = LocalTruth {
            mesh: &model.mesh,
            materials: &materials,
            view: &view,
            lights: &lights,
            occluders: Some(&occluders),
            fog: None,
        };
        // A light field is sampled as a whole, a texture pixel by pixel.
        let samples = if matches!(lights[0], LocalLight::Field(_)) { 32 } else { 8 };
        let truth = truth.radiance(samples, &()).unwrap();
        let psnr = |face_size: f64| {
            let settings_of_bake =
                BakeSettings { face_size, cells: 64, samples: 4, tolerance: 0.0, ..BakeSettings::default() };
            let transport = bake(&model.mesh, &view, &materials, settings_of_bake);
            let fine = Settings { source_side: 64, ..Settings::default() };
            psnr_db(&truth, &relit(&transport, fine, std::slice::from_ref(&light)), 1.0).unwrap()
        };
        let [small, large] = [1.0, 10.0].map(psnr);
        assert!(large > 45.0 && small < large - 15.0, "{small} {large}");
    }
}

#[test]
fn a_free_view_is_that_of_the_products() {
    let model = model();
    let factors = ViewFactors { cells: 6, terms: 5 };
    let settings_of_bake = BakeSettings { samples: 2, ..exact() };
    for mixed in [false, true] {
        let materials = materials(&model, mixed);
        let free = Transport::bake_view_free(
            &model.mesh,
            Occluders::of_mesh(&model.mesh),
            &materials,
            factors,
            settings_of_bake,
            &(),
        )
        .unwrap();
        assert!(free.is_view_free() && free.view().is_none());
        let mut relighter = Relighter::new(&free, settings(Route::Pixels, TargetSelection::All)).unwrap();
        relighter.set_lights(&[lamp(16, 2)]).unwrap();
        // The products are a BRDF too: seen from one view it is the same.
        let shared = |brdf: &Arc<dyn Brdf>| -> Arc<dyn Brdf> {
            match brdf.is_view_independent() {
                true => brdf.clone(),
                false => Arc::new(FactoredBrdf::new(&**brdf, factors.cells, factors.terms).unwrap()),
            }
        };
        let parts = model.parts.iter().map(|&part| u32::from(part > 0)).collect();
        let products = Materials::new(materials.brdfs().iter().map(shared).collect(), parts).unwrap();
        for eye in [model.camera.eye(), Vector3::new(-3.0, 5.0, 1.0)] {
            let view = View::eye(eye.cast()).unwrap();
            relighter.set_view(&view).unwrap();
            let mut got = vec![Vector3::zeros(); free.vertices()];
            relighter.relight(&mut got);
            let fixed = bake(&model.mesh, &view, &products, settings_of_bake);
            let want = relit(&fixed, settings(Route::Pixels, TargetSelection::All), &[lamp(16, 2)]);
            let off = rel_l2(&want, &got).unwrap();
            // A view in f32 frames and sums of products that cancel.
            assert!(off < 2e-5, "mixed {mixed}: {off:e}");
            let wavelets = relit_from(&free, &view, Route::Couplings);
            let off = rel_l2(&got, &wavelets).unwrap();
            assert!(off < 2e-5, "mixed {mixed}, by wavelets: {off:e}");
        }
    }
}

fn relit_from(transport: &Transport, view: &View, route: Route) -> Vec<Vector3<f32>> {
    let mut relighter = Relighter::new(transport, settings(route, TargetSelection::default())).unwrap();
    relighter.set_lights(&[lamp(16, 2)]).unwrap();
    relighter.set_view(view).unwrap();
    let mut out = vec![Vector3::zeros(); transport.vertices()];
    relighter.relight(&mut out);
    out
}

#[test]
fn a_baked_view_stays() {
    let model = model();
    let views = [Vector3::new(0.0, 3.0, 6.0), Vector3::new(0.0, 3.0, 7.0)].map(|eye| View::eye(eye.cast()).unwrap());
    let glossy = bake(&model.mesh, &views[0], &materials(&model, false), exact());
    let mut relighter = Relighter::new(&glossy, settings(Route::Pixels, TargetSelection::All)).unwrap();
    assert_eq!(relighter.set_view(&views[0]), Ok(()));
    assert_eq!(relighter.set_view(&views[1]), Err(Error::Baked { what: "view" }));
    let matt = bake(&model.mesh, &views[0], &Materials::uniform(Lambert::new([0.5; 3]).unwrap()), exact());
    assert_eq!(matt.view(), None);
    let mut relighter = Relighter::new(&matt, settings(Route::Pixels, TargetSelection::All)).unwrap();
    assert_eq!(relighter.set_view(&views[1]), Ok(()));
}

#[test]
fn the_face_may_lie_in_any_plane() {
    // Everything turned together: the same radiance.
    let model = model();
    let grey = Materials::uniform(Lambert::new([0.5; 3]).unwrap());
    let turn = nalgebra_turn();
    let turned = model.mesh.transformed(&haarmonic::nalgebra::convert(turn)).unwrap();
    let upright = exact();
    let spin = |v: Vector3<f32>| turn.transform_vector(&v.cast()).cast::<f32>();
    let LocalFrame { tangent, bitangent, normal } = upright.frame;
    let frame = LocalFrame { tangent: spin(tangent), bitangent: spin(bitangent), normal: spin(normal) };
    let view = View::towards(Vector3::z()).unwrap();
    let light = lamp(16, 2);
    let mut moved = light.clone();
    moved.set_centre(turn.transform_vector(&light.centre())).unwrap();
    let want =
        relit(&bake(&model.mesh, &view, &grey, upright), settings(Route::Pixels, TargetSelection::All), &[light]);
    let turned = bake(&turned, &view, &grey, BakeSettings { frame, ..upright });
    let got = relit(&turned, settings(Route::Pixels, TargetSelection::All), &[moved]);
    // Rays at edges fall on either side.
    let off = rel_l2(&want, &got).unwrap();
    assert!(off < 1e-2, "{off:e}");
}

fn nalgebra_turn() -> haarmonic::nalgebra::Rotation3<f64> {
    haarmonic::nalgebra::Rotation3::from_euler_angles(0.4, -1.1, 0.8)
}

#[test]
fn vertices_behind_the_light_are_black() {
    let model = model();
    let view = View::eye(model.camera.eye().cast()).unwrap();
    let transport = bake(&model.mesh, &view, &materials(&model, false), exact());
    let lights = |height: f64| {
        let mut light = lamp(16, 2);
        light.set_centre(Vector3::new(0.0, height, 0.0)).unwrap();
        light.set_size([50.0; 2]).unwrap();
        [light]
    };
    for route in [Route::Couplings, Route::StoredCouplings, Route::CanonicalTable, Route::SummedArea, Route::Pixels] {
        for height in [0.0, 0.5, 1e-30, -1.0, 1e30, 1e300] {
            let out = relit(&transport, settings(route, TargetSelection::All), &lights(height));
            assert!(out.iter().all(|l| l.iter().all(|c| c.is_finite())), "{route:?} {height}");
            for (l, p) in out.iter().zip(model.mesh.positions()) {
                assert!(f64::from(p.y) < height || *l == Vector3::zeros(), "{route:?} {height}: {l} at {p}");
            }
        }
    }
    // So near that the face sees one point of the light: its radiance all over, of which it sees .968 of the
    // irradiance.
    let corners = [[-1.0, 0.0, -1.0], [1.0, 0.0, -1.0], [1.0, 0.0, 1.0], [-1.0, 0.0, 1.0]].map(Vector3::from);
    let plate = Mesh::new(corners.to_vec(), vec![[0, 2, 1], [0, 3, 2]]).unwrap();
    let white = Materials::uniform(Lambert::new([1.0; 3]).unwrap());
    let transport = bake(&plate, &view, &white, BakeSettings { face_size: 10.0, samples: 4, ..exact() });
    let light = PlanarLight::uniform(Vector3::new(0.0, 1e-3, 0.0), [50.0; 2], Vector3::repeat(2.0)).unwrap();
    let share = transport.face().covered_projected_solid_angle() / std::f64::consts::PI;
    for l in relit(&transport, settings(Route::Pixels, TargetSelection::All), &[light]) {
        assert!((f64::from(l.x) - 2.0 * share).abs() < 2e-3, "{l} {share}");
    }
}

#[test]
fn lights_add_up_and_are_set_one_by_one() {
    let model = model();
    let view = View::eye(model.camera.eye().cast()).unwrap();
    let transport = bake(&model.mesh, &view, &materials(&model, true), exact());
    let [a, mut b] = [lamp(16, 2), lamp(8, 9)];
    b.set_centre(Vector3::new(-2.0, 5.0, 1.0)).unwrap();
    let all = settings(Route::Automatic, TargetSelection::All);
    let [of_a, of_b] = [&a, &b].map(|light| relit(&transport, all, std::slice::from_ref(light)));
    let both = relit(&transport, all, &[a.clone(), b.clone()]);
    let sum: Vec<Vector3<f32>> = of_a.iter().zip(&of_b).map(|(a, b)| a + b).collect();
    assert!(rel_l2(&sum, &both).unwrap() < 1e-7);
    let mut relighter = Relighter::new(&transport, all).unwrap();
    let mut out = vec![Vector3::repeat(1.0); transport.vertices()];
    relighter.relight(&mut out);
    assert!(out.iter().all(|l| *l == Vector3::zeros()), "without light all is black");
    relighter.set_lights(&[b.clone(), b.clone()]).unwrap();
    relighter.set_light(0, &a).unwrap();
    relighter.relight(&mut out);
    assert_eq!(out, both);
    assert!(matches!(relighter.set_light(2, &a), Err(Error::OutOfRange { .. })));
    relighter.set_lights(&[b]).unwrap();
    relighter.relight(&mut out);
    assert_eq!(out, of_b);
    // Any power of two, and so any light.
    for exponent in [-120, 90] {
        let scale = 2f32.powi(exponent);
        let mut scaled = a.clone();
        scaled.set_texture(&a.texture().iter().map(|t| t * scale).collect::<Vec<_>>()).unwrap();
        for (got, want) in relit(&transport, all, &[scaled]).iter().zip(&of_a) {
            assert!((got / scale - want).amax() <= 2e-6 * want.amax().max(1e-3), "{got} {want}");
        }
    }
    let mut blinding = a;
    blinding.set_texture(&vec![Vector3::repeat(f32::MAX); 256]).unwrap();
    assert!(relit(&transport, all, &[blinding]).iter().all(|l| l.iter().all(|c| c.is_finite())));
}

#[test]
fn incident_light_is_the_twins() {
    let (face, frame) = (TopFace::new(3.0, 8).unwrap(), BakeSettings::default().frame);
    let light = lamp(16, 2);
    let kept = Settings { source_side: 16, ..Settings::default() };
    let mut incident = IncidentLight::new(face, frame, kept).unwrap();
    incident.set(&light).unwrap();
    assert_eq!(incident.terms(), 256);
    let all = Targets::all(8, Decomposition::Standard).unwrap();
    for place in [[0.0, 0.0, 0.0], [1.0, 2.0, -1.5], [0.4, 3.4, -0.3], [0.4, 3.6, 0.0]] {
        let place = Vector3::from(place);
        let mut planes = [(); 3].map(|()| vec![f32::NAN; 64]);
        let [r, g, b] = &mut planes;
        incident.coefficients(&place, &all, [r, g, b], &mut PropagationScratch::new());
        let to = frame.to_local(&(light.centre() - place));
        let want = naive::incident((&pixels(&light, 16), 16), light.extent(), &to, &face);
        for (c, plane) in planes.iter().enumerate() {
            let got = inverse_2d(plane, 8, 8, Decomposition::Standard).unwrap();
            for (got, want) in got.iter().zip(&want) {
                assert!((got.widen() - want[c]).abs() < 1e-6, "{place}: {got} {want}");
            }
        }
    }
    for (face, side) in [(6, 16), (8, 12), (8, 512), (512, 16), (8, 0)] {
        let face = TopFace::new(3.0, face).unwrap();
        assert!(IncidentLight::new(face, frame, Settings { source_side: side, ..kept }).is_err(), "{side}");
    }
    for fraction in [-0.1, 1.1, f64::NAN, f64::INFINITY] {
        let kept = Settings { source_terms: Keep::Fraction(fraction), ..kept };
        assert!(IncidentLight::new(face, frame, kept).is_err());
    }
    let none = Settings { source_terms: Keep::Terms(0), ..kept };
    assert!(IncidentLight::new(face, frame, none).is_ok());
}

#[test]
fn bakes_refuse_what_they_cannot_do() {
    let model = Procedural::StackedSpheres.build(1000).unwrap();
    let view = View::eye(model.camera.eye().cast()).unwrap();
    let matt = Materials::uniform(Lambert::new([0.5; 3]).unwrap());
    let occluders = Arc::new(Occluders::of_mesh(&model.mesh));
    let try_bake = |settings: BakeSettings| {
        Transport::bake(&model.mesh, occluders.clone(), &view, &matt, settings, &()).map(|t| t.vertices())
    };
    let good = BakeSettings { cells: 4, samples: 1, ..BakeSettings::default() };
    assert_eq!(try_bake(good), Ok(model.mesh.positions().len()));
    for cells in [0, 3, 512, usize::MAX] {
        assert!(try_bake(BakeSettings { cells, ..good }).is_err(), "{cells} cells");
    }
    assert!(try_bake(BakeSettings { cells: 1, ..good }).is_ok());
    for samples in [0, 16, usize::MAX] {
        assert!(try_bake(BakeSettings { samples, ..good }).is_err(), "{samples} samples");
    }
    for face_size in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(try_bake(BakeSettings { face_size, ..good }).is_err(), "size {face_size}");
    }
    for tolerance in [-0.1, 1.0, f32::NAN, f32::INFINITY] {
        assert!(try_bake(BakeSettings { tolerance, ..good }).is_err(), "tolerance {tolerance}");
    }
    for offset in [-0.1, 1.5, f64::NAN] {
        assert!(try_bake(BakeSettings { offset, ..good }).is_err(), "offset {offset}");
    }
    for axis in [Vector3::zeros(), Vector3::repeat(f32::NAN), Vector3::repeat(1.0)] {
        let frame = LocalFrame { normal: axis, ..good.frame };
        assert!(try_bake(BakeSettings { frame, ..good }).is_err(), "axis {axis}");
    }
    let glossy = Materials::uniform(Phong::new([0.5; 3], 20.0).unwrap());
    for (cells, terms) in [(1, 1), (4, 0), (4, 17), (1000, 4)] {
        let factors = ViewFactors { cells, terms };
        assert!(Transport::bake_view_free(&model.mesh, occluders.clone(), &glossy, factors, good, &()).is_err());
    }
    let few = Materials::new(matt.brdfs().to_vec(), vec![0; 3]).unwrap();
    assert!(matches!(
        Transport::bake(&model.mesh, occluders.clone(), &view, &few, good, &()),
        Err(Error::Length { .. })
    ));
    let stop = crate::support::Watch::stopping_after(0, model.mesh.positions().len());
    assert_eq!(
        Transport::bake(&model.mesh, occluders, &view, &matt, good, &stop).map(|t| t.vertices()),
        Err(Error::Cancelled)
    );
}

#[test]
fn sixteen_bits_and_few_coefficients_come_near() {
    let model = model();
    let view = View::eye(model.camera.eye().cast()).unwrap();
    let materials = materials(&model, true);
    let want = relit(
        &bake(&model.mesh, &view, &materials, exact()),
        settings(Route::Couplings, TargetSelection::All),
        &[lamp(16, 2)],
    );
    let error = |settings_of_bake: BakeSettings| {
        let transport = bake(&model.mesh, &view, &materials, settings_of_bake);
        let [wavelets, pixels] = [Route::Couplings, Route::Pixels]
            .map(|route| relit(&transport, settings(route, TargetSelection::default()), &[lamp(16, 2)]));
        // Images of 16 bits are rounded once more (seen: 5.4e-6).
        let allowed = if settings_of_bake.precision == Precision::Full { 1e-6 } else { 1.2e-5 };
        let off = rel_l2(&wavelets, &pixels).unwrap();
        assert!(off < allowed, "{off:e}");
        (rel_l2(&want, &wavelets).unwrap(), transport.stats())
    };
    let (short, of_short) = error(BakeSettings { precision: Precision::Bits16, ..exact() });
    assert!((1e-7..3e-5).contains(&short), "{short:e}");
    let (few, of_few) = error(BakeSettings { tolerance: 0.05, ..exact() });
    assert!((1e-4..0.05).contains(&few), "{few:e}");
    assert!(of_few.coefficients < of_short.coefficients / 2 && of_few.vertices == of_short.vertices);
}

#[test]
fn frames_and_lights_allocate_nothing_after_the_first() {
    let model = model();
    let view = View::eye(model.camera.eye().cast()).unwrap();
    let transport = bake(&model.mesh, &view, &materials(&model, true), exact());
    let one_thread = haarmonic_pool();
    one_thread.install(|| {
        for route in Route::ALL {
            for (keep, targets) in
                [(1.0, TargetSelection::All), (0.1, TargetSelection::Transport), (0.1, TargetSelection::All)]
            {
                let kept = Settings { source_terms: Keep::Fraction(keep), ..settings(route, targets) };
                let mut relighter = Relighter::new(&transport, kept).unwrap();
                let mut out = vec![Vector3::zeros(); transport.vertices()];
                let mut lights = [lamp(16, 2), lamp(16, 5).with_rotation(0.3).unwrap()];
                let texture = lamp(16, 7).texture().to_vec();
                let mut frame = |k: usize, relighter: &mut Relighter<'_>| {
                    lights[0].set_texture(&texture).unwrap();
                    lights[0].set_centre(Vector3::new(0.1 * k as f64, 3.5, 0.0)).unwrap();
                    relighter.set_lights(&lights).unwrap();
                    relighter.relight(&mut out);
                };
                (0..4).for_each(|k| frame(k, &mut relighter));
                let count = allocation_counter::measure(|| (0..4).for_each(|k| frame(k, &mut relighter))).count_total;
                assert_eq!(count, 0, "{route:?} {keep} {targets:?}");
            }
        }
    });
}

fn haarmonic_pool() -> rayon::ThreadPool {
    rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap()
}
