//! Frames: darkness, pictures, counts, threads, change.

use haarmonic::Error;
use haarmonic::backend::block_product::{BlockAngle, FrameStats, Relighter, Rule, SampleBasis, Settings, Transport};
use haarmonic::compress::ScanOrder;
use haarmonic::nalgebra::Vector3;
use haarmonic::scene::{Camera, CookTorrance, Lambert, Materials, Mesh, Model, Phong, Procedural, Sum, View};

use super::support::{above, constant, frame, in_turn, layout, lobe, patchwork, sky, view};
use crate::support::{baker, noisy, soup};

fn rules() -> [Rule; 4] {
    [Rule::Pixels, Rule::Fixed { angle: BlockAngle::Centre }, Rule::default(), Rule::bounded(0.5).unwrap()]
}

fn settings(rule: Rule) -> Settings {
    Settings { rule, basis: SampleBasis::default() }
}

fn transport(mesh: &Mesh, side: usize, block: usize) -> Transport {
    Transport::bake(&baker(mesh, side), &layout(side, block, ScanOrder::Serpentine), &()).unwrap()
}

/// Diffuse, glossy, both, neither.
fn mixed(vertices: usize) -> Materials {
    let diffuse = lobe(Lambert::new([0.8, 0.4, 0.2]).unwrap());
    let gloss = lobe(Phong::new([0.3, 0.4, 0.5], 60.0).unwrap());
    let both = lobe(Sum::new(vec![(0.7, diffuse.clone()), (0.3, gloss.clone())]).unwrap());
    let rough = lobe(CookTorrance::isotropic([0.9, 0.6, 0.3], 0.3).unwrap());
    in_turn(&[diffuse, gloss, both, rough, lobe(Lambert::new([0.0; 3]).unwrap())], vertices)
}

fn dark(radiance: &[Vector3<f32>]) -> bool {
    radiance.iter().all(|l| *l == Vector3::zeros())
}

#[test]
fn no_light_is_black() {
    let mesh = soup(10);
    let transport = transport(&mesh, 16, 8);
    let materials = mixed(30);
    for rule in rules() {
        let mut relighter = Relighter::new(&mesh, &transport, settings(rule)).unwrap();
        let mut out = vec![Vector3::repeat(f32::NAN); 30];
        relighter.relight(&view(), &materials, &mut out).unwrap();
        assert!(dark(&out), "{rule:?}: no light was set");
        relighter.set_light(&noisy(16, 1)).unwrap();
        relighter.relight(&view(), &materials, &mut out).unwrap();
        assert!(!dark(&out));
        relighter.set_light(&constant(16, 0.0)).unwrap();
        relighter.relight(&view(), &materials, &mut out).unwrap();
        assert!(dark(&out), "{rule:?}: the light was put out");
        // Dark but for one texel, behind all: the blocks without light are no trouble.
        relighter.set_light(&super::support::one_texel(16, 77)).unwrap();
        relighter.relight(&view(), &materials, &mut out).unwrap();
        assert!(out.iter().all(|l| l.iter().all(|c| c.is_finite())));
    }
}

#[test]
fn from_behind_there_is_nothing_to_see_but_diffuse_light() {
    let mesh = soup(30);
    let transport = transport(&mesh, 16, 16);
    let materials = mixed(90);
    for rule in rules() {
        let radiance = frame((&mesh, &transport), settings(rule), &noisy(16, 2), &view(), &materials);
        let mut behind = [0; 2];
        for (v, l) in radiance.iter().enumerate() {
            let normal = mesh.normals()[v].cast::<f64>();
            let is_behind = view().wo(&mesh.positions()[v]).dot(&normal) <= 0.0;
            match (v % 5, is_behind) {
                // Diffuse light alone goes to all sides: it is had for the view along the normal.
                (0, _) => behind[1] += usize::from(is_behind && l.max() > 0.0),
                (4, _) => assert_eq!(*l, Vector3::zeros()),
                (_, true) => {
                    behind[0] += 1;
                    assert_eq!(*l, Vector3::zeros(), "{rule:?}, vertex {v}");
                }
                // Few samples, or a tolerance, may see no lobe.
                (_, false) => assert!(l.min() > 0.0 || rule != Rule::Pixels, "{rule:?}, vertex {v}: {l}"),
            }
        }
        assert!(behind[0] > 5 && behind[1] > 3, "{behind:?}");
    }
}

/// Points of a face, corners and rim among them.
fn points(mesh: &Mesh, face: [u32; 3]) -> impl Iterator<Item = Vector3<f64>> {
    let corners = face.map(|v| mesh.positions()[v as usize].cast::<f64>());
    (0..=6)
        .flat_map(move |i| (0..=6 - i).map(move |j| [i, j, 6 - i - j]))
        .map(move |w| (0..3).map(|k| corners[k] * (w[k] as f64 / 6.0)).sum())
}

/// Which vertices belong to a face that is seen from in front somewhere in the picture.
fn in_picture(mesh: &Mesh, camera: &Camera, aspect: f64) -> Vec<bool> {
    let mut seen = vec![false; mesh.positions().len()];
    for &face in mesh.faces() {
        let [a, b, c] = face.map(|v| mesh.positions()[v as usize].cast::<f64>());
        let normal = (b - a).cross(&(c - a));
        let is_inside = |p: Vector3<f64>| camera.project(&p).is_some_and(|[x, y]| x.abs() <= aspect && y.abs() <= 1.0);
        if normal.dot(&(camera.eye() - a)) > 0.0 && points(mesh, face).any(is_inside) {
            face.iter().for_each(|&v| seen[v as usize] = true);
        }
    }
    seen
}

fn cameras(model: &Model) -> Vec<(Camera, f64)> {
    let (eye, centre, size) = (model.camera.eye(), model.mesh.bounds().centre(), model.mesh.bounds().radius());
    let up = Vector3::y();
    let look = |eye: Vector3<f64>, target: Vector3<f64>, fov: f64| Camera::look_at(eye, target, up, fov).unwrap();
    vec![
        (model.camera, 1.5),
        (look(eye, centre, 0.05), 1.0),
        (look(eye, centre, 0.1), 8.0),
        (look(eye, centre + Vector3::new(0.3 * size, 0.0, 0.0), 0.2), 0.2),
        // In the midst of it all, wide; straight down; away from everything.
        (look(centre + Vector3::new(0.0, 0.1 * size, 0.0), eye, 2.4), 2.0),
        (look(centre + up * size, centre, 0.9), 0.7),
        (look(eye, eye * 2.0 - centre, 1.0), 1.0),
    ]
}

#[test]
fn a_picture_has_all_that_is_seen() {
    for procedural in [Procedural::TorusKnotOnFloor, Procedural::Table] {
        let model = procedural.build(1000).unwrap();
        let vertices = model.mesh.positions().len();
        let (transport, materials) = (transport(&model.mesh, 16, 8), mixed(vertices));
        let mut relighter = Relighter::new(&model.mesh, &transport, Settings::default()).unwrap();
        relighter.set_light(&sky(16)).unwrap();
        let (mut all, mut some) = (vec![Vector3::zeros(); vertices], vec![Vector3::repeat(f32::NAN); vertices]);
        let mut left_out = Vec::new();
        for (i, (camera, aspect)) in cameras(&model).into_iter().enumerate() {
            relighter.relight_in_picture(&camera, aspect, &materials, &mut some).unwrap();
            relighter.relight(&View::eye(camera.eye().cast()).unwrap(), &materials, &mut all).unwrap();
            let needed = in_picture(&model.mesh, &camera, aspect);
            let (mut skipped, mut bright) = (0, 0);
            for v in 0..vertices {
                let is_same = some[v] == all[v];
                assert!(
                    is_same || !needed[v],
                    "{}, camera {i}, vertex {v}: {} for {}",
                    procedural.name(),
                    some[v],
                    all[v]
                );
                assert!(is_same || some[v] == Vector3::zeros(), "neither black nor right");
                skipped += usize::from(!is_same);
                bright += usize::from(all[v] != Vector3::zeros());
            }
            left_out.push(skipped as f64 / bright as f64);
        }
        // Diffuse faces that turn away are left out everywhere, nearly all that a small picture does not show, and all
        // behind the camera.
        assert!(left_out.iter().all(|&share| share > 0.0), "{left_out:?}");
        assert!(left_out[1] > 0.9 && left_out[6] == 1.0, "{left_out:?}");
    }
}

#[test]
fn a_picture_of_no_shape_is_refused() {
    let model = Procedural::BasRelief.build(1000).unwrap();
    let vertices = model.mesh.positions().len();
    let transport = transport(&model.mesh, 8, 8);
    let mut relighter = Relighter::new(&model.mesh, &transport, Settings::default()).unwrap();
    let mut out = vec![Vector3::zeros(); vertices];
    for aspect in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let got = relighter.relight_in_picture(&model.camera, aspect, &mixed(vertices), &mut out);
        assert!(matches!(got, Err(Error::OutOfRange { what: "aspect ratio", .. })), "{aspect}: {got:?}");
    }
    let few = mixed(vertices - 1);
    let expected = Err(Error::Length { what: "parts of the vertices", expected: vertices, got: vertices - 1 });
    assert_eq!(relighter.relight_in_picture(&model.camera, 1.0, &few, &mut out), expected);
    assert_eq!(relighter.relight(&view(), &few, &mut out), expected);
    assert_eq!(relighter.frame_stats(&view(), &few).map(|_| ()), expected);
}

#[test]
#[should_panic(expected = "radiance of the vertices")]
fn a_frame_of_another_length_panics() {
    let mesh = soup(2);
    let transport = transport(&mesh, 8, 8);
    let mut relighter = Relighter::new(&mesh, &transport, Settings::default()).unwrap();
    let _ = relighter.relight(&view(), &mixed(6), &mut [Vector3::zeros(); 5]);
}

#[test]
fn counts_are_of_all_blocks() {
    let mesh = soup(40);
    let maps = above(&mesh, 32, patchwork(32, 16, 8));
    let transport = Transport::from_clipped(&maps, &layout(32, 16, ScanOrder::Serpentine)).unwrap();
    let materials = mixed(120);
    // Vertices that are shaded, and blocks of them that are not hidden.
    let shaded: Vec<usize> = (0..120)
        .filter(|v| v % 5 == 0 || v % 5 == 4 || view().wo(&mesh.positions()[*v]).dot(&mesh.normals()[*v].cast()) > 0.0)
        .collect();
    let live = |v: usize| {
        let layout = transport.layout();
        (0..layout.blocks()).filter(|&b| layout.texels(0, b).iter().any(|&t| maps.sees(v, t as usize))).count()
    };
    let counts = |rule: Rule| {
        let mut relighter = Relighter::new(&mesh, &transport, settings(rule)).unwrap();
        relighter.set_light(&sky(32)).unwrap();
        relighter.frame_stats(&view(), &materials).unwrap()
    };
    for rule in rules() {
        let stats = counts(rule);
        let FrameStats { vertices, zero, coefficients, sums, pixels, samples, .. } = stats;
        assert_eq!(vertices, shaded.len());
        assert_eq!(zero + coefficients + sums + pixels, 24 * vertices);
        assert_eq!(samples.iter().sum::<usize>(), 24 * vertices - zero);
        assert_eq!(samples[3], pixels, "{rule:?}");
        assert!((stats.case_percent().iter().sum::<f64>() - 100.0).abs() < 1e-10);
        assert!((stats.samples_percent().iter().sum::<f64>() - 100.0).abs() < 1e-10);
        let share = 100.0 * sums as f64 / (24 * vertices) as f64;
        assert!((stats.case_percent()[2] - share).abs() < 1e-10);
    }
    let stats = counts(Rule::Pixels);
    // Vertices that reflect nothing have no lobe; all others go through every pixel that is not hidden.
    let expected: usize = shaded.iter().filter(|&v| v % 5 != 4).map(|&v| live(v)).sum();
    assert_eq!((stats.pixels, stats.coefficients, stats.sums, stats.samples), (expected, 0, 0, [0, 0, 0, expected]));
    let stats = counts(Rule::default());
    assert!(stats.pixels > 0 && stats.coefficients > 0 && stats.sums > 0 && stats.samples.iter().all(|&n| n > 0));
    // Nothing at all: percentages of nothing are 0.
    assert_eq!((FrameStats::default().case_percent(), FrameStats::default().samples_percent()), ([0.0; 4], [0.0; 4]));
}

#[test]
fn light_view_and_materials_change_from_frame_to_frame() {
    let mesh = soup(20);
    let transport = transport(&mesh, 16, 8);
    for rule in rules() {
        let mut relighter = Relighter::new(&mesh, &transport, settings(rule)).unwrap();
        let mut out = vec![Vector3::zeros(); 60];
        for i in 0..12 {
            let light = noisy(16, i / 2);
            let view = View::towards(Vector3::new(1.0, 0.3 * i as f32, -0.5)).unwrap();
            // A new BRDF at what may be the address of the last.
            let phong = Phong::new([0.5, 0.1 * (i % 3) as f64, 0.3], 3.0 + 20.0 * (i / 3) as f64).unwrap();
            let materials = Materials::uniform(phong);
            relighter.set_light(&light).unwrap();
            relighter.relight(&view, &materials, &mut out).unwrap();
            assert_eq!(
                out,
                frame((&mesh, &transport), settings(rule), &light, &view, &materials),
                "{rule:?}, frame {i}"
            );
            // What is refused leaves the frame as it was.
            let mut bad = light.clone();
            bad.texels_mut()[9].z = f32::NAN;
            assert_eq!(relighter.set_light(&bad), Err(Error::NotFinite { what: "texel of the light", index: 9 }));
            assert!(relighter.set_light(&noisy(8, 1)).is_err());
            let mut again = vec![Vector3::zeros(); 60];
            relighter.relight(&view, &materials, &mut again).unwrap();
            assert_eq!(again, out);
        }
    }
}

#[cfg(feature = "rayon")]
#[test]
fn any_number_of_threads_gives_the_same_bits() {
    let model = Procedural::StackedSpheres.build(1000).unwrap();
    let vertices = model.mesh.positions().len();
    let (transport, materials) = (transport(&model.mesh, 16, 8), mixed(vertices));
    let view = View::eye(model.camera.eye().cast()).unwrap();
    let of = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            rules().map(|rule| frame((&model.mesh, &transport), settings(rule), &sky(16), &view, &materials))
        })
    };
    let one = of(1);
    assert!(of(2) == one && of(5) == one);
    // Made in one pool, used in another.
    let mut relighter = Relighter::new(&model.mesh, &transport, settings(rules()[2])).unwrap();
    relighter.set_light(&sky(16)).unwrap();
    let mut out = vec![Vector3::zeros(); vertices];
    let pool = rayon::ThreadPoolBuilder::new().num_threads(3).build().unwrap();
    pool.install(|| relighter.relight(&view, &materials, &mut out)).unwrap();
    assert_eq!(out, one[2]);
}

/// A byte a change and a vertex of each map that is not hidden, four a batch of maps, which are at most as many; counts
/// and places of the two courses of a block in each group of 256 vertices; three words of bits a vertex.
#[test]
fn bytes_are_of_what_is_held_once_more() {
    let mesh = soup(200);
    let transport = transport(&mesh, 32, 16);
    let relighter = Relighter::new(&mesh, &transport, Settings::default()).unwrap();
    let (coded, groups) = (transport.stats().coded, 3);
    let live = coded.maps - coded.all_zero;
    let least = coded.changes + live + groups * 2 * 24 * 2 + (groups + 1) * 24 + 600 * 24;
    assert!((least..=least + 4 * live).contains(&relighter.bytes()), "{} of {least} and up", relighter.bytes());
}
