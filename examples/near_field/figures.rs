//! Figures 4.7, 4.10 and 4.11 of the thesis.

use std::sync::Arc;
use std::time::Instant;

use haarmonic::affine::{Heuristic, mean_squares_2d};
use haarmonic::backend::near_field::{
    BakeSettings, PlanarLight, Relighter, Route, Settings, TargetSelection, Transport,
};
use haarmonic::haar::{Decomposition, Keep, forward_2d};
use haarmonic::nalgebra::Vector3;
use haarmonic::scene::{Bvh, Comparison, Occluders, Picture, Procedural, ToneMap, View, rel_l2};
use haarmonic::sphere::TopFace;
use serde_json::{Value, json};

use crate::args::Args;
use crate::frames::{bake, bake_settings, bright};
use crate::refine::refine;
use crate::scene::{Scene, TEXTURES, palette, texture};
use crate::support::axis::{Axis, Scale};
use crate::support::plot::{self, Chart, Series};
use crate::support::progress::Bar;
use crate::support::sheet::{PAPER, Panel, Sheet};
use crate::support::timer::Timer;
use crate::support::{self, Failure, table};
use crate::truth;

pub fn run(args: &Args) -> Result<(), Failure> {
    let scene = Scene::new(args)?;
    let mut results = Vec::new();
    faces(args, &scene, &mut results)?;
    errors(args, &scene, &mut results)?;
    rates(args, &mut results)?;
    println!(
        "pictures: near_field_faces.png, near_field_source.png, near_field_target.png in {}",
        args.folder.path.display()
    );
    support::write_report(&args.common, "near_field", json!({ "figures": true }), Value::Array(results))
}

fn relit(transport: &Transport, settings: Settings<'_>, lights: &[PlanarLight]) -> Result<Vec<Vector3<f32>>, Failure> {
    let mut relighter = Relighter::new(transport, settings)?;
    relighter.set_lights(lights)?;
    let mut out = vec![Vector3::zeros(); transport.vertices()];
    relighter.relight(&mut out);
    Ok(out)
}

/// Fig. 4.7: the same scene through faces of four sizes, and the truth of the whole hemisphere.
fn faces(args: &Args, scene: &Scene, results: &mut Vec<Value>) -> Result<(), Failure> {
    let lights = scene.lights_at(0.5)?;
    let truth = truth::of_lamps(scene, &lights, args.truth_samples)?;
    let plan = Picture::new(&scene.mesh, &Bvh::new(&scene.mesh), &scene.camera, [args.size; 2], 3)?;
    let short: Vec<Vector3<f32>> = truth.iter().map(|l| l.cast()).collect();
    let tone = ToneMap::with_white(bright(&short));
    let panel = |caption: Vec<String>, colours: &[Vector3<f32>]| {
        let pixels = plan.shade(colours, |_| Vector3::repeat(0.03)).iter().map(|l| tone.apply(l)).collect();
        Some(Panel { caption, width: args.size, height: args.size, pixels })
    };
    let (mut panels, mut rows) = (vec![], vec![]);
    for size in [2.0, 3.0, 4.0, 10.0] {
        let coarse = BakeSettings { face_size: size, ..bake_settings(args) };
        let fine = BakeSettings { cells: 2 * args.order, samples: 2, tolerance: 0.0, ..coarse };
        let exact = Settings { source_side: args.order, ..Settings::default() };
        let (transport, _) = bake(args, scene, coarse)?;
        let radiance = relit(&transport, exact, &lights)?;
        let same = truth::of_cells(scene, &lights, &coarse, args.order)?;
        let (finer, _) = bake(args, scene, fine)?;
        let finer = relit(&finer, Settings { source_side: 2 * args.order, ..exact }, &lights)?;
        let db =
            |reference: &[Vector3<f64>], test: &[Vector3<f32>]| Comparison::new(reference, test).map(|c| c.psnr_db);
        let (whole, cells, fine_db) = (db(&truth, &radiance)?, db(&same, &radiance)?, db(&truth, &finer)?);
        let face = TopFace::new(size, args.order)?;
        let solid = face.covered_solid_angle() / std::f64::consts::TAU;
        let energy = face.covered_projected_solid_angle() / std::f64::consts::PI;
        rows.push(vec![
            format!("{size}"),
            format!("{solid:.3}"),
            format!("{energy:.3}"),
            format!("{cells:.1}"),
            format!("{whole:.1}"),
            format!("{fine_db:.1}"),
        ]);
        results.push(json!({
            "figure": "4.7", "face": size, "psnr_db": whole, "psnr_same_face_db": cells, "psnr_fine_db": fine_db,
            "vertices": truth.len(),
        }));
        panels.push(panel(vec![format!("face of size {size}"), format!("PSNR {whole:.1} dB")], &radiance));
    }
    panels.push(panel(vec!["ground truth".to_owned(), "of the whole hemisphere".to_owned()], &short));
    args.folder.save("near_field_faces.png", &Sheet::new("Top faces of four sizes (fig. 4.7)", &[panels]))?;
    println!("\nfigure 4.7, everything kept");
    let header = ["face", "of the hemisphere", "of Lambert's", "same face dB", "hemisphere dB", "twice as fine dB"];
    println!("{}", table::format(&header, &rows));
    Ok(())
}

/// Fig. 4.10: error against the wavelets that are kept of the source and of the target, for four textures.
fn errors(args: &Args, scene: &Scene, results: &mut Vec<Value>) -> Result<(), Failure> {
    let (transport, _) = bake(args, scene, BakeSettings { tolerance: 0.0, ..bake_settings(args) })?;
    let shares = [0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.3, 0.5, 0.7, 1.0];
    let lights: Vec<PlanarLight> = TEXTURES
        .iter()
        .map(|name| -> Result<PlanarLight, Failure> {
            let ((width, texels), hung) = (texture(name)?, &scene.lights[0]);
            Ok(PlanarLight::new(hung.centre() + scene.travel * 0.5, hung.size(), width, texels)?)
        })
        .collect::<Result<_, _>>()?;
    let side = args.order;
    let base =
        Settings { source_side: side, route: Route::Couplings, targets: TargetSelection::All, ..Settings::default() };
    let (mut of_source, mut of_target) = (vec![], vec![]);
    let mut rows = vec![];
    for (k, (name, light)) in TEXTURES.iter().zip(&lights).enumerate() {
        let lamp = std::slice::from_ref(light);
        let whole = relit(&transport, Settings { route: Route::Pixels, ..base }, lamp)?;
        // What other lights are like, for the better heuristic.
        let coefs: Vec<Vec<f64>> = lights
            .iter()
            .filter(|other| *other != light)
            .map(|other| {
                let green: Vec<f64> = other.pixels(side)[1].iter().map(|&x| f64::from(x)).collect();
                forward_2d(&green, side, side, Decomposition::Standard)
            })
            .collect::<Result<_, _>>()?;
        let power =
            mean_squares_2d(side, Decomposition::Standard, &coefs.iter().map(Vec::as_slice).collect::<Vec<_>>())?;
        let (mut source, mut constant, mut by_power) = (vec![], vec![], vec![]);
        for share in shares {
            let keep = Keep::Fraction(share);
            let error = |settings: Settings<'_>| -> Result<f64, Failure> {
                Ok(rel_l2(&whole, &relit(&transport, settings, lamp)?)?)
            };
            let e = error(Settings { source_terms: keep, ..base })?;
            source.push([100.0 * share, e]);
            let c = error(Settings { targets: TargetSelection::constant_light(keep), ..base })?;
            constant.push([100.0 * share, c]);
            let better = TargetSelection::Predicted { heuristic: Heuristic::Power(&power), keep, union: 0, samples: 2 };
            let p = error(Settings { targets: better, ..base })?;
            by_power.push([100.0 * share, p]);
            results.push(json!({
                "figure": "4.10", "texture": name, "share_percent": 100.0 * share, "source_rel_l2": e, "target_rel_l2": c,
                "target_by_power_rel_l2": p,
            }));
        }
        let at = |points: &[[f64; 2]], share: f64| {
            points.iter().find(|p| (p[0] - share).abs() < 1e-9).map_or(f64::NAN, |p| p[1])
        };
        rows.push(vec![
            (*name).to_owned(),
            format!("{:.1e}", at(&source, 1.0)),
            format!("{:.1e}", at(&source, 5.0)),
            format!("{:.1e}", at(&constant, 20.0)),
            format!("{:.1e}", at(&constant, 30.0)),
            format!("{:.1e}", at(&by_power, 20.0)),
            format!("{:.1e}", at(&by_power, 30.0)),
        ]);
        of_source.push(Series::new(name, k, source));
        of_target.push(Series::new(&format!("{name}, constant light"), k, constant));
        of_target.push(Series::curve(&format!("{name}, power of others"), k, by_power));
    }
    for (file, title, series) in [
        ("near_field_source.png", "Error against wavelets of the source (fig. 4.10 A)", of_source),
        ("near_field_target.png", "Error against wavelets of the target (fig. 4.10 B)", of_target),
    ] {
        let chart = Chart {
            title: title.to_owned(),
            x: Axis::new("wavelets kept, %", Scale::Log10),
            y: Axis::between("relative L2 error of the radiance", Scale::Log10, 1e-4, 1.0),
            series,
            size: [1000, 640],
        };
        let legend = plot::legend(&chart.series, 2, chart.size[0]);
        args.folder.save(file, &Sheet::grid(&[vec![chart.draw()], vec![legend]], PAPER))?;
    }
    println!("figure 4.10: relative L2 error of the radiance");
    let header =
        ["texture", "source 1 %", "5 %", "target 20 %, constant light", "30 %", "20 %, power of others", "30 %"];
    println!("{}", table::format(&header, &rows));
    Ok(())
}

/// The columns of fig. 4.11: source and target.
const KEPT: [[f64; 2]; 5] = [[0.01, 0.01], [0.01, 0.2], [0.05, 0.4], [0.2, 0.7], [1.0, 1.0]];

/// Fig. 4.11: frames a second of three scenes, five compressions and 1…n threads.
fn rates(args: &Args, results: &mut Vec<Value>) -> Result<(), Failure> {
    let ghz = clock();
    let mut rows = vec![];
    let kinds = [(Procedural::StackedSpheres, false), (Procedural::Table, true), (Procedural::TorusKnotOnFloor, true)];
    for (&count, (kind, is_glossy)) in args.counts.iter().zip(kinds.into_iter().cycle()) {
        let model = refine(&kind.build(count * 85 / 100)?, count)?;
        let (mesh, view) = (&model.mesh, View::eye(model.camera.eye().cast())?);
        let materials = palette(&model, is_glossy)?;
        let bar = Bar::new("bake");
        let settings = BakeSettings { samples: 1, ..bake_settings(args) };
        let transport = Transport::bake(mesh, Arc::new(Occluders::of_mesh(mesh)), &view, &materials, settings, &bar)?;
        let bake_s = bar.finish();
        let bounds = mesh.bounds();
        let centre = bounds.centre();
        let (width, texels) = texture("window")?;
        let size = bounds.size().y;
        let light = PlanarLight::new(centre + Vector3::y() * size, [1.5 * size; 2], width, texels)?;
        let threads: Vec<usize> = (1..=rayon::current_num_threads()).collect();
        let mut frames: Vec<Vec<Vector3<f32>>> = vec![];
        for route in [Route::StoredCouplings, Route::Couplings, Route::Automatic] {
            for &threads in &threads {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build()?;
                let mut row = vec![format!("{count} {}", kind.name()), route.name().to_owned(), threads.to_string()];
                for [source, target] in KEPT {
                    let keep = Settings {
                        source_side: args.order,
                        source_terms: Keep::Fraction(source),
                        targets: if target < 1.0 {
                            TargetSelection::constant_light(Keep::Fraction(target))
                        } else {
                            TargetSelection::All
                        },
                        route,
                        ..Settings::default()
                    };
                    let (ms, out) = pool.install(|| time(&transport, keep, &light, args.frames))?;
                    let rate = count as f64 / ms / 1e3 / threads as f64;
                    row.push(format!("{:.1} ({:.0}k)", 1e3 / ms, 1e3 * rate / ghz));
                    results.push(json!({
                        "figure": "4.11", "scene": kind.name(), "vertices": count, "route": route.name(), "threads": threads,
                        "source": source, "target": target, "relight_ms": ms, "frames_per_second": 1e3 / ms,
                        "vertices_per_second_core_ghz": 1e6 * rate / ghz, "ghz": ghz, "bake_s": bake_s,
                        "transport_bytes": transport.bytes(),
                    }));
                    if route == Route::Automatic && source == 1.0 {
                        frames.push(out);
                    }
                }
                rows.push(row);
            }
        }
        if !frames.windows(2).all(|pair| pair[0] == pair[1]) {
            return Err("frames depend on the number of threads".into());
        }
    }
    println!(
        "figure 4.11: frames a second (thousands of vertices a second, core and GHz, at {ghz:.2} GHz); the same bits for all threads"
    );
    let header = ["scene", "route", "threads", "1 %, 1 %", "1 %, 20 %", "5 %, 40 %", "20 %, 70 %", "all"];
    println!("{}", table::format(&header, &rows));
    Ok(())
}

/// Milliseconds of a frame, the median, the light moving; and the last.
fn time(
    transport: &Transport,
    settings: Settings<'_>,
    light: &PlanarLight,
    frames: usize,
) -> Result<(f64, Vec<Vector3<f32>>), haarmonic::Error> {
    let mut relighter = Relighter::new(transport, settings)?;
    let mut out = vec![Vector3::zeros(); transport.vertices()];
    let mut light = light.clone();
    let start = light.centre();
    let mut timer = Timer::default();
    for frame in 0..=frames {
        light.set_centre(start + Vector3::x() * (0.01 * light.size()[0] * frame as f64))?;
        relighter.set_lights(std::slice::from_ref(&light))?;
        if frame == 0 {
            relighter.relight(&mut out);
        } else {
            timer.time(|| relighter.relight(&mut out));
        }
    }
    Ok((timer.median(), out))
}

/// GHz of a core, from additions that wait for each other: one a cycle.
fn clock() -> f64 {
    const COUNT: u64 = 300_000_000;
    let mut best = f64::INFINITY;
    for _ in 0..3 {
        let (started, mut sum) = (Instant::now(), 1_u64);
        for i in 0..COUNT {
            sum = std::hint::black_box(sum + i);
        }
        best = best.min(started.elapsed().as_secs_f64() / COUNT as f64);
    }
    1e-9 / best
}
